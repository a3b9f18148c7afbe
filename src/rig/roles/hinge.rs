//! Which way a limb's hinge closes.

use super::{BodyAxes, LimbRoles};
use glam::{Quat, Vec3};

/// A bend at rest, radians, from which it tells the hinge's axis; and one from which it does so against the body's front.
const TELLING_BEND: f32 = 0.15;
const CERTAIN_BEND: f32 = 0.5;

/// An elbow or a knee.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hinge {
    /// The joint that turns.
    pub joint: u32,
    /// Its centre, metres at rest.
    pub origin: Vec3,
    /// Unit vector about which it closes, at rest.
    pub axis: Vec3,
    /// Turns the rest pose to the straight limb.
    pub straight: Quat,
}

impl LimbRoles {
    /// The hinge between the two bones; `toward` is where the end goes as it closes, which a limb that is clearly bent at
    /// rest knows better. `None` where neither tells.
    pub fn hinge(&self, toward: Option<Vec3>) -> Option<Hinge> {
        let [start, middle, end] = self.places;
        let (upper, lower) = ((middle - start).try_normalize()?, (end - middle).try_normalize()?);
        let across = |toward: Vec3| upper.cross(toward).try_normalize().filter(|axis| axis.is_finite());
        let rest = upper.angle_between(lower);
        let agrees = toward.is_none_or(|toward| lower.reject_from_normalized(upper).dot(toward) > 0.0);
        let bent = rest > CERTAIN_BEND || (rest > TELLING_BEND && agrees);
        let axis = if bent { across(lower) } else { across(toward?) }?;
        Some(Hinge { joint: self.lower, origin: middle, axis, straight: Quat::from_rotation_arc(lower, upper) })
    }

    /// The hinge of an arm: the hand goes forward.
    pub fn elbow(&self, axes: Option<&BodyAxes>) -> Option<Hinge> {
        self.hinge(axes.map(|axes| axes.forward))
    }

    /// The hinge of a leg: the foot goes back.
    pub fn knee(&self, axes: Option<&BodyAxes>) -> Option<Hinge> {
        self.hinge(axes.map(|axes| -axes.forward))
    }

    /// Unit vector about which the fingers curl into the palm, `places` being where joints are at rest: what the fingers' own
    /// bend at rest tells, else the side of the knuckles on which the thumb lies, else downward.
    pub fn curl(&self, axes: Option<&BodyAxes>, places: impl Fn(u32) -> Vec3) -> Option<Vec3> {
        let wrist = self.places[2];
        let steps = |digit: &[u32]| -> Vec<Vec3> {
            let points: Vec<Vec3> = std::iter::once(wrist).chain(digit.iter().map(|&j| places(j))).collect();
            points.windows(2).map(|w| (w[1] - w[0]).normalize_or_zero()).collect()
        };
        let digits: Vec<Vec<Vec3>> = self.digits.iter().map(|digit| steps(digit)).collect();
        let turn: Vec3 = digits.iter().flat_map(|d| d.windows(2)).map(|w| w[0].cross(w[1])).sum();
        let bends = digits.iter().map(|d| d.len() - 1).sum::<usize>();
        if bends > 0 && turn.length() > TELLING_BEND * bends as f32 {
            return turn.try_normalize();
        }
        let along = digits.iter().map(|d| d[0]).sum::<Vec3>().try_normalize()?;
        let (first, last) = (self.digits.first()?, self.digits.last()?);
        let across =
            (places(*first.first()?) - places(*last.first()?)).reject_from_normalized(along).try_normalize()?;
        let palm = match &self.thumb {
            Some(thumb) => places(*thumb.last()?) - wrist,
            None => -axes?.up,
        };
        across.try_normalize().map(|axis| if axis.cross(along).dot(palm) > 0.0 { axis } else { -axis })
    }
}
