//! Figure 12: what a frame takes, over the number of particles in each muscle.

use super::motion::FPS;
use super::plot::{Axis, Corner, Label, Line, LinePlot, PALE, Page, Rect, SERIES};
use super::timing::{self, Case, Measured};
use super::{Arm, Drawn, Figure, Finding, Stage};
use crate::dynamics::settle;
use crate::error::FigureError;
use crate::rig::{BuildOptions, MuscleSpec, Rig};
use crate::schedule::{DynamicsOptions, Solver};
use std::sync::Arc;

/// Particles of each muscle.
const PARTICLES: [u32; 6] = [5, 10, 20, 30, 45, 60];
const PANEL: [u32; 2] = [680, 520];
const NOTE: u32 = 50;

/// The arm with as many particles in every muscle.
fn with_particles(arm: &Arm, particles: u32) -> Result<Rig, FigureError> {
    let specs: Vec<MuscleSpec> =
        arm.rig.specs.iter().map(|spec| MuscleSpec { segments: particles - 1, ..spec.clone() }).collect();
    let mut rig = Rig::build(arm.rig.character.clone(), &specs, &BuildOptions::default())?;
    settle(&mut rig, &DynamicsOptions::default());
    Ok(rig)
}

/// What measures a case, with or without the skin.
type Measure<'a> = Box<dyn Fn(&Case<'_>, bool) -> Result<Measured, FigureError> + 'a>;

/// Who measures, in words, and how.
fn machines<'a>(stage: &Stage<'a>) -> Result<Vec<(String, Measure<'a>)>, FigureError> {
    let cpu: Measure<'a> = Box::new(timing::on_cpu);
    Ok(std::iter::once((timing::cpu(), cpu)).chain(on_device(stage)?).collect())
}

#[cfg(feature = "gpu")]
fn on_device<'a>(stage: &Stage<'a>) -> Result<Option<(String, Measure<'a>)>, FigureError> {
    let Some(headless) = stage.device else { return Ok(None) };
    let bench = timing::Bench::new(headless)?;
    let measure: Measure<'a> = Box::new(move |case, with_skin| bench.measure(case, with_skin));
    Ok(timing::device(stage).map(|name| (name, measure)))
}

#[cfg(not(feature = "gpu"))]
fn on_device<'a>(_: &Stage<'a>) -> Result<Option<(String, Measure<'a>)>, FigureError> {
    Ok(None)
}

/// What was measured for one number of particles.
struct Times {
    particles: u32,
    /// With the default solver, and the skin.
    whole: Measured,
    /// With the other solver, and as many iterations.
    jacobi: Measured,
}

/// The figure.
pub(super) fn figure(stage: &Stage<'_>) -> Result<Drawn, FigureError> {
    let arm = Figure::Times.arm(stage)?;
    let machines = machines(stage)?;
    let mut measured: Vec<Vec<Times>> = machines.iter().map(|_| Vec::new()).collect();
    for particles in PARTICLES {
        let rig = Arc::new(with_particles(arm, particles)?);
        let case = |solver| Case::new(&rig, &arm.shake, DynamicsOptions { solver, ..DynamicsOptions::default() });
        for ((_, measure), times) in machines.iter().zip(&mut measured) {
            let whole = measure(&case(Solver::RedBlack), true)?;
            let jacobi = measure(&case(Solver::Jacobi), false)?;
            times.push(Times { particles, whole, jacobi });
        }
    }
    let mut page = Page::new(PANEL[0] * machines.len() as u32, PANEL[1] + NOTE)?;
    let mut findings = Vec::new();
    for (column, ((name, _), times)) in (0..).zip(machines.iter().zip(&measured)) {
        let place = Rect { left: column * PANEL[0], top: 0, width: PANEL[0], height: PANEL[1] };
        plot(name, times, &mut page, place)?;
        for found in times {
            let named = |what: &str| format!("{name}, {:2} particles: {what}", found.particles);
            findings.push(Finding::new(named("dynamics"), found.whole.dynamics, "ms"));
            findings.push(Finding::new(named("dynamics, jacobi"), found.jacobi.dynamics, "ms"));
            findings.push(Finding::new(named("Implicit Skinning"), found.whole.skin, "ms"));
        }
    }
    let options = DynamicsOptions::default();
    let note = format!(
        "{} muscles, {} vertices; a frame is 1/{FPS} s: {} substeps of {} × {} iterations. Medians of {} frames.",
        arm.rig.muscles.len(),
        arm.rig.character.vertex_count(),
        options.rate / FPS as u32,
        options.outer,
        options.inner,
        timing::MEASURED,
    );
    let [across, down] = [page.size().0, PANEL[1] + NOTE / 2].map(f64::from);
    Label::new(&note, 15.0).color(PALE).draw(&mut page, 0.5 * across, down - 6.0)?;
    Ok(Drawn { image: page.finish(), findings })
}

fn plot(name: &str, times: &[Times], page: &mut Page, place: Rect) -> Result<(), FigureError> {
    let line = |name: &str, color: usize, value: &dyn Fn(&Times) -> f64| {
        let points = times.iter().map(|found| [f64::from(found.particles), value(found)]);
        Line::new(name, points.collect(), SERIES[color])
    };
    let lines = vec![
        line("whole frame", 0, &|t| t.whole.dynamics + t.whole.skin),
        line("Implicit Skinning with muscles", 1, &|t| t.whole.skin),
        line("dynamics of the muscles", 2, &|t| t.whole.dynamics),
        line("the same, jacobi", 3, &|t| t.jacobi.dynamics),
    ];
    let most = lines[0].points.iter().map(|p| p[1]).fold(0.0, f64::max);
    let title = name.replace('_', " ");
    let x = Axis { name: "particles in each muscle", range: 0.0..60.0, ticks: 7, digits: 0 };
    let y = Axis { name: "time a frame, ms", range: 0.0..round(most), ticks: 7, digits: digits(most) };
    LinePlot { title: &title, x, y, lines, legend: Some(Corner::TopLeft) }.draw(page, place)
}

/// The next of 1, 2, 3, 5 and their tenfolds that leaves room for a legend.
fn round(most: f64) -> f64 {
    let wanted = 1.15 * most.max(1e-6);
    let ten = 10f64.powf(wanted.log10().floor());
    [1.0, 2.0, 3.0, 5.0, 10.0].map(|step| step * ten).into_iter().find(|top| *top >= wanted).unwrap_or(10.0 * ten)
}

fn digits(most: f64) -> usize {
    (1.0 - most.max(1e-6).log10().floor()).clamp(0.0, 4.0) as usize
}

#[cfg(test)]
mod tests {
    use super::super::motion::tests::arm;
    use super::*;

    #[test]
    fn every_muscle_has_as_many_particles() {
        let arm = arm();
        for particles in [5, 60] {
            let rig = with_particles(&arm, particles).expect("a rig");
            assert_eq!(rig.point_count, particles * 7);
        }
        assert!(with_particles(&arm, 2).is_err(), "a muscle of one segment is none");
    }

    #[test]
    fn axes_end_above_what_they_show() {
        for (most, top) in [(0.9, 2.0), (3.1, 5.0), (41.0, 50.0), (46.0, 100.0), (0.03, 0.05)] {
            assert!((round(most) - top).abs() < 1e-9 * top, "{most}: {}", round(most));
        }
        assert_eq!((digits(41.0), digits(3.1), digits(0.03)), (0, 1, 3));
    }
}
