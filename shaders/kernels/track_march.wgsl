// One Newton step of every active vertex towards its rest iso-value (background 1.12). One thread per such
// vertex of every instance, in the order of `targets`, whose vertices are their `copy_of`.

@group(0) @binding(0) var<uniform> params: TrackParams;
@group(0) @binding(1) var<storage, read> groups: array<GroupFrame>;
@group(0) @binding(2) var<storage, read> nodes: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> muscles: array<MuscleFrame>;
@group(0) @binding(4) var<storage, read> axes: array<AxisPoint>;
@group(0) @binding(5) var<storage, read> targets: array<VertexTarget>;
@group(0) @binding(6) var<storage, read> places: array<Place>;
@group(0) @binding(7) var<storage, read_write> positions: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> tracks: array<Track>;
@group(0) @binding(9) var<uniform> curves: array<vec4<f32>, 523>;

override MIN_GRADIENT_SQUARED: f32;
override SETTLED: f32;
override STOP_CONVERGED: u32;
override STOP_NO_GRADIENT: u32;
override STOP_SHORT: u32;
override STOP_PRESSED: u32;
override STOP_NON_FINITE: u32;
override TRACK_RUNS: u32;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let item = dispatch_index(group, workgroups, local);
    if item >= params.marched_count * params.instance_count {
        return;
    }
    let instance = item / params.marched_count;
    let goal = targets[item - instance * params.marched_count];
    let index = instance * params.vertex_count + goal.copy_of;
    let runs = tracks[index].runs;
    let passes = tracks[index].passes;
    if runs != TRACK_RUNS && (params.projects == 0u || runs == 0u) || tracks[index].stop == STOP_NON_FINITE {
        return;
    }
    let relaxed = select(0u, params.passes, runs == TRACK_RUNS);
    if params.projects != 0u && passes > relaxed && abs(tracks[index].normal.w) < SETTLED {
        return;
    }
    let place = FieldPlace(
        (params.sub_pose * params.instance_count + instance) * params.group_count,
        params.group_count,
        instance * params.muscle_count,
        instance * params.point_count,
    );
    let reach = instance * params.reach_count;
    let p = positions[index].xyz;
    let found = contact_own_side(place, goal, reach + goal.reach_begin, reach + goal.reach_end, p);
    let gap = found.value - goal.iso;
    let squared = math_dot(found.gradient, found.gradient);
    if math_not_finite(gap) || math_not_finite(squared) {
        tracks[index] = Track(vec4<f32>(0.0), vec4<f32>(0.0, 0.0, 0.0, 1.0), 0.0, STOP_NON_FINITE, 0u, 0u);
        return;
    }
    tracks[index].passes = passes + 1u;
    tracks[index].contact = found.contact;
    if squared < MIN_GRADIENT_SQUARED || found.group == FIELD_NO_GROUP {
        tracks[index].normal = vec4<f32>(0.0, 0.0, 0.0, gap);
        tracks[index].stop = STOP_NO_GRADIENT;
        return;
    }
    let length = sqrt(squared);
    let unit = found.gradient / length;
    tracks[index].normal = vec4<f32>(unit, gap);
    let short = select(STOP_SHORT, STOP_PRESSED, found.contact > 0.0);
    tracks[index].stop = select(short, STOP_CONVERGED, abs(gap) < params.tolerance);
    let at = place.group + found.group;
    let longest = params.max_step_radii * groups[at].grid.support_radius * groups[at].scale;
    let wanted = params.relaxation * -gap / length;
    positions[index] = vec4<f32>(p + unit * clamp(wanted, -longest, longest), 1.0);
}
