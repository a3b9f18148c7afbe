// Joints at the end of a substep, and what they add to points that they carry. One thread per joint of every instance.

@group(0) @binding(0) var<uniform> params: DynamicsParams;
@group(0) @binding(1) var<storage, read> clocks: array<StepClock>;
@group(0) @binding(2) var<storage, read> joints_before: array<JointFrame>;
@group(0) @binding(3) var<storage, read> joints: array<JointFrame>;
@group(0) @binding(4) var<storage, read_write> moved: array<MovedJoint>;


fn share_of(clock: StepClock, turn: u32) -> f32 {
    return select(clock.first + clock.step * (f32(turn) - 1.0), 0.0, turn == 0u);
}

fn retention_of(clock: StepClock) -> f32 {
    if clock.turn < clock.settling {
        return 0.0;
    }
    let age = f32(clock.age + clock.turn - clock.settling);
    return clock.full_retention * min(age / f32(max(clock.fade, 1u)), 1.0);
}

// A vector turned by a unit quaternion.
fn rotate(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = math_cross(q.xyz, v) * 2.0;
    return v + t * q.w + math_cross(q.xyz, t);
}

// The matrix at a share of the way: rotation by the shorter way, translation and stretch straight.
fn between(before: JointFrame, now: JointFrame, share: f32) -> mat4x4<f32> {
    let a0 = before.matrix;
    let b0 = now.matrix;
    let still = all(a0[0] == b0[0]) && all(a0[1] == b0[1]) && all(a0[2] == b0[2]) && all(a0[3] == b0[3]);
    if share <= 0.0 || still {
        return before.matrix;
    }
    if share >= 1.0 {
        return now.matrix;
    }
    let rest = 1.0 - share;
    let a = before.real;
    let b = now.real;
    let sign = select(share, -share, a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w < 0.0);
    let sum = a * rest + b * sign;
    let q = sum / sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z + sum.w * sum.w);
    return mat4x4<f32>(
        vec4<f32>(rotate(q, (before.stretch[0] * rest + now.stretch[0] * share).xyz), 0.0),
        vec4<f32>(rotate(q, (before.stretch[1] * rest + now.stretch[1] * share).xyz), 0.0),
        vec4<f32>(rotate(q, (before.stretch[2] * rest + now.stretch[2] * share).xyz), 0.0),
        before.matrix[3] * rest + now.matrix[3] * share,
    );
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = dispatch_index(group, workgroups, local);
    if index >= params.joint_count * params.instance_count {
        return;
    }
    let clock = clocks[index / params.joint_count];
    let carries = params.carries != 0u;
    let turn = min(clock.turn, clock.turns);
    let start_share = share_of(clock, turn);
    let end_share = select(share_of(clock, turn + 1u), 1.0, carries);
    let before = joints_before[index];
    let now = joints[index];
    let start = between(before, now, start_share);
    let matrix = between(before, now, end_share);
    let back = inverse_affine(start);
    let change = mat4x4<f32>(matrix[0] - start[0], matrix[1] - start[1], matrix[2] - start[2], matrix[3] - start[3]);
    var out = MovedJoint();
    out.matrix = matrix;
    out.carry = math_product(change, back.matrix);
    out.to_rest = inverse_affine(matrix).matrix;
    out.scale = math_cube_root(abs(back.volume));
    out.runs = select(0u, 1u, carries || clock.turn < clock.turns);
    out.retention = retention_of(clock);
    out.carries = params.carries;
    moved[index] = out;
}
