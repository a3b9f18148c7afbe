//! Volume of a muscle in motion, by quadrature of its field: a mesh of it would not do where its sections turn quickly,
//! because triangles cut them short.

use super::{AxisPoint, MuscleFrame, evaluate};
use crate::field::Sample;
use glam::{Mat3, UVec3, Vec3, Vec4Swizzles};

/// Halvings from the cubes that are looked at first to the smallest cells.
const HALVINGS: u32 = 1;
/// How many times its own half diagonal a cube's middle must seem to be from the surface for all of the cube to be on its
/// side. A field's slope falls away from the surface, so that it seems up to twice as far as it is; and round bends the
/// slope is not even.
const CLEAR: f32 = 2.5;

/// Volume inside the surface of a muscle's field, cubic metres, in cells of the given edge, metres; `points` are the
/// muscle's own. Cells that the surface cuts count by its distance from their middle.
///
/// With an eighth of the muscle's width for the edge it is within 0.2 % for muscles that are not bent; see
/// [`MuscleFrame::width`].
pub fn volume(muscle: &MuscleFrame, points: &[AxisPoint], cell: f32) -> f64 {
    if muscle.present == 0 || cell.is_nan() || cell <= 0.0 {
        return 0.0;
    }
    let edge = cell * (1 << HALVINGS) as f32;
    // In a box along the chord.
    let (start, end) = (points[0].position.xyz(), points[points.len() - 1].position.xyz());
    let along = (end - start).normalize_or(Vec3::Z);
    let across = along.any_orthonormal_vector();
    let turn = Mat3::from_cols(across, along.cross(across), along);
    let turned = points.iter().map(|p| turn.transpose() * p.position.xyz());
    let (low, high) = turned.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let most = (0..=40).map(|i| muscle.radius(i as f32 / 40.0, 1.0)).fold(0.0, f32::max) + cell;
    let counts = ((high - low + 2.0 * most) / edge).ceil().as_uvec3();
    let at = |i: u32, j: u32, k: u32| low - most + (UVec3::new(i, j, k).as_vec3() + 0.5) * edge;
    let cube = |middle: Vec3| filled(&|p| evaluate(muscle, points, turn * p), middle, edge, HALVINGS);
    let row = |j: u32, k: u32| -> f64 { (0..counts.x).map(|i| cube(at(i, j, k))).sum() };
    let slice = |k: u32| -> f64 { (0..counts.y).map(|j| row(j, k)).sum() };
    (0..counts.z).map(slice).sum::<f64>() * f64::from(edge).powi(3)
}

/// Share of a cube that is inside the surface, from cubes of half its edge where the surface may cut it.
fn filled(field: &impl Fn(Vec3) -> Sample, middle: Vec3, edge: f32, halvings: u32) -> f64 {
    let found = field(middle);
    // To the surface along the gradient, inward positive.
    let depth = (found.value - 0.5) / found.gradient.length().max(1e-6);
    if halvings == 0 {
        return (0.5 + depth / edge).clamp(0.0, 1.0).into();
    }
    if depth.abs() > CLEAR * 0.866 * edge {
        return if depth > 0.0 { 1.0 } else { 0.0 };
    }
    let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32) - 0.5;
    (0..8).map(|k| filled(field, middle + corner(k) * (0.5 * edge), 0.5 * edge, halvings - 1)).sum::<f64>() / 8.0
}

#[cfg(test)]
mod tests {
    use super::super::bent::{self, LENGTH, VOLUME};
    use super::super::{Profile, tests::muscle};
    use super::*;

    fn error(muscle: &MuscleFrame, points: &[AxisPoint], share: f32) -> f64 {
        volume(muscle, points, muscle.width * share) / f64::from(VOLUME) - 1.0
    }

    #[test]
    fn a_straight_muscle_has_the_volume_of_its_cylinder() {
        for (eccentricity, exponents) in [(0.0, (3, 3)), (0.0, (4, 7)), (0.9, (3, 3)), (0.9, (2, 5))] {
            let (muscle, points) = muscle(eccentricity, exponents);
            let found = error(&muscle, &points, 0.125);
            println!("{exponents:?} of eccentricity {eccentricity}: off by {:.3} %", 100.0 * found);
            assert!(found.abs() < 2e-3, "{exponents:?} {eccentricity}: {found}");
            let wider = MuscleFrame { width: muscle.width * 1.001, ..muscle };
            let seen = error(&wider, &points, 0.125) - found;
            assert!((seen - 2e-3).abs() < 3e-4, "a muscle a thousandth wider must be seen: {seen}");
        }
    }

    #[test]
    fn cubes_clear_of_the_surface_need_no_smaller_ones() {
        let (muscle, points) = bent::arc(1.5, 29, &Profile::of(3, 3), 0.5, Vec3::Z);
        let cell = 0.125 * muscle.width;
        // As many cells as stand in a cube, one by one.
        let field = |p: Vec3| evaluate(&muscle, &points, p);
        let edge = cell * (1 << HALVINGS) as f32;
        let (mut most, mut cut) = (0.0f64, 0);
        for (i, point) in points.iter().enumerate() {
            for k in -3..=3 {
                let middle = point.position.xyz() + Vec3::new(0.3 * edge, 0.2 * edge, k as f32 * edge);
                let quick = filled(&field, middle, edge, HALVINGS);
                let n = 1 << HALVINGS;
                let cells = (0..n * n * n).map(|c| {
                    let corner = Vec3::new((c % n) as f32, (c / n % n) as f32, (c / n / n) as f32) + 0.5;
                    filled(&field, middle + corner * cell - 0.5 * edge, cell, 0)
                });
                let whole = cells.sum::<f64>() / f64::from(n * n * n);
                most = most.max((quick - whole).abs());
                cut += u32::from(whole > 0.0 && whole < 1.0);
                assert!((quick - whole).abs() < 1e-3, "point {i}, {k}: {quick} {whole}");
            }
        }
        assert!(cut > 20, "the surface cuts some: {cut}, off by {most}");
    }

    #[test]
    fn a_bent_muscle_keeps_it_and_cells_matter_little() {
        let (muscle, points) = bent::arc(1.5, 29, &Profile::of(3, 3), 0.5, Vec3::Z);
        let (usual, fine) = (error(&muscle, &points, 0.125), error(&muscle, &points, 0.0625));
        println!("bent: off by {:.3} % and {:.3} %", 100.0 * usual, 100.0 * fine);
        assert!(usual.abs() < 5e-3 && (usual - fine).abs() < 1e-3, "{usual} {fine}");
        let longer = MuscleFrame { length: LENGTH * 1.1, inverse_length: 1.0 / (LENGTH * 1.1), ..muscle };
        assert!(error(&longer, &points, 0.125).abs() > 5e-3, "a profile that goes on beyond its axis must be seen");
    }
}
