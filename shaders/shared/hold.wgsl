// What holds one muscle: the contacts of its particles. Reads the globals params, bodies, links and iterates.

override HOLD_BONES: u32;
override HOLD_MUSCLES: u32;
override HOLD_SKIN: u32;

// The muscle at work, of one thread's point of view.
struct Work {
    place: TouchPlace,
    body: MuscleBody,
    read: u32,
    first: u32,
    kinds: u32,
}

// The muscle that a particle is deepest in, to be left by this one's share of the way.
fn hold_peer(work: Work, held: Held, p: vec3<f32>) -> vec4<f32> {
    var deepest = touch_none();
    if held.clear < 1.0 || (work.kinds & HOLD_MUSCLES) == 0u {
        return deepest;
    }
    var other = 0u;
    for (var k = work.body.peers_begin; k < work.body.skins_begin; k++) {
        let index = links[k].index;
        let first = dynamics_run(work.place.instance, index, bodies[index].first_point, params.from_half);
        if any(p + held.radius < iterates[first].xyz) || any(p - held.radius > iterates[first + 1u].xyz) {
            continue;
        }
        let found = touch_axis(first + 2u, bodies[index].segments, p, held.radius);
        if found.w < deepest.w {
            deepest = found;
            other = index;
        }
    }
    if deepest.w < 0.0 {
        let own = work.body.insertion.w * f32(bodies[other].segments);
        let others = bodies[other].insertion.w * f32(work.body.segments);
        deepest.w *= others / (own + others);
    }
    return deepest;
}

fn hold_bone(work: Work, held: Held, p: vec3<f32>) -> vec4<f32> {
    var deepest = touch_none();
    if (work.kinds & HOLD_BONES) == 0u {
        return deepest;
    }
    for (var k = work.body.bones_begin; k < work.body.peers_begin; k++) {
        let found = touch_bone(work.place, links[k], p, held.radius, held.clear, held.share);
        if found.w < deepest.w {
            deepest = found;
        }
    }
    return deepest;
}

fn hold_skin(work: Work, held: Held, p: vec3<f32>) -> vec4<f32> {
    if held.clear < 1.0 || (work.kinds & HOLD_SKIN) == 0u || work.body.skins_begin == work.body.links_end {
        return touch_none();
    }
    let refuge = at[0].xyz * (1.0 - held.share) + at[work.body.segments].xyz * held.share;
    return touch_skin(work.place, work.body.skins_begin, work.body.links_end, p, refuge);
}

fn hold_planes(work: Work, held: ptr<function, Held>, i: u32) {
    if i == 0u || i >= work.body.segments {
        return;
    }
    let p = at[i].xyz;
    (*held).planes[0] = touch_plane(hold_peer(work, *held, p), p);
    (*held).planes[1] = touch_plane(hold_bone(work, *held, p), p);
    (*held).planes[2] = touch_plane(hold_skin(work, *held, p), p);
}

// One contact pass: the neighbour as found before, every bone and the skin as they are.
fn hold_settle(work: Work, held: ptr<function, Held>, i: u32) {
    let plane = (*held).planes[0];
    chain_push(held, i, 0u, plane.xyz, plane.w - math_dot(plane.xyz, at[i].xyz));
    if (work.kinds & HOLD_BONES) != 0u {
        for (var k = work.body.bones_begin; k < work.body.peers_begin; k++) {
            let found = touch_bone(work.place, links[k], at[i].xyz, (*held).radius, (*held).clear, (*held).share);
            chain_push(held, i, 1u, found.xyz, -found.w);
        }
    }
    let found = hold_skin(work, *held, at[i].xyz);
    chain_push(held, i, 2u, found.xyz, -found.w);
}
