//! Many points in many muscles' fields: many points at a time through every segment, which the compiler makes vector
//! instructions of.

use super::{
    AxisPoint, MuscleFrame,
    evaluate::{FARTHEST, Segment, evaluate_near, unkeyed},
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

/// Points that one thread of the kernel takes.
pub const POINTS_PER_THREAD: usize = 16;

/// Points that go through an axis together.
const LANES: usize = 64;
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

/// Some points, and the largest field seen at each.
struct Block {
    x: Lanes,
    y: Lanes,
    z: Lanes,
    best: [Sample; LANES],
}

type Lanes = [f32; LANES];

impl Block {
    /// Takes up to as many points as there are lanes; the last one stands for those that are missing.
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
        for (lane, key) in nearest(points, block).into_iter().enumerate() {
            let (segment, squared) = unkeyed(key);
            if squared <= muscle.reach_squared() {
                let sample = evaluate_near(muscle, points, block.point(lane), segment);
                if sample.value > block.best[lane].value {
                    block.best[lane] = sample;
                }
            }
        }
    }
}

/// The key of each point's nearest segment.
///
/// The loop over the lanes is long enough that it stays one, of vector instructions as wide as the processor's.
#[inline(always)]
fn nearest(points: &[AxisPoint], block: &Block) -> Lanes {
    let mut best = [FARTHEST; LANES];
    for (i, ends) in (0..).zip(points.windows(2)) {
        let segment = Segment::new(&ends[0], &ends[1]);
        for (lane, best) in best.iter_mut().enumerate() {
            let key = segment.key(block.x[lane], block.y[lane], block.z[lane], i);
            *best = if key < *best { key } else { *best };
        }
    }
    best
}
