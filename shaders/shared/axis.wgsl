// Frames of a muscle's axis (paper A, section 5.1; background 7.7). Reads and writes the global axes.

override AXIS_CLEAR_TURN: f32;
override AXIS_CLEAR_SHARE: f32;
override AXIS_NO_DIRECTION: f32;
override AXIS_SMOOTHING: u32;

// Unit vector across `from` towards `to` (zero where they are parallel or opposite), and the angle between them.
fn axis_between(a: vec3<f32>, b: vec3<f32>) -> vec4<f32> {
    let flat_b = b - a * math_dot(a, b);
    let length = sqrt(math_dot(flat_b, flat_b));
    var turn = vec3<f32>(0.0);
    if length > AXIS_NO_DIRECTION {
        turn = flat_b / length;
    }
    let apart = b - a;
    let chord = sqrt(math_dot(apart, apart)) * 0.5;
    return vec4<f32>(turn, 2.0 * math_arc_sine(min(chord, 1.0)));
}

// The unit vector across `axis`, of any length, nearest to `wanted`, or any across it where they are parallel.
fn axis_across(wanted: vec3<f32>, axis: vec3<f32>) -> vec3<f32> {
    let axis_length = sqrt(math_dot(axis, axis));
    var unit = vec3<f32>(1.0, 0.0, 0.0);
    if axis_length > AXIS_NO_DIRECTION {
        unit = axis / axis_length;
    }
    let flat_wanted = wanted - unit * math_dot(wanted, unit);
    let length = sqrt(math_dot(flat_wanted, flat_wanted));
    if length > AXIS_NO_DIRECTION {
        return flat_wanted / length;
    }
    let other = select(vec3<f32>(0.0, 1.0, 0.0), vec3<f32>(1.0, 0.0, 0.0), abs(unit.x) < 0.7);
    let flat_other = other - unit * math_dot(other, unit);
    return flat_other / sqrt(math_dot(flat_other, flat_other));
}

// `normal` turned into the plane of two segments, as far as they and it make that plane clear.
fn axis_in_plane(normal: vec3<f32>, before: vec3<f32>, after: vec3<f32>) -> vec3<f32> {
    let across = math_cross(before, after);
    let sine = sqrt(math_dot(across, across));
    if sine <= AXIS_NO_DIRECTION {
        return normal;
    }
    let square = across / sine;
    let height = square * math_dot(normal, square);
    let inside = normal - height;
    let share = sqrt(math_dot(inside, inside));
    return normal - height * (math_smoothstep(sine / AXIS_CLEAR_TURN) * math_smoothstep(share / AXIS_CLEAR_SHARE));
}

// Tangents and lengths of the axis whose positions stand from `first` on; returns its length.
fn axis_measure(first: u32, segments: u32) -> f32 {
    var length = 0.0;
    var tangent = vec3<f32>(1.0, 0.0, 0.0);
    axes[first].position.w = 0.0;
    for (var i = 0u; i <= segments; i++) {
        axes[first + i].turn.w = length;
        var span = vec3<f32>(0.0);
        if i < segments {
            span = axes[first + i + 1u].position.xyz - axes[first + i].position.xyz;
        }
        var l = sqrt(math_dot(span, span));
        var inverse_squared = 0.0;
        if l > AXIS_NO_DIRECTION {
            tangent = span / l;
            length += l;
            inverse_squared = 1.0 / (l * l);
        } else {
            l = 0.0;
        }
        axes[first + i].tangent = vec4<f32>(tangent, l);
        if i < segments {
            axes[first + i + 1u].position.w = inverse_squared;
        }
    }
    return length;
}

// Smooths the inner normals by binomial passes.
fn axis_smooth_normals(first: u32, segments: u32) {
    for (var k = 0u; k < AXIS_SMOOTHING; k++) {
        var before = axes[first].normal.xyz;
        for (var i = 1u; i < segments; i++) {
            let own = axes[first + i].normal.xyz;
            let wanted = (before + axes[first + i + 1u].normal.xyz) * 0.25 + own * 0.5;
            let along = axes[first + i - 1u].tangent.xyz + axes[first + i].tangent.xyz;
            axes[first + i].normal = vec4<f32>(axis_across(wanted, along), 0.0);
            before = own;
        }
    }
}

// Fills in everything but the positions of an axis; returns its length.
fn axis_frame(first: u32, segments: u32, origin_normal: vec3<f32>, insertion_normal: vec3<f32>) -> f32 {
    let length = axis_measure(first, segments);
    let first_tangent = axes[first].tangent.xyz;
    let start = axis_across(origin_normal, first_tangent);
    let ends = axis_between(start, axis_across(insertion_normal, axes[first + segments].tangent.xyz));
    var end_turn = ends.xyz;
    if all(end_turn == vec3<f32>(0.0)) {
        // Opposite normals have no shortest way: they turn about the axis.
        end_turn = axis_across(math_cross(first_tangent, start), start);
    }
    var inverse_length = 0.0;
    if length > AXIS_NO_DIRECTION {
        inverse_length = 1.0 / length;
    }
    var previous = vec3<f32>(0.0);
    for (var i = 0u; i <= segments; i++) {
        let after = axes[first + i].tangent.xyz;
        var before = after;
        if i > 0u {
            before = axes[first + i - 1u].tangent.xyz;
        }
        let turned = math_sine_cosine(ends.w * (axes[first + i].turn.w * inverse_length));
        let wanted = start * turned.y + end_turn * turned.x;
        let normal = axis_across(axis_in_plane(wanted, before, after), before + after);
        previous = select(normal, -normal, math_dot(normal, previous) < 0.0);
        axes[first + i].normal = vec4<f32>(previous, 0.0);
    }
    axis_smooth_normals(first, segments);
    for (var i = 0u; i < segments; i++) {
        let turn = axis_between(axes[first + i].normal.xyz, axes[first + i + 1u].normal.xyz);
        axes[first + i].normal.w = turn.w;
        axes[first + i].turn = vec4<f32>(turn.xyz, axes[first + i].turn.w);
    }
    axes[first + segments].turn = vec4<f32>(0.0, 0.0, 0.0, length);
    return length;
}
