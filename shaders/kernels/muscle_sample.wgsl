// The largest of one instance's muscles' fields at given points of their own space: gradient in xyz where it is wanted,
// value in w. Every segment of every muscle is looked at. One thread per four points.

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
    let begin = 4u * dispatch_index(group, workgroups, local);
    if begin >= params.point_count {
        return;
    }
    let last = params.point_count - 1u;
    let at = min(vec4<u32>(begin, begin + 1u, begin + 2u, begin + 3u), vec4<u32>(last));
    let q = transpose(mat4x4<f32>(points[at.x], points[at.y], points[at.z], points[at.w]));
    var best = array<vec4<f32>, 4>();
    for (var m = 0u; m < params.muscle_count; m++) {
        let muscle = muscles[m];
        if muscle.present == 0u {
            continue;
        }
        let nearest = muscle_nearest_four(muscle.first_point, muscle.segments, q[0], q[1], q[2]);
        if all(nearest.squared > vec4<f32>(muscle.lowest.w)) {
            continue;
        }
        for (var k = 0u; k < 4u; k++) {
            if nearest.squared[k] > muscle.lowest.w {
                continue;
            }
            let point = vec3<f32>(q[0][k], q[1][k], q[2][k]);
            let sample = muscle_near(muscle, muscle.first_point, nearest.segment[k], point);
            if sample.value > best[k].w {
                best[k] = vec4<f32>(sample.gradient, sample.value);
            }
        }
    }
    for (var k = 0u; k < 4u; k++) {
        if begin + k < params.point_count {
            samples[begin + k] = vec4<f32>(select(vec3<f32>(0.0), best[k].xyz, params.gradients != 0u), best[k].w);
        }
    }
}
