// Area-weighted face normals, and the output vertex. One thread per vertex of every instance.

@group(0) @binding(0) var<uniform> params: NormalParams;
@group(0) @binding(1) var<storage, read> triangles: array<u32>;
@group(0) @binding(2) var<storage, read> fans: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> members: array<u32>;
@group(0) @binding(4) var<storage, read> positions: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> vertices: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = dispatch_index(group, groups, local);
    if index >= params.vertex_count * params.instance_count {
        return;
    }
    let instance = index / params.vertex_count;
    let vertex = index - instance * params.vertex_count;
    let first = instance * params.vertex_count;
    var sum = vec3<f32>(0.0);
    let fan = fans[vertex];
    for (var i = fan.x; i < fan.y; i++) {
        let corner = 3u * members[i];
        let a = positions[first + triangles[corner]].xyz;
        let b = positions[first + triangles[corner + 1u]].xyz;
        let c = positions[first + triangles[corner + 2u]].xyz;
        sum += cross(b - a, c - a);
    }
    let squared = math_dot(sum, sum);
    var normal = vec3<f32>(0.0, 1.0, 0.0);
    if squared > 1e-30 {
        normal = sum / sqrt(squared);
    }
    let position = positions[index].xyz;
    let at = params.offset + index * params.stride;
    vertices[at + params.position_at] = position.x;
    vertices[at + params.position_at + 1u] = position.y;
    vertices[at + params.position_at + 2u] = position.z;
    vertices[at + params.normal_at] = normal.x;
    vertices[at + params.normal_at + 1u] = normal.y;
    vertices[at + params.normal_at + 2u] = normal.z;
}
