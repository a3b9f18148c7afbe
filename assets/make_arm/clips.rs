//! The two motions of the built-in arm.

use crate::skeleton::{BIND_FLEXION, Skeleton, elbow_rotation};
use glam::DQuat;
use std::f64::consts::TAU;

/// Rotations of one bone, keyed evenly.
pub struct Track {
    /// Index into [`Skeleton::bones`].
    pub bone: usize,
    /// One unit quaternion per key of the clip.
    pub rotations: Vec<DQuat>,
}

/// A named motion.
pub struct Clip {
    /// Name in the file.
    pub name: &'static str,
    /// Key times, seconds.
    pub times: Vec<f64>,
    /// What moves.
    pub tracks: Vec<Track>,
}

/// Largest flexion of the curl, degrees.
const CURL: f64 = 130.0;
/// When the shaking stops, seconds.
const STOP: f64 = 1.0;
/// Swings per second of the shaking.
const RATE: f64 = 2.5;

fn key_times(rate: u32, seconds: u32) -> Vec<f64> {
    (0..=rate * seconds).map(|k| f64::from(k) / f64::from(rate)).collect()
}

/// Elbow from straight to 130 degrees and back in two seconds, at rest at both ends.
pub fn curl() -> Clip {
    let times = key_times(30, 2);
    let rotations = times.iter().map(|t| elbow_rotation(0.5 * CURL * (1.0 - (TAU * t / 2.0).cos()))).collect();
    Clip { name: "curl", times, tracks: vec![Track { bone: 1, rotations }] }
}

/// Shoulder and elbow swing for a second, stop dead at full speed, and hold still for another.
pub fn shake(skeleton: &Skeleton) -> Clip {
    let times = key_times(60, 2);
    let swing = |t: f64| {
        let t = t.min(STOP);
        let grown = (t / 0.3).min(1.0);
        let grown = grown * grown * (3.0 - 2.0 * grown);
        (grown, grown * (TAU * RATE * t).sin())
    };
    let shoulder = |t: f64| skeleton.upperarm.rotation * DQuat::from_rotation_x((14.0 * swing(t).1).to_radians());
    let elbow = |t: f64| elbow_rotation(BIND_FLEXION + 32.0 * swing(t).0 + 30.0 * swing(t).1);
    let tracks = vec![
        Track { bone: 0, rotations: times.iter().map(|&t| shoulder(t)).collect() },
        Track { bone: 1, rotations: times.iter().map(|&t| elbow(t)).collect() },
    ];
    Clip { name: "shake", times, tracks }
}
