// Spheres outside which field groups have no field, muscles included. One thread per group of every sub-pose and instance.

@group(0) @binding(0) var<uniform> params: MuscleParams;
@group(0) @binding(1) var<storage, read> muscles: array<MuscleFrame>;
@group(0) @binding(2) var<storage, read_write> groups: array<GroupFrame>;

override ROUNDING: f32;
override FARTHEST: f32;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let at = dispatch_index(group, workgroups, local);
    if at >= arrayLength(&groups) || groups[at].bounds.w >= 0.0 {
        return;
    }
    let first = at / params.group_count % params.instance_count * params.muscle_count;
    var lowest = vec3<f32>(FARTHEST);
    var highest = -lowest;
    for (var m = groups[at].grid.muscle_begin; m < groups[at].grid.muscle_end; m++) {
        lowest = min(lowest, muscles[first + m].lowest.xyz);
        highest = max(highest, muscles[first + m].highest.xyz);
    }
    let width = highest - lowest;
    if math_not_finite(math_dot(width, width)) {
        return;
    }
    let to_posed = inverse_affine(groups[at].to_rest).matrix;
    let centre = groups[at].bounds.xyz;
    var squared = -groups[at].bounds.w;
    for (var k = 0u; k < 8u; k++) {
        let high = (vec3<u32>(k) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u);
        let away = math_transform_point(to_posed, select(lowest, highest, high)) - centre;
        squared = max(squared, math_dot(away, away) * ROUNDING);
    }
    if squared < FARTHEST {
        groups[at].bounds.w = squared;
    }
}
