// The muscle primitive's compact field (paper A, equations 1 to 5; background 3.2).

// Profile Phi and its derivative by s, for whole exponents of 2 or more.
fn muscle_profile(alpha: u32, beta: u32, scale: f32, s: f32) -> vec2<f32> {
    let t = 1.0 - s;
    let flank = scale * math_power(s, alpha - 2u) * math_power(t, beta - 2u);
    return vec2<f32>(flank * s * t, flank * (f32(alpha - 1u) * t - f32(beta - 1u) * s));
}

fn muscle_evaluate(muscle: MuscleFrame, q: vec3<f32>) -> Sample {
    if muscle.present == 0u {
        return Sample(0.0, vec3<f32>(0.0));
    }
    let axis = muscle.axis.xyz;
    let from_origin = q - muscle.origin.xyz;
    let along = math_dot(from_origin, axis) * muscle.axis.w;
    let s = clamp(along, 0.0, 1.0);
    let across = from_origin - axis * (s * muscle.origin.w);
    let d = sqrt(math_dot(across, across));
    if d < 1e-9 {
        return Sample(1.0, vec3<f32>(0.0));
    }
    let outward = across / d;
    let phi = muscle_profile(muscle.alpha, muscle.beta, muscle.profile_scale, s);
    let normal = muscle.normal.xyz;
    let cosine = math_dot(outward, normal);
    let squared = cosine * cosine;
    let polar = 1.0 / sqrt(muscle.short_squared * squared + muscle.long_squared * (1.0 - squared));
    let width = muscle.normal.w;
    let radius = width * phi.x * polar;
    let inside_span = select(0.0, muscle.axis.w, along > 0.0 && along < 1.0);
    let polar_slope = cosine * (muscle.long_squared - muscle.short_squared) * polar * polar * polar;
    let radius_gradient = axis * (width * phi.y * polar * inside_span)
        + (normal - outward * cosine) * (width * phi.x * polar_slope / d);
    let x = d - radius;
    if x >= 0.0 {
        let t = field_transfer(x, muscle.support_radius);
        return Sample(t.x, (outward - radius_gradient) * t.y);
    }
    let u = -x / radius;
    let u2 = u * u;
    let steepness = 0.9375 / muscle.support_radius;
    let start = steepness * radius;
    let hump = u - 2.0 * u2 + u2 * u;
    let value = min(0.5 + start * hump + 0.5 * (3.0 * u2 - 2.0 * u2 * u), 1.0);
    let by_u = start * (1.0 - 4.0 * u + 3.0 * u2) + 3.0 * (u - u2);
    let u_gradient = (radius_gradient * (d / radius) - outward) / radius;
    return Sample(value, u_gradient * by_u + radius_gradient * (steepness * hump));
}
