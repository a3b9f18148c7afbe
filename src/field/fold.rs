//! Tissue that a folding joint displaces: an offset of a group's raw distance beside the fold (prototypes 5).
//!
//! Where two parts of a limb press against each other they lose volume to the contact. Living tissue gives way to the
//! sides: the surface is let out by `s A B` next to the joint, and the tracker carries the skin there.

use crate::math::smoothstep;
use glam::{Vec3, Vec4, Vec4Swizzles};

crate::gpu_struct! {
    /// One end of a group that folds against its neighbour, metres in scene space at rest.
    pub struct Fold {
        /// Centre of the bulge on the bone's line, and in `w` its half length away from the joint.
        pub centre: Vec4,
        /// Unit vector out of the joint along the group's bone, and in `w` the half length towards the joint.
        pub axis: Vec4,
        /// Unit vector to the fold's inner side, perpendicular to the axis, and in `w` the share of the offset that the
        /// outer side lacks.
        pub inner: Vec4,
        /// Offset s at the bulge's height; 0 where nothing folds.
        pub offset: f32,
        /// Largest offset that the fold's angle allows, metres.
        pub most: f32,
        /// Unused.
        pub pad_0: f32,
        /// Unused.
        pub pad_1: f32,
    }
}

impl crate::math::WgslType for Fold {
    const WGSL: &'static str = <Fold as crate::math::GpuStruct>::NAME;
}

impl Fold {
    /// What the offset adds to a raw distance at a point in scene space at rest, and the gradient of that.
    ///
    /// `B = (1 - (h / l)²)²` with h along the bone from the centre, and `A = 1 - kap (1 - smoothstep((cos + 1) / 1.2))`
    /// round it, with the angle from the inner side.
    #[inline]
    pub fn lift(&self, p_rest: Vec3) -> (f32, Vec3) {
        let (axis, inner) = (self.axis.xyz(), self.inner.xyz());
        let from = p_rest - self.centre.xyz();
        let h = from.dot(axis);
        let half = if h < 0.0 { self.axis.w } else { self.centre.w };
        if self.offset == 0.0 || h.abs() >= half {
            return (0.0, Vec3::ZERO);
        }
        let out = from - axis * h;
        let radius = out.dot(out).sqrt();
        let x = h / half;
        let rest = 1.0 - x * x;
        let along = rest * rest;
        if radius < LEAST_RADIUS {
            return (0.0, Vec3::ZERO);
        }
        let direction = out / radius;
        let cosine = direction.dot(inner);
        let t = ((cosine + 1.0) / SPREAD).clamp(0.0, 1.0);
        let round = 1.0 - self.inner.w * (1.0 - smoothstep(t));
        let along_slope = -4.0 * rest * x / half;
        let round_slope = self.inner.w * 6.0 * t * (1.0 - t) / SPREAD;
        let turn = (inner - direction * cosine) / radius;
        (-self.offset * (round * along), (axis * (round * along_slope) + turn * (along * round_slope)) * -self.offset)
    }
}

/// Range of the cosine over which the offset goes from the outer side's to the inner side's, from -1.
pub(crate) const SPREAD: f32 = 1.2;
/// Nearer to the bone's line than this, metres, sides have no direction; no skin is there.
pub(crate) const LEAST_RADIUS: f32 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    fn fold(offset: f32) -> Fold {
        Fold {
            centre: Vec4::new(0.1, 1.0, 0.0, 0.12),
            axis: Vec3::new(0.6, 0.0, 0.8).extend(0.09),
            inner: Vec3::new(0.0, 1.0, 0.0).extend(0.75),
            offset,
            ..Fold::default()
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_offset() {
        let fold = fold(0.01);
        let mut seen = 0;
        for k in 0..2000 {
            let t = k as f32;
            let p = Vec3::new(0.1, 1.0, 0.0) + Vec3::new((t * 1.7).sin(), (t * 0.9).cos(), (t * 2.3).sin()) * 0.1;
            let (value, gradient) = fold.lift(p);
            if (p - fold.centre.xyz()).reject_from(fold.axis.xyz()).length() < 0.02 {
                continue;
            }
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                let h = 5e-4;
                let measured = (fold.lift(p + axis * h).0 - fold.lift(p - axis * h).0) / (2.0 * h);
                assert!((measured - gradient.dot(axis)).abs() < 3e-3, "{p}: {measured} {}", gradient.dot(axis));
            }
            seen += u32::from(value != 0.0);
        }
        assert!(seen > 500, "{seen}");
    }

    #[test]
    fn the_inner_side_has_all_of_it_and_the_outer_a_quarter() {
        let fold = fold(0.01);
        let at = |side: f32| fold.lift(fold.centre.xyz() + Vec3::Y * side * 0.05).0;
        assert!((at(1.0) + 0.01).abs() < 1e-7 && (at(-1.0) + 0.0025).abs() < 1e-7, "{} {}", at(1.0), at(-1.0));
        let far = fold.centre.xyz() + fold.axis.xyz() * 0.13 + Vec3::Y * 0.05;
        assert_eq!(fold.lift(far), (0.0, Vec3::ZERO));
        assert_eq!(Fold { offset: 0.0, ..fold }.lift(fold.centre.xyz() + Vec3::Y * 0.05), (0.0, Vec3::ZERO));
    }
}
