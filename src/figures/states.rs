//! Figure 11: the calf least and most activated, and a back muscle of fibres, in two shapes.

use super::fibres::{CHEST, Fibre, HUMERUS, fibres, mirrored, on_chest, settle, skeleton};
use super::plot::{INK, Label, PALE, Page};
use super::scene::{self, BONE, Studio};
use super::{Drawn, Finding};
use crate::error::FigureError;
use crate::field::muscle::{AxisPoint, MuscleFrame, MuscleInput, MuscleRest, Profile};
use crate::gpu::Headless;
use crate::render::{Camera, ColorMesh, Direction, activation_color};
use glam::{Mat3, Vec3};

const HEIGHT: u32 = 760;
const TITLE: u32 = 84;
/// Pixels across of a calf and of the back.
const CALF: u32 = 360;
const BACK: u32 = 700;
/// Segments of a calf muscle.
const SEGMENTS: u32 = 29;

/// The calf's muscles, from the knee to the heel: both heads of the outer one and the one under them.
fn calf(activation: f32) -> Vec<Fibre> {
    let heel = Vec3::new(0.0, 0.045, -0.040);
    let heads = [
        (Vec3::new(0.022, 0.455, -0.026), heel + Vec3::X * 0.004, 0.031),
        (Vec3::new(-0.022, 0.455, -0.026), heel - Vec3::X * 0.004, 0.029),
        (Vec3::new(0.006, 0.400, -0.014), heel + Vec3::Z * 0.004, 0.027),
    ];
    let profile = Profile::blend(&[((3, 3), 1.0 - activation), ((4, 8), activation)]);
    let made = heads.map(|(origin, insertion, radius)| {
        let length = origin.distance(insertion);
        // So wide that its largest radius at rest is the one given.
        let width = radius / Profile::of(3, 3).max();
        let rest = MuscleRest {
            origin: origin.extend(std::f32::consts::PI * width * width * length),
            insertion: insertion.extend(0.03),
            origin_normal: Vec3::X.extend(length),
            insertion_normal: Vec3::X.extend(0.0),
            segments: SEGMENTS,
            ..MuscleRest::default()
        };
        let input = MuscleInput { activation, ..MuscleInput::new(&profile, 0.3) };
        let mut points = vec![AxisPoint::default(); SEGMENTS as usize + 1];
        (rest.at_rest(&input, &mut points), points)
    });
    made.to_vec()
}

/// Shin, thigh and foot.
fn leg() -> ColorMesh {
    scene::joined([
        scene::rod(Vec3::new(0.0, 0.435, 0.004), Vec3::new(0.0, 0.075, 0.008), [0.024, 0.016], BONE),
        scene::rod(Vec3::new(0.0, 0.47, 0.002), Vec3::new(0.0, 0.62, 0.012), [0.031, 0.019], BONE),
        scene::ellipsoid(Vec3::new(0.0, 0.03, 0.05), Mat3::from_diagonal(Vec3::new(0.032, 0.024, 0.115)), BONE),
        scene::ball(Vec3::new(0.0, 0.038, -0.034), 0.024, BONE),
    ])
}

/// The broad muscle of the back: from the spine's lower half to the humerus.
fn back(shape: (u32, u32)) -> Result<Vec<Fibre>, FigureError> {
    let origin = [on_chest(0.014, 0.085, -1.0), on_chest(0.014, -0.090, -1.0), on_chest(0.070, -0.185, -1.0)];
    let insertion = [Vec3::new(0.228, 0.112, -0.010), Vec3::new(0.238, 0.092, -0.030)];
    settle(&fibres("back", 8, [&origin, &insertion], shape, 0.019), &[CHEST, HUMERUS])
}

fn drawn(fibres: &[Fibre]) -> ColorMesh {
    scene::joined(fibres.iter().map(|(m, points)| scene::fibre(m, points, activation_color(m.activation))))
}

/// The thickest that a muscle gets, metres.
fn belly((muscle, _): &(MuscleFrame, Vec<AxisPoint>)) -> f32 {
    muscle.width * muscle.profile().max()
}

/// The figure.
pub(super) fn figure(headless: &Headless) -> Result<Drawn, FigureError> {
    let mut page = Page::new(2 * CALF + BACK, HEIGHT)?;
    let states = [0.0, 1.0].map(calf);
    let legs = states.each_ref().map(|fibres| vec![leg(), drawn(fibres)]);
    let studio = Studio::new(headless, CALF, HEIGHT - TITLE)?;
    let points = |solids: &[Vec<ColorMesh>]| -> Vec<Vec3> {
        solids.iter().flatten().flat_map(|mesh| mesh.positions.iter().copied()).collect()
    };
    let camera = Camera::around(&points(&legs), Direction { azimuth: 205.0, elevation: 6.0 }, studio.aspect());
    let titles =
        [["Calf, least activated", "α = 3, β = 3, *a* = 0"], ["Calf, most activated", "α = 4, β = 8, *a* = 1"]];
    for ((solids, title), left) in legs.iter().zip(titles).zip([0, CALF]) {
        page.paste(&studio.solids(&camera, solids)?, left, TITLE);
        write(&mut page, f64::from(left + CALF / 2), title)?;
    }
    let shapes = [back((2, 3))?, back((1, 3))?];
    let solids = vec![skeleton(), drawn(&shapes[0]), mirrored(&drawn(&shapes[1]))];
    let studio = Studio::new(headless, BACK, HEIGHT - TITLE)?;
    let held = points(std::slice::from_ref(&solids));
    let camera = Camera::around(&held, Direction { azimuth: 180.0, elevation: 8.0 }, studio.aspect());
    page.paste(&studio.solids(&camera, &solids)?, 2 * CALF, TITLE);
    // From behind the body's left is at the left.
    let middle = f64::from(2 * CALF + BACK / 2);
    write(&mut page, middle - 170.0, ["Back muscle at rest", "α = 2, β = 3"])?;
    write(&mut page, middle + 170.0, ["Back muscle at rest", "α = 1, β = 3 (blunt at the spine)"])?;
    let findings = vec![
        Finding::new("largest radius of the outer calf head, a = 0", f64::from(belly(&states[0][0])) * 1000.0, "mm"),
        Finding::new("largest radius of the outer calf head, a = 1", f64::from(belly(&states[1][0])) * 1000.0, "mm"),
    ];
    Ok(Drawn { image: page.finish(), findings })
}

fn write(page: &mut Page, x: f64, [title, shape]: [&str; 2]) -> Result<(), FigureError> {
    Label::new(title, 20.0).color(INK).draw(page, x, 28.0)?;
    Label::new(shape, 17.0).color(PALE).draw(page, x, 56.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::muscle::mesh::{Detail, surface};

    #[test]
    fn activation_thickens_the_calf_and_keeps_its_volume() {
        let (rest, active) = (calf(0.0), calf(1.0));
        for (a, b) in rest.iter().zip(&active) {
            let ratio = belly(b) / belly(a);
            assert!((ratio - 2.00610 / 1.56874).abs() < 1e-3, "the profiles' maxima: {ratio}");
            let volume = |(m, points): &Fibre| surface(m, points, Detail { rings: 80, around: 128 }).volume();
            assert!((volume(b) / volume(a) - 1.0).abs() < 2e-3);
            let mut wider = b.clone();
            wider.0.width *= 1.01;
            assert!((volume(&wider) / volume(a) - 1.0).abs() > 1e-2, "a wider muscle must be seen");
        }
    }
}
