// A quiet backdrop: lighter behind the figure, darker towards the corners. One triangle covers the picture.

struct BackgroundOut {
    @builtin(position) clip: vec4<f32>,
    @location(0) place: vec2<f32>,
}

@vertex
fn background_vertex(@builtin(vertex_index) index: u32) -> BackgroundOut {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u)) * 2.0 - 1.0;
    var out: BackgroundOut;
    out.clip = vec4<f32>(corner, 1.0, 1.0);
    out.place = corner;
    return out;
}

@fragment
fn background_fragment(in: BackgroundOut) -> @location(0) vec4<f32> {
    let away = clamp(length(in.place - vec2<f32>(0.0, 0.15)) / 1.5, 0.0, 1.0);
    let t = away * away * (3.0 - 2.0 * away);
    return vec4<f32>(mix(vec3<f32>(0.105, 0.112, 0.124), vec3<f32>(0.026, 0.028, 0.033), t), 1.0);
}
