//! All muscles of a character: every region searched, overlaps settled, what a person marked added.

use super::{
    body::{Body, Shares},
    check::Faults,
    limb::{PLANES, Region, Verdict, search},
    mark,
    muscle::{Extracted, Found, muscle},
    name,
    section::Surface,
    stretch::{Place, stretches},
    trunk::{self, Sweep},
    trunk_muscle,
};
use crate::error::{ExtractError, ExtractNote};
use crate::rig::{Character, groups::Side, muscle::MarkSpec, roles::Roles};
use glam::DVec3;

/// Muscles less sure than this are left out.
pub const LEAST_CONFIDENCE: f64 = 0.25;
/// A region with fewer sections than this share of its planes is told of.
const FEW_SECTIONS: f64 = 0.5;

/// All that was found in a character.
#[derive(Clone, Debug, Default)]
pub struct Extraction {
    /// Muscles, bone by bone, left before right, then the trunk's.
    pub muscles: Vec<Extracted>,
    /// Per long bone what the planes across it found.
    pub regions: Vec<(Region, Found)>,
    /// Per group of planes over the trunk what it found.
    pub sweeps: Vec<(Sweep, Found)>,
    /// What is odd about the character, and what was done about it.
    pub notes: Vec<ExtractNote>,
}

/// Finds the muscles of a character under its skin, and one for every mark: what a mark holds yields to its muscle.
///
/// # Errors
/// No limbs, no closed skin around any of their bones, or a mark where nothing is.
pub fn extract(character: &Character, roles: &Roles, marks: &[MarkSpec]) -> Result<Extraction, ExtractError> {
    let surface = Surface::new(character);
    let mut extraction = Extraction { notes: Faults::of(&surface).notes(), ..Extraction::default() };
    let regions = Region::of(character, roles);
    if regions.is_empty() {
        return Err(ExtractError::NoLimbs { character: character.name.clone() });
    }
    let bones = regions.len();
    let body = Body::of(character, roles);
    for region in regions {
        let found = search(&surface, &region);
        let bellies = found.bellies.iter().filter(|(_, verdict)| *verdict == Verdict::Muscle);
        let made = bellies.filter_map(|(belly, _)| muscle(character, roles, &region, &found.sections, belly));
        let made = made.filter(|m| m.confidence >= LEAST_CONFIDENCE).collect();
        extraction.muscles.extend(strongest(made, |m| m.confidence, Extracted::is_part_of));
        extraction.regions.push((region, found));
    }
    if extraction.regions.iter().all(|(_, found)| found.sections.is_empty()) {
        let planes = bones * PLANES;
        return Err(ExtractError::NoOutlines { character: character.name.clone(), planes, bones });
    }
    if let Some(body) = &body {
        let shares = Shares::new(character, body, &surface);
        for sweep in Sweep::of(body) {
            let (found, muscles) = swept(character, &surface, &shares, body, sweep);
            extraction.muscles.extend(muscles);
            extraction.sweeps.push((sweep, found));
        }
    } else {
        extraction.notes.push(ExtractNote::NoBody);
    }
    extraction.muscles = strongest(std::mem::take(&mut extraction.muscles), Extracted::dominance, |a, b| {
        a.place != b.place && a.spec.side == b.spec.side && a.is_under(b)
    });
    for mark in marks {
        let muscle = extraction.marked(character, roles, body.as_ref(), mark)?;
        extraction.muscles.retain(|other| !(other.spec.side == muscle.spec.side && other.is_under(&muscle)));
        extraction.muscles.push(muscle);
    }
    number(&mut extraction.muscles);
    extraction.note_few(character);
    Ok(extraction)
}

impl Extraction {
    /// The muscle of a marked region.
    fn marked(
        &mut self,
        character: &Character,
        roles: &Roles,
        body: Option<&Body>,
        mark: &MarkSpec,
    ) -> Result<Extracted, ExtractError> {
        let nothing = || ExtractError::NothingThere { mark: mark.region.clone() };
        let limb =
            self.regions.iter_mut().find(|(region, _)| character.joints[region.joint as usize].name == mark.region);
        let mut made = if let Some((region, found)) = limb {
            let degrees = |p: DVec3| region.degrees(roles, p);
            let aspect = region.settings().aspect;
            let belly = mark::belly(found, |p| mark.holds(degrees(p)), aspect).ok_or_else(nothing)?;
            let made = muscle(character, roles, region, &found.sections, &belly);
            found.bellies.push((belly, Verdict::Marked));
            made
        } else {
            let regions = self.region_names(character);
            let sided = [Side::Left, Side::Right];
            let of = |sweep: &Sweep| sided.into_iter().find(|&side| sweep.name(side).as_ref() == Some(&mark.region));
            let marked = self.sweeps.iter_mut().find_map(|(sweep, found)| Some((*sweep, of(sweep)?, found)));
            let (Some((sweep, side, found)), Some(body)) = (marked, body) else {
                return Err(ExtractError::NoRegion { mark: mark.region.clone(), regions });
            };
            let inside = |p: DVec3| {
                let place = Place::of(body, &[p]);
                place.side == side && mark.holds(place.degrees)
            };
            let belly = mark::belly(found, inside, sweep.settings().aspect).ok_or_else(nothing)?;
            let tips: Vec<DVec3> = belly.links.iter().map(|l| found.sections[l.section].tip_rest(l.bump)).collect();
            let place = Place::of(body, &tips);
            let name = name::of_trunk(sweep, &place).unwrap_or(name::UNNAMED);
            let made = trunk_muscle::muscle(character, body, sweep, found, &belly, &place, name);
            found.bellies.push((belly, Verdict::Marked));
            made
        }
        .ok_or_else(nothing)?;
        if let Some(name) = &mark.name {
            let side = stem(&made.spec.name).1.to_owned();
            made.spec.name = format!("{name}{side}");
        }
        Ok(made)
    }

    /// What marks may name.
    fn region_names(&self, character: &Character) -> String {
        let limbs = self.regions.iter().map(|(region, _)| character.joints[region.joint as usize].name.clone());
        let sides = [Side::Left, Side::Right];
        let sweeps = self.sweeps.iter().flat_map(|(sweep, _)| sides.into_iter().filter_map(|side| sweep.name(side)));
        limbs.chain(sweeps).collect::<Vec<_>>().join(", ")
    }

    /// Notes which regions have little skin around them.
    fn note_few(&mut self, character: &Character) {
        let limbs = self.regions.iter().map(|(region, found)| {
            (character.joints[region.joint as usize].name.clone(), found.sections.len(), PLANES)
        });
        let sweeps =
            self.sweeps.iter().map(|(sweep, found)| (sweep.title().to_owned(), found.sections.len(), trunk::PLANES));
        let few =
            limbs.chain(sweeps).filter(|(_, sections, planes)| (*sections as f64) < FEW_SECTIONS * *planes as f64);
        let notes = few.map(|(bone, sections, planes)| ExtractNote::FewSections { bone, sections, planes });
        self.notes.extend(notes.collect::<Vec<_>>());
    }
}

/// Numbers muscles of one name.
fn number(muscles: &mut [Extracted]) {
    for k in 0..muscles.len() {
        let name = muscles[k].spec.name.clone();
        let same = muscles[..k].iter().filter(|m| stem(&m.spec.name) == stem(&name)).count();
        if same > 0 {
            let (stem, side) = stem(&name);
            muscles[k].spec.name = format!("{stem}_{}{side}", same + 1);
        }
    }
}

/// Of muscles those that are no part of a stronger one, in the order that they came in.
fn strongest(
    muscles: Vec<Extracted>,
    strength: impl Fn(&Extracted) -> f64,
    is_part: impl Fn(&Extracted, &Extracted) -> bool,
) -> Vec<Extracted> {
    let mut order: Vec<usize> = (0..muscles.len()).collect();
    order.sort_by(|&a, &b| strength(&muscles[b]).total_cmp(&strength(&muscles[a])));
    let mut kept: Vec<usize> = Vec::new();
    for k in order {
        if !kept.iter().any(|&other| is_part(&muscles[k], &muscles[other])) {
            kept.push(k);
        }
    }
    muscles.into_iter().enumerate().filter(|(k, _)| kept.contains(k)).map(|(_, muscle)| muscle).collect()
}

/// What a group of planes over the trunk finds.
fn swept(
    character: &Character,
    surface: &Surface,
    shares: &Shares,
    body: &Body,
    sweep: Sweep,
) -> (Found, Vec<Extracted>) {
    let (sections, chains) = trunk::sections(surface, shares, body, sweep);
    let mut found = Found { rejected: trunk::PLANES - sections.len(), sections, bellies: Vec::new() };
    let mut muscles = Vec::new();
    for belly in chains.iter().flat_map(|chain| stretches(&found.sections, chain, sweep, body)) {
        let tips: Vec<DVec3> = belly.links.iter().map(|l| found.sections[l.section].tip_rest(l.bump)).collect();
        let place = Place::of(body, &tips);
        let name = name::of_trunk(sweep, &place);
        let made = name.and_then(|name| trunk_muscle::muscle(character, body, sweep, &found, &belly, &place, name));
        muscles.extend(made.filter(|m| m.confidence >= LEAST_CONFIDENCE));
        found.bellies.push((belly, if name.is_some() { Verdict::Muscle } else { Verdict::Bone }));
    }
    (found, muscles)
}

/// A name without its number, and its side.
fn stem(name: &str) -> (String, &str) {
    let (name, side) = match name.strip_suffix("_l").or(name.strip_suffix("_r")) {
        Some(stem) => (stem, &name[stem.len()..]),
        None => (name, ""),
    };
    (name.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches('_').into(), side)
}
