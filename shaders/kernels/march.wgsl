// Relaxed Newton steps from the geometrically skinned position to the rest iso-value (background 1.12).
// One thread per vertex of every instance.

@group(0) @binding(0) var<uniform> params: MarchParams;
@group(0) @binding(1) var<storage, read> groups: array<GroupFrame>;
@group(0) @binding(2) var<storage, read> nodes: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> muscles: array<MuscleFrame>;
@group(0) @binding(4) var<storage, read> axes: array<AxisPoint>;
@group(0) @binding(5) var<storage, read> targets: array<VertexTarget>;
@group(0) @binding(6) var<storage, read> skinned: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> tracked: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> reports: array<MarchReport>;

override MIN_GRADIENT_SQUARED: f32;
override INFINITE_GAP: f32;

override STOP_PASSIVE: u32;
override STOP_CONVERGED: u32;
override STOP_NO_GRADIENT: u32;
override STOP_PIT: u32;
override STOP_STEP_LIMIT: u32;
override STOP_NON_FINITE: u32;

struct Marched {
    position: vec3<f32>,
    report: MarchReport,
}

fn march(start: vec3<f32>, goal: VertexTarget, place: FieldPlace) -> Marched {
    var p = start;
    var previous = start;
    var previous_gap = INFINITE_GAP;
    var direction = vec3<f32>(0.0);
    var report = MarchReport(STOP_STEP_LIMIT, 0u, 0.0, 1.0);
    for (var step = 0u; step <= params.max_steps; step++) {
        let found = contact_own_side(place, goal.owner, goal.limit, p);
        let gap = found.value - goal.iso;
        let squared = math_dot(found.gradient, found.gradient);
        if math_not_finite(gap) || math_not_finite(squared) {
            return Marched(start, MarchReport(STOP_NON_FINITE, step, 0.0, report.turn_cosine));
        }
        if abs(gap) > previous_gap {
            report.stop = STOP_PIT;
            return Marched(previous, report);
        }
        report.steps = step;
        report.residual = gap;
        if abs(gap) < params.tolerance {
            report.stop = STOP_CONVERGED;
            break;
        }
        if squared < MIN_GRADIENT_SQUARED || found.group == FIELD_NO_GROUP {
            report.stop = STOP_NO_GRADIENT;
            break;
        }
        if step == params.max_steps {
            break;
        }
        let length = sqrt(squared);
        let unit = found.gradient / length;
        if step > 0u {
            report.turn_cosine = min(report.turn_cosine, math_dot(unit, direction));
        }
        direction = unit;
        let at = place.group + found.group;
        let longest = params.max_step_radii * groups[at].grid.support_radius * groups[at].scale;
        let wanted = params.relaxation * -gap / length;
        previous = p;
        previous_gap = abs(gap);
        p += unit * clamp(wanted, -longest, longest);
    }
    return Marched(p, report);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = dispatch_index(group, workgroups, local);
    if index >= params.vertex_count * params.instance_count {
        return;
    }
    let instance = index / params.vertex_count;
    let goal = targets[index - instance * params.vertex_count];
    let start = skinned[index].xyz;
    if goal.follows == 0u {
        tracked[index] = vec4<f32>(start, 1.0);
        reports[index] = MarchReport(STOP_PASSIVE, 0u, 0.0, 1.0);
        return;
    }
    let place = FieldPlace(
        instance * params.group_count,
        params.group_count,
        instance * params.muscle_count,
        instance * params.point_count,
    );
    let marched = march(start, goal, place);
    tracked[index] = vec4<f32>(marched.position, 1.0);
    reports[index] = marched.report;
}
