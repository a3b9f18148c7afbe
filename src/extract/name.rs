//! What anatomy has at a place of limbs and trunk: proposals. Where it has bone under the skin there is no name.

use super::{limb::Bone, stretch::Place, trunk::Sweep};
use crate::rig::{
    Character,
    groups::Side,
    roles::{LimbRoles, Roles},
};
use glam::DVec3;

/// What anatomy has at such a place of a limb: `degrees` around the bone, 0 in front, 90 outside, and at a share of its length; on
/// a forearm by whether it is on the flexors' side, where that is known.
pub fn of_limb(bone: Bone, degrees: f64, middle: f64, flexor: Option<bool>) -> &'static str {
    let quarter = ((degrees + 45.0).rem_euclid(360.0) / 90.0) as u32;
    match (bone, quarter) {
        (Bone::UpperArm, 0) if middle < 0.65 => "biceps",
        (Bone::UpperArm, 0) => "brachialis",
        (Bone::UpperArm, 1) if middle < 0.4 => "deltoid",
        (Bone::UpperArm, 1) => "triceps_lateral",
        (Bone::UpperArm, 2) if degrees > 0.0 => "triceps_lateral",
        (Bone::UpperArm, _) if middle > 0.65 => "triceps_medial",
        (Bone::UpperArm, _) => "triceps_long",
        (Bone::Forearm, _) if flexor == Some(true) => "forearm_flexors",
        (Bone::Forearm, _) if flexor == Some(false) => "forearm_extensors",
        (Bone::Forearm, 0) => "forearm_front",
        (Bone::Forearm, 1) => "forearm_outside",
        (Bone::Forearm, 2) => "forearm_back",
        (Bone::Forearm, _) => "forearm_inside",
        (Bone::Thigh, 0) => "quadriceps",
        (Bone::Thigh, 1) => "vastus_lateralis",
        (Bone::Thigh, 2) => "hamstrings",
        (Bone::Thigh, _) => "adductors",
        (Bone::Shin, 0) => "tibialis_anterior",
        (Bone::Shin, 1) => "peroneus",
        (Bone::Shin, 2) if middle < 0.4 => "gastrocnemius",
        (Bone::Shin, 2) => "soleus",
        (Bone::Shin, _) => "gastrocnemius_medial",
    }
}

/// Whether anatomy has a muscle of this name move the joint below its bone, wherever along the bone its belly is.
pub fn ends_below(bone: Bone, name: &str) -> bool {
    match bone {
        Bone::UpperArm => name != "deltoid",
        Bone::Thigh => name != "adductors",
        Bone::Forearm | Bone::Shin => false,
    }
}

/// Whether a place of a forearm is on its flexors' side: of the palm at the wrist, of the body and the front at the elbow, for the
/// forearm turns between. `None` where no fingers show a palm or nothing a front.
pub fn is_flexor(character: &Character, roles: &Roles, arm: &LimbRoles, out: DVec3, middle: f64) -> Option<bool> {
    let axes = roles.axes.as_ref()?;
    let along = (arm.places[2] - arm.places[1]).try_normalize()?;
    let place = |j: u32| character.joints[j as usize].bind().w_axis.truncate();
    let palm = arm.curl(Some(axes), place)?.cross(along).try_normalize()?;
    let outside = if arm.side == Some(Side::Right) { -axes.left } else { axes.left };
    let elbow = (axes.forward - outside).reject_from(along).try_normalize()?;
    let side = elbow.lerp(palm, (middle as f32).clamp(0.0, 1.0)).as_dvec3();
    Some(out.dot(side) > 0.0)
}

/// Over the arm, not beside it: cosine.
const OVER_ARM: f64 = 0.5;

/// A muscle of the trunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrunkName {
    /// Its name, without a side.
    pub name: &'static str,
    /// Where it ends away from the trunk.
    pub far: Far,
}

/// What is marked where anatomy has no muscle.
pub const UNNAMED: TrunkName = TrunkName { name: "muscle", far: Far::Trunk };

/// What a trunk's muscle moves beside the trunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Far {
    /// Nothing.
    Trunk,
    /// The upper arm.
    Arm,
    /// The thigh.
    Leg,
}

/// What anatomy has at a place of the trunk that a sweep found. `None` where bone is: ribs, clavicle, hip, spine, larynx.
pub fn of_trunk(sweep: Sweep, place: &Place) -> Option<TrunkName> {
    let named = |name, far| Some(TrunkName { name, far });
    let Place { across, height, degrees, over_arm, .. } = *place;
    if place.is_middle() {
        return None;
    }
    match sweep {
        Sweep::Neck if degrees < 70.0 => named("sternocleidomastoid", Far::Trunk),
        Sweep::Neck => named("trapezius_neck", Far::Trunk),
        Sweep::Shoulder(_) if across > 1.0 && over_arm > OVER_ARM => named("deltoid", Far::Arm),
        // Beside the arm its own planes see better, and under it is the armpit.
        Sweep::Shoulder(_) if across > 1.0 => None,
        _ if height > 1.0 && degrees > 60.0 => named("trapezius", Far::Trunk),
        // Clavicle.
        _ if height > 1.0 => None,
        _ if height < 0.3 && degrees > 110.0 => named("gluteus", Far::Leg),
        // The hip's own shape, and the groin.
        _ if height < 0.22 => None,
        _ if degrees > 135.0 && across < 0.5 => named("erector_spinae", Far::Trunk),
        _ if degrees > 115.0 && height > 0.75 => named("infraspinatus", Far::Arm),
        _ if degrees > 70.0 && height > 0.45 => named("latissimus", Far::Arm),
        _ if height > 0.68 && degrees < 70.0 => named("pectoralis", Far::Arm),
        _ if degrees < 28.0 => named("rectus_abdominis", Far::Trunk),
        _ if degrees < 110.0 => named("oblique", Far::Trunk),
        _ => None,
    }
}
