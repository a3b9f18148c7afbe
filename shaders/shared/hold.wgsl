// What holds one muscle: the contacts of its particles. Reads the globals params, links, moved, groups and iterates.
// Loops over contacts are left at their bottom: a software adapter runs the body of one that is left at its top once more.

override HOLD_BONES: u32;
override HOLD_MUSCLES: u32;
override HOLD_SKIN: u32;
override HOLD_PEERS: bool;

// The kinds of contact of which a muscle has any.
fn hold_kinds(body: MuscleBody) -> u32 {
    return select(0u, HOLD_BONES, body.bones_begin < body.peers_begin)
        | select(0u, HOLD_MUSCLES, body.peers_begin < body.skins_begin)
        | select(0u, HOLD_SKIN, body.skins_begin < body.links_end);
}

fn hold_bone(bone: TouchBone, bead: Bead) -> vec4<f32> {
    return touch_bone(bone, bead.p, bead.radius, bead.clear, bead.share);
}

// Planes against the bones that the particles are deepest in or nearest to.
fn hold_bones(work: Work, start: Pair) -> Pair {
    var pair = start;
    var first = touch_none();
    var second = touch_none();
    var k = work.body.bones_begin;
    loop {
        let bone = touch_bone_of(work.place, links[k]);
        let found_0 = hold_bone(bone, pair.first);
        let found_1 = hold_bone(bone, pair.second);
        if found_0.w < first.w {
            first = found_0;
        }
        if found_1.w < second.w {
            second = found_1;
        }
        k++;
        if k >= work.body.peers_begin {
            break;
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
    if bead.clear < 1.0 {
        return touch_none();
    }
    let origin = iterates[work.read + 2u].xyz;
    let insertion = iterates[work.read + 2u + 2u * work.body.segments].xyz;
    return touch_skin(deepest, bead.p, origin * (1.0 - bead.share) + insertion * bead.share);
}

fn hold_skins(work: Work, pair: Pair) -> HoldSkins {
    var first = touch_no_skin();
    var second = touch_no_skin();
    var k = work.body.skins_begin;
    loop {
        let grid = groups[work.place.group + links[k].index].grid;
        let to_rest = moved[work.place.joint + links[k].joint].to_rest;
        first = touch_deeper(first, grid, to_rest, pair.first.p);
        second = touch_deeper(second, grid, to_rest, pair.second.p);
        k++;
        if k >= work.body.links_end {
            break;
        }
    }
    return HoldSkins(hold_within(work, first, pair.first), hold_within(work, second, pair.second));
}

// Planes of the particles of a pair that begins at point i; none for those that move with the bones.
fn hold_planes(work: Work, i: u32, start: Pair) -> Pair {
    var pair = start;
    if HOLD_PEERS && (work.kinds & HOLD_MUSCLES) != 0u {
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
