//! The command line.

mod dynamics;
mod muscles;
mod skin;
mod values;

pub use dynamics::Dynamics;
pub use muscles::{Muscles, MusclesCopy, MusclesMirror, MusclesPlot, MusclesVerb, MusclesWeights};
pub use skin::{Skin, TrackingArg};
pub use values::{Device, FrameRange, Size};

use clap::{Args as Group, Parser, Subcommand, ValueEnum};
use sinew::figures::Figure;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use values::{parse_angle, parse_elevation, parse_fps, parse_threads};

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
    /// Find the muscles in the skin, and write them as a muscle file
    Extract(Extract),
    /// Edit a muscle file (mirror, copy; comments and order stay), or plot what its muscles do over a clip
    Muscles(Muscles),
    /// Print the JSON Schema of the muscle file
    Schema,
    /// Draw the papers' figures from this program's fields
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
    /// Animation by name or number; rest is the bind pose, default the file's own pose; test:elbow, test:knee, test:shoulder,
    /// test:squat and test:finger are made by code [default: the first animation]
    #[arg(long, value_name = "NAME|INDEX|rest|default")]
    pub clip: Option<String>,
    /// Inclusive range of frames, or one frame [default: the whole clip]
    #[arg(long, value_name = "A..B")]
    pub frames: Option<FrameRange>,
    /// Frames per second
    #[arg(long, default_value = "30", value_parser = parse_fps)]
    pub fps: f32,
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
    pub skin: Skin,
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
    /// Take one frame apart for this vertex: group, fields and muscles around it, passes, why it stopped, contact
    #[arg(long, value_name = "N", group = "frame-of", requires = "frame")]
    pub vertex: Option<u32>,
    /// Print a frame's order: what runs, how often, over how many threads
    #[arg(long, group = "frame-of")]
    pub schedule: bool,
    /// The frame; the clip is played up to it on the CPU reference [default with --schedule: 1]
    #[arg(long, value_name = "K", requires = "frame-of")]
    pub frame: Option<u32>,
    /// Animation by name or number; rest is the bind pose, default the file's own pose; test:elbow, test:knee, test:shoulder,
    /// test:squat and test:finger are made by code [default: the first animation]
    #[arg(long, value_name = "NAME|INDEX|rest|default", requires = "frame-of")]
    pub clip: Option<String>,
    /// Frames per second
    #[arg(long, default_value = "30", value_parser = parse_fps)]
    pub fps: f32,
    /// Where the skin of a frame starts
    #[arg(long, value_enum, default_value = "history", requires = "frame-of")]
    pub tracking: TrackingArg,
    #[command(flatten)]
    pub dynamics: Dynamics,
    /// Threads of the field fits and of the reference [default: all cores]
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
    /// Muscles alone; the long axis of a flat one lies along the `normal` of its muscle file. In motion their axes are strings
    /// of beads: black at the ends; blue, amber or green where another muscle, a bone or the skin holds them; pink and larger
    /// where they are in a bone or a muscle or outside the skin by more than 2 % of the muscle's radius, twice as large from
    /// 20 % on. White lines are their paths over the last half second, as seen from the muscle's bone
    Muscles,
    /// The skin, coloured by how much its edges are folded more than at rest: red where it is creased into a valley, blue where
    /// into a ridge, in full from 60 degrees on. Rigid parts as they are
    Crease,
    /// The skin under a ghost of linear skinning, coloured by how far it is from there: red where it is outside, blue where inside,
    /// in full from 20 mm on, with a legend. For any skinning; rigid parts are ghosts too
    Compare,
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
    #[command(flatten)]
    pub skin: Skin,
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
    #[command(flatten)]
    pub skin: Skin,
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
    #[command(flatten)]
    pub skin: Skin,
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

/// Options of `extract`.
#[derive(Debug, Group)]
pub struct Extract {
    /// The character: .glb, or .gltf with its files beside it
    #[arg(value_name = "IN")]
    pub file: PathBuf,
    /// The muscle file to write: NAME.muscles.toml. Where it is there already its muscles stay as they are, and those that
    /// it lacks are added
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Regions that must yield a muscle, however little it shows: a limb's joint or abdomen_l, chest_l, shoulder_l, neck_l and their
    /// likes, degrees around it (0 in front, 90 outside, 180 behind, -90 inside), and a name, as in thigh_l:60..120:vastus_lateralis
    #[arg(long, value_name = "REGION:FROM..TO[:NAME],..", value_delimiter = ',')]
    pub must: Vec<sinew::extract::Mark>,
    /// Muscles that are left out, by the names that they would get
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub without: Vec<String>,
    /// Folder for a page of sections per region, the muscles on the skin, and muscles.csv
    #[arg(long, value_name = "FOLDER")]
    pub report: Option<PathBuf>,
    /// Folder for the muscles' surfaces as they were found, lofted over their sections: muscles_0000.obj with an object per
    /// muscle, closed, at rest
    #[arg(long, value_name = "FOLDER")]
    pub meshes: Option<PathBuf>,
    /// Animation through which the surfaces move with the bones, one file per frame [default: rest]
    #[arg(long, value_name = "NAME|INDEX|rest|default", requires = "meshes")]
    pub clip: Option<String>,
    /// Inclusive range of its frames, or one frame [default: the whole clip]
    #[arg(long, value_name = "A..B", requires = "clip")]
    pub frames: Option<FrameRange>,
    /// Its frames per second
    #[arg(long, default_value = "30", value_parser = parse_fps)]
    pub fps: f32,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `figures`.
#[derive(Debug, Group)]
pub struct Figures {
    /// Folder for figure_2.png and so on
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Only these figures, T3 for the table, IS-elbow, IS-knee and IS-finger for Implicit Skinning's folds; 4, 5, 6, 8, 9, 10, 12, 13, A16
    /// and T3 need no adapter [default: all, IS-knee with --limb, IS-finger where the character has fingers]
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    pub only: Vec<Figure>,
    /// The character whose elbow, knee and finger are bent [default: the built-in arm]
    #[arg(long, value_name = "IN")]
    pub limb: Option<PathBuf>,
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Args::command().debug_assert();
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
