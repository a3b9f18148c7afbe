// The muscle primitive's compact field (paper A, equations 1 to 5, algorithm 1; background 3.2 and 7.6). Reads the
// global axes; `first` is a muscle's first point there.

override MUSCLE_NO_DIRECTION: f32;

// A point's place on an axis.
struct Projection {
    offset: vec3<f32>,
    arc: f32,
    arc_gradient: vec3<f32>,
    tangent: vec3<f32>,
    normal: vec3<f32>,
    normal_slope: vec3<f32>,
}

// Foot on a segment: from the foot to the point, and the place on the segment's line in metres.
fn muscle_foot(point: AxisPoint, q: vec3<f32>) -> vec4<f32> {
    let h = q - point.position.xyz;
    let along = math_dot(h, point.tangent.xyz);
    return vec4<f32>(h - point.tangent.xyz * clamp(along, 0.0, point.tangent.w), along);
}

fn muscle_inside(point: AxisPoint, foot: vec4<f32>) -> bool {
    return foot.w > 0.0 && foot.w < point.tangent.w;
}

fn muscle_on_segment(point: AxisPoint, at: f32, offset: vec3<f32>, arc_gradient: vec3<f32>) -> Projection {
    let inverse = 1.0 / max(point.tangent.w, MUSCLE_NO_DIRECTION);
    let turned = math_sine_cosine(point.normal.w * (at * inverse));
    let normal = point.normal.xyz * turned.y + point.turn.xyz * turned.x;
    let by_share = (point.turn.xyz * turned.y - point.normal.xyz * turned.x) * point.normal.w;
    return Projection(offset, point.turn.w + at, arc_gradient, point.tangent.xyz, normal, by_share * inverse);
}

// Between the segments on either side of a point that they share, with feet on both.
fn muscle_in_wedge(before: AxisPoint, after: AxisPoint, foot_0: vec4<f32>, foot_1: vec4<f32>, q: vec3<f32>) -> Projection {
    let a0 = before.tangent.w - clamp(foot_0.w, 0.0, before.tangent.w);
    let a1 = clamp(foot_1.w, 0.0, after.tangent.w);
    let o0 = sqrt(math_dot(foot_0.xyz, foot_0.xyz));
    let o1 = sqrt(math_dot(foot_1.xyz, foot_1.xyz));
    let sum = a0 * o1 + a1 * o0;
    if sum <= 0.0 {
        return muscle_on_segment(after, 0.0, q - after.position.xyz, vec3<f32>(0.0));
    }
    let x = (a1 * a1 * o0 - a0 * a0 * o1) / sum;
    let e0 = foot_0.xyz / max(o0, 1e-20);
    let e1 = foot_1.xyz / max(o1, 1e-20);
    let t0 = before.tangent.xyz;
    let t1 = after.tangent.xyz;
    let top = t1 * (2.0 * a1 * o0) + e0 * (a1 * a1) + t0 * (2.0 * a0 * o1) - e1 * (a0 * a0);
    let bottom = e1 * a0 - t0 * o1 + t1 * o0 + e0 * a1;
    let arc_gradient = (top - bottom * x) / sum;
    if x < 0.0 {
        let at = before.tangent.w + x;
        return muscle_on_segment(before, at, q - before.position.xyz - t0 * at, arc_gradient);
    }
    return muscle_on_segment(after, x, q - after.position.xyz - t1 * x, arc_gradient);
}

fn muscle_project(first: u32, segments: u32, nearest: u32, q: vec3<f32>) -> Projection {
    var k = nearest;
    var own = axes[first + k];
    var foot = muscle_foot(own, q);
    if !muscle_inside(own, foot) {
        // Where the neighbour behind that end has a foot inside, it is the nearer one by less than keys tell. Before the
        // first segment the number wraps round, beyond all segments.
        let behind = select(k - 1u, k + 1u, foot.w > 0.0);
        let neighbour = axes[first + min(behind, segments)];
        let nearer = muscle_foot(neighbour, q);
        if behind >= segments || !muscle_inside(neighbour, nearer) {
            return muscle_on_segment(own, clamp(foot.w, 0.0, own.tangent.w), foot.xyz, vec3<f32>(0.0));
        }
        k = behind;
        own = neighbour;
        foot = nearer;
    }
    var reach = 3.4e38;
    var other = own;
    var other_foot = foot;
    var other_is_before = false;
    if k > 0u {
        let before = axes[first + k - 1u];
        let candidate = muscle_foot(before, q);
        let away = q - own.position.xyz;
        if muscle_inside(before, candidate) {
            reach = math_dot(away, away);
            other = before;
            other_foot = candidate;
            other_is_before = true;
        }
    }
    if k + 1u < segments {
        let after = axes[first + k + 1u];
        let candidate = muscle_foot(after, q);
        let away = q - after.position.xyz;
        let squared = math_dot(away, away);
        if muscle_inside(after, candidate) && squared < reach {
            reach = squared;
            other = after;
            other_foot = candidate;
            other_is_before = false;
        }
    }
    if reach == 3.4e38 {
        return muscle_on_segment(own, clamp(foot.w, 0.0, own.tangent.w), foot.xyz, own.tangent.xyz);
    }
    if other_is_before {
        return muscle_in_wedge(other, own, other_foot, foot, q);
    }
    return muscle_in_wedge(own, other, foot, other_foot, q);
}
