// One muscle against its springs, neighbours, bones and skin, in one outer iteration. One workgroup per muscle of every
// instance; a thread has two particles, and the two segments that begin at them.

@group(0) @binding(0) var<uniform> params: DynamicsParams;
@group(0) @binding(1) var<storage, read> bodies: array<MuscleBody>;
@group(0) @binding(2) var<storage, read> bones: array<BoneRest>;
@group(0) @binding(3) var<storage, read> links: array<Link>;
@group(0) @binding(4) var<storage, read> moved: array<MovedJoint>;
@group(0) @binding(5) var<storage, read> groups: array<GroupFrame>;
@group(0) @binding(6) var<storage, read> nodes: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> particles: array<Particle>;
@group(0) @binding(8) var<storage, read_write> iterates: array<vec4<f32>>;

override MOST_STIFFNESS: f32;

fn loaded(work: Work, i: u32, scale: f32) -> Held {
    let particle = particles[work.first + i];
    let size = iterates[work.read + 2u + 2u * i];
    at[i] = vec4<f32>(size.xyz, particle.velocity.w);
    pull[i] = vec4<f32>(particle.spring.xyz, particle.spring.w * scale);
    return Held(
        array<vec4<f32>, 4>(),
        particle.pushes,
        size.w,
        particle.traits.x,
        f32(i) / f32(work.body.segments),
    );
}

fn gain_of(work: Work, j: u32) -> f32 {
    let stiffer = particles[work.first + j].traits.y;
    let mobility = at[j].w + at[j + 1u].w;
    let stiffness = iterates[work.read].w;
    if params.pbd != 0u {
        return min(stiffness * stiffer, MOST_STIFFNESS) / mobility;
    }
    return 1.0 / (mobility + stiffness / stiffer);
}

// New place and velocity: the displacement less what friction takes, and none below the deadband for a particle that
// presses against a muscle.
fn finish(work: Work, held: Held, i: u32) {
    var particle = particles[work.first + i];
    let from_carry = moved[work.place.joint + work.body.origin_joint].carry;
    let to_carry = moved[work.place.joint + work.body.insertion_joint].carry;
    let before = particle.position.xyz;
    let displaced =
        math_transform_point(from_carry, before) * (1.0 - held.share) + math_transform_point(to_carry, before) * held.share;
    var relative = at[i].xyz - before - displaced;
    var now = at[i].xyz;
    let pressed = held.pushes.x > 0.0 || held.pushes.y > 0.0;
    if pressed && sqrt(math_dot(relative, relative)) < params.deadband {
        relative = vec3<f32>(0.0);
        now = before + displaced;
    }
    for (var kind = 0u; kind < 3u; kind++) {
        let normal = held.planes[kind].xyz;
        let depth = held.pushes[kind] * at[i].w;
        let along = relative - normal * math_dot(relative, normal);
        let way = sqrt(math_dot(along, along));
        if depth > 0.0 && way > 0.0 {
            relative -= along * min(params.friction * depth / way, 1.0);
        }
    }
    particles[work.first + i].position = vec4<f32>(now, particle.position.w);
    particles[work.first + i].velocity = vec4<f32>((displaced + relative) / params.seconds, particle.velocity.w);
}

fn store(work: Work, held: Held, i: u32, write: u32) {
    iterates[write + 2u + 2u * i] = vec4<f32>(at[i].xyz, held.radius);
    iterates[write + 3u + 2u * i] = iterates[work.read + 3u + 2u * i];
    particles[work.first + i].spring = vec4<f32>(pull[i].xyz, particles[work.first + i].spring.w);
    particles[work.first + i].pushes = held.pushes;
    if params.ends_substep != 0u {
        finish(work, held, i);
    }
}

@compute @workgroup_size(32)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = group.y * workgroups.x + group.x;
    if index >= params.muscle_count * params.instance_count {
        return;
    }
    let instance = index / params.muscle_count;
    let own = index - instance * params.muscle_count;
    let body = bodies[own];
    let joint = instance * params.joint_count;
    if moved[joint + body.driver].runs == 0u {
        return;
    }
    let work = Work(
        TouchPlace(joint, instance * params.group_count, instance),
        body,
        dynamics_run(instance, own, body.first_point, params.from_half),
        instance * params.point_count + body.first_point,
        params.contacts & body.collides,
    );
    let write = dynamics_run(instance, own, body.first_point, 1u - params.from_half);
    let scale = moved[joint + body.driver].scale;
    let i0 = 2u * local;
    let i1 = i0 + 1u;
    var held_0 = Held();
    var held_1 = Held();
    if i0 <= body.segments {
        held_0 = loaded(work, i0, scale);
    }
    if i1 <= body.segments {
        held_1 = loaded(work, i1, scale);
    }
    workgroupBarrier();
    if i0 < body.segments {
        gains[i0] = gain_of(work, i0);
    }
    if i1 < body.segments {
        gains[i1] = gain_of(work, i1);
    }
    hold_planes(work, &held_0, i0);
    hold_planes(work, &held_1, i1);
    workgroupBarrier();
    let moves_0 = i0 > 0u && i0 < body.segments;
    let moves_1 = i1 < body.segments;
    let radius_squared = iterates[work.read + 1u].w;
    var relaxation = 1.0;
    for (var k = 0u; k < 2u * params.done; k++) {
        relaxation = chain_relaxation(relaxation, radius_squared);
    }
    for (var k = 0u; k < params.inner; k++) {
        if params.jacobi != 0u {
            chain_average(i0, body.segments);
            chain_average(i1, body.segments);
            workgroupBarrier();
            chain_apply(i0);
            chain_apply(i1);
            if moves_0 {
                chain_hold_averaged(&held_0, i0);
            }
            if moves_1 {
                chain_hold_averaged(&held_1, i1);
            }
            workgroupBarrier();
        } else {
            if i0 < body.segments {
                chain_project(i0, relaxation);
            }
            relaxation = chain_relaxation(relaxation, radius_squared);
            workgroupBarrier();
            if moves_1 {
                chain_project(i1, relaxation);
            }
            relaxation = chain_relaxation(relaxation, radius_squared);
            workgroupBarrier();
            if moves_0 {
                chain_hold(&held_0, i0);
            }
            if moves_1 {
                chain_hold(&held_1, i1);
            }
        }
    }
    if params.ends_substep != 0u {
        for (var k = 0u; k < params.final_passes; k++) {
            if moves_0 {
                hold_settle(work, &held_0, i0);
            }
            if moves_1 {
                hold_settle(work, &held_1, i1);
            }
        }
    }
    if local == 0u {
        iterates[write] = iterates[work.read];
        iterates[write + 1u] = iterates[work.read + 1u];
    }
    if i0 <= body.segments {
        store(work, held_0, i0, write);
    }
    if i1 <= body.segments {
        store(work, held_1, i1, write);
    }
}
