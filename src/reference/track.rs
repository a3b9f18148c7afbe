//! The tracker's steps of a schedule.

use super::{Reference, Trace, counts};
use crate::{
    field::{bound::bound, evaluate::Place},
    schedule::{FrameOptions, KernelId, Positions, Step},
    tracking::{self, AverageInput, CarryInput, FieldInput, FoldInput, RelaxInput, Skin, SubPose, TrackParams, Way},
};
use glam::Vec4;

/// What the tracker holds during one frame.
#[derive(Default)]
pub(super) struct UnderWay {
    pub way: Way,
    pub sub_poses: Vec<SubPose>,
    /// The pose itself, where the skin is in it already.
    pub still: SubPose,
    pub slid: Vec<Vec4>,
    pub spans: Vec<Vec4>,
}

impl Reference<'_> {
    /// Plays one step of the tracker.
    pub(super) fn track(
        &self,
        step: &Step,
        options: &FrameOptions,
        skin: &mut Skin,
        under_way: &mut UnderWay,
        trace: &mut Trace,
    ) {
        let rig = self.rig;
        let targets = &rig.targets;
        let params = TrackParams::new(&counts(rig), 1, &options.track, step.sub_pose, step.projects);
        let UnderWay { way, sub_poses, still, slid, spans } = under_way;
        if step.kernel == KernelId::GroupBound {
            sub_poses.iter_mut().chain([still]).for_each(|at| bound(&mut at.groups, &trace.muscles));
            return;
        }
        let sub_pose = match sub_poses.iter_mut().rev().nth(step.sub_pose as usize) {
            Some(sub_pose) => sub_pose,
            None => still,
        };
        let relax =
            RelaxInput { targets: &targets.vertices, edges: &rig.graph.edges, positions_rest: &rig.positions_rest };
        match step.kernel {
            KernelId::TrackStart => tracking::start(way, &trace.skinned, &mut skin.positions, &mut skin.tracks),
            KernelId::TrackPlace if step.sub_pose >= way.count => {}
            KernelId::TrackCarry => {
                let input = CarryInput {
                    joints: &sub_pose.joints,
                    positions_rest: &rig.positions_rest,
                    offsets: &rig.character.influence_offsets,
                    influences: &rig.character.influences,
                    targets: &targets.vertices,
                };
                tracking::carry(&params, way, &input, &mut skin.positions, &mut skin.tracks);
            }
            KernelId::TrackPlace => {
                skin.places.resize(targets.reaches.len(), Place::default());
                tracking::place(&sub_pose.joints, &targets.reaches, &targets.blends, &mut skin.places);
            }
            KernelId::TrackFold => {
                let input = FoldInput {
                    joints: &sub_pose.joints,
                    patches: &rig.fold_patches,
                    triangles: &rig.fold_triangles,
                    positions_rest: &rig.positions_rest,
                    positions: &skin.positions,
                };
                tracking::fold(&params, way, &input, &mut sub_pose.groups, &mut skin.offsets);
            }
            KernelId::TrackMarch => {
                let field = FieldInput {
                    groups: &sub_pose.groups,
                    nodes: &rig.nodes,
                    muscles: &trace.muscles,
                    axes: &trace.axes,
                };
                let Skin { positions, tracks, places, .. } = skin;
                tracking::march(&params, &field, &targets.vertices, places, positions, tracks);
            }
            KernelId::TrackTurn => tracking::turn(&params, &relax, &skin.positions, &mut skin.tracks),
            KernelId::TrackSpan => {
                spans.resize(skin.positions.len(), Vec4::ZERO);
                tracking::span(&relax, &skin.tracks, spans);
            }
            KernelId::TrackSlide => {
                slid.resize(skin.positions.len(), Vec4::ZERO);
                let (from, to) = match step.reads {
                    Some(Positions::Slid) => (&*slid, &mut skin.positions),
                    _ => (&skin.positions, slid),
                };
                tracking::slide(&params, &relax, &skin.tracks, spans, from, to);
            }
            KernelId::TrackAverage => {
                slid.resize(skin.positions.len(), Vec4::ZERO);
                let input =
                    AverageInput { targets: &targets.vertices, edges: &rig.graph.edges, mean_values: &rig.mean_values };
                let (from, to) = match step.reads {
                    Some(Positions::Slid) => (&*slid, &mut skin.positions),
                    _ => (&skin.positions, slid),
                };
                tracking::average(&params, &input, &skin.tracks, from, to);
            }
            KernelId::TrackSpread => {
                trace.tracked.resize(skin.positions.len(), Vec4::ZERO);
                tracking::spread(&targets.vertices, &skin.positions, &mut trace.tracked);
            }
            _ => {}
        }
    }
}
