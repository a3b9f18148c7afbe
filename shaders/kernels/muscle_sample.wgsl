// The largest of one instance's muscles' fields at given points of their own space: gradient in xyz where it is wanted,
// value in w. Every segment of every muscle is looked at. One thread per point.

@group(0) @binding(0) var<uniform> params: UnionParams;
@group(0) @binding(1) var<storage, read> muscles: array<MuscleFrame>;
@group(0) @binding(2) var<storage, read> axes: array<AxisPoint>;
@group(0) @binding(3) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> samples: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = dispatch_index(group, workgroups, local);
    if index >= params.point_count {
        return;
    }
    let q = points[index].xyz;
    var best = Sample(0.0, vec3<f32>(0.0));
    for (var m = 0u; m < params.muscle_count; m++) {
        let sample = muscle_evaluate(muscles[m], 0u, q);
        if sample.value > best.value {
            best = sample;
        }
    }
    samples[index] = vec4<f32>(select(vec3<f32>(0.0), best.gradient, params.gradients != 0u), best.value);
}
