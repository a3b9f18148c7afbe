//! `sinew figures`: the papers' figures as PNG files.

use crate::args::{self, Input};
use crate::failure::Failure;
use crate::load;
use crate::print;
use crate::progress::Progress;
use serde::Serialize;
use sinew::clip::{ClipChoice, Scene};
use sinew::error::FigureError;
use sinew::figures::{Arm, Figure, Limb, Stage};
use sinew::io::atomic::FileSet;
use sinew::io::{gltf, png};
use sinew::rig::groups::BodyPart;
use sinew::rig::muscle_file::MuscleFile;
use sinew::rig::{Pose, muscle_file};
use sinew::schedule::DynamicsOptions;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

const ARM: &[u8] = include_bytes!("../../assets/arm.glb");
const MUSCLES: &str = include_str!("../../assets/arm.muscles.toml");
/// Frames a second of its motions.
const FPS: f32 = 30.0;

#[derive(Serialize)]
struct Drawn {
    output: PathBuf,
    figures: Vec<One>,
    device: Option<String>,
    seconds: f64,
}

#[derive(Serialize)]
struct One {
    figure: &'static str,
    title: &'static str,
    file: PathBuf,
    width: u32,
    height: u32,
    /// What was measured for it, with the unit.
    findings: BTreeMap<String, Value>,
}

#[derive(Serialize)]
struct Value {
    value: f64,
    unit: &'static str,
}

pub fn run(args: &args::Figures) -> Result<(), Failure> {
    load::threads(args.compute.threads)?;
    let limb = args.limb.as_deref();
    let bent = match limb {
        Some(file) => gltf::read(file),
        None => gltf::from_bytes(ARM, "arm"),
    };
    let bent = bent.map_err(Failure::input)?;
    // The built-in arm has no knee, and few characters have fingers.
    let given = |figure: &Figure| match figure.bends() {
        Some(BodyPart::Calf) => limb.is_some(),
        Some(BodyPart::Hand) => Limb::has_finger(&bent.character),
        _ => true,
    };
    let wanted = |figure: &Figure| if args.only.is_empty() { given(figure) } else { args.only.contains(figure) };
    let chosen: Vec<Figure> = Figure::ALL.into_iter().filter(wanted).collect();
    let began = Instant::now();
    // Both before the long work, so that a missing adapter or an output that cannot be written is known at once.
    let device = Device::open(args, &chosen)?;
    let mut files = FileSet::open(&args.output).map_err(Failure::input)?;
    let arm = if chosen.iter().any(|figure| figure.needs_arm()) { Some(arm()?) } else { None };
    let parts: Vec<BodyPart> = chosen.iter().filter_map(|figure| figure.bends()).collect();
    let limbs = if parts.is_empty() { Vec::new() } else { limbs(limb, &bent, &parts)? };
    let stage = device.stage(arm.as_ref(), &limbs);
    let progress = Progress::steps("drawing", chosen.len() as u64);
    let mut figures = Vec::new();
    for figure in chosen {
        let drawn = figure.draw(&stage).map_err(failure)?;
        let (name, image) = (format!("figure_{figure}.png"), drawn.image);
        files.write(&name, |path| png::write(path, image.width, image.height, &image.rgba)).map_err(Failure::input)?;
        let findings = drawn.findings.into_iter().map(|f| (f.name, Value { value: f.value, unit: f.unit }));
        figures.push(One {
            figure: figure.number(),
            title: figure.title(),
            file: args.output.join(&name),
            width: image.width,
            height: image.height,
            findings: findings.collect(),
        });
        progress.step()?;
    }
    files.keep().map_err(Failure::input)?;
    drop(progress);
    let drawn =
        Drawn { output: args.output.clone(), figures, device: device.name(), seconds: began.elapsed().as_secs_f64() };
    print::result(args.json, &drawn, text)
}

/// The built-in arm and its motions. Of its curl the first half: it bends the elbow and stretches it again.
fn arm() -> Result<Arm, Failure> {
    let input = Input { file: "arm.glb".into(), muscles: Some("arm.muscles.toml".into()) };
    let scene = gltf::from_bytes(ARM, "arm").map_err(Failure::input)?;
    let muscles = muscle_file::parse(MUSCLES, Path::new("arm.muscles.toml")).map_err(Failure::input)?;
    let rig = |dynamics| load::rig(&input, &scene, &muscles, true, dynamics).map(Arc::new);
    let (curl, shake) = (poses(&scene, "curl")?, poses(&scene, "shake")?);
    let half = curl.len().div_ceil(2);
    Ok(Arm {
        rig: rig(None)?,
        settled: rig(Some(&DynamicsOptions::default()))?,
        curl: curl.into_iter().take(half).collect(),
        shake,
    })
}

/// Poses of each clip that are looked through for the direction in which a joint bends.
const LOOKS: u16 = 12;

/// The joints of a character that bend before the given parts, or with them; `file` is for messages.
fn limbs(file: Option<&Path>, scene: &Scene, parts: &[BodyPart]) -> Result<Vec<Limb>, Failure> {
    let input = Input { file: file.unwrap_or(Path::new("arm.glb")).into(), muscles: None };
    let lacks = |what: &str, figures: &str| {
        let file = input.file.display();
        Failure::Input(format!(
            "{file}: it has no {what}; give another character with --limb, or leave out {figures} with --only"
        ))
    };
    let (fingers, joints): (Vec<BodyPart>, Vec<BodyPart>) = parts.iter().partition(|part| **part == BodyPart::Hand);
    let mut limbs = Vec::new();
    if !fingers.is_empty() {
        let finger = Limb::finger(&scene.character).map_err(failure)?;
        limbs.push(finger.ok_or_else(|| lacks("finger of three joints", "figure IS-finger"))?);
    }
    if joints.is_empty() {
        return Ok(limbs);
    }
    let rig = Arc::new(load::rig(&input, scene, &MuscleFile::default(), true, None)?);
    let clips = scene.clips.iter().enumerate();
    let poses: Vec<Pose> = clips
        .flat_map(|(index, clip)| {
            let at = move |k| (clip.end - clip.start) * f32::from(k) / f32::from(LOOKS);
            (0..=LOOKS).map(move |k| (index, at(k)))
        })
        .map(|(index, time)| scene.pose(ClipChoice::Clip(index), time))
        .collect();
    for part in joints {
        let limb = Limb::find(&rig, part, &poses);
        let what = "elbow or knee whose direction its rest pose or a clip tells";
        limbs.push(limb.ok_or_else(|| lacks(what, "figures IS-elbow and IS-knee"))?);
    }
    Ok(limbs)
}

/// All frames of a clip.
fn poses(scene: &Scene, name: &str) -> Result<Vec<Pose>, Failure> {
    let clip = scene.choose_clip(Some(name)).map_err(Failure::input)?;
    Ok((0..scene.frame_count(clip, FPS)).map(|frame| scene.pose(clip, frame as f32 / FPS)).collect())
}

fn failure(error: FigureError) -> Failure {
    match error {
        FigureError::Device(_) | FigureError::Setup(_) | FigureError::Lacks { .. } => {
            Failure::Device(error.to_string())
        }
        _ => Failure::input(error),
    }
}

/// The device, where a chosen figure is drawn on one.
struct Device {
    #[cfg(feature = "gpu")]
    headless: Option<sinew::gpu::Headless>,
}

impl Device {
    #[cfg(feature = "gpu")]
    fn open(args: &args::Figures, chosen: &[Figure]) -> Result<Device, Failure> {
        let needed = chosen.iter().any(|figure| figure.needs_device());
        if !needed && !chosen.iter().any(|figure| figure.measures_device()) {
            return Ok(Device { headless: None });
        }
        let named = matches!(args.compute.device, args::Device::Named(_));
        match crate::device::open(&args.compute.device) {
            Ok(headless) => Ok(Device { headless: Some(headless) }),
            // What only measures a device goes without one that nobody asked for.
            Err(Failure::Device(_)) if !needed && !named => Ok(Device { headless: None }),
            Err(Failure::Device(line)) => Err(Failure::Device(format!("{line}; {}", without(chosen)))),
            Err(other) => Err(other),
        }
    }

    #[cfg(not(feature = "gpu"))]
    fn open(_: &args::Figures, chosen: &[Figure]) -> Result<Device, Failure> {
        match chosen.iter().find(|figure| figure.needs_device()) {
            Some(_) => Err(Failure::Device(format!(
                "figures in space are drawn on a GPU; build sinew with feature `gpu`; {}",
                without(chosen)
            ))),
            None => Ok(Device {}),
        }
    }

    #[cfg(feature = "gpu")]
    fn stage<'a>(&'a self, arm: Option<&'a Arm>, limbs: &'a [Limb]) -> Stage<'a> {
        Stage { arm, limbs, device: self.headless.as_ref() }
    }

    #[cfg(not(feature = "gpu"))]
    fn stage<'a>(&'a self, arm: Option<&'a Arm>, limbs: &'a [Limb]) -> Stage<'a> {
        Stage { arm, limbs }
    }

    #[cfg(feature = "gpu")]
    fn name(&self) -> Option<String> {
        self.headless.as_ref().map(|headless| headless.info.name.clone())
    }

    #[cfg(not(feature = "gpu"))]
    fn name(&self) -> Option<String> {
        None
    }
}

/// What can be drawn without a device, and what cannot.
fn without(chosen: &[Figure]) -> String {
    let list = |figures: &mut dyn Iterator<Item = Figure>| figures.map(Figure::number).collect::<Vec<_>>().join(",");
    let missing = list(&mut chosen.iter().copied().filter(|f| f.needs_device()));
    let plots = list(&mut Figure::ALL.into_iter().filter(|f| !f.needs_device()));
    format!("figures {missing} are drawn on it, --only {plots} goes without")
}

fn text(d: &Drawn) -> String {
    let mut text = String::new();
    for one in &d.figures {
        text += &format!("{}  {}\n", one.file.display(), one.title);
        for (name, Value { value, unit }) in &one.findings {
            text += &format!("    {name}: {value:.4}{}{unit}\n", if unit.is_empty() { "" } else { " " });
        }
    }
    let on = d.device.as_ref().map_or(String::new(), |name| format!(" on {name}"));
    text + &format!("{} figures drawn{on} in {:.1} s", d.figures.len(), d.seconds)
}
