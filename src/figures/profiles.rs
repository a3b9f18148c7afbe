//! Figures 5, 6 and A.16: how thick a muscle is round its axis and along it.

use super::plot::{Axis, Corner, Line, LinePlot, Page, Rect, SERIES, inside, ramp};
use super::{Drawn, Finding};
use crate::error::FigureError;
use crate::field::muscle::profile::{Exponents, ellipse_squared, overlap};
use crate::field::muscle::{MuscleFrame, Profile};

/// Points of a curve.
const STEPS: u32 = 400;
/// Pixels of a plot.
const SIZE: (u32, u32) = (960, 680);

/// Eccentricities of figure 5.
const ECCENTRICITIES: [f32; 5] = [0.0, 0.6, 0.8, 0.9, 0.97];
/// Shapes of figure 6: the paper's defaults.
const REST: Exponents = (3, 3);
const ACTIVE: Exponents = (4, 7);
const ACTIVATIONS: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// Shapes of figure A.16: even ones from blunt to sharp, and uneven ones.
const EVEN: [Exponents; 4] = [(2, 2), (3, 3), (5, 5), (9, 9)];
const UNEVEN: [Exponents; 6] = [(1, 3), (2, 3), (2, 9), (3, 9), (4, 7), (7, 4)];

/// A section's outline: the unit-area ellipse of equation 5, in the width's units, the section normal to the right.
fn section(eccentricity: f32) -> Vec<[f64; 2]> {
    let (short_squared, long_squared) = ellipse_squared(eccentricity);
    // Of exponents (1, 1) the profile is 1 everywhere, so that the radius is the section's own.
    let even = Profile::of(1, 1);
    let muscle = MuscleFrame {
        factors: even.factors,
        exponents: even.exponents,
        terms: even.terms,
        width: 1.0,
        short_squared,
        long_squared,
        ..MuscleFrame::default()
    };
    (0..=STEPS)
        .map(|i| {
            let theta = f64::from(i) / f64::from(STEPS) * std::f64::consts::TAU;
            let radius = f64::from(muscle.radius(0.5, theta.cos() as f32));
            [radius * theta.cos(), radius * theta.sin()]
        })
        .collect()
}

/// Area inside a closed line.
fn area(outline: &[[f64; 2]]) -> f64 {
    0.5 * outline.windows(2).map(|w| w[0][0] * w[1][1] - w[1][0] * w[0][1]).sum::<f64>()
}

/// A profile's value along the axis.
fn curve(profile: &Profile) -> Vec<[f64; 2]> {
    (0..=STEPS)
        .map(|i| {
            let s = i as f32 / STEPS as f32;
            [f64::from(s), f64::from(profile.at(s).0)]
        })
        .collect()
}

/// The integral of a curve's square, by the trapezoidal rule.
fn square_integral(curve: &[[f64; 2]]) -> f64 {
    curve.windows(2).map(|w| 0.5 * (w[0][1].powi(2) + w[1][1].powi(2)) * (w[1][0] - w[0][0])).sum()
}

/// A colour for step `i` of `n`, dark to light but not so light that white swallows it.
fn step_color(i: usize, n: usize) -> [u8; 3] {
    ramp(0.88 * i as f64 / (n.max(2) - 1) as f64)
}

/// Figure 5.
pub(super) fn sections() -> Result<Drawn, FigureError> {
    let mut page = Page::new(SIZE.0, SIZE.1)?;
    let mut lines = Vec::new();
    let mut findings = Vec::new();
    for (i, e) in ECCENTRICITIES.into_iter().enumerate() {
        let outline = section(e);
        let (short_squared, long_squared) = ellipse_squared(e);
        let name = format!("*e* = {e:.2}:  *u* = {:.2},  *v* = {:.2}", short_squared.sqrt(), long_squared.sqrt());
        findings.push(Finding::new(format!("area at e = {e}, over pi"), area(&outline) / std::f64::consts::PI, ""));
        lines.push(Line::new(name, outline, step_color(i, ECCENTRICITIES.len())));
    }
    let whole = page.whole();
    let inner = inside(whole);
    let across = 2.5;
    let upward = across * f64::from(inner.height) / f64::from(inner.width);
    LinePlot {
        title: "Sections *r*(θ) of equal area π",
        x: Axis {
            name: "along the section normal *n* (θ = 0), in *w*Φ", range: -across..across, ticks: 10, digits: 1
        },
        y: Axis { name: "across it, in *w*Φ", range: -upward..upward, ticks: 8, digits: 1 },
        lines,
        legend: Some(Corner::TopRight),
    }
    .draw(&mut page, whole)?;
    Ok(Drawn { image: page.finish(), findings })
}

/// Figure 6.
pub(super) fn activation() -> Result<Drawn, FigureError> {
    let mut page = Page::new(SIZE.0, SIZE.1)?;
    let whole = page.whole();
    let curves = ACTIVATIONS.map(|a| (a, curve(&Profile::blend(&[(REST, 1.0 - a), (ACTIVE, a)]))));
    let worst = curves.iter().map(|(_, c)| (square_integral(c) - 1.0).abs()).fold(0.0, f64::max);
    let lines = curves.into_iter().enumerate().map(|(i, (a, points))| {
        let shape = match a {
            0.0 => "  (rest: α = 3, β = 3)",
            1.0 => "  (active: α = 4, β = 7)",
            _ => "",
        };
        Line::new(format!("*a* = {a:.2}{shape}"), points, step_color(i, ACTIVATIONS.len()))
    });
    LinePlot {
        title: "Profile Φ(*s*) from rest to activation, its volume kept",
        x: Axis { name: "share *s* of the axis, from origin to insertion", range: 0.0..1.0, ticks: 10, digits: 1 },
        y: Axis { name: "Φ", range: 0.0..2.2, ticks: 6, digits: 1 },
        lines: lines.collect(),
        legend: Some(Corner::TopRight),
    }
    .draw(&mut page, whole)?;
    let findings = vec![
        Finding::new("overlap K of the two shapes", overlap(REST, ACTIVE), ""),
        Finding::new("largest |integral of the squared profile - 1|", worst, ""),
    ];
    Ok(Drawn { image: page.finish(), findings })
}

/// Figure A.16.
pub(super) fn profiles() -> Result<Drawn, FigureError> {
    let mut page = Page::new(1360, 620)?;
    let mut worst = 0.0f64;
    let groups: [(&str, &[Exponents]); 2] =
        [("α = β: sharper as they grow", &EVEN), ("α ≠ β: the belly moves to the smaller one", &UNEVEN)];
    for ((title, shapes), left) in groups.into_iter().zip([0, 680]) {
        let lines = shapes.iter().enumerate().map(|(i, &(alpha, beta))| {
            let points = curve(&Profile::of(alpha, beta));
            worst = worst.max((square_integral(&points) - 1.0).abs());
            let color = if shapes.len() == EVEN.len() { step_color(i, shapes.len()) } else { SERIES[i] };
            let name = format!("α = {alpha}, β = {beta}{}", if alpha == 1 { "  (blunt end)" } else { "" });
            Line { dashed: alpha == 1, ..Line::new(name, points, color) }
        });
        let plot = LinePlot {
            title,
            x: Axis { name: "share *s* of the axis", range: 0.0..1.0, ticks: 10, digits: 1 },
            y: Axis { name: "φ(α, β; *s*)", range: 0.0..3.0, ticks: 7, digits: 1 },
            lines: lines.collect(),
            legend: Some(if left == 0 { Corner::TopLeft } else { Corner::TopRight }),
        };
        plot.draw(&mut page, Rect { left, top: 0, width: 680, height: 620 })?;
    }
    let findings = vec![Finding::new("largest |integral of the squared profile - 1|", worst, "")];
    Ok(Drawn { image: page.finish(), findings })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn sections_have_the_area_of_a_unit_circle_and_the_eccentricity_asked_for() {
        for e in ECCENTRICITIES {
            let outline = section(e);
            // A polygon of 400 corners is short of its ellipse by 3e-4 of it where that is flattest.
            assert!((area(&outline) / PI - 1.0).abs() < 5e-4, "{e}: {}", area(&outline) / PI);
            let off: Vec<_> = outline.iter().map(|p| [p[0] * 1.01, p[1]]).collect();
            assert!((area(&off) / PI - 1.0).abs() > 1e-3, "a longer section must be seen");
            let (long, short) = (outline[0][0], outline[STEPS as usize / 4][1]);
            let found = (1.0 - (short / long).powi(2)).max(0.0).sqrt();
            assert!((found - f64::from(e)).abs() < 1e-3, "{e}: {found}");
        }
    }

    #[test]
    fn curves_have_a_unit_square_integral_and_the_known_maxima() {
        for a in ACTIVATIONS {
            let blend = |norm: bool| {
                let mut profile = Profile::blend(&[(REST, 1.0 - a), (ACTIVE, a)]);
                if !norm {
                    profile.factors *= (overlap(REST, ACTIVE) as f32 * 2.0 * a * (1.0 - a) + 0.9).sqrt();
                }
                square_integral(&curve(&profile))
            };
            assert!((blend(true) - 1.0).abs() < 1e-4, "{a}: {}", blend(true));
            assert!((blend(false) - 1.0).abs() > 1e-3, "a blend without its norm must be seen at {a}");
        }
        for (shape, at, max) in [(REST, 0.5, 1.56874), (ACTIVE, 1.0 / 3.0, 1.93108)] {
            let points = curve(&Profile::of(shape.0, shape.1));
            let top = points.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1])).expect("points");
            assert!((top[0] - at).abs() < 2.0 / f64::from(STEPS) && (top[1] - max).abs() < 1e-4, "{shape:?} {top:?}");
        }
        for (alpha, beta) in EVEN.into_iter().chain(UNEVEN) {
            let square = square_integral(&curve(&Profile::of(alpha, beta)));
            assert!((square - 1.0).abs() < 1e-3, "({alpha}, {beta}): {square}");
        }
    }
}
