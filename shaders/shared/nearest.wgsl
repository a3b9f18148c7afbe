// The segment of a muscle's axis that is nearest to a point. Reads the global axes; `first` is the axis' first point.
//
// A squared distance carries its segment's number in its lowest bits, so that the least of them, compared as whole
// numbers, names its segment. With h from a segment's start, t the place of the foot on its line and f on the segment,
// both as shares of it, the squared distance is h^2 + f (f - 2t) l^2; rounding may leave less than zero on the axis, so
// the sign goes with the lowest bits.
override NEAREST_KEY_BITS: u32;

struct Nearest {
    segment: u32,
    squared: f32,
}

fn nearest_of_key(key: u32) -> Nearest {
    return Nearest(key & NEAREST_KEY_BITS, bitcast<f32>(key & ~NEAREST_KEY_BITS));
}

// The key that every other one is nearer than, of the first segment.
fn nearest_farthest() -> u32 {
    return 0x7f7fffffu & ~NEAREST_KEY_BITS;
}

fn muscle_nearest(first: u32, segments: u32, q: vec3<f32>) -> Nearest {
    var best = nearest_farthest();
    var start = axes[first].position.xyz;
    for (var i = 0u; i < segments; i++) {
        let end = axes[first + i + 1u].position;
        let span = end.xyz - start;
        let h = q - start;
        let place = math_dot(h, span * end.w);
        let foot = clamp(place, 0.0, 1.0);
        let squared = math_dot(h, h) + foot * (foot - (place + place)) * math_dot(span, span);
        best = min(best, (bitcast<u32>(squared) & (0x7fffffffu & ~NEAREST_KEY_BITS)) | i);
        start = end.xyz;
    }
    return nearest_of_key(best);
}

// Keys of sixteen points at a time: what is read of the axis serves all of them.
fn muscle_nearest_sixteen(first: u32, segments: u32, q: array<mat4x4<f32>, 4>) -> array<vec4<u32>, 4> {
    let far = vec4<u32>(nearest_farthest());
    var best_0 = far;
    var best_1 = far;
    var best_2 = far;
    var best_3 = far;
    var start = axes[first].position.xyz;
    for (var i = 0u; i < segments; i++) {
        let end = axes[first + i + 1u].position;
        let span = end.xyz - start;
        let slope = span * end.w;
        let l2 = math_dot(span, span);
        best_0 = min(best_0, nearest_four_keys(q[0], start, slope, l2, i));
        best_1 = min(best_1, nearest_four_keys(q[1], start, slope, l2, i));
        best_2 = min(best_2, nearest_four_keys(q[2], start, slope, l2, i));
        best_3 = min(best_3, nearest_four_keys(q[3], start, slope, l2, i));
        start = end.xyz;
    }
    return array<vec4<u32>, 4>(best_0, best_1, best_2, best_3);
}

// Keys of four points, whose coordinates stand in the first three columns, for one segment: its start, its span over its
// squared length, its squared length.
fn nearest_four_keys(q: mat4x4<f32>, start: vec3<f32>, slope: vec3<f32>, l2: f32, segment: u32) -> vec4<u32> {
    let hx = q[0] - start.x;
    let hy = q[1] - start.y;
    let hz = q[2] - start.z;
    let place = hx * slope.x + hy * slope.y + hz * slope.z;
    let foot = clamp(place, vec4<f32>(0.0), vec4<f32>(1.0));
    let squared = hx * hx + hy * hy + hz * hz + foot * (foot - (place + place)) * l2;
    return (bitcast<vec4<u32>>(squared) & vec4<u32>(0x7fffffffu & ~NEAREST_KEY_BITS)) | vec4<u32>(segment);
}

// Which of sixteen points, from the lowest bit on, have keys of at most this squared distance.
fn nearest_within(keys: array<vec4<u32>, 4>, squared: f32) -> u32 {
    let limit = vec4<u32>(bitcast<u32>(squared) | NEAREST_KEY_BITS);
    let none = vec4<u32>(0u);
    let bits = vec4<u32>(1u, 2u, 4u, 8u);
    let within = select(none, bits, keys[0] <= limit) | select(none, bits << vec4<u32>(4u), keys[1] <= limit)
        | select(none, bits << vec4<u32>(8u), keys[2] <= limit) | select(none, bits << vec4<u32>(12u), keys[3] <= limit);
    return within.x | within.y | within.z | within.w;
}
