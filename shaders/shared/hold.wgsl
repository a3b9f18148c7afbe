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

// This muscle's share of the gap or the overlap with another one.
fn hold_shared(work: Work, contact: vec4<f32>, index: u32) -> vec4<f32> {
    if contact.w == TOUCH_NOTHING {
        return contact;
    }
    let own = work.body.insertion.w * f32(bodies[index].segments);
    let others = bodies[index].insertion.w * f32(work.body.segments);
    return vec4<f32>(contact.xyz, contact.w * (others / (own + others)));
}

// Planes against the two muscles that a particle is deepest in or nearest to, in the order of the links.
fn hold_peers(work: Work, held: ptr<function, Held>, p: vec3<f32>) {
    if (*held).clear < 1.0 || (work.kinds & HOLD_MUSCLES) == 0u {
        return;
    }
    var first = touch_none();
    var second = touch_none();
    var first_link = 0u;
    var second_link = 0u;
    for (var k = work.body.peers_begin; k < work.body.skins_begin; k++) {
        let index = links[k].index;
        let run = dynamics_run(work.place.instance, index, bodies[index].first_point, params.from_half);
        if any(p + (*held).radius < iterates[run].xyz) || any(p - (*held).radius > iterates[run + 1u].xyz) {
            continue;
        }
        let found = touch_axis(run + 2u, bodies[index].segments, p, (*held).radius);
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
    first = hold_shared(work, first, links[first_link].index);
    second = hold_shared(work, second, links[second_link].index);
    let swapped = second_link < first_link && second.w < TOUCH_NOTHING;
    (*held).planes[0] = touch_plane(select(first, second, swapped), p);
    (*held).planes[1] = touch_plane(select(second, first, swapped), p);
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
    hold_peers(work, held, p);
    (*held).planes[2] = touch_plane(hold_bone(work, *held, p), p);
    (*held).planes[3] = touch_plane(hold_skin(work, *held, p), p);
}

// One contact pass: the neighbour as found before, every bone and the skin as they are.
fn hold_settle(work: Work, held: ptr<function, Held>, i: u32) {
    for (var kind = 0u; kind < 2u; kind++) {
        let plane = (*held).planes[kind];
        chain_push(held, i, kind, plane.xyz, plane.w - math_dot(plane.xyz, at[i].xyz));
    }
    if (work.kinds & HOLD_BONES) != 0u {
        for (var k = work.body.bones_begin; k < work.body.peers_begin; k++) {
            let found = touch_bone(work.place, links[k], at[i].xyz, (*held).radius, (*held).clear, (*held).share);
            chain_push(held, i, 2u, found.xyz, -found.w);
        }
    }
    let found = hold_skin(work, *held, at[i].xyz);
    chain_push(held, i, 3u, found.xyz, -found.w);
}
