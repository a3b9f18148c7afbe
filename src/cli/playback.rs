//! Poses of a clip's frames in turn.

use crate::failure::Failure;
use crate::load::Frames;
use sinew::clip::Scene;
use sinew::rig::{Effort, Pose, Rig};

/// A clip on its way from frame to frame. Muscles whose activation cannot change at once depend on the frames before:
/// those that were not asked for are gone through all the same, from the first frame of the clip on.
pub struct Playback<'a> {
    scene: &'a Scene,
    frames: &'a Frames,
    rig: &'a Rig,
    effort: Effort,
    next: u32,
}

impl<'a> Playback<'a> {
    /// Stands before the clip's first frame.
    pub fn new(scene: &'a Scene, frames: &'a Frames, rig: &'a Rig) -> Playback<'a> {
        Playback { scene, frames, rig, effort: Effort::new(), next: 0 }
    }

    /// The pose of a frame. Going back starts the clip anew.
    pub fn pose(&mut self, frame: u32) -> Result<Pose, Failure> {
        if self.rig.drives.is_immediate() {
            return Ok(self.frames.pose(self.scene, frame));
        }
        if frame < self.next {
            self.effort.reset();
            self.next = 0;
        }
        loop {
            let mut pose = self.frames.pose(self.scene, self.next);
            let ratios = self.rig.axis_ratios(&pose);
            self.effort.advance(&self.rig.drives, &mut pose, &ratios).map_err(Failure::input)?;
            self.next += 1;
            if self.next > frame {
                return Ok(pose);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::FrameRange;
    use sinew::clip::ClipChoice;
    use sinew::rig::{BuildOptions, muscle_file};
    use std::path::Path;

    #[test]
    fn a_frame_alone_is_that_frame_of_the_whole_clip() {
        let scene = sinew::io::gltf::from_bytes(include_bytes!("../../assets/arm.glb"), "arm").expect("the arm");
        let text = include_str!("../../assets/arm.muscles.toml");
        let slow = text.replace("width = 0.0290", "width = 0.0290\nattack = 2.0");
        let rig = |text: &str| {
            let file = muscle_file::parse(text, Path::new("arm.muscles.toml")).expect("good");
            Rig::build(scene.character.clone(), &file.muscles, &BuildOptions::default()).expect("a rig")
        };
        let frames = Frames { clip: ClipChoice::Clip(0), fps: 30.0, range: FrameRange { first: 0, last: 20 } };
        let slow = rig(&slow);
        let mut whole = Playback::new(&scene, &frames, &slow);
        let last = (0..=20).map(|frame| whole.pose(frame).expect("a pose")).last().expect("a frame");
        assert_eq!(Playback::new(&scene, &frames, &slow).pose(20).expect("a pose"), last);
        assert_eq!(whole.pose(3).expect("back"), Playback::new(&scene, &frames, &slow).pose(3).expect("a pose"));
        let alone = frames.pose(&scene, 20);
        let parameters =
            |pose| slow.drives.parameters(pose, &slow.axis_ratios(pose)).expect("parameters")[0].activation;
        assert!(parameters(&last) + 0.1 < parameters(&alone), "attack holds it back");
        let quick = rig(text);
        assert_eq!(Playback::new(&scene, &frames, &quick).pose(20).expect("a pose"), alone);
    }
}
