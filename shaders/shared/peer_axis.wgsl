// How a particle touches the axis of another muscle. Reads the global iterates.

// The segment of an axis that is nearest to a particle, and where along it.
struct PeerNearest {
    segment: u32,
    squared: f32,
    share: f32,
}

fn peer_nearer(nearest: PeerNearest, j: u32, start: vec3<f32>, span: vec3<f32>, p: vec3<f32>) -> PeerNearest {
    let share = clamp(math_dot(p - start, span) / max(math_dot(span, span), 1e-12), 0.0, 1.0);
    let away = p - (start + span * share);
    let squared = math_dot(away, away);
    if squared < nearest.squared {
        return PeerNearest(j, squared, share);
    }
    return nearest;
}

// One muscle's axis, two entries a point from `first` on, against f_M with its radii straight from point to point.
fn peer_axis(first: u32, nearest: PeerNearest, p: vec3<f32>, radius: f32) -> vec4<f32> {
    let at = nearest.share;
    let start = iterates[first + 2u * nearest.segment];
    let end = iterates[first + 2u * nearest.segment + 2u];
    let span = end.xyz - start.xyz;
    let away = p - (start.xyz + span * at);
    let distance = sqrt(math_dot(away, away));
    if distance < 1e-9 {
        return touch_none();
    }
    let outward = away / distance;
    let own = start.w + (end.w - start.w) * at;
    let n0 = iterates[first + 2u * nearest.segment + 1u];
    let n1 = iterates[first + 2u * nearest.segment + 3u];
    let cosine = math_dot(outward, n0.xyz * (1.0 - at) + n1.xyz * at);
    var polar = 1.0;
    if n0.w > 0.0 {
        let squared = min(cosine * cosine, 1.0);
        polar = 1.0 / sqrt(n0.w * squared + (1.0 - squared) / n0.w);
    }
    var lean = vec3<f32>(0.0);
    if at > 0.0 && at < 1.0 {
        lean = span * ((end.w - start.w) * polar / max(math_dot(span, span), 1e-12));
    }
    let gradient = outward - lean;
    let slope = max(sqrt(math_dot(gradient, gradient)), 1e-6);
    return vec4<f32>(gradient / slope, (distance - own * polar - radius) / slope);
}
