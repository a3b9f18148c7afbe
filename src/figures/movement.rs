//! Paper B's figure 2: a muscle's bulge, and muscles that bend round a joint and round a bone.

use super::plot::{INK, Label, PALE, Page};
use super::scene::{self, BONE, Studio};
use super::{Drawn, Finding};
use crate::error::FigureError;
use crate::field::muscle::wrap::{
    Course, MuscleWrap, Spacing,
    cylinder::{self, Cylinder},
    sphere::Side,
};
use crate::field::muscle::{AxisPoint, MuscleFrame, MuscleInput, MuscleRest, Profile, shape, straighten};
use crate::gpu::Headless;
use crate::render::{Camera, ColorMesh, Direction, activation_color};
use glam::{Mat4, Vec3, Vec4Swizzles};

const PANEL: [u32; 2] = [430, 400];
const TITLE: u32 = 64;
/// Segments of an axis.
const SEGMENTS: u32 = 45;
/// Radius of the joint and of the bone, and how much of a muscle's thickness is added to it, metres.
const RADIUS: f32 = 0.026;
const HALF: f32 = 0.010;
/// Shares of its length at rest at which the bulging muscle is shown.
const LENGTHS: [f32; 3] = [1.0, 0.85, 0.7];
/// Angles of the joint, degrees, and turns of the lower bone round the upper one.
const ANGLES: [f32; 3] = [10.0, 60.0, 110.0];
const TURNS: [f32; 3] = [70.0, 120.0, 170.0];
/// The straight and the wound parts of a path.
const PARTS: [[f32; 3]; 3] = [[0.02, 0.20, 0.60], [0.75, 0.28, 0.02], [0.05, 0.42, 0.12]];
/// The frames' axes along a path, across it, and across both.
const AXES: [[f32; 3]; 3] = [[0.75, 0.05, 0.05], [0.05, 0.45, 0.08], [0.05, 0.15, 0.70]];

/// A muscle with its points and, where it bends round something, its path.
struct Bent {
    frame: MuscleFrame,
    points: Vec<AxisPoint>,
    course: Option<Course>,
}

/// A muscle of 7 cl between two points, straight or round an obstacle.
fn muscle(wrap: Option<&MuscleWrap>, ends: [Vec3; 2], normal: Vec3) -> Bent {
    let rest = MuscleRest { origin: ends[0].extend(7e-5), segments: SEGMENTS, ..MuscleRest::default() };
    let mut points = vec![AxisPoint::default(); SEGMENTS as usize + 1];
    let course = wrap.map(|wrap| Course::new(wrap, &wrap.to_rest, ends[0], ends[1], Spacing::Even));
    match &course {
        Some(course) => course.put(&mut points),
        None => straighten(&mut points, ends[0], ends[1]),
    }
    let input = MuscleInput::new(&Profile::of(3, 3), 0.3);
    let frame = shape(&rest, &input, &mut points, normal, normal);
    Bent { frame, points, course }
}

fn wrap(side: glam::Vec4, sphere: bool) -> MuscleWrap {
    MuscleWrap {
        to_rest: Mat4::IDENTITY,
        side,
        radius: RADIUS + HALF,
        low: -0.3,
        high: 0.3,
        sphere: sphere.into(),
        segments: SEGMENTS,
        ..MuscleWrap::default()
    }
}

/// A muscle over a joint about Z that is bent by an angle, and the joint's bones.
fn round_joint(degrees: f32) -> (Bent, ColorMesh) {
    let lower = glam::Quat::from_rotation_z(degrees.to_radians());
    let (origin, rest) = (Vec3::new(0.040, -0.21, 0.0), Vec3::new(0.037, 0.15, 0.0));
    let side = Side::at_rest(origin, rest, RADIUS + HALF, None);
    let side = side.map_or(Vec3::Z.extend(0.0), |side| side.axis.extend(side.swept));
    let bones = scene::joined([
        scene::rod(Vec3::Y * -0.24, Vec3::ZERO, [0.015, 0.016], BONE),
        scene::rod(Vec3::ZERO, lower * (Vec3::Y * 0.22), [0.016, 0.012], BONE),
        scene::ball(Vec3::ZERO, RADIUS, BONE),
    ]);
    (muscle(Some(&wrap(side, true)), [origin, lower * rest], Vec3::Z), bones)
}

/// A slim muscle that winds round a bone along Z, and the bones: the lower one has turned about it.
fn round_bone(degrees: f32) -> (Bent, ColorMesh) {
    let turn = |angle: f32| glam::Quat::from_rotation_z(angle.to_radians());
    let origin = Vec3::new(0.041, 0.0, -0.10);
    let insertion = turn(degrees) * Vec3::new(0.043, 0.0, 0.10);
    let bone = Cylinder { radius: RADIUS + HALF, low: -0.3, high: 0.3 };
    let swept = cylinder::side_at_rest(origin, turn(100.0) * Vec3::X * 0.043, &bone, None).unwrap_or_default();
    let bones = scene::joined([
        scene::rod(Vec3::Z * -0.15, Vec3::Z * 0.06, [RADIUS, RADIUS], BONE),
        scene::rod(Vec3::Z * 0.10, Vec3::Z * 0.16, [RADIUS * 0.9, RADIUS], BONE),
        scene::rod(Vec3::Z * 0.10, insertion, [0.009, 0.006], BONE),
        scene::rod(Vec3::Z * -0.11, origin, [0.009, 0.006], BONE),
    ]);
    (muscle(Some(&wrap(Vec3::Z.extend(swept), false)), [origin, insertion], Vec3::Z), bones)
}

/// A path as a tube, its three parts in their colours, with a frame on every fifth point.
fn framed(bent: &Bent) -> ColorMesh {
    let mut mesh = ColorMesh::default();
    let Some(course) = &bent.course else { return mesh };
    let [first, wound, _] = course.path().parts;
    for pair in bent.points.windows(2) {
        let middle = 0.5 * (pair[0].arc() + pair[1].arc());
        let part = usize::from(middle > first) + usize::from(middle > first + wound);
        mesh.append(&scene::tube(&[pair[0].position.xyz(), pair[1].position.xyz()], 0.0016, PARTS[part]));
    }
    for point in bent.points.iter().skip(2).step_by(5) {
        let (at, along) = (point.position.xyz(), point.tangent.xyz());
        let across = point.normal.xyz();
        for (axis, color) in [along, across, along.cross(across)].into_iter().zip(AXES) {
            mesh.append(&scene::arrow(at, at + axis * 0.018, 0.0008, color));
        }
    }
    mesh
}

fn drawn(bent: &Bent) -> ColorMesh {
    scene::fibre(&bent.frame, &bent.points, activation_color(0.6))
}

fn moved(mut mesh: ColorMesh, by: Vec3) -> ColorMesh {
    mesh.positions.iter_mut().for_each(|p| *p += by);
    mesh
}

/// The largest radius of a muscle, metres.
fn belly(bent: &Bent) -> f32 {
    bent.frame.width * bent.frame.profile().max()
}

/// The figure.
pub(super) fn figure(headless: &Headless) -> Result<Drawn, FigureError> {
    let studio = Studio::new(headless, PANEL[0], PANEL[1])?;
    let bulging = LENGTHS.map(|share| muscle(None, [Vec3::ZERO, Vec3::Y * (0.30 * share)], Vec3::X));
    let (joints, bones) = (ANGLES.map(round_joint), TURNS.map(round_bone));
    let row = |parts: Vec<ColorMesh>, step: Vec3| -> Vec<ColorMesh> {
        (0..).zip(parts).map(|(i, part)| moved(part, step * i as f32)).collect()
    };
    let both = |(bent, bones): &(Bent, ColorMesh)| scene::joined([drawn(bent), bones.clone()]);
    let paths = |(bent, bones): &(Bent, ColorMesh)| scene::joined([framed(bent), bones.clone()]);
    let panels = [
        (
            "(a) bulge at 100, 85 and 70 % of its length",
            row(bulging.iter().map(drawn).collect(), Vec3::X * 0.09),
            Direction::FRONT,
        ),
        ("(b) frames round a joint", vec![paths(&joints[1])], Direction { azimuth: -8.0, elevation: 12.0 }),
        (
            "(c) round a joint: 10, 60 and 110°",
            row(joints.iter().map(both).collect(), Vec3::X * 0.31),
            Direction::FRONT,
        ),
        ("(d) frames round a bone", vec![paths(&bones[1])], Direction { azimuth: 62.0, elevation: 28.0 }),
        (
            "(e) round a bone",
            row(bones.iter().map(both).collect(), Vec3::new(0.08, -0.13, 0.0)),
            Direction { azimuth: 62.0, elevation: 28.0 },
        ),
    ];
    let mut page = Page::new(3 * PANEL[0], 2 * (PANEL[1] + TITLE))?;
    for (k, (title, solids, direction)) in (0..).zip(&panels) {
        let points: Vec<Vec3> = solids.iter().flat_map(|mesh| mesh.positions.iter().copied()).collect();
        let camera = Camera::around(&points, *direction, studio.aspect());
        let (left, top) = (k % 3 * PANEL[0], k / 3 * (PANEL[1] + TITLE));
        page.paste(&studio.solids(&camera, solids)?, left, top + TITLE);
        let middle = f64::from(left + PANEL[0] / 2);
        Label::new(title, 19.0).color(INK).draw(&mut page, middle, f64::from(top) + 26.0)?;
    }
    let notes = ["blue: from the origin", "orange: against the obstacle", "green: to the insertion"];
    let (x, y) = (f64::from(2 * PANEL[0] + PANEL[0] / 2), f64::from(PANEL[1] + TITLE + 120));
    for (line, note) in (0..).zip(notes) {
        Label::new(note, 16.0).color(PALE).draw(&mut page, x, y + 26.0 * f64::from(line))?;
    }
    Ok(Drawn { image: page.finish(), findings: findings(&bulging, &joints, &bones) })
}

fn findings(bulging: &[Bent; 3], joints: &[(Bent, ColorMesh); 3], bones: &[(Bent, ColorMesh); 3]) -> Vec<Finding> {
    let mut found = Vec::new();
    for (share, bent) in LENGTHS.iter().zip(bulging) {
        let name = format!("largest radius at {:.0} % of the length", 100.0 * share);
        found.push(Finding::new(name, f64::from(belly(bent)) * 1000.0, "mm"));
    }
    for (what, angles, all) in [("joint at", ANGLES, joints), ("bone at", TURNS, bones)] {
        for (angle, (bent, _)) in angles.iter().zip(all) {
            let ends = [&bent.points[0], &bent.points[SEGMENTS as usize]].map(|p| p.position.xyz());
            let length = bent.course.as_ref().map_or(0.0, |course| course.path().length());
            let name = |of: &str| format!("round a {what} {angle:.0}°: {of}");
            found.push(Finding::new(name("length"), f64::from(length) * 1000.0, "mm"));
            found.push(Finding::new(name("straight"), f64::from(ends[0].distance(ends[1])) * 1000.0, "mm"));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_more_it_bends_the_longer_a_path_is_than_its_chord() {
        for bent in [ANGLES.map(round_joint), TURNS.map(round_bone)] {
            let excess = bent.each_ref().map(|(bent, _)| {
                let ends = [&bent.points[0], &bent.points[SEGMENTS as usize]].map(|p| p.position.xyz());
                bent.frame.length / ends[0].distance(ends[1])
            });
            assert!(excess[0] < excess[1] && excess[1] < excess[2] && excess[2] > 1.015, "{excess:?}");
            for (bent, _) in &bent {
                let inside = bent.points.iter().map(|p| p.position.xyz());
                assert!(inside.clone().all(|p| p.truncate().length() > RADIUS), "{:?}", inside.collect::<Vec<_>>());
            }
        }
        let radii = LENGTHS.map(|share| belly(&muscle(None, [Vec3::ZERO, Vec3::Y * (0.30 * share)], Vec3::X)));
        assert!((radii[2] / radii[0] - 0.7f32.powf(-0.5)).abs() < 1e-4, "{radii:?}");
    }
}
