// The frames through which vertices see the groups of their reaches. One thread per reach of every instance.

@group(0) @binding(0) var<uniform> params: TrackParams;
@group(0) @binding(1) var<storage, read> joints: array<TrackJoint>;
@group(0) @binding(2) var<storage, read> ways: array<Way>;
@group(0) @binding(3) var<storage, read> reaches: array<Reach>;
@group(0) @binding(4) var<storage, read> blends: array<Influence>;
@group(0) @binding(5) var<storage, read_write> places: array<Place>;

override NO_JOINT: u32;
override OPEN_FROM: f32;
override OPEN_RANGE: f32;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = dispatch_index(group, workgroups, local);
    if index >= params.reach_count * params.instance_count {
        return;
    }
    let instance = index / params.reach_count;
    if params.sub_pose >= ways[instance].count {
        return;
    }
    let reach = reaches[index - instance * params.reach_count];
    let first = (params.sub_pose * params.instance_count + instance) * params.joint_count;
    var matrix = mat4x4<f32>();
    for (var i = reach.blend_begin; i < reach.blend_end; i++) {
        matrix += joints[first + blends[i].joint].matrix * blends[i].weight;
    }
    if reach.other != NO_JOINT {
        var share = reach.share;
        if reach.gate != NO_JOINT {
            let swing = joints[first + reach.gate].swing;
            let towards = math_dot(reach.side.xyz, swing.xyz);
            share *= math_smoothstep((OPEN_FROM - towards) / OPEN_RANGE) * swing.w;
        }
        matrix += (joints[first + reach.other].matrix - matrix) * share;
    }
    places[index].to_rest = inverse_affine(matrix).matrix;
    places[index].group = reach.group;
    places[index].limit = reach.limit;
    places[index].join = reach.join;
}
