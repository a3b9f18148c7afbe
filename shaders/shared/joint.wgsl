// Operators that join two limbs (background 1.9 to 1.11). Reads the global curves: control values of the bulge's profile,
// then tables of openings.

override JOINT_CLOSED: f32;
override JOINT_PIECES: u32;
override JOINT_UNION: u32;
override JOINT_BULGE: u32;
override JOINT_SURFACE: f32;
override JOINT_STEPS: u32;

fn joint_curve(i: u32) -> f32 {
    return curves[i / 4u][i % 4u];
}

// The opening at a cosine, from the table that begins at `table`.
fn joint_opening(table: u32, cosine: f32) -> f32 {
    let x = (clamp(cosine, -1.0, 1.0) + 1.0) * (0.5 * f32(JOINT_STEPS));
    let i = min(u32(x), JOINT_STEPS - 1u);
    let low = joint_curve(table + i);
    return low + (joint_curve(table + i + 1u) - low) * (x - f32(i));
}

fn joint_circle(big: f32, q: f32, unit: f32, share: f32) -> vec3<f32> {
    let root = sqrt(1.0 + share * share + 2.0 * q * share * (1.0 - share));
    let y = share * share / (1.0 + q * share + root);
    return vec3<f32>(big + unit * y, (1.0 - q * y) / root, (share - q * y) / root);
}

fn joint_knot(i: u32) -> f32 {
    return 0.5 * (joint_curve(i) + joint_curve(i + 1u));
}

fn joint_bulge(big: f32, q: f32, unit: f32, share: f32) -> vec3<f32> {
    let step = 1.0 / f32(JOINT_PIECES);
    let d = 1.0 - q;
    let a = q + d * share;
    var piece = 0u;
    for (var i = 1u; i < JOINT_PIECES; i++) {
        if f32(i) * step + a * joint_knot(i) <= share {
            piece = i;
        }
    }
    let first = joint_curve(piece);
    let second = joint_curve(piece + 1u);
    let rise = second - first;
    let bend = 0.5 * (first - 2.0 * second + joint_curve(piece + 2u));
    let left = max(share - f32(piece) * step - a * joint_knot(piece), 0.0);
    let slope = step + a * rise;
    let f = 2.0 * left / (slope + sqrt(max(slope * slope + 4.0 * a * bend * left, 0.0)));
    let s = joint_knot(piece) + f * (rise + f * bend);
    let s_slope = (rise + 2.0 * f * bend) * f32(JOINT_PIECES);
    let t = (f32(piece) + f) * step;
    let scale = 1.0 / (1.0 - d * s + s_slope * (q + d * t));
    return vec3<f32>(big + unit * (s / (1.0 - d * s)), scale, s_slope * scale);
}

// The profile in its box; where `over` is none of `unit`, the larger value alone.
fn joint_boxed(profile: u32, big: f32, q: f32, unit: f32, over: f32) -> vec3<f32> {
    if over <= 0.0 || unit <= 0.0 {
        return vec3<f32>(big, 1.0, 0.0);
    }
    let share = min(over / unit, 1.0);
    if profile == JOINT_BULGE {
        return joint_bulge(big, q, unit, share);
    }
    return joint_circle(big, q, unit, share);
}

// Value, derivative by the larger, derivative by the smaller of two values at opening t.
fn joint_values(profile: u32, big: f32, small: f32, t: f32) -> vec3<f32> {
    if big <= JOINT_SURFACE {
        let open = joint_boxed(profile, big, t, big * (1.0 - t), small - t * big);
        if open.x <= JOINT_SURFACE {
            return open;
        }
    }
    let q = (JOINT_CLOSED - JOINT_SURFACE * t) / (JOINT_CLOSED - JOINT_SURFACE);
    return joint_boxed(profile, big, q, (JOINT_CLOSED - big) * (q - 1.0), q * (JOINT_CLOSED - big) - (JOINT_CLOSED - small));
}

// Two limbs joined. Where either has no gradient there is no angle, and the larger one is taken whole.
fn joint_join(a: Sample, b: Sample, own: JointOperatorParams) -> Sample {
    var big = a;
    var small = b;
    if b.value > a.value {
        big = b;
        small = a;
    }
    if own.profile == JOINT_UNION || small.value <= 0.0 || big.value >= JOINT_CLOSED {
        return big;
    }
    let length = sqrt(math_dot(big.gradient, big.gradient)) * sqrt(math_dot(small.gradient, small.gradient));
    if length <= 0.0 {
        return big;
    }
    let t = joint_opening(own.table, math_dot(big.gradient, small.gradient) / length);
    let found = joint_values(own.profile, big.value, small.value, t);
    return Sample(found.x, big.gradient * found.y + small.gradient * found.z);
}
