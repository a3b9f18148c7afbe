// What every field gives, and how a raw distance becomes one.

struct Sample {
    value: f32,
    gradient: vec3<f32>,
}

// Value and derivative of the compact transfer t_r (background 1.5).
fn field_transfer(d: f32, r: f32) -> vec2<f32> {
    if d <= -r {
        return vec2<f32>(1.0, 0.0);
    }
    if d >= r {
        return vec2<f32>(0.0, 0.0);
    }
    let x = d / r;
    let x2 = x * x;
    let rest = 1.0 - x2;
    let value = clamp(0.5 - x * (0.9375 - x2 * (0.625 - 0.1875 * x2)), 0.0, 1.0);
    return vec2<f32>(value, -0.9375 * rest * rest / r);
}
