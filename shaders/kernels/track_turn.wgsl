// The rotation that takes a vertex's edges at rest nearest to what they are (background 2.2). One thread per vertex of
// every instance.

@group(0) @binding(0) var<uniform> params: TrackParams;
@group(0) @binding(1) var<storage, read> targets: array<VertexTarget>;
@group(0) @binding(2) var<storage, read> edges: array<SkinEdge>;
@group(0) @binding(3) var<storage, read> positions_rest: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> positions: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> tracks: array<Track>;

override TRACK_RUNS: u32;
override TURNS: u32;
override WEAKEST_TURN: f32;

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
    let instance = index / params.vertex_count;
    let first = instance * params.vertex_count;
    let goal = targets[index - first];
    if goal.turns == 0u || tracks[index].runs != TRACK_RUNS {
        return;
    }
    let p = positions[index].xyz;
    let p_rest = positions_rest[index - first].xyz;
    var x = vec3<f32>(0.0);
    var y = x;
    var z = x;
    var size = 0.0;
    for (var k = goal.edge_begin; k < goal.edge_end; k++) {
        let other = edges[k].neighbour;
        let e = p - positions[first + other].xyz;
        let e_rest = p_rest - positions_rest[other].xyz;
        let rest = e_rest * edges[k].weight;
        x += e * rest.x;
        y += e * rest.y;
        z += e * rest.z;
        size += edges[k].weight * math_dot(e_rest, e_rest);
    }
    let normal = tracks[index].normal.xyz * (params.normal_weight * size);
    x += normal * goal.normal_rest.x;
    y += normal * goal.normal_rest.y;
    z += normal * goal.normal_rest.z;
    var q = tracks[index].rotation;
    for (var k = 0u; k < TURNS; k++) {
        let r = quaternion_matrix(q);
        let along = abs(math_dot(r[0], x) + math_dot(r[1], y) + math_dot(r[2], z));
        let around = math_cross(r[0], x) + math_cross(r[1], y) + math_cross(r[2], z);
        let least = WEAKEST_TURN * size;
        if along <= least && math_dot(around, around) <= least * least {
            break;
        }
        q = quaternion_turned(q, around / max(along, least));
    }
    let broken = math_not_finite(q.x + q.y + q.z + q.w);
    tracks[index].rotation = select(q, vec4<f32>(0.0, 0.0, 0.0, 1.0), broken);
}
