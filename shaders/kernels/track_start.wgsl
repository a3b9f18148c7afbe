// A pose's skin where geometric skinning has it, all else forgotten. One thread per vertex of every instance.

@group(0) @binding(0) var<uniform> params: TrackParams;
@group(0) @binding(1) var<storage, read> ways: array<Way>;
@group(0) @binding(2) var<storage, read> skinned: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> positions: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> tracks: array<Track>;

override TRACK_RUNS: u32;

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
    if ways[index / params.vertex_count].count == 0u {
        tracks[index].runs = 0u;
        return;
    }
    positions[index] = skinned[index];
    tracks[index] = Track(vec4<f32>(0.0), vec4<f32>(0.0, 0.0, 0.0, 1.0), 0.0, 0u, 0u, TRACK_RUNS);
}
