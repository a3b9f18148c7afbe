//! The field of the muscles that one point of the skin follows, each by a weight of its own (paper A, section 8.7).

use super::{AxisPoint, MuscleFrame, evaluate};
use crate::{
    field::{Sample, compose::clean_union_values},
    math::{cube_root, smoothstep, transform_point, transpose_vector},
};
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};

crate::gpu_struct! {
    /// How far one muscle takes one vertex with it.
    pub struct MuscleWeight {
        /// Direction of the muscle's gradient at the vertex at rest; `w` unused.
        pub inward: Vec4,
        /// Index of the muscle.
        pub muscle: u32,
        /// Joint in whose scene space at rest the muscle is shaped.
        pub joint: u32,
        /// Share of the way to the rest iso-value, 0..=1.
        pub weight: f32,
        /// Unused.
        pub pad_0: u32,
    }
}

/// Support of a muscle over that which it has among other fields.
pub(crate) const WIDENED: f32 = 2.5;

/// A muscle with the same surface and two and a half times the support: wider than most muscles bulge, so that the skin, which has no
/// field of its own here, is handed over smoothly.
#[inline]
pub fn widened(muscle: &MuscleFrame) -> MuscleFrame {
    let more = (WIDENED - 1.0) * muscle.support_radius;
    let reach = muscle.lowest.w.sqrt() + more;
    MuscleFrame {
        support_radius: muscle.support_radius + more,
        lowest: (muscle.lowest.xyz() - more).extend(reach * reach),
        highest: (muscle.highest.xyz() + more).extend(0.0),
        ..*muscle
    }
}

/// What the muscles of a vertex make of one point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pull {
    /// Clean union of the muscles' fields, its gradient in posed scene space.
    pub sample: Sample,
    /// Where the gradients of the rest pose have turned with the muscles, their mean by how much of the union each muscle is.
    pub inward: Vec3,
    /// The weights' mean likewise, 0..=1.
    pub weight: f32,
    /// Support radius, posed, of the muscle with the largest field, metres.
    pub reach: f32,
}

impl Pull {
    /// The clean union with another one.
    #[inline]
    fn with(self, other: Pull) -> Pull {
        let (big, small) = if other.sample.value > self.sample.value { (other, self) } else { (self, other) };
        let (value, by_big, by_small) = clean_union_values(big.sample.value, small.sample.value);
        let sum = by_big + by_small;
        let share = if sum > 0.0 { by_small / sum } else { 0.0 };
        Pull {
            sample: Sample { value, gradient: big.sample.gradient * by_big + small.sample.gradient * by_small },
            inward: big.inward + (small.inward - big.inward) * share,
            weight: big.weight + (small.weight - big.weight) * share,
            reach: big.reach,
        }
    }
}

/// The union of a vertex's muscles at a posed point. `to_rest` gives the way back from a joint's pose, and the volume factor of
/// that pose; it is asked once for muscles of one joint that follow each other.
#[inline]
pub fn pull(
    muscles: &[MuscleFrame],
    axes: &[AxisPoint],
    weights: &[MuscleWeight],
    to_rest: impl Fn(u32) -> (Mat4, f32),
    p_posed: Vec3,
) -> Pull {
    let mut found = Pull::default();
    let mut joint = u32::MAX;
    let (mut inverse, mut scale, mut p_rest) = (Mat4::IDENTITY, 1.0, p_posed);
    for own in weights {
        if own.joint != joint {
            joint = own.joint;
            let volume;
            (inverse, volume) = to_rest(joint);
            scale = cube_root(volume.abs());
            p_rest = transform_point(&inverse, p_posed);
        }
        let muscle = widened(&muscles[own.muscle as usize]);
        if !muscle.reaches(p_rest) {
            continue;
        }
        let sample = evaluate(&muscle, muscle.points(axes), p_rest);
        if sample.value > 0.0 {
            let gradient = transpose_vector(&inverse, sample.gradient);
            let turned = transpose_vector(&inverse, own.inward.xyz());
            let inward = turned / turned.dot(turned).sqrt();
            let reach = muscle.support_radius * scale;
            found = found.with(Pull { sample: Sample { gradient, ..sample }, inward, weight: own.weight, reach });
        }
    }
    found
}

/// Cosine between the union's gradient and the direction inward at rest from which the gradient alone leads.
pub(crate) const FACING: f32 = 0.5;

impl Pull {
    /// The way inward, a unit vector: along the gradient where this leads the way that it did at rest. Geometric skinning may have
    /// taken the point to the axis or past it, from where the gradient leads out of the muscle's back; there the direction of
    /// the rest pose stands for it.
    #[inline]
    pub fn direction(&self) -> Vec3 {
        let squared = self.sample.gradient.dot(self.sample.gradient);
        if squared <= 0.0 {
            return self.inward / self.inward.dot(self.inward).sqrt();
        }
        let unit = self.sample.gradient / squared.sqrt();
        let facing = smoothstep(unit.dot(self.inward) / FACING);
        let blend = self.inward * (1.0 - facing) + unit * facing;
        blend / blend.dot(blend).sqrt()
    }

    /// How far the gradient leads the way that it did at rest, 0..=1.
    #[inline]
    pub fn facing(&self) -> f32 {
        let squared = self.sample.gradient.dot(self.sample.gradient);
        if squared > 0.0 { smoothstep(self.sample.gradient.dot(self.inward) / (squared.sqrt() * FACING)) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(value: f32, weight: f32) -> Pull {
        Pull { sample: Sample { value, gradient: Vec3::X }, inward: Vec3::X, weight, reach: 1.0 }
    }

    #[test]
    fn a_union_weighs_by_what_each_muscle_is_of_it() {
        let both = of(0.3, 1.0).with(of(0.3, 0.5));
        assert!((both.weight - 0.75).abs() < 1e-6 && both.sample.value > 0.32, "{both:?}");
        assert_eq!(of(0.3, 1.0).with(of(0.1, 0.0)).weight, 1.0, "what is far below has no say");
        assert_eq!(of(0.3, 0.25).with(Pull::default()).weight, 0.25);
        assert_eq!(Pull::default().with(of(0.3, 0.25)), of(0.3, 0.25));
        // A muscle that comes up takes over without a jump.
        let weights: Vec<f32> = (0..=400).map(|i| of(0.3, 1.0).with(of(i as f32 / 1000.0, 0.0)).weight).collect();
        let step = weights.windows(2).map(|w| (w[0] - w[1]).abs()).fold(0.0, f32::max);
        assert!(step < 0.05 && weights[400] < 0.2, "{step} {}", weights[400]);
    }
}
