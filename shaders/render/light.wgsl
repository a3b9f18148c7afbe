// The studio: lights fixed to the camera, so that form reads the same from every side.

// Unit vector, or `fallback` where there is none.
fn light_unit(v: vec3<f32>, fallback: vec3<f32>) -> vec3<f32> {
    let square = dot(v, v);
    return select(fallback, v * inverseSqrt(square), square > 1e-20);
}

// Lambert that wraps a little round the terminator, as skin does.
fn light_wrapped(cosine: f32, wrap: f32) -> f32 {
    let x = max((cosine + wrap) / (1.0 + wrap), 0.0);
    return x * x * (3.0 - 2.0 * x) * 0.35 + x * 0.65;
}

// Light that leaves a surface of colour `albedo` with unit normal `n` towards the unit vector `to_eye`; linear RGB.
fn light_studio(albedo: vec3<f32>, n: vec3<f32>, to_eye: vec3<f32>, gloss: f32) -> vec3<f32> {
    let right = view.right.xyz;
    let up = view.up.xyz;
    let toward = view.toward.xyz;
    let key = normalize(-0.60 * right + 0.70 * up + 0.28 * toward);
    let fill = normalize(0.85 * right + 0.05 * up + 0.55 * toward);
    let rim_left = normalize(-0.80 * right + 0.25 * up - 0.60 * toward);
    let rim_right = normalize(0.75 * right + 0.45 * up - 0.60 * toward);

    let facing = clamp(dot(n, to_eye), 0.0, 1.0);
    let sky = 0.5 + 0.5 * n.y;
    let ambient = mix(vec3<f32>(0.036, 0.034, 0.032), vec3<f32>(0.095, 0.102, 0.112), sky * sky);
    var light = ambient;
    light += vec3<f32>(1.120, 1.075, 1.010) * light_wrapped(dot(n, key), 0.08);
    light += vec3<f32>(0.100, 0.115, 0.140) * light_wrapped(dot(n, fill), 0.20);
    // Grazing sides darken: what turns away from the eye recedes.
    light *= mix(0.55, 1.0, sqrt(facing));

    let edge = (1.0 - facing) * (1.0 - facing);
    let back = max(dot(n, rim_left), 0.0) * 0.55 + max(dot(n, rim_right), 0.0) * 0.80;
    let half_way = normalize(key + to_eye);
    let shine = pow(max(dot(n, half_way), 0.0), 26.0) * gloss;
    let sheen = vec3<f32>(0.92, 0.96, 1.0) * edge * back * 0.55;
    return light_shoulder(albedo * light + albedo * sheen + sheen * 0.12 + vec3<f32>(shine));
}

// Leaves the dark two thirds alone and bends the rest below 1.
fn light_shoulder(x: vec3<f32>) -> vec3<f32> {
    let start = vec3<f32>(0.65);
    let over = max(x - start, vec3<f32>(0.0));
    let room = vec3<f32>(1.0) - start;
    return min(x, start) + room * over / (over + room);
}
