// What the edges of every vertex at rest come to, turned as the skin around them has (background 2.2). One thread per
// vertex of every instance.

@group(0) @binding(0) var<uniform> params: TrackParams;
@group(0) @binding(1) var<storage, read> targets: array<VertexTarget>;
@group(0) @binding(2) var<storage, read> edges: array<SkinEdge>;
@group(0) @binding(3) var<storage, read> positions_rest: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> tracks: array<Track>;
@group(0) @binding(5) var<storage, read_write> spans: array<vec4<f32>>;

override ROLE_ACTIVE: u32;
override TRACK_RUNS: u32;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = dispatch_index(group, workgroups, local);
    if index >= params.vertex_count * params.instance_count || tracks[index].runs != TRACK_RUNS {
        return;
    }
    let instance = index / params.vertex_count;
    let first = instance * params.vertex_count;
    let goal = targets[index - first];
    if goal.role != ROLE_ACTIVE || goal.slides == 0u {
        spans[index] = vec4<f32>(0.0);
        return;
    }
    let rotation = quaternion_matrix(tracks[index].rotation);
    let p_rest = positions_rest[index - first].xyz;
    var sum = vec3<f32>(0.0);
    var weights = 0.0;
    for (var k = goal.edge_begin; k < goal.edge_end; k++) {
        let other = edges[k].neighbour;
        let e = p_rest - positions_rest[other].xyz;
        let theirs = quaternion_matrix(tracks[first + other].rotation);
        let both = (rotation[0] * e.x + rotation[1] * e.y + rotation[2] * e.z)
            + (theirs[0] * e.x + theirs[1] * e.y + theirs[2] * e.z);
        sum += both * (0.5 * edges[k].weight);
        weights += edges[k].weight;
    }
    let share = 1.0 / weights;
    spans[index] = vec4<f32>(sum * share, share);
}
