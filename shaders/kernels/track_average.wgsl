// One sweep of relaxation to the mean of neighbours: along the field by mean value coordinates at rest, or wholly where skin
// presses against skin (background 1.13 and 1.14). One thread per vertex of every instance.

@group(0) @binding(0) var<uniform> params: TrackParams;
@group(0) @binding(1) var<storage, read> targets: array<VertexTarget>;
@group(0) @binding(2) var<storage, read> edges: array<SkinEdge>;
@group(0) @binding(3) var<storage, read> mean_values: array<f32>;
@group(0) @binding(4) var<storage, read> tracks: array<Track>;
@group(0) @binding(5) var<storage, read> positions: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> averaged: array<vec4<f32>>;

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
    let first = index / params.vertex_count * params.vertex_count;
    let goal = targets[index - first];
    let own = positions[index];
    if goal.role != ROLE_ACTIVE || goal.slides == 0u {
        averaged[index] = own;
        return;
    }
    var mean = vec3<f32>(0.0);
    var sum = vec3<f32>(0.0);
    var contact = tracks[index].contact;
    for (var k = goal.edge_begin; k < goal.edge_end; k++) {
        let other = first + edges[k].neighbour;
        let e = positions[other].xyz - own.xyz;
        mean += e;
        sum += e * mean_values[k];
        contact += tracks[other].contact;
    }
    var moved = own.xyz;
    if params.projects != 0u {
        let count = f32(goal.edge_end - goal.edge_begin);
        moved += mean * (contact / ((count + 1.0) * count));
    } else {
        let left = 1.0 - min(abs(tracks[index].normal.w), 1.0);
        let squared = left * left;
        let normal = tracks[index].normal.xyz;
        moved += (sum - normal * math_dot(normal, sum)) * (1.0 - squared * squared);
    }
    averaged[index] = select(vec4<f32>(moved, 1.0), own, math_not_finite(math_dot(moved, moved)));
}
