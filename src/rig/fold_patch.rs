//! The skin around joints that fold, whose volume the tracker keeps.

use super::{Rig, SkinGraph};
use glam::{DVec3, Vec4};

crate::gpu_struct! {
    /// The skin of two groups that fold against each other.
    pub struct FoldPatch {
        /// Centre of the joint, metres in scene space at rest; `w` unused.
        pub origin: Vec4,
        /// The joint.
        pub joint: u32,
        /// The group above.
        pub parent: u32,
        /// The group below.
        pub child: u32,
        /// Where the patch's triangles begin.
        pub begin: u32,
        /// One past its last triangle.
        pub end: u32,
        /// Volume between the patch and the joint's centre at rest, cubic metres.
        pub volume_rest: f32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
    }
}

crate::gpu_struct! {
    /// A triangle of a patch.
    pub struct FoldTriangle {
        /// First corner, the first of its copies.
        pub a: u32,
        /// Second corner.
        pub b: u32,
        /// Third corner.
        pub c: u32,
        /// 1 where the group above owns its first corner.
        pub of_parent: u32,
    }
}

/// The patches of all folds of a rig, and their triangles: those whose corners the two groups own, as far as the
/// bulges go. What is beyond moves with its bone about the joint, so that the open patch keeps its volume as a closed one.
pub(super) fn patches(rig: &Rig, graph: &SkinGraph) -> (Vec<FoldPatch>, Vec<FoldTriangle>) {
    let mut triangles = Vec::new();
    let patch = |fold: &super::groups::FoldRest| {
        let swing = rig.swings.iter().find(|swing| swing.group == fold.child)?;
        let begin = triangles.len() as u32;
        let centre = swing.origin.as_dvec3();
        let mut volume = 0.0;
        for corners in &rig.character.triangles {
            let owners = corners.map(|v| rig.groups.owner[v as usize]);
            if owners.iter().any(|&g| g != fold.parent && g != fold.child) {
                continue;
            }
            let [a, b, c] = corners.map(|v| graph.copy_of[v as usize]);
            let at = |v: u32| -> DVec3 { rig.character.positions_rest[v as usize].as_dvec3() - centre };
            if !fold.reaches(rig.character.positions_rest[a as usize], owners[0] == fold.parent) {
                continue;
            }
            volume += at(a).dot(at(b).cross(at(c))) / 6.0;
            triangles.push(FoldTriangle { a, b, c, of_parent: (owners[0] == fold.parent).into() });
        }
        Some(FoldPatch {
            origin: swing.origin.extend(0.0),
            joint: swing.joint,
            parent: fold.parent,
            child: fold.child,
            begin,
            end: triangles.len() as u32,
            volume_rest: volume as f32,
            ..FoldPatch::default()
        })
    };
    let patches = rig.folds.iter().filter_map(patch).collect();
    (patches, triangles)
}
