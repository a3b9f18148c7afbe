// Muscles as joints of linear skinning, one at every point of an axis (paper B, "Skin Deformation"). One thread per point of every
// instance.

@group(0) @binding(0) var<uniform> params: MuscleParams;
@group(0) @binding(1) var<storage, read> muscles_rest: array<MuscleRest>;
@group(0) @binding(2) var<storage, read> joints_rest: array<MuscleJoint>;
@group(0) @binding(3) var<storage, read> joints: array<JointFrame>;
@group(0) @binding(4) var<storage, read> muscles: array<MuscleFrame>;
@group(0) @binding(5) var<storage, read> axes: array<AxisPoint>;
@group(0) @binding(6) var<storage, read_write> muscle_joints: array<mat4x4<f32>>;

override LEAST_SWELL: f32;
override MOST_SWELL: f32;
override LEAST_TURN: f32;
override NO_DIRECTION: f32;
override SHORT_NONE: f32;
override SHORT_WHOLE: f32;
override LONG_NONE: f32;
override LONG_WHOLE: f32;

// A vector's direction, or `other` where it has none.
fn unit_or(v: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let length = sqrt(math_dot(v, v));
    if length > NO_DIRECTION {
        return v / length;
    }
    return other;
}

// The unit tangent at a point of the axis: midway between those of the segments beside it.
fn point_tangent(first: u32, i: u32) -> vec3<f32> {
    let after = axes[first + i].tangent.xyz;
    if i == 0u {
        return unit_or(after, after);
    }
    return unit_or(after + axes[first + i - 1u].tangent.xyz, after);
}

// The unit tangent at `arc` metres along the axis, turned evenly from each point's to the next one's.
fn smooth_tangent(first: u32, segments: u32, arc: f32) -> vec3<f32> {
    var i = 0u;
    while i + 1u < segments && axes[first + i + 1u].turn.w <= arc {
        i++;
    }
    let point = axes[first + i];
    let share = clamp((arc - point.turn.w) / max(point.tangent.w, NO_DIRECTION), 0.0, 1.0);
    return unit_or(point_tangent(first, i) * (1.0 - share) + point_tangent(first, i + 1u) * share, point.tangent.xyz);
}

fn swelling(now: f32, before: f32, per_metre: f32) -> f32 {
    return clamp((now - before) * per_metre, LEAST_SWELL, MOST_SWELL);
}

// A vector turned the shortest way that takes one unit vector to another.
fn turned(v: vec3<f32>, start: vec3<f32>, end: vec3<f32>) -> vec3<f32> {
    let cosine = math_dot(start, end);
    let axis = math_cross(start, end);
    return v * cosine + math_cross(axis, v) + axis * (math_dot(axis, v) / max(1.0 + cosine, LEAST_TURN));
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = dispatch_index(group, workgroups, local);
    if index >= params.point_count * params.instance_count {
        return;
    }
    let instance = index / params.point_count;
    let own = joints_rest[index - instance * params.point_count];
    let muscle = muscles[instance * params.muscle_count + own.muscle];
    let rest = muscles_rest[own.muscle];
    let to_posed = joints[instance * params.joint_count + rest.joint].matrix;
    if muscle.present == 0u {
        muscle_joints[index] = to_posed;
        return;
    }
    let first = instance * params.point_count + muscle.first_point;
    let place = own.place.xyz;
    let nearest = muscle_nearest(first, muscle.segments, place);
    let foot = muscle_project(first, muscle.segments, nearest.segment, place);
    let tangent = smooth_tangent(first, muscle.segments, foot.arc);
    let aside = foot.offset - tangent * math_dot(tangent, foot.offset);
    let share = foot.arc * muscle.inverse_length;
    let radius = muscle.width * profile_shifted(muscle.factors, muscle.exponents, muscle.terms, muscle.shift, share).x;
    let long = swelling(radius * sqrt(muscle.long_squared), own.place.w, own.swell_long);
    let short = swelling(radius * sqrt(muscle.short_squared), own.tangent.w, own.swell_short);
    let before = own.tangent.xyz;
    let normal = own.normal.xyz;
    let square = math_cross(before, normal);
    var columns = mat3x3<f32>(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    for (var i = 0u; i < 3u; i++) {
        let axis = columns[i];
        let swollen = axis + normal * (math_dot(normal, axis) * long) + square * (math_dot(square, axis) * short);
        columns[i] = turned(swollen, before, tangent);
    }
    let moved = place - aside - (columns[0] * place.x + columns[1] * place.y + columns[2] * place.z);
    // From the bone's own motion towards the muscle's.
    let ratio = muscle.length / rest.origin_normal.w;
    let short_share = math_smoothstep((ratio - SHORT_NONE) / (SHORT_WHOLE - SHORT_NONE));
    let long_share = math_smoothstep((ratio - LONG_NONE) / (LONG_WHOLE - LONG_NONE));
    let gone = math_dot(aside, aside) * (own.swell_long * own.swell_short);
    let hold = short_share * long_share / sqrt(1.0 + gone);
    let x = vec3<f32>(1.0, 0.0, 0.0);
    let y = vec3<f32>(0.0, 1.0, 0.0);
    let z = vec3<f32>(0.0, 0.0, 1.0);
    let joint = mat4x4<f32>(
        vec4<f32>(x + (columns[0] - x) * hold, 0.0),
        vec4<f32>(y + (columns[1] - y) * hold, 0.0),
        vec4<f32>(z + (columns[2] - z) * hold, 0.0),
        vec4<f32>(moved * hold, 1.0),
    );
    muscle_joints[index] = math_product(to_posed, joint);
}
