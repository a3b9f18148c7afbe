//! Why a vertex is where it is: what the tracker saw of one vertex in one frame.

use super::{Motion, Reference, Trace};
use crate::{
    error::PoseError,
    field::{
        evaluate::{FieldInput, GroupFrame, OwnSide, Place},
        muscle,
    },
    math::transform_point,
    rig::{FrameInputs, Influence, NO_JOINT, Pose, Reach, Role, Targets, Unheld, VertexTarget},
    schedule::{FoldVolume, FrameOptions, KernelId},
    tracking::{Track, drawn_share},
};
use glam::{Vec3, Vec4Swizzles};
use std::cell::Cell;

/// What became of one vertex in one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Explained {
    /// The vertex itself, or the first of its copies, which everything here is about.
    pub vertex: u32,
    /// Where the tracker takes it.
    pub target: VertexTarget,
    /// Why no field holds it; `None` where one does.
    pub unheld: Option<Unheld>,
    /// Position at rest, metres.
    pub position_rest: Vec3,
    /// Sub-poses of the frame; 0 where no joint has moved.
    pub sub_poses: u32,
    /// The groups that it sees through frames of its own.
    pub reaches: Vec<SeenReach>,
    /// Before the first step: where the joints have carried it, in the first sub-pose.
    pub before: Sight,
    /// After the last step, in the pose itself.
    pub after: Sight,
    /// What the tracker keeps of it.
    pub track: Track,
}

/// A group seen through a frame of the vertex's own.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenReach {
    /// The group, and how it is seen.
    pub reach: Reach,
    /// Joints that its frame blends.
    pub blend: Vec<Influence>,
    /// By how much the frame is drawn to its other joint's in this pose; `None` where there is none, or where no joint has moved.
    pub drawn: Option<f32>,
}

/// The fields around a vertex at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// Position, metres in posed scene space.
    pub position: Vec3,
    /// What it tracks there.
    pub tracked: OwnSide,
    /// Groups whose field is not 0 there, and those that it has a reach for, ascending.
    pub groups: Vec<SeenGroup>,
    /// Muscles whose field is not 0 there, ascending.
    pub muscles: Vec<SeenMuscle>,
}

/// A group at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenGroup {
    /// The group.
    pub group: u32,
    /// Its field.
    pub value: f32,
    /// Field above which the vertex is in contact with it, where it is not the vertex's own.
    pub limit: f32,
}

/// A muscle at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenMuscle {
    /// The muscle.
    pub muscle: u32,
    /// Its own field, before any operator.
    pub value: f32,
}

impl Reference<'_> {
    /// Goes on to the next frame of a motion as [`Reference::next`] does, and says what became of a vertex; `None` where there
    /// is no such vertex, and then nothing has moved.
    ///
    /// # Errors
    /// As [`Reference::next`].
    pub fn explain(
        &self,
        motion: &mut Motion,
        pose: &Pose,
        options: &FrameOptions,
        vertex: u32,
    ) -> Result<Option<Explained>, PoseError> {
        let rig = self.rig;
        let Some(vertex) = rig.targets.vertices.get(vertex as usize).map(|target| target.copy_of) else {
            return Ok(None);
        };
        let target = rig.targets.vertices[vertex as usize];
        let v = vertex as usize;
        let inputs = FrameInputs::new(rig, pose)?;
        let way = motion.skin.as_ref().map(|skin| skin.path.clone().lead(rig, pose, &options.track).1);
        let way = way.unwrap_or_default();
        // As far as the first march, and no further.
        let mut carried = motion.clone();
        let on = Cell::new(true);
        let start = self.play_where(&mut carried, pose, options, Trace::default(), |step| {
            on.set(on.get() && step.kernel != KernelId::TrackMarch);
            on.get()
        })?;
        let trace = self.next(motion, pose, options)?;
        let own = target.reach_begin as usize..target.reach_end as usize;
        let sight = |motion: &Motion, trace: &Trace, groups: &[GroupFrame]| {
            let field = FieldInput { groups, nodes: &rig.nodes, muscles: &trace.muscles, axes: &trace.axes };
            let (position, places) = match &motion.skin {
                Some(skin) => (skin.positions[v].xyz(), skin.places.get(own.clone()).unwrap_or_default()),
                None => (trace.positions()[v].xyz(), &[][..]),
            };
            field.sight(&target, places, position)
        };
        let first = way.first().map_or(&inputs.groups, |sub_pose| &sub_pose.groups);
        let before = sight(&carried, &start, &self.folded(&carried, options, first));
        let after = sight(motion, &trace, &self.folded(motion, options, &inputs.groups));
        let reaches = rig.targets.reaches[own.clone()].iter().map(|reach| SeenReach {
            reach: *reach,
            blend: rig.targets.blends[reach.blend_begin as usize..reach.blend_end as usize].to_vec(),
            drawn: way.last().filter(|_| reach.other != NO_JOINT).map(|sub_pose| drawn_share(&sub_pose.joints, reach)),
        });
        Ok(Some(Explained {
            vertex,
            target,
            unheld: if target.role == Role::Active as u32 { None } else { Targets::unheld(rig, v) },
            position_rest: rig.character.positions_rest[v],
            sub_poses: way.len() as u32,
            reaches: reaches.collect(),
            before,
            after,
            track: trace.tracks.get(v).copied().unwrap_or_default(),
        }))
    }
}

impl Reference<'_> {
    /// Field groups with what the tracker has found their folds to displace.
    fn folded(&self, motion: &Motion, options: &FrameOptions, groups: &[GroupFrame]) -> Vec<GroupFrame> {
        let mut groups = groups.to_vec();
        let offsets = motion.skin.as_ref().filter(|_| options.track.fold == FoldVolume::Closed);
        let offsets = offsets.map_or(&[][..], |skin| &skin.offsets);
        for (patch, &offset) in self.rig.fold_patches.iter().zip(offsets) {
            groups[patch.child as usize].fold_start.offset = offset;
            groups[patch.parent as usize].fold_end.offset = offset;
        }
        groups
    }
}

impl FieldInput<'_> {
    /// All that a vertex sees at a point.
    fn sight(&self, target: &VertexTarget, places: &[Place], position: Vec3) -> Sight {
        let (mut groups, mut muscles) = (Vec::new(), Vec::new());
        for (group, frame) in (0..).zip(self.groups).filter(|(_, frame)| frame.present != 0) {
            let place = places.iter().find(|place| place.group == group);
            let (to_rest, limit) = place.map_or((&frame.to_rest, target.limit), |place| (&place.to_rest, place.limit));
            let value = self.group_from(frame, to_rest, position).value;
            if value > 0.0 || place.is_some() || group == target.owner {
                groups.push(SeenGroup { group, value, limit });
            }
            let p_rest = transform_point(to_rest, position);
            for muscle in frame.grid.muscle_begin..frame.grid.muscle_end {
                let shape = &self.muscles[muscle as usize];
                if shape.reaches(p_rest) {
                    let value = muscle::evaluate(shape, shape.points(self.axes), p_rest).value;
                    muscles.extend((value > 0.0).then_some(SeenMuscle { muscle, value }));
                }
            }
        }
        Sight { position, tracked: self.own_side(&target.side(), places, position), groups, muscles }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{arm, pose};
    use super::*;
    use crate::rig::{BuildOptions, Rig};

    #[test]
    fn an_explanation_is_of_the_frame_that_is_played() {
        let (scene, rig, options) = arm();
        let reference = Reference::new(&rig);
        let play = |vertex: u32| {
            let mut motion = Motion::new(&rig, &options);
            for frame in 0..4 {
                reference.advance(&mut motion, &pose(&scene, frame), &options).expect("a frame");
            }
            let mut beside = motion.clone();
            let found = reference.explain(&mut motion, &pose(&scene, 4), &options, vertex).expect("a frame");
            let trace = reference.next(&mut beside, &pose(&scene, 4), &options).expect("a frame");
            let skin = |motion: Motion| motion.skin.map(|skin| skin.positions);
            (found, trace, skin(motion) == skin(beside))
        };
        let active = |v: &u32| rig.targets.vertices[*v as usize].role == Role::Active as u32;
        let vertices: Vec<u32> = (0..rig.targets.vertices.len() as u32).filter(active).collect();
        let (mut muscles, mut moved) = (0, 0);
        for &vertex in vertices.iter().step_by(vertices.len() / 12) {
            let (found, trace, same) = play(vertex);
            let found = found.expect("the vertex");
            assert!(same, "explaining changes nothing");
            assert_eq!(found.after.position, trace.tracked[vertex as usize].xyz());
            assert_eq!(found.track, trace.tracks[vertex as usize]);
            assert!(found.unheld.is_none() && found.sub_poses > 0 && found.track.passes > 0);
            let own = found.after.groups.iter().find(|seen| seen.group == found.target.owner).expect("its own group");
            let gap = |sight: &Sight| (sight.tracked.sample.value - found.target.iso).abs();
            assert!(own.value > 0.0 && gap(&found.after) < 0.01, "{found:?}");
            moved += u32::from(gap(&found.before) > gap(&found.after));
            muscles += found.after.muscles.len();
        }
        assert!(muscles > 0 && moved > 6, "{muscles} muscles, {moved} vertices nearer to their values");
        let copies = rig.targets.vertices.len() as u32;
        let (beyond, _, same) = play(copies);
        assert!(beyond.is_none() && !same, "a vertex that there is not moves nothing");
    }

    #[test]
    fn a_vertex_that_no_field_holds_says_why() {
        let (scene, rig, options) = arm();
        let passive = rig.targets.vertices.iter().position(|t| t.role == Role::Passive as u32).expect("one at an end");
        let reference = Reference::new(&rig);
        let explain = |vertex: usize| {
            let mut motion = Motion::new(&rig, &options);
            reference.explain(&mut motion, &pose(&scene, 0), &options, vertex as u32).expect("a frame").expect("it")
        };
        let found = explain(passive);
        assert!(found.unheld.is_some() && found.track.passes == 0, "{found:?}");
        let bare = Rig::build(scene.character.clone(), &[], &BuildOptions { fields: false, ..BuildOptions::default() });
        let bare = bare.expect("a rig");
        let mut motion = Motion::new(&bare, &options);
        let found = Reference::new(&bare).explain(&mut motion, &pose(&scene, 0), &options, 3).expect("a frame");
        assert_eq!(found.expect("it").unheld, Some(Unheld::NoField));
    }
}
