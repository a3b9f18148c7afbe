//! `extract --meshes`: the surfaces of the muscles that were found, lofted over their sections, one OBJ file per frame.

use crate::args;
use crate::bake::Sequence;
use crate::failure::Failure;
use crate::load::Frames;
use crate::progress::Progress;
use serde::Serialize;
use sinew::clip::Scene;
use sinew::extract::{
    Extracted,
    loft::{Bound, Loft},
};
use sinew::field::muscle::{AxisPoint, MuscleFrame, mesh::Surface};
use sinew::io::{atomic::FileSet, obj::Objects};
use sinew::rig::{BuildOptions, FrameInputs, MuscleSpec, Pose, Rig};
use sinew::wrap::{self, ShapeInput};
use std::path::{Path, PathBuf};

/// What was written.
#[derive(Serialize)]
pub struct Written {
    folder: PathBuf,
    /// Files, one per frame.
    files: usize,
    /// Muscles in each.
    muscles: usize,
    /// Volume of all of them at rest, cubic metres.
    volume: f64,
}

/// The muscles of one pose.
struct Moment {
    pose: Pose,
    shaped: Vec<MuscleFrame>,
    axes: Vec<AxisPoint>,
}

impl Moment {
    /// Muscles' axes lie straight, or round what they are wrapped round.
    fn of(rig: &Rig, pose: Pose) -> Result<Moment, Failure> {
        let inputs = FrameInputs::new(rig, &pose).map_err(Failure::input)?;
        let mut shaped = vec![MuscleFrame::default(); rig.muscles.len()];
        let mut axes = vec![AxisPoint::default(); rig.point_count as usize];
        let input = ShapeInput { joints: &inputs.joints, inputs: &inputs.muscles, iterates: &[], wraps: &rig.wraps };
        wrap::shape(&rig.muscles, &input, &mut shaped, &mut axes);
        Ok(Moment { pose, shaped, axes })
    }

    fn points(&self, muscle: usize) -> &[AxisPoint] {
        self.shaped[muscle].points(&self.axes)
    }
}

/// The character with the muscles: which of its joints carries each of them is told by their fields.
fn rig(scene: &Scene, lofted: &[&Extracted]) -> Result<Rig, Failure> {
    let _progress = Progress::unknown("fitting fields");
    let specs: Vec<MuscleSpec> = lofted.iter().map(|m| m.spec.clone()).collect();
    Rig::build(scene.character.clone(), &specs, &BuildOptions::default()).map_err(Failure::input)
}

/// Writes the muscles at rest, or moved by a clip.
pub fn write(args: &args::Extract, folder: &Path, scene: &Scene, found: &[&Extracted]) -> Result<Written, Failure> {
    let place = Sequence::of(folder, "muscles").ok_or_else(|| {
        Failure::Input(format!("--meshes {}: is no OBJ file; give NAME.obj or a folder", folder.display()))
    })?;
    let motion =
        args::Motion { clip: args.clip.clone().or_else(|| Some("rest".into())), frames: args.frames, fps: args.fps };
    let frames = Frames::choose(&args.file, scene, &motion)?;
    let mut set = FileSet::open(&place.folder).map_err(Failure::input)?;
    let lofted: Vec<&Extracted> = found.iter().copied().filter(|m| m.loft.is_some()).collect();
    let lofts: Vec<&Loft> = lofted.iter().filter_map(|m| m.loft.as_ref()).collect();
    let mut put = |number: u32, meshes: Vec<Surface>| {
        set.write(&place.file(number), |path| {
            let mut file = Objects::create(path, number)?;
            for (muscle, mesh) in lofted.iter().zip(&meshes) {
                file.add(&muscle.spec.name, &mesh.positions, &mesh.normals, &mesh.triangles)?;
            }
            file.finish()
        })
        .map_err(Failure::input)
    };
    let rest: Vec<Surface> = lofts.iter().map(|loft| loft.surface_rest()).collect();
    let volume = rest.iter().map(Surface::volume).sum();
    if args.clip.is_none() {
        put(0, rest)?;
    } else {
        let rig = rig(scene, &lofted)?;
        let moment = Moment::of(&rig, Pose::rest(&rig.character))?;
        let bound: Vec<Bound> = lofts.iter().enumerate().map(|(k, loft)| loft.bound(moment.points(k))).collect();
        let progress = Progress::steps("moving muscles", u64::from(frames.count()));
        for number in frames.numbers() {
            let moment = Moment::of(&rig, frames.pose(scene, number))?;
            let to_posed = |k: usize| &moment.pose.palette[rig.muscles[k].joint as usize];
            put(number, bound.iter().enumerate().map(|(k, b)| b.posed(moment.points(k), to_posed(k))).collect())?;
            progress.step()?;
        }
    }
    set.keep().map_err(Failure::input)?;
    Ok(Written { folder: place.folder, files: frames.count() as usize, muscles: lofts.len(), volume })
}

impl Written {
    /// In words, for results.
    pub fn describe(&self) -> String {
        let litres = self.volume * 1e3;
        format!(
            "  {}: {} files of {} lofted muscles, {litres:.2} litres at rest\n",
            self.folder.display(),
            self.files,
            self.muscles
        )
    }
}
