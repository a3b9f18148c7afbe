//! Figure 7: pectoral and shoulder muscles as sets of fibres, on bones of simple shapes.

use super::plot::{INK, Label, PALE, Page};
use super::scene::{self, BONE, Studio};
use super::{Drawn, Finding};
use crate::error::{FigureError, RigError};
use crate::field::muscle::{self, AxisPoint, MuscleFrame, MuscleInput, MuscleRest, Profile};
use crate::gpu::Headless;
use crate::render::{Camera, ColorMesh, Direction};
use crate::rig::groups::{FieldGroups, Group};
use crate::rig::muscle::{FibreSet, resolve};
use crate::rig::{Attachment, Character, Influence, Joint, MuscleShape, MuscleSize, MuscleSpec};
use glam::{Mat3, Mat4, Vec2, Vec3, Vec4Swizzles};

const SIZE: [u32; 2] = [1200, 760];
/// Green and blue that differ in lightness too.
const PECTORAL: [f32; 3] = [0.20, 0.52, 0.16];
const SHOULDER: [f32; 3] = [0.03, 0.16, 0.50];
/// Share of a fibre's radius that the bones push away: what lies on a bone is flatter below than above.
const SUNK: f32 = 0.5;
/// Rounds in which fibres settle.
const ROUNDS: u32 = 160;

/// A bone of a simple shape.
#[derive(Clone, Copy)]
pub(super) enum Bone {
    /// Centre and half axes along X, Y and Z.
    Ellipsoid(Vec3, Vec3),
    /// Two ends and a radius.
    Capsule(Vec3, Vec3, f32),
}

const CHEST_CENTER: Vec3 = Vec3::new(0.0, -0.01, 0.0);
const CHEST_HALF: Vec3 = Vec3::new(0.155, 0.225, 0.110);
/// A chest with its left arm, metres; Y up, Z to the front, X to the left.
pub(super) const CHEST: Bone = Bone::Ellipsoid(CHEST_CENTER, CHEST_HALF);
pub(super) const HUMERUS: Bone = Bone::Capsule(Vec3::new(0.205, 0.155, -0.01), Vec3::new(0.335, -0.115, 0.0), 0.019);
const SHOULDER_HEAD: Bone = Bone::Ellipsoid(Vec3::new(0.198, 0.158, -0.01), Vec3::splat(0.027));
const CLAVICLE: Bone = Bone::Capsule(Vec3::new(0.018, 0.195, 0.075), Vec3::new(0.185, 0.205, 0.0), 0.0085);

impl Bone {
    /// A point moved so that a ball about it with a given radius does not reach into the bone.
    fn push(&self, p: Vec3, radius: f32) -> Vec3 {
        match *self {
            Bone::Ellipsoid(center, half) => {
                let grown = half + Vec3::splat(radius);
                let unit = (p - center) / grown;
                let inside = unit.length();
                if inside < 1.0 && inside > 1e-6 { center + unit / inside * grown } else { p }
            }
            Bone::Capsule(from, to, thick) => {
                let span = to - from;
                let on = from + span * ((p - from).dot(span) / span.length_squared()).clamp(0.0, 1.0);
                let away = p - on;
                let distance = away.length();
                if distance < thick + radius && distance > 1e-6 { on + away / distance * (thick + radius) } else { p }
            }
        }
    }

    pub(super) fn mesh(&self) -> ColorMesh {
        match *self {
            Bone::Ellipsoid(center, half) => scene::ellipsoid(center, Mat3::from_diagonal(half), BONE),
            Bone::Capsule(from, to, radius) => scene::rod(from, to, [radius; 2], BONE),
        }
    }
}

/// The character that the fibres are resolved on: its bones stand in scene space, so that offsets are places.
fn character() -> (Character, FieldGroups) {
    let joint = |(node, name): (u32, &str)| Joint {
        name: name.into(),
        parent: (node > 0).then_some(0),
        node,
        inverse_bind: Mat4::IDENTITY,
    };
    let character = Character {
        name: "torso".into(),
        joints: [(0, "chest"), (1, "upperarm")].map(joint).to_vec(),
        positions_rest: vec![Vec3::Y * -0.5, Vec3::Y * 0.5],
        normals_rest: vec![Vec3::X; 2],
        uvs: vec![Vec2::ZERO; 2],
        influences: vec![Influence { joint: 0, weight: 1.0 }; 2],
        influence_offsets: vec![0, 1, 2],
        ..Character::default()
    };
    let chest = Group { name: "chest".into(), joint: 0, joints: vec![0, 1], parent: None, passive: false, part: None };
    (character, FieldGroups { groups: vec![chest], group_of_joint: vec![0, 0], owner: vec![0, 0] })
}

/// The place on the chest at a height and distance from the middle; in front where `side` is 1, behind where it is -1.
pub(super) fn on_chest(x: f32, y: f32, side: f32) -> Vec3 {
    let (across, up) = (x / CHEST_HALF.x, (y - CHEST_CENTER.y) / CHEST_HALF.y);
    let deep = (1.0 - across * across - up * up).max(0.0).sqrt();
    Vec3::new(x, y, CHEST_CENTER.z + side * (CHEST_HALF.z * deep + 0.004))
}

/// A fibre set between two lines of points.
pub(super) fn fibres(name: &str, count: u32, lines: [&[Vec3]; 2], shape: (u32, u32), width: f32) -> MuscleSpec {
    let end = |bone: &str, line: &[Vec3]| Attachment { bone: bone.into(), offset: line[0], normal: Vec3::Y };
    let size = MuscleSize::Width(width);
    MuscleSpec {
        fibres: Some(FibreSet {
            count,
            origin_line: lines[0][1..].to_vec(),
            insertion_line: lines[1][1..].to_vec(),
            overlap: true,
        }),
        rest: MuscleShape { alpha: shape.0, beta: shape.1, ..MuscleShape::REST },
        ..MuscleSpec::new(name, "chest", end("chest", lines[0]), end("upperarm", lines[1]), size)
    }
}

/// The pectoral muscle: from clavicle, breastbone and ribs to the humerus, the lowest fibre the highest there.
fn pectoral() -> MuscleSpec {
    let origin = [
        Vec3::new(0.115, 0.196, 0.044),
        Vec3::new(0.040, 0.187, 0.072),
        on_chest(0.016, 0.140, 1.0),
        on_chest(0.014, 0.040, 1.0),
        on_chest(0.050, -0.070, 1.0),
    ];
    let insertion = [Vec3::new(0.258, 0.078, 0.016), Vec3::new(0.236, 0.122, 0.016)];
    fibres("pectoral", 11, [&origin, &insertion], (3, 9), 0.0185)
}

/// The shoulder's muscle: from clavicle, acromion and the blade's spine to the middle of the humerus.
fn shoulder() -> MuscleSpec {
    let origin = [
        Vec3::new(0.130, 0.207, 0.052),
        Vec3::new(0.195, 0.215, 0.022),
        Vec3::new(0.205, 0.213, -0.020),
        Vec3::new(0.130, 0.190, -0.085),
    ];
    let insertion = [Vec3::new(0.281, 0.018, 0.017), Vec3::new(0.289, 0.018, 0.006), Vec3::new(0.283, 0.014, -0.020)];
    let set = fibres("shoulder", 7, [&origin, &insertion], (3, 3), 0.018);
    MuscleSpec { fibres: set.fibres.map(|f| FibreSet { overlap: false, ..f }), ..set }
}

/// One fibre's shape with the points of its axis.
pub(super) type Fibre = (MuscleFrame, Vec<AxisPoint>);

/// Resolves a fibre set and lets its fibres settle over the bones.
pub(super) fn settle(spec: &MuscleSpec, bones: &[Bone]) -> Result<Vec<Fibre>, FigureError> {
    let (character, groups) = character();
    let resolved = resolve(spec, &character, &groups).map_err(RigError::from)?;
    let rests: Vec<MuscleRest> = resolved.into_iter().map(|(rest, _)| rest).collect();
    let profile = Profile::of(spec.rest.alpha, spec.rest.beta);
    let input = MuscleInput::new(&profile, spec.rest.eccentricity);
    let apart = spec.fibres.as_ref().is_some_and(|f| !f.overlap);
    let mut axes: Vec<Vec<Vec3>> = rests.iter().map(straight).collect();
    let radii = |rest: &MuscleRest, axis: &[Vec3]| -> Vec<f32> {
        let length: f32 = axis.windows(2).map(|w| w[0].distance(w[1])).sum();
        let width = (rest.origin.w / (std::f32::consts::PI * length)).sqrt();
        (0..axis.len()).map(|i| width * profile.at(i as f32 / (axis.len() - 1) as f32).0).collect()
    };
    // Rounds of smoothing and pushing stand in for the particles' elasticity and contact (section 6): what settles is
    // the shortest way over the bones.
    for _ in 0..ROUNDS {
        let thick: Vec<Vec<f32>> = rests.iter().zip(&axes).map(|(rest, axis)| radii(rest, axis)).collect();
        for (axis, thick) in axes.iter_mut().zip(&thick) {
            let before = axis.clone();
            for i in 1..axis.len() - 1 {
                let smooth = before[i].lerp(0.5 * (before[i - 1] + before[i + 1]), 0.8);
                axis[i] = bones.iter().fold(smooth, |p, bone| bone.push(p, SUNK * thick[i]));
            }
            // A blunt end lies on its bone too.
            axis[0] = bones.iter().fold(axis[0], |p, bone| bone.push(p, SUNK * thick[0]));
        }
        if apart {
            part(&mut axes, &thick);
        }
    }
    let shaped = rests.iter().zip(&axes).map(|(rest, axis)| {
        let mut points: Vec<AxisPoint> =
            axis.iter().map(|p| AxisPoint { position: p.extend(0.0), ..AxisPoint::default() }).collect();
        let frame = muscle::shape(rest, &input, &mut points, rest.origin_normal.xyz(), rest.insertion_normal.xyz());
        (frame, points)
    });
    Ok(shaped.collect())
}

fn straight(rest: &MuscleRest) -> Vec<Vec3> {
    let mut points = vec![AxisPoint::default(); rest.segments as usize + 1];
    muscle::straighten(&mut points, rest.origin.xyz(), rest.insertion.xyz());
    points.iter().map(|p| p.position.xyz()).collect()
}

/// Moves neighbouring fibres apart where they overlap, both by half.
fn part(axes: &mut [Vec<Vec3>], thick: &[Vec<f32>]) {
    for f in 1..axes.len() {
        let (before, after) = axes.split_at_mut(f);
        let (one, other) = (&mut before[f - 1], &mut after[0]);
        for i in 1..one.len() - 1 {
            for j in i.saturating_sub(2).max(1)..(i + 3).min(other.len() - 1) {
                let away = other[j] - one[i];
                let (distance, least) = (away.length(), thick[f - 1][i] + thick[f][j]);
                if distance < least && distance > 1e-6 {
                    let by = away / distance * (0.25 * (least - distance));
                    one[i] -= by;
                    other[j] += by;
                }
            }
        }
    }
}

/// Largest depth to which neighbouring fibres reach into one another, metres.
fn overlap(fibres: &[Fibre]) -> f32 {
    let last = |points: &[AxisPoint]| points.len() - 1;
    let mut worst = 0.0f32;
    for pair in fibres.windows(2) {
        for (i, p) in pair[0].1.iter().enumerate() {
            for (j, q) in pair[1].1.iter().enumerate() {
                let radius =
                    |(muscle, points): &Fibre, i: usize| muscle.radius(points[i].arc() * muscle.inverse_length, 1.0);
                let inner = (last(&pair[0].1) / 6..=last(&pair[0].1) * 5 / 6).contains(&i);
                let depth = radius(&pair[0], i) + radius(&pair[1], j) - p.position.xyz().distance(q.position.xyz());
                worst = if inner { worst.max(depth) } else { worst };
            }
        }
    }
    worst
}

/// A mesh seen in a mirror that stands in the body's middle.
pub(super) fn mirrored(mesh: &ColorMesh) -> ColorMesh {
    let turn = |v: &Vec3| Vec3::new(-v.x, v.y, v.z);
    ColorMesh {
        positions: mesh.positions.iter().map(turn).collect(),
        normals: mesh.normals.iter().map(turn).collect(),
        colors: mesh.colors.clone(),
        triangles: mesh.triangles.iter().map(|t| [t[0], t[2], t[1]]).collect(),
    }
}

/// The bones of both sides.
pub(super) fn skeleton() -> ColorMesh {
    let left = scene::joined([HUMERUS, SHOULDER_HEAD, CLAVICLE].map(|bone| bone.mesh()));
    scene::joined([CHEST.mesh(), mirrored(&left), left])
}

/// The figure.
pub(super) fn figure(headless: &Headless) -> Result<Drawn, FigureError> {
    let bones = [CHEST, HUMERUS, SHOULDER_HEAD, CLAVICLE];
    let (chest, arm) = (settle(&pectoral(), &bones)?, settle(&shoulder(), &bones)?);
    let drawn =
        |fibres: &[Fibre], color| scene::joined(fibres.iter().map(|(m, points)| scene::fibre(m, points, color)));
    let left = [drawn(&chest, PECTORAL), drawn(&arm, SHOULDER)];
    let mut solids: Vec<ColorMesh> = left.iter().map(mirrored).collect();
    solids.extend(left);
    solids.push(skeleton());
    let studio = Studio::new(headless, SIZE[0], SIZE[1] - 60)?;
    let held: Vec<Vec3> = solids.iter().flat_map(|mesh| mesh.positions.iter().copied()).collect();
    let camera = Camera::around(&held, Direction { azimuth: 22.0, elevation: 10.0 }, studio.aspect());
    let mut page = Page::new(SIZE[0], SIZE[1])?;
    page.paste(&studio.solids(&camera, &solids)?, 0, 0);
    let text = format!(
        "Pectoral (green): {} fibres of α = 3, β = 9 that may overlap. Shoulder (blue): {} fibres of α = β = 3 that collide.",
        chest.len(),
        arm.len()
    );
    let middle = f64::from(SIZE[0]) * 0.5;
    Label::new(&text, 18.0).color(INK).draw(&mut page, middle, f64::from(SIZE[1]) - 46.0)?;
    Label::new("Bones: ellipsoids and capsules. Pale: the axis, where a fibre is thinner than the line.", 16.0)
        .color(PALE)
        .draw(&mut page, middle, f64::from(SIZE[1]) - 20.0)?;
    let findings = vec![
        Finding::new("deepest overlap of neighbouring pectoral fibres", f64::from(overlap(&chest)) * 1000.0, "mm"),
        Finding::new("deepest overlap of neighbouring shoulder fibres", f64::from(overlap(&arm)) * 1000.0, "mm"),
    ];
    Ok(Drawn { image: page.finish(), findings })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fibres_settle_outside_the_bones_and_apart_where_they_collide() {
        let bones = [CHEST, HUMERUS, SHOULDER_HEAD, CLAVICLE];
        let apart = settle(&shoulder(), &bones).expect("settles");
        let spec = shoulder();
        let over = MuscleSpec { fibres: spec.fibres.map(|f| FibreSet { overlap: true, ..f }), ..spec };
        let over = settle(&over, &bones).expect("settles");
        assert!(overlap(&apart) < 0.5 * overlap(&over), "{} {}", overlap(&apart), overlap(&over));
        for (_, points) in settle(&pectoral(), &bones).expect("settles") {
            let inside = |p: &AxisPoint| CHEST.push(p.position.xyz(), 0.0) != p.position.xyz();
            assert!(!points[3..27].iter().any(inside));
        }
        let rest = settle(&pectoral(), &[]).expect("settles");
        let through =
            |(_, points): &Fibre| points.iter().any(|p| CHEST.push(p.position.xyz(), 0.0) != p.position.xyz());
        assert!(rest.iter().any(through), "without bones fibres go through the chest");
    }
}
