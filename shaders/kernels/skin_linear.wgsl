// Linear blend skinning: v' = sum w_i M_i v. One thread per vertex of every instance.

@group(0) @binding(0) var<uniform> params: VertexParams;
@group(0) @binding(1) var<storage, read> joints: array<JointFrame>;
@group(0) @binding(2) var<storage, read> positions_rest: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> offsets: array<u32>;
@group(0) @binding(4) var<storage, read> influences: array<Influence>;
@group(0) @binding(5) var<storage, read_write> skinned: array<vec4<f32>>;

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
    let first_joint = instance * params.joint_count;
    var m0 = vec4<f32>(0.0);
    var m1 = vec4<f32>(0.0);
    var m2 = vec4<f32>(0.0);
    var m3 = vec4<f32>(0.0);
    for (var i = offsets[vertex]; i < offsets[vertex + 1u]; i++) {
        let influence = influences[i];
        let joint = first_joint + influence.joint;
        m0 += joints[joint].matrix[0] * influence.weight;
        m1 += joints[joint].matrix[1] * influence.weight;
        m2 += joints[joint].matrix[2] * influence.weight;
        m3 += joints[joint].matrix[3] * influence.weight;
    }
    let p = positions_rest[vertex];
    let posed = m0 * p.x + m1 * p.y + m2 * p.z + m3;
    skinned[index] = vec4<f32>(posed.xyz, 1.0);
}
