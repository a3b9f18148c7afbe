//! Poisson-disk samples of a triangle patch: points spread evenly at random, a given number of them.
//!
//! Recipe of background 1.3: scatter about forty times as many points as wanted, uniformly by area; keep a point when
//! no kept one lies within the radius; bisect the radius until the count is within a tenth of the target.
//! The generator lives here, so the same input gives the same bytes on every machine.

use glam::DVec3;

/// Scattered points per sample wanted.
const SCATTER: usize = 40;
/// Points thrown at most per point that has to be kept, where a filter rejects most of the patch.
const MOST_THROWS: usize = 8;
/// Bisections of the radius at most; the interval is then 1e-7 of its start.
const BISECTIONS: usize = 24;

/// A point on a surface with its interpolated unit normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSample {
    /// Position, metres.
    pub position: DVec3,
    /// Unit normal.
    pub normal: DVec3,
}

/// What a sampling returned.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sampling {
    /// The samples, in the order they were kept.
    pub samples: Vec<SurfaceSample>,
    /// Share of the patch's area that the filter rejected, 0..=1.
    pub rejected: f64,
    /// Least distance between two samples, metres; 0 where there are none.
    pub radius: f64,
}

/// A triangle of a patch: corner positions and corner normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchTriangle {
    /// Corners, metres.
    pub positions: [DVec3; 3],
    /// Normals at the corners, of any length above zero.
    pub normals: [DVec3; 3],
}

impl PatchTriangle {
    /// Area in square metres; 0 where a corner is not finite.
    pub fn area(&self) -> f64 {
        let [a, b, c] = self.positions;
        let area = (b - a).cross(c - a).length() * 0.5;
        if area.is_finite() { area } else { 0.0 }
    }

    /// The point at barycentric coordinates `(1 - u - v, u, v)`; `None` where the normals cancel.
    fn at(&self, u: f64, v: f64) -> Option<SurfaceSample> {
        let w = 1.0 - u - v;
        let [a, b, c] = self.positions;
        let [na, nb, nc] = self.normals;
        let normal = (na * w + nb * u + nc * v).try_normalize()?;
        Some(SurfaceSample { position: a * w + b * u + c * v, normal })
    }
}

/// Spreads about `target` samples (within a tenth where the patch allows it) over the part of the patch that `keep`
/// accepts. Empty where the patch has no area or `keep` accepts nothing.
pub fn sample_patch(
    patch: &[PatchTriangle],
    target: usize,
    seed: u64,
    keep: impl Fn(&SurfaceSample) -> bool,
) -> Sampling {
    let mut area = 0.0;
    let cumulative: Vec<f64> = patch
        .iter()
        .map(|t| {
            area += t.area();
            area
        })
        .collect();
    if target == 0 || area <= 0.0 {
        return Sampling::default();
    }
    let mut random = SplitMix64 { state: seed };
    let (mut scattered, mut thrown) = (Vec::with_capacity(SCATTER * target), 0_usize);
    while scattered.len() < SCATTER * target && thrown < MOST_THROWS * SCATTER * target {
        thrown += 1;
        let along = random.unit() * area;
        let triangle = cumulative.partition_point(|&c| c <= along).min(patch.len() - 1);
        let (root, v) = (random.unit().sqrt(), random.unit());
        let sample = patch[triangle].at(root * (1.0 - v), root * v);
        scattered.extend(sample.filter(|s| s.position.is_finite() && keep(s)));
    }
    let share = scattered.len() as f64 / thrown as f64;
    let (samples, radius) = thin(&scattered, target, area * share);
    Sampling { samples, rejected: 1.0 - share, radius }
}

/// Throws darts with a bisected radius until about `target` points are kept.
fn thin(scattered: &[SurfaceSample], target: usize, area: f64) -> (Vec<SurfaceSample>, f64) {
    let (least, most) = ((target as f64 * 0.9).ceil() as usize, (target as f64 * 1.1) as usize);
    let mut radius = 0.75 * (2.0 * area / (3.0_f64.sqrt() * target as f64)).sqrt();
    let (mut low, mut high) = (0.0, f64::INFINITY);
    let (mut best, mut best_radius) = (Vec::new(), 0.0);
    for _ in 0..BISECTIONS {
        let kept = throw(scattered, radius, most + 1);
        if kept.len() > most {
            low = radius;
            radius = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * radius };
            continue;
        }
        let enough = kept.len() >= least;
        if kept.len() > best.len() {
            (best, best_radius) = (kept, radius);
        }
        if enough {
            break;
        }
        high = radius;
        radius = 0.5 * (low + high);
    }
    (best, best_radius)
}

/// Keeps every point that no kept one lies within `radius` of, in order, and stops at `most`.
fn throw(scattered: &[SurfaceSample], radius: f64, most: usize) -> Vec<SurfaceSample> {
    let mut kept: Vec<SurfaceSample> = Vec::with_capacity(most);
    for s in scattered {
        if kept.iter().all(|k| k.position.distance_squared(s.position) > radius * radius) {
            kept.push(*s);
            if kept.len() == most {
                break;
            }
        }
    }
    kept
}

/// SplitMix64 (Steele, Lea and Flood 2014): 64 bits of state, one multiplication-xorshift round per number.
struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `0.0..1.0`, 53 bits.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 2 in the plane z = 0, cut into 2 n² triangles.
    fn square(n: usize) -> Vec<PatchTriangle> {
        let at = |i: usize, j: usize| DVec3::new(2.0 * i as f64 / n as f64 - 1.0, 2.0 * j as f64 / n as f64 - 1.0, 0.0);
        let triangle = |positions| PatchTriangle { positions, normals: [DVec3::Z; 3] };
        (0..n * n)
            .flat_map(|k| {
                let (i, j) = (k % n, k / n);
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                [triangle([a, b, c]), triangle([a, c, d])]
            })
            .collect()
    }

    #[test]
    fn generator_gives_the_published_numbers() {
        // First outputs of the reference implementation for seed 1234567.
        let mut random = SplitMix64 { state: 1_234_567 };
        assert_eq!(random.next(), 6_457_827_717_110_365_317);
        assert_eq!(random.next(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn count_is_within_a_tenth_and_no_two_are_closer_than_the_radius() {
        for target in [10, 50, 100] {
            for n in [1, 7] {
                let sampling = sample_patch(&square(n), target, 1, |_| true);
                let count = sampling.samples.len();
                assert!(count.abs_diff(target) * 10 <= target, "{count} of {target}");
                // A hexagonal packing of discs of the radius bounds the count from above.
                let densest = 2.0 * 4.0 / (3.0_f64.sqrt() * sampling.radius * sampling.radius);
                assert!((count as f64) < 1.3 * densest, "{count} {densest}");
                for (k, s) in sampling.samples.iter().enumerate() {
                    assert!(s.normal == DVec3::Z && s.position.z == 0.0);
                    let nearest = sampling.samples[..k]
                        .iter()
                        .map(|o| o.position.distance(s.position))
                        .fold(f64::INFINITY, f64::min);
                    assert!(nearest > sampling.radius);
                }
            }
        }
    }

    #[test]
    fn samples_spread_evenly_over_uneven_triangles() {
        // One half of the square in two large triangles, the other in 98 small ones: halves must hold like numbers.
        let mut patch: Vec<_> = square(14).into_iter().filter(|t| t.positions.iter().all(|p| p.x < 1e-9)).collect();
        let corners = |a, b, c| PatchTriangle { positions: [a, b, c], normals: [DVec3::Z; 3] };
        let (a, b) = (DVec3::new(0.0, -1.0, 0.0), DVec3::new(1.0, -1.0, 0.0));
        let (c, d) = (DVec3::new(1.0, 1.0, 0.0), DVec3::new(0.0, 1.0, 0.0));
        patch.extend([corners(a, b, c), corners(a, c, d)]);
        let sampling = sample_patch(&patch, 100, 5, |_| true);
        let left = sampling.samples.iter().filter(|s| s.position.x < 0.0).count();
        let right = sampling.samples.len() - left;
        assert!(left.abs_diff(right) <= 12, "{left} {right}");
    }

    #[test]
    fn seed_decides_the_bytes() {
        let run = |seed| sample_patch(&square(3), 50, seed, |_| true);
        assert_eq!(run(9), run(9));
        assert_ne!(run(9).samples, run(10).samples);
    }

    #[test]
    fn filter_keeps_the_count_and_reports_its_share() {
        let sampling = sample_patch(&square(3), 50, 2, |s| s.position.x > 0.5);
        assert!(sampling.samples.len().abs_diff(50) <= 5 && sampling.samples.iter().all(|s| s.position.x > 0.5));
        assert!((sampling.rejected - 0.75).abs() < 0.03, "{}", sampling.rejected);
    }

    #[test]
    fn normals_are_interpolated_and_of_unit_length() {
        let patch = [PatchTriangle {
            positions: [DVec3::ZERO, DVec3::X, DVec3::Y],
            normals: [DVec3::Z, DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, 2.0, 1.0)],
        }];
        for s in sample_patch(&patch, 20, 3, |_| true).samples {
            let expected = DVec3::new(s.position.x, 2.0 * s.position.y, 1.0).normalize();
            assert!((s.normal - expected).length() < 1e-12 && (s.normal.length() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn degenerate_patches_give_nothing_and_do_not_hang() {
        let flat = PatchTriangle { positions: [DVec3::ZERO, DVec3::X, DVec3::X * 2.0], normals: [DVec3::Z; 3] };
        let nan = PatchTriangle { positions: [DVec3::NAN, DVec3::X, DVec3::Y], normals: [DVec3::Z; 3] };
        let cancelling = PatchTriangle { positions: [DVec3::ZERO, DVec3::X, DVec3::Y], normals: [DVec3::ZERO; 3] };
        for patch in [&[][..], &[flat], &[nan], &[cancelling]] {
            assert!(sample_patch(patch, 50, 1, |_| true).samples.is_empty());
        }
        assert!(sample_patch(&square(2), 50, 1, |_| false).samples.is_empty());
        assert!(sample_patch(&square(2), 0, 1, |_| true).samples.is_empty());
    }
}
