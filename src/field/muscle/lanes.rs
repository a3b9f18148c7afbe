//! Many points in many muscles' fields: eight points at a time through every segment, which the compiler makes vector
//! instructions of.

use super::{
    AxisPoint, MuscleFrame,
    evaluate::{evaluate_near, squared_distance},
};
use crate::field::Sample;
use glam::{Vec3, Vec4, Vec4Swizzles};
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

/// Which of the processor's vector instructions are used; the results are the same to the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// What every processor of the architecture has.
    Portable,
    /// AVX2, where the processor has it.
    Fastest,
}

/// What sampling muscles alone reads: one instance's muscles, and the points of their axes.
#[derive(Clone, Copy)]
pub struct UnionInput<'a> {
    /// The muscles, in one common space.
    pub muscles: &'a [MuscleFrame],
    /// Points of all of their axes.
    pub axes: &'a [AxisPoint],
    /// Whether gradients are wanted.
    pub gradients: bool,
}

/// The largest of many muscles' fields at many points: gradient in `xyz` where it is wanted, value in `w`. Twin of the
/// kernel `muscle_sample`.
///
/// Points are in the muscles' own space; `samples` has one entry per point. Every segment of every muscle is looked at.
pub fn union(input: &UnionInput, points: &[Vec4], samples: &mut [Vec4]) {
    union_with(Instructions::Fastest, input, points, samples);
}

/// [`union`] with given instructions, for comparing them.
pub fn union_with(instructions: Instructions, input: &UnionInput, points: &[Vec4], samples: &mut [Vec4]) {
    let best_of = best_of_block(instructions);
    samples.par_chunks_mut(PIECE).zip(points.par_chunks(PIECE)).for_each(|(samples, points)| {
        for (samples, points) in samples.chunks_mut(LANES).zip(points.chunks(LANES)) {
            let mut block = Block::new(points);
            best_of(input, &mut block);
            for (sample, best) in samples.iter_mut().zip(&block.best) {
                *sample = if input.gradients { best.gradient } else { Vec3::ZERO }.extend(best.value);
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

fn best_of_block(instructions: Instructions) -> fn(&UnionInput, &mut Block) {
    #[cfg(target_arch = "x86_64")]
    if instructions == Instructions::Fastest && std::arch::is_x86_feature_detected!("avx2") {
        #[allow(unsafe_code, reason = "the one instruction set that the call needs was found on this processor")]
        // SAFETY: AVX2 has just been detected.
        return |input, block| unsafe { best_of_block_avx2(input, block) };
    }
    let _ = instructions;
    best_of_block_portable
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn best_of_block_avx2(input: &UnionInput, block: &mut Block) {
    best_of_block_portable(input, block);
}

#[inline(always)]
fn best_of_block_portable(input: &UnionInput, block: &mut Block) {
    for muscle in input.muscles.iter().filter(|m| m.present != 0) {
        let points = muscle.points(input.axes);
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
    let mut before: [Vec3; LANES] = std::array::from_fn(|lane| block.point(lane) - points[0].position.xyz());
    for (i, point) in (0..).zip(&points[1..]) {
        for lane in 0..LANES {
            let after = block.point(lane) - point.position.xyz();
            let squared = squared_distance(before[lane], after, point.position.w);
            let closer = squared < best[lane];
            best[lane] = if closer { squared } else { best[lane] };
            found[lane] = if closer { i } else { found[lane] };
            before[lane] = after;
        }
    }
    (found, best)
}
