fn math_transform_point(m: mat4x4<f32>, p: vec3<f32>) -> vec3<f32> {
    return (m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3]).xyz;
}

fn math_transform_vector(m: mat4x4<f32>, v: vec3<f32>) -> vec3<f32> {
    return (m[0] * v.x + m[1] * v.y + m[2] * v.z).xyz;
}

// The transposed upper 3x3 times v: takes a gradient from the map's target space back to its source space.
fn math_transpose_vector(m: mat4x4<f32>, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(math_dot(m[0].xyz, v), math_dot(m[1].xyz, v), math_dot(m[2].xyz, v));
}

// Sums in a stated order, so that host and kernel agree where the driver does not fuse.
fn math_dot(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn math_power(x: f32, exponent: u32) -> f32 {
    var result = 1.0;
    for (var i = 0u; i < exponent; i++) {
        result *= x;
    }
    return result;
}

// Bit test, because drivers fold x != x away.
fn math_not_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) >= 0x7f800000u;
}
