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

/// What one frame is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameOptions {
    /// How skin follows joints.
    pub skinning: Skinning,
    /// Settings of the march.
    pub march: MarchOptions,
}

/// A kernel, on whichever side it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum KernelId {
    /// Linear blend skinning.
    SkinLinear,
    /// Dual quaternion skinning.
    SkinDualQuaternion,
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
    /// Field groups; 0 where the rig has no fields.
    pub groups: u32,
}

/// The steps of one frame, in order. Steps without work are left out.
pub fn frame(counts: &Counts, options: &FrameOptions) -> Vec<Step> {
    let implicit = options.skinning == Skinning::Implicit && counts.groups > 0;
    let skin = match options.skinning {
        Skinning::DualQuaternion => KernelId::SkinDualQuaternion,
        Skinning::Implicit | Skinning::Linear => KernelId::SkinLinear,
    };
    let step = |kernel, items, reads, writes| Step { kernel, items, reads, writes };
    let mut steps = vec![step(skin, counts.vertices, None, Some(Positions::Skinned))];
    let mut last = Positions::Skinned;
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
        frame(&Counts { vertices, muscles, points: 0, groups }, &options).iter().map(|s| s.kernel).collect()
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
    fn every_step_reads_what_an_earlier_one_wrote() {
        for skinning in [Skinning::Implicit, Skinning::Linear, Skinning::DualQuaternion] {
            let options = FrameOptions { skinning, ..FrameOptions::default() };
            let mut written = Vec::new();
            for step in frame(&Counts { vertices: 5, muscles: 1, points: 30, groups: 1 }, &options) {
                assert!(step.reads.is_none_or(|r| written.contains(&r)), "{step:?}");
                written.extend(step.writes);
            }
        }
    }
}
