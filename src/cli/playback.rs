//! Poses of a clip's frames in turn.

use crate::failure::Failure;
use crate::load::Frames;
use crate::progress::Progress;
use sinew::clip::Scene;
use sinew::rig::{Effort, Pose, Rig};

/// What a clip moves along with it.
pub trait Moves {
    /// Forgets the motion: the next pose starts anew.
    fn reset(&mut self);

    /// Moves on to the pose of a frame that nobody asked to see.
    fn pass(&mut self, pose: &Pose) -> Result<(), Failure>;
}

/// A clip on its way from frame to frame.
///
/// Muscles in motion, tracked skin, and activations that cannot change at once depend on the frames before: what was not asked
/// for is gone through all the same, from the first frame of the clip on. So a frame does not depend on which others were
/// asked for.
pub struct Playback<'a> {
    scene: &'a Scene,
    frames: &'a Frames,
    rig: &'a Rig,
    /// Whether muscles or skin depend on the frames before.
    moving: bool,
    effort: Effort,
    next: u32,
}

impl<'a> Playback<'a> {
    /// Stands before the clip's first frame; `moving` says whether muscles or skin remember.
    pub fn new(scene: &'a Scene, frames: &'a Frames, rig: &'a Rig, moving: bool) -> Playback<'a> {
        Playback { scene, frames, rig, moving, effort: Effort::new(), next: 0 }
    }

    /// The pose of a frame, which is to be played on `moved` next; brings that up to it. Going back starts the clip anew.
    pub fn pose(&mut self, frame: u32, moved: &mut impl Moves) -> Result<Pose, Failure> {
        if !self.moving && self.rig.drives.is_immediate() {
            return Ok(self.frames.pose(self.scene, frame));
        }
        if frame < self.next || self.next == 0 {
            self.effort.reset();
            moved.reset();
            self.next = 0;
        }
        if self.moving && self.next < frame {
            let progress = Progress::steps("moving on", u64::from(frame - self.next));
            while self.next < frame {
                moved.pass(&self.step()?)?;
                progress.step()?;
            }
        }
        loop {
            let pose = self.step()?;
            if self.next > frame {
                return Ok(pose);
            }
        }
    }

    /// The pose of the next frame.
    fn step(&mut self) -> Result<Pose, Failure> {
        let mut pose = self.frames.pose(self.scene, self.next);
        if !self.rig.drives.is_immediate() {
            let ratios = self.rig.axis_ratios(&pose);
            self.effort.advance(&self.rig.drives, &mut pose, &ratios).map_err(Failure::input)?;
        }
        self.next += 1;
        Ok(pose)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::FrameRange;
    use crate::deform::OnCpu;
    use sinew::clip::ClipChoice;
    use sinew::rig::{BuildOptions, muscle_file};
    use sinew::schedule::{DynamicsOptions, FrameOptions};
    use std::path::Path;
    use std::sync::Arc;

    /// Nothing that moves.
    struct Still;

    impl Moves for Still {
        fn reset(&mut self) {}

        fn pass(&mut self, _: &Pose) -> Result<(), Failure> {
            Ok(())
        }
    }

    #[test]
    fn a_frame_alone_is_that_frame_of_the_whole_clip() {
        let scene = sinew::io::gltf::from_bytes(include_bytes!("../../assets/arm.glb"), "arm").expect("the arm");
        let text = include_str!("../../assets/arm.muscles.toml");
        let slow = text.replace("name = \"biceps\"", "name = \"biceps\"\nattack = 2.0");
        let rig = |text: &str| {
            let file = muscle_file::parse(text, Path::new("arm.muscles.toml")).expect("good");
            Rig::build(scene.character.clone(), &file.muscles, &BuildOptions::default()).expect("a rig")
        };
        let frames = Frames { clip: ClipChoice::Clip(0), fps: 30.0, range: FrameRange { first: 0, last: 20 } };
        let slow = rig(&slow);
        let mut whole = Playback::new(&scene, &frames, &slow, false);
        let last = (0..=20).map(|frame| whole.pose(frame, &mut Still).expect("a pose")).last().expect("a frame");
        assert_eq!(Playback::new(&scene, &frames, &slow, false).pose(20, &mut Still).expect("a pose"), last);
        assert_eq!(
            whole.pose(3, &mut Still).expect("back"),
            Playback::new(&scene, &frames, &slow, false).pose(3, &mut Still).expect("a pose")
        );
        let alone = frames.pose(&scene, 20);
        let parameters =
            |pose| slow.drives.parameters(pose, &slow.axis_ratios(pose)).expect("parameters")[0].activation;
        assert!(parameters(&last) + 0.1 < parameters(&alone), "attack holds it back");
        let quick = rig(text);
        assert_eq!(Playback::new(&scene, &frames, &quick, false).pose(20, &mut Still).expect("a pose"), alone);
    }

    /// The arm as the command builds it, shaken; and what is asked of its frames.
    fn shaken() -> (Scene, Arc<Rig>, FrameOptions, Frames) {
        let scene = sinew::io::gltf::from_bytes(include_bytes!("../../assets/arm.glb"), "arm").expect("the arm");
        let text = include_str!("../../assets/arm.muscles.toml");
        let file = muscle_file::parse(text, Path::new("arm.muscles.toml")).expect("good");
        let options = FrameOptions { dynamics: Some(DynamicsOptions::default()), ..FrameOptions::default() };
        let input = crate::args::Input { file: "arm.glb".into(), muscles: None };
        let rig = crate::load::rig(&input, &scene, &file, true, options.dynamics.as_ref()).expect("a rig");
        let clip = scene.choose_clip(Some("shake")).expect("the clip");
        let frames = Frames { clip, fps: 30.0, range: FrameRange { first: 0, last: 29 } };
        (scene, Arc::new(rig), options, frames)
    }

    #[test]
    fn a_frame_of_moving_muscles_does_not_depend_on_which_others_are_asked_for() {
        let (scene, rig, options, frames) = shaken();
        let playback = || Playback::new(&scene, &frames, &rig, true);
        let skins = |numbers: &[u32], playback: &mut Playback, cpu: &mut OnCpu| {
            let skin = |&number| {
                let pose = playback.pose(number, cpu).expect("a pose");
                cpu.skin(&pose).expect("a frame").positions
            };
            numbers.iter().map(skin).last().expect("a frame")
        };
        let fresh = || OnCpu::new(&rig, &options);
        let (mut on, mut whole) = (playback(), fresh());
        let last = skins(&(0..=20).collect::<Vec<_>>(), &mut on, &mut whole);
        assert_eq!(skins(&[20], &mut playback(), &mut fresh()), last, "alone");
        assert_eq!(skins(&[3, 4, 11, 20], &mut playback(), &mut fresh()), last, "cut differently");
        assert_eq!(skins(&[9, 20], &mut on, &mut whole), last, "after going back");
        assert_eq!(skins(&[20], &mut playback(), &mut whole), last, "on what has played before");
        // Muscles at rest in the same pose are not where the motion has taken them.
        let alone = fresh().skin(&frames.pose(&scene, 20)).expect("a frame").positions;
        let apart = last.iter().zip(&alone).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(apart > 1e-4, "the motion must be seen: {apart} m");
    }

    #[test]
    fn muscles_at_rest_leave_the_skin_where_it_is() {
        let (scene, rig, options, _) = shaken();
        let frames = Frames { clip: ClipChoice::Rest, fps: 30.0, range: FrameRange { first: 0, last: 0 } };
        let moved = |rig: &Arc<Rig>| {
            let skin = OnCpu::new(rig, &options).skin(&frames.pose(&scene, 0)).expect("a frame");
            let pairs = skin.positions.iter().zip(&rig.character.positions_rest);
            pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max) / rig.character.height_rest()
        };
        assert!(moved(&rig) < 1e-5, "{} of the height", moved(&rig));
        let file = muscle_file::parse(include_str!("../../assets/arm.muscles.toml"), Path::new("m")).expect("good");
        let straight = Rig::build(scene.character.clone(), &file.muscles, &BuildOptions::default()).expect("a rig");
        assert!(moved(&Arc::new(straight)) > 1e-5, "axes that have not settled must be seen");
    }
}
