// Skin and rigid parts: positions and normals from the deformer's buffer, colour from the file's material.

@group(1) @binding(0) var<uniform> material: MaterialParams;
@group(1) @binding(1) var base_texture: texture_2d<f32>;
@group(1) @binding(2) var base_sampler: sampler;

struct SurfaceIn {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) model_0: vec4<f32>,
    @location(4) model_1: vec4<f32>,
    @location(5) model_2: vec4<f32>,
    @location(6) model_3: vec4<f32>,
}

struct SurfaceOut {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) @interpolate(flat) mirrored: u32,
}

@vertex
fn surface_vertex(in: SurfaceIn) -> SurfaceOut {
    let a = in.model_0.xyz;
    let b = in.model_1.xyz;
    let c = in.model_2.xyz;
    let world = a * in.position.x + b * in.position.y + c * in.position.z + in.model_3.xyz;
    // Normals go with the cofactors: the inverse transpose up to a factor, whose sign a mirror turns.
    let determinant = dot(a, cross(b, c));
    let turned = cross(b, c) * in.normal.x + cross(c, a) * in.normal.y + cross(a, b) * in.normal.z;
    var out: SurfaceOut;
    out.clip = view.view_projection * vec4<f32>(world, 1.0);
    out.world = world;
    out.normal = light_unit(select(turned, -turned, determinant < 0.0), vec3<f32>(0.0));
    out.uv = in.uv;
    out.mirrored = select(0u, 1u, determinant < 0.0);
    return out;
}

// Unit normal on the side that is seen; the triangle's own where the vertices have none.
fn surface_normal(in: SurfaceOut, front: bool, to_eye: vec3<f32>) -> vec3<f32> {
    let flat_normal = light_unit(cross(dpdx(in.world), dpdy(in.world)), to_eye);
    let seen = select(flat_normal, -flat_normal, dot(flat_normal, to_eye) < 0.0);
    let outward = front != (in.mirrored == 1u);
    return light_unit(select(-in.normal, in.normal, outward), seen);
}

fn surface_albedo(uv: vec2<f32>) -> vec3<f32> {
    return material.base_color.rgb * textureSample(base_texture, base_sampler, uv).rgb;
}

@fragment
fn surface_skin(in: SurfaceOut, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let to_eye = light_unit(view.eye.xyz - in.world, view.toward.xyz);
    let n = surface_normal(in, front, to_eye);
    let albedo = surface_albedo(in.uv);
    return vec4<f32>(select(albedo, light_studio(albedo, n, to_eye, 0.045), view.lit > 0.5), 1.0);
}

// Depth alone: finds the skin's front-most layer.
@fragment
fn surface_depth() -> @location(0) vec4<f32> {
    return vec4<f32>(0.0);
}

// Glass: thin where it faces the eye, dense where it turns away. Premultiplied.
@fragment
fn surface_ghost(in: SurfaceOut, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let to_eye = light_unit(view.eye.xyz - in.world, view.toward.xyz);
    let n = surface_normal(in, front, to_eye);
    let own = surface_albedo(in.uv);
    let glass = mix(vec3<f32>(0.52, 0.60, 0.70), own, 0.35);
    let edge = pow(1.0 - clamp(dot(n, to_eye), 0.0, 1.0), view.ghost_power);
    let lit = light_studio(glass, n, to_eye, 0.12) + vec3<f32>(0.16, 0.19, 0.23) * edge;
    let opacity = mix(view.ghost_facing, view.ghost_edge, edge);
    return vec4<f32>(lit * opacity, opacity);
}
