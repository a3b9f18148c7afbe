// One sweep of Jacobi's method on the skin's elastic energy, along the field alone (background 2.2). One thread per vertex
// of every instance.

@group(0) @binding(0) var<uniform> params: TrackParams;
@group(0) @binding(1) var<storage, read> targets: array<VertexTarget>;
@group(0) @binding(2) var<storage, read> edges: array<SkinEdge>;
@group(0) @binding(3) var<storage, read> tracks: array<Track>;
@group(0) @binding(4) var<storage, read> spans: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> positions: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> slid: array<vec4<f32>>;

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
    let own = positions[index];
    let normal = tracks[index].normal.xyz;
    if goal.role != ROLE_ACTIVE || goal.slides == 0u {
        slid[index] = own;
        return;
    }
    var sum = vec3<f32>(0.0);
    for (var k = goal.edge_begin; k < goal.edge_end; k++) {
        sum += positions[first + edges[k].neighbour].xyz * edges[k].weight;
    }
    let span = spans[index];
    let way = sum * span.w + span.xyz - own.xyz;
    let share = 1.0 - params.contact_hold * tracks[index].contact;
    let moved = own.xyz + (way - normal * math_dot(normal, way)) * share;
    slid[index] = select(vec4<f32>(moved, 1.0), own, math_not_finite(math_dot(moved, moved)));
}
