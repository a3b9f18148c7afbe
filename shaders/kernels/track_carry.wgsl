// Every vertex on from the sub-pose before by its joints' motion, and drawn to where linear skinning has it. One thread
// per vertex of every instance.

@group(0) @binding(0) var<uniform> params: TrackParams;
@group(0) @binding(1) var<storage, read> joints: array<TrackJoint>;
@group(0) @binding(2) var<storage, read> ways: array<Way>;
@group(0) @binding(3) var<storage, read> positions_rest: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> offsets: array<u32>;
@group(0) @binding(5) var<storage, read> influences: array<Influence>;
@group(0) @binding(6) var<storage, read> targets: array<VertexTarget>;
@group(0) @binding(7) var<storage, read_write> positions: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> tracks: array<Track>;

override ROLE_PASSIVE: u32;
override ROLE_COPY: u32;
override STOP_NON_FINITE: u32;
override TRACK_RUNS: u32;
override TRACK_ENDS: u32;
override LOST_PULL: f32;
override LEAST_AWAY: f32;

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
    let vertex = index - instance * params.vertex_count;
    if params.sub_pose >= ways[instance].count {
        tracks[index].runs = 0u;
        if ways[instance].posed != 0u {
            tracks[index].runs = TRACK_ENDS;
            tracks[index].passes = 0u;
        }
        return;
    }
    tracks[index].runs = TRACK_RUNS;
    if targets[vertex].role == ROLE_COPY {
        return;
    }
    let first = (params.sub_pose * params.instance_count + instance) * params.joint_count;
    var matrix = mat4x4<f32>();
    var carry = mat4x4<f32>();
    for (var i = offsets[vertex]; i < offsets[vertex + 1u]; i++) {
        let joint = first + influences[i].joint;
        matrix += joints[joint].matrix * influences[i].weight;
        carry += joints[joint].carry * influences[i].weight;
    }
    let linear = math_transform_point(matrix, positions_rest[vertex].xyz);
    let broken = tracks[index].stop == STOP_NON_FINITE;
    tracks[index].passes = 0u;
    tracks[index].stop = 0u;
    if targets[vertex].role == ROLE_PASSIVE || broken {
        positions[index] = vec4<f32>(linear, 1.0);
        return;
    }
    let p = positions[index].xyz;
    let carried = p + math_transform_point(carry, p);
    let way = linear - carried;
    let anchor = params.anchor * ways[instance].turn * (1.0 - tracks[index].contact);
    let away = sqrt(math_dot(way, way)) / max(targets[vertex].normal_rest.w, LEAST_AWAY);
    let drawn = carried + way * (anchor + max(LOST_PULL - anchor, 0.0) * clamp(away - 1.0, 0.0, 1.0));
    positions[index] = vec4<f32>(select(drawn, linear, math_not_finite(math_dot(drawn, drawn))), 1.0);
}
