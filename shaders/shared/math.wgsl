fn math_transform_point(m: mat4x4<f32>, p: vec3<f32>) -> vec3<f32> {
    return (m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3]).xyz;
}

fn math_transform_vector(m: mat4x4<f32>, v: vec3<f32>) -> vec3<f32> {
    return (m[0] * v.x + m[1] * v.y + m[2] * v.z).xyz;
}

// A product of maps with its sums in a stated order.
fn math_product(a: mat4x4<f32>, b: mat4x4<f32>) -> mat4x4<f32> {
    return mat4x4<f32>(math_times(a, b[0]), math_times(a, b[1]), math_times(a, b[2]), math_times(a, b[3]));
}

fn math_times(a: mat4x4<f32>, v: vec4<f32>) -> vec4<f32> {
    return a[0] * v.x + a[1] * v.y + a[2] * v.z + a[3] * v.w;
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

fn math_cross(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y);
}

// Arc sine of x in 0..=1 (Abramowitz and Stegun 4.4.46).
fn math_arc_sine(x: f32) -> f32 {
    let series = 1.5707963
        + x * (-0.2145988
            + x * (0.08897899
                + x * (-0.0501743
                    + x * (0.03089188 + x * (-0.017088126 + x * (0.00667009 + x * -0.0012624911))))));
    return 1.5707963 - sqrt(1.0 - x) * series;
}

// The angle of a vector; 0 of no vector.
fn math_polar_angle(x: f32, y: f32) -> f32 {
    let across = abs(x);
    let up = abs(y);
    let length = sqrt(x * x + y * y);
    if length < 1.17549435e-38 {
        return 0.0;
    }
    var acute = 0.0;
    if up <= across {
        acute = math_arc_sine(up / length);
    } else {
        acute = 1.5707963 - math_arc_sine(across / length);
    }
    let half = select(acute, 3.1415927 - acute, x < 0.0);
    return select(half, -half, y < 0.0);
}

// Sine and cosine of x in 0..=pi, from the series about a right angle.
fn math_sine_cosine(x: f32) -> vec2<f32> {
    let y = x - 1.5707963;
    let y2 = y * y;
    let sine = y
        * (1.0
            + y2 * (-0.16666667
                + y2 * (0.008333334 + y2 * (-0.0001984127 + y2 * (2.7557319e-6 + y2 * -2.5052108e-8)))));
    let cosine = 1.0
        + y2 * (-0.5
            + y2 * (0.041666668
                + y2 * (-0.0013888889 + y2 * (2.4801587e-5 + y2 * (-2.7557319e-7 + y2 * 2.0876757e-9)))));
    return vec2<f32>(cosine, -sine);
}

fn math_smoothstep(x: f32) -> f32 {
    let t = clamp(x, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// Cube root of a normal x > 0; 0 for what is smaller.
fn math_cube_root(x: f32) -> f32 {
    if x < 1.17549435e-38 {
        return 0.0;
    }
    var root = bitcast<f32>(bitcast<u32>(x) / 3u + 0x2a5137a0u);
    for (var i = 0u; i < 3u; i++) {
        root = (2.0 * root + x / (root * root)) * (1.0 / 3.0);
    }
    return root;
}
