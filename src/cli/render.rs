//! `sinew render`: frames as PNG.

use crate::args;
use crate::failure::Failure;

#[cfg(not(feature = "gpu"))]
pub fn run(_: &args::Render) -> Result<(), Failure> {
    Err(Failure::Device("render draws on a GPU; build sinew with feature `gpu`".into()))
}

#[cfg(feature = "gpu")]
pub use on_device::{Set, Shoot, film, run, sheet_of, shoot, write};

#[cfg(feature = "gpu")]
mod on_device {
    use super::*;
    use crate::args::{CameraArg, Device, Size, ViewArg};
    use crate::compare::{self, Against};
    use crate::crease::{Folds, Summary};
    use crate::deform::{OnCpu, Shaped};
    use crate::device::{self, OnDevice};
    use crate::load::{self, Frames};
    use crate::playback::{Moves, Playback};
    use crate::print;
    use crate::progress::Progress;
    use crate::studio::{self, Studio};
    use serde::Serialize;
    use sinew::clip::Scene;
    use sinew::dynamics::{Bodies, Skins, depths};
    use sinew::gpu::Headless;
    use sinew::io::atomic::FileSet;
    use sinew::io::png;
    use sinew::render::{
        Camera, ColorMesh, Direction, Paths, Picture, View, axis_meshes, contact_sheet, vertex_buffer,
    };
    use sinew::rig::{FrameInputs, Pose, Rig};
    use sinew::schedule::{FrameOptions, Skinning};
    use std::path::PathBuf;
    use std::sync::Arc;
    use std::time::Instant;

    /// Most pictures on a contact sheet, most side by side, and their largest height in pixels.
    const SHEET: u32 = 12;
    const SHEET_NAME: &str = "sheet.png";
    const COLUMNS: u32 = 4;
    const CELL: u32 = 480;

    #[derive(Serialize)]
    struct Rendered {
        output: PathBuf,
        motion: String,
        frames: u32,
        width: u32,
        height: u32,
        /// Vertices that fields can move; absent without implicit skinning.
        active_vertices: Option<usize>,
        /// What the crease view measured over all its frames.
        #[serde(skip_serializing_if = "Option::is_none")]
        crease: Option<Summary>,
        /// What the compare view measured over all its frames.
        #[serde(skip_serializing_if = "Option::is_none")]
        compare: Option<compare::Summary>,
        sheet: Option<PathBuf>,
        device: String,
        seconds: f64,
    }

    pub fn run(args: &args::Render) -> Result<(), Failure> {
        load::threads(args.compute.threads)?;
        args.dynamics.options()?;
        let (mut scene, muscles) = load::input(&args.input)?;
        let view = View::from(args.view);
        if view.shows_muscles() && muscles.muscles.is_empty() {
            return Err(Failure::Usage(
                "--view xray and --view muscles draw muscles: needs --muscles with a file that has some".into(),
            ));
        }
        let frames = Frames::choose(&args.input.file, &scene, &args.motion)?;
        let mut files = FileSet::open(&args.output).map_err(Failure::input)?;
        // Muscles take their shape in the space of their fields, whichever skinning is drawn over them.
        let fields = args.skin.needs_fields() || view.shows_muscles();
        let options = load::options(args.skin, &args.dynamics, &muscles, fields)?;
        // Before the long work of fitting, so that a missing adapter is known at once.
        let headless = device::open(&args.compute.device)?;
        load::note_idle_muscles(&mut scene, &muscles, fields);
        let rig = Arc::new(load::rig_for(&options, &args.input, &scene, &muscles, fields)?);
        let set = Set {
            scene: &scene,
            rig: &rig,
            options: &options,
            frames: &frames,
            direction: direction(args),
            size: args.size,
        };
        let mut film = film(headless, &args.compute.device, &set)?;
        film.tint = match args.view {
            ViewArg::Crease => Some(Tint::Folds(Folds::of(&rig))),
            ViewArg::Compare => Some(Tint::Against(Box::new(Against::of(&rig)))),
            ViewArg::Skin | ViewArg::Xray | ViewArg::Muscles => None,
        };
        let began = Instant::now();
        let shoot = Shoot { frames: frames.numbers(), view, files: Some(&mut files) };
        let kept = self::shoot(&mut film, &scene, &frames, shoot)?;
        let sheet = args.sheet.then(|| args.output.join(SHEET_NAME));
        if sheet.is_some() {
            write(SHEET_NAME, &sheet_of(&kept), &mut files)?;
        }
        files.keep().map_err(Failure::input)?;
        let (crease, compare) = match &film.tint {
            Some(Tint::Folds(folds)) => (folds.summary(), None),
            Some(Tint::Against(against)) => (None, against.summary()),
            None => (None, None),
        };
        scene.notes.extend(crease.as_ref().map(Summary::note));
        scene.notes.extend(compare.as_ref().map(compare::Summary::note));
        let rendered = Rendered {
            output: args.output.clone(),
            motion: frames.describe(&scene),
            frames: frames.count(),
            width: film.size.width,
            height: film.size.height,
            active_vertices: load::active(&rig, options.skinning),
            crease,
            compare,
            sheet,
            device: film.describe(),
            seconds: began.elapsed().as_secs_f64(),
        };
        print::noted(args.json, &rendered, &scene.notes, |r| {
            let sheet = r.sheet.as_ref().map_or(String::new(), |s| format!(" and {}", s.display()));
            let (folder, width, height) = (r.output.display(), r.width, r.height);
            format!(
                "{folder}/frame_*.png{sheet}: {} pictures of {width} x {height}, {}\ndrawn on {} in {:.2} s{}",
                r.frames,
                r.motion,
                r.device,
                r.seconds,
                load::inactive_text(r.active_vertices)
            )
        })
    }

    fn direction(args: &args::Render) -> Direction {
        let camera = match args.camera {
            CameraArg::Front => Direction::FRONT,
            CameraArg::Side => Direction::SIDE,
            CameraArg::ThreeQuarter => Direction::THREE_QUARTER,
        };
        Direction {
            azimuth: args.azimuth.unwrap_or(camera.azimuth),
            elevation: args.elevation.unwrap_or(camera.elevation),
        }
    }

    /// What puts the deformed skin into a vertex buffer.
    enum Source {
        Device(Box<OnDevice>),
        /// The reference deforms, the device draws.
        Reference(Box<Headless>, Box<OnCpu>),
    }

    /// A character with its device, its camera and its studio.
    pub struct Film {
        source: Source,
        studio: Studio,
        camera: Camera,
        rig: Arc<Rig>,
        /// Muscles under a skinning that does not shape them.
        beside: Option<OnCpu>,
        moving: bool,
        /// Whether muscles or skin depend on the frames before.
        remembers: bool,
        /// What muscles in motion collide with.
        bodies: Bodies,
        /// Where their axes have been, where that is to be seen.
        paths: Option<Paths>,
        /// What the skin's colours tell, where they do.
        tint: Option<Tint>,
        /// Pixels of a picture.
        pub size: Size,
    }

    /// What the skin's colours tell.
    enum Tint {
        /// How it is creased.
        Folds(Folds),
        /// How far it is from linear skinning.
        Against(Box<Against>),
    }

    /// What is filmed, and from where.
    pub struct Set<'a> {
        /// The character with its motion.
        pub scene: &'a Scene,
        /// The character made ready.
        pub rig: &'a Arc<Rig>,
        /// How it is deformed.
        pub options: &'a FrameOptions,
        /// The frames that the camera must hold.
        pub frames: &'a Frames,
        /// From where.
        pub direction: Direction,
        /// Pixels, where they are given.
        pub size: Option<Size>,
    }

    /// Sets everything up. `headless` draws, and deforms too unless `device` is the CPU.
    pub fn film(headless: Headless, device: &Device, set: &Set) -> Result<Film, Failure> {
        let Set { scene, rig, options, frames, direction, size } = *set;
        let points = studio::points(scene, rig, frames)?;
        let size = size.unwrap_or_else(|| studio::size_for(&points, direction));
        let source = match device {
            Device::Cpu => Source::Reference(Box::new(headless), Box::new(OnCpu::new(rig, options))),
            _ => Source::Device(Box::new(OnDevice::new(headless, rig, options)?)),
        };
        let studio = Studio::open(source.headless(), scene, size)?;
        let camera = Camera::around(&points, direction, studio.aspect());
        let beneath = FrameOptions { skinning: Skinning::Implicit, ..*options };
        let apart = !options.skinning.follows_muscles() && !rig.grids.is_empty();
        let beside = apart.then(|| OnCpu::new(rig, &beneath));
        let moving = options.dynamics.is_some();
        let remembers = options.remembers();
        let bodies = if moving { Bodies::new(rig) } else { Bodies::default() };
        Ok(Film {
            source,
            studio,
            camera,
            rig: Arc::clone(rig),
            beside,
            moving,
            remembers,
            bodies,
            paths: None,
            tint: None,
            size,
        })
    }

    impl Source {
        fn headless(&self) -> &Headless {
            match self {
                Source::Device(device) => &device.headless,
                Source::Reference(headless, _) => headless,
            }
        }
    }

    impl Film {
        /// Draws one pose.
        pub fn picture(&mut self, pose: &Pose, view: View) -> Result<Picture, Failure> {
            if let Some(mut tint) = self.tint.take() {
                let picture = self.tinted(pose, &mut tint);
                self.tint = Some(tint);
                return picture;
            }
            let vertices = match &mut self.source {
                Source::Device(device) => {
                    device.play(pose)?;
                    device.instance().output().clone()
                }
                Source::Reference(headless, cpu) => {
                    let skin = cpu.skin(pose)?;
                    vertex_buffer(headless, &skin.positions, &skin.normals).map_err(Failure::device)?
                }
            };
            let shaped = if view.shows_muscles() {
                self.beside.iter_mut().try_for_each(|beside| beside.pass(pose))?;
                Some(self.shaped()?)
            } else {
                None
            };
            let marks = match &shaped {
                Some(shaped) if view == View::Muscles && self.moving => self.marks(pose, shaped)?,
                _ => Vec::new(),
            };
            let (headless, rig) = (self.source.headless(), &*self.rig);
            let drawn = (Some(&vertices), Vec::new());
            self.studio.draw(headless, (rig, pose), drawn, (shaped.as_ref(), &marks), &self.camera, view)
        }

        /// Draws one pose in colours that tell something.
        fn tinted(&mut self, pose: &Pose, tint: &mut Tint) -> Result<Picture, Failure> {
            let skin = match &mut self.source {
                Source::Device(device) => device.skin(pose)?,
                Source::Reference(_, cpu) => cpu.skin(pose)?,
            };
            let (headless, rig) = (self.source.headless(), &*self.rig);
            match tint {
                Tint::Folds(folds) => {
                    let drawn = (None, vec![folds.mesh(rig, &skin)]);
                    self.studio.draw(headless, (rig, pose), drawn, (None, &[]), &self.camera, View::Colors)
                }
                Tint::Against(against) => {
                    let (mesh, linear) = against.mesh(rig, pose, &skin)?;
                    let ghost = vertex_buffer(headless, &linear.positions, &linear.normals).map_err(Failure::device)?;
                    let drawn = (Some(&ghost), vec![mesh]);
                    let picture =
                        self.studio.draw(headless, (rig, pose), drawn, (None, &[]), &self.camera, View::Xray)?;
                    Against::legend(picture)
                }
            }
        }

        /// The muscles of the last pose.
        fn shaped(&self) -> Result<Shaped, Failure> {
            match (&self.beside, &self.source) {
                (Some(cpu), _) => Ok(cpu.shaped().clone()),
                (None, Source::Reference(_, cpu)) => Ok(cpu.shaped().clone()),
                (None, Source::Device(device)) => device.shaped(),
            }
        }

        /// The axes of muscles in motion, how deep they are in what they collide with, and where they have been.
        fn marks(&mut self, pose: &Pose, shaped: &Shaped) -> Result<Vec<ColorMesh>, Failure> {
            let rig = &*self.rig;
            let inputs = FrameInputs::new(rig, pose).map_err(Failure::input)?;
            let depths = depths(&self.bodies, Skins::of(rig), &inputs.joints, &shaped.iterates);
            let mut marks = axis_meshes(rig, pose, &shaped.axes, &shaped.particles, &depths);
            if let Some(paths) = &mut self.paths {
                paths.add(pose.time, &shaped.axes);
                marks.extend(paths.meshes(rig, pose));
            }
            Ok(marks)
        }

        /// What deforms and draws, in words.
        pub fn describe(&self) -> String {
            match &self.source {
                Source::Device(device) => device.headless.info.name.clone(),
                Source::Reference(headless, _) => {
                    format!("{} (deformed by the {})", headless.info.name, OnCpu::describe())
                }
            }
        }
    }

    impl Moves for Film {
        fn reset(&mut self) {
            match &mut self.source {
                Source::Device(device) => device.reset(),
                Source::Reference(_, cpu) => cpu.reset(),
            }
            self.beside.iter_mut().for_each(Moves::reset);
            self.paths.iter_mut().for_each(Paths::clear);
        }

        fn pass(&mut self, pose: &Pose) -> Result<(), Failure> {
            match &mut self.source {
                Source::Device(device) => device.pass(pose)?,
                Source::Reference(_, cpu) => cpu.pass(pose)?,
            }
            self.beside.iter_mut().try_for_each(|beside| beside.pass(pose))?;
            if self.paths.is_none() {
                return Ok(());
            }
            let axes = self.shaped()?.axes;
            self.paths.iter_mut().for_each(|paths| paths.add(pose.time, &axes));
            Ok(())
        }
    }

    /// Which frames to draw, how, and into which folder if any.
    pub struct Shoot<'a, I> {
        /// Frame numbers, ascending.
        pub frames: I,
        /// What is drawn.
        pub view: View,
        /// Takes `frame_0000.png` and so on.
        pub files: Option<&'a mut FileSet>,
    }

    /// Draws frames, writes them, and keeps evenly chosen small ones for a contact sheet.
    pub fn shoot(
        film: &mut Film,
        scene: &Scene,
        frames: &Frames,
        mut shoot: Shoot<impl ExactSizeIterator<Item = u32>>,
    ) -> Result<Vec<(u32, Picture)>, Failure> {
        let progress = Progress::steps("drawing", shoot.frames.len() as u64);
        let chosen = chosen(shoot.frames.len());
        let rig = Arc::clone(&film.rig);
        film.paths = (film.moving && shoot.view == View::Muscles).then(Paths::default);
        let mut playback = Playback::new(scene, frames, &rig, film.remembers);
        let mut kept = Vec::new();
        for (i, number) in shoot.frames.enumerate() {
            let pose = playback.pose(number, film)?;
            let picture = film.picture(&pose, shoot.view)?;
            if let Some(files) = &mut shoot.files {
                write(&format!("frame_{number:04}.png"), &picture, files)?;
            }
            if chosen.contains(&i) {
                kept.push((number, picture.reduced(picture.height.div_ceil(CELL))));
            }
            progress.step()?;
        }
        Ok(kept)
    }

    /// Places of the pictures that a sheet of `count` takes.
    fn chosen(count: usize) -> Vec<usize> {
        let cells = count.min(SHEET as usize);
        (0..cells).map(|i| i * (count - 1) / (cells.max(2) - 1)).collect()
    }

    /// The contact sheet of kept pictures.
    pub fn sheet_of(kept: &[(u32, Picture)]) -> Picture {
        let (numbers, pictures): (Vec<u32>, Vec<Picture>) = kept.iter().cloned().unzip();
        contact_sheet(&pictures, &numbers, COLUMNS)
    }

    /// Writes a picture as a file of a set.
    pub fn write(name: &str, picture: &Picture, files: &mut FileSet) -> Result<(), Failure> {
        files.write(name, |path| png::write(path, picture.width, picture.height, &picture.rgba)).map_err(Failure::input)
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn a_sheet_takes_the_first_and_the_last() {
            assert_eq!(chosen(5), [0, 1, 2, 3, 4]);
            assert_eq!(chosen(1), [0]);
            assert_eq!(chosen(0), [0; 0]);
            let many = chosen(100);
            assert_eq!((many.len(), many[0], many[11]), (12, 0, 99));
        }
    }
}
