//! Options of `sinew muscles`.

use super::skin::SkinningArg;
use super::{Compute, Dynamics, Input, Motion, values::parse_threads};
use clap::{Args as Group, Subcommand, ValueEnum};
use sinew::rig::muscle_file::Settings;
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// Options of `muscles`.
#[derive(Debug, Group)]
pub struct Muscles {
    /// What to do with them.
    #[command(subcommand)]
    pub verb: MusclesVerb,
}

/// What can be done with a muscle file.
#[derive(Debug, Subcommand)]
pub enum MusclesVerb {
    /// Give every muscle of one side its partner on the other, added or brought in line
    Mirror(MusclesMirror),
    /// Copy settings, never ends or names, from one muscle to others
    Copy(MusclesCopy),
    /// Plot what every muscle does over a clip: length, width, activation, volume, speed, and what is left of the dynamics'
    /// errors
    Plot(MusclesPlot),
    /// Write how far every muscle takes every vertex with it into the character, as attributes `_MUSCLE_n` to paint on
    Weights(MusclesWeights),
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

/// Options of `muscles plot`.
#[derive(Debug, Group)]
pub struct MusclesPlot {
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub motion: Motion,
    #[command(flatten)]
    pub compute: Compute,
    #[command(flatten)]
    pub dynamics: Dynamics,
    /// Folder for a page per muscle, 00_NAME.png and so on, and muscles.csv with all their numbers
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of `muscles weights`.
#[derive(Debug, Group)]
pub struct MusclesWeights {
    #[command(flatten)]
    pub input: Input,
    /// Which skinning's weights: weighted or hybrid, whose weights fade over the tendons
    #[arg(long, value_enum, default_value = "hybrid")]
    pub skinning: SkinningArg,
    #[command(flatten)]
    pub dynamics: Dynamics,
    /// Threads of the field fits [default: all cores]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub threads: Option<NonZeroUsize>,
    /// The character with its weights; may be the same
    #[arg(short, long, value_name = "OUT.glb")]
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
