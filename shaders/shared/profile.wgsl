// A muscle's profile.

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
