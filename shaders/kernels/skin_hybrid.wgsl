// Linear skinning by bones and by muscles (paper B, equation 3). One thread per vertex of every instance.

@group(0) @binding(0) var<uniform> params: WeightedParams;
@group(0) @binding(1) var<storage, read> joints: array<JointFrame>;
@group(0) @binding(2) var<storage, read> muscle_joints: array<mat4x4<f32>>;
@group(0) @binding(3) var<storage, read> positions_rest: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> offsets: array<u32>;
@group(0) @binding(5) var<storage, read> influences: array<Influence>;
@group(0) @binding(6) var<storage, read_write> skinned: array<vec4<f32>>;

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
    let p = positions_rest[vertex];
    var posed = vec4<f32>(0.0);
    for (var i = offsets[vertex]; i < offsets[vertex + 1u]; i++) {
        let influence = influences[i];
        var m: mat4x4<f32>;
        if influence.joint < params.joint_count {
            m = joints[instance * params.joint_count + influence.joint].matrix;
        } else {
            m = muscle_joints[instance * params.point_count + influence.joint - params.joint_count];
        }
        posed += (m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3]) * influence.weight;
    }
    skinned[index] = vec4<f32>(posed.xyz, 1.0);
}
