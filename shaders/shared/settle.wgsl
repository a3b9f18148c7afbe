// The contact passes that end a substep. Reads the globals params, links, moved, groups and iterates.

override SETTLE_LEAST_TURN: f32;
override SETTLE_LEAST_WAY_SQUARED: f32;

fn settle_push_peers(start: Bead) -> Bead {
    var bead = start;
    let first = bead.peer_0;
    bead = chain_push(bead, first.xyz, first.w - math_dot(first.xyz, bead.p), vec4<f32>(1.0, 0.0, 0.0, 0.0));
    let second = bead.peer_1;
    return chain_push(bead, second.xyz, second.w - math_dot(second.xyz, bead.p), vec4<f32>(0.0, 1.0, 0.0, 0.0));
}

fn settle_push_bone(found: vec4<f32>, bead: Bead) -> Bead {
    return chain_push(bead, found.xyz, -found.w, vec4<f32>(0.0, 0.0, 1.0, 0.0));
}

// Along a bone that the particle has just left.
fn settle_push_skin(found: vec4<f32>, bone: vec3<f32>, bead: Bead) -> Bead {
    let facing = min(math_dot(found.xyz, bone), 0.0);
    let way = (found.xyz - bone * facing) * (1.0 / max(1.0 - facing * facing, SETTLE_LEAST_TURN));
    return chain_push(bead, way, -found.w, vec4<f32>(0.0, 0.0, 0.0, 1.0));
}

// One contact pass: the neighbours as found before, every bone and the skin as they are.
fn settle_pass(work: Work, start: Pair) -> Pair {
    var pair = Pair(settle_push_peers(start.first), settle_push_peers(start.second));
    var touched_0 = vec3<f32>(0.0);
    var touched_1 = touched_0;
    if (work.kinds & HOLD_BONES) != 0u {
        var k = work.body.bones_begin;
        loop {
            let bone = touch_bone_of(work.place, links[k]);
            let found_0 = hold_bone(bone, pair.first);
            let found_1 = hold_bone(bone, pair.second);
            touched_0 = select(touched_0, found_0.xyz, found_0.w < 0.0);
            touched_1 = select(touched_1, found_1.xyz, found_1.w < 0.0);
            pair.first = settle_push_bone(found_0, pair.first);
            pair.second = settle_push_bone(found_1, pair.second);
            k++;
            if k >= work.body.peers_begin {
                break;
            }
        }
    }
    if (work.kinds & HOLD_SKIN) != 0u {
        let skins = hold_skins(work, pair);
        pair.first = settle_push_skin(skins.first, touched_0, pair.first);
        pair.second = settle_push_skin(skins.second, touched_1, pair.second);
    }
    return pair;
}

fn settle_rested(before: Bead, after: Bead) -> bool {
    let way = after.p - before.p;
    return math_dot(way, way) <= SETTLE_LEAST_WAY_SQUARED;
}

// The final contact passes, one at least; what one of them has hardly moved, the next one would not move either.
fn settle(work: Work, start: Pair) -> Pair {
    var pair = start;
    var rested_0 = false;
    var rested_1 = false;
    var k = 0u;
    loop {
        let next = settle_pass(work, pair);
        let rests_0 = settle_rested(pair.first, next.first);
        let rests_1 = settle_rested(pair.second, next.second);
        if !rested_0 {
            pair.first = next.first;
        }
        if !rested_1 {
            pair.second = next.second;
        }
        rested_0 = rested_0 || rests_0;
        rested_1 = rested_1 || rests_1;
        k++;
        if k >= params.final_passes || (rested_0 && rested_1) {
            break;
        }
    }
    return pair;
}
