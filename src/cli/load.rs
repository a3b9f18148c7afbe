//! From the command line to a rig and the frames to play.

use crate::args::{Dynamics, FrameRange, Input, Motion, Skin, TrackingArg};
use crate::failure::Failure;
use crate::progress::Progress;
use sinew::clip::{ClipChoice, Scene};
use sinew::error::{RigError, WeightError};
use sinew::rig::muscle_file::{self, MuscleFile};
use sinew::rig::{BuildOptions, Pose, Rig};
use sinew::schedule::{DynamicsOptions, FrameOptions, Skinning};
use std::num::NonZeroUsize;
use std::path::Path;

/// Most threads per core: more of them only take memory.
const THREADS_PER_CORE: usize = 4;

/// Sets the number of worker threads, within what the machine's cores can use.
pub fn threads(count: Option<NonZeroUsize>) -> Result<(), Failure> {
    let Some(count) = count else { return Ok(()) };
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let used = count.get().min(cores * THREADS_PER_CORE);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(used).build_global();
    pool.map_err(|error| Failure::Input(format!("--threads {count}: {error}; give a smaller number")))
}

/// Reads the character and its muscles; what is odd about the muscles joins the scene's notes.
pub fn input(input: &Input) -> Result<(Scene, MuscleFile), Failure> {
    let muscles = input.muscles.as_deref().map(muscle_file::read).transpose().map_err(Failure::input)?;
    let mut scene = sinew::io::gltf::read(&input.file).map_err(Failure::input)?;
    let keyed: Vec<(&str, &str)> = scene
        .clips
        .iter()
        .flat_map(|clip| clip.muscle_channels.iter().map(|channel| (&clip.name[..], &channel.muscle[..])))
        .collect();
    let Some(mut muscles) = muscles else {
        if let Some((clip, muscle)) = keyed.first() {
            let note = format!("clip `{clip}` keys muscle `{muscle}`, and there are no muscles without --muscles FILE");
            scene.notes.push(note);
        }
        return Ok((scene, MuscleFile::default()));
    };
    muscles.check(&scene.character).map_err(Failure::input)?;
    let notes = [muscles.notes_beside(&scene.character), muscles.notes_on_keyed(keyed)].concat();
    muscles.notes.extend(notes);
    scene.notes.extend(muscles.notes.iter().cloned());
    Ok((scene, muscles))
}

/// What the command line asks of every frame; muscles move where there are some and `fields` for them to act in.
pub fn options(skin: Skin, dynamics: &Dynamics, muscles: &MuscleFile, fields: bool) -> Result<FrameOptions, Failure> {
    if by_weights(skin.skinning.into()) && muscles.muscles.is_empty() {
        return Err(Failure::input(WeightError::NoMuscles));
    }
    let single = skin.tracking == TrackingArg::Single;
    if single && Skinning::from(skin.skinning) != Skinning::Implicit {
        let text = "--tracking single needs --skinning implicit: no other skinning starts from a frame before";
        return Err(Failure::Usage(text.into()));
    }
    // A pose by itself has no motion for muscles to follow, unless one is asked for.
    let moves = fields && !muscles.muscles.is_empty() && (!single || dynamics.is_asked());
    let dynamics = dynamics.options()?.filter(|_| moves);
    Ok(FrameOptions { skinning: skin.skinning.into(), track: skin.tracking.into(), dynamics })
}

/// Builds the rig; the paths of `input` are for messages. Without `fields`, which are what takes long, only geometric
/// skinning is to be had and muscles have no shape. With `dynamics` muscles lie at rest where these let them come to rest.
pub fn rig(
    input: &Input,
    scene: &Scene,
    muscles: &MuscleFile,
    fields: bool,
    dynamics: Option<&DynamicsOptions>,
) -> Result<Rig, Failure> {
    let mut rig = built(input, scene, muscles, fields)?;
    if let Some(dynamics) = dynamics {
        let _progress = Progress::unknown("letting muscles settle");
        sinew::dynamics::settle(&mut rig, dynamics);
    }
    Ok(rig)
}

/// [`rig`] for frames of given options.
pub fn rig_for(
    options: &FrameOptions,
    input: &Input,
    scene: &Scene,
    muscles: &MuscleFile,
    fields: bool,
) -> Result<Rig, Failure> {
    let rig = rig(input, scene, muscles, fields, options.dynamics.as_ref())?;
    if by_weights(options.skinning) {
        let named = |error| Failure::Input(format!("{}: {error}", input.file.display()));
        rig.check_weights().map_err(named)?;
    }
    Ok(rig)
}

/// Whether muscles move the skin by weights, so that there must be some.
fn by_weights(skinning: Skinning) -> bool {
    matches!(skinning, Skinning::Weighted | Skinning::Hybrid)
}

fn built(input: &Input, scene: &Scene, muscles: &MuscleFile, fields: bool) -> Result<Rig, Failure> {
    let _progress = Progress::unknown(if fields { "fitting fields" } else { "building the rig" });
    let (bones, bone_meshes) = (muscles.bones.clone(), scene.bone_meshes(&muscles.bones));
    let (groups, joints) = (muscles.groups.clone(), muscles.joints.clone());
    let options = BuildOptions { fields, groups, bones, bone_meshes, joints, ..BuildOptions::default() };
    Rig::build(scene.character.clone(), &muscles.muscles, &options).map_err(|error| match &error {
        RigError::Muscle(error) => Failure::input(muscles.locate(error)),
        RigError::Group(error) => Failure::input(muscles.locate_group(error)),
        RigError::Joint(error) => Failure::input(muscles.locate_joint(error)),
        RigError::Bone(error) => Failure::input(muscles.locate_bone(error)),
        _ => Failure::Input(format!("{}: {error}", input.file.display())),
    })
}

/// Notes muscles that nothing will come of, because the rig has no `fields` for them to act on.
pub fn note_idle_muscles(scene: &mut Scene, muscles: &MuscleFile, fields: bool) {
    if !fields && !muscles.muscles.is_empty() {
        scene.notes.push("--muscles moves no skin without --skinning implicit, weighted or hybrid".into());
    }
}

/// How many vertices fields or muscles can move under a skinning; none where it uses neither.
pub fn active(rig: &Rig, skinning: Skinning) -> Option<usize> {
    match skinning {
        Skinning::Implicit => Some(rig.active_count()),
        Skinning::Weighted | Skinning::Hybrid => Some(rig.weights.followers()),
        Skinning::Linear | Skinning::DualQuaternion => None,
    }
}

/// What a result says of [`active`], where there is something to say.
pub fn inactive_text(active: Option<usize>) -> &'static str {
    match active {
        Some(0) => "\n0 vertices follow fields: the skin is the same as with --skinning linear",
        _ => "",
    }
}

/// Most frames of one run: above it a clip's end is a mistake rather than a wish.
const MOST_FRAMES: u32 = 1_000_000;

/// Frames of one clip: frame `k` is at `k / fps` seconds after its start.
#[derive(Clone, Copy, Debug)]
pub struct Frames {
    /// The clip.
    pub clip: ClipChoice,
    /// Frames per second.
    pub fps: f32,
    /// First and last frame.
    pub range: FrameRange,
}

impl Frames {
    /// Chooses the clip and the frames that the command line asks for; `file` is for messages.
    pub fn choose(file: &Path, scene: &Scene, motion: &Motion) -> Result<Frames, Failure> {
        let named = |error: &dyn std::fmt::Display| Failure::Input(format!("{}: {error}", file.display()));
        let clip = scene.choose_clip(motion.clip.as_deref()).map_err(|error| named(&error))?;
        let last = scene.frame_count(clip, motion.fps).saturating_sub(1);
        let range = motion.frames.unwrap_or(FrameRange { first: 0, last });
        if range.last > last {
            return Err(named(&format!(
                "--frames {}..{} is outside {}, which has frames 0..{last} at {} fps; give a range within them",
                range.first,
                range.last,
                clip_name(scene, clip),
                motion.fps
            )));
        }
        // A clip of 2^32 frames or more ends at the largest number, so one is added with care.
        if range.last - range.first >= MOST_FRAMES {
            return Err(named(&format!(
                "{} has {} frames at {} fps, more than {MOST_FRAMES}; give fewer with --frames A..B",
                clip_name(scene, clip),
                u64::from(range.last - range.first) + 1,
                motion.fps
            )));
        }
        Ok(Frames { clip, fps: motion.fps, range })
    }

    /// How many frames there are.
    pub fn count(&self) -> u32 {
        self.range.last - self.range.first + 1
    }

    /// All frame numbers, ascending.
    pub fn numbers(&self) -> impl ExactSizeIterator<Item = u32> + use<> {
        let first = self.range.first;
        (0..self.count()).map(move |i| first + i)
    }

    /// At most `most` frame numbers, evenly spread from the first to the last.
    #[cfg(feature = "gpu")]
    pub fn spread(&self, most: u32) -> Vec<u32> {
        let count = self.count().min(most);
        let place = |i: u32| u64::from(i) * u64::from(self.count() - 1) / u64::from(count.max(2) - 1);
        (0..count).map(|i| self.range.first + place(i) as u32).collect()
    }

    /// The pose of a frame.
    pub fn pose(&self, scene: &Scene, frame: u32) -> Pose {
        scene.pose(self.clip, frame as f32 / self.fps)
    }

    /// In words, for results.
    pub fn describe(&self, scene: &Scene) -> String {
        let FrameRange { first, last } = self.range;
        format!("{}, frames {first}..{last} at {} fps", clip_name(scene, self.clip), self.fps)
    }
}

/// A clip in words.
pub fn clip_name(scene: &Scene, clip: ClipChoice) -> String {
    match clip {
        ClipChoice::Rest => "the bind pose".into(),
        ClipChoice::Default => "the file's own pose".into(),
        ClipChoice::Clip(index) => match scene.clips.get(index) {
            Some(clip) => format!("clip `{}`", clip.name),
            None => format!("clip {index}"),
        },
        ClipChoice::Test(clip) => format!("clip `{}`", clip.name()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clip_without_end_is_refused_and_a_part_of_it_is_not() {
        let mut scene = sinew::io::gltf::from_bytes(include_bytes!("../../assets/arm.glb"), "arm").expect("the arm");
        scene.clips[0].end = 1.4e8;
        let choose = |frames| {
            let motion = Motion { clip: None, frames, fps: 30.0 };
            Frames::choose(Path::new("arm.glb"), &scene, &motion)
        };
        for frames in [None, Some(FrameRange { first: 0, last: MOST_FRAMES })] {
            let Err(Failure::Input(line)) = choose(frames) else { panic!("not refused") };
            assert!(line.contains("arm.glb") && line.contains("curl") && line.contains("--frames A..B"), "{line}");
        }
        let late = FrameRange { first: 2_000_000_000, last: 2_000_999_999 };
        let frames = choose(Some(late)).expect("a million frames");
        assert_eq!((frames.count(), frames.numbers().last()), (MOST_FRAMES, Some(late.last)));
    }

    #[cfg(feature = "gpu")]
    fn frames(first: u32, last: u32) -> Frames {
        Frames { clip: ClipChoice::Rest, fps: 30.0, range: FrameRange { first, last } }
    }

    #[cfg(feature = "gpu")]
    #[test]
    fn frames_spread_from_end_to_end() {
        assert_eq!(frames(0, 9).spread(10), (0..10).collect::<Vec<_>>());
        assert_eq!(frames(5, 25).spread(3), [5, 15, 25]);
        assert_eq!(frames(7, 7).spread(10), [7]);
        assert_eq!(frames(7, 9).spread(1), [7]);
    }
}
