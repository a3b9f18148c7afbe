//! `sinew demo`: the built-in arm bends its elbow.

use crate::args;
use crate::failure::Failure;

#[cfg(not(feature = "gpu"))]
pub fn run(_: &args::Demo) -> Result<(), Failure> {
    Err(Failure::Device("demo draws on a GPU; build sinew with feature `gpu`".into()))
}

#[cfg(feature = "gpu")]
pub use on_device::run;

#[cfg(feature = "gpu")]
mod on_device {
    use super::*;
    use crate::args::{FrameRange, Input, Motion};
    use crate::deform::OnCpu;
    use crate::load::{self, Frames};
    use crate::playback::Playback;
    use crate::print;
    use crate::render::{Set, Shoot, film, sheet_of, shoot, write};
    use serde::Serialize;
    use sinew::io::atomic::FileSet;
    use sinew::io::gltf;
    use sinew::render::{Direction, View};
    use sinew::rig::{Rig, muscle_file};
    use sinew::schedule::{FrameOptions, Skinning};
    use std::path::{Path, PathBuf};
    use std::sync::Arc;
    use std::time::Instant;

    const ARM: &[u8] = include_bytes!("../../assets/arm.glb");
    const MUSCLES: &str = include_str!("../../assets/arm.muscles.toml");
    const SHEET_NAME: &str = "xray.png";
    /// Frames on the sheet: as many skins as x-rays, from the stretched arm to the bent one.
    const SHOWN: u32 = 4;
    /// From the inner side, where the biceps shows.
    const DIRECTION: Direction = Direction { azimuth: -75.0, elevation: 5.0 };

    #[derive(Serialize)]
    struct Played {
        output: PathBuf,
        sheet: PathBuf,
        frames: u32,
        vertices: usize,
        active_vertices: usize,
        device: String,
        seconds: f64,
        muscles: Vec<MuscleChange>,
        /// Farthest that the fields moved a vertex from linear skinning at the bend, millimetres.
        moved_millimetres: f32,
    }

    /// A muscle at rest and where the clip bends most.
    #[derive(Serialize)]
    struct MuscleChange {
        name: String,
        rest_length_metres: f32,
        bent_length_metres: f32,
        rest_width_metres: f32,
        bent_width_metres: f32,
    }

    pub fn run(args: &args::Demo) -> Result<(), Failure> {
        load::threads(args.compute.threads)?;
        let headless = crate::device::open(&args.compute.device)?;
        let mut files = FileSet::open(&args.output).map_err(Failure::input)?;
        let input = Input { file: "arm.glb".into(), muscles: Some("arm.muscles.toml".into()) };
        let scene = gltf::from_bytes(ARM, "arm").map_err(Failure::input)?;
        let muscles = muscle_file::parse(MUSCLES, Path::new("arm.muscles.toml")).map_err(Failure::input)?;
        let motion = Motion { clip: Some("curl".into()), frames: None, fps: 30.0 };
        let frames = Frames::choose(&input.file, &scene, &motion)?;
        let options = load::options(args.skin, &args.dynamics, &muscles, args.skin.needs_fields())?;
        let began = Instant::now();
        let rig = Arc::new(load::rig_for(&options, &input, &scene, &muscles, true)?);
        let set = Set {
            scene: &scene,
            rig: &rig,
            options: &options,
            frames: &frames,
            direction: DIRECTION,
            size: Some(args.size),
        };
        let mut film = film(headless, &args.compute.device, &set)?;
        let skin = Shoot { frames: frames.numbers(), view: View::Skin, files: Some(&mut files) };
        shoot(&mut film, &scene, &frames, skin)?;
        let bend = Frames { range: FrameRange { first: 0, last: frames.range.last / 2 }, ..frames };
        let mut shown = Vec::new();
        for view in [View::Skin, View::Xray] {
            let few = Shoot { frames: bend.spread(SHOWN).into_iter(), view, files: None };
            shown.extend(shoot(&mut film, &scene, &frames, few)?);
        }
        let sheet = args.output.join(SHEET_NAME);
        write(SHEET_NAME, &sheet_of(&shown), &mut files)?;
        files.keep().map_err(Failure::input)?;
        let (muscles, moved) = at_the_bend(&rig, &options, &scene, &frames)?;
        let played = Played {
            output: args.output.clone(),
            sheet,
            frames: frames.count(),
            vertices: scene.character.vertex_count(),
            active_vertices: load::active(&rig, options.skinning).unwrap_or_default(),
            device: film.describe(),
            seconds: began.elapsed().as_secs_f64(),
            muscles,
            moved_millimetres: moved * 1000.0,
        };
        print::noted(args.json, &played, &scene.notes, text)
    }

    /// What muscles and fields did halfway through the clip, where the elbow bends most.
    fn at_the_bend(
        rig: &Arc<Rig>,
        options: &FrameOptions,
        scene: &sinew::clip::Scene,
        frames: &Frames,
    ) -> Result<(Vec<MuscleChange>, f32), Failure> {
        let mut cpu = OnCpu::new(rig, options);
        let mut playback = Playback::new(scene, frames, rig, options.remembers());
        let pose = playback.pose((frames.range.first + frames.range.last) / 2, &mut cpu)?;
        let implicit = cpu.skin(&pose)?;
        let linear = OnCpu::new(rig, &FrameOptions { skinning: Skinning::Linear, ..*options }).skin(&pose)?;
        let pairs = implicit.positions.iter().zip(&linear.positions);
        let moved = pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        let (at_rest, _) = rig.muscles_at_rest();
        let named = rig.muscle_names.iter().zip(&at_rest).zip(&cpu.shaped().muscles);
        let muscles = named.map(|((name, rest), bent)| MuscleChange {
            name: name.clone(),
            rest_length_metres: rest.length,
            bent_length_metres: bent.length,
            rest_width_metres: rest.width,
            bent_width_metres: bent.width,
        });
        Ok((muscles.collect(), moved))
    }

    fn text(p: &Played) -> String {
        let mut text = format!(
            "The built-in arm bent its elbow: {} frames of {} vertices, {} of them on muscle and bone fields.\n\
             Drawn on {} in {:.1} s.\n\
             {}/frame_*.png  the skin\n\
             {}  skin, and below it the muscles, redder where active\n\
             At the bend the fields move the skin by up to {:.1} mm from linear skinning, and the muscles, whose volume is constant:\n",
            p.frames,
            p.vertices,
            p.active_vertices,
            p.device,
            p.seconds,
            p.output.display(),
            p.sheet.display(),
            p.moved_millimetres
        );
        for m in &p.muscles {
            let centimetres = [m.rest_length_metres, m.bent_length_metres, m.rest_width_metres, m.bent_width_metres];
            let [l0, l1, w0, w1] = centimetres.map(|x| x * 100.0);
            text += &format!("  {}: length {l0:.1} to {l1:.1} cm, mean radius {w0:.2} to {w1:.2} cm\n", m.name);
        }
        text
    }
}
