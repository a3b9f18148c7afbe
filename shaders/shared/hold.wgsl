// What holds one muscle: the contacts of its particles. Reads the globals params, bodies, links and iterates.

override HOLD_BONES: u32;
override HOLD_MUSCLES: u32;
override HOLD_SKIN: u32;
override HOLD_FACING: f32;
override HOLD_TURN: f32;

// The muscle at work, of one thread's point of view.
struct Work {
    place: TouchPlace,
    body: MuscleBody,
    read: u32,
    first: u32,
    kinds: u32,
}

// The plane of a contact with another muscle, where the two share the gap or the overlap, with play: where the particle
// kept one before, it stays as far as it is right to within the play.
fn hold_follow(work: Work, particle: Particle, contact: vec4<f32>, index: u32, p: vec3<f32>) -> vec4<f32> {
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
    let before = touch_posed(kept, work.place.joint + work.body.driver);
    let facing = math_dot(before.xyz, shared_contact.xyz);
    if facing <= 0.0 {
        return touch_plane(shared_contact, p);
    }
    let value = math_dot(before.xyz, p) - before.w;
    let distance = clamp(value, shared_contact.w - params.play, shared_contact.w + params.play);
    let turned = before.xyz * (1.0 - HOLD_TURN) + shared_contact.xyz * HOLD_TURN;
    let unit = turned * (1.0 / max(sqrt(math_dot(turned, turned)), 1e-9));
    return touch_plane(vec4<f32>(select(unit, before.xyz, facing > HOLD_FACING), distance), p);
}

// Planes against the two muscles that a particle is deepest in or nearest to, in the order of the links.
fn hold_peers(work: Work, i: u32, p: vec3<f32>) {
    if held[i].clear < 1.0 || (work.kinds & HOLD_MUSCLES) == 0u {
        return;
    }
    var first = touch_none();
    var second = touch_none();
    var first_link = 0u;
    var second_link = 0u;
    for (var k = work.body.peers_begin; k < work.body.skins_begin; k++) {
        let index = links[k].index;
        let run = dynamics_run(work.place.instance, index, bodies[index].first_point, params.from_half);
        if any(p + held[i].radius < iterates[run].xyz) || any(p - held[i].radius > iterates[run + 1u].xyz) {
            continue;
        }
        let found = touch_axis(run + 2u, bodies[index].segments, p, held[i].radius);
        if found.w < first.w {
            second = first;
            second_link = first_link;
            first = found;
            first_link = k;
        } else if found.w < second.w {
            second = found;
            second_link = k;
        }
    }
    if second_link < first_link && second.w < TOUCH_NOTHING {
        let swap = first;
        let swap_link = first_link;
        first = second;
        first_link = second_link;
        second = swap;
        second_link = swap_link;
    }
    let particle = particles[work.first + i];
    let planes = array<vec4<f32>, 2>(
        hold_follow(work, particle, first, links[first_link].index, p),
        hold_follow(work, particle, second, links[second_link].index, p),
    );
    let driver = work.place.joint + work.body.driver;
    particles[work.first + i].traits.z = select(f32(links[first_link].index) + 1.0, 0.0, first.w == TOUCH_NOTHING);
    particles[work.first + i].traits.w = select(f32(links[second_link].index) + 1.0, 0.0, second.w == TOUCH_NOTHING);
    particles[work.first + i].peer_0 = touch_rest(planes[0], driver);
    particles[work.first + i].peer_1 = touch_rest(planes[1], driver);
    held[i].planes[0] = planes[0];
    held[i].planes[1] = planes[1];
}

fn hold_bone(work: Work, i: u32, p: vec3<f32>) -> vec4<f32> {
    var deepest = touch_none();
    if (work.kinds & HOLD_BONES) == 0u {
        return deepest;
    }
    for (var k = work.body.bones_begin; k < work.body.peers_begin; k++) {
        let found = touch_bone(work.place, links[k], p, held[i].radius, held[i].clear, held[i].share);
        if found.w < deepest.w {
            deepest = found;
        }
    }
    return deepest;
}

fn hold_skin(work: Work, i: u32, p: vec3<f32>) -> vec4<f32> {
    if held[i].clear < 1.0 || (work.kinds & HOLD_SKIN) == 0u || work.body.skins_begin == work.body.links_end {
        return touch_none();
    }
    let refuge = at[0].xyz * (1.0 - held[i].share) + at[work.body.segments].xyz * held[i].share;
    return touch_skin(work.place, work.body.skins_begin, work.body.links_end, p, refuge);
}

fn hold_planes(work: Work, i: u32) {
    if i == 0u || i >= work.body.segments {
        return;
    }
    let p = at[i].xyz;
    hold_peers(work, i, p);
    held[i].planes[2] = touch_plane(hold_bone(work, i, p), p);
    held[i].planes[3] = touch_plane(hold_skin(work, i, p), p);
}

// One contact pass: the neighbour as found before, every bone and the skin as they are.
fn hold_settle(work: Work, i: u32) {
    for (var kind = 0u; kind < 2u; kind++) {
        let plane = held[i].planes[kind];
        chain_push(i, kind, plane.xyz, plane.w - math_dot(plane.xyz, at[i].xyz));
    }
    if (work.kinds & HOLD_BONES) != 0u {
        for (var k = work.body.bones_begin; k < work.body.peers_begin; k++) {
            let found = touch_bone(work.place, links[k], at[i].xyz, held[i].radius, held[i].clear, held[i].share);
            chain_push(i, 2u, found.xyz, -found.w);
        }
    }
    let found = hold_skin(work, i, at[i].xyz);
    chain_push(i, 3u, found.xyz, -found.w);
}
