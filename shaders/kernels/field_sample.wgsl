// The composed field at given points of posed scene space: gradient in xyz, value in w. One thread per point; the
// points of all instances follow one another.

@group(0) @binding(0) var<uniform> params: SampleParams;
@group(0) @binding(1) var<storage, read> groups: array<GroupFrame>;
@group(0) @binding(2) var<storage, read> nodes: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> muscles: array<MuscleFrame>;
@group(0) @binding(4) var<storage, read> axes: array<AxisPoint>;
@group(0) @binding(5) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> samples: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = dispatch_index(group, workgroups, local);
    if index >= params.point_count * params.instance_count {
        return;
    }
    let instance = index / params.point_count;
    let place = FieldPlace(
        instance * params.group_count,
        params.group_count,
        instance * params.muscle_count,
        instance * params.axis_point_count,
    );
    let found = field_composed(place, points[index].xyz);
    samples[index] = vec4<f32>(found.gradient, found.value);
}
