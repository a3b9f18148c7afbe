// What a particle touches: bones, and the skin from within. Reads the globals bones, moved and nodes.

// A unit normal that leads out of a contact, and in `w` the distance by which it is kept, metres; less than 0 where it is
// not. TOUCH_NOTHING stands for no contact.
override TOUCH_NOTHING: f32;
override TOUCH_GRIDS: bool;

// Where one instance stands in the globals.
struct TouchPlace {
    joint: u32,
    group: u32,
    instance: u32,
}

// The muscle at work, of one thread's point of view.
struct Work {
    place: TouchPlace,
    body: MuscleBody,
    read: u32,
    first: u32,
    kinds: u32,
}

fn touch_none() -> vec4<f32> {
    return vec4<f32>(0.0, 0.0, 0.0, TOUCH_NOTHING);
}

// The point of a segment that is nearest to p.
fn touch_nearest(start: vec3<f32>, end: vec3<f32>, p: vec3<f32>) -> vec3<f32> {
    let span = end - start;
    return start + span * clamp(math_dot(p - start, span) / max(math_dot(span, span), 1e-12), 0.0, 1.0);
}

// A bone as a link's muscle meets it, posed.
struct TouchBone {
    start: vec3<f32>,
    end: vec3<f32>,
    radius: f32,
    scale: f32,
    origin_depth: f32,
    insertion_depth: f32,
    to_rest: mat4x4<f32>,
    grid: GroupGrid,
}

fn touch_bone_of(place: TouchPlace, link: Link) -> TouchBone {
    let bone = bones[link.index];
    let joint = place.joint + bone.joint;
    let matrix = moved[joint].matrix;
    return TouchBone(
        math_transform_point(matrix, bone.start.xyz),
        math_transform_point(matrix, bone.end.xyz),
        bone.start.w,
        moved[joint].scale,
        link.origin_depth,
        link.insertion_depth,
        moved[joint].to_rest,
        bone.grid,
    );
}

fn touch_bone(bone: TouchBone, p: vec3<f32>, radius: f32, clear: f32, share: f32) -> vec4<f32> {
    let held = select(bone.insertion_depth, bone.origin_depth, share < 0.5);
    let wanted = radius * clear + held * bone.scale * (1.0 - clear);
    if !TOUCH_GRIDS || bone.grid.size_x == 0u {
        let away = p - touch_nearest(bone.start, bone.end, p);
        let distance = sqrt(math_dot(away, away));
        return vec4<f32>(away / max(distance, 1e-9), distance - (bone.radius * bone.scale + wanted));
    }
    let u = math_transform_point(bone.grid.rest_to_grid, math_transform_point(bone.to_rest, p));
    if !grid_holds(bone.grid, u) {
        return touch_none();
    }
    let raw = grid_sample(bone.grid, u);
    let outward = math_transpose_vector(bone.to_rest, raw.xyz);
    return vec4<f32>(outward / max(sqrt(math_dot(outward, outward)), 1e-9), raw.w * bone.scale - wanted);
}

// No skin yet of which a particle could be inside.
fn touch_no_skin() -> vec4<f32> {
    return vec4<f32>(0.0, 0.0, 0.0, -TOUCH_NOTHING);
}

// The skin of one more group around a particle: of all of them the one that it is deepest inside of.
fn touch_deeper(deepest: vec4<f32>, grid: GroupGrid, to_rest: mat4x4<f32>, p: vec3<f32>) -> vec4<f32> {
    let u = math_transform_point(grid.rest_to_grid, math_transform_point(to_rest, p));
    if !grid_holds(grid, u) {
        return deepest;
    }
    let raw = grid_sample(grid, u);
    let outward = math_transpose_vector(to_rest, raw.xyz);
    let slope = max(sqrt(math_dot(outward, outward)), 1e-6);
    if -raw.w / slope > deepest.w {
        return vec4<f32>(-outward / slope, -raw.w / slope);
    }
    return deepest;
}

// The deepest skin; beyond all of them a particle is drawn to `refuge`.
fn touch_skin(deepest: vec4<f32>, p: vec3<f32>, refuge: vec3<f32>) -> vec4<f32> {
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

// A contact as a half space n . p >= w; the zero normal is none.
fn touch_plane(contact: vec4<f32>, p: vec3<f32>) -> vec4<f32> {
    if contact.w == TOUCH_NOTHING {
        return vec4<f32>(0.0);
    }
    return vec4<f32>(contact.xyz, math_dot(contact.xyz, p) - contact.w);
}

// A plane brought from scene space at rest of a joint to posed scene space, its normal of length one.
fn touch_posed(plane: vec4<f32>, to_rest: mat4x4<f32>) -> vec4<f32> {
    let normal = math_transpose_vector(to_rest, plane.xyz);
    let scale = 1.0 / max(sqrt(math_dot(normal, normal)), 1e-9);
    return vec4<f32>(normal * scale, (plane.w - math_dot(plane.xyz, to_rest[3].xyz)) * scale);
}

// The inverse of touch_posed, but for the normal's length.
fn touch_rest(plane: vec4<f32>, matrix: mat4x4<f32>) -> vec4<f32> {
    let normal = math_transpose_vector(matrix, plane.xyz);
    return vec4<f32>(normal, plane.w - math_dot(plane.xyz, matrix[3].xyz));
}
