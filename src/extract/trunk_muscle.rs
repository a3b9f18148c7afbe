//! From a stretch over the trunk to a muscle: fitted along the chain's own axis, for the planes follow no bone there.

use super::{
    body::{Body, Part},
    chain::{Belly, Link, Section},
    fit::{self, Bounds, Primitive},
    loft::Loft,
    muscle::{Extracted, Found, Where, attachment, axis, collision_group, eccentricity, shape, side_of, thickest},
    name::{Far, TrunkName},
    stretch::Place,
    trunk::{Sweep, index},
};
use crate::rig::{Character, MuscleSize, MuscleSpec, groups::Side};
use glam::DVec3;

/// How far the axis goes on past a stretch's ends, in its lengths.
const EXTENSION: f64 = 0.12;
/// Where a muscle that moves a limb ends on the limb's bone, in lengths of the bone, and how much of its distance from it is left.
const LIMB_SHARE: f64 = 0.2;
const LIMB_OFF: f64 = 0.4;
/// That distance before, at most, in lengths of the bone.
const LIMB_ROOM: f64 = 0.25;
/// A deltoid ends this far down its bone.
const DELTOID_SHARE: f64 = 0.5;
/// A crest's half, in spans of its bump: sheets are told by their breadth.
const CREST: f64 = 0.4;
/// A muscle that ends on a limb may be this many times as far off the skin as it would be on the trunk, and this much, metres: one that
/// leaves the body for its limb stays.
const FOR_LIMB: (f64, f64) = (1.5, 0.003);
/// A muscle's axis is no deeper under its tips, in heights of the trunk: ellipses in the body's corners are as large as the body.
const DEEPEST: f64 = 0.07;
/// And it is no thicker outward from there.
const THICKEST: f64 = 0.08;
/// Exponents of a sheet, level along most of its length: the roundest, and their neighbours.
const SHEET: (u32, u32) = (2, 2);
/// How far the skin may draw an end, in the ellipses' size: on the trunk, and on a limb's bone.
const PLAY: f64 = 1.0;
const LIMB_PLAY: f64 = 0.5;
/// Bumps that stand out by this, perimeters, are as sure as can be.
pub(super) const SURE_VARIATION: f64 = 0.003;
/// So are tips whose curvature stands out by this.
const SURE_PROMINENCE: f64 = 1.0;
/// Sections from which a muscle is no surer, and the stray of its tips, perimeters, that halves its sureness.
const SURE_SECTIONS: f64 = 10.0;
const UNSURE_STRAY: f64 = 0.03;

/// The muscle of a stretch; `None` where no profile stands out.
pub fn muscle(
    character: &Character,
    body: &Body,
    sweep: Sweep,
    found: &Found,
    belly: &Belly,
    place: &Place,
    name: TrunkName,
) -> Option<Extracted> {
    let sections = &found.sections;
    let tips_rest: Vec<DVec3> = belly.links.iter().map(|l| sections[l.section].tip_rest(l.bump)).collect();
    let most = DEEPEST * body.height();
    let no_deeper = |(tip, root): (&DVec3, &DVec3)| tip.lerp(*root, (most / tip.distance(*root).max(1e-9)).min(1.0));
    let roots_rest: Vec<DVec3> = tips_rest.iter().zip(&belly.roots_rest).map(no_deeper).collect();
    let (first, way) = axis(&roots_rest);
    let plain = [first - way * EXTENSION, first + way * (1.0 + EXTENSION)];
    let outward = outward(sections, belly);
    let (long, short) = thickest(sections, belly);
    let (short, eccentricity) = (short.min(most), eccentricity(long, short.min(most)));
    let size = (long * short).sqrt();
    let depth = THICKEST * body.height();
    let crest: Vec<(DVec3, f64)> =
        belly.links.iter().flat_map(|l| sections[l.section].crest_rest(l.bump, CREST)).collect();
    let lay = |ends: [DVec3; 2], far: Option<usize>| {
        let normal_rest = (ends[1] - ends[0]).cross(outward).try_normalize()?;
        let mut primitive = Primitive { ends_rest: ends, normal_rest, exponents: SHEET, eccentricity, width: size };
        let play = [0, 1].map(|k| [if far == Some(k) { LIMB_PLAY } else { PLAY } * size; 2]);
        primitive.fit(&crest, outward, &Bounds { width: [0.3 * size, 1.5 * size], depth, play, flatter: false });
        Some(primitive)
    };
    let on_trunk = lay(plain, None)?;
    let on_limb = held(body, place, name, plain).and_then(|(ends, far)| Some((lay(ends, Some(far))?, far)));
    let most_off = FOR_LIMB.0 * on_trunk.off(&crest) + FOR_LIMB.1;
    let (primitive, far) = match on_limb {
        Some((on_limb, far)) if on_limb.off(&crest) < most_off => (on_limb, Some(far)),
        _ => (on_trunk, None),
    };
    let (ends, normal_rest, (alpha, beta)) = (primitive.ends_rest, primitive.normal_rest, primitive.exponents);
    let way = ends[1] - ends[0];
    let s: Vec<f64> = tips_rest.iter().map(|p| (*p - ends[0]).dot(way) / way.length_squared()).collect();
    let out: Vec<f64> = tips_rest.iter().map(|p| (*p - ends[0]).dot(outward)).collect();
    let profile_rms = fit::profile(&s, &out).map_or(0.0, |profile| profile.rms);
    let joint = |part: &dyn Fn(Part) -> bool, p: DVec3| nearest_joint(character, body, p, part);
    let trunk = |part: Part| matches!(part, Part::Trunk | Part::Neck | Part::Head);
    let holds = [0, 1].map(|k| match (name.far, far) {
        (Far::Arm, Some(far)) if far == k => {
            joint(&|part| part == Part::Arm(place.side), body.shoulders_rest[index(place.side)])
        }
        (Far::Leg, Some(far)) if far == k => {
            joint(&|part| part == Part::Leg(place.side), body.hips_rest[index(place.side)])
        }
        _ => joint(&trunk, if k == 0 { tips_rest[0] } else { tips_rest[tips_rest.len() - 1] }),
    });
    let [origin, insertion] = [holds[0]?, holds[1]?];
    let shapes = joint(&|_| true, tips_rest[tips_rest.len() / 2])?;
    let attach = |k: usize, joint: u32| attachment(&character.joints[joint as usize], ends[k], normal_rest);
    let (side, suffix) = side_of(Some(place.side));
    let spec = MuscleSpec {
        side,
        rest: shape(alpha, beta, eccentricity, 0),
        active: shape(alpha, beta, eccentricity, 1),
        collision_group: collision_group("trunk", suffix),
        ..MuscleSpec::new(
            &format!("{}{suffix}", name.name),
            &character.joints[shapes as usize].name,
            attach(0, origin),
            attach(1, insertion),
            MuscleSize::Width(primitive.width as f32),
        )
    };
    let ellipses = belly.links.iter().map(|l| sections[l.section].ellipses[l.bump].rms.powi(2)).sum::<f64>();
    let sure = sweep.settings().variation.map_or(SURE_PROMINENCE, |_| SURE_VARIATION);
    let stands_out = (belly.prominence / sure).min(1.0);
    let sections_sure = (belly.links.len() as f64 / SURE_SECTIONS).min(1.0);
    let line_sure = 1.0 - 0.5 * (belly.stray / UNSURE_STRAY).min(1.0);
    Some(Extracted {
        spec,
        place: Where::Trunk(sweep),
        degrees: place.degrees,
        sections: belly.links.len(),
        profile_rms,
        ellipse_rms: (ellipses / belly.links.len() as f64).sqrt(),
        skin_rms: primitive.off(&crest),
        confidence: stands_out * sections_sure * line_sure,
        loft: Loft::new(sections, &belly.links, &roots_rest, ends),
        roots_rest,
        half_width: long,
        across: alignment(sections, &belly.links),
        tips_rest,
    })
}

/// The ends of a muscle that moves a limb, and which of them is on its bone: the one that is nearer to where the bone holds it.
fn held(body: &Body, place: &Place, name: TrunkName, mut ends: [DVec3; 2]) -> Option<([DVec3; 2], usize)> {
    let (from, to) = limb(body, place.side, name.far)?;
    let hold = from.lerp(to, if name.name == "deltoid" { DELTOID_SHARE } else { LIMB_SHARE });
    let far = usize::from(ends[1].distance(hold) < ends[0].distance(hold));
    let beside = (ends[far] - hold).reject_from(to - from);
    let room = LIMB_ROOM * from.distance(to);
    ends[far] = hold + beside * (LIMB_OFF * (room / beside.length().max(1e-9)).min(1.0));
    Some((ends, far))
}

/// The bone that a muscle moves.
fn limb(body: &Body, side: Side, far: Far) -> Option<(DVec3, DVec3)> {
    let side = index(side);
    match far {
        Far::Trunk => None,
        Far::Arm => Some((body.shoulders_rest[side], body.elbows_rest[side])),
        Far::Leg => Some((body.hips_rest[side], body.knees_rest[side])),
    }
}

/// Distance of a point from a segment.
pub(super) fn near(p: DVec3, from: DVec3, to: DVec3) -> f64 {
    let way = to - from;
    let share = ((p - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
    p.distance(from + way * share)
}

/// Mean direction from the ellipses' centres to the tips.
pub(super) fn outward(sections: &[Section], belly: &Belly) -> DVec3 {
    belly.links.iter().map(|l| sections[l.section].outward_rest(l.bump)).sum::<DVec3>().normalize_or(DVec3::Y)
}

/// How square the planes are to a chain's way, 0..=1: the group of planes that are is the one that handles a muscle (paper B).
pub fn alignment(sections: &[Section], links: &[Link]) -> f64 {
    let tip = |l: &Link| sections[l.section].tip_rest(l.bump);
    let way = (tip(&links[links.len() - 1]) - tip(&links[0])).normalize_or_zero();
    links.iter().map(|l| sections[l.section].plane.normal().dot(way).abs()).sum::<f64>() / links.len() as f64
}

/// Of the joints that a muscle may end on the one that moves the skin at a place most, among those of some parts.
fn nearest_joint(character: &Character, body: &Body, p: DVec3, part: &dyn Fn(Part) -> bool) -> Option<u32> {
    let held = |v: usize| {
        let own = character.influences_of(v).iter().filter(|i| i.weight > 0.2);
        own.map(|i| body.holds[i.joint as usize]).find(|&joint| part(body.parts[joint as usize]))
    };
    let away = |v: &usize| character.positions_rest[*v].as_dvec3().distance_squared(p);
    let candidates = (0..character.vertex_count()).filter(|&v| held(v).is_some());
    candidates.min_by(|a, b| away(a).total_cmp(&away(b))).and_then(held)
}
