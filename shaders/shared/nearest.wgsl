// The segment of a muscle's axis that is nearest to a point. Reads the global axes; `first` is the axis' first point.

// The nearest segment, of equals the first, and the squared distance to it.
struct Nearest {
    segment: u32,
    squared: f32,
}

fn muscle_nearest(first: u32, segments: u32, q: vec3<f32>) -> Nearest {
    var found = Nearest(0u, 3.4e38);
    var start = axes[first].position.xyz;
    for (var i = 0u; i < segments; i++) {
        let end = axes[first + i + 1u].position;
        let span = end.xyz - start;
        let h = q - start;
        let offset = h - span * clamp(math_dot(h, span) * end.w, 0.0, 1.0);
        let squared = math_dot(offset, offset);
        if squared < found.squared {
            found = Nearest(i, squared);
        }
        start = end.xyz;
    }
    return found;
}

// The same for eight points at a time: what is read of the axis serves all eight.
struct NearestEight {
    segment_0: vec4<u32>,
    segment_1: vec4<u32>,
    squared_0: vec4<f32>,
    squared_1: vec4<f32>,
}

fn muscle_nearest_eight(first: u32, segments: u32, q_0: mat4x4<f32>, q_1: mat4x4<f32>) -> NearestEight {
    let far = vec4<f32>(3.4e38);
    var found = NearestEight(vec4<u32>(0u), vec4<u32>(0u), far, far);
    var start = axes[first].position.xyz;
    for (var i = 0u; i < segments; i++) {
        let end = axes[first + i + 1u].position;
        let span = end.xyz - start;
        let squared_0 = muscle_squared_four(q_0, start, span, end.w);
        let squared_1 = muscle_squared_four(q_1, start, span, end.w);
        found.segment_0 = select(found.segment_0, vec4<u32>(i), squared_0 < found.squared_0);
        found.segment_1 = select(found.segment_1, vec4<u32>(i), squared_1 < found.squared_1);
        found.squared_0 = min(found.squared_0, squared_0);
        found.squared_1 = min(found.squared_1, squared_1);
        start = end.xyz;
    }
    return found;
}

// Squared distances of four points, whose coordinates stand in the first three columns, to a segment.
fn muscle_squared_four(q: mat4x4<f32>, start: vec3<f32>, span: vec3<f32>, scale: f32) -> vec4<f32> {
    let hx = q[0] - start.x;
    let hy = q[1] - start.y;
    let hz = q[2] - start.z;
    let share = clamp((hx * span.x + hy * span.y + hz * span.z) * scale, vec4<f32>(0.0), vec4<f32>(1.0));
    let ox = hx - span.x * share;
    let oy = hy - span.y * share;
    let oz = hz - span.z * share;
    return ox * ox + oy * oy + oz * oz;
}
