//! How the skin is deformed.

use clap::{Args as Group, ValueEnum};
use sinew::schedule::{Skinning, TrackOptions};

/// How the skin is deformed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Group)]
pub struct Skin {
    /// How the skin is deformed
    #[arg(long, value_enum, default_value = "implicit")]
    pub skinning: SkinningArg,
    /// Where the skin of a frame starts, with implicit skinning
    #[arg(long, value_enum, default_value = "history")]
    pub tracking: TrackingArg,
}

/// Where implicit skinning starts a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum TrackingArg {
    /// At the frame before, whose frames are played for it: the better folds
    #[default]
    History,
    /// At dual quaternion skinning of its own pose: any frame by itself, folds worse from a right angle on
    Single,
}

/// How the skin follows joints and muscles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SkinningArg {
    /// Muscle and bone fields over linear skinning
    Implicit,
    /// Linear blend skinning
    Linear,
    /// Dual-quaternion skinning
    DualQuaternion,
    /// Linear skinning that muscles alone displace, by weights of every vertex; needs --muscles
    Weighted,
    /// Linear skinning in which muscles are joints that swell, by weights of every vertex; needs --muscles
    Hybrid,
}

impl Skin {
    /// Muscle and bone fields, as where nothing is asked for.
    pub const DEFAULT: Skin = Skin { skinning: SkinningArg::Implicit, tracking: TrackingArg::History };

    /// Whether it needs fields: of its own, or for the muscles that live in them.
    pub fn needs_fields(self) -> bool {
        Skinning::from(self.skinning).follows_muscles()
    }
}

impl From<SkinningArg> for Skinning {
    fn from(argument: SkinningArg) -> Skinning {
        match argument {
            SkinningArg::Implicit => Skinning::Implicit,
            SkinningArg::Linear => Skinning::Linear,
            SkinningArg::DualQuaternion => Skinning::DualQuaternion,
            SkinningArg::Weighted => Skinning::Weighted,
            SkinningArg::Hybrid => Skinning::Hybrid,
        }
    }
}

impl From<TrackingArg> for TrackOptions {
    fn from(argument: TrackingArg) -> TrackOptions {
        match argument {
            TrackingArg::History => TrackOptions::default(),
            TrackingArg::Single => TrackOptions::single_pose(),
        }
    }
}
