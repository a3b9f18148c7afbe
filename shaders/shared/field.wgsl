// Fields: cached group field, detail operator, composition. Reads the globals groups,
// nodes, muscles and axes.

// Where one instance stands in the globals.
struct FieldPlace {
    group: u32,
    group_count: u32,
    muscle: u32,
    point: u32,
}

struct GroupSample {
    value: f32,
    gradient: vec3<f32>,
    group: u32,
}

override FIELD_NO_GROUP: u32;
override FIELD_SATURATION: f32;
override FIELD_HEADROOM: f32;
override FIELD_FILLET: f32;

// Detail operator D(limb, muscle): value, derivative by limb, derivative by muscle (background 3.4).
fn field_detail(limb: f32, muscle: f32) -> vec3<f32> {
    var q = muscle;
    var slope = 1.0;
    if muscle > FIELD_SATURATION {
        let y = 1.0 - min(muscle - FIELD_SATURATION, 1.0 - FIELD_SATURATION) / (1.0 - FIELD_SATURATION);
        let y2 = y * y;
        let y4 = y2 * y2;
        q = FIELD_SATURATION + FIELD_HEADROOM * (1.0 - y4 * y4);
        slope = y4 * y2 * y;
    }
    if q <= FIELD_FILLET * limb {
        return vec3<f32>(limb, 1.0, 0.0);
    }
    let s = sqrt(q * q + (1.0 - 2.0 * FIELD_FILLET) * limb * limb);
    let scale = 1.0 / (1.0 - 2.0 * FIELD_FILLET);
    let value = ((1.0 - FIELD_FILLET) * s - FIELD_FILLET * q) * scale;
    return vec3<f32>(value, (1.0 - FIELD_FILLET) * limb / s, ((1.0 - FIELD_FILLET) * q / s - FIELD_FILLET) * scale * slope);
}

// Raw distance (w) and its gradient (xyz) of a group's grid at grid coordinates u inside it; the caller checks bounds.
fn field_grid(grid: GroupGrid, u: vec3<f32>) -> vec4<f32> {
    let x = min(u32(u.x), grid.size_x - 2u);
    let y = min(u32(u.y), grid.size_y - 2u);
    let z = min(u32(u.z), grid.size_z - 2u);
    let t = u - vec3<f32>(f32(x), f32(y), f32(z));
    let row = grid.size_x;
    let slab = grid.size_x * grid.size_y;
    let at = grid.offset + x + row * y + slab * z;
    let n00 = nodes[at] + (nodes[at + 1u] - nodes[at]) * t.x;
    let n10 = nodes[at + row] + (nodes[at + row + 1u] - nodes[at + row]) * t.x;
    let n01 = nodes[at + slab] + (nodes[at + slab + 1u] - nodes[at + slab]) * t.x;
    let n11 = nodes[at + slab + row] + (nodes[at + slab + row + 1u] - nodes[at + slab + row]) * t.x;
    let n0 = n00 + (n10 - n00) * t.y;
    let n1 = n01 + (n11 - n01) * t.y;
    return n0 + (n1 - n0) * t.z;
}

// The field of one group at a posed point, in posed scene space.
fn field_group(frame: GroupFrame, place: FieldPlace, p_posed: vec3<f32>) -> Sample {
    let p_rest = math_transform_point(frame.to_rest, p_posed);
    var limb = Sample(0.0, vec3<f32>(0.0));
    let u = math_transform_point(frame.grid.rest_to_grid, p_rest);
    let last = vec3<f32>(f32(frame.grid.size_x - 1u), f32(frame.grid.size_y - 1u), f32(frame.grid.size_z - 1u));
    if all(u >= vec3<f32>(0.0)) && all(u <= last) {
        let raw = field_grid(frame.grid, u);
        let t = field_transfer(raw.w, frame.grid.support_radius);
        limb = Sample(t.x, raw.xyz * t.y);
    }
    var best = Sample(0.0, vec3<f32>(0.0));
    for (var m = frame.grid.muscle_begin; m < frame.grid.muscle_end; m++) {
        let muscle = muscles[place.muscle + m];
        if any(p_rest < muscle.lowest.xyz) || any(p_rest > muscle.highest.xyz) {
            continue;
        }
        let sample = muscle_evaluate(muscle, place.point, p_rest);
        if sample.value > best.value {
            best = sample;
        }
    }
    if best.value > 0.0 {
        let d = field_detail(limb.value, best.value);
        limb = Sample(d.x, limb.gradient * d.y + best.gradient * d.z);
    }
    return Sample(limb.value, math_transpose_vector(frame.to_rest, limb.gradient));
}

// The composed field: the largest of one instance's groups.
fn field_composed(place: FieldPlace, p_posed: vec3<f32>) -> GroupSample {
    var result = GroupSample(0.0, vec3<f32>(0.0), FIELD_NO_GROUP);
    for (var g = 0u; g < place.group_count; g++) {
        if groups[place.group + g].present == 0u {
            continue;
        }
        let sample = field_group(groups[place.group + g], place, p_posed);
        if sample.value > result.value {
            result = GroupSample(sample.value, sample.gradient, g);
        }
    }
    return result;
}
