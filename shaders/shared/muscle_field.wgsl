// A muscle's compact field from its projection (paper A, equations 1, 2 and 5; background 3.2).

fn muscle_near(muscle: MuscleFrame, first: u32, k: u32, q: vec3<f32>) -> Sample {
    let on = muscle_project(first, muscle.segments, k, q);
    let d = sqrt(math_dot(on.offset, on.offset));
    if d < 1e-9 {
        return Sample(1.0, vec3<f32>(0.0));
    }
    let outward = on.offset / d;
    let distance_gradient = outward - on.arc_gradient * math_dot(outward, on.tangent);
    let s = clamp(on.arc * muscle.inverse_length, 0.0, 1.0);
    let phi = profile_shifted(muscle.factors, muscle.exponents, muscle.terms, muscle.shift, s);
    let cosine = math_dot(outward, on.normal);
    let squared = cosine * cosine;
    let polar = 1.0 / sqrt(muscle.short_squared * squared + muscle.long_squared * (1.0 - squared));
    let radius = muscle.width * phi.x * polar;
    let polar_slope = cosine * (muscle.long_squared - muscle.short_squared) * polar * polar * polar;
    let cosine_gradient = (on.normal - on.arc_gradient * math_dot(on.tangent, on.normal) - distance_gradient * cosine) / d
        + on.arc_gradient * math_dot(outward, on.normal_slope);
    let radius_gradient = on.arc_gradient * (muscle.width * phi.y * muscle.inverse_length * polar)
        + cosine_gradient * (muscle.width * phi.x * polar_slope);
    let x = d - radius;
    if x >= 0.0 {
        let t = field_transfer(x, muscle.support_radius);
        return Sample(t.x, (distance_gradient - radius_gradient) * t.y);
    }
    let u = -x / radius;
    let u2 = u * u;
    let steepness = 0.9375 / muscle.support_radius;
    let start = steepness * radius;
    let hump = u - 2.0 * u2 + u2 * u;
    let value = min(0.5 + start * hump + 0.5 * (3.0 * u2 - 2.0 * u2 * u), 1.0);
    let by_u = start * (1.0 - 4.0 * u + 3.0 * u2) + 3.0 * (u - u2);
    let u_gradient = (radius_gradient * (d / radius) - distance_gradient) / radius;
    return Sample(value, u_gradient * by_u + radius_gradient * (steepness * hump));
}

fn muscle_evaluate(muscle: MuscleFrame, first_point: u32, q: vec3<f32>) -> Sample {
    if muscle.present == 0u {
        return Sample(0.0, vec3<f32>(0.0));
    }
    let first = first_point + muscle.first_point;
    let nearest = muscle_nearest(first, muscle.segments, q);
    if nearest.squared > muscle.lowest.w {
        return Sample(0.0, vec3<f32>(0.0));
    }
    return muscle_near(muscle, first, nearest.segment, q);
}
