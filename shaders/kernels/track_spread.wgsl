// Positions of first copies to all vertices. One thread per vertex of every instance.

@group(0) @binding(0) var<uniform> params: TrackParams;
@group(0) @binding(1) var<storage, read> targets: array<VertexTarget>;
@group(0) @binding(2) var<storage, read> positions: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> tracked: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = dispatch_index(group, workgroups, local);
    if index >= params.vertex_count * params.instance_count {
        return;
    }
    let first = index / params.vertex_count * params.vertex_count;
    tracked[index] = positions[first + targets[index - first].copy_of];
}
