//! How much a folding joint displaces, so that its two groups keep their volume (prototypes 5, the closed loop). Twin of the
//! kernel `track_fold`.

use super::{TrackJoint, TrackParams, Way, point};
use crate::{
    field::{Fold, evaluate::GroupFrame},
    math::transform_point,
    rig::{FoldPatch, FoldTriangle},
};
use glam::Vec4;

/// Share of the missing volume that one pass gives back.
pub(crate) const FOLD_GAIN: f32 = 0.7;
/// Partial sums, in the order of a workgroup's threads: sums of floats depend on it.
pub const FOLD_LANES: u32 = 64;
/// Weight, cubic metres per metre, under which a patch cannot change its volume.
pub(crate) const LEAST_FOLD_WEIGHT: f32 = 1e-9;

/// What [`fold`] reads of a character at a sub-pose.
#[derive(Clone, Copy)]
pub struct FoldInput<'a> {
    /// Joints at the sub-pose.
    pub joints: &'a [TrackJoint],
    /// The skin around every fold.
    pub patches: &'a [FoldPatch],
    /// Triangles of all patches.
    pub triangles: &'a [FoldTriangle],
    /// Positions at rest.
    pub positions_rest: &'a [Vec4],
    /// Positions of the skin.
    pub positions: &'a [Vec4],
}

/// Moves every fold's offset towards the one at which its patch has its volume at rest, in the passes that relax the skin,
/// and sets it in the two groups.
///
/// With o the joint's centre, `V = sum det(a - o, b - o, c - o) / 6` and `s <- clamp(s + .7 (V_rest - V) / sum area A B)`.
pub fn fold(params: &TrackParams, way: &Way, input: &FoldInput, groups: &mut [GroupFrame], offsets: &mut [f32]) {
    let moves = params.projects == 0 && params.sub_pose < way.count;
    for (patch, offset) in input.patches.iter().zip(offsets) {
        let (parent, child) = (patch.parent as usize, patch.child as usize);
        if moves {
            let ends = [&groups[child].fold_start, &groups[parent].fold_end].map(|end| Fold { offset: 1.0, ..*end });
            let (volume, weight) = measure(input, patch, &ends);
            if weight > LEAST_FOLD_WEIGHT {
                let most = groups[child].fold_start.most;
                *offset = (*offset + FOLD_GAIN * (patch.volume_rest - volume) / weight).clamp(0.0, most);
            }
        }
        groups[child].fold_start.offset = *offset;
        groups[parent].fold_end.offset = *offset;
    }
}

/// The patch's volume about its joint, and how much an offset of a metre would add to it to first order.
fn measure(input: &FoldInput, patch: &FoldPatch, ends: &[Fold; 2]) -> (f32, f32) {
    let centre = transform_point(&input.joints[patch.joint as usize].matrix, point(&patch.origin));
    let mut sums = [(0.0f32, 0.0f32); FOLD_LANES as usize];
    let triangles = &input.triangles[patch.begin as usize..patch.end as usize];
    for (k, triangle) in triangles.iter().enumerate() {
        let corners = [triangle.a, triangle.b, triangle.c].map(|v| v as usize);
        let [a, b, c] = corners.map(|v| point(&input.positions[v]) - centre);
        let [p, q, r] = corners.map(|v| point(&input.positions_rest[v]));
        let across = (b - a).cross(c - a);
        let area = 0.5 * across.dot(across).sqrt();
        let (lift, _) = ends[triangle.of_parent as usize].lift((p + q + r) * (1.0 / 3.0));
        let sum = &mut sums[k % FOLD_LANES as usize];
        *sum = (sum.0 + a.dot(b.cross(c)) * (1.0 / 6.0), sum.1 - area * lift);
    }
    let mut half = FOLD_LANES as usize / 2;
    while half > 0 {
        for lane in 0..half {
            let (a, b) = (sums[lane], sums[lane + half]);
            sums[lane] = (a.0 + b.0, a.1 + b.1);
        }
        half /= 2;
    }
    sums[0]
}
