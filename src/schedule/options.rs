//! What a frame is asked for: skinning, the tracker's settings, the dynamics'.

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
    /// Linear skinning, displaced to the rest iso-values of the muscles alone, by a weight per vertex and muscle (paper A,
    /// section 8.7).
    Weighted,
    /// Linear blend skinning in which muscles are joints that swell (paper B, equation 3).
    Hybrid,
}

impl Skinning {
    /// Whether the skin follows muscles, which are shaped, and where they have dynamics moved, for it.
    pub fn follows_muscles(self) -> bool {
        matches!(self, Skinning::Implicit | Skinning::Weighted | Skinning::Hybrid)
    }
}

/// What sets how much a folding joint displaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FoldVolume {
    /// The volume that its groups have lost, measured in every pass.
    #[default]
    Closed,
    /// Its angle.
    Open,
}

/// Where a frame's skin starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tracking {
    /// Where the frame before has left it, moved by the joints (background 2).
    #[default]
    History,
    /// At dual quaternion skinning of its pose: a frame depends on no other (Implicit Skinning 2013, background 1).
    SinglePose,
}

/// Settings of the tracker (prototypes 3; background 1.12 and 2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackOptions {
    /// Where a frame's skin starts, and so how it is relaxed: with a history as rigidly as can be, else to the mean of neighbours.
    pub mode: Tracking,
    /// Passes of a sub-pose that relax the skin along the field after their step.
    pub passes: u32,
    /// Passes after them, in the pose itself, that only take the step, of vertices that have not arrived.
    pub projections: u32,
    /// Sweeps of a relaxation: an even number, since positions go to and fro between two buffers.
    pub sweeps: u32,
    /// Sweeps between the two, an even number as well, that smooth a single pose's skin where it presses against skin.
    pub smoothings: u32,
    /// Share of the Newton step that is taken: .35 in Implicit Skinning's implementations.
    pub relaxation: f32,
    /// Share of it in the last passes.
    pub projection: f32,
    /// Field difference at which a vertex counts as arrived.
    pub tolerance: f32,
    /// Longest step in support radii.
    pub max_step_radii: f32,
    /// How far a sub-pose of a turn of `direct_degrees` draws vertices without contact to linear skinning, 0..=1, and a
    /// smaller turn in proportion: it holds what they forget.
    pub anchor: f32,
    /// Share of a relaxation's way that vertices are spared where skin presses against skin, 0..=1.
    pub contact_hold: f32,
    /// How strongly the skin's rotations follow the field's normal.
    pub normal_weight: f32,
    /// Turn of a joint up to which a pose is one sub-pose, degrees.
    pub direct_degrees: f32,
    /// Turn of a joint in one of several sub-poses, degrees.
    pub degrees: f32,
    /// What sets how much a folding joint displaces.
    pub fold: FoldVolume,
}

impl Default for TrackOptions {
    fn default() -> Self {
        TrackOptions {
            mode: Tracking::History,
            passes: 5,
            projections: 6,
            sweeps: 4,
            smoothings: 0,
            relaxation: 0.35,
            projection: 0.8,
            tolerance: 1e-3,
            max_step_radii: 0.2,
            anchor: 0.1,
            contact_hold: 0.8,
            normal_weight: 0.5,
            direct_degrees: 20.0,
            degrees: 10.0,
            fold: FoldVolume::Closed,
        }
    }
}

impl TrackOptions {
    /// Settings for frames that depend on no other.
    pub fn single_pose() -> TrackOptions {
        TrackOptions {
            mode: Tracking::SinglePose,
            passes: 12,
            sweeps: 2,
            smoothings: 2,
            projections: 6,
            ..TrackOptions::default()
        }
    }

    /// Most sub-poses of one pose.
    pub const MOST_SUB_POSES: u32 = 18;

    /// Sub-poses of a turn by `angle` radians.
    pub fn sub_poses(&self, angle: f32) -> u32 {
        let degrees = angle.to_degrees();
        if degrees <= self.direct_degrees {
            return 1;
        }
        ((degrees / self.degrees).ceil() as u32).clamp(1, Self::MOST_SUB_POSES)
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
    /// Settings of the tracker.
    pub track: TrackOptions,
    /// Muscles in motion; without, their axes are straight.
    pub dynamics: Option<DynamicsOptions>,
}

impl FrameOptions {
    /// Whether a frame depends on those before it.
    pub fn remembers(&self) -> bool {
        match self.skinning {
            Skinning::Implicit => self.track.mode == Tracking::History || self.dynamics.is_some(),
            Skinning::Weighted | Skinning::Hybrid => self.dynamics.is_some(),
            Skinning::Linear | Skinning::DualQuaternion => false,
        }
    }
}
