// What a vertex tracks: the composed field, and at a contact its own side of it (prototypes 3). Reads the globals groups,
// nodes, muscles, axes and places. The derivative of the weight w is left out, as in the authors' operators.
override CONTACT_AGREE: f32;
override CONTACT_TURN: f32;
override CONTACT_APART: u32;
override CONTACT_CODE_SHIFT: u32;
override CONTACT_JOINS: bool;

struct OwnSide {
    value: f32,
    gradient: vec3<f32>,
    group: u32,
    contact: f32,
}

// A vertex's own group and the other one that matters to it: the largest, and the one furthest above its limit.
struct Neighbours {
    own: Sample,
    other: GroupSample,
    join: u32,
    pressing: Sample,
    excess: f32,
}

// Whether a group has no field at a point, seen through its own frame.
fn contact_is_beyond(at: u32, p_posed: vec3<f32>) -> bool {
    let bounds = groups[at].bounds;
    let away = p_posed - bounds.xyz;
    return bounds.w >= 0.0 && math_dot(away, away) > bounds.w;
}

// The group of a place; no group past the last.
fn contact_seen(place: u32, end: u32) -> u32 {
    if place < end {
        return places[place].group;
    }
    return FIELD_NO_GROUP;
}

// `first..end` are the places through which the vertex sees groups in a way of its own, ascending by group.
fn contact_neighbours(place: FieldPlace, owner: u32, limit: f32, first: u32, end: u32, p_posed: vec3<f32>) -> Neighbours {
    let none = Sample(0.0, vec3<f32>(0.0));
    var found = Neighbours(none, GroupSample(0.0, vec3<f32>(0.0), FIELD_NO_GROUP), 0u, none, 0.0);
    var next = first;
    var seen = contact_seen(next, end);
    for (var g = 0u; g < place.group_count; g++) {
        var to_rest: mat4x4<f32>;
        var most = limit;
        var join = CONTACT_APART;
        if g == seen {
            to_rest = places[next].to_rest;
            most = places[next].limit;
            join = places[next].join;
            next++;
            seen = contact_seen(next, end);
        } else if contact_is_beyond(place.group + g, p_posed) {
            continue;
        } else {
            to_rest = groups[place.group + g].to_rest;
        }
        if groups[place.group + g].present == 0u {
            continue;
        }
        let sample = field_group(place.group + g, to_rest, place, p_posed);
        if g == owner {
            found.own = sample;
            continue;
        }
        if join != CONTACT_APART && sample.value > found.other.value {
            found.other = GroupSample(sample.value, sample.gradient, g);
            found.join = join;
        }
        if sample.value - most > found.excess {
            found.pressing = sample;
            found.excess = sample.value - most;
        }
    }
    return found;
}

// The field of a vertex's own group and of the one that overlaps it at rest.
fn contact_joined(owner: u32, found: Neighbours) -> GroupSample {
    var largest = GroupSample(found.own.value, found.own.gradient, owner);
    if found.other.value > found.own.value {
        largest = found.other;
    }
    if CONTACT_JOINS && found.join != 0u {
        let own = JointOperatorParams(found.join & ((1u << CONTACT_CODE_SHIFT) - 1u), found.join >> CONTACT_CODE_SHIFT, 0u, 0u);
        let joined = joint_join(found.own, Sample(found.other.value, found.other.gradient), own);
        largest = GroupSample(joined.value, joined.gradient, largest.group);
    }
    return largest;
}

fn contact_own_side(place: FieldPlace, goal: VertexTarget, first: u32, end: u32, p_posed: vec3<f32>) -> OwnSide {
    let found = contact_neighbours(place, goal.owner, goal.limit, first, end, p_posed);
    let own = found.own;
    let largest = contact_joined(goal.owner, found);
    var facing = found.other.gradient;
    if found.excess > 0.0 {
        facing = found.pressing.gradient;
    }
    let product = math_dot(own.gradient, own.gradient) * math_dot(facing, facing);
    if product <= 0.0 {
        return OwnSide(largest.value, largest.gradient, largest.group, 0.0);
    }
    let cosine = math_dot(own.gradient, facing) / sqrt(product);
    let w = math_smoothstep((CONTACT_AGREE - cosine) / CONTACT_TURN);
    var value = (1.0 - w) * largest.value + w * (own.value + goal.lift);
    var gradient = largest.gradient * (1.0 - w) + own.gradient * w;
    var contact = 0.0;
    if found.excess > 0.0 {
        value -= w * found.excess;
        gradient -= facing * w;
        contact = w;
    }
    return OwnSide(value, gradient, largest.group, contact);
}
