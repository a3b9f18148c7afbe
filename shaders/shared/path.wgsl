// A muscle's path past one obstacle, in the obstacle's frame: straight, wound, straight.

struct WrapPath {
    origin: vec3<f32>,
    insertion: vec3<f32>,
    parts: vec3<f32>,
    angle: f32,
    centre: vec3<f32>,
    outward: vec3<f32>,
    onward: vec3<f32>,
    rise: vec3<f32>,
}

fn path_straight(origin: vec3<f32>, insertion: vec3<f32>) -> WrapPath {
    let along = insertion - origin;
    let none = vec3<f32>(0.0);
    let length = sqrt(math_dot(along, along));
    return WrapPath(origin, insertion, vec3<f32>(length, 0.0, 0.0), 0.0, insertion, none, none, none);
}

// The path whose projection along the third axis is the contact, round `centre`.
fn path_wound(origin: vec3<f32>, insertion: vec3<f32>, contact: Contact, centre: vec3<f32>, axes: mat3x3<f32>) -> WrapPath {
    let start = math_dot(origin - centre, axes[2]);
    let climb = math_dot(insertion - centre, axes[2]) - start;
    let arc = contact.radius * contact.angle;
    let flat_length = circle_length(contact);
    let steep = sqrt(flat_length * flat_length + climb * climb) / flat_length;
    let quarter = circle_perp(contact.first) * contact.sense;
    return WrapPath(
        origin,
        insertion,
        vec3<f32>(contact.legs.x * steep, arc * steep, contact.legs.y * steep),
        contact.angle,
        centre + axes[2] * (start + climb * (contact.legs.x / flat_length)),
        (axes[0] * contact.first.x + axes[1] * contact.first.y) * contact.radius,
        (axes[0] * quarter.x + axes[1] * quarter.y) * contact.radius,
        axes[2] * (climb * (arc / flat_length)),
    );
}

fn path_length(path: WrapPath) -> f32 {
    return path.parts.x + path.parts.y + path.parts.z;
}

fn path_share(distance: f32, length: f32) -> f32 {
    if length > 0.0 {
        return clamp(distance / length, 0.0, 1.0);
    }
    return 0.0;
}

fn path_on_helix(path: WrapPath, share: f32) -> vec3<f32> {
    let angle = path.angle * share;
    var turned = math_sine_cosine(angle);
    if angle > 3.1415927 {
        turned = -math_sine_cosine(angle - 3.1415927);
    }
    return path.centre + path.outward * turned.y + path.onward * turned.x + path.rise * share;
}

// The point at a distance from the origin along the path.
fn path_point(path: WrapPath, distance: f32) -> vec3<f32> {
    let wound = distance - path.parts.x;
    let last = wound - path.parts.y;
    if wound <= 0.0 {
        let end = path.centre + path.outward;
        return path.origin + (end - path.origin) * path_share(distance, path.parts.x);
    }
    if last <= 0.0 {
        return path_on_helix(path, path_share(wound, path.parts.y));
    }
    let start = path_on_helix(path, 1.0);
    return start + (path.insertion - start) * path_share(last, path.parts.z);
}
