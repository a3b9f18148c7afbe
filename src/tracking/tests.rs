//! Oracles of the tracker: nearest rotations by SVD, rigid motion, shares in closed form.

use super::*;
use crate::{
    field::compose::JointOperator,
    math::{product, transform_point},
    reference::Reference,
    rig::{BuildOptions, Influence, NO_JOINT, Pose, Reach, Rig, Role, SkinEdge, VertexTarget, muscle::JointSpec},
    schedule::FrameOptions,
};
use glam::{Mat3, Mat4, Quat, Vec3};
use nalgebra::Matrix3;

/// A vertex between six others, and their edges.
struct Patch {
    targets: Vec<VertexTarget>,
    edges: Vec<SkinEdge>,
    rest: Vec<Vec4>,
}

const AXES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
/// A skin's neighbours: flat, but for a dent.
const FLAT: [Vec3; 6] = [
    Vec3::new(1.0, 0.1, 0.0),
    Vec3::new(0.4, 0.2, 0.9),
    Vec3::new(-0.6, 0.0, 0.8),
    Vec3::new(-1.1, 0.1, 0.1),
    Vec3::new(-0.5, 0.3, -0.7),
    Vec3::new(0.6, 0.1, -1.0),
];

impl Patch {
    fn new(neighbours: [Vec3; 6]) -> Patch {
        let active = VertexTarget { role: Role::Active as u32, slides: 1, turns: 1, ..VertexTarget::default() };
        let mut targets = vec![VertexTarget { normal_rest: Vec3::Y.extend(0.0), edge_end: 6, ..active }];
        targets.extend((1..7).map(|copy_of| VertexTarget { copy_of, edge_begin: 6, edge_end: 6, slides: 0, ..active }));
        let edge = |k| SkinEdge { neighbour: k, weight: if neighbours == AXES { 1.0 } else { 0.2 + 0.3 * k as f32 } };
        let centre = Vec3::new(0.3, -0.2, 0.1);
        let around = neighbours.iter().map(|n| (centre + *n * 0.1).extend(1.0));
        let rest = std::iter::once(centre.extend(1.0)).chain(around).collect();
        Patch { targets, edges: (1..7).map(edge).collect(), rest }
    }

    fn input(&self) -> RelaxInput<'_> {
        RelaxInput { targets: &self.targets, edges: &self.edges, positions_rest: &self.rest }
    }

    fn moved(&self, matrix: &Mat4) -> Vec<Vec4> {
        self.rest.iter().map(|p| transform_point(matrix, p.xyz()).extend(1.0)).collect()
    }

    /// The nearest rotation in the tracker's sense, by SVD in f64.
    fn nearest(&self, positions: &[Vec4], normal: Vec3, weight: f32) -> Mat3 {
        let mut s = Matrix3::<f64>::zeros();
        let mut size = 0.0;
        let column = |v: Vec3| nalgebra::Vector3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z));
        for edge in &self.edges {
            let k = edge.neighbour as usize;
            let (e, rest) = ((positions[0] - positions[k]).xyz(), (self.rest[0] - self.rest[k]).xyz());
            s += column(e) * column(rest).transpose() * f64::from(edge.weight);
            size += f64::from(edge.weight * rest.length_squared());
        }
        s += column(normal) * column(self.targets[0].normal_rest.xyz()).transpose() * (f64::from(weight) * size);
        let svd = s.svd(true, true);
        let (u, v_t) = (svd.u.expect("u"), svd.v_t.expect("v"));
        let mut flip = Matrix3::identity();
        flip[(2, 2)] = (u * v_t).determinant().signum();
        let r = u * flip * v_t;
        Mat3::from_cols_array(&[0, 1, 2, 3, 4, 5, 6, 7, 8].map(|i| r[(i % 3, i / 3)] as f32))
    }
}

fn params() -> TrackParams {
    TrackParams::new(&Counts::default(), 1, &TrackOptions::default(), 0, false)
}

/// Angle between a track's rotation and another one, degrees.
fn off(track: &Track, rotation: &Mat3) -> f32 {
    Quat::from_vec4(track.rotation).angle_between(Quat::from_mat3(rotation)).to_degrees()
}

/// Tracks of a patch after some turns from no rotation.
fn turned(patch: &Patch, positions: &[Vec4], normal: Vec3, calls: usize) -> Vec<Track> {
    let mut tracks = vec![Track { normal: normal.extend(0.0), ..Track::REST }; patch.rest.len()];
    for _ in 0..calls {
        turn(&params(), &patch.input(), positions, &mut tracks);
    }
    tracks
}

#[test]
fn a_turned_patch_is_found_at_any_angle() {
    let mut worst = 0.0f32;
    for patch in [Patch::new(AXES), Patch::new(FLAT)] {
        for degrees in [0.1f32, 10.0, 45.0, 80.0, 100.0, 119.0, 120.0, 121.0, 135.0, 150.0] {
            for axis in [Vec3::Y, Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.3, 0.9, 0.2).normalize()] {
                let rotation = Quat::from_axis_angle(axis, degrees.to_radians());
                let positions = patch.moved(&Mat4::from_rotation_translation(rotation, Vec3::new(0.5, 2.0, -1.0)));
                let tracks = turned(&patch, &positions, rotation * Vec3::Y, 5);
                let found = off(&tracks[0], &Mat3::from_quat(rotation));
                worst = worst.max(found);
                assert!(found < 0.1, "{degrees} degrees about {axis}: {found} degrees off");
                assert_eq!(tracks[3].rotation, Vec4::W, "a vertex without edges does not turn");
            }
        }
    }
    println!("turns are found to {worst} degrees");
    let patch = Patch::new(FLAT);
    let turned_by_less = patch.moved(&Mat4::from_rotation_y(0.5));
    let tracks = turned(&patch, &turned_by_less, Vec3::Y, 4);
    assert!(off(&tracks[0], &Mat3::from_rotation_y(0.51)) > 0.1, "half a degree more must be seen");
}

#[test]
fn a_deformed_patch_has_the_rotation_of_the_svd() {
    let patch = Patch::new(FLAT);
    let mut worst = 0.0f32;
    for k in 0..50 {
        let at = k as f32;
        let rotation = Quat::from_scaled_axis(Vec3::new((at * 1.3).sin(), (at * 0.7).cos(), (at * 2.1).sin()));
        let mut positions = patch.moved(&Mat4::from_quat(rotation));
        for (i, p) in positions.iter_mut().enumerate() {
            let t = at * 3.1 + i as f32;
            *p += Vec3::new(t.sin(), (t * 1.7).cos(), (t * 2.3).sin()).extend(0.0) * 0.02;
        }
        let normal = (rotation * Vec3::Y + Vec3::new(0.2, 0.0, 0.1)).normalize();
        let tracks = turned(&patch, &positions, normal, 5);
        worst = worst.max(off(&tracks[0], &patch.nearest(&positions, normal, params().normal_weight)));
        let bare = off(&tracks[0], &patch.nearest(&positions, Vec3::ZERO, 0.0));
        assert!(bare > 0.1, "the normal must count: {bare} degrees");
    }
    println!("nearest rotations are found to {worst} degrees");
    assert!(worst < 0.1, "{worst} degrees off");
}

#[test]
fn sliding_leaves_rigid_motion_alone_and_never_goes_along_the_normal() {
    let patch = Patch::new(FLAT);
    let rotation = Quat::from_scaled_axis(Vec3::new(0.7, -1.1, 0.4));
    let moved = patch.moved(&Mat4::from_rotation_translation(rotation, Vec3::new(-0.4, 0.1, 0.3)));
    let normal = rotation * Vec3::new(0.1, 0.9, -0.2).normalize();
    let track = Track { normal: normal.extend(0.0), rotation: rotation.into(), ..Track::REST };
    let slid = |patch: &Patch, positions: &[Vec4], contact: f32| {
        let mut out = vec![Vec4::ZERO; positions.len()];
        let (tracks, mut spans) = ([Track { contact, ..track }; 7], vec![Vec4::ZERO; 7]);
        span(&patch.input(), &tracks, &mut spans);
        slide(&params(), &patch.input(), &tracks, &spans, positions, &mut out);
        assert_eq!(out[1..], positions[1..], "vertices that do not slide stay");
        out[0]
    };
    assert!((slid(&patch, &moved, 0.0) - moved[0]).length() < 1e-6);
    for k in 0..20 {
        let t = k as f32;
        let mut positions = moved.clone();
        let pushed = Vec3::new(t.sin(), (t * 1.7).cos(), (t * 0.9).sin()) * 0.03;
        positions[0] += pushed.extend(0.0);
        let way = (slid(&patch, &positions, 0.0) - positions[0]).xyz();
        assert!(way.dot(normal).abs() < 1e-7, "{} m along the normal", way.dot(normal));
        // What is tangential of the push is taken back whole, one edge's own rotation being the other's.
        let back = -pushed.reject_from_normalized(normal);
        assert!((way - back).length() < 1e-6 && way.length() > 1e-4, "{way} {back}");
        let held = (slid(&patch, &positions, 0.5) - positions[0]).xyz();
        assert!((held - back * (1.0 - 0.5 * params().contact_hold)).length() < 1e-6, "a contact spares its share");
    }
    let mut still = Patch::new(FLAT);
    still.targets[0].slides = 0;
    assert_eq!(slid(&still, &patch.moved(&Mat4::IDENTITY), 0.0), patch.rest[0]);
}

fn joint(matrix: Mat4, before: Mat4) -> TrackJoint {
    TrackJoint { matrix, carry: product(&(matrix - before), &before.inverse()), swing: Vec4::ZERO }
}

#[test]
fn places_are_inverse_blends_and_gates_let_the_other_joint_in() {
    let turn = |angle: f32, x: f32| Mat4::from_translation(Vec3::X * x) * Mat4::from_rotation_z(angle);
    let mut joints = [turn(0.3, 0.1), turn(0.8, -0.2)].map(|m| joint(m, Mat4::IDENTITY));
    let blends = [Influence { joint: 0, weight: 1.0 }];
    let alone = Reach { blend_end: 1, other: NO_JOINT, gate: NO_JOINT, group: 5, limit: 0.4, ..Reach::default() };
    let placed = |joints: &[TrackJoint], reach: Reach| {
        let mut places = [Place::default()];
        place(joints, &[reach], &blends, &mut places);
        assert_eq!((places[0].group, places[0].limit), (5, 0.4));
        places[0].to_rest
    };
    let near = |a: Mat4, b: Mat4| a.abs_diff_eq(b, 1e-6);
    let [first, second] = [joints[0].matrix.inverse(), joints[1].matrix.inverse()];
    assert!(near(placed(&joints, alone), first));
    assert!(near(placed(&joints, Reach { other: 1, share: 1.0, ..alone }), second), "drawn wholly");
    let half = (joints[0].matrix * 0.5 + joints[1].matrix * 0.5).inverse();
    assert!(near(placed(&joints, Reach { other: 1, share: 0.5, ..alone }), half));
    let gated = Reach { other: 1, share: 1.0, gate: 1, side: Vec4::X, ..alone };
    assert!(near(placed(&joints, gated), first), "the arm has not swung");
    joints[1].swing = Vec3::NEG_X.extend(1.0);
    assert!(near(placed(&joints, gated), second), "it opens on the side that it leaves");
    joints[1].swing = Vec3::X.extend(1.0);
    assert!(near(placed(&joints, gated), first), "and not on the side that it goes to");
}

/// Metres from linear skinning at which a carried vertex is lost.
const LOST_FROM: f32 = 0.04;

/// Vertices between two joints: active ones, a passive one and a copy.
fn carried(joints: &[TrackJoint], way: &Way, positions: &mut [Vec4], tracks: &mut [Track]) {
    let rest: Vec<Vec4> = AXES[..4].iter().map(|p| p.extend(1.0)).collect();
    let normal_rest = Vec3::X.extend(LOST_FROM);
    let role = |role: Role| VertexTarget { role: role as u32, normal_rest, ..VertexTarget::default() };
    let targets = [role(Role::Active), role(Role::Active), role(Role::Passive), role(Role::Copy)];
    let influences = [0, 1, 0, 1, 0, 1, 0].map(|joint| Influence { joint, weight: 0.5 });
    let input = CarryInput {
        joints,
        positions_rest: &rest,
        offsets: &[0, 2, 4, 6, 7],
        influences: &influences,
        targets: &targets,
    };
    carry(&params(), way, &input, positions, tracks);
}

#[test]
fn a_rigidly_moved_character_is_carried_rigidly() {
    let mut positions: Vec<Vec4> = AXES[..4].iter().map(|p| p.extend(1.0)).collect();
    let mut tracks = vec![Track { stop: 3, passes: 9, ..Track::REST }; 4];
    let mut before = Mat4::IDENTITY;
    for k in 1..=20 {
        let turn = Quat::from_scaled_axis(Vec3::new(0.1, 0.2, -0.1) * k as f32);
        let now = Mat4::from_rotation_translation(turn, Vec3::new(0.0, 0.1, 0.3) * k as f32);
        carried(&[joint(now, before); 2], &Way { count: 1, turn: 1.0, posed: 1 }, &mut positions, &mut tracks);
        before = now;
    }
    for (v, p) in positions.iter().enumerate().take(3) {
        let expected = transform_point(&before, AXES[v]);
        assert!((p.xyz() - expected).length() < 1e-5, "vertex {v}: {p} {expected}");
        assert_eq!((tracks[v].runs, tracks[v].stop, tracks[v].passes), (RUNS, 0, 0));
    }
    assert_eq!(positions[3], AXES[3].extend(1.0), "a copy is not carried");
}

#[test]
fn the_anchor_draws_by_its_share() {
    let still = [joint(Mat4::IDENTITY, Mat4::IDENTITY); 2];
    let drift = Vec4::new(0.02, -0.01, 0.03, 0.0);
    for (turn, contact) in [(1.0, 0.0), (0.25, 0.0), (1.0, 0.5), (1.0, 1.0), (0.0, 0.0)] {
        let mut positions: Vec<Vec4> = AXES[..4].iter().map(|p| p.extend(1.0) + drift).collect();
        let mut tracks = vec![Track { contact, ..Track::REST }; 4];
        tracks[1].stop = StopReason::NonFinite as u32;
        carried(&still, &Way { count: 1, turn, posed: 1 }, &mut positions, &mut tracks);
        let left = drift * (1.0 - params().anchor * turn * (1.0 - contact));
        assert!((positions[0] - AXES[0].extend(1.0) - left).length() < 1e-7, "turn {turn}, contact {contact}");
        assert_eq!(positions[1], AXES[1].extend(1.0), "what broke follows linear skinning");
        assert_eq!(positions[2], AXES[2].extend(1.0), "what is passive too");
    }
}

#[test]
fn what_is_far_from_linear_skinning_is_drawn_there_though_pressed() {
    let still = [joint(Mat4::IDENTITY, Mat4::IDENTITY); 2];
    // Up to the distance not at all, at half as much again by half of the pull, from twice as much on by all of it.
    for (away, share) in [(0.9, 0.0), (1.0, 0.0), (1.5, 0.5), (2.0, 1.0), (7.0, 1.0)] {
        let drift = Vec4::new(0.0, 0.0, LOST_FROM * away, 0.0);
        let mut positions: Vec<Vec4> = AXES[..4].iter().map(|p| p.extend(1.0) + drift).collect();
        let mut tracks = vec![Track { contact: 1.0, ..Track::REST }; 4];
        carried(&still, &Way { count: 1, turn: 1.0, posed: 1 }, &mut positions, &mut tracks);
        let left = drift * (1.0 - carry::LOST_PULL * share);
        assert!((positions[0] - AXES[0].extend(1.0) - left).length() < 1e-6, "{away}: {}", positions[0]);
    }
}

fn arm() -> Rig {
    let scene = crate::io::gltf::from_bytes(include_bytes!("../../assets/arm.glb"), "arm").expect("the arm");
    Rig::build(scene.character, &[], &BuildOptions::default()).expect("a rig")
}

/// The rest pose with one joint and what hangs on it turned, and all of it moved.
fn posed(rig: &Rig, joint: usize, degrees: f32, moved: Mat4) -> Pose {
    let joints = &rig.character.joints;
    let turn = joints[joint].bind() * Mat4::from_rotation_x(degrees.to_radians()) * joints[joint].inverse_bind;
    let below =
        |j: usize| std::iter::successors(Some(j as u32), |&j| joints[j as usize].parent).any(|a| a == joint as u32);
    let palette = (0..joints.len()).map(|j| moved * if below(j) { turn } else { Mat4::IDENTITY });
    Pose { palette: palette.collect(), ..Pose::default() }
}

/// The joint that bends the arm.
fn elbow(rig: &Rig) -> usize {
    rig.swings.first().expect("a joint between two groups").joint as usize
}

#[test]
fn sub_poses_keep_bones_together_and_end_in_the_pose() {
    let rig = arm();
    let options = TrackOptions::default();
    let moved = Mat4::from_rotation_translation(Quat::from_rotation_z(2.0), Vec3::new(1.0, 0.0, -2.0));
    let target = posed(&rig, elbow(&rig), 130.0, moved);
    let mut path = Path::default();
    let (way, sub_poses) = path.advance(&rig, &target, &options);
    assert_eq!((way.count, sub_poses.len()), (13, 13));
    assert_eq!(way.turn, 0.5, "ten degrees of twenty");
    let last = sub_poses.last().expect("one");
    assert!(last.joints.iter().zip(&target.palette).all(|(j, m)| j.matrix == *m), "to the bit");
    let centre = |j: usize| rig.character.joints[j].bind().w_axis.truncate();
    let mut carried: Vec<Vec3> = (0..rig.character.joints.len()).map(|j| centre(j) + Vec3::splat(0.05)).collect();
    let mut before = 0.0;
    for sub_pose in &sub_poses {
        for (j, joint) in rig.character.joints.iter().enumerate() {
            let at = carried[j];
            carried[j] = at + transform_point(&sub_pose.joints[j].carry, at);
            let expected = transform_point(&sub_pose.joints[j].matrix, centre(j) + Vec3::splat(0.05));
            assert!((carried[j] - expected).length() < 1e-4, "joint {j} carries what it holds");
            if let Some(parent) = joint.parent.map(|p| p as usize) {
                let at = |k: usize| transform_point(&sub_pose.joints[k].matrix, centre(k));
                let (length, at_rest) = (at(j).distance(at(parent)), centre(j).distance(centre(parent)));
                assert!((length - at_rest).abs() < 1e-5, "bone {j} is {length} m, at rest {at_rest}");
            }
        }
        let e = elbow(&rig);
        let parent = rig.character.joints[e].parent.expect("a parent") as usize;
        let relative = sub_pose.joints[parent].matrix.inverse() * sub_pose.joints[e].matrix;
        let angle = Quat::from_mat4(&relative).angle_between(Quat::IDENTITY).to_degrees();
        assert!((angle - before - 10.0).abs() < 0.01, "from {before} to {angle} degrees");
        before = angle;
    }
}

#[test]
fn who_stands_still_has_no_sub_poses() {
    let rig = arm();
    let options = TrackOptions::default();
    let at = |degrees: f32| posed(&rig, elbow(&rig), degrees, Mat4::IDENTITY);
    let mut path = Path::default();
    let counts =
        [0.0, 0.0, 5.0, 5.0, 5.00001, 24.9, 26.0, 55.0].map(|degrees| path.advance(&rig, &at(degrees), &options).0);
    // The first pose always has one: nothing is known of where the skin is.
    assert_eq!(counts.map(|way| way.count), [1, 0, 1, 0, 0, 1, 1, 3]);
    assert!(counts.iter().all(|way| way.posed == 1));
    // An angle from a cosine in f32 is good to a thousandth of a degree.
    assert!((counts[6].turn - 1.1 / 20.0).abs() < 1e-4, "{}", counts[6].turn);
    let lifted = posed(&rig, elbow(&rig), 55.0, Mat4::from_translation(Vec3::Y * 1e-3));
    assert_eq!(path.advance(&rig, &lifted, &options).0.count, 1, "a millimetre of lift");
    for degrees in 0..400 {
        let held = posed(&rig, elbow(&rig), 0.3 * degrees as f32, Mat4::from_rotation_y(0.01 * degrees as f32));
        path.advance(&rig, &held, &options);
        assert_eq!(path.advance(&rig, &held, &options).0.count, 0, "{degrees}: a pose that is held");
    }
}

#[test]
fn joints_without_volume_lead_nowhere_that_is_not_finite() {
    let rig = arm();
    let mut flat = posed(&rig, elbow(&rig), 90.0, Mat4::IDENTITY);
    flat.palette[elbow(&rig)] = Mat4::ZERO;
    flat.palette[0] *= Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0));
    let mut path = Path::default();
    for pose in [&flat, &posed(&rig, elbow(&rig), 120.0, Mat4::IDENTITY), &flat] {
        for sub_pose in path.advance(&rig, pose, &TrackOptions::default()).1 {
            assert!(sub_pose.joints.iter().all(|j| j.matrix.is_finite() && j.carry.is_finite() && j.swing.is_finite()));
            assert!(sub_pose.groups.iter().all(|g| g.to_rest.is_finite() && g.fold_end.offset.is_finite()));
        }
    }
}

#[test]
fn joined_groups_stay_at_rest() {
    let Some(data) = std::env::var_os("SINEW_DATA").map(std::path::PathBuf::from) else { return };
    let scene = crate::io::gltf::read(&data.join("humans/arm_nohand_dense_2172.glb")).expect("the arm");
    let strays = |operator: JointOperator, moved: f32| {
        let joints = vec![JointSpec { joint: "lowerarm_l".into(), operator }];
        let options = BuildOptions { joints, ..BuildOptions::default() };
        let mut rig = Rig::build(scene.character.clone(), &[], &options).expect("a rig");
        // What the join adds at rest is in the targets.
        rig.targets.vertices.iter_mut().filter(|t| t.lift != 0.0).for_each(|t| t.iso -= moved);
        let pose = Pose::rest(&rig.character);
        let trace = Reference::new(&rig).frame(&pose, &FrameOptions::default()).expect("a frame");
        let pairs = trace.positions().iter().zip(&rig.positions_rest);
        pairs.fold(0.0f32, |most, (p, q)| most.max(p.distance(*q)))
    };
    for operator in [JointOperator::Blend, JointOperator::Contact, JointOperator::Bulge] {
        let found = strays(operator, 0.0);
        assert!(found < 1e-6, "{operator:?}: {found} m");
    }
    assert!(strays(JointOperator::Blend, 1e-3) > 1e-5, "another target must be seen");
}
