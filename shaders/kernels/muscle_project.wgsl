// Muscles against their springs, neighbours, bones and skin, in one outer iteration. One workgroup has one muscle, or
// several short ones; a thread has two neighbouring particles, the segment between them, and those that lead on from them.

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
override ENDS: bool;

// Points beyond the muscle's end are copies of the last one.
fn load(work: Work, point: u32) -> Bead {
    let i = min(point, work.body.segments);
    let particle = particles[work.first + i];
    let size = iterates[work.read + 2u + 2u * i];
    let mobility = particle.velocity.w;
    return Bead(
        size.xyz,
        mobility,
        select(0.0, 1.0 / mobility, mobility > 0.0),
        size.w,
        particle.traits.x,
        f32(i) / f32(work.body.segments),
        vec4<f32>(0.0),
        vec4<f32>(0.0),
        vec4<f32>(0.0),
        vec4<f32>(0.0),
        particle.pushes,
    );
}

// The segment that begins at point j; a zero one where there is none.
fn segment(work: Work, j: u32, scale: f32) -> Spring {
    if j >= work.body.segments {
        return Spring(vec3<f32>(0.0), 0.0, 0.0, 0.0);
    }
    let spring = particles[work.first + j].spring;
    let stiffer = particles[work.first + j].traits.y;
    let stiffness = iterates[work.read].w;
    let mobility = particles[work.first + j].velocity.w + particles[work.first + j + 1u].velocity.w;
    var gain = 1.0 / (mobility + stiffness / stiffer);
    if params.pbd != 0u {
        gain = min(stiffness * stiffer, MOST_STIFFNESS) / mobility;
    }
    return Spring(spring.xyz, spring.w * scale, gain, mobility);
}

// What friction takes of a displacement along a plane.
fn rubbed(relative: vec3<f32>, plane: vec4<f32>, push: f32, mobility: f32) -> vec3<f32> {
    let normal = plane.xyz;
    let depth = push * mobility;
    let along = relative - normal * math_dot(relative, normal);
    let way = sqrt(math_dot(along, along));
    if depth > 0.0 && way > 0.0 {
        return relative - along * min(params.friction * depth / way, 1.0);
    }
    return relative;
}

// New place and velocity: the displacement less what friction takes, and none below the deadband for a particle that
// presses against a muscle.
fn finish(work: Work, i: u32, bead: Bead) {
    let particle = particles[work.first + i];
    let from_carry = moved[work.place.joint + work.body.origin_joint].carry;
    let to_carry = moved[work.place.joint + work.body.insertion_joint].carry;
    let before = particle.position.xyz;
    let displaced =
        math_transform_point(from_carry, before) * (1.0 - bead.share) + math_transform_point(to_carry, before) * bead.share;
    var relative = bead.p - before - displaced;
    var now = bead.p;
    let pressed = bead.pushes.x > 0.0 || bead.pushes.y > 0.0;
    if pressed && sqrt(math_dot(relative, relative)) < params.deadband {
        relative = vec3<f32>(0.0);
        now = before + displaced;
    }
    relative = rubbed(relative, bead.peer_0, bead.pushes.x, bead.mobility);
    relative = rubbed(relative, bead.peer_1, bead.pushes.y, bead.mobility);
    relative = rubbed(relative, bead.bone, bead.pushes.z, bead.mobility);
    particles[work.first + i].position = vec4<f32>(now, particle.position.w);
    particles[work.first + i].velocity = vec4<f32>((displaced + relative) / params.seconds, particle.velocity.w);
}

fn store(work: Work, i: u32, write: u32, bead: Bead, pull: vec3<f32>) {
    if i > work.body.segments {
        return;
    }
    iterates[write + 2u + 2u * i] = vec4<f32>(bead.p, bead.radius);
    iterates[write + 3u + 2u * i] = iterates[work.read + 3u + 2u * i];
    particles[work.first + i].spring = vec4<f32>(pull, particles[work.first + i].spring.w);
    particles[work.first + i].pushes = bead.pushes;
    if ENDS && params.ends_substep != 0u {
        finish(work, i, bead);
    }
}

@compute @workgroup_size(32)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = (group.y * workgroups.x + group.x) * CHAIN_THREADS + local;
    let slot = thread % params.threads_per_muscle;
    // All threads meet at the barriers: those beyond the last muscle have it once more, and for nothing.
    let last = params.muscle_count * params.instance_count - 1u;
    let index = min(thread / params.threads_per_muscle, last);
    let instance = index / params.muscle_count;
    let own = index - instance * params.muscle_count;
    let body = bodies[own];
    let joint = instance * params.joint_count;
    let work = Work(
        TouchPlace(joint, instance * params.group_count, instance),
        body,
        dynamics_run(instance, own, body.first_point, params.from_half),
        instance * params.point_count + body.first_point,
        params.contacts & body.collides & hold_kinds(body),
    );
    let i = 2u * slot;
    let idle = thread / params.threads_per_muscle > last || i > body.segments || moved[joint + body.driver].runs == 0u;
    var pair = Pair(load(work, i), load(work, i + 1u));
    let scale = moved[joint + body.driver].scale;
    var inner = segment(work, i, scale);
    // The segments to the neighbouring pairs: each of the two threads knows it, and changes it as the other one does.
    var before = Spring(vec3<f32>(0.0), 0.0, 0.0, 0.0);
    if i > 0u {
        before = segment(work, i - 1u, scale);
    }
    var after = segment(work, i + 1u, scale);
    // Neighbours have read what this thread writes from here on.
    storageBarrier();
    if !idle {
        pair = hold_planes(work, i, pair);
    }
    let radius_squared = iterates[work.read + 1u].w;
    var relaxation = 1.0;
    for (var k = 0u; k < 2u * params.done; k++) {
        relaxation = chain_relaxation(relaxation, radius_squared);
    }
    for (var k = 0u; k < params.inner; k++) {
        var within = chain_change(inner, pair.first.p, pair.second.p);
        if params.jacobi != 0u {
            within *= CHAIN_JACOBI_SHARE;
        } else {
            within *= relaxation;
            pair.first.p += within * pair.first.mobility;
            pair.second.p -= within * pair.second.mobility;
            relaxation = chain_relaxation(relaxation, radius_squared);
        }
        inner.pull = chain_pull(inner, within);
        let half = (k & 1u) * 2u * CHAIN_THREADS;
        let place = half + 2u * local;
        places[place] = pair.first.p;
        places[place + 1u] = pair.second.p;
        workgroupBarrier();
        var behind = chain_change(before, places[max(place, 1u) - 1u], pair.first.p);
        var ahead = chain_change(after, pair.second.p, places[min(place + 2u, 4u * CHAIN_THREADS - 1u)]);
        if params.jacobi != 0u {
            behind *= CHAIN_JACOBI_SHARE;
            ahead *= CHAIN_JACOBI_SHARE;
            pair.first.p += (within - behind) * pair.first.mobility;
            pair.second.p += (ahead - within) * pair.second.mobility;
            pair = Pair(chain_hold_averaged(pair.first), chain_hold_averaged(pair.second));
        } else {
            behind *= relaxation;
            ahead *= relaxation;
            relaxation = chain_relaxation(relaxation, radius_squared);
            pair.first.p -= behind * pair.first.mobility;
            pair.second.p += ahead * pair.second.mobility;
            pair = Pair(chain_hold(pair.first), chain_hold(pair.second));
        }
        before.pull = chain_pull(before, behind);
        after.pull = chain_pull(after, ahead);
    }
    if idle {
        return;
    }
    let write = dynamics_run(instance, own, body.first_point, 1u - params.from_half);
    if slot == 0u {
        iterates[write] = iterates[work.read];
        iterates[write + 1u] = iterates[work.read + 1u];
    }
    if ENDS && params.ends_substep != 0u && params.final_passes > 0u {
        pair = settle(work, pair);
    }
    store(work, i, write, pair.first, inner.pull);
    store(work, i + 1u, write, pair.second, after.pull);
}
