// One muscle against its springs, neighbours, bones and skin, in one outer iteration. One workgroup per muscle of every
// instance; a thread has pairs of neighbouring particles, and the two segments that begin at each pair.

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
override STRIDE: u32;

fn load(work: Work, i: u32, scale: f32) {
    let particle = particles[work.first + i];
    let size = iterates[work.read + 2u + 2u * i];
    at[i] = vec4<f32>(size.xyz, particle.velocity.w);
    pull[i] = vec4<f32>(particle.spring.xyz, particle.spring.w * scale);
    held[i] = Held(
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
fn finish(work: Work, i: u32) {
    var particle = particles[work.first + i];
    let from_carry = moved[work.place.joint + work.body.origin_joint].carry;
    let to_carry = moved[work.place.joint + work.body.insertion_joint].carry;
    let before = particle.position.xyz;
    let displaced =
        math_transform_point(from_carry, before) * (1.0 - held[i].share) + math_transform_point(to_carry, before) * held[i].share;
    var relative = at[i].xyz - before - displaced;
    var now = at[i].xyz;
    let pressed = held[i].pushes.x > 0.0 || held[i].pushes.y > 0.0;
    if pressed && sqrt(math_dot(relative, relative)) < params.deadband {
        relative = vec3<f32>(0.0);
        now = before + displaced;
    }
    for (var kind = 0u; kind < 3u; kind++) {
        let normal = held[i].planes[kind].xyz;
        let depth = held[i].pushes[kind] * at[i].w;
        let along = relative - normal * math_dot(relative, normal);
        let way = sqrt(math_dot(along, along));
        if depth > 0.0 && way > 0.0 {
            relative -= along * min(params.friction * depth / way, 1.0);
        }
    }
    particles[work.first + i].position = vec4<f32>(now, particle.position.w);
    particles[work.first + i].velocity = vec4<f32>((displaced + relative) / params.seconds, particle.velocity.w);
}

// The final contact passes; what one of them has not moved, the next one would not move either.
fn settle(work: Work, i: u32) {
    for (var k = 0u; k < params.final_passes; k++) {
        let before = at[i].xyz;
        hold_settle(work, i);
        if all(at[i].xyz == before) {
            break;
        }
    }
}

// Both particles of a pair against their planes.
fn hold_pair(i: u32, last: u32) {
    for (var j = max(i, 1u); j < min(i + 2u, last); j++) {
        if params.jacobi != 0u {
            chain_hold_averaged(j);
        } else {
            chain_hold(j);
        }
    }
}

fn store(work: Work, i: u32, write: u32) {
    if params.ends_substep != 0u && i > 0u && i < work.body.segments {
        settle(work, i);
    }
    iterates[write + 2u + 2u * i] = vec4<f32>(at[i].xyz, held[i].radius);
    iterates[write + 3u + 2u * i] = iterates[work.read + 3u + 2u * i];
    particles[work.first + i].spring = vec4<f32>(pull[i].xyz, particles[work.first + i].spring.w);
    particles[work.first + i].pushes = held[i].pushes;
    if params.ends_substep != 0u {
        finish(work, i);
    }
}

@compute @workgroup_size(16)
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
    let last = body.segments;
    // Its pairs begin at `begin`, `begin + STRIDE` and so on.
    let begin = 2u * local;
    for (var i = begin; i <= last; i += STRIDE) {
        load(work, i, scale);
        if i < last {
            load(work, i + 1u, scale);
        }
    }
    workgroupBarrier();
    for (var i = begin; i < last; i += STRIDE) {
        gains[i] = gain_of(work, i);
        hold_planes(work, i);
        if i + 1u < last {
            gains[i + 1u] = gain_of(work, i + 1u);
            hold_planes(work, i + 1u);
        }
    }
    workgroupBarrier();
    let radius_squared = iterates[work.read + 1u].w;
    var relaxation = 1.0;
    for (var k = 0u; k < 2u * params.done; k++) {
        relaxation = chain_relaxation(relaxation, radius_squared);
    }
    for (var k = 0u; k < params.inner; k++) {
        if params.jacobi != 0u {
            for (var i = begin; i <= last; i += STRIDE) {
                chain_average(i, last);
                chain_average(min(i + 1u, last), last);
            }
            workgroupBarrier();
            for (var i = begin; i <= last; i += STRIDE) {
                chain_apply(i);
                if i < last {
                    chain_apply(i + 1u);
                }
                hold_pair(i, last);
            }
            workgroupBarrier();
        } else {
            for (var i = begin; i < last; i += STRIDE) {
                chain_project(i, relaxation);
            }
            relaxation = chain_relaxation(relaxation, radius_squared);
            workgroupBarrier();
            for (var i = begin + 1u; i < last; i += STRIDE) {
                chain_project(i, relaxation);
            }
            relaxation = chain_relaxation(relaxation, radius_squared);
            workgroupBarrier();
            for (var i = begin; i < last; i += STRIDE) {
                hold_pair(i, last);
            }
        }
    }
    if local == 0u {
        iterates[write] = iterates[work.read];
        iterates[write + 1u] = iterates[work.read + 1u];
    }
    for (var i = begin; i <= last; i += STRIDE) {
        store(work, i, write);
        if i < last {
            store(work, i + 1u, write);
        }
    }
}
