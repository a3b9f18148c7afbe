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

// The field of one group at a posed point, in posed scene space; `at` is its place in the globals.
fn field_group(at: u32, to_rest: mat4x4<f32>, place: FieldPlace, p_posed: vec3<f32>) -> Sample {
    let p_rest = math_transform_point(to_rest, p_posed);
    var limb = Sample(0.0, vec3<f32>(0.0));
    let u = math_transform_point(groups[at].grid.rest_to_grid, p_rest);
    if grid_holds(groups[at].grid, u) {
        var raw = grid_sample(groups[at].grid, u);
        // Most groups do not fold; what a fold is made of need not be read for them.
        if groups[at].fold_start.offset != 0.0 {
            raw += fold_lift(groups[at].fold_start, p_rest);
        }
        if groups[at].fold_end.offset != 0.0 {
            raw += fold_lift(groups[at].fold_end, p_rest);
        }
        let t = field_transfer(raw.w, groups[at].grid.support_radius);
        limb = Sample(t.x, raw.xyz * t.y);
    }
    var set_in = Sample(0.0, vec3<f32>(0.0));
    for (var m = groups[at].grid.muscle_begin; m < groups[at].grid.muscle_end; m++) {
        if any(p_rest < muscles[place.muscle + m].lowest.xyz) || any(p_rest > muscles[place.muscle + m].highest.xyz) {
            continue;
        }
        set_in = clean_union(set_in, muscle_evaluate(muscles[place.muscle + m], place.point, p_rest));
    }
    if set_in.value > 0.0 {
        let d = field_detail(limb.value, set_in.value);
        limb = Sample(d.x, limb.gradient * d.y + set_in.gradient * d.z);
    }
    return Sample(limb.value, math_transpose_vector(to_rest, limb.gradient));
}

// The composed field: the largest of one instance's groups.
fn field_composed(place: FieldPlace, p_posed: vec3<f32>) -> GroupSample {
    var result = GroupSample(0.0, vec3<f32>(0.0), FIELD_NO_GROUP);
    for (var g = 0u; g < place.group_count; g++) {
        if groups[place.group + g].present == 0u {
            continue;
        }
        let sample = field_group(place.group + g, groups[place.group + g].to_rest, place, p_posed);
        if sample.value > result.value {
            result = GroupSample(sample.value, sample.gradient, g);
        }
    }
    return result;
}
