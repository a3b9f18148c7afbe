//! Regions that a person marks: each yields its muscle, however little it shows (paper B, user control).

use super::{
    bump::Bump,
    chain::{Belly, Link, Section},
    ellipse,
    muscle::Found,
    outline, stretch,
};
use crate::rig::muscle::MarkSpec;
use glam::DVec3;
use std::str::FromStr;

/// Fewest sections of a marked muscle.
pub const FEWEST: usize = 5;
/// Deviations of the Gaussians of the outline in which its most prominent point is sought, perimeters.
const SMOOTH: f64 = 0.02;
const LARGE: f64 = 0.1;

/// A part of a region in which there is a muscle, around its bone or around the trunk: read from a command line.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark(pub MarkSpec);

impl FromStr for Mark {
    type Err = String;

    fn from_str(text: &str) -> Result<Mark, String> {
        let wrong = || format!("{text} is not REGION:FROM..TO or REGION:FROM..TO:NAME, as upperarm_l:-30..30:biceps");
        let (region, rest) = text.split_once(':').ok_or_else(wrong)?;
        let (range, name) = rest.split_once(':').map_or((rest, None), |(range, name)| (range, Some(name.to_owned())));
        let (from, to) = range.split_once("..").ok_or_else(wrong)?;
        let degrees = [from.parse::<f64>().map_err(|_| wrong())?, to.parse::<f64>().map_err(|_| wrong())?];
        if !MarkSpec::is_range(degrees) || region.is_empty() || name.as_ref().is_some_and(String::is_empty) {
            return Err(wrong());
        }
        Ok(Mark(MarkSpec { region: region.into(), degrees, name }))
    }
}

/// What a marked region holds: the longest of the bellies that were found in it, muscles or not, or one that is made of what stands
/// out most there. `inside` tells which points of the skin, in scene space at rest, are the region's; `None` where too few sections
/// have any.
pub fn belly(found: &mut Found, inside: impl Fn(DVec3) -> bool, aspect: f64) -> Option<Belly> {
    let sections = &found.sections;
    let is_in = |belly: &&Belly| {
        let held = belly.links.iter().filter(|l| inside(sections[l.section].tip_rest(l.bump))).count();
        2 * held > belly.links.len()
    };
    let bellies = found.bellies.iter().map(|(belly, _)| belly).filter(is_in);
    let longest = bellies.max_by(|a, b| a.length.total_cmp(&b.length)).cloned();
    longest.or_else(|| made(&mut found.sections, inside, aspect))
}

/// In every section the point of the region that stands out most. Sections get the bumps that it needs.
fn made(sections: &mut [Section], inside: impl Fn(DVec3) -> bool, aspect: f64) -> Option<Belly> {
    let mut links = Vec::new();
    for (s, section) in sections.iter_mut().enumerate() {
        let count = section.outline.len();
        let smoothed = outline::smooth(&section.outline, SMOOTH * section.perimeter);
        let varied = outline::variation(&smoothed, LARGE * section.perimeter);
        let is_in = |k: usize| !section.bridged[k] && inside(section.plane.to_scene(section.outline[k]));
        let held: Vec<bool> = (0..count).map(is_in).collect();
        let Some(tip) = (0..count).filter(|&k| held[k]).max_by(|&a, &b| varied[a].total_cmp(&varied[b])) else {
            continue;
        };
        let reach = |step: usize| {
            let run = (1..count / 2).take_while(|k| held[(tip + k * step) % count]).count().max(2);
            (tip + run * step) % count
        };
        let (begin, end) = (reach(count - 1), reach(1));
        let curved = outline::curvature(&smoothed);
        let prominence = (varied[tip] - 0.5 * (varied[begin] + varied[end])) / section.perimeter;
        let bump = Bump { tip, begin, end, sharpness: curved[tip], prominence };
        section.ellipses.push(ellipse::fit(&section.outline, &curved, &bump, aspect));
        section.bumps.push(bump);
        links.push(Link { section: s, bump: section.bumps.len() - 1 });
    }
    (links.len() >= FEWEST).then(|| stretch::stretch(sections, &links))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_read() {
        let Mark(mark) = "upperarm_l:-30..30:biceps".parse().expect("a mark");
        assert_eq!(
            (mark.region.as_str(), mark.degrees, mark.name.as_deref()),
            ("upperarm_l", [-30.0, 30.0], Some("biceps"))
        );
        assert!(mark.holds(0.0) && mark.holds(-29.0) && mark.holds(331.0) && !mark.holds(31.0) && !mark.holds(180.0));
        let Mark(behind) = "thigh_r:150..210".parse().expect("a mark");
        assert!(behind.holds(-170.0) && behind.holds(170.0) && !behind.holds(0.0) && behind.name.is_none());
        for wrong in
            ["", "thigh_r", "thigh_r:30", "thigh_r:30..20", "thigh_r:0..500", ":0..20", "thigh_r:0..x", "a:0..9:"]
        {
            assert!(wrong.parse::<Mark>().is_err(), "{wrong}");
        }
    }
}
