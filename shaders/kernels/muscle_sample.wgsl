// The largest of one instance's muscles' fields at given points of their own space: gradient in xyz where it is wanted,
// value in w. Every segment of every muscle is looked at. One thread per eight points.

@group(0) @binding(0) var<uniform> params: UnionParams;
@group(0) @binding(1) var<storage, read> muscles: array<MuscleFrame>;
@group(0) @binding(2) var<storage, read> axes: array<AxisPoint>;
@group(0) @binding(3) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> samples: array<vec4<f32>>;

// Four points from `begin` on, coordinates in rows; the last point stands for those that are missing.
fn four_points(begin: u32) -> mat4x4<f32> {
    let at = min(vec4<u32>(begin) + vec4<u32>(0u, 1u, 2u, 3u), vec4<u32>(params.point_count - 1u));
    return transpose(mat4x4<f32>(points[at.x], points[at.y], points[at.z], points[at.w]));
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let begin = 8u * dispatch_index(group, workgroups, local);
    if begin >= params.point_count {
        return;
    }
    let q_0 = four_points(begin);
    let q_1 = four_points(begin + 4u);
    var best = array<vec4<f32>, 8>();
    for (var m = 0u; m < params.muscle_count; m++) {
        if muscles[m].present == 0u {
            continue;
        }
        let first = muscles[m].first_point;
        let reach = muscles[m].lowest.w;
        let keys = muscle_nearest_eight(first, muscles[m].segments, q_0, q_1);
        if all(min(keys.four_0, keys.four_1) > vec4<u32>(bitcast<u32>(reach))) {
            continue;
        }
        let muscle = muscles[m];
        for (var k = 0u; k < 8u; k++) {
            let nearest = nearest_of_key(select(keys.four_0[k & 3u], keys.four_1[k & 3u], k > 3u));
            if nearest.squared > reach {
                continue;
            }
            let point = points[min(begin + k, params.point_count - 1u)].xyz;
            let sample = muscle_near(muscle, first, nearest.segment, point);
            if sample.value > best[k].w {
                best[k] = vec4<f32>(sample.gradient, sample.value);
            }
        }
    }
    for (var k = 0u; k < 8u && begin + k < params.point_count; k++) {
        samples[begin + k] = vec4<f32>(select(vec3<f32>(0.0), best[k].xyz, params.gradients != 0u), best[k].w);
    }
}
