//! Options of muscles in motion.

use crate::failure::Failure;
use clap::{Args as Group, ValueEnum};
use sinew::schedule::{Contacts, DynamicsOptions, Solver};
use std::str::FromStr;

/// How muscles move, where skinning is implicit.
#[derive(Clone, Debug, Default, Group)]
pub struct Dynamics {
    /// Whether muscles move, and how their stiffness is understood [default: xpbd; off with --tracking single]
    #[arg(long, value_enum, value_name = "MODE")]
    pub dynamics: Option<ModeArg>,
    /// In what order a muscle's constraints are solved [default: red-black]
    #[arg(long, value_enum)]
    pub solver: Option<SolverArg>,
    /// Frequency of a muscle of stiffness 0.4, 1 to 60; lower is looser [default: 12]
    #[arg(long, value_name = "HZ", value_parser = parse_frequency)]
    pub frequency: Option<f32>,
    /// What muscles pass through
    #[arg(long, value_enum, value_name = "WHAT,..", value_delimiter = ',')]
    pub no_contacts: Vec<ContactArg>,
    /// Iterations of a substep: over each muscle alone, 1 to 64, times over all of them, 1 to 8 [default: 8x2, pbd: 15x1]
    #[arg(long, value_name = "INNERxOUTER")]
    pub iterations: Option<Iterations>,
}

/// `--dynamics`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ModeArg {
    /// Muscles are straight between their ends, as if they had no mass
    Off,
    /// As a frequency, which no other setting changes
    #[default]
    Xpbd,
    /// As the muscle paper's raw stiffness per iteration, 60 substeps a second
    Pbd,
}

/// `--solver`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum SolverArg {
    /// Every second segment, then the others
    #[default]
    RedBlack,
    /// All at once, averaged; needs more iterations
    Jacobi,
}

/// `--no-contacts`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ContactArg {
    /// Bones
    Bones,
    /// Other muscles
    Muscles,
    /// The skin, from within
    Skin,
}

/// `--iterations`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Iterations {
    /// Over one muscle while the others stand still.
    pub inner: u32,
    /// Over all muscles.
    pub outer: u32,
}

impl FromStr for Iterations {
    type Err = String;

    fn from_str(text: &str) -> Result<Iterations, String> {
        let count = |s: &str, most| s.parse::<u32>().ok().filter(|n| (1..=most).contains(n));
        text.split_once(['x', 'X'])
            .and_then(|(i, o)| Some(Iterations { inner: count(i, 64)?, outer: count(o, DynamicsOptions::MOST_OUTER)? }))
            .ok_or_else(|| format!("give INNERxOUTER, 1 to 64 times 1 to {}", DynamicsOptions::MOST_OUTER))
    }
}

fn parse_frequency(text: &str) -> Result<f32, String> {
    text.parse::<f32>().ok().filter(|f| (1.0..=60.0).contains(f)).ok_or_else(|| "give 1 to 60".into())
}

impl Dynamics {
    /// Whether muscles in motion are asked for, or set up, by name.
    pub fn is_asked(&self) -> bool {
        self.dynamics.is_some() || self.setting().is_some()
    }

    /// The first flag given that says how muscles move.
    fn setting(&self) -> Option<&'static str> {
        let set = [
            ("--solver", self.solver.is_some()),
            ("--frequency", self.frequency.is_some()),
            ("--no-contacts", !self.no_contacts.is_empty()),
            ("--iterations", self.iterations.is_some()),
        ];
        set.into_iter().find(|(_, set)| *set).map(|(flag, _)| flag)
    }

    /// What is asked for; none without dynamics.
    pub fn options(&self) -> Result<Option<DynamicsOptions>, Failure> {
        let mode = match self.dynamics.unwrap_or_default() {
            ModeArg::Off => {
                return match self.setting() {
                    Some(flag) => Err(Failure::Usage(format!("{flag} needs --dynamics xpbd or pbd"))),
                    None => Ok(None),
                };
            }
            ModeArg::Xpbd => DynamicsOptions::default(),
            ModeArg::Pbd if self.frequency.is_some() => {
                return Err(Failure::Usage(
                    "--frequency says nothing to --dynamics pbd, whose stiffness is raw".into(),
                ));
            }
            ModeArg::Pbd => DynamicsOptions::pbd(),
        };
        let iterations = self.iterations.unwrap_or(Iterations { inner: mode.inner, outer: mode.outer });
        let touches = |what| !self.no_contacts.contains(&what);
        Ok(Some(DynamicsOptions {
            solver: match self.solver.unwrap_or_default() {
                SolverArg::RedBlack => Solver::RedBlack,
                SolverArg::Jacobi => Solver::Jacobi,
            },
            frequency: self.frequency.unwrap_or(mode.frequency),
            contacts: Contacts {
                bones: touches(ContactArg::Bones),
                muscles: touches(ContactArg::Muscles),
                skin: touches(ContactArg::Skin),
            },
            inner: iterations.inner,
            outer: iterations.outer,
            ..mode
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Args, Verb};
    use clap::Parser;
    use sinew::schedule::Mode;

    fn dynamics(extra: &[&str]) -> Option<Dynamics> {
        let arguments = [&["sinew", "bake", "in.glb", "-o", "a.pc2"], extra].concat();
        let Verb::Bake(bake) = Args::try_parse_from(arguments).ok()?.verb else { panic!("not bake") };
        Some(bake.dynamics)
    }

    fn options(extra: &[&str]) -> Option<DynamicsOptions> {
        dynamics(extra).expect("good flags").options().expect("flags that go together")
    }

    #[test]
    fn a_mode_alone_is_the_librarys_default() {
        assert_eq!(options(&["--dynamics", "xpbd"]), Some(DynamicsOptions::default()));
        assert_eq!(options(&["--dynamics", "pbd"]), Some(DynamicsOptions::pbd()));
        assert_eq!(options(&["--dynamics", "off"]), None);
        assert_eq!(options(&[]), Some(DynamicsOptions::default()), "muscles move unless asked otherwise");
    }

    #[test]
    fn every_flag_changes_its_own_setting() {
        let all = options(&["--dynamics", "pbd", "--solver", "jacobi", "--iterations", "40x3"]).expect("dynamics");
        assert_eq!((all.mode, all.solver, all.inner, all.outer), (Mode::Pbd, Solver::Jacobi, 40, 3));
        assert_eq!(options(&["--dynamics", "xpbd", "--frequency", "6.5"]).expect("dynamics").frequency, 6.5);
        let contacts = Contacts { bones: true, muscles: false, skin: false };
        for flags in [&["--no-contacts", "muscles,skin"][..], &["--no-contacts", "skin", "--no-contacts", "muscles"]] {
            let flags = [&["--dynamics", "xpbd"], flags].concat();
            assert_eq!(options(&flags).expect("dynamics").contacts, contacts);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let wrong: [&[&str]; 8] = [
            &["--frequency", "0.9"],
            &["--frequency", "60.5"],
            &["--frequency", "NaN"],
            &["--iterations", "8"],
            &["--iterations", "0x2"],
            &["--iterations", "8x9"],
            &["--iterations", "65x1"],
            &["--no-contacts", "air"],
        ];
        for flags in wrong {
            assert!(dynamics(flags).is_none(), "{flags:?}");
        }
        let alone = dynamics(&["--dynamics", "off", "--solver", "jacobi"]).expect("good flags");
        assert!(matches!(alone.options(), Err(Failure::Usage(text)) if text.contains("--solver needs --dynamics")));
        let both = dynamics(&["--dynamics", "pbd", "--frequency", "8"]).expect("good flags");
        assert!(matches!(both.options(), Err(Failure::Usage(text)) if text.contains("--frequency")));
    }
}
