// One Newton step of every active vertex towards its rest iso-value (background 1.12). One thread per vertex of every
// instance.

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
override ROLE_ACTIVE: u32;
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
    let index = dispatch_index(group, workgroups, local);
    if index >= params.vertex_count * params.instance_count {
        return;
    }
    let instance = index / params.vertex_count;
    let goal = targets[index - instance * params.vertex_count];
    var track = tracks[index];
    let runs = track.runs == TRACK_RUNS || (params.projects != 0u && track.runs != 0u);
    if !runs || goal.role != ROLE_ACTIVE || track.stop == STOP_NON_FINITE {
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
    track.passes++;
    track.contact = found.contact;
    if squared < MIN_GRADIENT_SQUARED || found.group == FIELD_NO_GROUP {
        track.normal = vec4<f32>(0.0, 0.0, 0.0, gap);
        track.stop = STOP_NO_GRADIENT;
        tracks[index] = track;
        return;
    }
    let length = sqrt(squared);
    let unit = found.gradient / length;
    track.normal = vec4<f32>(unit, gap);
    track.stop = select(select(STOP_SHORT, STOP_PRESSED, found.contact > 0.0), STOP_CONVERGED, abs(gap) < params.tolerance);
    tracks[index] = track;
    let at = place.group + found.group;
    let longest = params.max_step_radii * groups[at].grid.support_radius * groups[at].scale;
    let wanted = params.relaxation * -gap / length;
    positions[index] = vec4<f32>(p + unit * clamp(wanted, -longest, longest), 1.0);
}
