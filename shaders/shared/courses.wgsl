// The paths of a muscle that lies round something, at the start and at the end of a substep.

struct Courses {
    // At the start, seen from where the obstacle is at the end.
    before: Course,
    // Takes what the obstacle has carried along back to where it was.
    back: mat4x4<f32>,
    now: Course,
}

// `before` and `now` are the muscle's ends.
fn courses_of(wrap: MuscleWrap, around: MovedJoint, before: array<vec3<f32>, 2>, now: array<vec3<f32>, 2>) -> Courses {
    let to_posed = math_product(around.matrix, wrap.to_rest);
    let carry = around.carry;
    let origin = before[0] + math_transform_point(carry, before[0]);
    let insertion = before[1] + math_transform_point(carry, before[1]);
    let added = mat4x4<f32>(
        carry[0] + vec4<f32>(1.0, 0.0, 0.0, 0.0),
        carry[1] + vec4<f32>(0.0, 1.0, 0.0, 0.0),
        carry[2] + vec4<f32>(0.0, 0.0, 1.0, 0.0),
        vec4<f32>(carry[3].xyz, 1.0),
    );
    return Courses(
        course_of(wrap, to_posed, origin, insertion, false),
        inverse_affine(added).matrix,
        course_of(wrap, to_posed, now[0], now[1], false),
    );
}

// Where point `i` of the path was at the start.
fn courses_start(courses: Courses, i: u32) -> vec3<f32> {
    return math_transform_point(courses.back, course_point(courses.before, i));
}

// Multiplier with which a spring of rest length `rest` is in balance over `span`.
fn courses_tension(span: vec3<f32>, rest: f32, stiffness: f32) -> vec3<f32> {
    let length = max(sqrt(math_dot(span, span)), 1e-9);
    return span * (min(rest - length, 0.0) * stiffness / length);
}
