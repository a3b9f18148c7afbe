//! Table 3: what moving the muscles takes without and with collisions, beside the solver's iterations and residuals.

use super::motion::FPS;
use super::plot::{Align, INK, Label, PALE, Page, RULE, polyline};
use super::timing::{self, Case, Measured};
use super::{Drawn, Figure, Finding, Stage};
use crate::error::FigureError;
use crate::rig::{Attachment, BuildOptions, MuscleSize, MuscleSpec, Rig};
use crate::schedule::{Contacts, DynamicsOptions, Solver};
use glam::Vec3;
use std::f32::consts::TAU;
use std::sync::Arc;

/// Right ends of the columns, pixels, from the third on; the first two are set to the left.
const COLUMNS: [f64; 8] = [470.0, 590.0, 720.0, 840.0, 1000.0, 1130.0, 1250.0, 1380.0];
const NAMES: [&str; 8] =
    ["iterations", "CPU, ms", "device, ms", "elastic, %", "CPU, ms", "device, ms", "elastic, %", "deepest, mm"];
const LEFT: [f64; 2] = [24.0, 190.0];
const WIDTH: u32 = 1410;
const ROW: f64 = 27.0;
const TOP: f64 = 122.0;
const TEXT: f64 = 16.0;

/// Fifty muscles side by side round the upper arm, in five rings of ten, as many as the paper's whole body has.
fn fifty() -> Vec<MuscleSpec> {
    let one = |i: u32| {
        let (ring, place) = (i / 10, i % 10);
        let angle = (place as f32 + 0.5 * (ring % 2) as f32) / 10.0 * TAU;
        let outward = Vec3::new(angle.cos(), 0.0, angle.sin());
        let low = 0.02 + 0.036 * ring as f32;
        let end =
            |y: f32| Attachment { bone: "upperarm".into(), offset: outward * 0.02 + Vec3::Y * y, normal: outward };
        MuscleSpec::new(&format!("muscle {i}"), "upperarm", end(low), end(low + 0.1), MuscleSize::Width(0.012))
    };
    (0..50).map(one).collect()
}

/// Constraints as the paper counts them: one a segment, and one a moving particle for bones and for the skin each.
fn constraints(rig: &Rig, contacts: Contacts) -> u32 {
    let kinds = u32::from(contacts.bones) + u32::from(contacts.skin);
    rig.muscles.iter().map(|muscle| muscle.segments + kinds * (muscle.segments - 1)).sum()
}

/// What solves, in words, and its settings with everything that collides.
fn solvers() -> [(&'static str, DynamicsOptions); 4] {
    let jacobi = |options| DynamicsOptions { solver: Solver::Jacobi, ..options };
    let xpbd = DynamicsOptions::default();
    let pbd = DynamicsOptions::pbd();
    [
        ("compliance, red-black", xpbd),
        ("compliance, jacobi", jacobi(xpbd)),
        ("raw *k*, red-black", pbd),
        ("raw *k*, jacobi", jacobi(pbd)),
    ]
}

/// Substeps of a frame, outer and inner iterations.
fn iterations(options: &DynamicsOptions) -> String {
    format!("{} × {} × {}", options.rate / FPS as u32, options.outer, options.inner)
}

/// One line of the table: without contacts and with them, on the CPU and where there is one on the device.
struct Entry {
    scene: &'static str,
    solver: &'static str,
    options: DynamicsOptions,
    measured: [[Option<Measured>; 2]; 2],
}

/// The figure.
pub(super) fn figure(stage: &Stage<'_>) -> Result<Drawn, FigureError> {
    let arm = Figure::Solvers.arm(stage)?;
    let fifty = Arc::new(Rig::build(arm.rig.character.clone(), &fifty(), &BuildOptions::default())?);
    let scenes = [
        ("Arm shake", &arm.settled, &arm.shake),
        ("Biceps curl", &arm.settled, &arm.curl),
        ("Fifty muscles", &fifty, &arm.shake),
    ];
    #[cfg(feature = "gpu")]
    let bench = stage.device.map(timing::Bench::new).transpose()?;
    let mut entries = Vec::new();
    for (scene, rig, poses) in scenes {
        for (solver, options) in solvers() {
            let mut measured = [[None; 2]; 2];
            for (contacts, column) in [Contacts::NONE, Contacts::ALL].into_iter().zip(&mut measured) {
                let case = Case::new(rig, poses, DynamicsOptions { contacts, ..options });
                column[0] = Some(timing::on_cpu(&case, false)?);
                #[cfg(feature = "gpu")]
                if let Some(bench) = &bench {
                    column[1] = Some(bench.measure(&case, false)?);
                }
            }
            entries.push(Entry { scene, solver, options, measured });
        }
    }
    let mut page = Page::new(WIDTH, (TOP + ROW * entries.len() as f64) as u32 + 108)?;
    head(&mut page)?;
    for (i, entry) in entries.iter().enumerate() {
        let y = TOP + ROW * (i as f64 + 0.5);
        if i % solvers().len() == 0 {
            rule(&mut page, y - 0.5 * ROW)?;
            Label::new(entry.scene, TEXT).align(Align::Left).draw(&mut page, LEFT[0], y)?;
        }
        Label::new(entry.solver, TEXT).align(Align::Left).draw(&mut page, LEFT[1], y)?;
        for (text, right) in entry.cells().iter().zip(COLUMNS) {
            Label::new(text, TEXT).align(Align::Right).draw(&mut page, right, y)?;
        }
    }
    let bottom = TOP + ROW * entries.len() as f64;
    rule(&mut page, bottom)?;
    let counts = [&arm.rig, &fifty].map(|rig| (rig.muscles.len(), constraints(rig, Contacts::ALL)));
    for (i, note) in notes(stage, counts).iter().enumerate() {
        let y = bottom + 24.0 + 23.0 * i as f64;
        Label::new(note, 15.0).align(Align::Left).color(PALE).draw(&mut page, LEFT[0], y)?;
    }
    Ok(Drawn { image: page.finish(), findings: entries.iter().flat_map(Entry::findings).collect() })
}

fn head(page: &mut Page) -> Result<(), FigureError> {
    Label::new("Moving the muscles of one frame of 1/30 s, as in paper A's Table 3", 19.0).draw(
        page,
        0.5 * f64::from(WIDTH),
        28.0,
    )?;
    Label::new("elasticity alone", 17.0).draw(page, 0.5 * (COLUMNS[0] + COLUMNS[3]) + 20.0, 68.0)?;
    Label::new("with collisions", 17.0).draw(page, 0.5 * (COLUMNS[3] + COLUMNS[7]) + 20.0, 68.0)?;
    for (name, right) in NAMES.iter().zip(COLUMNS) {
        Label::new(name, 15.0).align(Align::Right).color(PALE).draw(page, right, TOP - 18.0)?;
    }
    polyline(page, &[[COLUMNS[0] + 30.0, 84.0], [COLUMNS[3], 84.0]], INK, 1.2)?;
    polyline(page, &[[COLUMNS[3] + 40.0, 84.0], [COLUMNS[7], 84.0]], INK, 1.2)
}

fn rule(page: &mut Page, y: f64) -> Result<(), FigureError> {
    polyline(page, &[[LEFT[0], y], [f64::from(WIDTH) - LEFT[0], y]], RULE, 1.4)
}

fn notes(stage: &Stage<'_>, [arm, fifty]: [(usize, u32); 2]) -> [String; 3] {
    let cpu = timing::cpu();
    let device = timing::device(stage).map_or("none".to_string(), |name| name.replace('_', " "));
    let of = |(muscles, constraints)| format!("{muscles} muscles with {constraints} constraints");
    let (arm, fifty) = (of(arm), of(fifty));
    [
        format!(
            "{cpu}; device: {device}. Medians of {} frames. Iterations: substeps × outer × inner. The arm: {arm}; then {fifty}.",
            timing::MEASURED
        ),
        "elastic: largest error of a segment's stretch over its length after the last contact passes; with raw *k*, \
         which no pull balances, of the tendons alone."
            .into(),
        "deepest: in a bone or out of the skin, tendons aside. Residuals are the worst of all frames measured, on CPU \
         and device."
            .into(),
    ]
}

impl Entry {
    fn cells(&self) -> Vec<String> {
        let time = |m: Option<Measured>| m.map_or("–".to_string(), |m| format!("{:.2}", m.dynamics));
        let [without, with] = self.measured;
        let elastic = |column: [Option<Measured>; 2]| format!("{:.2}", 100.0 * worst(column, |r| r.elastic));
        vec![
            iterations(&self.options),
            time(without[0]),
            time(without[1]),
            elastic(without),
            time(with[0]),
            time(with[1]),
            elastic(with),
            format!("{:.3}", 1000.0 * worst(with, |r| r.depth())),
        ]
    }

    fn findings(&self) -> Vec<Finding> {
        let solver = self.solver.replace('*', "");
        let mut findings = Vec::new();
        for (column, name) in self.measured.iter().zip(["elasticity alone", "with collisions"]) {
            let named = |what: &str| format!("{}, {solver}, {name}: {what}", self.scene);
            for (measured, machine) in column.iter().zip(["CPU", "device"]) {
                findings.extend(measured.map(|m| Finding::new(named(machine), m.dynamics, "ms")));
            }
            findings.push(Finding::new(named("elastic residual"), 100.0 * worst(*column, |r| r.elastic), "%"));
            findings.push(Finding::new(named("deepest in bones"), 1000.0 * worst(*column, |r| r.bone), "mm"));
            findings.push(Finding::new(named("farthest outside the skin"), 1000.0 * worst(*column, |r| r.skin), "mm"));
        }
        findings
    }
}

/// The worse of CPU and device.
fn worst(column: [Option<Measured>; 2], of: impl Fn(&crate::dynamics::Residual) -> f32) -> f64 {
    column.iter().flatten().map(|m| f64::from(of(&m.residual))).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::motion::tests::arm;
    use super::*;

    #[test]
    fn fifty_muscles_have_as_many_constraints_as_the_papers() {
        let arm = arm();
        let rig = Rig::build(arm.rig.character.clone(), &fifty(), &BuildOptions::default()).expect("a rig");
        assert_eq!(rig.muscles.len(), 50);
        assert_eq!(constraints(&rig, Contacts::ALL), 4250);
        assert_eq!(constraints(&rig, Contacts::NONE), 50 * 29);
        assert_eq!(constraints(&arm.rig, Contacts::ALL), 7 * 85);
    }

    #[test]
    fn collisions_keep_the_arms_muscles_out_of_its_bones() {
        let arm = arm();
        for (solver, options) in solvers() {
            let depth = |contacts| {
                let case = Case::new(&arm.settled, &arm.shake, DynamicsOptions { contacts, ..options });
                timing::on_cpu(&case, false).expect("frames").residual.depth()
            };
            let (with, without) = (depth(Contacts::ALL), depth(Contacts::NONE));
            assert!(with < 1e-3 && without > 5e-3, "{solver}: {with} {without}");
        }
    }
}
