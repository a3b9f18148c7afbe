// The segment of a muscle's axis that is nearest to a point. Reads the global axes; `first` is the axis' first point.
//
// A squared distance carries its segment's number in its lowest bits, so that the least of them, compared as whole
// numbers, names its segment.
override NEAREST_KEY_BITS: u32;

struct Nearest {
    segment: u32,
    squared: f32,
}

fn nearest_of_key(key: u32) -> Nearest {
    return Nearest(key & NEAREST_KEY_BITS, bitcast<f32>(key & ~NEAREST_KEY_BITS));
}

fn muscle_nearest(first: u32, segments: u32, q: vec3<f32>) -> Nearest {
    var best = 0xffffffffu;
    var start = axes[first].position.xyz;
    for (var i = 0u; i < segments; i++) {
        let end = axes[first + i + 1u].position;
        let span = end.xyz - start;
        let h = q - start;
        let offset = h - span * clamp(math_dot(h, span) * end.w, 0.0, 1.0);
        best = min(best, (bitcast<u32>(math_dot(offset, offset)) & ~NEAREST_KEY_BITS) | i);
        start = end.xyz;
    }
    return nearest_of_key(best);
}

// Keys of sixteen points at a time: what is read of the axis serves all of them.
struct SixteenKeys {
    four_0: vec4<u32>,
    four_1: vec4<u32>,
    four_2: vec4<u32>,
    four_3: vec4<u32>,
}

fn muscle_nearest_sixteen(first: u32, segments: u32, q: array<mat4x4<f32>, 4>) -> SixteenKeys {
    let far = vec4<u32>(0xffffffffu);
    var best = SixteenKeys(far, far, far, far);
    var start = axes[first].position.xyz;
    for (var i = 0u; i < segments; i++) {
        let end = axes[first + i + 1u].position;
        let span = end.xyz - start;
        best.four_0 = min(best.four_0, nearest_four_keys(q[0], start, span, end.w, i));
        best.four_1 = min(best.four_1, nearest_four_keys(q[1], start, span, end.w, i));
        best.four_2 = min(best.four_2, nearest_four_keys(q[2], start, span, end.w, i));
        best.four_3 = min(best.four_3, nearest_four_keys(q[3], start, span, end.w, i));
        start = end.xyz;
    }
    return best;
}

// Keys of four points, whose coordinates stand in the first three columns, for one segment.
fn nearest_four_keys(q: mat4x4<f32>, start: vec3<f32>, span: vec3<f32>, scale: f32, segment: u32) -> vec4<u32> {
    let hx = q[0] - start.x;
    let hy = q[1] - start.y;
    let hz = q[2] - start.z;
    let share = clamp((hx * span.x + hy * span.y + hz * span.z) * scale, vec4<f32>(0.0), vec4<f32>(1.0));
    let ox = hx - span.x * share;
    let oy = hy - span.y * share;
    let oz = hz - span.z * share;
    return (bitcast<vec4<u32>>(ox * ox + oy * oy + oz * oz) & vec4<u32>(~NEAREST_KEY_BITS)) | vec4<u32>(segment);
}
