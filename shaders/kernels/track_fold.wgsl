// How much folding joints displace, so that their groups keep their volume (prototypes 5, the closed loop). One workgroup
// per fold of every instance.

@group(0) @binding(0) var<uniform> params: TrackParams;
@group(0) @binding(1) var<storage, read> ways: array<Way>;
@group(0) @binding(2) var<storage, read> joints: array<TrackJoint>;
@group(0) @binding(3) var<storage, read> patches: array<FoldPatch>;
@group(0) @binding(4) var<storage, read> triangles: array<FoldTriangle>;
@group(0) @binding(5) var<storage, read> positions_rest: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> positions: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> groups: array<GroupFrame>;
@group(0) @binding(8) var<storage, read_write> offsets: array<f32>;

override LANES: u32;
override GAIN: f32;
override LEAST_WEIGHT: f32;

// Per thread: volume, and what an offset of a metre would add to it.
var<workgroup> sums: array<vec2<f32>, 64>;

// An end of a fold as if its offset were a metre.
fn unit_end(fold: Fold) -> Fold {
    var unit = fold;
    unit.offset = 1.0;
    return unit;
}

fn measured(triangle: FoldTriangle, first: u32, centre: vec3<f32>, parent: Fold, child: Fold) -> vec2<f32> {
    let a = positions[first + triangle.a].xyz - centre;
    let b = positions[first + triangle.b].xyz - centre;
    let c = positions[first + triangle.c].xyz - centre;
    let across = math_cross(b - a, c - a);
    let area = 0.5 * sqrt(math_dot(across, across));
    let middle =
        (positions_rest[triangle.a].xyz + positions_rest[triangle.b].xyz + positions_rest[triangle.c].xyz) * (1.0 / 3.0);
    var lift = fold_lift(child, middle).w;
    if triangle.of_parent != 0u {
        lift = fold_lift(parent, middle).w;
    }
    return vec2<f32>(math_dot(a, math_cross(b, c)) * (1.0 / 6.0), -area * lift);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    // All threads meet at the barriers: workgroups beyond the last fold have it once more, and for nothing.
    let item = group.y * workgroups.x + group.x;
    let index = min(item, params.fold_count * params.instance_count - 1u);
    let instance = index / params.fold_count;
    let around = patches[index - instance * params.fold_count];
    let slot = params.sub_pose * params.instance_count + instance;
    let parent = slot * params.group_count + around.parent;
    let child = slot * params.group_count + around.child;
    let moves = params.projects == 0u && params.sub_pose < ways[instance].count;
    let parent_end = unit_end(groups[parent].fold_end);
    let child_end = unit_end(groups[child].fold_start);
    let centre = math_transform_point(joints[slot * params.joint_count + around.joint].matrix, around.origin.xyz);
    var sum = vec2<f32>(0.0);
    if moves {
        for (var k = around.begin + lane; k < around.end; k += LANES) {
            sum += measured(triangles[k], instance * params.vertex_count, centre, parent_end, child_end);
        }
    }
    sums[lane] = sum;
    workgroupBarrier();
    for (var half = LANES / 2u; half > 0u; half /= 2u) {
        if lane < half {
            sums[lane] += sums[lane + half];
        }
        workgroupBarrier();
    }
    if lane > 0u || item > index {
        return;
    }
    var offset = offsets[index];
    if moves && sums[0].y > LEAST_WEIGHT {
        let wanted = offset + GAIN * (around.volume_rest - sums[0].x) / sums[0].y;
        offset = clamp(wanted, 0.0, groups[child].fold_start.most);
    }
    offsets[index] = offset;
    groups[child].fold_start.offset = offset;
    groups[parent].fold_end.offset = offset;
}
