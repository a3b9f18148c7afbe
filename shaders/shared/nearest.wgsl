// The segment of a muscle's axis that is nearest to a point. Reads the global axes; `first` is the axis' first point.

// The nearest segment, of equals the first, and the squared distance to it.
struct Nearest {
    segment: u32,
    squared: f32,
}

fn muscle_nearest(first: u32, segments: u32, q: vec3<f32>) -> Nearest {
    var found = Nearest(0u, 3.4e38);
    var before = q - axes[first].position.xyz;
    for (var i = 0u; i < segments; i++) {
        let end = axes[first + i + 1u].position;
        let after = q - end.xyz;
        let span = before - after;
        let offset = before - span * clamp(math_dot(before, span) * end.w, 0.0, 1.0);
        let squared = math_dot(offset, offset);
        if squared < found.squared {
            found = Nearest(i, squared);
        }
        before = after;
    }
    return found;
}

// The same for four points at a time: what is read of the axis serves all four.
struct NearestFour {
    segment: vec4<u32>,
    squared: vec4<f32>,
}

fn muscle_nearest_four(first: u32, segments: u32, x: vec4<f32>, y: vec4<f32>, z: vec4<f32>) -> NearestFour {
    var found = NearestFour(vec4<u32>(0u), vec4<f32>(3.4e38));
    let start = axes[first].position;
    var before_x = x - start.x;
    var before_y = y - start.y;
    var before_z = z - start.z;
    for (var i = 0u; i < segments; i++) {
        let end = axes[first + i + 1u].position;
        let after_x = x - end.x;
        let after_y = y - end.y;
        let after_z = z - end.z;
        let span_x = before_x - after_x;
        let span_y = before_y - after_y;
        let span_z = before_z - after_z;
        let along = before_x * span_x + before_y * span_y + before_z * span_z;
        let share = clamp(along * end.w, vec4<f32>(0.0), vec4<f32>(1.0));
        let offset_x = before_x - span_x * share;
        let offset_y = before_y - span_y * share;
        let offset_z = before_z - span_z * share;
        let squared = offset_x * offset_x + offset_y * offset_y + offset_z * offset_z;
        let closer = squared < found.squared;
        found.segment = select(found.segment, vec4<u32>(i), closer);
        found.squared = select(found.squared, squared, closer);
        before_x = after_x;
        before_y = after_y;
        before_z = after_z;
    }
    return found;
}
