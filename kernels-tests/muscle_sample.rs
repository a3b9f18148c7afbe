//! `muscle_sample`, muscles alone, against its twin: 20,000 points in 50 muscles of 29 segments, values and gradients.

use crate::support::{JUNK, Random, SIZES, gpu, run};
use glam::{Vec3, Vec4, Vec4Swizzles};
use sinew::{
    field::muscle::{
        self, AxisPoint, Instructions, MuscleFrame, MuscleInput, MuscleRest, Profile, UnionInput, UnionParams,
    },
    parity::{self, Tolerance},
    schedule::KernelId,
};

/// Muscles on curved axes, in a box of a metre.
struct Muscles {
    frames: Vec<MuscleFrame>,
    axes: Vec<AxisPoint>,
}

impl Muscles {
    fn new(count: usize, segments: u32, seed: u64) -> Muscles {
        let mut random = Random(seed);
        let mut muscles = Muscles { frames: Vec::new(), axes: Vec::new() };
        for i in 0..count {
            let (start, along, aside) = (random.vec3() * 0.4, random.vec3().normalize() * 0.3, random.vec3() * 0.1);
            let first = muscles.axes.len();
            muscles.axes.extend((0..=segments).map(|k| {
                let share = k as f32 / segments as f32;
                let p = start + along * share + aside * (4.0 * share * (1.0 - share));
                AxisPoint { position: p.extend(0.0), ..AxisPoint::default() }
            }));
            let share = i as f32 / count as f32;
            let profile = Profile::blend(&[((2 + i as u32 % 4, 3), 1.0 - share), ((4, 7), share)]);
            let profile = Profile { shift: [0.0, 0.15, -0.2][i % 3], ..profile };
            let input = MuscleInput::new(&profile, 0.8 * share);
            let rest = MuscleRest {
                origin: start.extend(3e-4),
                insertion: Vec3::ZERO.extend(0.02),
                segments,
                first_point: first as u32,
                ..MuscleRest::default()
            };
            let normals = (random.vec3(), random.vec3());
            muscles.frames.push(muscle::shape(&rest, &input, &mut muscles.axes[first..], normals.0, normals.1));
        }
        muscles
    }

    fn cpu(&self, points: &[Vec4], gradients: bool) -> Vec<Vec4> {
        let mut samples = vec![Vec4::NAN; points.len()];
        let input = UnionInput { muscles: &self.frames, axes: &self.axes, gradients };
        muscle::union(&input, points, &mut samples);
        let mut portable = vec![Vec4::NAN; points.len()];
        muscle::union_with(Instructions::Portable, &input, points, &mut portable);
        assert_eq!(samples, portable, "instructions make a difference");
        samples
    }

    fn gpu(&self, points: &[Vec4], gradients: bool) -> Option<Vec<Vec4>> {
        let gpu = gpu()?;
        let count = points.len();
        let params = UnionParams {
            point_count: count as u32,
            muscle_count: self.frames.len() as u32,
            gradients: gradients.into(),
            pad_0: 0,
        };
        let inputs: [(&str, &[u8]); 4] = [
            ("params", bytemuck::bytes_of(&params)),
            ("muscles", bytemuck::cast_slice(&self.frames)),
            ("axes", bytemuck::cast_slice(&self.axes)),
            ("points", bytemuck::cast_slice(points)),
        ];
        let out = run(
            &gpu,
            KernelId::MuscleSample,
            count.div_ceil(muscle::POINTS_PER_THREAD) as u64,
            &inputs,
            &[("samples", (count + 1) * 16)],
        );
        let mut samples: Vec<Vec4> = bytemuck::pod_collect_to_vec(&out[0]);
        assert_eq!(samples.pop().map(|s| s.x.to_bits()), Some(JUNK), "written beyond the last point");
        Some(samples)
    }

    /// Points in and about the muscles: half of them near an axis.
    fn points(&self, count: usize, seed: u64) -> Vec<Vec4> {
        let mut random = Random(seed);
        let point = |i: usize| {
            let spread = random.vec3();
            if i.is_multiple_of(2) {
                return (spread * 0.6).extend(1.0);
            }
            let at = self.axes[(i * 7919) % self.axes.len()].position.xyz();
            (at + spread * 0.03).extend(1.0)
        };
        (0..count).map(point).collect()
    }
}

fn values(samples: &[Vec4]) -> Vec<Vec4> {
    samples.iter().map(|s| Vec4::new(s.w, 0.0, 0.0, 0.0)).collect()
}

/// Both sides do the same f32 operations in the same order; a driver may fuse some, which moves a distance of 1 m by
/// some 1e-7, and the value by its slope of at most 50 per metre times that.
const VALUE: Tolerance = Tolerance { absolute: 2e-5, share_over: 0.0 };
/// Gradients in units of 50 per metre. Where two segments or two muscles tie, rounding decides whose gradient counts.
const GRADIENT: Tolerance = Tolerance { absolute: 1e-4, share_over: 1e-3 };

#[test]
fn matches_its_twin_at_every_size() {
    let muscles = Muscles::new(50, 29, 71);
    for size in SIZES.into_iter().chain([20_000]) {
        let points = muscles.points(size, 72);
        for gradients in [true, false] {
            let Some(gpu) = muscles.gpu(&points, gradients) else { return };
            let cpu = muscles.cpu(&points, gradients);
            let inside = cpu.iter().filter(|s| s.w > 0.5).count();
            assert!(size < 1000 || inside * 10 > size, "only {inside} points inside");
            let report = parity::vectors("values", &values(&gpu), &values(&cpu), 1.0, VALUE);
            assert!(report.pass, "size {size}: {report:?}");
            let report = parity::vectors("gradients", &gpu, &cpu, 0.02, GRADIENT);
            assert!(report.pass, "size {size}: {report:?}");
            assert!(gradients || gpu.iter().all(|s| s.xyz() == Vec3::ZERO));
        }
    }
}

#[test]
fn a_muscle_moved_by_a_tenth_of_a_millimetre_is_found() {
    let muscles = Muscles::new(50, 29, 71);
    let points = muscles.points(20_000, 72);
    let Some(gpu) = muscles.gpu(&points, true) else { return };
    let mut moved = Muscles::new(50, 29, 71);
    let first = moved.frames[7].first_point as usize;
    moved.axes[first..first + 30].iter_mut().for_each(|p| p.position.x += 1e-4);
    let cpu = moved.cpu(&points, true);
    assert!(!parity::vectors("values", &values(&gpu), &values(&cpu), 1.0, VALUE).pass);
    assert!(!parity::vectors("gradients", &gpu, &cpu, 0.02, GRADIENT).pass);
}

#[test]
fn twin_in_lanes_is_the_field_point_by_point_to_the_bit() {
    for segments in [3, 29, 63] {
        let muscles = Muscles::new(9, segments, 73);
        let points = muscles.points(1001, 74);
        let fast = muscles.cpu(&points, true);
        let mut differs = 0;
        for (p, fast) in points.iter().zip(&fast) {
            let plain = muscles.frames.iter().map(|m| muscle::evaluate(m, m.points(&muscles.axes), p.xyz()));
            let best = plain.fold(sinew::field::Sample::default(), |a, b| if b.value > a.value { b } else { a });
            assert_eq!(best.gradient.extend(best.value), *fast, "{p}");
            let other = muscle::evaluate(&muscles.frames[0], muscles.frames[0].points(&muscles.axes), p.xyz());
            differs += usize::from(other.value != fast.w);
        }
        assert!(differs > 100, "one muscle alone must be seen: {differs}");
    }
}
