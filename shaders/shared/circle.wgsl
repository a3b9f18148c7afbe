// A string in a plane, drawn tight round a circle at the origin (background 6.5 without its third coordinate).

override CIRCLE_CLEARANCE: f32;
override CIRCLE_POINT: f32;

// Where a string lies on a circle; of radius 0 where it is straight.
struct Contact {
    first: vec2<f32>,
    second: vec2<f32>,
    legs: vec2<f32>,
    radius: f32,
    angle: f32,
    sense: f32,
}

fn circle_dot(a: vec2<f32>, b: vec2<f32>) -> f32 {
    return a.x * b.x + a.y * b.y;
}

// A quarter of a turn on.
fn circle_perp(a: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(-a.y, a.x);
}

// The angle from one end to the other about the centre, of those that differ by whole turns the one nearest to `rest`.
fn circle_swept(origin: vec2<f32>, insertion: vec2<f32>, rest: f32) -> f32 {
    let turn = math_polar_angle(circle_dot(origin, insertion), origin.x * insertion.y - origin.y * insertion.x) - rest;
    return rest + (turn - 6.2831855 * floor(turn / 6.2831855 + 0.5));
}

// The string round a circle of `wanted` radius that sweeps `rest` at rest.
fn circle_around(origin: vec2<f32>, insertion: vec2<f32>, wanted: f32, rest: f32) -> Contact {
    let far_1 = sqrt(circle_dot(origin, origin));
    let far_2 = sqrt(circle_dot(insertion, insertion));
    let radius = min(wanted, min(far_1, far_2) / CIRCLE_CLEARANCE);
    var contact = Contact();
    if radius < CIRCLE_POINT {
        return contact;
    }
    let swept = circle_swept(origin, insertion, rest);
    let sense = select(1.0, -1.0, swept < 0.0);
    let leg_1 = sqrt(max((far_1 - radius) * (far_1 + radius), 0.0));
    let leg_2 = sqrt(max((far_2 - radius) * (far_2 + radius), 0.0));
    let angle = swept * sense - math_polar_angle(radius, leg_1) - math_polar_angle(radius, leg_2);
    if angle <= 0.0 {
        return contact;
    }
    contact.radius = radius;
    contact.first = (origin * radius + circle_perp(origin) * (leg_1 * sense)) * (1.0 / (far_1 * far_1));
    contact.second = (insertion * radius - circle_perp(insertion) * (leg_2 * sense)) * (1.0 / (far_2 * far_2));
    contact.legs = vec2<f32>(leg_1, leg_2);
    contact.angle = angle;
    contact.sense = sense;
    return contact;
}

fn circle_length(contact: Contact) -> f32 {
    return contact.legs.x + contact.radius * contact.angle + contact.legs.y;
}
