// What holds a muscle against its neighbours. Reads the globals params, bodies, links, moved, particles and iterates.

override PEER_FACING: f32;
override PEER_TURN: f32;

// Between posed scene space and that at rest of the joint that drives the muscle's field.
struct PeerSpace {
    to_rest: mat4x4<f32>,
    to_posed: mat4x4<f32>,
}

// The plane of a contact with another muscle, where the two share the gap or the overlap, with play: where the particle
// kept one before, it stays as far as it is right to within the play.
fn peer_follow(work: Work, space: PeerSpace, particle: Particle, contact: vec4<f32>, index: u32, p: vec3<f32>) -> vec4<f32> {
    if contact.w == TOUCH_NOTHING {
        return vec4<f32>(0.0);
    }
    let own = work.body.insertion.w * f32(bodies[index].segments);
    let others = bodies[index].insertion.w * f32(work.body.segments);
    let shared_contact = vec4<f32>(contact.xyz, contact.w * (others / (own + others)));
    let name = f32(index) + 1.0;
    if params.play <= 0.0 || (particle.traits.z != name && particle.traits.w != name) {
        return touch_plane(shared_contact, p);
    }
    let kept = select(particle.peer_1, particle.peer_0, particle.traits.z == name);
    let before = touch_posed(kept, space.to_rest);
    let facing = math_dot(before.xyz, shared_contact.xyz);
    if facing <= 0.0 {
        return touch_plane(shared_contact, p);
    }
    let value = math_dot(before.xyz, p) - before.w;
    let distance = clamp(value, shared_contact.w - params.play, shared_contact.w + params.play);
    let turned = before.xyz * (1.0 - PEER_TURN) + shared_contact.xyz * PEER_TURN;
    let unit = turned * (1.0 / max(sqrt(math_dot(turned, turned)), 1e-9));
    return touch_plane(vec4<f32>(select(unit, before.xyz, facing > PEER_FACING), distance), p);
}

// The two muscles that a particle is deepest in or nearest to.
struct Peers {
    first: vec4<f32>,
    second: vec4<f32>,
    first_link: u32,
    second_link: u32,
}

fn peer_found(peers: Peers, found: vec4<f32>, link: u32) -> Peers {
    if found.w < peers.first.w {
        return Peers(found, peers.first, link, peers.first_link);
    }
    if found.w < peers.second.w {
        return Peers(peers.first, found, peers.first_link, link);
    }
    return peers;
}

// Whether neighbours leave a particle alone: tendons of one bone meet at it, and the bones move the ends.
fn peer_free(bead: Bead) -> bool {
    return bead.clear < 1.0 || bead.mass == 0.0;
}

// Planes against them, in the order of the links.
fn peer_planes(work: Work, space: PeerSpace, i: u32, found: Peers, start: Bead) -> Bead {
    var bead = start;
    if peer_free(bead) {
        return bead;
    }
    var peers = found;
    if peers.second_link < peers.first_link && peers.second.w < TOUCH_NOTHING {
        peers = Peers(found.second, found.first, found.second_link, found.first_link);
    }
    let particle = particles[work.first + i];
    let first = links[peers.first_link].index;
    let second = links[peers.second_link].index;
    bead.peer_0 = peer_follow(work, space, particle, peers.first, first, bead.p);
    bead.peer_1 = peer_follow(work, space, particle, peers.second, second, bead.p);
    particles[work.first + i].traits.z = select(f32(first) + 1.0, 0.0, peers.first.w == TOUCH_NOTHING);
    particles[work.first + i].traits.w = select(f32(second) + 1.0, 0.0, peers.second.w == TOUCH_NOTHING);
    particles[work.first + i].peer_0 = touch_rest(bead.peer_0, space.to_posed);
    particles[work.first + i].peer_1 = touch_rest(bead.peer_1, space.to_posed);
    return bead;
}

fn peer_apart(bead: Bead, lowest: vec3<f32>, highest: vec3<f32>) -> bool {
    return peer_free(bead) || any(bead.p + bead.radius < lowest) || any(bead.p - bead.radius > highest);
}

fn peer_hold(work: Work, i: u32, start: Pair) -> Pair {
    var pair = start;
    var found_0 = Peers(touch_none(), touch_none(), 0u, 0u);
    var found_1 = found_0;
    for (var k = work.body.peers_begin; k < work.body.skins_begin; k++) {
        let index = links[k].index;
        let run = dynamics_run(work.place.instance, index, bodies[index].first_point, params.from_half);
        let apart_0 = peer_apart(pair.first, iterates[run].xyz, iterates[run + 1u].xyz);
        let apart_1 = peer_apart(pair.second, iterates[run].xyz, iterates[run + 1u].xyz);
        if apart_0 && apart_1 {
            continue;
        }
        var nearest_0 = PeerNearest(0u, TOUCH_NOTHING, 0.0);
        var nearest_1 = nearest_0;
        var from_point = iterates[run + 2u].xyz;
        for (var j = 0u; j < bodies[index].segments; j++) {
            let to_point = iterates[run + 4u + 2u * j].xyz;
            nearest_0 = peer_nearer(nearest_0, j, from_point, to_point - from_point, pair.first.p);
            nearest_1 = peer_nearer(nearest_1, j, from_point, to_point - from_point, pair.second.p);
            from_point = to_point;
        }
        if !apart_0 {
            found_0 = peer_found(found_0, peer_axis(run + 2u, nearest_0, pair.first.p, pair.first.radius), k);
        }
        if !apart_1 {
            found_1 = peer_found(found_1, peer_axis(run + 2u, nearest_1, pair.second.p, pair.second.radius), k);
        }
    }
    let driver = work.place.joint + work.body.driver;
    let space = PeerSpace(moved[driver].to_rest, moved[driver].matrix);
    pair.first = peer_planes(work, space, i, found_0, pair.first);
    pair.second = peer_planes(work, space, i + 1u, found_1, pair.second);
    return pair;
}
