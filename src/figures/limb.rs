//! A limb without muscles whose joint is bent by code, and what bending does to its skin.

use crate::error::FigureError;
use crate::math::polar;
use crate::normals::Creases;
use crate::reference::{Motion, Reference};
use crate::rig::groups::{BodyPart, GroupSpec};
use crate::rig::roles::{LimbRoles, Roles};
use crate::rig::{BuildOptions, Character, Pose, Rig};
use crate::schedule::{FrameOptions, Skinning};
use glam::{Mat4, Quat, Vec3, Vec4, Vec4Swizzles};
use std::sync::Arc;

/// Bend at rest, radians, from which it tells the hinge's direction by itself.
const TELLING_BEND: f32 = 0.15;
/// Turn in a pose from which that does.
const TELLING_TURN: f32 = 0.15;
/// How far pictures of a hinge reach: in support radii of what is beyond it, and in lengths of a finger's first bone.
const LIMB_REACH: f32 = 3.4;
const FINGER_REACH: f32 = 1.7;
/// Share of a finger's middle bend that its last joint bends by.
const LAST_BEND: f32 = 0.6;
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
    /// Centre of the hinge, metres at rest.
    pub origin: Vec3,
    /// Unit vector about which it closes, at rest.
    pub axis: Vec3,
    /// Unit vector along the axis, to the side from which nothing else stands before the hinge.
    pub outside: Vec3,
    /// How far from the hinge what pictures of it hold reaches, metres.
    reach: f32,
    /// Angle between the two bones at rest, radians; 0 is straight.
    rest: f32,
    /// A hinge farther out that bends along, about the same axis: its joint and where it is, metres at rest.
    further: Option<(u32, Vec3)>,
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
        let places = &rig.character.positions_rest;
        let middle = places.iter().sum::<Vec3>() / places.len().max(1) as f32;
        Some(Limb {
            rig: Arc::clone(rig),
            part: groups[fold.child as usize].part,
            joint: swing.joint,
            origin: swing.origin,
            axis,
            outside: if (swing.origin - middle).dot(axis) < 0.0 { -axis } else { axis },
            reach: LIMB_REACH * rig.grids[fold.child as usize].support_radius,
            rest,
            further: None,
        })
    }

    /// Whether a character has fingers to bend.
    pub fn has_finger(character: &Character) -> bool {
        pointer(&Roles::find(character), character).is_some()
    }

    /// The finger of a character that is nearest to its thumb, with a field for each of its bones; `None` where it has no
    /// fingers.
    ///
    /// # Errors
    /// [`FigureError`] where the fields cannot be fitted.
    pub fn finger(character: &Character) -> Result<Option<Limb>, FigureError> {
        let roles = Roles::find(character);
        let Some((hand, digit)) = pointer(&roles, character) else { return Ok(None) };
        let place = |j: u32| place(character, j);
        let names = digit.iter().map(|&j| character.joints[j as usize].name.clone()).collect();
        let fingers = GroupSpec { name: "finger".into(), joints: names, separate: true, passive: None };
        let options = BuildOptions { groups: vec![fingers], ..BuildOptions::default() };
        let rig = Arc::new(Rig::build(character.clone(), &[], &options)?);
        let Some(curl) = hand.curl(roles.axes.as_ref(), place) else { return Ok(None) };
        let [knuckle, middle, last] = [0, 1, 2].map(|k| place(digit[k]));
        let (first, second) = (middle - knuckle, last - middle);
        let Some(axis) = curl.reject_from(first).try_normalize() else { return Ok(None) };
        let others: Vec<Vec3> = hand.digits.iter().map(|digit| place(digit[0])).collect();
        let among = others.iter().sum::<Vec3>() / others.len().max(1) as f32;
        Ok(Some(Limb {
            part: Some(BodyPart::Hand),
            joint: digit[1],
            origin: middle,
            axis,
            outside: if (knuckle - among).dot(axis) < 0.0 { -axis } else { axis },
            reach: FINGER_REACH * first.length(),
            rest: first.cross(second).dot(axis).atan2(first.dot(second)),
            further: Some((digit[2], last)),
            rig,
        }))
    }

    /// The pose in which its two bones are `degrees` out of line, everything else at rest.
    pub fn bent(&self, degrees: f32) -> Pose {
        let character = &self.rig.character;
        let turn = |origin: Vec3, angle: f32| {
            let rotation = Mat4::from_quat(Quat::from_axis_angle(self.axis, angle));
            Mat4::from_translation(origin) * rotation * Mat4::from_translation(-origin)
        };
        let angle = degrees.to_radians() - self.rest;
        let mut pose = Pose::rest(character);
        for (j, joint) in character.joints.iter().enumerate() {
            let above = joint.parent.map_or(Mat4::IDENTITY, |p| pose.palette[p as usize]);
            let own = |hinge: u32| hinge as usize == j;
            pose.palette[j] = match self.further {
                _ if own(self.joint) => above * turn(self.origin, angle),
                Some((last, origin)) if own(last) => above * turn(origin, LAST_BEND * angle),
                _ => above,
            };
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
        let rest = &self.rig.character.positions_rest;
        (0..rest.len()).filter(|&v| rest[v].distance(self.origin) < self.reach).collect()
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

fn place(character: &Character, joint: u32) -> Vec3 {
    character.joints[joint as usize].bind().w_axis.truncate()
}

/// The finger of three joints that ends nearest to the thumb, with its arm.
fn pointer<'a>(roles: &'a Roles, character: &Character) -> Option<(&'a LimbRoles, &'a Vec<u32>)> {
    let hand = roles.arms.iter().find(|arm| arm.digits.iter().any(|digit| digit.len() > 2))?;
    let tip = |digit: &Vec<u32>| digit.last().map(|&joint| place(character, joint));
    let thumb = hand.thumb.as_ref().and_then(tip).unwrap_or(hand.places[2]);
    let far = |digit: &Vec<u32>| tip(digit).map_or(f32::INFINITY, |tip| tip.distance(thumb));
    let fingers = hand.digits.iter().filter(|digit| digit.len() > 2);
    Some((hand, fingers.min_by(|a, b| far(a).total_cmp(&far(b)))?))
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
        let swing = limb.rig.swings.iter().find(|swing| swing.joint == limb.joint).expect("a swing");
        let straight = limb.bent(0.0).palette[limb.joint as usize].transform_vector3(swing.axis);
        for degrees in [45.0, 90.0, 130.0] {
            let bone = limb.bent(degrees).palette[limb.joint as usize].transform_vector3(swing.axis);
            assert!((bone.angle_between(straight).to_degrees() - degrees).abs() < 0.1, "{degrees}");
        }
        assert!(Limb::find(&limb.rig, BodyPart::Calf, &[]).is_none(), "an arm has no knee");
        assert!(!Limb::has_finger(&limb.rig.character), "nor fingers");
    }

    #[test]
    fn a_finger_with_fields_of_its_own_folds_better_than_linear_skinning() {
        let Some(data) = std::env::var_os("SINEW_DATA").map(std::path::PathBuf::from) else {
            println!("SINEW_DATA is not set: no finger is bent");
            return;
        };
        let scene = crate::io::gltf::read(&data.join("humans/mh_male_athletic.glb")).expect("a human");
        let finger = Limb::finger(&scene.character).expect("fields").expect("a finger");
        let c = &finger.rig.character;
        assert_eq!(c.joints[finger.joint as usize].name, "index_02_l");
        let [knuckle, middle, last] = ["index_01_l", "index_02_l", "index_03_l"]
            .map(|name| c.joints.iter().position(|j| j.name == name).expect("a joint"));
        let bend = |pose: &Pose| {
            let at = |moves: usize, j: usize| pose.palette[moves].transform_point3(place(c, j as u32));
            let [a, b, c] = [at(knuckle, knuckle), at(middle, middle), at(middle, last)];
            (b - a).angle_between(c - b).to_degrees()
        };
        // The axis lies across the first bone, and the second one is some degrees out of its plane.
        assert!((bend(&finger.bent(80.0)) - 80.0).abs() < 3.0, "{}", bend(&finger.bent(80.0)));
        let at = |limb: &Limb, skinning| limb.skins(skinning, &[110.0]).expect("skins").remove(0);
        let [linear, ours] = [Skinning::Linear, Skinning::Implicit].map(|skinning| at(&finger, skinning));
        let effects = [&linear, &ours].map(|skin| finger.effect(skin));
        assert!(effects[1].areas[0] > 1.5 * effects[0].areas[0], "{effects:?}");
        assert!(effects[1].crease < 0.9 * effects[0].crease, "{effects:?}");
        // Without fields of its own the finger belongs to the hand, which follows linear skinning.
        let rig = Arc::new(Rig::build(c.clone(), &[], &BuildOptions::default()).expect("a rig"));
        let merged = Limb { rig, ..finger.clone() };
        let same = at(&merged, Skinning::Implicit);
        let far = |a: &Bent, b: &Bent| {
            let near = finger.near().into_iter();
            near.map(|v| a.positions[v].distance(b.positions[v])).fold(0.0, f32::max)
        };
        assert!(
            far(&same, &linear) < 1e-6 && far(&ours, &linear) > 5e-4,
            "{} {}",
            far(&same, &linear),
            far(&ours, &linear)
        );
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
