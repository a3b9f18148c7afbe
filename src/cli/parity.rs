//! `sinew parity`: the GPU against the CPU reference, stage by stage.

use crate::args;
use crate::failure::Failure;

#[cfg(not(feature = "gpu"))]
pub fn run(_: &args::Parity) -> Result<(), Failure> {
    Err(Failure::Device("parity compares with a GPU; build sinew with feature `gpu`".into()))
}

#[cfg(feature = "gpu")]
pub fn run(args: &args::Parity) -> Result<(), Failure> {
    on_device::run(args)
}

#[cfg(feature = "gpu")]
mod on_device {
    use super::*;
    use crate::args::Device;
    use crate::device::{self, OnDevice};
    use crate::load::{self, Frames};
    use crate::playback::{Moves, Playback};
    use crate::print;
    use crate::progress::Progress;
    use glam::Vec4;
    use serde::Serialize;
    use sinew::dynamics::Particle;
    use sinew::field::muscle::AxisPoint;
    use sinew::parity::{self, CpuResult, StageReport, compare, stop_counts};
    use sinew::reference::{Motion, Reference, Trace};
    use sinew::rig::Pose;
    use sinew::schedule::FrameOptions;
    use sinew::tracking::Track;
    use std::fmt::Write;
    use std::sync::Arc;

    /// Frames compared where none are asked for.
    const FRAMES: u32 = 10;

    #[derive(Serialize)]
    struct Compared {
        character: String,
        device: String,
        clip: String,
        frames: Vec<u32>,
        vertices: usize,
        active: usize,
        pass: bool,
        stages: Vec<StageReport>,
        /// Vertices by stop reason over all frames, on the CPU.
        stops: Vec<(String, usize)>,
    }

    pub fn run(args: &args::Parity) -> Result<(), Failure> {
        if args.compute.device == Device::Cpu {
            return Err(Failure::Device(
                "parity compares an adapter with the CPU; give --device auto or its name".into(),
            ));
        }
        load::threads(args.compute.threads)?;
        args.dynamics.options()?;
        let (mut scene, muscles) = load::input(&args.input)?;
        let frames = Frames::choose(&args.input.file, &scene, &args.motion)?;
        let numbers = if args.motion.frames.is_some() { frames.numbers().collect() } else { frames.spread(FRAMES) };
        let fields = args.skin.needs_fields();
        let options = load::options(args.skin, &args.dynamics, &muscles, fields)?;
        let headless = device::open(&args.compute.device)?;
        load::note_idle_muscles(&mut scene, &muscles, fields);
        let rig = Arc::new(load::rig_for(&options, &args.input, &scene, &muscles, fields)?);
        let device = OnDevice::new(headless, &rig, &options)?;
        let motion = Motion::new(&rig, &options);
        let mut both = Both { device, reference: Reference::new(&rig), motion, options };
        let mut compared = Compared {
            character: scene.character.name.clone(),
            device: both.device.headless.info.name.clone(),
            clip: load::clip_name(&scene, frames.clip),
            frames: numbers.clone(),
            vertices: scene.character.vertex_count(),
            active: load::active(&rig, options.skinning).unwrap_or_default(),
            pass: true,
            stages: Vec::new(),
            stops: stop_counts(&[]).iter().map(|(reason, n)| (format!("{reason:?}"), *n)).collect(),
        };
        let progress = Progress::steps("comparing", numbers.len() as u64);
        let mut playback = Playback::new(&scene, &frames, &rig, options.remembers());
        for &number in &numbers {
            let pose = playback.pose(number, &mut both)?;
            let gpu = both.device.stages(&pose)?;
            let trace = both.next(&pose)?;
            let stages = compare(&gpu, CpuResult(&trace), scene.character.height_rest());
            if compared.stages.is_empty() {
                compared.stages = stages;
            } else {
                for (all, one) in compared.stages.iter_mut().zip(&stages) {
                    all.merge(one);
                }
            }
            both.join(&gpu.particles, &gpu.axes, &gpu.tracked, &gpu.tracks);
            // Added up by frame: the reports of a whole clip would take gigabytes.
            for ((_, all), (_, one)) in compared.stops.iter_mut().zip(stop_counts(&trace.tracks)) {
                *all += one;
            }
            progress.step()?;
        }
        drop(progress);
        compared.pass = compared.stages.iter().all(|stage| stage.pass);
        print::noted(args.json, &compared, &scene.notes, table)?;
        verdict(&compared.character, &compared.stages)
    }

    /// Either side, moved by the same clip.
    struct Both<'a> {
        device: OnDevice,
        reference: Reference<'a>,
        motion: Motion,
        options: FrameOptions,
    }

    impl Both<'_> {
        /// The reference's next frame, which the device has played already.
        ///
        /// Where muscles press on one another, a last bit decides within a frame which of them gives way. What follows
        /// from their places is then judged on the device's own, and they by themselves.
        fn next(&mut self, pose: &Pose) -> Result<Trace, Failure> {
            let skin = self.motion.skin.clone();
            let mut trace = self.reference.next(&mut self.motion, pose, &self.options).map_err(Failure::input)?;
            if let Some(simulation) = &mut self.motion.simulation
                && parity::touching(&trace.particles)
            {
                let iterates = self.device.shaped()?.iterates;
                simulation.iterates[..iterates.len()].copy_from_slice(&iterates);
                self.motion.skin = skin;
                self.reference.reshape(&mut self.motion, pose, &self.options, &mut trace).map_err(Failure::input)?;
            }
            Ok(trace)
        }

        /// Lets the reference go on from the device's state of this frame. So every frame starts from one state, also those
        /// between the compared ones: muscles that press on one another, and skin in a fold, magnify rounding errors from
        /// frame to frame, and the figures are to be those of one frame.
        fn join(&mut self, particles: &[Particle], axes: &[AxisPoint], positions: &[Vec4], tracks: &[Track]) {
            if let Some(skin) = &mut self.motion.skin {
                skin.positions.copy_from_slice(positions);
                skin.tracks.copy_from_slice(tracks);
            }
            if let Some(simulation) = &mut self.motion.simulation {
                simulation.resume(particles, axes);
            }
        }
    }

    impl Moves for Both<'_> {
        fn reset(&mut self) {
            self.device.reset();
            self.motion.reset(self.reference.rig());
        }

        fn pass(&mut self, pose: &Pose) -> Result<(), Failure> {
            self.device.pass(pose)?;
            self.reference.advance(&mut self.motion, pose, &self.options).map_err(Failure::input)?;
            let shaped = self.device.shaped()?;
            let (positions, tracks) = self.device.tracked()?;
            self.join(&shaped.particles, &shaped.axes, &positions, &tracks);
            Ok(())
        }
    }

    /// Findings where a stage is out of tolerance.
    fn verdict(character: &str, stages: &[StageReport]) -> Result<(), Failure> {
        let failed: Vec<_> = stages.iter().filter(|s| !s.pass).map(|s| s.stage).collect();
        if failed.is_empty() {
            return Ok(());
        }
        Err(Failure::Findings(format!("{character} out of tolerance: {}", failed.join(", "))))
    }

    fn table(compared: &Compared) -> String {
        let mut text = String::new();
        let mut line = |s: String| {
            text.push_str(&s);
            text.push('\n');
        };
        line(format!(
            "{}: {} vertices, {} active; {}, {} frames; {} against the CPU reference",
            compared.character,
            compared.vertices,
            compared.active,
            compared.clip,
            compared.frames.len(),
            compared.device
        ));
        line(format!(
            "{:<18}{:>9} {:>10} {:>10} {:>6} {:>9} {:>9} {:>10}",
            "stage", "items", "max abs", "max rel", "over", "worst", "stops", "tolerance"
        ));
        for s in &compared.stages {
            let worst = s.worst.map_or("-".into(), |w| w.to_string());
            let stops = s.stop_agreement.map_or("-".into(), |a| format!("{:.3} %", a * 100.0));
            let mut row = format!(
                "{:<18}{:>9} {:>10.2e} {:>10.2e} {:>6}",
                s.stage, s.items, s.max_absolute, s.max_relative, s.over
            );
            let verdict = if s.pass { "ok" } else { "OUT" };
            // Writing to a string cannot fail.
            let _ = write!(row, " {worst:>9} {stops:>9} {:>10.0e} {verdict}", s.tolerance.absolute);
            line(row);
        }
        let stops: Vec<_> = compared.stops.iter().filter(|(_, n)| *n > 0).map(|(r, n)| format!("{r} {n}")).collect();
        if !stops.is_empty() {
            line(format!("stop reasons: {}", stops.join(", ")));
        }
        text
    }

    #[cfg(test)]
    mod tests {
        use super::*;
        use sinew::parity::{SKINNED, vectors};

        #[test]
        fn a_stage_out_of_tolerance_is_a_finding() {
            let cpu = [glam::Vec4::ONE; 3];
            let same = vectors("skinned", &cpu, &cpu, 1.0, SKINNED);
            let apart = vectors("tracked", &[glam::Vec4::ZERO; 3], &cpu, 1.0, SKINNED);
            assert!(verdict("arm", std::slice::from_ref(&same)).is_ok());
            let Err(Failure::Findings(why)) = verdict("arm", &[same, apart]) else { panic!("no finding") };
            assert_eq!(why, "arm out of tolerance: tracked");
        }
    }
}
