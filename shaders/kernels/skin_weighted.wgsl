// Skinned vertices displaced to the rest iso-value of their muscles' union, by weights (paper A, section 8.7). One thread per
// vertex of every instance.

@group(0) @binding(0) var<uniform> params: WeightedParams;
@group(0) @binding(1) var<storage, read> joints: array<JointFrame>;
@group(0) @binding(2) var<storage, read> muscles: array<MuscleFrame>;
@group(0) @binding(3) var<storage, read> axes: array<AxisPoint>;
@group(0) @binding(4) var<storage, read> targets: array<WeightTarget>;
@group(0) @binding(5) var<storage, read> weights: array<MuscleWeight>;
@group(0) @binding(6) var<storage, read> skinned: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> displaced: array<vec4<f32>>;

override STEPS: u32;
override TOLERANCE: f32;
override LONGEST: f32;
override LEAST_SLOPE: f32;
override HELD: f32;
override LEFT: f32;
override FACING: f32;
override NO_JOINT: u32;
override WIDENED: f32;

// What a vertex's muscles make of one point.
struct Pull {
    value: f32,
    gradient: vec3<f32>,
    inward: vec3<f32>,
    weight: f32,
    reach: f32,
}

fn pull_with(a: Pull, b: Pull) -> Pull {
    var big = a;
    var small = b;
    if b.value > a.value {
        big = b;
        small = a;
    }
    let by = clean_values(big.value, small.value);
    let sum = by.y + by.z;
    let share = select(0.0, by.z / sum, sum > 0.0);
    return Pull(
        by.x,
        big.gradient * by.y + small.gradient * by.z,
        big.inward + (small.inward - big.inward) * share,
        big.weight + (small.weight - big.weight) * share,
        big.reach,
    );
}

// How far the gradient leads the way that it did at rest.
fn pull_facing(found: Pull) -> f32 {
    let squared = math_dot(found.gradient, found.gradient);
    let share = math_smoothstep(math_dot(found.gradient, found.inward) / (sqrt(squared) * FACING));
    return select(0.0, share, squared > 0.0);
}

// The way inward: along the gradient where this leads the way that it did at rest.
fn pull_direction(found: Pull) -> vec3<f32> {
    let squared = math_dot(found.gradient, found.gradient);
    var blend = found.inward;
    if squared > 0.0 {
        let unit = found.gradient / sqrt(squared);
        let facing = math_smoothstep(math_dot(unit, found.inward) / FACING);
        blend = found.inward * (1.0 - facing) + unit * facing;
    }
    return blend / sqrt(math_dot(blend, blend));
}

// A muscle with the same surface and a wider support.
fn widened(narrow: MuscleFrame) -> MuscleFrame {
    var muscle = narrow;
    let more = (WIDENED - 1.0) * muscle.support_radius;
    let reach = sqrt(muscle.lowest.w) + more;
    muscle.support_radius += more;
    muscle.lowest = vec4<f32>(muscle.lowest.xyz - more, reach * reach);
    muscle.highest = vec4<f32>(muscle.highest.xyz + more, 0.0);
    return muscle;
}

// The union at a posed point; the instance's first joint, muscle and axis point.
fn pull(goal: WeightTarget, first: vec3<u32>, p_posed: vec3<f32>) -> Pull {
    var found = Pull(0.0, vec3<f32>(0.0), vec3<f32>(0.0), 0.0, 0.0);
    var joint = NO_JOINT;
    var inverse = mat4x4<f32>();
    var scale = 1.0;
    var p_rest = p_posed;
    for (var k = goal.begin; k < goal.end; k++) {
        let own = weights[k];
        if own.joint != joint {
            joint = own.joint;
            let back = inverse_affine(joints[first.x + joint].matrix);
            inverse = back.matrix;
            scale = math_cube_root(abs(back.volume));
            p_rest = math_transform_point(inverse, p_posed);
        }
        let muscle = widened(muscles[first.y + own.muscle]);
        if any(p_rest < muscle.lowest.xyz) || any(p_rest > muscle.highest.xyz) {
            continue;
        }
        let sample = muscle_evaluate(muscle, first.z, p_rest);
        if sample.value > 0.0 {
            let gradient = math_transpose_vector(inverse, sample.gradient);
            let turned = math_transpose_vector(inverse, own.inward.xyz);
            let inward = turned / sqrt(math_dot(turned, turned));
            found = pull_with(found, Pull(sample.value, gradient, inward, own.weight, muscle.support_radius * scale));
        }
    }
    return found;
}

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
    let goal = targets[index - instance * params.vertex_count];
    let start = skinned[index];
    if goal.begin >= goal.end {
        displaced[index] = start;
        return;
    }
    let first = instance * vec3<u32>(params.joint_count, params.muscle_count, params.point_count);
    var p = start.xyz;
    var found = pull(goal, first, p);
    var hold = math_smoothstep((found.value / goal.iso - LEFT) / (HELD - LEFT));
    // What has come out of a muscle's back cannot be drawn to it.
    if found.value < goal.iso {
        hold *= pull_facing(found);
    }
    let gap = abs(found.value - goal.iso);
    var longest = LONGEST * found.reach;
    var before = 0.0;
    for (var k = 0u; k < STEPS; k++) {
        let gap = found.value - goal.iso;
        if abs(gap) < TOLERANCE || found.value <= 0.0 {
            break;
        }
        let wanted = -gap / max(sqrt(math_dot(found.gradient, found.gradient)), LEAST_SLOPE);
        // A step back over the surface halves the longest one.
        if wanted * before < 0.0 {
            longest = 0.5 * abs(before);
        }
        before = clamp(wanted, -longest, longest);
        p += pull_direction(found) * before;
        found = pull(goal, first, p);
    }
    // Who cannot get there stays.
    let arrived = 1.0 - min(abs(found.value - goal.iso) / max(gap, TOLERANCE), 1.0);
    let moved = start.xyz + (p - start.xyz) * (found.weight * hold * arrived);
    displaced[index] = select(vec4<f32>(moved, 1.0), start, math_not_finite(math_dot(moved, moved)));
}
