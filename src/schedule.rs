//! A frame as plain data: which kernels run, in what order, on which positions.
//!
//! The GPU and the reference both play this list, so counts and buffers cannot diverge.

/// How skin follows joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Skinning {
    /// Marched to rest iso-values of the posed field, from a linear start.
    #[default]
    Implicit,
    /// Linear blend skinning alone.
    Linear,
    /// Dual quaternion skinning alone.
    DualQuaternion,
}

/// Settings of the march.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarchOptions {
    /// Most steps of a vertex.
    pub max_steps: u32,
    /// Share of the Newton step that is taken: .35 in Implicit Skinning's implementations (background 1.12).
    pub relaxation: f32,
    /// Field difference at which a vertex has arrived.
    pub tolerance: f32,
    /// Longest step in support radii.
    pub max_step_radii: f32,
}

impl Default for MarchOptions {
    fn default() -> Self {
        MarchOptions { max_steps: 40, relaxation: 0.35, tolerance: 1e-4, max_step_radii: 0.2 }
    }
}

/// How stiffness is understood.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// As compliance: a muscle has a frequency of its own, whatever the substeps and iterations are.
    #[default]
    Xpbd,
    /// As paper A has it: the share k of every error that one projection mends. The look depends on substeps and
    /// iterations.
    Pbd,
}

/// In what order a muscle's constraints are projected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solver {
    /// Every second segment, then the others, over-relaxed; then the contacts.
    #[default]
    RedBlack,
    /// All at once, averaged.
    Jacobi,
}

/// What muscles collide with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contacts {
    /// Bones.
    pub bones: bool,
    /// Muscles of the same collision group.
    pub muscles: bool,
    /// The skin, from within.
    pub skin: bool,
}

impl Contacts {
    /// Everything.
    pub const ALL: Contacts = Contacts { bones: true, muscles: true, skin: true };
    /// Nothing.
    pub const NONE: Contacts = Contacts { bones: false, muscles: false, skin: false };
}

/// Settings of the dynamics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicsOptions {
    /// How stiffness is understood.
    pub mode: Mode,
    /// In what order constraints are projected.
    pub solver: Solver,
    /// Iterations over one muscle while the others stand still.
    pub inner: u32,
    /// Iterations over all muscles, 1 to [`DynamicsOptions::MOST_OUTER`].
    pub outer: u32,
    /// Passes over the contacts alone that end a substep, at most; one that moves a particle by less than a micrometre is
    /// its last.
    pub final_passes: u32,
    /// What collides.
    pub contacts: Contacts,
    /// Substeps per second.
    pub rate: u32,
    /// Frequency of a muscle of stiffness .4, hertz: 8 to 24 are useful.
    pub frequency: f32,
    /// Share of a velocity relative to the bones that is left after 1/60 s: .9 in paper A.
    pub retention: f32,
    /// Coefficient of friction with bones and muscles.
    pub friction: f32,
    /// How far a plane between two muscles may be off before it follows them, metres: it brings muscles that press against
    /// one another to rest, for an overlap of two to three times as much. 0 is off.
    pub play: f32,
    /// Displacement relative to the bones under which a particle that presses against a muscle stays where it is in a
    /// substep, metres; 0 is off.
    pub deadband: f32,
    /// Seconds for which muscles settle in the first pose, before anything moves.
    pub settle: f32,
    /// Seconds over which velocities come to their full life after that.
    pub fade: f32,
}

impl Default for DynamicsOptions {
    fn default() -> Self {
        DynamicsOptions {
            mode: Mode::Xpbd,
            solver: Solver::RedBlack,
            inner: 8,
            outer: 2,
            final_passes: 4,
            contacts: Contacts::ALL,
            rate: 240,
            frequency: 12.0,
            retention: 0.9,
            friction: 0.3,
            play: 5e-4,
            deadband: 5e-5,
            settle: 0.5,
            fade: 0.25,
        }
    }
}

impl DynamicsOptions {
    /// Paper A's own dynamics: raw k, 15 iterations, a time step of 1/60 s (background 4.7).
    pub fn pbd() -> DynamicsOptions {
        DynamicsOptions { mode: Mode::Pbd, inner: 15, outer: 1, rate: 60, ..DynamicsOptions::default() }
    }

    /// Most outer iterations.
    pub const MOST_OUTER: u32 = 8;

    /// Length of a substep, seconds.
    pub fn seconds(&self) -> f32 {
        1.0 / self.rate as f32
    }
}

/// What one frame is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameOptions {
    /// How skin follows joints.
    pub skinning: Skinning,
    /// Settings of the march.
    pub march: MarchOptions,
    /// Muscles in motion; without, their axes are straight.
    pub dynamics: Option<DynamicsOptions>,
}

/// A kernel, on whichever side it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum KernelId {
    /// Linear blend skinning.
    SkinLinear,
    /// Dual quaternion skinning.
    SkinDualQuaternion,
    /// Joints at the end of a substep.
    JointStep,
    /// Muscles before anything holds them.
    MusclePredict,
    /// Muscles against their springs and contacts.
    MuscleProject,
    /// Muscle ends, length and width.
    MuscleShape,
    /// Vertices to their rest iso-value.
    March,
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
    /// After the march.
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
}

impl Step {
    /// Whether it moves or shapes muscles, rather than skin. These steps alone carry a motion from frame to frame.
    pub fn is_of_muscles(&self) -> bool {
        use KernelId::{JointStep, MusclePredict, MuscleProject, MuscleShape};
        matches!(self.kernel, JointStep | MusclePredict | MuscleProject | MuscleShape)
    }
}

/// Sizes of a rig that a schedule depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Vertices.
    pub vertices: u32,
    /// Muscles.
    pub muscles: u32,
    /// Points of all muscles' axes together.
    pub points: u32,
    /// Segments of the axis that has most of them.
    pub most_segments: u32,
    /// Field groups; 0 where the rig has no fields.
    pub groups: u32,
}

impl Counts {
    /// Threads that share one muscle in the projection, each with two of its points. A power of two, so that no muscle
    /// stands in two workgroups; short muscles share one.
    pub fn threads_per_muscle(&self) -> u32 {
        (self.most_segments + 1).div_ceil(2).next_power_of_two()
    }

    /// Whether a frame of these options moves muscles.
    pub fn dynamics(&self, options: &FrameOptions) -> Option<DynamicsOptions> {
        let fields = options.skinning == Skinning::Implicit && self.groups > 0 && self.muscles > 0;
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
/// `joints` the joints of the character.
pub fn frame(counts: &Counts, options: &FrameOptions, joints: u32, turns: u32) -> Vec<Step> {
    let implicit = options.skinning == Skinning::Implicit && counts.groups > 0;
    let skin = match options.skinning {
        Skinning::DualQuaternion => KernelId::SkinDualQuaternion,
        Skinning::Implicit | Skinning::Linear => KernelId::SkinLinear,
    };
    let step = |kernel, items, reads, writes| Step { kernel, items, reads, writes, outer: 0, carries: false };
    let mut steps = vec![step(skin, counts.vertices, None, Some(Positions::Skinned))];
    let mut last = Positions::Skinned;
    if let Some(dynamics) = counts.dynamics(options) {
        let joints = step(KernelId::JointStep, joints, None, None);
        let predict = step(KernelId::MusclePredict, counts.muscles, None, None);
        let project = step(KernelId::MuscleProject, counts.muscles * counts.threads_per_muscle(), None, None);
        for _ in 0..turns {
            steps.extend([joints, predict]);
            steps.extend((0..dynamics.outer).map(|outer| Step { outer, ..project }));
        }
        steps.extend([joints, predict].map(|step| Step { carries: true, ..step }));
    }
    if implicit {
        steps.push(step(KernelId::MuscleShape, counts.muscles, None, None));
        steps.push(step(KernelId::March, counts.vertices, Some(last), Some(Positions::Tracked)));
        last = Positions::Tracked;
    }
    steps.push(step(KernelId::Normals, counts.vertices, Some(last), None));
    steps.retain(|s| s.items > 0);
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernels(vertices: u32, muscles: u32, groups: u32, skinning: Skinning) -> Vec<KernelId> {
        let options = FrameOptions { skinning, ..FrameOptions::default() };
        frame(&Counts { vertices, muscles, points: 0, most_segments: 0, groups }, &options, 2, 3)
            .iter()
            .map(|s| s.kernel)
            .collect()
    }

    #[test]
    fn steps_follow_the_frame() {
        use KernelId::*;
        assert_eq!(kernels(10, 2, 3, Skinning::Implicit), [SkinLinear, MuscleShape, March, Normals]);
        assert_eq!(kernels(10, 0, 3, Skinning::Implicit), [SkinLinear, March, Normals]);
        assert_eq!(kernels(10, 2, 0, Skinning::Implicit), [SkinLinear, Normals]);
        assert_eq!(kernels(10, 2, 3, Skinning::DualQuaternion), [SkinDualQuaternion, Normals]);
        assert_eq!(kernels(0, 0, 3, Skinning::Linear), []);
    }

    #[test]
    fn steps_of_muscles_are_all_but_those_of_skin() {
        use KernelId::*;
        let options = FrameOptions { dynamics: Some(DynamicsOptions::default()), ..FrameOptions::default() };
        let steps = frame(&Counts { vertices: 10, muscles: 2, points: 8, most_segments: 3, groups: 3 }, &options, 2, 1);
        let kernels =
            |of_muscles| steps.iter().filter(|s| s.is_of_muscles() == of_muscles).map(|s| s.kernel).collect::<Vec<_>>();
        let moved = [JointStep, MusclePredict, MuscleProject, MuscleProject, JointStep, MusclePredict, MuscleShape];
        assert_eq!(kernels(true), moved);
        assert_eq!(kernels(false), [SkinLinear, March, Normals]);
    }

    #[test]
    fn every_step_reads_what_an_earlier_one_wrote() {
        for skinning in [Skinning::Implicit, Skinning::Linear, Skinning::DualQuaternion] {
            let options = FrameOptions { skinning, ..FrameOptions::default() };
            let mut written = Vec::new();
            for step in
                frame(&Counts { vertices: 5, muscles: 1, points: 30, most_segments: 29, groups: 1 }, &options, 2, 3)
            {
                assert!(step.reads.is_none_or(|r| written.contains(&r)), "{step:?}");
                written.extend(step.writes);
            }
        }
    }
}
