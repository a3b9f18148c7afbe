// A muscle's profile, and the same shifted along the axis at constant volume.

// Phi and its derivative by s.
fn profile_at(factors: vec4<f32>, exponents: u32, terms: u32, s: f32) -> vec2<f32> {
    let t = 1.0 - s;
    var phi = vec2<f32>(0.0);
    for (var k = 0u; k < terms; k++) {
        let byte = exponents >> (8u * k);
        let p = byte & 15u;
        let q = (byte >> 4u) & 15u;
        let s_below = math_power(s, max(p, 1u) - 1u);
        let t_below = math_power(t, max(q, 1u) - 1u);
        let s_power = select(s_below * s, 1.0, p == 0u);
        let t_power = select(t_below * t, 1.0, q == 0u);
        let factor = factors[k];
        phi.x += factor * s_power * t_power;
        phi.y += factor * (f32(p) * s_below * t_power - f32(q) * s_power * t_below);
    }
    return phi;
}

// Phi(sigma(s)) sqrt(sigma'(s)) and its derivative by s, with sigma(s) = s - 4 d s (1 - s) and the shift d.
fn profile_shifted(factors: vec4<f32>, exponents: u32, terms: u32, shift: f32, s: f32) -> vec2<f32> {
    var place = s;
    var slope = 1.0;
    var root = 1.0;
    var lean = 0.0;
    if shift != 0.0 {
        let t = 1.0 - s;
        let bend = 4.0 * shift;
        place = clamp(s - bend * s * t, 0.0, 1.0);
        slope = 1.0 - bend * (t - s);
        root = sqrt(slope);
        lean = bend / root;
    }
    let phi = profile_at(factors, exponents, terms, place);
    return vec2<f32>(phi.x * root, phi.y * slope * root + phi.x * lean);
}
