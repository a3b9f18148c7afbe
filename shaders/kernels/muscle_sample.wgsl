// The largest of one instance's muscles' fields at given points of their own space: gradient in xyz where it is wanted,
// value in w. Every segment of every muscle is looked at. One thread per sixteen points, a workgroup apart: threads side by
// side have points side by side, which are in reach of the same muscles.

@group(0) @binding(0) var<uniform> params: UnionParams;
@group(0) @binding(1) var<storage, read> muscles: array<MuscleFrame>;
@group(0) @binding(2) var<storage, read> axes: array<AxisPoint>;
@group(0) @binding(3) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> samples: array<vec4<f32>>;

// Four points from `begin` on, coordinates in rows; the last point stands for those that are missing.
fn four_points(begin: u32) -> mat4x4<f32> {
    let wanted = vec4<u32>(begin) + DISPATCH_WORKGROUP * vec4<u32>(0u, 1u, 2u, 3u);
    let at = min(wanted, vec4<u32>(params.point_count - 1u));
    return transpose(mat4x4<f32>(points[at.x], points[at.y], points[at.z], points[at.w]));
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let begin = 16u * dispatch_index(group, workgroups, 0u) + local;
    if begin >= params.point_count {
        return;
    }
    let q = array<mat4x4<f32>, 4>(
        four_points(begin),
        four_points(begin + 4u * DISPATCH_WORKGROUP),
        four_points(begin + 8u * DISPATCH_WORKGROUP),
        four_points(begin + 12u * DISPATCH_WORKGROUP),
    );
    var best = array<vec4<f32>, 16>();
    for (var m = 0u; m < params.muscle_count; m++) {
        if muscles[m].present == 0u {
            continue;
        }
        let first = muscles[m].first_point;
        var keys = muscle_nearest_sixteen(first, muscles[m].segments, q);
        var left = nearest_within(keys, muscles[m].lowest.w);
        if left == 0u {
            continue;
        }
        // Only points in reach take a turn: threads run together, and a turn that some threads have no use for takes as
        // long as one that all need.
        let muscle = muscles[m];
        loop {
            let k = firstTrailingBit(left);
            left &= left - 1u;
            let point = points[min(begin + k * DISPATCH_WORKGROUP, params.point_count - 1u)].xyz;
            let sample = muscle_near(muscle, first, nearest_of_key(keys[k / 4u][k % 4u]).segment, point);
            if sample.value > best[k].w {
                best[k] = vec4<f32>(sample.gradient, sample.value);
            }
            continuing {
                break if left == 0u;
            }
        }
    }
    for (var k = 0u; k < 16u; k++) {
        let at = begin + k * DISPATCH_WORKGROUP;
        if at < params.point_count {
            samples[at] = vec4<f32>(select(vec3<f32>(0.0), best[k].xyz, params.gradients != 0u), best[k].w);
        }
    }
}
