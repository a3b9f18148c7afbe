// What a particle touches: other muscles, bones, the skin from within. Reads the globals bodies, bones, moved, groups,
// nodes and iterates.

// A unit normal that leads out of a contact, and in `w` the distance by which it is kept, metres; less than 0 where it is
// not. TOUCH_NOTHING stands for no contact.
override TOUCH_NOTHING: f32;

// Where one instance stands in the globals.
struct TouchPlace {
    joint: u32,
    group: u32,
    instance: u32,
}

fn touch_none() -> vec4<f32> {
    return vec4<f32>(0.0, 0.0, 0.0, TOUCH_NOTHING);
}

// The point of a segment that is nearest to p.
fn touch_nearest(start: vec3<f32>, end: vec3<f32>, p: vec3<f32>) -> vec3<f32> {
    let span = end - start;
    return start + span * clamp(math_dot(p - start, span) / max(math_dot(span, span), 1e-12), 0.0, 1.0);
}

fn touch_bone(place: TouchPlace, link: Link, p: vec3<f32>, radius: f32, clear: f32, share: f32) -> vec4<f32> {
    let bone = bones[link.index];
    let joint = place.joint + bone.joint;
    let scale = moved[joint].scale;
    let held = select(link.insertion_depth, link.origin_depth, share < 0.5);
    let wanted = radius * clear + held * scale * (1.0 - clear);
    if bone.grid.size_x == 0u {
        let matrix = moved[joint].matrix;
        let start = math_transform_point(matrix, bone.start.xyz);
        let end = math_transform_point(matrix, bone.end.xyz);
        let away = p - touch_nearest(start, end, p);
        let distance = sqrt(math_dot(away, away));
        return vec4<f32>(away / max(distance, 1e-9), distance - (bone.start.w * scale + wanted));
    }
    let to_rest = moved[joint].to_rest;
    let u = math_transform_point(bone.grid.rest_to_grid, math_transform_point(to_rest, p));
    if !grid_holds(bone.grid, u) {
        return touch_none();
    }
    let raw = grid_sample(bone.grid, u);
    let outward = math_transpose_vector(to_rest, raw.xyz);
    return vec4<f32>(outward / max(sqrt(math_dot(outward, outward)), 1e-9), raw.w * scale - wanted);
}

// The skin around a particle, of all groups from `begin` to `end` the one that it is deepest inside of; beyond all of
// them it is drawn to `refuge`.
fn touch_skin(place: TouchPlace, begin: u32, end: u32, p: vec3<f32>, refuge: vec3<f32>) -> vec4<f32> {
    var deepest = vec4<f32>(0.0, 0.0, 0.0, -TOUCH_NOTHING);
    for (var k = begin; k < end; k++) {
        let g = place.group + links[k].index;
        let to_rest = moved[place.joint + groups[g].grid.joint].to_rest;
        let u = math_transform_point(groups[g].grid.rest_to_grid, math_transform_point(to_rest, p));
        if !grid_holds(groups[g].grid, u) {
            continue;
        }
        let raw = grid_sample(groups[g].grid, u);
        let outward = math_transpose_vector(to_rest, raw.xyz);
        let slope = max(sqrt(math_dot(outward, outward)), 1e-6);
        if -raw.w / slope > deepest.w {
            deepest = vec4<f32>(-outward / slope, -raw.w / slope);
        }
    }
    if deepest.w > -TOUCH_NOTHING {
        return deepest;
    }
    let way = refuge - p;
    let distance = sqrt(math_dot(way, way));
    if distance > 1e-9 {
        return vec4<f32>(way / distance, -distance);
    }
    return touch_none();
}

// One muscle's axis, two entries a point from `first` on, against f_M with its radii straight from point to point.
fn touch_axis(first: u32, segments: u32, p: vec3<f32>, radius: f32) -> vec4<f32> {
    var nearest = 0u;
    var least = TOUCH_NOTHING;
    var at = 0.0;
    for (var j = 0u; j < segments; j++) {
        let start = iterates[first + 2u * j].xyz;
        let span = iterates[first + 2u * j + 2u].xyz - start;
        let share = clamp(math_dot(p - start, span) / max(math_dot(span, span), 1e-12), 0.0, 1.0);
        let away = p - (start + span * share);
        let squared = math_dot(away, away);
        if squared < least {
            nearest = j;
            least = squared;
            at = share;
        }
    }
    let start = iterates[first + 2u * nearest];
    let end = iterates[first + 2u * nearest + 2u];
    let span = end.xyz - start.xyz;
    let away = p - (start.xyz + span * at);
    let distance = sqrt(math_dot(away, away));
    if distance < 1e-9 {
        return touch_none();
    }
    let outward = away / distance;
    let own = start.w + (end.w - start.w) * at;
    let n0 = iterates[first + 2u * nearest + 1u];
    let n1 = iterates[first + 2u * nearest + 3u];
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

// A contact as a half space n . p >= w; the zero normal is none.
fn touch_plane(contact: vec4<f32>, p: vec3<f32>) -> vec4<f32> {
    if contact.w == TOUCH_NOTHING {
        return vec4<f32>(0.0);
    }
    return vec4<f32>(contact.xyz, math_dot(contact.xyz, p) - contact.w);
}

// A plane brought from scene space at rest of a joint to posed scene space, its normal of length one.
fn touch_posed(plane: vec4<f32>, joint: u32) -> vec4<f32> {
    let normal = math_transpose_vector(moved[joint].to_rest, plane.xyz);
    let scale = 1.0 / max(sqrt(math_dot(normal, normal)), 1e-9);
    return vec4<f32>(normal * scale, (plane.w - math_dot(plane.xyz, moved[joint].to_rest[3].xyz)) * scale);
}

// The inverse of touch_posed, but for the normal's length.
fn touch_rest(plane: vec4<f32>, joint: u32) -> vec4<f32> {
    let normal = math_transpose_vector(moved[joint].matrix, plane.xyz);
    return vec4<f32>(normal, plane.w - math_dot(plane.xyz, moved[joint].matrix[3].xyz));
}
