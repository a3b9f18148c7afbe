//! Comparing what the GPU computed with what its CPU twin computed.
//!
//! The two sides have types of their own, so that a result cannot be compared with itself. Tolerances stand here,
//! each with its reason.

#[cfg(feature = "gpu")]
mod capture;

#[cfg(feature = "gpu")]
pub use capture::capture;

use crate::{
    dynamics::Particle,
    field::muscle::{AxisPoint, MuscleFrame},
    reference::Trace,
    tracking::{StopReason, Track},
};
use glam::{Vec2, Vec4, Vec4Swizzles};
use serde::Serialize;

/// What came from the GPU.
#[derive(Clone, Debug, Default)]
pub struct GpuResult {
    /// Geometrically skinned positions.
    pub skinned: Vec<Vec4>,
    /// Muscles as shaped.
    pub muscles: Vec<MuscleFrame>,
    /// Points of the muscles' axes.
    pub axes: Vec<AxisPoint>,
    /// Points of the muscles in motion; empty without dynamics.
    pub particles: Vec<Particle>,
    /// Tracked positions, or those displaced to muscles; empty without either.
    pub tracked: Vec<Vec4>,
    /// What the tracker keeps of every vertex; empty without it.
    pub tracks: Vec<Track>,
    /// Output vertices: position and normal.
    pub vertices: Vec<[f32; 6]>,
}

/// What came from the CPU reference.
#[derive(Clone, Copy, Debug)]
pub struct CpuResult<'a>(pub &'a Trace);

/// How far apart one stage may be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tolerance {
    /// Largest absolute difference.
    pub absolute: f32,
    /// Share of the items that may be over it.
    pub share_over: f32,
}

/// Positions after geometric skinning, in heights of the character. Both sides do the same sums in f32; a driver may
/// fuse multiplications and additions (naga emits no NoContraction), which moves a sum of four products of the
/// order of a height by a few units in its last place: 2^-24 x 16.
pub const SKINNED: Tolerance = Tolerance { absolute: 1e-6, share_over: 0.0 };
/// Muscle frames: lengths in heights, directions and widths as they are; one division and two square roots more than
/// skinning, each good to an ulp or two.
pub const MUSCLES: Tolerance = Tolerance { absolute: 2e-6, share_over: 0.0 };
/// Points of axes that follow their paths. Round an obstacle they go through its frame and back, and two arc sines of 1e-6;
/// normals turn with the plane of segments a thirtieth of the length, which magnifies that.
pub const AXES: Tolerance = Tolerance { absolute: 1e-5, share_over: 0.0 };
/// Joints of a substep: entries of matrices up to 1 as they are, beyond as a share of the largest one. The inverse of a
/// joint divides sums of products by its volume, 0.2 and more here, and the change through it multiplies the error once
/// more: 2^-24 x 16 x 4.
pub const MOVED_JOINTS: Tolerance = Tolerance { absolute: 4e-6, share_over: 0.0 };
/// Predicted particles and iterates, as they are up to 1 and as a share beyond: two points carried by matrices, a square
/// root and a division for the radius, and Young's factor, whose root of a difference from 1 magnifies its error tenfold.
pub const PREDICTED: Tolerance = Tolerance { absolute: 4e-6, share_over: 0.0 };
/// Places after one outer iteration, and displacements of its substep, in lengths of the muscle: ten projections of every
/// constraint of a stable system, each good to 2^-24 of coordinates of the order of 2 m, ten times a muscle's length.
pub const PROJECTED: Tolerance = Tolerance { absolute: 1e-5, share_over: 0.0 };
/// Particles of a frame, in lengths of their muscle. Against bones and the skin a rounding error stays one: a nudge of 1e-7 m
/// is no more than 2e-6 of a length in any of the 120 frames after it. Contacts between muscles pass it on and magnify it
/// by up to ten a frame, since which muscle gives way depends on the last bit where many of them are pressed together:
/// there [`TOUCHING`] holds.
pub const PARTICLES: Tolerance = Tolerance { absolute: 1e-5, share_over: 0.0 };
/// Particles of a frame whose muscles are pressed against each other: a plane between two of them follows or stays by the
/// last bit, and has half a millimetre of play, 5e-3 of the shortest muscles' length.
pub const TOUCHING: Tolerance = Tolerance { absolute: 5e-3, share_over: 0.0 };
/// Particles of such muscles after 120 frames by themselves: ten times that.
pub const TOUCHING_DRIFT: Tolerance = Tolerance { absolute: 5e-2, share_over: 0.0 };
/// Muscles as shaped from such particles, whose axes' lengths and boxes move by a share of the play, which is 3e-4 of a
/// character's height.
pub const TOUCHING_MUSCLES: Tolerance = Tolerance { absolute: 3e-4, share_over: 0.0 };
/// Axes of such muscles: one point in a hundred may be over [`MOVING_AXES`].
pub const TOUCHING_AXES: Tolerance = Tolerance { absolute: 6e-3, share_over: 1e-2 };
/// Axes of muscles in motion. Tangents are differences of particles a thirtieth of the length apart, each within
/// [`PARTICLES`]: 1e-5 x 2 x 30. Normals turn with the plane of two segments, which may turn by .05 only: 20 times that,
/// in the worst case; half of it here.
pub const MOVING_AXES: Tolerance = Tolerance { absolute: 6e-3, share_over: 0.0 };
/// Marched positions, in heights. A vertex stops within a field difference of 1e-4, and where one side takes a step
/// more than the other they end up to 1e-4 of a support radius apart, 5e-6 of a height. At a pit, where vertices
/// stop on a ridge of the maximum, the step before decides: a thousandth of the vertices may be over.
pub const TRACKED: Tolerance = Tolerance { absolute: 1e-5, share_over: 1e-3 };
/// Normals, unit vectors: differences of neighbouring positions magnify the positions' error by an edge's share of
/// the height, about a hundredfold; the vertices that TRACKED lets off take their neighbours with them.
pub const NORMALS: Tolerance = Tolerance { absolute: 2e-3, share_over: 6e-3 };
/// Share of march reports whose stop reason must agree.
pub const STOP_AGREEMENT: f32 = 0.999;

/// One stage compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageReport {
    /// The stage.
    pub stage: &'static str,
    /// Items compared.
    pub items: usize,
    /// Largest absolute difference, in the tolerance's unit.
    pub max_absolute: f32,
    /// Largest difference over the larger magnitude of the two.
    pub max_relative: f32,
    /// Items over the absolute tolerance.
    pub over: usize,
    /// Index of the item that differs most.
    pub worst: Option<usize>,
    /// Share of equal stop reasons, for the march.
    pub stop_agreement: Option<f32>,
    /// The tolerance that it was held against.
    pub tolerance: Tolerance,
    /// Whether it was met.
    pub pass: bool,
}

impl StageReport {
    /// Puts several frames' reports of one stage together: worst figures, summed counts.
    pub fn merge(&mut self, other: &StageReport) {
        if other.max_absolute > self.max_absolute || other.max_absolute.is_nan() {
            self.max_absolute = other.max_absolute;
            self.worst = other.worst;
        }
        self.max_relative = self.max_relative.max(other.max_relative);
        if other.tolerance.absolute > self.tolerance.absolute {
            self.tolerance = other.tolerance;
        }
        self.items += other.items;
        self.over += other.over;
        self.stop_agreement = match (self.stop_agreement, other.stop_agreement) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        self.pass &= other.pass;
    }
}

/// Compares every stage that the reference played. `height` is the character's, metres.
pub fn compare(gpu: &GpuResult, cpu: CpuResult, height: f32) -> Vec<StageReport> {
    let trace = cpu.0;
    let unit = if height > 0.0 { 1.0 / height } else { 1.0 };
    let mut stages = vec![vectors("skinned", &gpu.skinned, &trace.skinned, unit, SKINNED)];
    let [of_muscles, of_axes, of_particles] = match trace.particles.as_slice() {
        [] => [MUSCLES, AXES, PARTICLES],
        moving if !touching(moving) => [MUSCLES, MOVING_AXES, PARTICLES],
        _ => [TOUCHING_MUSCLES, TOUCHING_AXES, TOUCHING],
    };
    if !trace.muscles.is_empty() {
        stages.push(muscles(&gpu.muscles, &trace.muscles, unit, of_muscles));
        stages.push(axes(&gpu.axes, &trace.axes, unit, of_axes));
    }
    if !trace.particles.is_empty() {
        stages.push(particles(gpu, trace, of_particles));
    }
    if !trace.tracked.is_empty() {
        let stage = if trace.tracks.is_empty() { "displaced" } else { "tracked" };
        let mut report = vectors(stage, &gpu.tracked, &trace.tracked, unit, TRACKED);
        if !trace.tracks.is_empty() || !gpu.tracks.is_empty() {
            let agreement = stop_agreement(&gpu.tracks, &trace.tracks);
            report.stop_agreement = Some(agreement);
            report.pass &= agreement >= STOP_AGREEMENT;
        }
        stages.push(report);
    }
    let positions: Vec<Vec4> = gpu.vertices.iter().map(|v| Vec4::new(v[0], v[1], v[2], 1.0)).collect();
    let normals: Vec<Vec4> = gpu.vertices.iter().map(|v| Vec4::new(v[3], v[4], v[5], 0.0)).collect();
    let last = if trace.tracked.is_empty() { SKINNED } else { TRACKED };
    stages.push(vectors("output positions", &positions, trace.positions(), unit, last));
    stages.push(vectors("output normals", &normals, &trace.normals, 1.0, NORMALS));
    stages
}

/// Whether muscles press on one another: some particle is held off another muscle. [`TOUCHING`] says what comes of it.
pub fn touching(particles: &[Particle]) -> bool {
    particles.iter().any(|p| p.pushes.xy() != Vec2::ZERO)
}

/// Compares two lists of vectors by distance.
pub fn vectors(stage: &'static str, gpu: &[Vec4], cpu: &[Vec4], unit: f32, tolerance: Tolerance) -> StageReport {
    let pairs = gpu.iter().zip(cpu).map(|(g, c)| {
        let size = g.xyz().length().max(c.xyz().length()) * unit;
        ((g.xyz() - c.xyz()).length() * unit, size)
    });
    measure(stage, gpu.len(), cpu.len(), pairs, tolerance)
}

fn muscles(gpu: &[MuscleFrame], cpu: &[MuscleFrame], unit: f32, tolerance: Tolerance) -> StageReport {
    let pairs = gpu.iter().zip(cpu).map(|(g, c)| {
        let lengths = [
            (g.length - c.length).abs(),
            (g.width - c.width).abs(),
            (g.support_radius - c.support_radius).abs(),
            (g.lowest.xyz() - c.lowest.xyz()).length(),
            (g.highest.xyz() - c.highest.xyz()).length(),
        ];
        let numbers = (g.activation - c.activation).abs().max((g.factors - c.factors).abs().max_element());
        let same = (g.exponents, g.terms, g.segments, g.present) == (c.exponents, c.terms, c.segments, c.present);
        let difference = lengths.iter().fold(numbers, |a, &b| a.max(b * unit));
        (if same { difference } else { f32::INFINITY }, 1.0)
    });
    measure("muscles", gpu.len(), cpu.len(), pairs, tolerance)
}

fn axes(gpu: &[AxisPoint], cpu: &[AxisPoint], unit: f32, tolerance: Tolerance) -> StageReport {
    let pairs = gpu.iter().zip(cpu).map(|(g, c)| {
        let moved = (g.position.xyz() - c.position.xyz()).length().max((g.turn.w - c.turn.w).abs());
        let turned = (g.tangent.xyz() - c.tangent.xyz()).length().max((g.normal.xyz() - c.normal.xyz()).length());
        ((moved * unit).max(turned).max((g.normal.w - c.normal.w).abs()), 1.0)
    });
    measure("muscle axes", gpu.len(), cpu.len(), pairs, tolerance)
}

/// Compares the places of particles, in lengths of their muscle at the frame.
pub fn particles(gpu: &GpuResult, trace: &Trace, tolerance: Tolerance) -> StageReport {
    let points = |m: &MuscleFrame| (m.length.max(LEAST_LENGTH), m.segments as usize + 1);
    let lengths = trace.muscles.iter().map(points).flat_map(|(length, count)| std::iter::repeat_n(length, count));
    let pairs = gpu.particles.iter().zip(&trace.particles).zip(lengths).map(|((g, c), length)| {
        let size = g.position.xyz().length().max(c.position.xyz().length());
        ((g.position.xyz() - c.position.xyz()).length() / length, size / length)
    });
    measure("particles", gpu.particles.len(), trace.particles.len(), pairs, tolerance)
}

/// Length, metres, that a muscle without one is taken to have.
const LEAST_LENGTH: f32 = 1e-3;

/// Share of vertices that stopped for the same reason on both sides.
fn stop_agreement(gpu: &[Track], cpu: &[Track]) -> f32 {
    if gpu.len() != cpu.len() {
        return 0.0;
    }
    let same = gpu.iter().zip(cpu).filter(|(g, c)| g.stop == c.stop).count();
    if cpu.is_empty() { 1.0 } else { same as f32 / cpu.len() as f32 }
}

fn measure(
    stage: &'static str,
    gpu_items: usize,
    cpu_items: usize,
    pairs: impl Iterator<Item = (f32, f32)>,
    tolerance: Tolerance,
) -> StageReport {
    let mut report = StageReport {
        stage,
        items: cpu_items,
        max_absolute: 0.0,
        max_relative: 0.0,
        over: 0,
        worst: None,
        stop_agreement: None,
        tolerance,
        pass: false,
    };
    for (index, (difference, size)) in pairs.enumerate() {
        // A difference that is not a number is the largest of all.
        let difference = if difference.is_nan() { f32::INFINITY } else { difference };
        if difference > report.max_absolute || report.worst.is_none() {
            report.max_absolute = difference;
            report.worst = Some(index);
        }
        if size > 0.0 {
            report.max_relative = report.max_relative.max(difference / size);
        }
        report.over += usize::from(difference > tolerance.absolute);
    }
    report.pass = gpu_items == cpu_items && report.over as f32 <= tolerance.share_over * cpu_items as f32;
    report
}

/// How many vertices stopped for each reason.
pub fn stop_counts(tracks: &[Track]) -> Vec<(StopReason, usize)> {
    StopReason::ALL.iter().map(|&r| (r, tracks.iter().filter(|m| m.stop == r as u32).count())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(n: usize) -> Vec<Vec4> {
        (0..n).map(|i| Vec4::new(i as f32, 1.0, -2.0, 1.0)).collect()
    }

    #[test]
    fn equal_lists_pass_and_a_moved_item_is_found() {
        let cpu = line(100);
        let report = vectors("x", &line(100), &cpu, 1.0, SKINNED);
        assert!(report.pass && report.over == 0 && report.max_absolute == 0.0);
        let mut gpu = line(100);
        gpu[37].y += 1e-3;
        let report = vectors("x", &gpu, &cpu, 1.0, SKINNED);
        assert!(!report.pass && report.over == 1 && report.worst == Some(37));
    }

    #[test]
    fn nan_missing_items_and_too_many_over_fail() {
        let cpu = line(1000);
        let mut gpu = line(1000);
        gpu[3].x = f32::NAN;
        assert!(!vectors("x", &gpu, &cpu, 1.0, SKINNED).pass);
        assert!(!vectors("x", &line(999), &cpu, 1.0, SKINNED).pass);
        let mut gpu = line(1000);
        gpu[5].x += 1.0;
        assert!(vectors("x", &gpu, &cpu, 1.0, TRACKED).pass, "one of a thousand is let off");
        gpu[6].x += 1.0;
        assert!(!vectors("x", &gpu, &cpu, 1.0, TRACKED).pass);
    }

    #[test]
    fn another_stop_reason_fails_the_march() {
        let stopped = |stop: u32| vec![Track { stop, ..Track::default() }; 100];
        let trace = Trace {
            steps: Vec::new(),
            skinned: line(100),
            muscles: Vec::new(),
            axes: Vec::new(),
            particles: Vec::new(),
            muscle_joints: Vec::new(),
            tracked: line(100),
            tracks: stopped(1),
            normals: vec![Vec4::Y; 100],
        };
        let vertices: Vec<[f32; 6]> = line(100).iter().map(|p| [p.x, p.y, p.z, 0.0, 1.0, 0.0]).collect();
        let mut gpu =
            GpuResult { skinned: line(100), tracked: line(100), tracks: stopped(1), vertices, ..GpuResult::default() };
        assert!(compare(&gpu, CpuResult(&trace), 1.0).iter().all(|s| s.pass));
        gpu.tracks[7].stop = 3;
        let stages = compare(&gpu, CpuResult(&trace), 1.0);
        assert!(stages.iter().any(|s| s.stage == "tracked" && !s.pass && s.stop_agreement == Some(0.99)));
    }
}
