//! Where the vertices lie: rings cast from centre lines to the skin, then evened out within it.

use crate::{
    field::{Digits, Skin},
    skeleton::{Chain, FOREARM, Frame, HAND_TWIST, Skeleton, UPPERARM},
    topology::{Fineness, Place, Topology},
};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Where the dome of the shoulder is cast from, along the upper arm, metres.
const DOME_AT: f64 = 0.012;
/// Share of the rings that make the dome.
const DOME_SHARE: f64 = 0.10;
/// Where the last ring of the palm lies, metres beyond the wrist.
const PALM: f64 = 0.094;
/// Slope of the knuckles: the little finger's lies lower, radians.
const KNUCKLE_SLOPE: f64 = 0.20;
/// Share of a digit's rings that close its tip.
const TIP_SHARE: f64 = 0.3;
/// Passes that even out the coarsest hand; finer ones need as many times more as they have vertices.
const PASSES: usize = 24;

/// The centre line of the whole arm.
pub struct Limb {
    chain: Chain,
    hand: Frame,
}

impl Limb {
    /// The centre line through upper arm, forearm and palm.
    pub fn new(skeleton: &Skeleton) -> Limb {
        let chain = Chain::new(vec![skeleton.upperarm, skeleton.lowerarm], vec![UPPERARM, FOREARM], 0.045);
        Limb { chain, hand: skeleton.hand }
    }

    /// Centre and plane of the rings at `at` metres from the shoulder; across the palm the plane tilts.
    fn frame_at(&self, at: f64) -> Frame {
        let mut frame = self.chain.frame_at(at);
        let t = ((at - UPPERARM - FOREARM) / PALM).clamp(0.0, 1.0);
        let palmar = self.hand.rotation * DVec3::Z;
        frame.rotation = DQuat::from_axis_angle(palmar, -KNUCKLE_SLOPE * t) * frame.rotation;
        frame
    }
}

/// Wished distance of neighbouring rings, in units of the usual one: closer at the elbow and the wrist.
fn spacing(at: f64) -> f64 {
    let near = |centre: f64, reach: f64| (-((at - centre) / reach).powi(2)).exp();
    1.0 - 0.48 * near(UPPERARM, 0.05) - 0.12 * near(UPPERARM + FOREARM, 0.03)
}

/// Positions along the limb of `count` rings from the dome's rim to the palm's end.
fn stations(count: usize) -> Vec<f64> {
    let end = UPPERARM + FOREARM + PALM;
    let steps = 4000;
    let at = |i: usize| DOME_AT + (end - DOME_AT) * i as f64 / steps as f64;
    let mut sums = vec![0.0];
    for i in 0..steps {
        sums.push(sums[i] + 1.0 / spacing(0.5 * (at(i) + at(i + 1))));
    }
    (0..count)
        .map(|ring| {
            let wish = sums[steps] * ring as f64 / (count - 1) as f64;
            let i = sums.partition_point(|&s| s < wish).clamp(1, steps);
            let t = (wish - sums[i - 1]) / (sums[i] - sums[i - 1]);
            at(i - 1) + (at(i) - at(i - 1)) * t
        })
        .collect()
}

/// The ring's station nearest to where the thumb leaves the palm.
pub fn thumb_ring(m: usize, rings: usize) -> usize {
    let dome = dome_rings(rings);
    let stations = stations(rings - dome);
    let wish = UPPERARM + FOREARM + 0.024;
    (0..rings - dome - 2 * m)
        .min_by(|&a, &b| (stations[a] - wish).abs().total_cmp(&(stations[b] - wish).abs()))
        .map_or(0, |i| i + dome)
}

fn dome_rings(rings: usize) -> usize {
    (rings as f64 * DOME_SHARE).round() as usize
}

/// Places every vertex on the skin.
pub fn place(skin: &Skin, skeleton: &Skeleton, fineness: &Fineness, topology: &Topology) -> Vec<DVec3> {
    let limb = Limb::new(skeleton);
    let rings = limb_rings(skin, &limb, fineness);
    let mut points = vec![DVec3::ZERO; topology.places.len()];
    for (point, place) in points.iter_mut().zip(&topology.places) {
        match *place {
            Place::Shoulder => {
                let frame = limb.frame_at(DOME_AT);
                *point = skin.cast(frame.origin, frame.rotation * -DVec3::Y, Digits::None);
            }
            Place::Ring { ring, column } => *point = rings[ring][column],
            _ => {}
        }
    }
    webs(skin, fineness, topology, &rings[fineness.rings - 1], &limb, &mut points);
    digits(skin, fineness, topology, &mut points);
    even_out(skin, skeleton, topology, PASSES * fineness.m * fineness.m, &mut points);
    points
}

fn limb_rings(skin: &Skin, limb: &Limb, fineness: &Fineness) -> Vec<Vec<DVec3>> {
    let dome = dome_rings(fineness.rings);
    let stations = stations(fineness.rings - dome);
    (0..fineness.rings)
        .into_par_iter()
        .map(|ring| {
            let (at, tilt) = match ring.checked_sub(dome) {
                Some(i) => (stations[i], 0.0),
                None => (DOME_AT, FRAC_PI_2 * (dome - ring) as f64 / (dome + 1) as f64),
            };
            even_ring(skin, &limb.frame_at(at), tilt, fineness.columns())
        })
        .collect()
}

/// One ring of arm or palm, its columns evenly spaced in each half from the thumb's side to the other.
fn even_ring(skin: &Skin, frame: &Frame, tilt: f64, columns: usize) -> Vec<DVec3> {
    let cast = |psi: f64| {
        let angle = psi + HAND_TWIST;
        let across = DVec3::new(-angle.cos(), 0.0, angle.sin());
        let direction = across * tilt.cos() - DVec3::Y * tilt.sin();
        skin.cast(frame.origin, frame.rotation * direction, Digits::None)
    };
    let samples = 6 * columns;
    let angle = |i: usize| TAU * i as f64 / samples as f64;
    let outline: Vec<DVec3> = (0..=samples).map(|i| cast(angle(i))).collect();
    let mut along = vec![0.0];
    for i in 0..samples {
        along.push(along[i] + outline[i].distance(outline[i + 1]));
    }
    let half = samples / 2;
    (0..columns)
        .map(|column| {
            let (from, to, share) = match column.checked_sub(columns / 2) {
                None => (0, half, 2.0 * column as f64 / columns as f64),
                Some(over) => (half, samples, 2.0 * over as f64 / columns as f64),
            };
            let wish = along[from] + (along[to] - along[from]) * share;
            let i = along.partition_point(|&a| a < wish).clamp(1, samples);
            let t = (wish - along[i - 1]) / (along[i] - along[i - 1]);
            cast(angle(i - 1) + (angle(i) - angle(i - 1)) * t)
        })
        .collect()
}

/// Fans of rays from between two fingers' roots.
fn webs(skin: &Skin, fineness: &Fineness, topology: &Topology, last: &[DVec3], limb: &Limb, points: &mut [DVec3]) {
    let m = fineness.m;
    let frame = limb.frame_at(UPPERARM + FOREARM + PALM);
    let (distal, palmar) = (frame.rotation * DVec3::Y, limb.hand.rotation * DVec3::Z);
    for (vertex, place) in topology.places.iter().enumerate() {
        if let Place::Web { finger, step } = *place {
            let column = m + 3 * m * finger;
            let middle = 0.5 * (last[column] + last[fineness.columns() - column]) - distal * 0.004;
            let angle = FRAC_PI_2 - PI * step as f64 / (2 * m) as f64;
            let direction = distal * angle.cos() + palmar * angle.sin();
            points[vertex] = skin.cast(middle, direction, seen(place));
        }
    }
}

fn digits(skin: &Skin, fineness: &Fineness, topology: &Topology, points: &mut [DVec3]) {
    let phases: [f64; 5] = std::array::from_fn(|digit| phase(skin, digit, &topology.roots[digit], points));
    for (vertex, place) in topology.places.iter().enumerate() {
        let (digit, ring, index) = match *place {
            Place::Digit { digit, ring, index } => (digit, ring, Some(index)),
            Place::Tip { digit } => (digit, fineness.digit_rings[digit], None),
            _ => continue,
        };
        let chain = &skin.hand.digits[digit].chain;
        let first = skin.hand.digits[digit].first_ring;
        let rings = fineness.digit_rings[digit];
        let closing = (rings as f64 * TIP_SHARE).round() as usize;
        let straight = rings - closing;
        let last = chain.length() - 0.002;
        let (at, tilt) = match ring.checked_sub(straight) {
            None => (first + (last - first) * ring as f64 / (straight - 1) as f64, 0.0),
            Some(over) => (last, FRAC_PI_2 * (over + 1) as f64 / (closing + 1) as f64),
        };
        let frame = chain.frame_at(at);
        let psi = index.map_or(0.0, |i| phases[digit] + TAU * i as f64 / topology.roots[digit].len() as f64);
        let across = DVec3::new(-psi.cos(), 0.0, psi.sin());
        let direction = across * tilt.cos() + DVec3::Y * tilt.sin();
        points[vertex] = skin.cast(frame.origin, frame.rotation * direction, seen(place));
    }
}

/// The angle of a root's first vertex round its digit, so that the loop runs into the first ring untwisted.
fn phase(skin: &Skin, digit: usize, root: &[u32], points: &[DVec3]) -> f64 {
    let frame = skin.hand.digits[digit].chain.frame_at(skin.hand.digits[digit].first_ring);
    let (mut sin, mut cos) = (0.0, 0.0);
    for (i, &vertex) in root.iter().enumerate() {
        let local = frame.local(points[vertex as usize]);
        let psi = local.z.atan2(-local.x) - TAU * i as f64 / root.len() as f64;
        sin += psi.sin();
        cos += psi.cos();
    }
    sin.atan2(cos)
}

/// The digits that a vertex's skin may be drawn to.
fn seen(place: &Place) -> Digits {
    match *place {
        Place::Shoulder => Digits::None,
        Place::Ring { .. } => Digits::ALL,
        Place::Web { finger, .. } => Digits::Some(0b11 << finger),
        Place::Digit { digit, .. } | Place::Tip { digit } => Digits::Some(1 << digit),
    }
}

/// Moves the hand's vertices towards the middle of their neighbours, within the skin.
fn even_out(skin: &Skin, skeleton: &Skeleton, topology: &Topology, passes: usize, points: &mut [DVec3]) {
    let neighbours = neighbours(topology);
    let share = |place: &Place, point: DVec3| match place {
        Place::Shoulder => 0.0,
        Place::Ring { .. } => 0.5 * ((skeleton.hand.local(point).y + 0.01) / 0.03).clamp(0.0, 1.0),
        Place::Web { .. } => 0.5,
        Place::Digit { .. } => 0.3,
        Place::Tip { .. } => 0.0,
    };
    for _ in 0..passes {
        let before = points.to_vec();
        points.par_iter_mut().enumerate().for_each(|(vertex, point)| {
            let place = &topology.places[vertex];
            let share = share(place, before[vertex]);
            if share == 0.0 {
                return;
            }
            let near = &neighbours[vertex];
            let middle = near.iter().map(|&n| before[n as usize]).sum::<DVec3>() / near.len() as f64;
            let gradient = skin.gradient(before[vertex], seen(place));
            let move_by = (middle - before[vertex]).reject_from(gradient) * share;
            *point = skin.approach(before[vertex] + move_by, gradient, seen(place));
        });
    }
}

/// The vertices joined to each, ascending; diagonals of cells left out, so that rings stay rings.
fn neighbours(topology: &Topology) -> Vec<Vec<u32>> {
    let mut near = vec![Vec::new(); topology.places.len()];
    for triangle in &topology.triangles {
        for i in 0..3 {
            let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
            near[a as usize].push(b);
            near[b as usize].push(a);
        }
    }
    for diagonal in &topology.diagonals {
        let [a, b] = *diagonal;
        near[a as usize].retain(|&n| n != b);
        near[b as usize].retain(|&n| n != a);
    }
    for list in &mut near {
        list.sort_unstable();
        list.dedup();
    }
    near
}
