// Muscle ends from their joints, length, and width at constant volume. One thread per muscle of every instance.

@group(0) @binding(0) var<uniform> params: MuscleParams;
@group(0) @binding(1) var<storage, read> muscles_rest: array<MuscleRest>;
@group(0) @binding(2) var<storage, read> joints: array<JointFrame>;
@group(0) @binding(3) var<storage, read> groups: array<GroupFrame>;
@group(0) @binding(4) var<storage, read_write> shaped: array<MuscleFrame>;

override MIN_LENGTH: f32;
override ACTIVE_SHORTENING: f32;
override LEAST_SUPPORT_RADII: f32;
override PI: f32;

fn across(wanted: vec3<f32>, axis: vec3<f32>) -> vec3<f32> {
    let flat_wanted = wanted - axis * math_dot(wanted, axis);
    let length = sqrt(math_dot(flat_wanted, flat_wanted));
    if length > 1e-6 {
        return flat_wanted / length;
    }
    let other = select(vec3<f32>(0.0, 1.0, 0.0), vec3<f32>(1.0, 0.0, 0.0), abs(axis.x) < 0.7);
    let flat_other = other - axis * math_dot(other, axis);
    return flat_other / sqrt(math_dot(flat_other, flat_other));
}

fn shape(rest: MuscleRest, origin: vec3<f32>, insertion: vec3<f32>, wanted_normal: vec3<f32>) -> MuscleFrame {
    let span = insertion - origin;
    let length = sqrt(math_dot(span, span));
    if length < MIN_LENGTH {
        return MuscleFrame();
    }
    let axis = span / length;
    let width = sqrt(rest.origin.w / (PI * length));
    let largest = width * rest.profile_max * sqrt(rest.long_squared);
    var muscle: MuscleFrame;
    muscle.origin = vec4<f32>(origin, length);
    muscle.axis = vec4<f32>(axis, 1.0 / length);
    muscle.normal = vec4<f32>(across(wanted_normal, axis), width);
    muscle.alpha = rest.alpha;
    muscle.beta = rest.beta;
    muscle.profile_scale = rest.profile_scale;
    muscle.support_radius = max(rest.insertion.w, LEAST_SUPPORT_RADII * largest);
    muscle.short_squared = rest.short_squared;
    muscle.long_squared = rest.long_squared;
    muscle.activation = clamp((1.0 - length / rest.origin_normal.w) / ACTIVE_SHORTENING, 0.0, 1.0);
    muscle.present = 1u;
    return muscle;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = dispatch_index(group, workgroups, local);
    if index >= params.muscle_count * params.instance_count {
        return;
    }
    let instance = index / params.muscle_count;
    let rest = muscles_rest[index - instance * params.muscle_count];
    let to_rest = groups[instance * params.group_count + rest.group].to_rest;
    let origin_matrix = joints[instance * params.joint_count + rest.origin_joint].matrix;
    let insertion_matrix = joints[instance * params.joint_count + rest.insertion_joint].matrix;
    let origin = math_transform_point(to_rest, math_transform_point(origin_matrix, rest.origin.xyz));
    let insertion = math_transform_point(to_rest, math_transform_point(insertion_matrix, rest.insertion.xyz));
    let normal = math_transform_vector(to_rest, math_transform_vector(origin_matrix, rest.origin_normal.xyz))
        + math_transform_vector(to_rest, math_transform_vector(insertion_matrix, rest.insertion_normal.xyz));
    shaped[index] = shape(rest, origin, insertion, normal);
}
