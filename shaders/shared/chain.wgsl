// A muscle's chain: springs along the axis, and planes that its particles may not pass. Every thread keeps two
// neighbouring particles to itself; of its neighbours it sees where their nearer particles are. Reads the global params.

override CHAIN_JACOBI_SHARE: f32;
override CHAIN_NO_DIRECTION: f32;
override CHAIN_THREADS: u32;

// One particle. Planes against two muscles, bone and skin, and their multipliers.
struct Bead {
    p: vec3<f32>,
    mobility: f32,
    mass: f32,
    radius: f32,
    clear: f32,
    share: f32,
    peer_0: vec4<f32>,
    peer_1: vec4<f32>,
    bone: vec4<f32>,
    skin: vec4<f32>,
    pushes: vec4<f32>,
}

// The two particles of a thread.
struct Pair {
    first: Bead,
    second: Bead,
}

// One segment; mobility is that of both its particles. A zero segment changes nothing.
struct Spring {
    pull: vec3<f32>,
    rest: f32,
    gain: f32,
    mobility: f32,
}

// Where the particles of all threads are, twice over: while some threads still read one half, others write the other one.
var<workgroup> places: array<vec3<f32>, 128>;

// How much a segment's multiplier changes: to the tension that it would have alone, with everything else as it is.
fn chain_change(spring: Spring, start: vec3<f32>, end: vec3<f32>) -> vec3<f32> {
    let e = end - start - spring.pull * spring.mobility;
    let length = sqrt(math_dot(e, e));
    if length < CHAIN_NO_DIRECTION {
        return spring.pull;
    }
    return e * ((length - spring.rest) * spring.gain / length) + spring.pull;
}

// What a segment has pulled after a change of its multiplier; in pbd mode it knows nothing of it.
fn chain_pull(spring: Spring, change: vec3<f32>) -> vec3<f32> {
    return spring.pull - change * select(1.0, 0.0, params.pbd != 0u);
}

// The over-relaxation of the next half sweep.
fn chain_relaxation(relaxation: f32, radius_squared: f32) -> f32 {
    return 1.0 / (1.0 - radius_squared * select(0.25 * relaxation, 0.5, relaxation == 1.0));
}

// The multiplier that a plane has after its projection; less than nothing it cannot have.
fn chain_pushed(plane: vec4<f32>, push: f32, bead: Bead) -> f32 {
    return max(push + (plane.w - math_dot(plane.xyz, bead.p)) * bead.mass, 0.0);
}

// Projects a particle on its planes, one after the other. A plane takes back what it pushed too far, and never pulls.
fn chain_hold(start: Bead) -> Bead {
    var bead = start;
    let first = chain_pushed(bead.peer_0, bead.pushes.x, bead);
    bead.p += bead.peer_0.xyz * ((first - bead.pushes.x) * bead.mobility);
    let second = chain_pushed(bead.peer_1, bead.pushes.y, bead);
    bead.p += bead.peer_1.xyz * ((second - bead.pushes.y) * bead.mobility);
    let third = chain_pushed(bead.bone, bead.pushes.z, bead);
    bead.p += bead.bone.xyz * ((third - bead.pushes.z) * bead.mobility);
    let fourth = chain_pushed(bead.skin, bead.pushes.w, bead);
    bead.p += bead.skin.xyz * ((fourth - bead.pushes.w) * bead.mobility);
    bead.pushes = vec4<f32>(first, second, third, fourth);
    return bead;
}

// All planes of a particle from the same state, averaged.
fn chain_hold_averaged(start: Bead) -> Bead {
    var bead = start;
    let next = vec4<f32>(
        chain_pushed(bead.peer_0, bead.pushes.x, bead),
        chain_pushed(bead.peer_1, bead.pushes.y, bead),
        chain_pushed(bead.bone, bead.pushes.z, bead),
        chain_pushed(bead.skin, bead.pushes.w, bead),
    );
    let counted = select(vec4<f32>(0.0), vec4<f32>(1.0), next != bead.pushes);
    let count = counted.x + counted.y + counted.z + counted.w;
    let change = select(vec4<f32>(0.0), (next - bead.pushes) / count, count > 0.0);
    let push = change * bead.mobility;
    bead.p += bead.peer_0.xyz * push.x + bead.peer_1.xyz * push.y + bead.bone.xyz * push.z + bead.skin.xyz * push.w;
    bead.pushes += change;
    return bead;
}

// Without planes where the bones move the particle.
fn chain_freed(start: Bead) -> Bead {
    var bead = start;
    if bead.mass == 0.0 {
        bead.peer_0 = vec4<f32>(0.0);
        bead.peer_1 = vec4<f32>(0.0);
        bead.bone = vec4<f32>(0.0);
        bead.skin = vec4<f32>(0.0);
    }
    return bead;
}

// Pushes a particle out of a contact by its depth; `kind` is 1 in the multiplier that grows.
fn chain_push(start: Bead, normal: vec3<f32>, depth: f32, kind: vec4<f32>) -> Bead {
    var bead = start;
    if depth > 0.0 && bead.mass > 0.0 {
        bead.p += normal * depth;
        bead.pushes += kind * (depth * bead.mass);
    }
    return bead;
}
