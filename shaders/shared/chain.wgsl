// A muscle's chain in workgroup memory: springs along the axis, and planes that its particles may not pass. Reads the
// global params.

override CHAIN_JACOBI_SHARE: f32;
override CHAIN_NO_DIRECTION: f32;

// The chain: position and mobility of a point; multiplier and rest length, and gain, of the segment that begins
// there; how much the segment changes in an averaged iteration.
var<workgroup> at: array<vec4<f32>, 64>;
var<workgroup> pull: array<vec4<f32>, 64>;
var<workgroup> gains: array<f32, 64>;
var<workgroup> changes: array<vec4<f32>, 64>;

// Planes of one particle and their multipliers: two muscles, bone, skin.
struct Held {
    planes: array<vec4<f32>, 4>,
    pushes: vec4<f32>,
    radius: f32,
    clear: f32,
    share: f32,
}

var<workgroup> held: array<Held, 64>;

// How much a segment's multiplier changes: to the tension that it would have alone, with everything else as it is.
fn chain_change(j: u32) -> vec3<f32> {
    let mobility = at[j].w + at[j + 1u].w;
    let e = at[j + 1u].xyz - at[j].xyz - pull[j].xyz * mobility;
    let length = sqrt(math_dot(e, e));
    if length < CHAIN_NO_DIRECTION {
        return pull[j].xyz;
    }
    return e * ((length - pull[j].w) * gains[j] / length) + pull[j].xyz;
}

// 1 where a segment knows what it has pulled already, 0 in pbd mode.
fn chain_memory() -> f32 {
    return select(1.0, 0.0, params.pbd != 0u);
}

// The over-relaxation of the next half sweep.
fn chain_relaxation(relaxation: f32, radius_squared: f32) -> f32 {
    return 1.0 / (1.0 - radius_squared * select(0.25 * relaxation, 0.5, relaxation == 1.0));
}

fn chain_project(j: u32, relaxation: f32) {
    let change = chain_change(j) * relaxation;
    pull[j] = vec4<f32>(pull[j].xyz - change * chain_memory(), pull[j].w);
    at[j] = vec4<f32>(at[j].xyz + change * at[j].w, at[j].w);
    at[j + 1u] = vec4<f32>(at[j + 1u].xyz - change * at[j + 1u].w, at[j + 1u].w);
}

// Segments that change together, and how much each particle's two change it.
fn chain_average(i: u32, segments: u32) {
    changes[i] = vec4<f32>(0.0);
    if i < segments {
        changes[i] = vec4<f32>(chain_change(i) * CHAIN_JACOBI_SHARE, 0.0);
    }
}

fn chain_apply(i: u32) {
    let after = changes[i].xyz;
    var before = vec3<f32>(0.0);
    if i > 0u {
        before = changes[i - 1u].xyz;
    }
    pull[i] = vec4<f32>(pull[i].xyz - after * chain_memory(), pull[i].w);
    at[i] = vec4<f32>(at[i].xyz + (after - before) * at[i].w, at[i].w);
}

// Projects a particle on its planes, one after the other. A plane takes back what it pushed too far, and never pulls.
fn chain_hold(i: u32) {
    var p = at[i];
    for (var kind = 0u; kind < 4u; kind++) {
        let plane = held[i].planes[kind];
        let depth = plane.w - math_dot(plane.xyz, p.xyz);
        let push = max(held[i].pushes[kind] + depth / p.w, 0.0);
        p = vec4<f32>(p.xyz + plane.xyz * ((push - held[i].pushes[kind]) * p.w), p.w);
        held[i].pushes[kind] = push;
    }
    at[i] = p;
}

// All planes of a particle from the same state, averaged.
fn chain_hold_averaged(i: u32) {
    let p = at[i];
    var pushes = held[i].pushes;
    var count = 0.0;
    for (var kind = 0u; kind < 4u; kind++) {
        let plane = held[i].planes[kind];
        let depth = plane.w - math_dot(plane.xyz, p.xyz);
        let next = max(pushes[kind] + depth / p.w, 0.0);
        count += select(0.0, 1.0, next != pushes[kind]);
        pushes[kind] = next;
    }
    if count == 0.0 {
        return;
    }
    var moved_by = vec3<f32>(0.0);
    for (var kind = 0u; kind < 4u; kind++) {
        let change = (pushes[kind] - held[i].pushes[kind]) / count;
        moved_by += held[i].planes[kind].xyz * (change * p.w);
        held[i].pushes[kind] += change;
    }
    at[i] = vec4<f32>(p.xyz + moved_by, p.w);
}

// Pushes a particle out of a contact by its depth.
fn chain_push(i: u32, kind: u32, normal: vec3<f32>, depth: f32) {
    if depth > 0.0 {
        at[i] = vec4<f32>(at[i].xyz + normal * depth, at[i].w);
        held[i].pushes[kind] += depth / at[i].w;
    }
}
