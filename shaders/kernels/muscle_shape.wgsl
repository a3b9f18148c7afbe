// Muscle ends from their joints, the axis between them, round what it lies round or as the dynamics left it, and width at constant
// volume. One thread per muscle of every instance.

@group(0) @binding(0) var<uniform> params: MuscleParams;
@group(0) @binding(1) var<storage, read> muscles_rest: array<MuscleRest>;
@group(0) @binding(2) var<storage, read> inputs: array<MuscleInput>;
@group(0) @binding(3) var<storage, read> joints: array<JointFrame>;
@group(0) @binding(4) var<storage, read_write> shaped: array<MuscleFrame>;
@group(0) @binding(5) var<storage, read_write> axes: array<AxisPoint>;
@group(0) @binding(6) var<storage, read> iterates: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> wraps: array<MuscleWrap>;

override MIN_LENGTH: f32;
override LEAST_SUPPORT_RADII: f32;
override ROUNDING: f32;
override PI: f32;
override WRAPS: bool;

// Puts the points evenly on the straight line between the ends.
fn straighten(first: u32, segments: u32, origin: vec3<f32>, insertion: vec3<f32>) {
    for (var i = 0u; i <= segments; i++) {
        let share = f32(i) / f32(segments);
        axes[first + i].position = vec4<f32>(origin * (1.0 - share) + insertion * share, 0.0);
    }
}

// Smooths the inner points by binomial passes.
fn smooth_axis(first: u32, segments: u32) {
    for (var k = 0u; k < AXIS_SMOOTHING; k++) {
        var before = axes[first].position;
        for (var i = 1u; i < segments; i++) {
            let own = axes[first + i].position;
            axes[first + i].position = (before + axes[first + i + 1u].position) * 0.25 + own * 0.5;
            before = own;
        }
    }
}

// Puts the points on their path.
fn put_on_course(first: u32, course: Course) {
    for (var i = 0u; i <= course.segments; i++) {
        axes[first + i].position = vec4<f32>(course_point(course, i), 0.0);
    }
}

// Smooths how far the points are from their path.
fn smooth_on_course(first: u32, course: Course) {
    for (var i = 0u; i <= course.segments; i++) {
        axes[first + i].position -= vec4<f32>(course_point(course, i), 0.0);
    }
    smooth_axis(first, course.segments);
    for (var i = 0u; i <= course.segments; i++) {
        axes[first + i].position += vec4<f32>(course_point(course, i), 0.0);
    }
}

fn shape(rest: MuscleRest, own: MuscleInput, first: u32, length: f32) -> MuscleFrame {
    var muscle = MuscleFrame();
    muscle.first_point = rest.first_point;
    muscle.segments = rest.segments;
    if length < MIN_LENGTH || math_not_finite(length) {
        return muscle;
    }
    let width = own.width * sqrt(rest.origin.w / (PI * length));
    let short_squared = sqrt(1.0 - own.eccentricity * own.eccentricity);
    let long_squared = 1.0 / short_squared;
    let largest = width * (own.profile_bound * sqrt(1.0 + 4.0 * abs(own.shift))) * sqrt(long_squared);
    let support_radius = max(rest.insertion.w, LEAST_SUPPORT_RADII * largest);
    var lowest = axes[first].position.xyz;
    var highest = lowest;
    for (var i = 0u; i <= rest.segments; i++) {
        lowest = min(lowest, axes[first + i].position.xyz);
        highest = max(highest, axes[first + i].position.xyz);
    }
    let reach = largest + support_radius;
    muscle.factors = own.factors;
    muscle.lowest = vec4<f32>(lowest - reach, reach * reach * ROUNDING);
    muscle.highest = vec4<f32>(highest + reach, 0.0);
    muscle.exponents = own.exponents;
    muscle.terms = own.terms;
    muscle.length = length;
    muscle.inverse_length = 1.0 / length;
    muscle.width = width;
    muscle.support_radius = support_radius;
    muscle.short_squared = short_squared;
    muscle.long_squared = long_squared;
    muscle.activation = own.activation;
    muscle.present = 1u;
    muscle.shift = own.shift;
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
    let to_rest = inverse_affine(joints[instance * params.joint_count + rest.joint].matrix).matrix;
    let origin_matrix = joints[instance * params.joint_count + rest.origin_joint].matrix;
    let insertion_matrix = joints[instance * params.joint_count + rest.insertion_joint].matrix;
    let origin = math_transform_point(to_rest, math_transform_point(origin_matrix, rest.origin.xyz));
    let insertion = math_transform_point(to_rest, math_transform_point(insertion_matrix, rest.insertion.xyz));
    let origin_normal = math_transform_vector(to_rest, math_transform_vector(origin_matrix, rest.origin_normal.xyz));
    let insertion_normal =
        math_transform_vector(to_rest, math_transform_vector(insertion_matrix, rest.insertion_normal.xyz));
    let first = instance * params.point_count + rest.first_point;
    var own = inputs[index];
    let follows = WRAPS && rest.wrap != 0u;
    var course = Course();
    if follows {
        let wrap = wraps[rest.wrap - 1u];
        let around = joints[instance * params.joint_count + wrap.joint].matrix;
        let to_own = math_product(to_rest, math_product(around, wrap.to_rest));
        course = course_of(wrap, to_own, origin, insertion, params.moving == 0u);
    }
    if params.moving == 0u {
        if follows {
            put_on_course(first, course);
        } else {
            straighten(first, rest.segments, origin, insertion);
        }
    } else {
        let moved = dynamics_run(instance, index - instance * params.muscle_count, rest.first_point, 0u) + 2u;
        for (var i = 0u; i <= rest.segments; i++) {
            axes[first + i].position = vec4<f32>(math_transform_point(to_rest, iterates[moved + 2u * i].xyz), 0.0);
        }
        if follows {
            smooth_on_course(first, course);
        } else {
            smooth_axis(first, rest.segments);
        }
        own.shift = iterates[moved + 2u * rest.segments + 1u].w;
    }
    let length = axis_frame(first, rest.segments, origin_normal, insertion_normal);
    shaped[index] = shape(rest, own, first, length);
}
