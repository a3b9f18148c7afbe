//! What frames take, on the CPU and on a device.

use super::Stage;
use super::motion::Play;
use crate::dynamics::{Residual, Skins, residuals};
use crate::error::FigureError;
use crate::reference::{Motion, Reference};
use crate::rig::{Pose, Rig};
use crate::schedule::{DynamicsOptions, FrameOptions};
use std::sync::Arc;
use std::time::Instant;

/// First frames, which are not measured: memory and caches are cold, and muscles settle.
const WARM: usize = 2;
/// Frames whose median is given.
pub(super) const MEASURED: usize = 7;

/// Seconds for which muscles settle in the first frame: enough to come to where the motion begins, in a moment.
const SETTLE: f32 = 0.1;

/// What is measured: a rig on its way through poses.
pub(super) struct Case<'a> {
    rig: &'a Arc<Rig>,
    /// Consecutive frames, of which as many are taken as are needed.
    poses: &'a [Pose],
    /// How its muscles move.
    options: DynamicsOptions,
}

impl<'a> Case<'a> {
    /// A rig that moves as `options` say, but for the time to settle.
    pub fn new(rig: &'a Arc<Rig>, poses: &'a [Pose], options: DynamicsOptions) -> Case<'a> {
        Case { rig, poses, options: DynamicsOptions { settle: SETTLE, ..options } }
    }
}

/// What was measured. Times are medians over frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Measured {
    /// Moving the muscles, milliseconds a frame.
    pub dynamics: f64,
    /// Shaping them and deforming the skin, milliseconds a frame.
    pub skin: f64,
    /// The worst of all muscles in all measured frames.
    pub residual: Residual,
}

/// Times and residuals frame by frame.
#[derive(Default)]
struct Log {
    dynamics: Vec<f64>,
    skin: Vec<f64>,
    residual: Residual,
}

impl Log {
    fn measured(self) -> Measured {
        Measured { dynamics: median(self.dynamics), skin: median(self.skin), residual: self.residual }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}

/// Milliseconds since a moment.
fn since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1000.0
}

/// The CPU in words.
pub(super) fn cpu() -> String {
    format!("CPU, {} threads", rayon::current_num_threads())
}

/// The device in words, where the stage has one.
pub(super) fn device(stage: &Stage<'_>) -> Option<String> {
    #[cfg(feature = "gpu")]
    return stage.device.map(|device| device.info.name.clone());
    #[cfg(not(feature = "gpu"))]
    return stage.arm.and(None);
}

/// Measures on the CPU; the skin only where it is wanted.
pub(super) fn on_cpu(case: &Case<'_>, with_skin: bool) -> Result<Measured, FigureError> {
    let mut play = Play::new(case.rig, &case.options);
    let frame_options = FrameOptions::default();
    let mut motion = Motion::new(case.rig, &frame_options);
    let mut log = Log::default();
    for (frame, pose) in case.poses.iter().take(WARM + MEASURED).enumerate() {
        let start = Instant::now();
        play.advance(pose)?;
        let moved = since(start);
        let start = Instant::now();
        play.shape();
        if with_skin {
            let (muscles, axes) = (play.shaped.clone(), play.simulation.axes.clone());
            Reference::new(case.rig).skin(&mut motion, pose, &frame_options, muscles, axes)?;
        }
        if frame >= WARM {
            log.dynamics.push(moved);
            log.skin.push(since(start));
            let found = residuals(&play.simulation, Skins::of(case.rig), &play.inputs, &case.options);
            log.residual = found.into_iter().fold(log.residual, Residual::worse);
        }
    }
    Ok(log.measured())
}

#[cfg(feature = "gpu")]
pub(super) use on_device::Bench;

#[cfg(feature = "gpu")]
mod on_device {
    use super::*;
    use crate::dynamics::{Bodies, Simulation};
    use crate::gpu::{Batch, Headless, Kernels, Output, RigBuffers, readback};
    use crate::rig::FrameInputs;
    use crate::schedule::{KernelId, Step};

    /// A device with its kernels.
    pub struct Bench<'a> {
        headless: &'a Headless,
        kernels: Kernels,
    }

    impl<'a> Bench<'a> {
        /// Builds the kernels.
        pub fn new(headless: &'a Headless) -> Result<Bench<'a>, FigureError> {
            Ok(Bench { headless, kernels: Kernels::new(&headless.device)? })
        }

        /// Measures on the device, from submitting to the end of waiting; the skin only where it is wanted.
        pub fn measure(&self, case: &Case<'_>, with_skin: bool) -> Result<Measured, FigureError> {
            let Headless { device, queue, .. } = self.headless;
            let buffers = Arc::new(RigBuffers::upload(device, Arc::clone(case.rig))?);
            let mut batch = Batch::new(&self.kernels, device, queue, &buffers, 1, Output::Owned)?;
            batch.set_options(queue, &FrameOptions { dynamics: Some(case.options), ..FrameOptions::default() });
            let mut log = Log::default();
            let mut simulation = Simulation::new(Arc::new(Bodies::new(case.rig)));
            for (frame, pose) in case.poses.iter().take(WARM + MEASURED).enumerate() {
                batch.set_pose(queue, 0, pose)?;
                let start = Instant::now();
                self.headless.run(|encoder| batch.encode_where(encoder, None, Step::moves))?;
                let moved = since(start);
                let start = Instant::now();
                // Shapes at least: the axes are read by the next frame's prediction.
                let shapes = |step: &Step| step.kernel == KernelId::MuscleShape;
                let wanted = |step: &Step| !step.moves() && (with_skin || shapes(step));
                self.headless.run(|encoder| batch.encode_where(encoder, None, wanted))?;
                if frame >= WARM {
                    log.dynamics.push(moved);
                    log.skin.push(since(start));
                    simulation.particles = readback::read(self.headless, batch.particles(), ..)?;
                    simulation.iterates = readback::read(self.headless, batch.iterates(), ..)?;
                    let inputs = FrameInputs::new(case.rig, pose)?;
                    let found = residuals(&simulation, Skins::of(case.rig), &inputs, &case.options);
                    log.residual = found.into_iter().fold(log.residual, Residual::worse);
                }
            }
            Ok(log.measured())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::motion::tests::arm;
    use super::*;

    #[test]
    fn a_median_is_no_mean() {
        assert_eq!(median(vec![9.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(Vec::new()), 0.0);
    }

    #[test]
    fn what_is_measured_is_the_motion() {
        let arm = arm();
        let measure = |poses| {
            let case = Case::new(&arm.settled, poses, DynamicsOptions::default());
            on_cpu(&case, true).expect("frames")
        };
        let found = measure(&arm.shake[..]);
        assert!(found.dynamics > 0.0 && found.skin > 0.0, "{found:?}");
        assert!(found.residual.bone < 1e-3 && found.residual.elastic > 0.0, "{found:?}");
        assert_eq!(measure(&arm.shake[..WARM]).dynamics, 0.0, "what is cold is not measured");
    }
}
