//! How the skin is deformed.

use clap::{Args as Group, ValueEnum};
use sinew::schedule::Skinning;

/// How the skin is deformed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Group)]
pub struct Skin {
    /// How the skin is deformed
    #[arg(long, value_enum, default_value = "implicit")]
    pub skinning: SkinningArg,
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
    pub const DEFAULT: Skin = Skin { skinning: SkinningArg::Implicit };

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
