//! Spheres outside which field groups have no field, muscles included. Twin of the kernel `group_bound`.

use super::{evaluate::GroupFrame, muscle::MuscleFrame};
use crate::math::{affine_inverse, transform_point};
use glam::{Vec3, Vec4Swizzles};

/// A little more than a sphere needs, for rounding.
pub(crate) const ROUNDING: f32 = 1.0001;

/// Grows the spheres of the groups that have muscles ([`GroupFrame::bounds`]) by their muscles' boxes: exact, since a muscle
/// has no field outside its box. Where a box is not finite its group stays without a sphere.
pub fn bound(groups: &mut [GroupFrame], muscles: &[MuscleFrame]) {
    for frame in groups.iter_mut().filter(|frame| frame.bounds.w < 0.0) {
        let (mut lowest, mut highest) = (Vec3::MAX, Vec3::MIN);
        for muscle in &muscles[frame.grid.muscle_begin as usize..frame.grid.muscle_end as usize] {
            (lowest, highest) = (lowest.min(muscle.lowest.xyz()), highest.max(muscle.highest.xyz()));
        }
        let width = highest - lowest;
        if !width.dot(width).is_finite() {
            continue;
        }
        let to_posed = affine_inverse(&frame.to_rest).0;
        let mut squared = -frame.bounds.w;
        for k in 0..8 {
            let corner = Vec3::new(
                if k & 1 == 0 { lowest.x } else { highest.x },
                if k & 2 == 0 { lowest.y } else { highest.y },
                if k & 4 == 0 { lowest.z } else { highest.z },
            );
            let away = transform_point(&to_posed, corner) - frame.bounds.xyz();
            squared = squared.max(away.dot(away) * ROUNDING);
        }
        if squared < f32::MAX {
            frame.bounds.w = squared;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::GroupGrid;
    use super::*;
    use glam::{Mat4, Quat, Vec4};

    fn group(muscles: [u32; 2]) -> GroupFrame {
        let matrix = Mat4::from_rotation_translation(Quat::from_rotation_z(0.7), Vec3::new(0.3, -0.2, 0.1));
        let grid = GroupGrid { muscle_begin: muscles[0], muscle_end: muscles[1], ..GroupGrid::default() };
        let bounds = matrix.transform_point3(Vec3::ZERO).extend(-0.01);
        GroupFrame { to_rest: matrix.inverse(), grid, bounds, present: 1, ..GroupFrame::default() }
    }

    fn muscle(lowest: Vec3, highest: Vec3) -> MuscleFrame {
        MuscleFrame { lowest: lowest.extend(0.0), highest: highest.extend(0.0), ..MuscleFrame::default() }
    }

    #[test]
    fn a_sphere_holds_its_grid_and_its_muscles_and_little_more() {
        let muscles = [
            muscle(Vec3::splat(-0.01), Vec3::splat(0.02)),
            muscle(Vec3::new(0.1, 0.0, -0.2), Vec3::new(0.3, 0.05, 0.0)),
            muscle(Vec3::splat(-9.0), Vec3::splat(9.0)),
        ];
        let mut groups = [group([0, 1]), group([0, 2]), group([0, 0])];
        groups[2].bounds.w = 0.01;
        bound(&mut groups, &muscles);
        assert_eq!(groups[0].bounds.w, 0.01, "a muscle inside the grid's sphere");
        assert_eq!(groups[2].bounds.w, 0.01, "no muscles");
        // The far corner of the two muscles' box is (.3, .05, -.2).
        let far: f32 = 0.3f32.powi(2) + 0.05f32.powi(2) + 0.2f32.powi(2);
        assert!((groups[1].bounds.w / far - 1.0001).abs() < 1e-4, "{} {far}", groups[1].bounds.w);
        let to_posed = groups[1].to_rest.inverse();
        for (corner, beyond) in [(Vec3::new(0.3, 0.05, -0.2), false), (Vec3::new(0.31, 0.06, -0.21), true)] {
            assert_eq!(groups[1].is_beyond(to_posed.transform_point3(corner)), beyond);
        }
        let before = groups;
        bound(&mut groups, &muscles[..1]);
        assert_eq!(groups, before, "once a frame");
    }

    #[test]
    fn no_sphere_is_made_of_what_is_not_finite() {
        for bad in [f32::NAN, f32::INFINITY] {
            let mut groups = [group([0, 1])];
            bound(&mut groups, &[muscle(Vec3::ZERO, Vec3::new(0.0, bad, 0.0))]);
            assert!(!groups[0].is_beyond(Vec3::splat(1e6)), "{bad} {:?}", groups[0].bounds);
        }
        let mut groups = [group([0, 1])];
        groups[0].bounds = Vec4::new(0.0, 0.0, 0.0, -1.0);
        assert!(!groups[0].is_beyond(Vec3::splat(1e6)), "not yet bounded");
    }
}
