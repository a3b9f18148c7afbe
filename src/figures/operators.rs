//! Figure 9: a section through a limb with a muscle, composed by the union, by a blend and by the detail operator.

use super::plot::{Axis, HeatMap, INK, Label, PALE, Page, Rect};
use super::{Drawn, Finding};
use crate::error::FigureError;
use crate::field::Sample;
use crate::field::compose::{detail_samples, larger};
use crate::field::muscle::{AxisPoint, MuscleFrame, MuscleInput, MuscleRest, Profile, evaluate};
use crate::field::transfer::transfer;
use glam::{Vec3, Vec4};

/// Everything is in radii of the limb, whose bone is the origin: support of its field, and the muscle's place and belly.
const LIMB_SUPPORT: f32 = 0.5;
const MUSCLE_AT: f32 = 0.85;
const MUSCLE_RADIUS: f32 = 0.35;
const MUSCLE_LENGTH: f32 = 3.0;
/// What is shown.
const SHOWN: [[f32; 2]; 2] = [[-0.25, 1.45], [-0.85, 0.85]];
/// Distance of the places that are looked at.
const STEP: f32 = 0.005;
/// Distance of the arrows, and their length.
const ARROWS: f32 = 0.1;
const ARROW: f32 = 0.075;
/// Places of less value are not counted, nor those nearer to the bone, where the limb's own field has its peak.
const LEAST: f32 = 0.15;
const CORE: f32 = 0.3;
/// Arrows that lead away from the bone.
const WRONG: [u8; 3] = [255, 84, 62];

/// The limb with its muscle.
struct Limb {
    muscle: MuscleFrame,
    points: Vec<AxisPoint>,
}

/// How two fields are put together.
type Operator = fn(Sample, Sample) -> Sample;

/// Ricci's blend of order two.
fn ricci(a: Sample, b: Sample) -> Sample {
    let value = a.value.hypot(b.value);
    if value <= 0.0 {
        return Sample::default();
    }
    Sample { value, gradient: (a.gradient * a.value + b.gradient * b.value) / value }
}

const OPERATORS: [(&str, &str, Operator); 3] = [
    ("union", "Union: the larger field", larger),
    ("blend", "Ricci's blend: √(*f*_1^2 + *f*_2^2)", ricci),
    ("detail operator", "Detail operator", detail_samples),
];

impl Limb {
    fn new() -> Limb {
        let profile = Profile::of(3, 3);
        let input = MuscleInput::new(&profile, 0.0);
        let width = MUSCLE_RADIUS / input.profile_bound;
        let rest = MuscleRest {
            origin: Vec3::new(MUSCLE_AT, 0.0, -0.5 * MUSCLE_LENGTH)
                .extend(std::f32::consts::PI * width * width * MUSCLE_LENGTH),
            insertion: Vec3::new(MUSCLE_AT, 0.0, 0.5 * MUSCLE_LENGTH).extend(MUSCLE_RADIUS),
            origin_normal: Vec4::Y,
            insertion_normal: Vec4::Y,
            segments: 29,
            ..MuscleRest::default()
        };
        let mut points = vec![AxisPoint::default(); 30];
        let muscle = rest.at_rest(&input, &mut points);
        Limb { muscle, points }
    }

    /// The composed field in the section through the muscle's belly. The limb's raw distance is that of an interpolant of
    /// Hermite samples round a cylinder.
    fn at(&self, operator: Operator, x: f32, y: f32) -> Sample {
        let p = Vec3::new(x, y, 0.0);
        let (value, slope) = transfer(0.5 * (p.length_squared() - 1.0), LIMB_SUPPORT);
        operator(Sample { value, gradient: p * slope }, evaluate(&self.muscle, &self.points, p))
    }
}

/// What is wrong with a composed field.
#[derive(Debug, Default)]
struct Faults {
    /// Places round which the gradient turns once: it is zero there, or has no direction.
    singular: Vec<[f64; 2]>,
    /// Share of the places where it leads away from the bone.
    wrong: f64,
    /// Largest angle between neighbours, degrees.
    turn: f64,
    /// Ends of the pieces of the surface.
    surface: Vec<[[f64; 2]; 2]>,
}

fn leads_away(x: f32, y: f32, sample: &Sample) -> bool {
    sample.gradient.x * x + sample.gradient.y * y > 0.0
}

/// The angle from one direction to another, degrees, -180 to 180.
fn turn(from: &Sample, to: &Sample) -> f64 {
    let (a, b) = (from.gradient, to.gradient);
    f64::from((a.x * b.y - a.y * b.x).atan2(a.x * b.x + a.y * b.y)).to_degrees()
}

/// Looks at every place of a grid.
fn faults(limb: &Limb, operator: Operator) -> Faults {
    let [[left, right], [bottom, top]] = SHOWN;
    let (columns, rows) = (((right - left) / STEP) as usize, ((top - bottom) / STEP) as usize);
    // Half a step off, so that no place stands on the axis of symmetry.
    let place = |i: usize, j: usize| (left + (i as f32 + 0.5) * STEP, bottom + (j as f32 + 0.5) * STEP);
    let samples: Vec<Sample> = (0..rows * columns)
        .map(|k| {
            let (x, y) = place(k % columns, k / columns);
            limb.at(operator, x, y)
        })
        .collect();
    let mut found = Faults::default();
    let (mut seen, mut wrong) = (0u32, 0u32);
    for j in 0..rows - 1 {
        for i in 0..columns - 1 {
            let (x, y) = place(i, j);
            let own = samples[j * columns + i];
            let round =
                [own, samples[j * columns + i + 1], samples[(j + 1) * columns + i + 1], samples[(j + 1) * columns + i]];
            if own.value > LEAST && x.hypot(y) > CORE {
                seen += 1;
                wrong += u32::from(leads_away(x, y, &own));
                let most = turn(&own, &round[1]).abs().max(turn(&own, &round[3]).abs());
                found.turn = found.turn.max(most);
                let whole: f64 = (0..4).map(|k| turn(&round[k], &round[(k + 1) % 4])).sum();
                if whole.abs() > 180.0 {
                    found.singular.push([x, y].map(|v| f64::from(v + 0.5 * STEP)));
                }
            }
            found.surface.extend(crossing([x, y], &round));
        }
    }
    found.wrong = f64::from(wrong) / f64::from(seen.max(1));
    found
}

/// Where the surface crosses a cell whose corners go round from the lower left.
fn crossing([x, y]: [f32; 2], round: &[Sample; 4]) -> Option<[[f64; 2]; 2]> {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut ends = (0..4).filter_map(|k| {
        let (from, to) = (round[k].value - 0.5, round[(k + 1) % 4].value - 0.5);
        ((from < 0.0) != (to < 0.0)).then(|| {
            let share = from / (from - to);
            let [a, b] = [corners[k], corners[(k + 1) % 4]];
            [x + (a[0] + (b[0] - a[0]) * share) * STEP, y + (a[1] + (b[1] - a[1]) * share) * STEP].map(f64::from)
        })
    });
    Some([ends.next()?, ends.next()?])
}

/// Arrows along the gradient, shafts and heads; red where they lead away from the bone.
fn arrows(limb: &Limb, operator: Operator) -> Vec<(Vec<[f64; 2]>, [u8; 3], f64)> {
    let [[left, right], [bottom, top]] = SHOWN;
    let (columns, rows) = (((right - left) / ARROWS) as u32, ((top - bottom) / ARROWS) as u32);
    let mut lines = Vec::new();
    for k in 0..columns * rows {
        let (x, y) = (left + ((k % columns) as f32 + 0.5) * ARROWS, bottom + ((k / columns) as f32 + 0.5) * ARROWS);
        let sample = limb.at(operator, x, y);
        if sample.value < 0.02 {
            continue;
        }
        let along = sample.gradient.normalize_or_zero() * ARROW;
        let across = Vec3::new(-along.y, along.x, 0.0);
        let [middle, to] = [Vec3::new(x, y, 0.0), Vec3::new(x, y, 0.0) + along * 0.5];
        let at = |p: Vec3| [f64::from(p.x), f64::from(p.y)];
        let barb = |side: f32| at(to - along * 0.38 + across * (0.24 * side));
        let color = match leads_away(x, y, &sample) {
            true => WRONG,
            false if sample.value > 0.62 => INK,
            false => [255; 3],
        };
        let width = if color == WRONG { 2.2 } else { 1.3 };
        lines.push((vec![at(middle - along * 0.5), at(to)], color, width));
        lines.push((vec![barb(1.0), at(to), barb(-1.0)], color, width));
    }
    lines
}

/// The figure.
pub(super) fn figure() -> Result<Drawn, FigureError> {
    let mut page = Page::new(1500, 590)?;
    let limb = Limb::new();
    let [across, upward] = SHOWN.map(|r| f64::from(r[0])..f64::from(r[1]));
    let mut findings = Vec::new();
    for ((name, title, operator), left) in OPERATORS.into_iter().zip([0, 470, 940]) {
        let found = faults(&limb, operator);
        let at = |[x, y]: [f64; 2]| {
            let value = limb.at(operator, x as f32, y as f32).value;
            (value > 0.0).then_some(f64::from(value))
        };
        let surface = found.surface.iter().map(|ends| (ends.to_vec(), [255, 255, 255], 2.6));
        let map = HeatMap {
            title,
            x: Axis { name: "from the bone, in limb radii", range: across.clone(), ticks: 5, digits: 1 },
            y: Axis { name: "", range: upward.clone(), ticks: 5, digits: 1 },
            value: Axis { name: "*f*", range: 0.0..1.0, ticks: 6, digits: 1 },
            at: &at,
            bands: 20,
            lines: surface.chain(arrows(&limb, operator)).collect(),
            points: found.singular.clone(),
            bar: left == 940,
        };
        let width = if map.bar { 560 } else { 470 };
        let inner = map.draw(&mut page, Rect { left, top: 4, width, height: 500 })?;
        let middle = f64::from(inner.left) + 0.5 * f64::from(inner.width);
        let singular = found.singular.len();
        let note = format!(
            "singular points: {singular}; {:.2} % of the gradients lead away from the bone",
            100.0 * found.wrong
        );
        Label::new(&note, 14.0).color(PALE).draw(&mut page, middle, 522.0)?;
        let note = format!("largest turn between neighbours {:.0}°", found.turn);
        Label::new(&note, 14.0).color(PALE).draw(&mut page, middle, 543.0)?;
        findings.push(Finding::new(format!("singular points, {name}"), singular as f64, ""));
        findings.push(Finding::new(
            format!("gradients that lead away from the bone, {name}"),
            100.0 * found.wrong,
            "%",
        ));
        findings.push(Finding::new(format!("largest turn between neighbours, {name}"), found.turn, "degrees"));
    }
    let note = format!(
        "Section through a limb with a muscle; arrows run up the field, red ones away from the bone, the white line is the surface. \
         Counted {STEP} limb radii apart, where the field is over {LEAST}, farther than {CORE} from the bone."
    );
    Label::new(&note, 14.0).color(PALE).draw(&mut page, 750.0, 570.0)?;
    Ok(Drawn { image: page.finish(), findings })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_detail_operator_leads_to_the_bone_throughout() {
        let limb = Limb::new();
        let [union, blend, detail] = OPERATORS.map(|(_, _, operator)| faults(&limb, operator));
        // In the muscle's core little of the gradient is left, so that it turns within a few hundredths of a radius.
        let told =
            |faults: &Faults| format!("{} singular, {} wrong, {}°", faults.singular.len(), faults.wrong, faults.turn);
        assert!(detail.singular.is_empty() && detail.wrong <= 1e-3 && detail.turn < 30.0, "{}", told(&detail));
        for other in [&union, &blend] {
            assert!(!other.singular.is_empty() && other.wrong > 1e-3, "{}", told(other));
        }
        assert!(union.turn > 90.0, "{}", union.turn);
    }

    #[test]
    fn the_surface_stands_where_the_fields_say() {
        let limb = Limb::new();
        let union = faults(&limb, larger);
        let off = |p: [f64; 2]| {
            let (x, y) = (p[0] as f32, p[1] as f32);
            (x.hypot(y) - 1.0).abs().min(((x - MUSCLE_AT).hypot(y) - MUSCLE_RADIUS).abs())
        };
        assert!(union.surface.len() > 300);
        assert!(union.surface.iter().flatten().all(|p| off(*p) < 2.0 * STEP), "the union's surface is the two parts'");
        assert!(faults(&limb, ricci).surface.iter().flatten().any(|p| off(*p) > 4.0 * STEP), "a blend's is not");
    }
}
