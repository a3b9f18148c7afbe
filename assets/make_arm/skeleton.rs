//! The arm's three bones in the bind pose, and the smooth curves that rings are strung along.

use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::TAU;

/// Shoulder to elbow, metres.
pub const UPPERARM: f64 = 0.30;
/// Elbow to wrist, metres.
pub const FOREARM: f64 = 0.26;
/// Flexion of the elbow in the bind pose, degrees.
pub const BIND_FLEXION: f64 = 18.0;
/// Lateral deviation of the forearm when the elbow is straight (the carrying angle), degrees.
const CARRYING_ANGLE: f64 = 6.0;
/// Abduction of the hanging upper arm, degrees.
const ABDUCTION: f64 = 9.0;
/// Half-pronation of the hand about the forearm, radians: five of 28 columns, so that edge loops run straight into
/// the palm.
pub const HAND_TWIST: f64 = TAU * 5.0 / 28.0;

/// A bone's space: Y along the bone, X towards the body's midline, Z to the front (palmar in the hand).
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Where the bone starts, scene space.
    pub origin: DVec3,
    /// Bone space to scene space.
    pub rotation: DQuat,
}

impl Frame {
    /// A point given in the bone's space.
    pub fn point(&self, local: DVec3) -> DVec3 {
        self.origin + self.rotation * local
    }

    /// A scene-space point in the bone's space.
    pub fn local(&self, point: DVec3) -> DVec3 {
        self.rotation.inverse() * (point - self.origin)
    }

    /// The frame that lies at `offset` in this one, turned by `rotation`.
    pub fn child(&self, offset: DVec3, rotation: DQuat) -> Frame {
        Frame { origin: self.point(offset), rotation: self.rotation * rotation }
    }
}

/// The lower arm's rotation in the upper arm for a flexion in degrees.
pub fn elbow_rotation(flexion: f64) -> DQuat {
    DQuat::from_rotation_x(flexion.to_radians()) * DQuat::from_rotation_z(CARRYING_ANGLE.to_radians())
}

/// The three bones at rest.
#[derive(Clone, Copy, Debug)]
pub struct Skeleton {
    /// Starts at the shoulder, the scene's origin.
    pub upperarm: Frame,
    /// Starts at the elbow.
    pub lowerarm: Frame,
    /// Starts at the wrist.
    pub hand: Frame,
}

impl Skeleton {
    /// A hanging left arm, elbow bent as in [`BIND_FLEXION`], hand half pronated, character facing +Z.
    pub fn bind() -> Skeleton {
        let out = ABDUCTION.to_radians();
        let along = DVec3::new(out.sin(), -out.cos(), 0.0);
        let basis = DMat3::from_cols(along.cross(DVec3::Z), along, DVec3::Z);
        let upperarm = Frame { origin: DVec3::ZERO, rotation: DQuat::from_mat3(&basis).normalize() };
        let lowerarm = upperarm.child(DVec3::Y * UPPERARM, elbow_rotation(BIND_FLEXION));
        let hand = lowerarm.child(DVec3::Y * FOREARM, DQuat::from_rotation_y(HAND_TWIST));
        Skeleton { upperarm, lowerarm, hand }
    }

    /// The bones in the order of the file's joints.
    pub fn bones(&self) -> [(&'static str, Frame); 3] {
        [("upperarm", self.upperarm), ("lowerarm", self.lowerarm), ("hand", self.hand)]
    }
}

/// Straight pieces joined by smooth bends.
#[derive(Clone, Debug)]
pub struct Chain {
    /// Start of every piece.
    frames: Vec<Frame>,
    /// Length of every piece.
    lengths: Vec<f64>,
    /// Half the length over which a joint bends.
    round: f64,
}

impl Chain {
    /// A chain of frames, each piece running along its frame's Y for its length.
    pub fn new(frames: Vec<Frame>, lengths: Vec<f64>, round: f64) -> Chain {
        Chain { frames, lengths, round }
    }

    /// Length of all pieces.
    pub fn length(&self) -> f64 {
        self.lengths.iter().sum()
    }

    /// Position and orientation at arc length `at`, which may lie before the start or past the end.
    pub fn frame_at(&self, at: f64) -> Frame {
        let mut start = 0.0;
        for (i, pair) in self.frames.windows(2).enumerate() {
            let joint = start + self.lengths[i];
            if at < joint - self.round {
                return pair[0].child(DVec3::Y * (at - start), DQuat::IDENTITY);
            }
            if at < joint + self.round {
                let t = (at - joint + self.round) / (2.0 * self.round);
                let before = pair[1].origin - pair[0].rotation * (DVec3::Y * self.round);
                let after = pair[1].point(DVec3::Y * self.round);
                let origin = before.lerp(pair[1].origin, t).lerp(pair[1].origin.lerp(after, t), t);
                return Frame { origin, rotation: pair[0].rotation.slerp(pair[1].rotation, t) };
            }
            start = joint;
        }
        let last = self.frames[self.frames.len() - 1];
        last.child(DVec3::Y * (at - start), DQuat::IDENTITY)
    }
}
