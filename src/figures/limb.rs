//! A limb without muscles whose joint is bent by code, and what bending does to its skin.

use crate::error::FigureError;
use crate::math::polar;
use crate::normals::Creases;
use crate::reference::{Motion, Reference};
use crate::rig::groups::BodyPart;
use crate::rig::{Pose, Rig};
use crate::schedule::{FrameOptions, Skinning};
use glam::{Mat4, Quat, Vec3, Vec4, Vec4Swizzles};
use std::sync::Arc;

/// Bend at rest, radians, from which it tells the hinge's direction by itself.
const TELLING_BEND: f32 = 0.15;
/// Turn in a pose from which that does.
const TELLING_TURN: f32 = 0.15;
/// Steps in which the tracked skin is led to a pose, degrees.
const STEP_DEGREES: f32 = 5.0;

/// A hinge between two field groups of a rig.
#[derive(Clone, Debug)]
pub struct Limb {
    /// The character, with its fields and no muscles.
    pub rig: Arc<Rig>,
    /// The part beyond the hinge, where names say it.
    pub part: Option<BodyPart>,
    /// What turns: this joint and all below it.
    joint: u32,
    /// Group beyond the hinge.
    group: u32,
    /// Centre of the hinge, metres at rest.
    pub origin: Vec3,
    /// Unit vector about which it closes, at rest.
    pub axis: Vec3,
    /// Angle between the two bones at rest, radians; 0 is straight.
    rest: f32,
}

/// A skin in one pose.
#[derive(Clone, Debug, Default)]
pub struct Bent {
    /// Positions, scene space, `w = 1`.
    pub positions: Vec<Vec4>,
    /// Unit normals.
    pub normals: Vec<Vec4>,
}

/// What bending has done to a skin, against rest.
#[derive(Clone, Copy, Debug)]
pub struct Effect {
    /// Volume that the whole skin encloses at rest, and by how much it has changed, cubic metres; `None` where it has holes.
    pub volume: Option<[f64; 2]>,
    /// Smallest and largest ratio of a triangle's areas near the hinge.
    pub areas: [f64; 2],
    /// Change of the angle at edges near the hinge that 99.5 % of them stay within, degrees.
    pub crease: f64,
}

impl Limb {
    /// The first joint of a rig that folds and has `part` beyond it, or has no name; `poses` tell about which axis, where the
    /// limb is straight at rest.
    pub fn find(rig: &Arc<Rig>, part: BodyPart, poses: &[Pose]) -> Option<Limb> {
        let groups = &rig.groups.groups;
        let of = |wanted: Option<BodyPart>| rig.folds.iter().find(|fold| groups[fold.child as usize].part == wanted);
        let fold = of(Some(part)).or_else(|| of(None).filter(|_| part == BodyPart::Forearm))?;
        let swing = rig.swings.iter().find(|swing| swing.group == fold.child)?;
        let above = *groups[fold.parent as usize].joints.first()?;
        let start = rig.character.joints[above as usize].bind().w_axis.truncate();
        let upper = (swing.origin - start).try_normalize()?;
        let rest = upper.angle_between(swing.axis);
        let axis = if rest > TELLING_BEND {
            upper.cross(swing.axis).try_normalize()?
        } else {
            let turn = |pose: &Pose| {
                let (above, own) = (pose.palette.get(swing.parent as usize)?, pose.palette.get(swing.joint as usize)?);
                let (axis, angle) = polar(&(above.inverse() * *own)).0.to_axis_angle();
                let shorter = std::f32::consts::TAU - angle;
                Some(if angle > shorter { (-axis, shorter) } else { (axis, angle) })
            };
            let turns = poses.iter().filter_map(turn).filter(|(_, angle)| *angle > TELLING_TURN);
            turns.max_by(|a, b| a.1.total_cmp(&b.1))?.0
        };
        Some(Limb {
            rig: Arc::clone(rig),
            part: groups[fold.child as usize].part,
            joint: swing.joint,
            group: fold.child,
            origin: swing.origin,
            axis,
            rest,
        })
    }

    /// The pose in which its two bones are `degrees` out of line, everything else at rest.
    pub fn bent(&self, degrees: f32) -> Pose {
        let character = &self.rig.character;
        let rotation = Quat::from_axis_angle(self.axis, degrees.to_radians() - self.rest);
        let turn =
            Mat4::from_translation(self.origin) * Mat4::from_quat(rotation) * Mat4::from_translation(-self.origin);
        let mut pose = Pose::rest(character);
        let mut turns = vec![false; character.joints.len()];
        for (j, joint) in character.joints.iter().enumerate() {
            turns[j] = j == self.joint as usize || joint.parent.is_some_and(|p| turns[p as usize]);
            if turns[j] {
                pose.palette[j] = turn;
            }
        }
        pose
    }

    /// The skin at each of some angles, degrees, led there from rest: what one angle leaves behind is no matter of the next.
    ///
    /// # Errors
    /// [`FigureError::Pose`].
    pub fn skins(&self, skinning: Skinning, degrees: &[f32]) -> Result<Vec<Bent>, FigureError> {
        let options = FrameOptions { skinning, ..FrameOptions::default() };
        let reference = Reference::new(&self.rig);
        let mut skins = Vec::new();
        for &goal in degrees {
            let mut motion = Motion::new(&self.rig, &options);
            let mut at = self.rest.to_degrees();
            while (goal - at).abs() > STEP_DEGREES {
                at += STEP_DEGREES.copysign(goal - at);
                reference.advance(&mut motion, &self.bent(at), &options)?;
            }
            let trace = reference.next(&mut motion, &self.bent(goal), &options)?;
            skins.push(Bent { positions: trace.positions().to_vec(), normals: trace.normals });
        }
        Ok(skins)
    }

    /// Vertices near the hinge, which pictures of it hold.
    pub fn near(&self) -> Vec<usize> {
        let reach = 3.4 * self.rig.grids[self.group as usize].support_radius;
        let rest = &self.rig.character.positions_rest;
        (0..rest.len()).filter(|&v| rest[v].distance(self.origin) < reach).collect()
    }

    /// What bending has done.
    pub fn effect(&self, skin: &Bent) -> Effect {
        let rig = &self.rig;
        let rest = &rig.positions_rest;
        let corner = |positions: &[Vec4], v: u32| positions[v as usize].xyz().as_dvec3();
        let volume = |positions: &[Vec4]| {
            let of = |t: &[u32; 3]| corner(positions, t[0]).dot(corner(positions, t[1]).cross(corner(positions, t[2])));
            rig.character.triangles.iter().map(of).sum::<f64>() / 6.0
        };
        let area = |positions: &[Vec4], t: &[u32; 3]| {
            let a = corner(positions, t[0]);
            (corner(positions, t[1]) - a).cross(corner(positions, t[2]) - a).length()
        };
        let mut near = vec![false; rest.len()];
        self.near().into_iter().for_each(|v| near[v] = true);
        let triangles: Vec<[u32; 3]> =
            rig.character.triangles.iter().filter(|t| t.iter().all(|&v| near[v as usize])).copied().collect();
        let ratios = triangles.iter().filter_map(|t| {
            let before = area(rest, t);
            (before > 1e-12).then(|| area(&skin.positions, t) / before)
        });
        let areas = ratios.fold([f64::INFINITY, 0.0f64], |[low, high], ratio| [low.min(ratio), high.max(ratio)]);
        let creases = Creases::new(&triangles, &rig.graph.copy_of, rest);
        let mut changes: Vec<f32> = creases.changes(&skin.positions).iter().map(|change| change.abs()).collect();
        changes.sort_unstable_by(f32::total_cmp);
        let crease = changes.get((0.995 * changes.len() as f64) as usize).copied().unwrap_or_default();
        let closed = !rig.graph.boundary.iter().any(|&open| open);
        let volume = closed.then(|| {
            let at_rest = volume(rest);
            [at_rest, volume(&skin.positions) - at_rest]
        });
        Effect { volume, areas, crease: crease.into() }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::motion::tests::arm;
    use super::*;
    use crate::rig::BuildOptions;

    /// The built-in arm without muscles.
    pub fn limb() -> Limb {
        let arm = arm();
        let rig = Rig::build(arm.rig.character.clone(), &[], &BuildOptions::default()).expect("a rig");
        Limb::find(&Arc::new(rig), BodyPart::Forearm, &arm.curl).expect("an elbow")
    }

    #[test]
    fn bones_stand_at_the_angle_that_is_asked_for() {
        let limb = limb();
        let swing = limb.rig.swings.iter().find(|swing| swing.group == limb.group).expect("a swing");
        let straight = limb.bent(0.0).palette[limb.joint as usize].transform_vector3(swing.axis);
        for degrees in [45.0, 90.0, 130.0] {
            let bone = limb.bent(degrees).palette[limb.joint as usize].transform_vector3(swing.axis);
            assert!((bone.angle_between(straight).to_degrees() - degrees).abs() < 0.1, "{degrees}");
        }
        assert!(Limb::find(&limb.rig, BodyPart::Calf, &[]).is_none(), "an arm has no knee");
    }

    #[test]
    fn linear_skinning_loses_volume_at_the_elbow_and_ours_less() {
        let limb = limb();
        let at = |skinning, degrees| limb.effect(&limb.skins(skinning, &[degrees]).expect("skins")[0]);
        let [linear, ours] = [Skinning::Linear, Skinning::Implicit].map(|skinning| at(skinning, 130.0));
        assert!(linear.crease > 5.0 && linear.areas[0] < 0.5, "{linear:?}");
        if let (Some(linear), Some(ours)) = (linear.volume, ours.volume) {
            assert!(linear[1] < -0.01 * linear[0] && ours[1].abs() < linear[1].abs(), "{linear:?} {ours:?}");
        }
        let rest = at(Skinning::Linear, limb.rest.to_degrees());
        assert!(rest.areas.iter().all(|ratio| (ratio - 1.0).abs() < 1e-3) && rest.crease < 0.1, "{rest:?}");
    }
}
