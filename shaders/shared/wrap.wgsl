// Paths round joints and bones (background 6.4, 6.5; paper B, equations 1 and 2).

override WRAP_HOLD: f32;
override WRAP_SHORT: f32;

// Unit vectors at right angles, the last one the axis about which a path round a sphere turns.
fn sphere_axes(origin: vec3<f32>, insertion: vec3<f32>, kept: vec3<f32>) -> mat3x3<f32> {
    let size = sqrt(math_dot(origin, origin)) * sqrt(math_dot(insertion, insertion));
    var normal = vec3<f32>(0.0);
    if size > WRAP_SHORT * WRAP_SHORT {
        normal = math_cross(origin, insertion) * (1.0 / size);
    }
    let turn = normal + kept * (2.0 * max(WRAP_HOLD - math_dot(normal, kept), 0.0));
    let axis = turn * (1.0 / sqrt(math_dot(turn, turn)));
    var side = origin - axis * math_dot(origin, axis);
    let length = sqrt(math_dot(side, side));
    if length > WRAP_SHORT {
        side = side * (1.0 / length);
    } else {
        // Duff et al., Building an Orthonormal Basis, Revisited (2017).
        let sign = select(1.0, -1.0, axis.z < 0.0);
        let a = -1.0 / (sign + axis.z);
        side = vec3<f32>(axis.x * axis.y * a, sign + axis.y * axis.y * a, -axis.y);
    }
    return mat3x3<f32>(side, math_cross(axis, side), axis);
}

fn sphere_pushed_out(p: vec3<f32>, radius: f32) -> vec3<f32> {
    let out = radius * CIRCLE_CLEARANCE;
    let away = sqrt(math_dot(p, p));
    if away >= out {
        return p;
    }
    if away > 0.0 {
        return p * (out / away);
    }
    return vec3<f32>(out, 0.0, 0.0);
}

fn sphere_path(start: vec3<f32>, end: vec3<f32>, wrap: MuscleWrap) -> WrapPath {
    let origin = sphere_pushed_out(start, wrap.radius);
    let insertion = sphere_pushed_out(end, wrap.radius);
    let axes = sphere_axes(origin, insertion, wrap.side.xyz);
    let first = vec2<f32>(math_dot(origin, axes[0]), math_dot(origin, axes[1]));
    let second = vec2<f32>(math_dot(insertion, axes[0]), math_dot(insertion, axes[1]));
    let contact = circle_around(first, second, wrap.radius, wrap.side.w);
    if contact.radius == 0.0 {
        return path_straight(origin, insertion);
    }
    return path_wound(origin, insertion, contact, vec3<f32>(0.0), axes);
}

fn cylinder_beyond(wrap: MuscleWrap, height: f32) -> f32 {
    return max(max(height - wrap.high, wrap.low - height), 0.0);
}

fn cylinder_pushed_out(p: vec3<f32>, wrap: MuscleWrap) -> vec3<f32> {
    let out = wrap.radius * CIRCLE_CLEARANCE;
    let beyond = min(cylinder_beyond(wrap, p.z), out);
    let least = sqrt((out - beyond) * (out + beyond));
    let away = sqrt(circle_dot(p.xy, p.xy));
    if away >= least {
        return p;
    }
    if away > 0.0 {
        return vec3<f32>(p.xy * (least / away), p.z);
    }
    return vec3<f32>(least, 0.0, p.z);
}

fn cylinder_path(start: vec3<f32>, end: vec3<f32>, wrap: MuscleWrap) -> WrapPath {
    let origin = cylinder_pushed_out(start, wrap);
    let insertion = cylinder_pushed_out(end, wrap);
    let axes = mat3x3<f32>(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    let contact = circle_around(origin.xy, insertion.xy, wrap.radius, wrap.side.w);
    if contact.radius == 0.0 {
        return path_straight(origin, insertion);
    }
    let middle = (contact.legs.x + 0.5 * contact.radius * contact.angle) / circle_length(contact);
    let beyond = cylinder_beyond(wrap, origin.z + (insertion.z - origin.z) * middle);
    if beyond == 0.0 {
        return path_wound(origin, insertion, contact, vec3<f32>(0.0), axes);
    }
    // How far a ball on the bone's end has fallen back there; from half a right angle on no steeper.
    let round = min(beyond, wrap.radius);
    let sink = round * round / (2.0 * wrap.radius) + (beyond - round);
    let across = circle_perp(insertion.xy - origin.xy);
    let length = sqrt(circle_dot(across, across));
    let sunk = select(vec2<f32>(0.0), across * (1.0 / length), length > 0.0) * (contact.sense * sink);
    let sunken = circle_around(origin.xy - sunk, insertion.xy - sunk, wrap.radius, 3.1415927 * contact.sense);
    if sunken.radius == 0.0 {
        return path_straight(origin, insertion);
    }
    return path_wound(origin, insertion, sunken, vec3<f32>(sunk, 0.0), axes);
}
