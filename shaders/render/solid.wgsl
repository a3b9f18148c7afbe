// Coloured meshes that the host makes anew each frame: muscles.

struct SolidIn {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) color: vec3<f32>,
}

struct SolidOut {
    @builtin(position) clip: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) color: vec3<f32>,
}

@vertex
fn solid_vertex(in: SolidIn) -> SolidOut {
    var out: SolidOut;
    out.clip = view.view_projection * vec4<f32>(in.position, 1.0);
    out.world = in.position;
    out.normal = in.normal;
    out.color = in.color;
    return out;
}

@fragment
fn solid_fragment(in: SolidOut, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let to_eye = light_unit(view.eye.xyz - in.world, view.toward.xyz);
    let n = light_unit(select(-in.normal, in.normal, front), to_eye);
    return vec4<f32>(select(in.color, light_studio(in.color, n, to_eye, 0.10), view.lit > 0.5), 1.0);
}
