//! The command line.

mod dynamics;

pub use dynamics::Dynamics;

use clap::{Args as Group, Parser, Subcommand, ValueEnum};
use sinew::figures::Figure;
use sinew::rig::muscle_file::Settings;
use sinew::schedule::Skinning;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::str::FromStr;

const EXIT_CODES: &str = "Exit codes: 0 ok, 1 findings, 2 wrong usage, 3 bad input or output, 4 no device.";

/// Deforms a character's skin from the muscles under it.
#[derive(Debug, Parser)]
#[command(name = "sinew", version, about, after_help = EXIT_CODES)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
}

/// What can be done.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Play the built-in arm: frames of its curl and an x-ray sheet
    Demo(Demo),
    /// Say what a file holds and what Sinew makes of it
    Inspect(Inspect),
    /// Draw frames as PNG
    Render(Render),
    /// Write deformed vertices as a PC2 cache or a sequence of OBJ files, and muscles as meshes
    Bake(Bake),
    /// Compare the GPU with the CPU reference, stage by stage
    Parity(Parity),
    /// Check a muscle file against its character, line by line
    Validate(Validate),
    /// Edit a muscle file: mirror left and right, copy settings; comments and order stay
    Muscles(Muscles),
    /// Print the JSON Schema of the muscle file
    Schema,
    /// Draw the muscle paper's figures from this program's fields
    Figures(Figures),
    /// Say what Sinew finds on this machine and what is missing
    Doctor(Doctor),
}

/// A character and its muscles.
#[derive(Debug, Group)]
pub struct Input {
    /// The character: .glb, or .gltf with its files beside it
    #[arg(value_name = "IN")]
    pub file: PathBuf,
    /// The muscles: NAME.muscles.toml
    #[arg(long, value_name = "FILE")]
    pub muscles: Option<PathBuf>,
}

/// Where the work is done.
#[derive(Clone, Debug, Group)]
pub struct Compute {
    /// auto, cpu (the reference; deforms without an adapter), or part of an adapter's name
    #[arg(long, value_name = "auto|cpu|NAME", default_value = "auto")]
    pub device: Device,
    /// Threads of the CPU reference and of the field fits [default: all cores]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub threads: Option<NonZeroUsize>,
}

/// Which frames.
#[derive(Debug, Group)]
pub struct Motion {
    /// Animation by name or number; rest is the bind pose, default the file's own pose [default: the first animation]
    #[arg(long, value_name = "NAME|INDEX|rest|default")]
    pub clip: Option<String>,
    /// Inclusive range of frames, or one frame [default: the whole clip]
    #[arg(long, value_name = "A..B")]
    pub frames: Option<FrameRange>,
    /// Frames per second
    #[arg(long, default_value = "30", value_parser = parse_fps)]
    pub fps: f32,
}

/// How the skin is deformed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SkinningArg {
    /// Muscle and bone fields over linear skinning
    Implicit,
    /// Linear blend skinning
    Linear,
    /// Dual-quaternion skinning
    DualQuaternion,
}

impl From<SkinningArg> for Skinning {
    fn from(argument: SkinningArg) -> Skinning {
        match argument {
            SkinningArg::Implicit => Skinning::Implicit,
            SkinningArg::Linear => Skinning::Linear,
            SkinningArg::DualQuaternion => Skinning::DualQuaternion,
        }
    }
}

/// Options of `demo`.
#[derive(Debug, Group)]
pub struct Demo {
    /// Folder for the pictures and the cache
    #[arg(short, long, value_name = "FOLDER", default_value = "sinew-demo")]
    pub output: PathBuf,
    /// Pixels of each frame
    #[arg(long, value_name = "WxH", default_value = "720x720")]
    pub size: Size,
    #[command(flatten)]
    pub compute: Compute,
    #[command(flatten)]
    pub dynamics: Dynamics,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `inspect`.
#[derive(Debug, Group)]
pub struct Inspect {
    #[command(flatten)]
    pub input: Input,
    /// Threads of the field fits [default: all cores]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub threads: Option<NonZeroUsize>,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ViewArg {
    /// The skin with its textures
    Skin,
    /// Muscles under translucent skin, redder where active
    Xray,
    /// Muscles alone; the long axis of a flat one lies along the `normal` of its muscle file. Beads on the axes are black at
    /// the ends, and blue, amber or green where another muscle, a bone or the skin holds them
    Muscles,
}

/// Where the camera stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CameraArg {
    /// In front
    Front,
    /// At the character's left
    Side,
    /// Between the two, a little above
    ThreeQuarter,
}

/// Options of `render`.
#[derive(Debug, Group)]
pub struct Render {
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub motion: Motion,
    #[command(flatten)]
    pub compute: Compute,
    /// How the skin is deformed
    #[arg(long, value_enum, default_value = "implicit")]
    pub skinning: SkinningArg,
    #[command(flatten)]
    pub dynamics: Dynamics,
    /// What is drawn
    #[arg(long, value_enum, default_value = "skin")]
    pub view: ViewArg,
    /// Where the camera stands
    #[arg(long, value_enum, default_value = "three-quarter")]
    pub camera: CameraArg,
    /// Degrees around the character from its front to its left; replaces the camera's own
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = parse_angle)]
    pub azimuth: Option<f32>,
    /// Degrees above the horizon; replaces the camera's own
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = parse_elevation)]
    pub elevation: Option<f32>,
    /// Pixels of each frame [default: 960 by 1280, 1280 by 960 or 960 by 960, by the character's shape]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// Also write sheet.png: all frames, or evenly chosen ones, side by side
    #[arg(long)]
    pub sheet: bool,
    /// Folder for frame_0000.png and so on
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `bake`.
#[derive(Debug, Group)]
pub struct Bake {
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub motion: Motion,
    #[command(flatten)]
    pub compute: Compute,
    /// How the skin is deformed
    #[arg(long, value_enum, default_value = "implicit")]
    pub skinning: SkinningArg,
    #[command(flatten)]
    pub dynamics: Dynamics,
    /// NAME.pc2, or NAME.obj or a folder for a sequence of OBJ files
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Also write the muscles' surfaces as OBJ files of one object per muscle: a folder for muscles_0000.obj and so on,
    /// or NAME.obj
    #[arg(long, value_name = "OUT")]
    pub muscle_meshes: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `parity`.
#[derive(Debug, Group)]
pub struct Parity {
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub motion: Motion,
    #[command(flatten)]
    pub compute: Compute,
    /// How the skin is deformed
    #[arg(long, value_enum, default_value = "implicit")]
    pub skinning: SkinningArg,
    #[command(flatten)]
    pub dynamics: Dynamics,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `validate`.
#[derive(Debug, Group)]
pub struct Validate {
    /// The character: .glb, or .gltf with its files beside it
    #[arg(value_name = "IN")]
    pub file: PathBuf,
    /// The muscles: NAME.muscles.toml
    #[arg(long, value_name = "FILE")]
    pub muscles: PathBuf,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `muscles`.
#[derive(Debug, Group)]
pub struct Muscles {
    /// What to edit.
    #[command(subcommand)]
    pub edit: MusclesEdit,
}

/// What can be edited of a muscle file.
#[derive(Debug, Subcommand)]
pub enum MusclesEdit {
    /// Give every muscle of one side its partner on the other, added or brought in line
    Mirror(MusclesMirror),
    /// Copy settings, never ends or names, from one muscle to others
    Copy(MusclesCopy),
}

/// Options of `muscles mirror`.
#[derive(Debug, Group)]
pub struct MusclesMirror {
    /// The muscle file
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// The character, whose bones at rest say where the other side is
    #[arg(value_name = "IN")]
    pub character: PathBuf,
    /// What names the side that is copied, in muscles and bones [default: _l, .L, left and their like]
    #[arg(long, value_name = "PATTERN", requires = "to")]
    pub from: Option<String>,
    /// What stands in its place on the other side [default: _r, .R, right and their like]
    #[arg(long, value_name = "PATTERN", requires = "from")]
    pub to: Option<String>,
    /// The edited file; may be the same
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `muscles copy`.
#[derive(Debug, Group)]
pub struct MusclesCopy {
    /// The muscle file
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// The muscle whose settings are copied
    #[arg(long, value_name = "NAME")]
    pub from: String,
    /// The muscles that get them
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', required = true)]
    pub to: Vec<String>,
    /// What is copied [default: everything]
    #[arg(long, value_enum, value_name = "WHAT,..", value_delimiter = ',')]
    pub only: Vec<SettingsArg>,
    /// The edited file; may be the same
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Settings of a muscle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SettingsArg {
    /// Shapes at rest and active, segments
    Shape,
    /// Width or volume
    Size,
    /// Stiffness, frequency, jiggle, tendon, collisions
    Physics,
    /// Drivers, attack, decay
    Drive,
    /// Values over time
    Keys,
}

impl From<SettingsArg> for Settings {
    fn from(argument: SettingsArg) -> Settings {
        match argument {
            SettingsArg::Shape => Settings::Shape,
            SettingsArg::Size => Settings::Size,
            SettingsArg::Physics => Settings::Physics,
            SettingsArg::Drive => Settings::Drive,
            SettingsArg::Keys => Settings::Keys,
        }
    }
}

/// Options of `figures`.
#[derive(Debug, Group)]
pub struct Figures {
    /// Folder for figure_2.png and so on
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Only these figures, T3 for the table; 4, 5, 6, 8, 12, 13, A16 and T3 need no adapter [default: 2,3,4,5,6,7,8,11,12,13,14,15,A16,T3]
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    pub only: Vec<Figure>,
    #[command(flatten)]
    pub compute: Compute,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `doctor`.
#[derive(Debug, Group)]
pub struct Doctor {
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// `--device`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Device {
    /// The best adapter.
    Auto,
    /// The CPU reference.
    Cpu,
    /// The adapter whose name contains this.
    Named(String),
}

impl FromStr for Device {
    type Err = String;

    fn from_str(text: &str) -> Result<Device, String> {
        match text {
            "auto" => Ok(Device::Auto),
            "cpu" => Ok(Device::Cpu),
            "" => Err("give auto, cpu or part of an adapter's name".into()),
            name => Ok(Device::Named(name.into())),
        }
    }
}

/// `--frames`: both ends belong to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// First frame.
    pub first: u32,
    /// Last frame.
    pub last: u32,
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<FrameRange, String> {
        let number =
            |s: &str| s.parse::<u32>().map_err(|_| format!("{s:?} is no frame number; give A..B or one frame"));
        let (first, last) = match text.split_once("..") {
            Some((a, b)) => (number(a)?, number(b)?),
            None => (number(text)?, number(text)?),
        };
        if last < first {
            return Err(format!("ends before it begins; {last}..{first}?"));
        }
        Ok(FrameRange { first, last })
    }
}

/// `--size`: pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Size, String> {
        let pixels = |s: &str| s.parse::<u32>().ok().filter(|n| (1..=16384).contains(n));
        text.split_once(['x', 'X'])
            .and_then(|(w, h)| Some(Size { width: pixels(w)?, height: pixels(h)? }))
            .ok_or_else(|| "give WIDTHxHEIGHT, each 1 to 16384".into())
    }
}

fn parse_threads(text: &str) -> Result<NonZeroUsize, String> {
    text.parse::<NonZeroUsize>().ok().filter(|n| n.get() <= 1024).ok_or_else(|| "give 1 to 1024".into())
}

fn parse_fps(text: &str) -> Result<f32, String> {
    text.parse::<f32>().ok().filter(|fps| (0.001..=10_000.0).contains(fps)).ok_or_else(|| "give 0.001 to 10000".into())
}

fn parse_angle(text: &str) -> Result<f32, String> {
    text.parse::<f32>().ok().filter(|a| a.is_finite()).ok_or_else(|| "give degrees".into())
}

fn parse_elevation(text: &str) -> Result<f32, String> {
    parse_angle(text).ok().filter(|a| a.abs() <= 89.0).ok_or_else(|| "give degrees from -89 to 89".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn frames_are_inclusive() {
        assert_eq!("0..47".parse(), Ok(FrameRange { first: 0, last: 47 }));
        assert_eq!("7".parse(), Ok(FrameRange { first: 7, last: 7 }));
        for wrong in ["", "..", "3..", "5..4", "a..b", "-1..2", "1...3"] {
            assert!(wrong.parse::<FrameRange>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes_have_two_positive_numbers() {
        assert_eq!("96x128".parse(), Ok(Size { width: 96, height: 128 }));
        for wrong in ["", "96", "x", "0x5", "5x0", "5x99999", "5x5x5", "-5x5"] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn flags_stand_in_any_order() {
        let before = Args::try_parse_from(["sinew", "bake", "--fps", "24", "-o", "a.pc2", "in.glb"]);
        let after = Args::try_parse_from(["sinew", "bake", "in.glb", "-o", "a.pc2", "--fps", "24"]);
        for parsed in [before, after] {
            let Verb::Bake(bake) = parsed.expect("parses").verb else { panic!("not bake") };
            assert_eq!((bake.motion.fps, bake.output), (24.0, PathBuf::from("a.pc2")));
        }
    }
}
