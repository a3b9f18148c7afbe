//! `track_march` against its twin, and the twin against what a march is for.

use crate::support::{JUNK, Random, SIZES, bent, gpu, limb_joined, run};
use crate::track_fixtures::apart;
use glam::{Vec3, Vec4, Vec4Swizzles};
use sinew::{
    field::{
        bound::bound,
        compose::{self, JointOperator},
        evaluate::{APART, GroupFrame, Place},
        muscle::{AxisPoint, MuscleFrame},
    },
    parity,
    reference::Reference,
    rig::{FrameInputs, Rig, Role, VertexTarget, march_order},
    schedule::{Counts, FrameOptions, KernelId, Skinning, TrackOptions},
    tracking::{self, FieldInput, StopReason, Track, TrackJoint, TrackParams},
    wrap::{self, ShapeInput},
};

/// Degrees of three instances at two sub-poses.
const DEGREES: [[f32; 3]; 2] = [[70.0, 0.0, 110.0], [60.0, 10.0, 95.0]];
const INSTANCES: usize = 3;

/// Some of the limb's vertices, three times on their way.
#[derive(Clone)]
struct March {
    rig: Rig,
    /// Of all instances of the first sub-pose, then of the next.
    groups: Vec<GroupFrame>,
    muscles: Vec<MuscleFrame>,
    axes: Vec<AxisPoint>,
    places: Vec<Place>,
    targets: Vec<VertexTarget>,
    positions: Vec<Vec4>,
    tracks: Vec<Track>,
    projects: bool,
    passes: u32,
}

impl March {
    /// As many of the limb's vertices as asked for, where linear skinning has them and up to 3 mm off.
    fn new(count: usize, sub_pose: usize) -> March {
        March::joined(count, sub_pose, JointOperator::Union)
    }

    /// The same with an operator at the elbow.
    fn joined(count: usize, sub_pose: usize, operator: JointOperator) -> March {
        let rig = limb_joined(40, operator);
        let (mut groups, mut muscles, mut axes) = (Vec::new(), Vec::new(), Vec::new());
        let (mut places, mut positions) = (Vec::new(), Vec::new());
        let chosen: Vec<usize> = (0..rig.positions_rest.len()).filter(|v| v % 7 == 3).cycle().take(count).collect();
        let target = |(k, &v): (usize, &usize)| VertexTarget { copy_of: k as u32, ..rig.targets.vertices[v] };
        let targets = chosen.iter().enumerate().map(target).collect();
        let linear = FrameOptions { skinning: Skinning::Linear, ..FrameOptions::default() };
        let mut random = Random(151);
        for (k, degrees) in DEGREES.iter().flatten().enumerate() {
            let inputs = FrameInputs::new(&rig, &bent(*degrees)).expect("a pose");
            groups.extend(inputs.groups.clone());
            if k / INSTANCES != sub_pose {
                continue;
            }
            let (mut shaped, mut points) =
                (vec![Default::default(); rig.muscles.len()], vec![Default::default(); rig.point_count as usize]);
            let input =
                ShapeInput { joints: &inputs.joints, inputs: &inputs.muscles, iterates: &[], wraps: &rig.wraps };
            wrap::shape(&rig.muscles, &input, &mut shaped, &mut points);
            let own = groups.len() - rig.grids.len()..;
            bound(&mut groups[own], &shaped);
            muscles.extend(shaped);
            axes.extend(points);
            let joint = |j: &sinew::rig::JointFrame| TrackJoint { matrix: j.matrix, ..TrackJoint::default() };
            let joints: Vec<TrackJoint> = inputs.joints.iter().map(joint).collect();
            let mut seen = vec![Place::default(); rig.targets.reaches.len()];
            tracking::place(&joints, &rig.targets.reaches, &rig.targets.blends, &mut seen);
            places.extend(seen);
            let skinned = Reference::new(&rig).frame(&bent(*degrees), &linear).expect("a pose").skinned;
            positions.extend(chosen.iter().map(|&v| (skinned[v].xyz() + random.vec3() * 3e-3).extend(1.0)));
        }
        let tracks = (0..positions.len()).map(|_| Track { runs: 1, ..Track::REST }).collect();
        March { rig, groups, muscles, axes, places, targets, positions, tracks, projects: false, passes: 5 }
    }

    fn params(&self, sub_pose: usize) -> TrackParams {
        let counts = Counts {
            vertices: self.targets.len() as u32,
            marched: self.targets.iter().filter(|t| t.role == Role::Active as u32).count() as u32,
            joints: 2,
            muscles: self.rig.muscles.len() as u32,
            points: self.rig.point_count,
            groups: self.rig.grids.len() as u32,
            reaches: self.rig.targets.reaches.len() as u32,
            ..Counts::default()
        };
        let options = TrackOptions { passes: self.passes, ..TrackOptions::default() };
        TrackParams::new(&counts, INSTANCES as u32, &options, sub_pose as u32, self.projects)
    }

    fn cpu(&self, sub_pose: usize) -> (Vec<Vec4>, Vec<Track>) {
        let (mut positions, mut tracks) = (self.positions.clone(), self.tracks.clone());
        let part = |list: usize, instance: usize| instance * list..(instance + 1) * list;
        for instance in 0..INSTANCES {
            let groups = self.rig.grids.len();
            let field = FieldInput {
                groups: &self.groups[part(groups, sub_pose * INSTANCES + instance)],
                nodes: &self.rig.nodes,
                muscles: &self.muscles[part(self.rig.muscles.len(), instance)],
                axes: &self.axes[part(self.rig.point_count as usize, instance)],
            };
            let own = part(self.targets.len(), instance);
            let places = &self.places[part(self.rig.targets.reaches.len(), instance)];
            let (positions, tracks) = (&mut positions[own.clone()], &mut tracks[own]);
            tracking::march(&self.params(sub_pose), &field, &self.targets, places, positions, tracks);
        }
        (positions, tracks)
    }

    fn gpu(&self, sub_pose: usize) -> Option<(Vec<Vec4>, Vec<Track>)> {
        let gpu = gpu()?;
        let params = self.params(sub_pose);
        let marched = march_order(&self.targets, &self.rig.targets.reaches);
        let inputs: [(&str, &[u8]); 10] = [
            ("params", bytemuck::bytes_of(&params)),
            ("groups", bytemuck::cast_slice(&self.groups)),
            ("nodes", bytemuck::cast_slice(&self.rig.nodes)),
            ("muscles", bytemuck::cast_slice(&self.muscles)),
            ("axes", bytemuck::cast_slice(&self.axes)),
            ("targets", bytemuck::cast_slice(&marched)),
            ("places", bytemuck::cast_slice(&self.places)),
            ("positions", bytemuck::cast_slice(&self.positions)),
            ("tracks", bytemuck::cast_slice(&self.tracks)),
            ("curves", bytemuck::cast_slice(compose::curves())),
        ];
        let count = self.positions.len();
        let outputs = [("positions", (count + 1) * 16), ("tracks", (count + 1) * size_of::<Track>())];
        let out = run(&gpu, KernelId::TrackMarch, count as u64, &inputs, &outputs);
        let mut positions: Vec<Vec4> = bytemuck::pod_collect_to_vec(&out[0]);
        let mut tracks: Vec<Track> = bytemuck::pod_collect_to_vec(&out[1]);
        assert_eq!(positions.pop().map(|p| p.x.to_bits()), Some(JUNK), "written beyond the last vertex");
        assert_eq!(tracks.pop().map(|t| t.stop), Some(JUNK), "written beyond the last vertex");
        Some((positions, tracks))
    }

    fn active(&self) -> usize {
        self.targets.iter().position(|t| t.role == Role::Active as u32).expect("an active vertex")
    }
}

/// Directions and residuals of tracks, one list of each.
fn normals(tracks: &[Track]) -> (Vec<Vec4>, Vec<Vec4>) {
    let direction = |t: &Track| t.normal.xyz().extend(0.0);
    (tracks.iter().map(direction).collect(), tracks.iter().map(|t| Vec4::splat(t.normal.w)).collect())
}

#[test]
fn matches_its_twin_at_every_size_and_sub_pose() {
    let mut worst = [0.0f32; 3];
    for size in SIZES.into_iter().chain([3000]) {
        for sub_pose in [0, 1] {
            let march = March::new(size, sub_pose);
            let Some((positions, tracks)) = march.gpu(sub_pose) else { return };
            let (expected, expected_tracks) = march.cpu(sub_pose);
            let report = parity::vectors("positions", &positions, &expected, 1.0 / 0.64, parity::TRACKED);
            assert!(report.pass, "size {size}, sub-pose {sub_pose}: {report:?}");
            let (found, expected_normals) = (normals(&tracks), normals(&expected_tracks));
            let report = parity::vectors("normals", &found.0, &expected_normals.0, 1.0, parity::NORMALS);
            assert!(report.pass, "size {size}, sub-pose {sub_pose}: {report:?}");
            worst = [
                worst[0].max(apart(&positions, &expected)),
                worst[1].max(report.max_absolute),
                worst[2].max(apart(&found.1, &expected_normals.1)),
            ];
            // Values are those of `field_sample`, and their difference.
            assert!(worst[2] < 1e-5, "size {size}, sub-pose {sub_pose}: values {worst:?} apart");
            let differ = tracks.iter().zip(&expected_tracks).filter(|(g, c)| (g.stop, g.passes) != (c.stop, c.passes));
            let differ = differ.count();
            assert!(differ as f32 <= (1.0 - parity::STOP_AGREEMENT) * positions.len() as f32, "{differ} stop reasons");
        }
    }
    println!("track_march: positions {:.1e} m, normals {:.1e}, values {:.1e} apart", worst[0], worst[1], worst[2]);
}

#[test]
fn groups_joined_by_an_operator_match_their_twin() {
    for operator in [JointOperator::Blend, JointOperator::Contact, JointOperator::Bulge] {
        let march = March::joined(3000, 0, operator);
        let Some((positions, _)) = march.gpu(0) else { return };
        let report = parity::vectors("positions", &positions, &march.cpu(0).0, 1.0 / 0.64, parity::TRACKED);
        assert_eq!(report.over, 0, "{operator:?}: {report:?}");
        let mut plain = march.clone();
        plain.places.iter_mut().filter(|p| p.join != APART).for_each(|p| p.join = 0);
        let plain = parity::vectors("positions", &positions, &plain.cpu(0).0, 1.0 / 0.64, parity::TRACKED);
        println!("{operator:?}: {} vertices see the difference to the plain union", plain.over);
        // Most of the overlap is a contact's, where the join does not count.
        assert!(operator != JointOperator::Blend || plain.over > 0, "the plain union must be seen");
    }
}

#[test]
fn another_target_is_found() {
    let march = March::new(65, 0);
    let Some((positions, _)) = march.gpu(0) else { return };
    let mut changed = march.clone();
    let active = march.active();
    changed.targets[active].iso -= 0.02;
    changed.targets[active].limit -= 0.02;
    let report = parity::vectors("positions", &positions, &changed.cpu(0).0, 1.0 / 0.64, parity::TRACKED);
    assert!(!report.pass && report.over == INSTANCES, "{report:?}");
}

#[test]
fn only_who_takes_part_is_moved() {
    for (runs, projects, moves) in [(1, false, true), (2, false, false), (2, true, true), (0, true, false)] {
        let mut march = March::new(65, 0);
        march.projects = projects;
        march.tracks.iter_mut().for_each(|t| t.runs = runs);
        let Some((positions, _)) = march.gpu(0) else { return };
        let moved = positions != march.positions;
        assert_eq!(moved, moves, "runs {runs}, projects {projects}");
    }
}

#[test]
fn a_value_that_is_not_finite_stays_and_says_so() {
    let mut march = March::new(64, 0);
    let active = march.active();
    march.targets[active].iso = f32::NAN;
    let check = |(positions, tracks): &(Vec<Vec4>, Vec<Track>)| {
        for (i, track) in tracks.iter().enumerate() {
            assert_eq!(track.stop == StopReason::NonFinite as u32, i % 64 == active, "vertex {i}");
            assert!(positions[i].is_finite() && track.normal.is_finite() && track.rotation == Vec4::W);
            assert!(i % 64 != active || positions[i] == march.positions[i], "it stays");
        }
    };
    check(&march.cpu(0));
    let Some(found) = march.gpu(0) else { return };
    check(&found);
}

#[test]
fn places_beyond_reason_stay_finite() {
    let mut march = March::new(300, 0);
    for (v, p) in march.positions.iter_mut().enumerate() {
        *p = match v % 5 {
            0 => Vec3::ZERO.extend(1.0),
            1 => (p.xyz() * 1e30).extend(1.0),
            2 => (p.xyz() * 1e-30).extend(1.0),
            3 => Vec3::new(f32::MAX, -f32::MAX, 0.0).extend(1.0),
            _ => *p,
        };
    }
    march.targets.iter_mut().step_by(13).for_each(|t| (t.iso, t.limit) = (1e30, -1e30));
    let sound = |(positions, tracks): (Vec<Vec4>, Vec<Track>)| {
        positions.iter().all(|p| p.is_finite()) && tracks.iter().all(|t| t.normal.is_finite() && t.contact.is_finite())
    };
    assert!(sound(march.cpu(0)));
    let Some(found) = march.gpu(0) else { return };
    assert!(sound(found));
}

#[test]
fn twin_reaches_its_targets_in_a_few_passes() {
    let mut march = March::new(3000, 0);
    let gaps = |tracks: &[Track]| tracks.iter().map(|t| t.residual().abs()).fold(0.0f32, f32::max);
    let first = march.cpu(0);
    march.passes = 12;
    for _ in 0..12 {
        (march.positions, march.tracks) = march.cpu(0);
    }
    march.projects = true;
    for _ in 0..4 {
        (march.positions, march.tracks) = march.cpu(0);
    }
    let active: Vec<&Track> = march.tracks.iter().filter(|t| t.passes > 0).collect();
    let arrived = active.iter().filter(|t| t.stop == StopReason::Converged as u32).count();
    println!(
        "{arrived} of {} arrived; gaps at first {}, at last {}",
        active.len(),
        gaps(&first.1),
        gaps(&march.tracks)
    );
    assert!(active.len() > 6000 && arrived * 100 >= active.len() * 99, "{arrived} of {}", active.len());
    assert!(
        active.iter().all(|t| t.passes == 16 || (t.passes > 12 && t.residual().abs() < 1e-4)),
        "who has arrived rests"
    );
    assert!(active.iter().any(|t| t.passes == 13) && active.iter().any(|t| t.passes > 13));
    let lone = |t: &&Track| t.stop == StopReason::Converged as u32 && t.residual().abs() >= 1e-3;
    assert!(!active.into_iter().any(|t| lone(&t)));
}
