//! The buffers of a batch, and what each kernel binds of them.

use super::{
    Kernels, RigBuffers,
    kernels::Pipelines,
    output::{Output, OutputLayout},
    rig_buffers::{MIN_BYTES, fits},
};
use crate::{
    dynamics::{DynamicsParams, MovedJoint, Particle, StepClock},
    error::SetupError,
    field::{
        evaluate::{GroupFrame, Place},
        muscle::{AxisPoint, MuscleFrame, MuscleInput, axis},
    },
    normals::NormalParams,
    rig::JointFrame,
    schedule::{Counts, DynamicsOptions, KernelId, Positions, TrackOptions},
    skinning::{VertexParams, WeightedParams},
    tracking::{Track, TrackJoint, TrackParams, Way},
    wrap::MuscleParams,
};
use glam::Mat4;
use std::sync::Arc;

/// A kernel with what it binds for one choice of source positions.
#[derive(Debug)]
pub(super) struct Prepared {
    pub kernel: KernelId,
    pub reads: Option<Positions>,
    pub pipelines: Arc<Pipelines>,
    pub bindings: wgpu::BindGroup,
    /// Outer iteration and whether it carries, where that matters.
    pub part: Option<(u32, bool)>,
    /// Sub-pose and whether it projects, where that matters.
    pub sub_pose: Option<(u32, bool)>,
}

#[derive(Debug)]
pub(super) struct Buffers {
    pub joints: wgpu::Buffer,
    pub groups: wgpu::Buffer,
    pub muscle_inputs: wgpu::Buffer,
    pub muscles: wgpu::Buffer,
    pub axes: wgpu::Buffer,
    pub muscle_joints: wgpu::Buffer,
    pub skinned: wgpu::Buffer,
    pub tracked: wgpu::Buffer,
    pub tracks: wgpu::Buffer,
    pub skin: wgpu::Buffer,
    pub slid: wgpu::Buffer,
    pub spans: wgpu::Buffer,
    pub places: wgpu::Buffer,
    pub track_joints: wgpu::Buffer,
    pub ways: wgpu::Buffer,
    pub offsets: wgpu::Buffer,
    pub output: wgpu::Buffer,
    pub vertex_params: wgpu::Buffer,
    pub weighted_params: wgpu::Buffer,
    pub muscle_params: wgpu::Buffer,
    pub normal_params: wgpu::Buffer,
    pub clocks: wgpu::Buffer,
    pub joints_before: wgpu::Buffer,
    pub moved: wgpu::Buffer,
    pub particles: wgpu::Buffer,
    pub iterates: wgpu::Buffer,
    /// One per outer iteration.
    pub outer_params: Vec<wgpu::Buffer>,
    pub carry_params: wgpu::Buffer,
    /// One per sub-pose, the pose itself first.
    pub track_params: Vec<wgpu::Buffer>,
    pub projection_params: wgpu::Buffer,
    /// Bytes of all that grows with the character, output included.
    pub bytes: u64,
}

impl Buffers {
    pub fn new(
        device: &wgpu::Device,
        rig: &RigBuffers,
        counts: &Counts,
        count: u32,
        output: Output,
    ) -> Result<(Buffers, OutputLayout), SetupError> {
        let times = |items: u32, size: usize| u64::from(items) * u64::from(count) * size as u64;
        let joint_count = rig.rig.character.joints.len() as u32;
        // Without fields nothing is tracked.
        let (tracked, carried) = if counts.groups > 0 { (counts.vertices, joint_count) } else { (0, 0) };
        let layout = output.layout();
        let sizes = [
            ("joints", times(joint_count, size_of::<JointFrame>())),
            ("groups", times(SUB_POSES * counts.groups, size_of::<GroupFrame>())),
            ("muscle inputs", times(counts.muscles, size_of::<MuscleInput>())),
            ("shaped muscles", times(counts.muscles, size_of::<MuscleFrame>())),
            ("muscle axes", times(counts.points, size_of::<AxisPoint>())),
            ("skinned positions", times(counts.vertices, 16)),
            ("tracked positions", times(tracked, 16)),
            ("tracks", times(tracked, size_of::<Track>())),
            ("muscle clocks", times(1, size_of::<StepClock>())),
            ("joints before", times(joint_count, size_of::<JointFrame>())),
            ("moved joints", times(joint_count, size_of::<MovedJoint>())),
            ("muscle particles", times(counts.points, size_of::<Particle>())),
            ("muscle iterates", times(2, 16 * axis::half(counts.muscles, counts.points))),
            ("skin positions", times(tracked, 16)),
            ("slid positions", times(tracked, 16)),
            ("edge spans", times(tracked, 16)),
            ("places", times(counts.reaches, size_of::<Place>())),
            ("tracked joints", times(SUB_POSES * carried, size_of::<TrackJoint>())),
            ("ways", times(1, size_of::<Way>())),
            ("fold offsets", times(counts.folds, 4)),
            ("muscle joints", times(counts.points, size_of::<Mat4>())),
        ];
        let vertices = ("output vertices", layout.end(u64::from(counts.vertices) * u64::from(count)));
        let limits = device.limits();
        for (name, bytes) in sizes.iter().chain([&vertices]) {
            fits(&limits, &format!("`{}`, {count} instances: {name}", rig.rig.character.name), *bytes)?;
        }
        output.check(vertices.1, &limits)?;
        let bytes = sizes.iter().chain([&vertices]).map(|(_, bytes)| bytes).sum();
        let storage = |(name, bytes): (&str, u64)| buffer(device, name, bytes, wgpu::BufferUsages::STORAGE);
        let uniform = |name, bytes: usize| buffer(device, name, bytes as u64, wgpu::BufferUsages::UNIFORM);
        let [
            joints,
            groups,
            muscle_inputs,
            muscles,
            axes,
            skinned,
            tracked,
            tracks,
            clocks,
            joints_before,
            moved,
            particles,
            iterates,
            skin,
            slid,
            spans,
            places,
            track_joints,
            ways,
            offsets,
            muscle_joints,
        ] = sizes.map(storage);
        let buffers = Buffers {
            joints,
            groups,
            muscle_inputs,
            muscles,
            axes,
            skinned,
            tracked,
            tracks,
            clocks,
            joints_before,
            moved,
            particles,
            iterates,
            skin,
            slid,
            spans,
            places,
            track_joints,
            ways,
            offsets,
            muscle_joints,
            output: match output {
                Output::Caller { buffer, .. } => buffer,
                Output::Owned => {
                    buffer(device, vertices.0, vertices.1, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::VERTEX)
                }
            },
            vertex_params: uniform("vertex params", size_of::<VertexParams>()),
            weighted_params: uniform("weighted params", size_of::<WeightedParams>()),
            muscle_params: uniform("muscle params", size_of::<MuscleParams>()),
            normal_params: uniform("normal params", size_of::<NormalParams>()),
            outer_params: (0..DynamicsOptions::MOST_OUTER)
                .map(|_| uniform("dynamics params", size_of::<DynamicsParams>()))
                .collect(),
            carry_params: uniform("carry params", size_of::<DynamicsParams>()),
            track_params: (0..SUB_POSES).map(|_| uniform("track params", size_of::<TrackParams>())).collect(),
            projection_params: uniform("projection params", size_of::<TrackParams>()),
            bytes,
        };
        Ok((buffers, layout))
    }
}

fn buffer(device: &wgpu::Device, name: &str, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(&format!("sinew.{name}")),
        size: bytes.max(MIN_BYTES).next_multiple_of(4),
        usage: usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

pub(super) fn prepare(
    kernels: &Kernels,
    device: &wgpu::Device,
    rig: &RigBuffers,
    b: &Buffers,
) -> Result<Vec<Prepared>, SetupError> {
    let make = |kernel, reads, buffers: &[(&str, &wgpu::Buffer)]| {
        let bindings = kernels.bind(device, kernel, buffers)?;
        Ok(Prepared { kernel, reads, pipelines: kernels.pipelines(kernel), bindings, part: None, sub_pose: None })
    };
    let step = |params| {
        [
            ("params", params),
            ("clocks", &b.clocks),
            ("joints_before", &b.joints_before),
            ("joints", &b.joints),
            ("moved", &b.moved),
        ]
    };
    let predict = |params| {
        [
            ("params", params),
            ("bodies", &rig.bodies),
            ("inputs", &b.muscle_inputs),
            ("moved", &b.moved),
            ("axes", &b.axes),
            ("particles", &b.particles),
            ("iterates", &b.iterates),
            ("clocks", &b.clocks),
            ("wraps", &rig.wraps),
        ]
    };
    let project = |params| {
        [
            ("params", params),
            ("bodies", &rig.bodies),
            ("bones", &rig.bones),
            ("links", &rig.links),
            ("moved", &b.moved),
            ("groups", &b.groups),
            ("nodes", &rig.nodes),
            ("particles", &b.particles),
            ("iterates", &b.iterates),
        ]
    };
    let skin = [
        ("params", &b.vertex_params),
        ("joints", &b.joints),
        ("positions_rest", &rig.positions_rest),
        ("offsets", &rig.influence_offsets),
        ("influences", &rig.influences),
        ("skinned", &b.skinned),
    ];
    let weighted = [
        ("params", &b.weighted_params),
        ("joints", &b.joints),
        ("muscles", &b.muscles),
        ("axes", &b.axes),
        ("targets", &rig.weight_targets),
        ("weights", &rig.weights),
        ("skinned", &b.skinned),
        ("displaced", &b.tracked),
    ];
    let muscle_joint = [
        ("params", &b.muscle_params),
        ("muscles_rest", &rig.muscles),
        ("joints_rest", &rig.joint_rests),
        ("joints", &b.joints),
        ("muscles", &b.muscles),
        ("axes", &b.axes),
        ("muscle_joints", &b.muscle_joints),
    ];
    let hybrid = [
        ("params", &b.weighted_params),
        ("joints", &b.joints),
        ("muscle_joints", &b.muscle_joints),
        ("positions_rest", &rig.positions_rest),
        ("offsets", &rig.hybrid_offsets),
        ("influences", &rig.hybrid_influences),
        ("skinned", &b.skinned),
    ];
    let shape = [
        ("params", &b.muscle_params),
        ("muscles_rest", &rig.muscles),
        ("inputs", &b.muscle_inputs),
        ("joints", &b.joints),
        ("shaped", &b.muscles),
        ("axes", &b.axes),
        ("iterates", &b.iterates),
        ("wraps", &rig.wraps),
    ];
    let bound = [("params", &b.muscle_params), ("muscles", &b.muscles), ("groups", &b.groups)];
    let normals = |positions| {
        [
            ("params", &b.normal_params),
            ("triangles", &rig.corners),
            ("fans", &rig.fans),
            ("members", &rig.fan_members),
            ("positions", positions),
            ("vertices", &b.output),
        ]
    };
    let mut prepared = vec![
        make(KernelId::SkinLinear, None, &skin)?,
        make(KernelId::SkinDualQuaternion, None, &skin)?,
        make(KernelId::SkinWeighted, None, &weighted)?,
        make(KernelId::MuscleShape, None, &shape)?,
        make(KernelId::MuscleJoint, None, &muscle_joint)?,
        make(KernelId::SkinHybrid, None, &hybrid)?,
        make(KernelId::GroupBound, None, &bound)?,
        make(KernelId::Normals, Some(Positions::Skinned), &normals(&b.skinned))?,
        make(KernelId::Normals, Some(Positions::Tracked), &normals(&b.tracked))?,
    ];
    let in_part = |prepared: Prepared, part| Prepared { part: Some(part), ..prepared };
    for (params, carries) in [(&b.outer_params[0], false), (&b.carry_params, true)] {
        prepared.push(in_part(make(KernelId::JointStep, None, &step(params))?, (0, carries)));
        prepared.push(in_part(make(KernelId::MusclePredict, None, &predict(params))?, (0, carries)));
    }
    for (outer, params) in (0..).zip(&b.outer_params) {
        prepared.push(in_part(make(KernelId::MuscleProject, None, &project(params))?, (outer, false)));
    }
    let in_sub_pose = |prepared: Prepared, sub_pose| Prepared { sub_pose: Some(sub_pose), ..prepared };
    for (sub_pose, params) in (0..).zip(&b.track_params) {
        for prepared_step in track(&make, rig, b, params)? {
            prepared.push(in_sub_pose(prepared_step, (sub_pose, false)));
        }
    }
    let fold = fold(rig, b, &b.projection_params);
    prepared.push(in_sub_pose(make(KernelId::TrackFold, None, &fold)?, (0, true)));
    for (params, projects) in [(&b.track_params[0], false), (&b.projection_params, true)] {
        for prepared_step in track_alone(&make, rig, b, params)? {
            prepared.push(in_sub_pose(prepared_step, (0, projects)));
        }
    }
    let march = march(rig, b, &b.projection_params);
    prepared.push(in_sub_pose(make(KernelId::TrackMarch, None, &march)?, (0, true)));
    Ok(prepared)
}

/// Sub-poses that a batch has room for.
pub(super) const SUB_POSES: u32 = TrackOptions::MOST_SUB_POSES;

type Bound<'a> = (&'a str, &'a wgpu::Buffer);

fn march<'a>(rig: &'a RigBuffers, b: &'a Buffers, params: &'a wgpu::Buffer) -> [Bound<'a>; 10] {
    [
        ("params", params),
        ("groups", &b.groups),
        ("nodes", &rig.nodes),
        ("muscles", &b.muscles),
        ("axes", &b.axes),
        ("targets", &rig.marched),
        ("places", &b.places),
        ("positions", &b.skin),
        ("tracks", &b.tracks),
        ("curves", &rig.curves),
    ]
}

fn fold<'a>(rig: &'a RigBuffers, b: &'a Buffers, params: &'a wgpu::Buffer) -> [Bound<'a>; 9] {
    [
        ("params", params),
        ("ways", &b.ways),
        ("joints", &b.track_joints),
        ("patches", &rig.fold_patches),
        ("triangles", &rig.fold_triangles),
        ("positions_rest", &rig.positions_rest),
        ("positions", &b.skin),
        ("groups", &b.groups),
        ("offsets", &b.offsets),
    ]
}

/// The tracker's kernels with the parameters of one sub-pose.
fn track(
    make: &impl Fn(KernelId, Option<Positions>, &[Bound]) -> Result<Prepared, SetupError>,
    rig: &RigBuffers,
    b: &Buffers,
    params: &wgpu::Buffer,
) -> Result<[Prepared; 9], SetupError> {
    let carry = [
        ("params", params),
        ("joints", &b.track_joints),
        ("ways", &b.ways),
        ("positions_rest", &rig.positions_rest),
        ("offsets", &rig.influence_offsets),
        ("influences", &rig.influences),
        ("targets", &rig.targets),
        ("positions", &b.skin),
        ("tracks", &b.tracks),
    ];
    let place = [
        ("params", params),
        ("joints", &b.track_joints),
        ("ways", &b.ways),
        ("reaches", &rig.reaches),
        ("blends", &rig.blends),
        ("places", &b.places),
    ];
    let turn = [
        ("params", params),
        ("targets", &rig.targets),
        ("edges", &rig.edges),
        ("positions_rest", &rig.positions_rest),
        ("positions", &b.skin),
        ("tracks", &b.tracks),
    ];
    let span = [
        ("params", params),
        ("targets", &rig.targets),
        ("edges", &rig.edges),
        ("positions_rest", &rig.positions_rest),
        ("tracks", &b.tracks),
        ("spans", &b.spans),
    ];
    let slide = |positions, slid| {
        [
            ("params", params),
            ("targets", &rig.targets),
            ("edges", &rig.edges),
            ("tracks", &b.tracks),
            ("spans", &b.spans),
            ("positions", positions),
            ("slid", slid),
        ]
    };
    let spread = [("params", params), ("targets", &rig.targets), ("positions", &b.skin), ("tracked", &b.tracked)];
    Ok([
        make(KernelId::TrackCarry, None, &carry)?,
        make(KernelId::TrackPlace, None, &place)?,
        make(KernelId::TrackFold, None, &fold(rig, b, params))?,
        make(KernelId::TrackMarch, None, &march(rig, b, params))?,
        make(KernelId::TrackTurn, None, &turn)?,
        make(KernelId::TrackSpan, None, &span)?,
        make(KernelId::TrackSlide, Some(Positions::Skin), &slide(&b.skin, &b.slid))?,
        make(KernelId::TrackSlide, Some(Positions::Slid), &slide(&b.slid, &b.skin))?,
        make(KernelId::TrackSpread, None, &spread)?,
    ])
}

/// The kernels of a pose by itself.
fn track_alone(
    make: &impl Fn(KernelId, Option<Positions>, &[Bound]) -> Result<Prepared, SetupError>,
    rig: &RigBuffers,
    b: &Buffers,
    params: &wgpu::Buffer,
) -> Result<[Prepared; 3], SetupError> {
    let start =
        [("params", params), ("ways", &b.ways), ("skinned", &b.skinned), ("positions", &b.skin), ("tracks", &b.tracks)];
    let average = |positions, averaged| {
        [
            ("params", params),
            ("targets", &rig.targets),
            ("edges", &rig.edges),
            ("mean_values", &rig.mean_values),
            ("tracks", &b.tracks),
            ("positions", positions),
            ("averaged", averaged),
        ]
    };
    Ok([
        make(KernelId::TrackStart, None, &start)?,
        make(KernelId::TrackAverage, Some(Positions::Skin), &average(&b.skin, &b.slid))?,
        make(KernelId::TrackAverage, Some(Positions::Slid), &average(&b.slid, &b.skin))?,
    ])
}
