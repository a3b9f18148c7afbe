//! One muscle's inner iterations: springs along the axis and planes that its particles may not pass.

use super::DynamicsParams;
use glam::{Vec3, Vec4, Vec4Swizzles};

/// Most points of an axis.
pub(super) const MOST: usize = crate::field::muscle::axis::MAX_SEGMENTS as usize + 1;
/// Share of an averaged constraint that counts: over-relaxed by 1.5, and every moving particle has two (background 4.4).
pub(crate) const JACOBI_SHARE: f32 = 0.75;
/// Lengths under which a segment has no direction, metres.
pub(crate) const NO_DIRECTION: f32 = 1e-9;
/// Kinds of contact, in the order in which they are projected: the last one wins.
pub(super) const KINDS: usize = 4;

/// A half space that a particle stays in: `n . p >= w`; the zero normal is no plane.
pub(super) type Plane = Vec4;

/// One muscle while it is projected.
pub(super) struct Chain {
    /// Number of points.
    pub points: usize,
    /// Positions.
    pub at: [Vec3; MOST],
    /// One over the masses, 1/kg.
    pub mobility: [f32; MOST],
    /// Masses, kg; 0 where nothing moves the particle.
    pub mass: [f32; MOST],
    /// Rest length of the segment that begins at a point, metres.
    pub rest: [f32; MOST],
    /// Factor on its projection, kg: one over mobilities and compliance, or the paper's k over the mobilities.
    pub gain: [f32; MOST],
    /// 1 where a segment knows what it has pulled already, 0 in `pbd` mode, where each projection starts anew.
    pub memory: f32,
    /// Its multiplier, kg m.
    pub pull: [Vec3; MOST],
    /// Planes of each particle: two muscles, bone, skin.
    pub planes: [[Plane; KINDS]; MOST],
    /// Their multipliers, kg m.
    pub pushes: [[f32; KINDS]; MOST],
}

impl Chain {
    /// An empty chain.
    pub fn new(points: usize) -> Chain {
        Chain {
            points,
            at: [Vec3::ZERO; MOST],
            mobility: [0.0; MOST],
            mass: [0.0; MOST],
            rest: [0.0; MOST],
            gain: [0.0; MOST],
            memory: 1.0,
            pull: [Vec3::ZERO; MOST],
            planes: [[Vec4::ZERO; KINDS]; MOST],
            pushes: [[0.0; KINDS]; MOST],
        }
    }

    /// Runs the inner iterations, after `done` of earlier outer iterations of the substep. `radius_squared` is the square
    /// of the spectral radius of Jacobi's sweeps.
    ///
    /// Sweeps in two colours are over-relaxed by the cyclic Chebyshev method, whose factor grows from 1 to the best one
    /// from half sweep to half sweep, so that no error grows on the way (Varga, Matrix Iterative Analysis, section 5.3).
    pub fn iterate(&mut self, params: &DynamicsParams, radius_squared: f32, done: u32) {
        let mut relaxation = 1.0;
        for _ in 0..2 * done {
            relaxation = next_relaxation(relaxation, radius_squared);
        }
        for _ in 0..params.inner {
            if params.jacobi != 0 {
                self.averaged();
                continue;
            }
            for first in [0, 1] {
                self.sweep(first, relaxation);
                relaxation = next_relaxation(relaxation, radius_squared);
            }
            for i in 1..self.points - 1 {
                self.hold(i);
            }
        }
    }

    /// How much a segment's multiplier changes: to the tension that it would have alone, with everything else as it is.
    /// Without its own pull its span would be `e`, and along `e` lies the pull that solves it: exactly, and so that the
    /// energy falls.
    #[inline]
    fn change(&self, j: usize) -> Vec3 {
        let mobility = self.mobility[j] + self.mobility[j + 1];
        let e = self.at[j + 1] - self.at[j] - self.pull[j] * mobility;
        let length = e.length();
        if length < NO_DIRECTION {
            return self.pull[j];
        }
        e * ((length - self.rest[j]) * self.gain[j] / length) + self.pull[j]
    }

    /// Projects every second segment, from `first` on: no two of them share a particle.
    fn sweep(&mut self, first: usize, relaxation: f32) {
        for j in (first..self.points - 1).step_by(2) {
            let change = self.change(j) * relaxation;
            self.pull[j] -= change * self.memory;
            self.at[j] += change * self.mobility[j];
            self.at[j + 1] -= change * self.mobility[j + 1];
        }
    }

    /// The multiplier that a plane has after its projection; less than nothing it cannot have.
    #[inline]
    fn next_push(&self, i: usize, kind: usize, depth: f32) -> f32 {
        (self.pushes[i][kind] + depth * self.mass[i]).max(0.0)
    }

    /// Projects a particle on its planes, one after the other. A plane takes back what it pushed too far, and never pulls.
    #[inline]
    fn hold(&mut self, i: usize) {
        for kind in 0..KINDS {
            let plane = self.planes[i][kind];
            let depth = plane.w - plane.xyz().dot(self.at[i]);
            let push = self.next_push(i, kind, depth);
            self.at[i] += plane.xyz() * ((push - self.pushes[i][kind]) * self.mobility[i]);
            self.pushes[i][kind] = push;
        }
    }

    /// Projects all segments from the same state, then all planes of a particle from the same state, each kind averaged
    /// by its own count: every moving particle has two segments (background 4.4).
    fn averaged(&mut self) {
        let mut changes = [Vec3::ZERO; MOST];
        for (j, change) in changes.iter_mut().enumerate().take(self.points - 1) {
            *change = self.change(j) * JACOBI_SHARE;
        }
        for i in 0..self.points {
            let before = if i > 0 { changes[i - 1] } else { Vec3::ZERO };
            let after = if i < self.points - 1 { changes[i] } else { Vec3::ZERO };
            self.pull[i] -= after * self.memory;
            self.at[i] += (after - before) * self.mobility[i];
        }
        for i in 1..self.points - 1 {
            let mut pushes = self.pushes[i];
            let mut count = 0.0;
            for (kind, push) in pushes.iter_mut().enumerate() {
                let plane = self.planes[i][kind];
                let depth = plane.w - plane.xyz().dot(self.at[i]);
                let next = self.next_push(i, kind, depth);
                count += if next != *push { 1.0 } else { 0.0 };
                *push = next;
            }
            let mut moved = Vec3::ZERO;
            for (kind, next) in pushes.iter().enumerate() {
                let change = if count > 0.0 { (next - self.pushes[i][kind]) / count } else { 0.0 };
                moved += self.planes[i][kind].xyz() * (change * self.mobility[i]);
                self.pushes[i][kind] += change;
            }
            self.at[i] += moved;
        }
    }
}

/// The factor of the next half sweep; after the first one, of factor 1, it is `1 / (1 - radius^2 / 2)`.
#[inline]
fn next_relaxation(relaxation: f32, radius_squared: f32) -> f32 {
    let share = if relaxation == 1.0 { 0.5 } else { 0.25 * relaxation };
    1.0 / (1.0 - radius_squared * share)
}

/// The plane through `place` that keeps everything on the side of `normal`, a unit vector, where `place` has the
/// constraint's value `distance`, metres, which is to be 0 at least.
#[inline]
pub(super) fn plane(place: Vec3, normal: Vec3, distance: f32) -> Plane {
    normal.extend(normal.dot(place) - distance)
}
