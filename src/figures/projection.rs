//! Figure 4: where points project to on a polyline, by the nearest segment alone and by algorithm 1.

use super::plot::{Align, Axis, HeatMap, Label, PALE, Page, Rect};
use super::{Drawn, Finding};
use crate::error::FigureError;
use crate::field::muscle::{AxisPoint, axis, project};
use glam::{Vec3, Vec4Swizzles};

/// Directions of the unit segments of the polyline, degrees. Its bends change sides, as those of the paper's figure: of
/// two bends to the same side the inner angles overlap from half the radius of curvature on, and from one to the other
/// algorithm 1 jumps too.
const HEADINGS: [f32; 5] = [46.0, -8.0, 46.0, -10.0, 42.0];
/// Distance from the polyline up to which points are coloured, in segment lengths: algorithm 1 is continuous while both
/// feet of an inner angle's points stay in their segments, up to the cotangent of the bend.
const REACH: f32 = 0.7;
/// Distance of neighbours whose projections are compared, in segment lengths.
const STEP: f32 = 0.01;
/// What is shown of the plane, in segment lengths.
const SHOWN: [[f32; 2]; 2] = [[-0.8, 5.0], [-0.8, 2.7]];

/// The polyline in the plane z = 0, and its length.
fn polyline() -> (Vec<AxisPoint>, f32) {
    let mut at = Vec3::ZERO;
    let mut points = vec![AxisPoint { position: at.extend(0.0), ..AxisPoint::default() }];
    for heading in HEADINGS {
        let (sine, cosine) = heading.to_radians().sin_cos();
        at += Vec3::new(cosine, sine, 0.0);
        points.push(AxisPoint { position: at.extend(0.0), ..AxisPoint::default() });
    }
    let length = axis::frame(&mut points, Vec3::Z, Vec3::Z, 0);
    (points, length)
}

/// Arc length of the nearest point of the nearest segment, which algorithm 1 mends, and the distance to it.
fn plain(points: &[AxisPoint], q: Vec3) -> (f32, f32) {
    let mut best = (0.0, f32::INFINITY);
    for point in &points[..points.len() - 1] {
        let away = q - point.position.xyz();
        let at = away.dot(point.tangent.xyz()).clamp(0.0, point.tangent.w);
        let distance = (away - point.tangent.xyz() * at).length();
        if distance < best.1 {
            best = (point.arc() + at, distance);
        }
    }
    best
}

/// The share of the length that a point projects to, and its distance by the plain projection.
fn plain_share(points: &[AxisPoint], length: f32, q: Vec3) -> (f32, f32) {
    let (arc, distance) = plain(points, q);
    (arc / length, distance)
}

/// The same by algorithm 1. The distance is the plain one, so that both colour the same points.
fn our_share(points: &[AxisPoint], length: f32, q: Vec3) -> (f32, f32) {
    (project(points, q).arc / length, plain(points, q).1)
}

type Operator = fn(&[AxisPoint], f32, Vec3) -> (f32, f32);

/// The largest difference between neighbours on a grid within `reach` of the polyline.
fn largest_step(operator: Operator, reach: f32) -> f32 {
    let (points, length) = polyline();
    let [[left, right], [bottom, top]] = SHOWN;
    let (columns, rows) = (((right - left) / STEP) as u32, ((top - bottom) / STEP) as u32);
    let share = |i: u32, j: u32| {
        let q = Vec3::new(left + i as f32 * STEP, bottom + j as f32 * STEP, 0.0);
        let (share, distance) = operator(&points, length, q);
        (distance < reach).then_some(share)
    };
    let mut below: Vec<Option<f32>> = vec![None; columns as usize];
    let mut worst = 0.0f32;
    for j in 0..rows {
        let row: Vec<Option<f32>> = (0..columns).map(|i| share(i, j)).collect();
        let beside = row.iter().zip(&row[1..]);
        for (a, b) in beside.chain(row.iter().zip(&below)) {
            if let (Some(a), Some(b)) = (a, b) {
                worst = worst.max((a - b).abs());
            }
        }
        below = row;
    }
    worst
}

/// The figure.
pub(super) fn figure() -> Result<Drawn, FigureError> {
    let mut page = Page::new(1400, 560)?;
    let (points, length) = polyline();
    let line: Vec<[f64; 2]> = points.iter().map(|p| [f64::from(p.position.x), f64::from(p.position.y)]).collect();
    let [across, upward] = SHOWN.map(|r| f64::from(r[0])..f64::from(r[1]));
    let panels: [(&str, Operator, u32, u32); 2] =
        [("Nearest segment", plain_share, 0, 660), ("Algorithm 1: weighted by cotangents", our_share, 660, 740)];
    for (title, operator, left, width) in panels {
        let at = |place: [f64; 2]| {
            let q = Vec3::new(place[0] as f32, place[1] as f32, 0.0);
            let (share, distance) = operator(&points, length, q);
            (distance < REACH).then_some(f64::from(share))
        };
        let map = HeatMap {
            title,
            x: Axis { name: "*x*, in segment lengths", range: across.clone(), ticks: 6, digits: 0 },
            y: Axis { name: "*y*, in segment lengths", range: upward.clone(), ticks: 4, digits: 0 },
            value: Axis { name: "*s*(*q*)", range: 0.0..1.0, ticks: 6, digits: 1 },
            at: &at,
            bands: 40,
            lines: vec![(line.clone(), [255; 3], 6.0), (line.clone(), [20, 20, 24], 3.0)],
            points: line.clone(),
            bar: left > 0,
        };
        map.draw(&mut page, Rect { left, top: 4, width, height: 510 })?;
    }
    let (before, after) = (largest_step(plain_share, REACH), largest_step(our_share, REACH));
    let note = format!(
        "Coloured up to {REACH} segment lengths from the polyline, shaded in bands of *s*. \
         Largest step of *s* between points {STEP} apart: {before:.3} left, {after:.3} right."
    );
    Label::new(&note, 15.0).color(PALE).align(Align::Middle).draw(&mut page, 700.0, 534.0)?;
    let findings = vec![
        Finding::new("largest step of s between neighbours, nearest segment", f64::from(before), ""),
        Finding::new("largest step of s between neighbours, algorithm 1", f64::from(after), ""),
    ];
    Ok(Drawn { image: page.finish(), findings })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plain_projection_jumps_and_ours_does_not() {
        // On a straight line neighbours are STEP of 5 segments apart; algorithm 1 stretches that in the bends.
        let ours = largest_step(our_share, REACH);
        assert!(ours < 10.0 * STEP / HEADINGS.len() as f32, "{ours}");
        let plain = largest_step(plain_share, REACH);
        assert!(plain > 0.1, "{plain}");
    }

    #[test]
    fn off_the_bends_both_are_the_same() {
        let (points, length) = polyline();
        let first = points[0].tangent.xyz();
        let q = points[0].position.xyz() + first * 0.3 + first.cross(Vec3::Z) * 0.2;
        assert_eq!(plain_share(&points, length, q).0, our_share(&points, length, q).0);
        let second = points[1].position.xyz() + (points[1].tangent.xyz() - first).normalize() * 0.4;
        let q = second + first * 0.05;
        assert!((plain_share(&points, length, q).0 - our_share(&points, length, q).0).abs() > 0.01, "in a bend");
    }
}
