//! Many points in many muscles' fields: eight points at a time through every segment, which the compiler makes vector
//! instructions of.

use super::{
    AxisPoint, MuscleFrame,
    evaluate::{evaluate_near, squared_distance},
};
use crate::field::Sample;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

crate::gpu_struct! {
    /// What sampling muscles alone needs.
    pub struct UnionParams {
        /// Points.
        pub point_count: u32,
        /// Muscles.
        pub muscle_count: u32,
        /// 1 where gradients are wanted.
        pub gradients: u32,
        /// Unused.
        pub pad_0: u32,
    }
}

/// Points that go through an axis together.
const LANES: usize = 8;
/// Points of one piece of work.
const PIECE: usize = 256;

/// The largest of many muscles' fields at many points: gradient in `xyz`, value in `w`. Without `gradients` `xyz` is 0.
/// Twin of the kernel `muscle_sample`.
///
/// Points are in the muscles' own space; `axes` holds the axis points of all of them. `samples` has one entry per
/// point. Every segment of every muscle is looked at.
pub fn union(muscles: &[MuscleFrame], axes: &[AxisPoint], points: &[Vec4], gradients: bool, samples: &mut [Vec4]) {
    let scale = if gradients { 1.0 } else { 0.0 };
    samples.par_chunks_mut(PIECE).zip(points.par_chunks(PIECE)).for_each(|(samples, points)| {
        for (samples, points) in samples.chunks_mut(LANES).zip(points.chunks(LANES)) {
            let mut block = Block::new(points);
            best_of_block(muscles, axes, &mut block);
            for (sample, best) in samples.iter_mut().zip(&block.best) {
                *sample = (best.gradient * scale).extend(best.value);
            }
        }
    });
}

/// Eight points, and the largest field seen at each.
struct Block {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    best: [Sample; LANES],
}

impl Block {
    /// Takes up to eight points; the last one stands for those that are missing.
    fn new(points: &[Vec4]) -> Block {
        let at = |lane: usize| points[lane.min(points.len() - 1)];
        Block {
            x: std::array::from_fn(|lane| at(lane).x),
            y: std::array::from_fn(|lane| at(lane).y),
            z: std::array::from_fn(|lane| at(lane).z),
            best: [Sample::default(); LANES],
        }
    }

    fn point(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }
}

fn best_of_block(muscles: &[MuscleFrame], axes: &[AxisPoint], block: &mut Block) {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        #[allow(unsafe_code, reason = "the one instruction set that the call needs was found on this processor")]
        // SAFETY: AVX2 has just been detected.
        return unsafe { best_of_block_avx2(muscles, axes, block) };
    }
    best_of_block_portable(muscles, axes, block);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn best_of_block_avx2(muscles: &[MuscleFrame], axes: &[AxisPoint], block: &mut Block) {
    best_of_block_portable(muscles, axes, block);
}

#[inline(always)]
fn best_of_block_portable(muscles: &[MuscleFrame], axes: &[AxisPoint], block: &mut Block) {
    for muscle in muscles.iter().filter(|m| m.present != 0) {
        let points = muscle.points(axes);
        let (segments, squared) = nearest(points, block);
        for lane in 0..LANES {
            if squared[lane] <= muscle.reach_squared() {
                let sample = evaluate_near(muscle, points, block.point(lane), segments[lane] as usize);
                if sample.value > block.best[lane].value {
                    block.best[lane] = sample;
                }
            }
        }
    }
}

/// The nearest segment of each point, and the squared distance to it.
#[inline(always)]
fn nearest(points: &[AxisPoint], block: &Block) -> ([u32; LANES], [f32; LANES]) {
    let mut found = [0; LANES];
    let mut best = [f32::INFINITY; LANES];
    for (i, point) in (0..).zip(&points[..points.len() - 1]) {
        for lane in 0..LANES {
            let squared = squared_distance(point, block.point(lane));
            let closer = squared < best[lane];
            best[lane] = if closer { squared } else { best[lane] };
            found[lane] = if closer { i } else { found[lane] };
        }
    }
    (found, best)
}
