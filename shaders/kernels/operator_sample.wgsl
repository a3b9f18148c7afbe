// Operators on given pairs of samples: gradients in xyz, values in w. One thread per pair.

override CLEAN_UNION: u32;

@group(0) @binding(0) var<uniform> params: OperatorParams;
@group(0) @binding(1) var<storage, read> curves: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> left: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> right: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> samples: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = dispatch_index(group, workgroups, local);
    if index >= params.count {
        return;
    }
    let a = Sample(left[index].w, left[index].xyz);
    let b = Sample(right[index].w, right[index].xyz);
    var found: Sample;
    if params.joint.profile == CLEAN_UNION {
        found = clean_union(a, b);
    } else {
        found = joint_join(a, b, params.joint);
    }
    samples[index] = vec4<f32>(found.gradient, found.value);
}
