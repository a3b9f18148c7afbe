// What holds one muscle: the contacts of its particles. Reads the globals params, links, moved, groups and iterates.

override HOLD_BONES: u32;
override HOLD_MUSCLES: u32;
override HOLD_SKIN: u32;
override HOLD_LEAST_TURN: f32;
override HOLD_LEAST_WAY_SQUARED: f32;

fn hold_bone(bone: TouchBone, bead: Bead) -> vec4<f32> {
    return touch_bone(bone, bead.p, bead.radius, bead.clear, bead.share);
}

// Planes against the bones that the particles are deepest in or nearest to.
fn hold_bones(work: Work, start: Pair) -> Pair {
    var pair = start;
    var first = touch_none();
    var second = touch_none();
    for (var k = work.body.bones_begin; k < work.body.peers_begin; k++) {
        let bone = touch_bone_of(work.place, links[k]);
        let found_0 = hold_bone(bone, pair.first);
        let found_1 = hold_bone(bone, pair.second);
        if found_0.w < first.w {
            first = found_0;
        }
        if found_1.w < second.w {
            second = found_1;
        }
    }
    pair.first.bone = touch_plane(first, pair.first.p);
    pair.second.bone = touch_plane(second, pair.second.p);
    return pair;
}

// A contact of each of two particles.
struct HoldSkins {
    first: vec4<f32>,
    second: vec4<f32>,
}

fn hold_within(work: Work, deepest: vec4<f32>, bead: Bead) -> vec4<f32> {
    if bead.clear < 1.0 || work.body.skins_begin == work.body.links_end {
        return touch_none();
    }
    let origin = iterates[work.read + 2u].xyz;
    let insertion = iterates[work.read + 2u + 2u * work.body.segments].xyz;
    return touch_skin(deepest, bead.p, origin * (1.0 - bead.share) + insertion * bead.share);
}

fn hold_skins(work: Work, pair: Pair) -> HoldSkins {
    var first = touch_no_skin();
    var second = touch_no_skin();
    for (var k = work.body.skins_begin; k < work.body.links_end; k++) {
        let grid = groups[work.place.group + links[k].index].grid;
        let to_rest = moved[work.place.joint + grid.joint].to_rest;
        first = touch_deeper(first, grid, to_rest, pair.first.p);
        second = touch_deeper(second, grid, to_rest, pair.second.p);
    }
    return HoldSkins(hold_within(work, first, pair.first), hold_within(work, second, pair.second));
}

// Planes of the particles of a pair that begins at point i; none for those that move with the bones.
fn hold_planes(work: Work, i: u32, start: Pair) -> Pair {
    var pair = start;
    if (work.kinds & HOLD_MUSCLES) != 0u {
        pair = peer_hold(work, i, pair);
    }
    if (work.kinds & HOLD_BONES) != 0u {
        pair = hold_bones(work, pair);
    }
    if (work.kinds & HOLD_SKIN) != 0u {
        let skins = hold_skins(work, pair);
        pair.first.skin = touch_plane(skins.first, pair.first.p);
        pair.second.skin = touch_plane(skins.second, pair.second.p);
    }
    return Pair(chain_freed(pair.first), chain_freed(pair.second));
}

fn hold_push_peers(start: Bead) -> Bead {
    var bead = start;
    let first = bead.peer_0;
    bead = chain_push(bead, first.xyz, first.w - math_dot(first.xyz, bead.p), vec4<f32>(1.0, 0.0, 0.0, 0.0));
    let second = bead.peer_1;
    return chain_push(bead, second.xyz, second.w - math_dot(second.xyz, bead.p), vec4<f32>(0.0, 1.0, 0.0, 0.0));
}

fn hold_push_bone(found: vec4<f32>, bead: Bead) -> Bead {
    return chain_push(bead, found.xyz, -found.w, vec4<f32>(0.0, 0.0, 1.0, 0.0));
}

// Along a bone that the particle has just left.
fn hold_push_skin(found: vec4<f32>, bone: vec3<f32>, bead: Bead) -> Bead {
    let facing = min(math_dot(found.xyz, bone), 0.0);
    let way = (found.xyz - bone * facing) * (1.0 / max(1.0 - facing * facing, HOLD_LEAST_TURN));
    return chain_push(bead, way, -found.w, vec4<f32>(0.0, 0.0, 0.0, 1.0));
}

// One contact pass: the neighbours as found before, every bone and the skin as they are.
fn hold_pass(work: Work, start: Pair) -> Pair {
    var pair = Pair(hold_push_peers(start.first), hold_push_peers(start.second));
    var touched_0 = vec3<f32>(0.0);
    var touched_1 = touched_0;
    if (work.kinds & HOLD_BONES) != 0u {
        for (var k = work.body.bones_begin; k < work.body.peers_begin; k++) {
            let bone = touch_bone_of(work.place, links[k]);
            let found_0 = hold_bone(bone, pair.first);
            let found_1 = hold_bone(bone, pair.second);
            touched_0 = select(touched_0, found_0.xyz, found_0.w < 0.0);
            touched_1 = select(touched_1, found_1.xyz, found_1.w < 0.0);
            pair.first = hold_push_bone(found_0, pair.first);
            pair.second = hold_push_bone(found_1, pair.second);
        }
    }
    if (work.kinds & HOLD_SKIN) != 0u {
        let skins = hold_skins(work, pair);
        pair.first = hold_push_skin(skins.first, touched_0, pair.first);
        pair.second = hold_push_skin(skins.second, touched_1, pair.second);
    }
    return pair;
}

fn hold_rested(before: Bead, after: Bead) -> bool {
    let way = after.p - before.p;
    return math_dot(way, way) <= HOLD_LEAST_WAY_SQUARED;
}

// The final contact passes; what one of them has hardly moved, the next one would not move either.
fn hold_settle(work: Work, start: Pair) -> Pair {
    var pair = start;
    var rested_0 = false;
    var rested_1 = false;
    for (var k = 0u; k < params.final_passes && !(rested_0 && rested_1); k++) {
        let next = hold_pass(work, pair);
        let rests_0 = hold_rested(pair.first, next.first);
        let rests_1 = hold_rested(pair.second, next.second);
        if !rested_0 {
            pair.first = next.first;
        }
        if !rested_1 {
            pair.second = next.second;
        }
        rested_0 = rested_0 || rests_0;
        rested_1 = rested_1 || rests_1;
    }
    return pair;
}
