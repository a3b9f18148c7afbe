//! The figures of the muscle paper (A), some of the extraction paper (B), and the folds of Implicit Skinning, drawn by this project's code from this project's fields.
//!
//! A figure is drawn on a [`Stage`]: plots need nothing of it, figures in space a device, and those of motion the built-in
//! arm or limbs of a character. Beside the picture a figure gives what was measured for it.

#[cfg(feature = "gpu")]
mod actor;
#[cfg(feature = "gpu")]
mod anatomy;
pub mod charts;
#[cfg(feature = "gpu")]
mod collisions;
mod constraints;
#[cfg(feature = "gpu")]
mod curl;
#[cfg(feature = "gpu")]
mod fibres;
#[cfg(feature = "gpu")]
mod flexion;
#[cfg(feature = "gpu")]
mod folds;
#[cfg(feature = "gpu")]
mod hybrid;
mod limb;
mod motion;
#[cfg(feature = "gpu")]
mod movement;
mod operators;
pub mod plot;
mod profiles;
mod projection;
#[cfg(feature = "gpu")]
mod scene;
mod schedule;
mod section;
mod solvers;
#[cfg(feature = "gpu")]
mod states;
mod times;
mod timing;
mod volume;

pub use limb::{Bent, Effect, Limb};

use crate::error::FigureError;
use crate::rig::groups::BodyPart;
use crate::rig::{Image, Pose, Rig};
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

/// One of the papers' figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// 2: the arm at rest, activated and flexed.
    Flexion,
    /// 3: the anatomy of one muscle.
    Anatomy,
    /// 4: the projection on the axis, plain and ours.
    Projection,
    /// 5: sections of equal area.
    Sections,
    /// 6: the profile from rest to activation.
    Activation,
    /// 7: muscles of several fibres.
    Fibres,
    /// 8: the constraints of a muscle.
    Constraints,
    /// 9: a section composed by three operators.
    Operators,
    /// 10: a frame as its schedule has it.
    Schedule,
    /// 11: calf and back in their states.
    States,
    /// 12: time over the number of particles.
    Times,
    /// 13: volume over a curl and a lively motion.
    Volume,
    /// 14: a wider muscle under the skin.
    Width,
    /// 15: the bent arm without muscles, without collisions and with them.
    Collisions,
    /// A.16: profiles of several shapes.
    Profiles,
    /// Table 3: time without and with collisions.
    Solvers,
    /// Implicit Skinning's elbow by three skinnings.
    Elbow,
    /// The same of a knee.
    Knee,
    /// The same of a finger, each of whose bones has a field.
    Finger,
    /// 2 of the extraction paper: bulge, and muscles round a joint and round a bone.
    Movement,
    /// 3 of it: hybrid skinning.
    Hybrid,
}

/// The built-in arm, for the figures that show motion.
#[derive(Debug)]
pub struct Arm {
    /// The arm with its fields and muscles, their axes straight at rest.
    pub rig: Arc<Rig>,
    /// The same with axes where the dynamics let them come to rest.
    pub settled: Arc<Rig>,
    /// Poses from the stretched arm to the bent one, 30 a second.
    pub curl: Vec<Pose>,
    /// The arm shaken, 30 poses a second.
    pub shake: Vec<Pose>,
}

/// What figures are drawn on and from.
#[derive(Clone, Copy, Default)]
pub struct Stage<'a> {
    /// The built-in arm.
    pub arm: Option<&'a Arm>,
    /// Limbs that are bent.
    pub limbs: &'a [Limb],
    /// The device that draws what is in space.
    #[cfg(feature = "gpu")]
    pub device: Option<&'a crate::gpu::Headless>,
}

/// Something that was measured for a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What it is.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its unit; empty for a plain number.
    pub unit: &'static str,
}

/// A figure as drawn.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The picture.
    pub image: Image,
    /// What was measured.
    pub findings: Vec<Finding>,
}

impl Figure {
    /// All figures in the paper's order.
    pub const ALL: [Figure; 21] = [
        Figure::Flexion,
        Figure::Anatomy,
        Figure::Projection,
        Figure::Sections,
        Figure::Activation,
        Figure::Fibres,
        Figure::Constraints,
        Figure::Operators,
        Figure::Schedule,
        Figure::States,
        Figure::Times,
        Figure::Volume,
        Figure::Width,
        Figure::Collisions,
        Figure::Profiles,
        Figure::Solvers,
        Figure::Elbow,
        Figure::Knee,
        Figure::Finger,
        Figure::Movement,
        Figure::Hybrid,
    ];

    /// Its number in the paper.
    pub fn number(self) -> &'static str {
        match self {
            Figure::Flexion => "2",
            Figure::Anatomy => "3",
            Figure::Projection => "4",
            Figure::Sections => "5",
            Figure::Activation => "6",
            Figure::Fibres => "7",
            Figure::Constraints => "8",
            Figure::Operators => "9",
            Figure::Schedule => "10",
            Figure::States => "11",
            Figure::Times => "12",
            Figure::Volume => "13",
            Figure::Width => "14",
            Figure::Collisions => "15",
            Figure::Profiles => "A16",
            Figure::Solvers => "T3",
            Figure::Elbow => "IS-elbow",
            Figure::Knee => "IS-knee",
            Figure::Finger => "IS-finger",
            Figure::Movement => "B2",
            Figure::Hybrid => "B3",
        }
    }

    /// What it shows, in a few words.
    pub fn title(self) -> &'static str {
        match self {
            Figure::Flexion => "arm at rest, activated and flexed",
            Figure::Anatomy => "anatomy of one muscle",
            Figure::Projection => "projection on the axis, nearest segment and ours",
            Figure::Sections => "elliptic sections of equal area",
            Figure::Activation => "profile from rest to activation",
            Figure::Fibres => "pectoral and shoulder muscles as fibres",
            Figure::Constraints => "constraints of a muscle",
            Figure::Operators => "limb and muscle composed by three operators",
            Figure::Schedule => "a frame as its schedule has it",
            Figure::States => "calf least and most activated, and a back muscle",
            Figure::Times => "time a frame over the particles of a muscle",
            Figure::Volume => "volume over a curl, a shaking and a bend",
            Figure::Width => "curl, and the same with a wider muscle",
            Figure::Collisions => "bent arm without muscles, without collisions and with them",
            Figure::Profiles => "profiles of several shapes",
            Figure::Solvers => "time of the dynamics without and with collisions",
            Figure::Elbow => "elbow by linear and dual quaternion skinning and by ours",
            Figure::Knee => "knee by linear and dual quaternion skinning and by ours",
            Figure::Movement => "bulge, and muscles round a joint and round a bone",
            Figure::Hybrid => "muscles of an arm, and hybrid skinning over smooth skinning",
            Figure::Finger => "finger by linear and dual quaternion skinning and by ours",
        }
    }

    /// Whether it is drawn in space, on a device.
    pub fn needs_device(self) -> bool {
        use Figure::{Anatomy, Collisions, Elbow, Fibres, Finger, Flexion, Hybrid, Knee, Movement, States, Width};
        let bends = matches!(self, Elbow | Knee | Finger);
        bends || matches!(self, Flexion | Anatomy | Fibres | States | Width | Collisions | Movement | Hybrid)
    }

    /// Whether it measures the device, where there is one.
    pub fn measures_device(self) -> bool {
        matches!(self, Figure::Times | Figure::Solvers)
    }

    /// Whether it shows the built-in arm.
    pub fn needs_arm(self) -> bool {
        use Figure::{Collisions, Constraints, Flexion, Hybrid, Schedule, Volume, Width};
        matches!(self, Flexion | Constraints | Schedule | Volume | Width | Collisions | Hybrid)
            || self.measures_device()
    }

    /// The part of the body beyond the joint that it bends, or with it, where it bends one.
    pub fn bends(self) -> Option<BodyPart> {
        match self {
            Figure::Elbow => Some(BodyPart::Forearm),
            Figure::Knee => Some(BodyPart::Calf),
            Figure::Finger => Some(BodyPart::Hand),
            _ => None,
        }
    }

    /// Draws it. The same stage gives the same bytes, but for times.
    ///
    /// # Errors
    /// [`FigureError::Lacks`] where the stage is missing something; otherwise what drawing met.
    pub fn draw(self, stage: &Stage<'_>) -> Result<Drawn, FigureError> {
        match self {
            Figure::Projection => projection::figure(),
            Figure::Sections => profiles::sections(),
            Figure::Activation => profiles::activation(),
            Figure::Profiles => profiles::profiles(),
            Figure::Constraints => constraints::figure(self.arm(stage)?),
            Figure::Operators => operators::figure(),
            Figure::Schedule => schedule::figure(self.arm(stage)?),
            Figure::Volume => volume::figure(self.arm(stage)?),
            Figure::Times => times::figure(stage),
            Figure::Solvers => solvers::figure(stage),
            #[cfg(feature = "gpu")]
            Figure::Flexion => flexion::figure(self.device(stage)?, self.arm(stage)?),
            #[cfg(feature = "gpu")]
            Figure::Anatomy => anatomy::figure(self.device(stage)?),
            #[cfg(feature = "gpu")]
            Figure::Fibres => fibres::figure(self.device(stage)?),
            #[cfg(feature = "gpu")]
            Figure::States => states::figure(self.device(stage)?),
            #[cfg(feature = "gpu")]
            Figure::Width => curl::figure(self.device(stage)?, self.arm(stage)?),
            #[cfg(feature = "gpu")]
            Figure::Collisions => collisions::figure(self.device(stage)?, self.arm(stage)?),
            #[cfg(feature = "gpu")]
            Figure::Movement => movement::figure(self.device(stage)?),
            #[cfg(feature = "gpu")]
            Figure::Hybrid => hybrid::figure(self.device(stage)?, self.arm(stage)?),
            #[cfg(feature = "gpu")]
            Figure::Elbow | Figure::Knee | Figure::Finger => folds::figure(self.device(stage)?, self.limb(stage)?),
            #[cfg(not(feature = "gpu"))]
            _ => Err(self.lacks("a graphics adapter, and sinew built with feature `gpu`")),
        }
    }

    fn lacks(self, what: &'static str) -> FigureError {
        FigureError::Lacks { figure: self.number(), what }
    }

    fn arm<'a>(self, stage: &Stage<'a>) -> Result<&'a Arm, FigureError> {
        stage.arm.filter(|arm| !arm.curl.is_empty()).ok_or_else(|| self.lacks("the built-in arm in motion"))
    }

    #[cfg(feature = "gpu")]
    fn limb<'a>(self, stage: &Stage<'a>) -> Result<&'a Limb, FigureError> {
        // A limb whose names say nothing passes for an arm.
        let fits = |limb: &&Limb| limb.part.or(Some(BodyPart::Forearm)) == self.bends();
        stage
            .limbs
            .iter()
            .find(fits)
            .ok_or_else(|| self.lacks("a character with such a joint that bends; give one with --limb"))
    }

    #[cfg(feature = "gpu")]
    fn device<'a>(self, stage: &Stage<'a>) -> Result<&'a crate::gpu::Headless, FigureError> {
        stage.device.ok_or_else(|| self.lacks("a graphics adapter"))
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.number())
    }
}

impl FromStr for Figure {
    type Err = FigureError;

    /// By its number; a dot or the letters' case do not matter.
    fn from_str(text: &str) -> Result<Figure, FigureError> {
        let plain = |text: &str| text.trim().replace('.', "").to_uppercase();
        Figure::ALL.into_iter().find(|figure| plain(figure.number()) == plain(text)).ok_or_else(|| {
            FigureError::Unknown { wanted: text.into(), known: Figure::ALL.map(Figure::number).join(", ") }
        })
    }
}

impl Finding {
    fn new(name: impl Into<String>, value: f64, unit: &'static str) -> Finding {
        Finding { name: name.into(), value, unit }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_known_by_their_numbers() {
        for figure in Figure::ALL {
            assert_eq!(figure.number().parse::<Figure>().ok(), Some(figure));
        }
        assert_eq!("a.16".parse::<Figure>().ok(), Some(Figure::Profiles));
        assert_eq!("is-Elbow".parse::<Figure>().ok(), Some(Figure::Elbow));
        let error = "1".parse::<Figure>().expect_err("not ours").to_string();
        assert!(error.contains("\"1\" is no figure") && error.contains("3, 4, 5"), "{error}");
    }

    #[test]
    fn a_figure_names_what_its_stage_lacks() {
        for figure in Figure::ALL.into_iter().filter(|f| f.needs_arm() || f.needs_device()) {
            let error = figure.draw(&Stage::default()).expect_err("lacks something").to_string();
            assert!(error.starts_with(&format!("figure {figure} needs")), "{error}");
        }
    }
}
