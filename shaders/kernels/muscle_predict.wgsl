// Where a muscle's particles would be at the end of a substep if nothing held them, their radii, and the muscle's run of
// the iterates. One thread per muscle of every instance; an instance's first one counts its substeps.

@group(0) @binding(0) var<uniform> params: DynamicsParams;
@group(0) @binding(1) var<storage, read> bodies: array<MuscleBody>;
@group(0) @binding(2) var<storage, read> inputs: array<MuscleInput>;
@group(0) @binding(3) var<storage, read> moved: array<MovedJoint>;
@group(0) @binding(4) var<storage, read> axes: array<AxisPoint>;
@group(0) @binding(5) var<storage, read_write> particles: array<Particle>;
@group(0) @binding(6) var<storage, read_write> iterates: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> clocks: array<StepClock>;
@group(0) @binding(8) var<storage, read> wraps: array<MuscleWrap>;

override THREADS: u32;
override WRAPS: bool;
override PI: f32;
override TAU: f32;
override STRETCH: f32;
override MOST_PHASE_SQUARED: f32;
override MOST_WAY: f32;
override NOMINAL_STIFFNESS: f32;
override RATE: f32;
override JIGGLE_RATE: f32;
override JIGGLE_DAMPING: f32;
override JIGGLE_MOST_SHIFT: f32;
override JIGGLE_MOST_DRIVE: f32;

// nominal 2^((k - .4) / .3), from the series of the exponential.
fn frequency(k: f32, nominal: f32) -> f32 {
    let x = (k - NOMINAL_STIFFNESS) * RATE;
    let e = 1.0 + x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x * (1.0 / 120.0)))));
    let squared = e * e;
    return nominal * squared * squared;
}

// Compliance over the substep squared and the square of the spectral radius of Jacobi's sweeps; in pbd mode the paper's
// k, and 0.
fn stiffness_of(body: MuscleBody, input: MuscleInput) -> vec2<f32> {
    if params.pbd != 0u {
        return vec2<f32>(input.stiffness, 0.0);
    }
    let segments = f32(body.segments);
    var hertz = body.frequency;
    if hertz == 0.0 {
        hertz = frequency(input.stiffness, params.frequency);
    }
    let cycles = hertz * params.seconds;
    let squared = min(TAU * TAU * cycles * cycles, MOST_PHASE_SQUARED);
    let quick = cycles * (15.0 - squared) / (15.0 - 6.0 * squared);
    let compliance = STRETCH / (4.0 * body.insertion.w * quick * quick * segments);
    let angle = PI / segments;
    let cosine = 1.0 - angle * angle * (0.5 - angle * angle * (1.0 / 24.0));
    let radius = cosine * 2.0 * body.looseness / (2.0 * body.looseness + compliance);
    return vec2<f32>(compliance, radius * radius);
}

// Steps the oscillator along the axis by a substep, unless the joints carry, and gives the profile's shift.
fn jiggle_shift(body: MuscleBody, joint: u32, first: u32, carries: bool, length: f32) -> f32 {
    if body.jiggle == 0.0 {
        return 0.0;
    }
    var away = particles[first].traits.z;
    var speed = particles[first].traits.w;
    if !carries {
        let last = body.segments;
        let start = particles[first].position.xyz;
        let end = particles[first + last].position.xyz;
        let displaced = math_transform_point(moved[joint + body.origin_joint].carry, start)
            + math_transform_point(moved[joint + body.insertion_joint].carry, end);
        let before = particles[first].velocity.xyz + particles[first + last].velocity.xyz;
        let span = end - start;
        let change = (displaced / params.seconds - before) * (0.5 * moved[joint + body.driver].retention);
        var drive = math_dot(change, span) / max(sqrt(math_dot(span, span)) * length * params.seconds, 1e-9);
        drive = clamp(drive, -JIGGLE_MOST_DRIVE, JIGGLE_MOST_DRIVE) * body.jiggle;
        let rate = min(JIGGLE_RATE, 1.0 / params.seconds);
        let slowed = 1.0 + 2.0 * JIGGLE_DAMPING * rate * params.seconds;
        speed = (speed - (rate * rate * away + drive) * params.seconds) / slowed;
        away += speed * params.seconds;
        if math_not_finite(away) || math_not_finite(speed) {
            away = 0.0;
            speed = 0.0;
        }
        particles[first].traits.z = away;
        particles[first].traits.w = speed;
    }
    let size = away / JIGGLE_MOST_SHIFT;
    return away / sqrt(1.0 + size * size);
}

@compute @workgroup_size(16)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = (group.y * workgroups.x + group.x) * THREADS + local;
    if index >= params.muscle_count * params.instance_count {
        return;
    }
    let instance = index / params.muscle_count;
    let body = bodies[index - instance * params.muscle_count];
    if index == instance * params.muscle_count {
        clocks[instance].turn = min(clocks[instance].turn + 1u, clocks[instance].turns);
    }
    let joint = instance * params.joint_count;
    if moved[joint + body.origin_joint].runs == 0u {
        return;
    }
    let input = inputs[index];
    let first = instance * params.point_count + body.first_point;
    let out = dynamics_run(instance, index - instance * params.muscle_count, body.first_point, 0u);
    let last = body.segments;
    var length = 0.0;
    var rest = 0.0;
    var softness = 0.0;
    for (var i = 0u; i < last; i++) {
        let span = particles[first + i + 1u].position.xyz - particles[first + i].position.xyz;
        length += sqrt(math_dot(span, span));
        rest += particles[first + i].spring.w;
        softness += 1.0 / particles[first + i].traits.y;
    }
    let driver_matrix = moved[joint + body.driver].matrix;
    let retention = moved[joint + body.driver].retention;
    let carries = moved[joint + body.driver].carries != 0u;
    let scale = max(moved[joint + body.driver].scale, 1e-6);
    let width = input.width * sqrt(body.origin.w / (PI * max(length / scale, 1e-5))) * scale;
    let shift = jiggle_shift(body, joint, first, carries, length);
    let short_squared = sqrt(1.0 - input.eccentricity * input.eccentricity);
    let from_carry = moved[joint + body.origin_joint].carry;
    let to_carry = moved[joint + body.insertion_joint].carry;
    let origin = math_transform_point(moved[joint + body.origin_joint].matrix, body.origin.xyz);
    let insertion = math_transform_point(moved[joint + body.insertion_joint].matrix, body.insertion.xyz);
    let stiffness = stiffness_of(body, input);
    // All springs start with the tension of the whole axis along its chord, which moves no particle.
    let excess = select(max(length - rest * scale, 0.0), 0.0, params.pbd != 0u);
    let chord = insertion - origin;
    let pull = chord * (-excess / (stiffness.x * softness * max(sqrt(math_dot(chord, chord)), 1e-9)));
    // The box holds the surface, and what planes may lag behind it.
    let longest = 1.0 / sqrt(short_squared);
    var lowest = vec3<f32>(3.4e38);
    var highest = vec3<f32>(-3.4e38);
    let follows = WRAPS && body.wrap != 0u;
    var courses = Courses();
    if follows {
        let before = array(particles[first].position.xyz, particles[first + last].position.xyz);
        let wrap = wraps[body.wrap - 1u];
        courses = courses_of(wrap, moved[joint + wrap.joint], before, array(origin, insertion));
    }
    var next = origin;
    for (var i = 0u; i <= last; i++) {
        var particle = particles[first + i];
        let share = f32(i) / f32(last);
        let x = particle.position.xyz;
        var displaced = math_transform_point(from_carry, x) * (1.0 - share) + math_transform_point(to_carry, x) * share;
        var own_pull = pull;
        if follows {
            let start = courses_start(courses, i);
            let end = next;
            let by_ends = math_transform_point(from_carry, start) * (1.0 - share) + math_transform_point(to_carry, start) * share;
            displaced += (end - start) - by_ends;
            next = course_point(courses.now, min(i + 1u, last));
            if params.pbd == 0u {
                own_pull = courses_tension(next - end, particle.spring.w * scale, particle.traits.y / stiffness.x);
            }
        }
        let carried = x + displaced;
        var place = carried;
        if i == 0u {
            place = origin;
        } else if i == last {
            place = insertion;
        } else if !carries {
            // No farther than that: it would leap over a bone.
            let relative = (particle.velocity.xyz * params.seconds - displaced) * retention;
            let way = max(sqrt(math_dot(relative, relative)), 1e-9);
            place = carried + relative * select(min(MOST_WAY * width / way, 1.0), 1.0, params.pbd != 0u);
        }
        let radius = width * profile_shifted(input.factors, input.exponents, input.terms, shift, share).x;
        particle.position.w = radius;
        var section = math_transform_vector(driver_matrix, axes[first + i].normal.xyz);
        let size = sqrt(math_dot(section, section));
        var ellipse = 0.0;
        if size > 0.0 {
            section = section / size;
            ellipse = short_squared;
        }
        iterates[out + 2u + 2u * i] = vec4<f32>(place, radius);
        iterates[out + 3u + 2u * i] = vec4<f32>(section, ellipse);
        lowest = min(lowest, place - (radius * longest + params.play));
        highest = max(highest, place + (radius * longest + params.play));
        if !carries {
            particle.spring = vec4<f32>(select(own_pull, vec3<f32>(0.0), i == last), particle.spring.w);
            particle.pushes = vec4<f32>(0.0);
        }
        particles[first + i] = particle;
    }
    iterates[out + 3u + 2u * last].w = shift;
    iterates[out] = vec4<f32>(lowest, stiffness.x);
    iterates[out + 1u] = vec4<f32>(highest, stiffness.y);
}
