//! The finished skin: positions, normals, texture coordinates, weights.

use crate::{
    field::Skin,
    place,
    skeleton::{FOREARM, Skeleton, UPPERARM},
    topology::{self, Fineness, Place},
};
use glam::DVec3;
use std::f64::consts::PI;

/// Length over which the elbow's weights blend, metres.
const ELBOW_BLEND: f64 = 0.075;
/// Length over which the wrist's weights blend, metres.
const WRIST_BLEND: f64 = 0.050;
/// Row of the texture where the digits' own part starts; above it lies the arm.
pub const DIGIT_ROW: f64 = 0.8;
/// Metres from the shoulder at the texture's first row and at [`DIGIT_ROW`].
const ROWS: (f64, f64) = (-0.06, 0.66);
/// Where the two outer joints of every digit lie on its part of the texture, 0..=1.
pub const JOINT_ROWS: [f64; 2] = [0.45, 0.73];
/// Weights are multiples of this, so that their sum is 1 to the bit.
const WEIGHT_STEP: f64 = 1.0 / 4096.0;

/// A skinned mesh in the bind pose.
pub struct Mesh {
    /// Metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit length.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates: `u` from the back (0) to the palm's side (1), `v` along the arm.
    pub uvs: Vec<[f32; 2]>,
    /// Shares of upper arm, lower arm and hand; the fourth is 0.
    pub weights: Vec<[f32; 4]>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// The arm in one of its two finenesses.
pub fn build(skeleton: &Skeleton, m: usize, rings: usize) -> Mesh {
    let skin = Skin::new(skeleton);
    let thumb_ring = place::thumb_ring(m, rings);
    let fineness = Fineness { m, rings, thumb_ring, digit_rings: [8, 10, 11, 11, 10].map(|r| r * m) };
    let topology = topology::build(&fineness);
    let points = place::place(&skin, skeleton, &fineness, &topology);
    let normals = normals(&points, &topology.triangles);
    Mesh {
        positions: points.iter().map(|p| p.as_vec3().to_array()).collect(),
        normals: normals.iter().map(|n| n.as_vec3().normalize().to_array()).collect(),
        uvs: points.iter().zip(&topology.places).map(|(&p, place)| uv(&skin, skeleton, place, p)).collect(),
        weights: points.iter().zip(&topology.places).map(|(&p, place)| weights(skeleton, place, p)).collect(),
        triangles: topology.triangles,
    }
}

/// Normals of the faces around each vertex, weighted by area.
fn normals(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| points[i as usize]);
        let normal = (b - a).cross(c - a);
        triangle.iter().for_each(|&i| sums[i as usize] += normal);
    }
    sums.iter().map(|n| n.normalize()).collect()
}

/// 0 below 0 and 1 above 1, with two smooth derivatives in between.
fn ease(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

fn weights(skeleton: &Skeleton, place: &Place, point: DVec3) -> [f32; 4] {
    // Across the elbow, distance from the plane that halves the bend.
    let bend = skeleton.upperarm.rotation.slerp(skeleton.lowerarm.rotation, 0.5);
    let over_elbow = (bend.inverse() * (point - skeleton.lowerarm.origin)).y;
    let over_wrist = skeleton.hand.local(point).y;
    let rounded = |share: f64| (share / WEIGHT_STEP).round() * WEIGHT_STEP;
    let below = rounded(ease(over_elbow / ELBOW_BLEND + 0.5));
    let hand = match place {
        Place::Shoulder | Place::Ring { .. } => rounded(ease(over_wrist / WRIST_BLEND + 0.5)).min(below),
        _ => 1.0,
    };
    [1.0 - below, below - hand, hand, 0.0].map(|w| w as f32)
}

/// Texture coordinates. The surface is mapped mirrored, from the back over either side to the palm, so that it has no
/// seam; all digits share one strip of the texture.
fn uv(skin: &Skin, skeleton: &Skeleton, place: &Place, point: DVec3) -> [f32; 2] {
    let (u, v) = match *place {
        Place::Digit { digit, .. } | Place::Tip { digit } => {
            let (over, local) = skin.hand.digits[digit].over(point);
            (local.x.abs().atan2(-local.z) / PI, DIGIT_ROW + (1.0 - DIGIT_ROW) * over)
        }
        Place::Web { .. } => (0.5, DIGIT_ROW),
        Place::Shoulder | Place::Ring { .. } => {
            let upper = skeleton.upperarm.local(point);
            let (lower, hand) = (skeleton.lowerarm.local(point), skeleton.hand.local(point));
            // From back to front on the upper arm, from the back of the hand to the palm on the hand.
            let turned = ease(lower.y / FOREARM);
            let angle = |v: DVec3| v.x.abs().atan2(-v.z);
            let turned_angle = angle(upper) + (angle(hand) - angle(upper)) * turned;
            let past = ease(lower.y / ELBOW_BLEND + 0.5);
            let at = upper.y + (UPPERARM + lower.y - upper.y) * past;
            (turned_angle / PI, DIGIT_ROW * ((at - ROWS.0) / (ROWS.1 - ROWS.0)).clamp(0.0, 1.0))
        }
    };
    [u as f32, v as f32]
}

/// Where a row of the texture above [`DIGIT_ROW`] lies, metres from the shoulder.
pub fn metres_of_row(v: f64) -> f64 {
    ROWS.0 + (ROWS.1 - ROWS.0) * v / DIGIT_ROW
}
