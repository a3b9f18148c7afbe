//! Figure 3: the anatomy of one muscle, cut open along its axis, and its section at a query point.

use super::plot::{Align, INK, Label, PALE, Page, SERIES, polyline};
use super::scene::{self, Shown, Studio};
use super::{Drawn, Finding};
use crate::error::FigureError;
use crate::field::muscle::mesh::{Detail, Surface, surface};
use crate::field::muscle::{self, AxisPoint, MuscleFrame, MuscleInput, MuscleRest, Profile, Projection, project};
use crate::gpu::Headless;
use crate::render::{Camera, ColorMesh, Direction};
use glam::{Vec3, Vec4Swizzles};

/// Few enough segments that each shows.
const SEGMENTS: u32 = 9;
/// Pixels of the picture in space and of the whole page.
const SPACE: [u32; 2] = [980, 640];
const WHOLE: [u32; 2] = [1420, 640];
const FLESH: [f32; 3] = [0.80, 0.36, 0.30];
const DETAIL: Detail = Detail { rings: 96, around: 96 };
/// Colours of what is measured.
const ARC: [u8; 3] = SERIES[1];
const DISTANCE: [u8; 3] = SERIES[3];
const RADIUS: [u8; 3] = SERIES[2];
const NORMAL: [u8; 3] = SERIES[5];

/// The muscle: an axis bent in the plane z = 0, its section's long axis in that plane.
fn example() -> (MuscleFrame, Vec<AxisPoint>) {
    let place = |i: u32| {
        let share = i as f32 / SEGMENTS as f32;
        let turn = 1.5 * (share - 0.5);
        Vec3::new(0.17 * turn.sin(), 0.17 * turn.cos() - 0.15, 0.0)
    };
    let mut points: Vec<AxisPoint> =
        (0..=SEGMENTS).map(|i| AxisPoint { position: place(i).extend(0.0), ..AxisPoint::default() }).collect();
    let rest = MuscleRest {
        origin: Vec3::ZERO.extend(2.6e-4),
        insertion: Vec3::ZERO.extend(0.03),
        segments: SEGMENTS,
        ..MuscleRest::default()
    };
    let muscle = muscle::shape(&rest, &MuscleInput::new(&Profile::of(3, 4), 0.75), &mut points, Vec3::Y, Vec3::Y);
    (muscle, points)
}

/// The half of a surface behind the plane of the axis, and the two lines along which it is cut.
fn half(surface: &Surface) -> (Surface, [Vec<Vec3>; 2]) {
    let around = DETAIL.around as usize;
    // Two triangles a corner of a ring, ring by ring and then pole by pole; from half a turn on they are behind.
    let behind = |t: &usize| t / 2 % around >= around / 2;
    let triangles = (0..surface.triangles.len()).filter(behind).map(|t| surface.triangles[t]).collect();
    let rings = (surface.positions.len() - 2) / around;
    let poles = [surface.positions[rings * around], surface.positions[rings * around + 1]];
    let cut = [0, around / 2].map(|k| {
        let edge = (0..rings).map(|ring| surface.positions[ring * around + k]);
        std::iter::once(poles[0]).chain(edge).chain([poles[1]]).collect()
    });
    (Surface { triangles, ..surface.clone() }, cut)
}

/// The outline of the section at a projected point.
fn ring(muscle: &MuscleFrame, on: &Projection, q: Vec3) -> Vec<Vec3> {
    let binormal = on.tangent.cross(on.normal);
    let s = on.arc * muscle.inverse_length;
    (0..=96)
        .map(|i| {
            let theta = i as f32 / 96.0 * std::f32::consts::TAU;
            let across = on.normal * theta.cos() + binormal * theta.sin();
            q - on.offset + across * muscle.radius(s, theta.cos())
        })
        .collect()
}

/// The figure.
pub(super) fn figure(headless: &Headless) -> Result<Drawn, FigureError> {
    let (muscle, points) = example();
    // A point over the fifth segment, outside, between the normal and the reader.
    let under = points[4].position.xyz() * 0.4 + points[5].position.xyz() * 0.6;
    let normal = points[4].normal.xyz();
    let q = under + (normal * 0.64 + Vec3::Z * 0.77).normalize() * 0.066;
    let on = project(&points, q);
    let outward = on.offset.normalize_or(Vec3::Y);
    let s = on.arc * muscle.inverse_length;
    let radius = muscle.radius(s, outward.dot(on.normal));

    let solids = solids(&muscle, &points, &on, q, radius);
    let studio = Studio::new(headless, SPACE[0], SPACE[1])?;
    let held: Vec<Vec3> = solids.iter().flat_map(|mesh| mesh.positions.iter().copied()).collect();
    let camera = Camera::around(&held, Direction { azimuth: -33.0, elevation: 17.0 }, studio.aspect());
    let mut page = Page::new(WHOLE[0], WHOLE[1])?;
    let image = studio.solids(&camera, &solids)?;
    let shown = scene::place(&mut page, &image, &camera, 0, 0);
    write(&mut page, &shown, &points, &on, q, radius)?;
    section(&mut page, &muscle, &on, radius)?;
    let findings = vec![
        Finding::new("s(q)", f64::from(s), ""),
        Finding::new("d(q)", f64::from(on.offset.length()) * 1000.0, "mm"),
        Finding::new("R(q)", f64::from(radius) * 1000.0, "mm"),
        Finding::new("theta(q)", f64::from(outward.dot(on.normal).clamp(-1.0, 1.0).acos().to_degrees()), "degrees"),
        Finding::new("f_M(q) = d - R", f64::from(on.offset.length() - radius) * 1000.0, "mm"),
    ];
    Ok(Drawn { image: page.finish(), findings })
}

fn solids(muscle: &MuscleFrame, points: &[AxisPoint], on: &Projection, q: Vec3, radius: f32) -> Vec<ColorMesh> {
    let (cut, edges) = half(&surface(muscle, points, DETAIL));
    let mut solids = vec![scene::colored(cut, FLESH)];
    solids.extend(edges.iter().map(|edge| scene::tube(edge, 0.0006, [0.25, 0.05, 0.04])));
    let dark = scene::linear(INK);
    let places: Vec<Vec3> = points.iter().map(|p| p.position.xyz()).collect();
    let foot = q - on.offset;
    let before = places.iter().zip(points).take_while(|(_, p)| p.arc() < on.arc).map(|(p, _)| *p);
    let walked: Vec<Vec3> = before.chain([foot]).collect();
    solids.push(scene::tube(&walked, 0.0014, scene::linear(ARC)));
    let rest = places.iter().zip(points).filter(|(_, p)| p.arc() > on.arc).map(|(p, _)| *p);
    let rest: Vec<Vec3> = std::iter::once(foot).chain(rest).collect();
    solids.push(scene::tube(&rest, 0.0011, dark));
    solids.extend(places.iter().map(|p| scene::ball(*p, 0.0024, dark)));
    for end in [places[0], places[places.len() - 1]] {
        solids.push(scene::ball(end, 0.0042, dark));
    }
    for point in points {
        let from = point.position.xyz();
        solids.push(scene::arrow(from, from + point.normal.xyz() * 0.028, 0.0007, scene::linear(NORMAL)));
    }
    solids.push(scene::tube(&ring(muscle, on, q), 0.0007, scene::linear(PALE)));
    let outward = on.offset.normalize_or(Vec3::Y);
    solids.push(scene::tube(&[foot, foot + outward * radius], 0.0016, scene::linear(RADIUS)));
    solids.push(scene::tube(&[foot, q], 0.0009, scene::linear(DISTANCE)));
    solids.push(scene::ball(q, 0.0032, scene::linear(DISTANCE)));
    solids
}

/// The names of what is drawn in space.
fn write(
    page: &mut Page,
    shown: &Shown<'_>,
    points: &[AxisPoint],
    on: &Projection,
    q: Vec3,
    radius: f32,
) -> Result<(), FigureError> {
    let foot = q - on.offset;
    let outward = on.offset.normalize_or(Vec3::Y);
    let place = |i: usize| points[i].position.xyz();
    let tip = |i: usize| place(i) + points[i].normal.xyz() * 0.028;
    let last = points.len() - 1;
    let mut label = |text: &str, at: Vec3, by: [f64; 2], color: [u8; 3], align: Align| {
        let [x, y] = shown.at(at);
        let text = Label { rimmed: true, ..Label::new(text, 21.0) }.color(color).align(align);
        text.draw(page, x + by[0], y + by[1])
    };
    label("*m*_0", place(0), [-14.0, 20.0], INK, Align::Right)?;
    label("origin", place(0), [-14.0, 44.0], PALE, Align::Middle)?;
    label("*m*_1", place(last), [14.0, 20.0], INK, Align::Left)?;
    label("insertion", place(last), [-4.0, 46.0], PALE, Align::Middle)?;
    label("*n*_{m0}", tip(0), [0.0, -18.0], NORMAL, Align::Middle)?;
    label("*n*_{m1}", tip(last), [6.0, -14.0], NORMAL, Align::Left)?;
    label("*p*_i", place(3), [8.0, 24.0], INK, Align::Middle)?;
    label("*n*_i", tip(3), [-6.0, -16.0], NORMAL, Align::Middle)?;
    label("*C*", (place(7) + place(8)) * 0.5, [-10.0, 24.0], INK, Align::Middle)?;
    label("*s*(*q*)", (place(1) + place(2)) * 0.5, [14.0, 24.0], ARC, Align::Left)?;
    label("*q*", q, [24.0, -10.0], DISTANCE, Align::Left)?;
    label("proj(*q*)", foot, [12.0, 26.0], INK, Align::Middle)?;
    label("*d*(*q*)", (foot + outward * radius).lerp(q, 0.45), [14.0, 4.0], DISTANCE, Align::Left)?;
    label("*R*(*q*)", foot + outward * (0.55 * radius), [16.0, 6.0], RADIUS, Align::Left)
}

/// The section through the query point, looked at along the axis.
fn section(page: &mut Page, muscle: &MuscleFrame, on: &Projection, radius: f32) -> Result<(), FigureError> {
    let center = [1165.0, 340.0];
    let scale = 3600.0;
    let s = on.arc * muscle.inverse_length;
    // The normal upward, as in the picture beside it.
    let at = |theta: f32, away: f32| {
        let (sine, cosine) = theta.sin_cos();
        [center[0] + f64::from(sine * away) * scale, center[1] - f64::from(cosine * away) * scale]
    };
    let theta = on.offset.normalize_or(Vec3::Y).dot(on.normal).clamp(-1.0, 1.0).acos();
    let distance = on.offset.length();
    // Beside the line from the foot to the point, where its length is drawn.
    const ASIDE: f64 = 54.0;
    let beside = |away: f32, by: f64| {
        let [x, y] = at(theta, away);
        [x + by * f64::from(theta.cos()), y + by * f64::from(theta.sin())]
    };
    let sweep = |from: f32, to: f32, away: &dyn Fn(f32) -> f32| -> Vec<[f64; 2]> {
        (0..=96).map(|i| from + (to - from) * i as f32 / 96.0).map(|t| at(t, away(t))).collect()
    };
    let outline = sweep(0.0, std::f32::consts::TAU, &|t| muscle.radius(s, t.cos()));
    polyline(page, &outline, [150, 60, 52], 3.0)?;
    let long = muscle.radius(s, 1.0);
    super::plot::arrow(page, center, at(0.0, long * 1.35), NORMAL, 2.4)?;
    polyline(page, &[center, at(theta, radius)], RADIUS, 4.0)?;
    polyline(page, &[at(theta, radius), at(theta, distance)], DISTANCE, 2.6)?;
    polyline(page, &sweep(0.0, theta, &|_| 0.5 * long), INK, 1.6)?;
    for away in [0.0, distance] {
        polyline(page, &[beside(away, 10.0), beside(away, ASIDE + 6.0)], DISTANCE, 1.0)?;
    }
    super::plot::arrow(page, beside(0.5 * distance, ASIDE), beside(0.0, ASIDE), DISTANCE, 1.6)?;
    super::plot::arrow(page, beside(0.5 * distance, ASIDE), beside(distance, ASIDE), DISTANCE, 1.6)?;
    page.dot(center, 5.0, INK)?;
    page.dot(at(theta, distance), 6.0, DISTANCE)?;
    let mut label = |text: &str, [x, y]: [f64; 2], by: [f64; 2], color: [u8; 3]| {
        Label::new(text, 21.0).color(color).draw(page, x + by[0], y + by[1])
    };
    label("*n*(*s*)", at(0.0, long * 1.35), [0.0, -18.0], NORMAL)?;
    label("θ(*q*)", at(0.5 * theta, 0.5 * long), [10.0, -20.0], INK)?;
    label("*R*(*q*)", at(theta, 0.62 * radius), [12.0, 26.0], RADIUS)?;
    label("*d*(*q*)", beside(0.5 * distance, ASIDE + 14.0), [10.0, 12.0], DISTANCE)?;
    label("*q*", at(theta, distance), [16.0, -14.0], DISTANCE)?;
    label("proj(*q*)", center, [-26.0, 28.0], INK)?;
    Label::new("Section at *s*(*q*)", 19.0).draw(page, center[0] + 40.0, 60.0)?;
    Label::new("*R* = *w* Φ(*s*) *r*(θ)", 19.0).draw(page, center[0] + 40.0, 566.0)?;
    Label::new("*f*_{ M}(*q*) = *d*(*q*) − *R*(*q*)", 19.0).draw(page, center[0] + 40.0, 598.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn the_cut_lies_in_the_plane_of_the_axis() {
        let (muscle, points) = example();
        let whole = surface(&muscle, &points, DETAIL);
        let (cut, edges) = half(&whole);
        assert_eq!(cut.triangles.len() * 2, whole.triangles.len());
        assert!(edges.iter().flatten().all(|p| p.z.abs() < 1e-5));
        let corners: HashSet<u32> = cut.triangles.iter().flatten().copied().collect();
        let z = |i: &u32| cut.positions[*i as usize].z;
        assert!(corners.iter().all(|i| z(i) < 1e-5) && corners.iter().any(|i| z(i) < -0.01));
        assert!(whole.positions.iter().any(|p| p.z > 0.01), "the half in front is left away");
    }
}
