// A muscle's path round its obstacle in one pose, with how its axis' points stand along it.

override COURSE_REST_SHARE: f32;
override COURSE_TENDON_STIFFNESS: f32;

struct Course {
    path: WrapPath,
    length: f32,
    to_posed: mat4x4<f32>,
    origin: vec3<f32>,
    insertion: vec3<f32>,
    // Shares of the path that one segment of tendon and one of muscle have.
    steps: vec2<f32>,
    segments: u32,
    tendon: u32,
}

// Shares at even distances, or as springs under one tension have them.
fn course_steps(wrap: MuscleWrap, length: f32, even: bool) -> vec2<f32> {
    let segments = f32(wrap.segments);
    if even {
        return vec2<f32>(1.0 / segments);
    }
    let tendon = f32(2u * wrap.tendon);
    let muscle = f32(wrap.segments - 2u * wrap.tendon);
    let rest = wrap.rest_length / segments;
    let slack = rest * (tendon + COURSE_REST_SHARE * muscle);
    let stretch = max(length - slack, 0.0) / (tendon / COURSE_TENDON_STIFFNESS + muscle);
    let long = rest + stretch / COURSE_TENDON_STIFFNESS;
    let short = COURSE_REST_SHARE * rest + stretch;
    let whole = tendon * long + muscle * short;
    return vec2<f32>(long / whole, short / whole);
}

// The path between two points of any one space, into which `to_posed` takes the obstacle's frame.
fn course_of(wrap: MuscleWrap, to_posed: mat4x4<f32>, origin: vec3<f32>, insertion: vec3<f32>, even: bool) -> Course {
    let inverse = inverse_affine(to_posed).matrix;
    let start = math_transform_point(inverse, origin);
    let end = math_transform_point(inverse, insertion);
    var course = Course();
    if wrap.sphere != 0u {
        course.path = sphere_path(start, end, wrap);
    } else {
        course.path = cylinder_path(start, end, wrap);
    }
    course.length = path_length(course.path);
    course.to_posed = to_posed;
    course.origin = origin;
    course.insertion = insertion;
    course.steps = course_steps(wrap, course.length, even);
    course.segments = wrap.segments;
    course.tendon = wrap.tendon;
    return course;
}

// Place of a point of the axis; the first and the last are the muscle's ends.
fn course_point(course: Course, i: u32) -> vec3<f32> {
    if i == 0u {
        return course.origin;
    }
    if i >= course.segments {
        return course.insertion;
    }
    let muscle = min(max(i, course.tendon), course.segments - course.tendon) - course.tendon;
    let share = course.steps.x * f32(i - muscle) + course.steps.y * f32(muscle);
    return math_transform_point(course.to_posed, path_point(course.path, course.length * share));
}
