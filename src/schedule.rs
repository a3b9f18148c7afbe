//! A frame as plain data: which kernels run, in what order, on which positions.
//!
//! The GPU and the reference both play this list, so counts and buffers cannot diverge.

mod options;
mod outline;

pub use options::{
    Contacts, DynamicsOptions, FoldVolume, FrameOptions, Mode, Skinning, Solver, TrackOptions, Tracking,
};
pub use outline::{Entry, outline};

/// A kernel, on whichever side it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum KernelId {
    /// Linear blend skinning.
    SkinLinear,
    /// Dual quaternion skinning.
    SkinDualQuaternion,
    /// Skinned vertices to the muscles that they have weights of.
    SkinWeighted,
    /// Linear blend skinning by bones and muscles.
    SkinHybrid,
    /// Joints at the end of a substep.
    JointStep,
    /// Muscles before anything holds them.
    MusclePredict,
    /// Muscles against their springs and contacts.
    MuscleProject,
    /// Muscle ends, length and width.
    MuscleShape,
    /// Muscles as joints.
    MuscleJoint,
    /// Vertices to where geometric skinning has them.
    TrackStart,
    /// Vertices to where a sub-pose's joints take them.
    TrackCarry,
    /// The frames through which vertices see the groups around them.
    TrackPlace,
    /// Spheres around field groups and their muscles.
    GroupBound,
    /// How much folding joints displace.
    TrackFold,
    /// One step towards the rest iso-values.
    TrackMarch,
    /// How the skin around every vertex has turned.
    TrackTurn,
    /// What vertices' edges at rest come to, turned with the skin.
    TrackSpan,
    /// One sweep of relaxation along the field.
    TrackSlide,
    /// One sweep of relaxation to the mean of neighbours.
    TrackAverage,
    /// First copies' positions to all vertices.
    TrackSpread,
    /// Normals and output vertices.
    Normals,
    /// The composed field at given points; no part of a frame.
    FieldSample,
    /// Muscles alone at given points; no part of a frame.
    MuscleSample,
    /// Operators on given pairs of samples; no part of a frame.
    OperatorSample,
}

/// A position buffer of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Positions {
    /// After geometric skinning.
    Skinned,
    /// Under way in the tracker.
    Skin,
    /// The same after an odd number of sweeps.
    Slid,
    /// After the tracker, or after the displacement to muscles that stands in its place.
    Tracked,
}

/// One step of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// What runs.
    pub kernel: KernelId,
    /// Threads per instance: one per vertex or per muscle.
    pub items: u32,
    /// Positions it reads, where it reads any.
    pub reads: Option<Positions>,
    /// Positions it writes, where it writes any.
    pub writes: Option<Positions>,
    /// Which outer iteration it is, of a step of the dynamics.
    pub outer: u32,
    /// Whether it carries joints and axes on to the frame, rather than through a substep.
    pub carries: bool,
    /// Which sub-pose it is of, of a step of the tracker: 0 is the pose itself, which comes last.
    pub sub_pose: u32,
    /// Whether it is of the tracker's last passes.
    pub projects: bool,
    /// Whether it moves a skin that no later frame starts from.
    pub forgotten: bool,
}

impl Step {
    /// Whether it carries a motion on from frame to frame, rather than making this frame's output.
    pub fn is_of_motion(&self) -> bool {
        use KernelId::{MuscleJoint, Normals, SkinDualQuaternion, SkinHybrid, SkinLinear, SkinWeighted, TrackSpread};
        let skins = matches!(self.kernel, SkinDualQuaternion | SkinHybrid | SkinLinear | SkinWeighted);
        !skins && !self.forgotten && !matches!(self.kernel, MuscleJoint | Normals | TrackSpread)
    }

    /// Whether it moves muscles.
    pub fn moves(&self) -> bool {
        use KernelId::{JointStep, MusclePredict, MuscleProject};
        matches!(self.kernel, JointStep | MusclePredict | MuscleProject)
    }
}

/// Sizes of a rig that a schedule depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Vertices.
    pub vertices: u32,
    /// Those of them that the tracker marches.
    pub marched: u32,
    /// Joints.
    pub joints: u32,
    /// Muscles.
    pub muscles: u32,
    /// Points of all muscles' axes together.
    pub points: u32,
    /// Segments of the axis that has most of them.
    pub most_segments: u32,
    /// Field groups; 0 where the rig has no fields.
    pub groups: u32,
    /// Reaches of all vertices.
    pub reaches: u32,
    /// Joints that fold.
    pub folds: u32,
}

impl Counts {
    /// Threads that share one muscle in the projection, each with two of its points. A power of two, so that no muscle
    /// stands in two workgroups; short muscles share one.
    pub fn threads_per_muscle(&self) -> u32 {
        (self.most_segments + 1).div_ceil(2).next_power_of_two()
    }

    /// Whether a frame of these options moves muscles.
    pub fn dynamics(&self, options: &FrameOptions) -> Option<DynamicsOptions> {
        let fields = options.skinning.follows_muscles() && self.groups > 0 && self.muscles > 0;
        let usable = |d: DynamicsOptions| DynamicsOptions {
            inner: d.inner.max(1),
            outer: d.outer.clamp(1, DynamicsOptions::MOST_OUTER),
            rate: d.rate.max(1),
            ..d
        };
        options.dynamics.filter(|_| fields).map(usable)
    }
}

/// The steps of one frame, in order. Steps without work are left out. `turns` are the substeps of the dynamics, and
/// `sub_poses` those of the tracker.
pub fn frame(counts: &Counts, options: &FrameOptions, turns: u32, sub_poses: u32) -> Vec<Step> {
    let mut steps = Vec::new();
    let skinned = Some(Positions::Skinned);
    let last = match options.skinning {
        Skinning::Implicit if counts.groups > 0 => {
            muscles(counts, options, turns, &mut steps);
            match options.track.mode {
                Tracking::History => track(counts, &options.track, sub_poses, &mut steps),
                Tracking::SinglePose => track_alone(counts, &options.track, &mut steps),
            }
            Positions::Tracked
        }
        Skinning::Weighted if counts.muscles > 0 => {
            muscles(counts, options, turns, &mut steps);
            steps.push(step(KernelId::SkinLinear, counts.vertices, None, skinned));
            steps.push(step(KernelId::SkinWeighted, counts.vertices, skinned, Some(Positions::Tracked)));
            Positions::Tracked
        }
        Skinning::Hybrid if counts.muscles > 0 => {
            muscles(counts, options, turns, &mut steps);
            steps.push(step(KernelId::MuscleJoint, counts.points, None, None));
            steps.push(step(KernelId::SkinHybrid, counts.vertices, None, skinned));
            Positions::Skinned
        }
        Skinning::DualQuaternion => {
            steps.push(step(KernelId::SkinDualQuaternion, counts.vertices, None, skinned));
            Positions::Skinned
        }
        Skinning::Implicit | Skinning::Linear | Skinning::Weighted | Skinning::Hybrid => {
            steps.push(step(KernelId::SkinLinear, counts.vertices, None, skinned));
            Positions::Skinned
        }
    };
    steps.push(step(KernelId::Normals, counts.vertices, Some(last), None));
    steps.retain(|s| s.items > 0);
    steps
}

fn step(kernel: KernelId, items: u32, reads: Option<Positions>, writes: Option<Positions>) -> Step {
    Step { kernel, items, reads, writes, outer: 0, carries: false, sub_pose: 0, projects: false, forgotten: false }
}

fn muscles(counts: &Counts, options: &FrameOptions, turns: u32, steps: &mut Vec<Step>) {
    if let Some(dynamics) = counts.dynamics(options) {
        let joints = step(KernelId::JointStep, counts.joints, None, None);
        let predict = step(KernelId::MusclePredict, counts.muscles, None, None);
        let project = step(KernelId::MuscleProject, counts.muscles * counts.threads_per_muscle(), None, None);
        for _ in 0..turns {
            steps.extend([joints, predict]);
            steps.extend((0..dynamics.outer).map(|outer| Step { outer, ..project }));
        }
        steps.extend([joints, predict].map(|step| Step { carries: true, ..step }));
    }
    steps.push(step(KernelId::MuscleShape, counts.muscles, None, None));
}

/// Sub-poses count down to 0, the pose itself. A skin whose joints stand still is only projected: its muscles may move;
/// it is carried nowhere then, and its carrying says so.
fn track(counts: &Counts, options: &TrackOptions, sub_poses: u32, steps: &mut Vec<Step>) {
    let skin = Some(Positions::Skin);
    let slid = Some(Positions::Slid);
    let march = step(KernelId::TrackMarch, counts.marched, skin, skin);
    let folds = if options.fold == FoldVolume::Closed { counts.folds } else { 0 };
    let fold = step(KernelId::TrackFold, folds, skin, None);
    if counts.muscles > 0 {
        steps.push(step(KernelId::GroupBound, counts.groups * sub_poses.max(1), None, None));
    }
    for sub_pose in (0..sub_poses).rev() {
        let first = steps.len();
        steps.push(step(KernelId::TrackCarry, counts.vertices, skin, skin));
        steps.push(step(KernelId::TrackPlace, counts.reaches, None, None));
        for _ in 0..options.passes {
            steps.push(fold);
            steps.push(march);
            steps.push(step(KernelId::TrackTurn, counts.vertices, skin, None));
            steps.push(step(KernelId::TrackSpan, if options.sweeps > 0 { counts.vertices } else { 0 }, None, None));
            for _ in 0..options.sweeps.div_ceil(2) {
                steps.push(step(KernelId::TrackSlide, counts.vertices, skin, slid));
                steps.push(step(KernelId::TrackSlide, counts.vertices, slid, skin));
            }
        }
        steps[first..].iter_mut().for_each(|step| step.sub_pose = sub_pose);
    }
    if sub_poses == 0 {
        steps.push(step(KernelId::TrackCarry, counts.vertices, skin, skin));
        steps.push(Step { projects: true, ..fold });
    }
    steps.extend((0..options.projections).map(|_| Step { projects: true, ..march }));
    steps.push(step(KernelId::TrackSpread, counts.vertices, skin, Some(Positions::Tracked)));
}

/// A pose's skin from geometric skinning alone, in one sub-pose.
fn track_alone(counts: &Counts, options: &TrackOptions, steps: &mut Vec<Step>) {
    let (skinned, skin, slid) = (Some(Positions::Skinned), Some(Positions::Skin), Some(Positions::Slid));
    let first = steps.len();
    let march = step(KernelId::TrackMarch, counts.marched, skin, skin);
    let average = [
        step(KernelId::TrackAverage, counts.vertices, skin, slid),
        step(KernelId::TrackAverage, counts.vertices, slid, skin),
    ];
    let folds = if options.fold == FoldVolume::Closed { counts.folds } else { 0 };
    if counts.muscles > 0 {
        steps.push(step(KernelId::GroupBound, counts.groups, None, None));
    }
    steps.push(step(KernelId::SkinDualQuaternion, counts.vertices, None, skinned));
    steps.push(step(KernelId::TrackStart, counts.vertices, skinned, skin));
    steps.push(step(KernelId::TrackPlace, counts.reaches, None, None));
    for _ in 0..options.passes {
        steps.push(step(KernelId::TrackFold, folds, skin, None));
        steps.push(march);
        (0..options.sweeps.div_ceil(2)).for_each(|_| steps.extend(average));
    }
    let last = steps.len();
    (0..options.smoothings.div_ceil(2)).for_each(|_| steps.extend(average));
    steps.extend((0..options.projections).map(|_| march));
    steps[last..].iter_mut().for_each(|step| step.projects = true);
    steps[first..].iter_mut().for_each(|step| step.forgotten = true);
    steps.push(step(KernelId::TrackSpread, counts.vertices, skin, Some(Positions::Tracked)));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(vertices: u32, muscles: u32, groups: u32) -> Counts {
        Counts {
            vertices,
            marched: vertices,
            joints: 2,
            muscles,
            points: 30,
            most_segments: 29,
            groups,
            reaches: 4,
            folds: 0,
        }
    }

    fn kernels(vertices: u32, muscles: u32, groups: u32, skinning: Skinning) -> Vec<KernelId> {
        let track = TrackOptions { passes: 1, projections: 2, sweeps: 2, ..TrackOptions::default() };
        let options = FrameOptions { skinning, track, ..FrameOptions::default() };
        frame(&counts(vertices, muscles, groups), &options, 3, 1).iter().map(|s| s.kernel).collect()
    }

    #[test]
    fn steps_follow_the_frame() {
        use KernelId::*;
        let tracked = [
            TrackCarry,
            TrackPlace,
            TrackMarch,
            TrackTurn,
            TrackSpan,
            TrackSlide,
            TrackSlide,
            TrackMarch,
            TrackMarch,
            TrackSpread,
        ];
        let expected = |muscles: &[KernelId]| [muscles, &tracked, &[Normals]].concat();
        assert_eq!(kernels(10, 2, 3, Skinning::Implicit), expected(&[MuscleShape, GroupBound]));
        assert_eq!(kernels(10, 0, 3, Skinning::Implicit), expected(&[]));
        assert_eq!(kernels(10, 2, 0, Skinning::Implicit), [SkinLinear, Normals]);
        assert_eq!(kernels(10, 2, 3, Skinning::DualQuaternion), [SkinDualQuaternion, Normals]);
        assert_eq!(kernels(10, 2, 3, Skinning::Weighted), [MuscleShape, SkinLinear, SkinWeighted, Normals]);
        assert_eq!(kernels(10, 0, 3, Skinning::Weighted), [SkinLinear, Normals]);
        assert_eq!(kernels(10, 2, 3, Skinning::Hybrid), [MuscleShape, MuscleJoint, SkinHybrid, Normals]);
        assert_eq!(kernels(10, 0, 3, Skinning::Hybrid), [SkinLinear, Normals]);
        assert_eq!(kernels(0, 0, 3, Skinning::Linear), []);
    }

    #[test]
    fn a_motion_needs_all_but_the_output() {
        use KernelId::*;
        let options = FrameOptions { dynamics: Some(DynamicsOptions::default()), ..FrameOptions::default() };
        let steps = frame(&counts(10, 2, 3), &options, 1, 0);
        let kernels =
            |of_motion| steps.iter().filter(|s| s.is_of_motion() == of_motion).map(|s| s.kernel).collect::<Vec<_>>();
        let moved = [JointStep, MusclePredict, MuscleProject, MuscleProject, JointStep, MusclePredict, MuscleShape];
        assert_eq!(kernels(true), [&moved[..], &[GroupBound, TrackCarry], &[TrackMarch; 6]].concat());
        assert_eq!(kernels(false), [TrackSpread, Normals]);
    }

    #[test]
    fn a_pose_by_itself_starts_from_geometric_skinning_and_is_forgotten() {
        use KernelId::*;
        let track = TrackOptions { passes: 1, sweeps: 2, smoothings: 2, projections: 2, ..TrackOptions::single_pose() };
        let dynamics = Some(DynamicsOptions::default());
        let options = FrameOptions { track, dynamics, ..FrameOptions::default() };
        let steps = frame(&counts(10, 2, 3), &options, 0, 9);
        let kernels = |of: &dyn Fn(&Step) -> bool| steps.iter().filter(|s| of(s)).map(|s| s.kernel).collect::<Vec<_>>();
        let averages = [TrackAverage; 2];
        let skinned = [GroupBound, SkinDualQuaternion, TrackStart, TrackPlace, TrackMarch];
        let expected = [&skinned[..], &averages, &averages, &[TrackMarch, TrackMarch, TrackSpread, Normals]].concat();
        assert_eq!(kernels(&|s| !s.is_of_motion()), expected, "whatever the number of sub-poses");
        assert_eq!(kernels(&Step::is_of_motion), [JointStep, MusclePredict, MuscleShape], "but its muscles go on");
        assert_eq!(kernels(&|s| s.projects), [TrackAverage, TrackAverage, TrackMarch, TrackMarch]);
        assert!(options.remembers() && !FrameOptions { dynamics: None, ..options }.remembers());
        assert!(FrameOptions::default().remembers());
    }

    #[test]
    fn sub_poses_count_down_to_the_pose() {
        let steps = frame(&counts(10, 0, 3), &FrameOptions::default(), 0, 3);
        let carried: Vec<u32> = steps.iter().filter(|s| s.kernel == KernelId::TrackCarry).map(|s| s.sub_pose).collect();
        assert_eq!(carried, [2, 1, 0]);
        assert!(steps.iter().rev().skip_while(|s| !s.projects).take(3).all(|s| s.projects && s.sub_pose == 0));
        let options = TrackOptions::default();
        let turn = |degrees: f32| options.sub_poses(degrees.to_radians());
        assert_eq!([turn(0.0), turn(19.9), turn(20.1), turn(84.0), turn(5000.0)], [1, 1, 3, 9, 18]);
    }

    #[test]
    fn every_step_reads_what_an_earlier_one_wrote() {
        use Skinning::{DualQuaternion, Hybrid, Implicit, Linear, Weighted};
        let modes = [Implicit, Linear, DualQuaternion, Weighted, Hybrid].map(|s| (s, TrackOptions::default()));
        for (skinning, track) in modes.into_iter().chain([(Implicit, TrackOptions::single_pose())]) {
            let options = FrameOptions { skinning, track, ..FrameOptions::default() };
            // The skin is where the frame before left it.
            let mut written = if track.mode == Tracking::History { vec![Positions::Skin] } else { Vec::new() };
            for step in frame(&counts(5, 1, 1), &options, 2, 3) {
                assert!(step.reads.is_none_or(|r| written.contains(&r)), "{step:?}");
                written.extend(step.writes);
            }
        }
    }
}
