// Dual quaternion skinning after a first linear pass of the joints' stretch. One thread per vertex of every instance.

@group(0) @binding(0) var<uniform> params: VertexParams;
@group(0) @binding(1) var<storage, read> joints: array<JointFrame>;
@group(0) @binding(2) var<storage, read> positions_rest: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> offsets: array<u32>;
@group(0) @binding(4) var<storage, read> influences: array<Influence>;
@group(0) @binding(5) var<storage, read_write> skinned: array<vec4<f32>>;

fn dot4(a: vec4<f32>, b: vec4<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}

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
    let rest = positions_rest[vertex].xyz;
    let begin = offsets[vertex];
    let end = offsets[vertex + 1u];
    if begin == end {
        skinned[index] = vec4<f32>(rest, 1.0);
        return;
    }
    // The strongest influence comes first: every other rotation is taken in its hemisphere.
    let pivot = joints[first_joint + influences[begin].joint].real;
    var real = vec4<f32>(0.0);
    var dual = vec4<f32>(0.0);
    var p = vec3<f32>(0.0);
    for (var i = begin; i < end; i++) {
        let influence = influences[i];
        let joint = first_joint + influence.joint;
        let signed = select(influence.weight, -influence.weight, dot4(joints[joint].real, pivot) < 0.0);
        real += joints[joint].real * signed;
        dual += joints[joint].dual * signed;
        p += math_transform_point(joints[joint].stretch, rest) * influence.weight;
    }
    let length = sqrt(dot4(real, real));
    real = real / length;
    dual = dual / length;
    let r = real.xyz;
    let d = dual.xyz;
    let turned = cross(r, cross(r, p) + p * real.w);
    let moved = d * real.w - r * dual.w + cross(r, d);
    skinned[index] = vec4<f32>(p + turned * 2.0 + moved * 2.0, 1.0);
}
