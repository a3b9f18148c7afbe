//! Choosing a motion and sampling it. Transforms are composed in f64 and rounded once, at the end: down a chain of
//! twenty joints f32 would already lose a tenth of the tolerance against other programs.

use super::made::MadeClips;
use super::{Channel, Clip, ClipChoice, Interpolation, Local, MuscleChannel, Scene, TestClip, Track};
use crate::error::{ClipError, one_line};
use crate::rig::muscle::{BoneShape, BoneSpec};
use crate::rig::{BoneMesh, Keyed, Pose};
use glam::{DMat4, DQuat, DVec3, DVec4, Quat, Vec3};

/// Share of a frame by which a clip may end before its last frame: key times are rounded to f32.
const FRAME_SLACK: f64 = 1e-3;

impl Scene {
    /// Finds a motion by name: `rest`, `default`, a clip's name, its index, or the name of a [`TestClip`]. Without a name,
    /// the first clip that moves anything, and [`ClipChoice::Default`] where there is none.
    ///
    /// # Errors
    /// [`ClipError::Unknown`], which lists what there is; [`ClipError::Limb`] where a test clip moves what the skeleton
    /// lacks.
    pub fn choose_clip(&self, name: Option<&str>) -> Result<ClipChoice, ClipError> {
        let Some(name) = name else {
            let moving = self.clips.iter().position(|clip| !clip.is_empty());
            return Ok(moving.map_or(ClipChoice::Default, ClipChoice::Clip));
        };
        match name {
            "rest" => return Ok(ClipChoice::Rest),
            "default" => return Ok(ClipChoice::Default),
            _ => {}
        }
        let by_name = self.clips.iter().position(|clip| clip.name == name);
        let by_index = || name.parse::<usize>().ok().filter(|&index| index < self.clips.len());
        if let Some(index) = by_name.or_else(by_index) {
            return Ok(ClipChoice::Clip(index));
        }
        if let Some(clip) = TestClip::ALL.into_iter().find(|clip| clip.name() == name) {
            return self.check_test(clip).map(|()| ClipChoice::Test(clip));
        }
        let clips = self.clips.iter().enumerate().map(|(i, clip)| format!(", {i} `{}`", clip.name));
        let made = TestClip::ALL.iter().filter(|clip| self.check_test(**clip).is_ok());
        Err(ClipError::Unknown {
            character: self.character.name.clone(),
            wanted: one_line(name),
            available: clips.chain(made.map(|clip| format!(", {}", clip.name()))).collect(),
        })
    }

    /// Whether the skeleton has what a test clip moves.
    ///
    /// # Errors
    /// [`ClipError::Limb`], which names what is missing.
    pub fn check_test(&self, clip: TestClip) -> Result<(), ClipError> {
        self.made().check(clip, &self.character)
    }

    fn made(&self) -> &MadeClips {
        self.made.get_or_init(|| MadeClips::new(&self.character))
    }

    /// How long a motion lasts, seconds; 0 for the two poses that do not move.
    pub fn duration(&self, choice: ClipChoice) -> f32 {
        match choice {
            ClipChoice::Test(clip) => self.made().seconds(clip),
            _ => self.clip(choice).map_or(0.0, |clip| clip.end - clip.start),
        }
    }

    /// How many frames a motion has: frame `k` is `k / fps` seconds after its start, and the last one is at or before
    /// its end. Never 0.
    pub fn frame_count(&self, choice: ClipChoice, fps: f32) -> u32 {
        let frames = f64::from(self.duration(choice)) * f64::from(fps);
        // The cast takes NaN to 0 and saturates.
        ((frames + FRAME_SLACK).floor() as u32).saturating_add(1)
    }

    /// Where everything is, `time` seconds after the motion's start. Before its first and after its last key a channel
    /// holds that key's value.
    ///
    /// What the clip keys of muscles stands in [`Pose::keyed`].
    ///
    /// [`ClipChoice::Rest`] has an identity palette; joint nodes are at the inverse of their inverse bind matrices and
    /// other nodes keep their place relative to their parents; so they do in a [`TestClip`]. A clip that the scene does
    /// not have is [`ClipChoice::Default`].
    pub fn pose(&self, choice: ClipChoice, time: f32) -> Pose {
        let joints = &self.character.joints;
        let (globals, motion) = match choice {
            ClipChoice::Test(clip) => {
                let motion = self.made().motion(clip, time);
                (moved_globals(self, &motion), motion)
            }
            _ => (node_globals(self, choice, time), Vec::new()),
        };
        let palette = match choice {
            ClipChoice::Rest => Pose::rest(&self.character).palette,
            ClipChoice::Test(_) => motion.iter().map(DMat4::as_mat4).collect(),
            _ => joints.iter().map(|j| (globals[j.node as usize] * j.inverse_bind.as_dmat4()).as_mat4()).collect(),
        };
        let nodes = globals.iter().map(DMat4::as_mat4).collect();
        let keyed = self.clip(choice).map_or_else(Vec::new, |clip| clip.keyed(time));
        Pose { palette, nodes, time, keyed, ..Pose::default() }
    }

    /// The rigid parts in the rest pose, where some of `bones` have a mesh for their shape; else nothing.
    pub fn bone_meshes(&self, bones: &[BoneSpec]) -> Vec<BoneMesh> {
        if !bones.iter().any(|bone| matches!(bone.shape, BoneShape::Mesh(_))) {
            return Vec::new();
        }
        let nodes = self.pose(ClipChoice::Rest, 0.0).nodes;
        let meshes = self.rigid.iter().map(|part| {
            let place = |p: &Vec3| nodes[part.node as usize].transform_point3(*p);
            let (positions, triangles) = (part.positions.iter().map(place).collect(), part.triangles.clone());
            BoneMesh { name: part.name.clone(), positions, triangles }
        });
        meshes.collect()
    }

    fn clip(&self, choice: ClipChoice) -> Option<&Clip> {
        match choice {
            ClipChoice::Clip(index) => self.clips.get(index),
            ClipChoice::Rest | ClipChoice::Default | ClipChoice::Test(_) => None,
        }
    }
}

impl Clip {
    /// A time after the clip's start in the file's own seconds.
    fn moment(&self, time: f32) -> f32 {
        self.start + if time.is_nan() { 0.0 } else { time }
    }

    /// What is keyed of muscles, `time` seconds after the clip's start.
    fn keyed(&self, time: f32) -> Vec<Keyed> {
        let moment = self.moment(time);
        let key = |c: &MuscleChannel| c.track.at(moment).map(|key| Keyed { muscle: c.muscle.clone(), key });
        self.muscle_channels.iter().filter_map(key).collect()
    }
}

/// The global transform of every node, see [`Scene::pose`].
pub(crate) fn node_globals(scene: &Scene, choice: ClipChoice, time: f32) -> Vec<DMat4> {
    let mut parts: Vec<Parts> = scene.nodes.iter().map(|node| Parts::of(&node.local)).collect();
    if let Some(clip) = scene.clip(choice) {
        let time = clip.moment(time);
        for channel in &clip.channels {
            if let Some(Parts::Animated(scale, rotation, translation)) = parts.get_mut(channel.node as usize) {
                match channel.at(time) {
                    Value::Translation(v) => *translation = v,
                    Value::Rotation(q) => *rotation = q,
                    Value::Scale(v) => *scale = v,
                }
            }
        }
    }
    let mut bound = vec![None; scene.nodes.len()];
    if choice == ClipChoice::Rest {
        bound = bound_nodes(scene, |_| DMat4::IDENTITY);
    }
    composed(scene, &parts, &bound)
}

/// The global transform of every node where `motion` moves the joints from the bind pose.
fn moved_globals(scene: &Scene, motion: &[DMat4]) -> Vec<DMat4> {
    let parts: Vec<Parts> = scene.nodes.iter().map(|node| Parts::of(&node.local)).collect();
    composed(scene, &parts, &bound_nodes(scene, |j| motion[j]))
}

/// The global transforms of the joints' nodes.
fn bound_nodes(scene: &Scene, motion: impl Fn(usize) -> DMat4) -> Vec<Option<DMat4>> {
    let mut bound = vec![None; scene.nodes.len()];
    for (j, joint) in scene.character.joints.iter().enumerate() {
        bound[joint.node as usize].get_or_insert_with(|| motion(j) * joint.inverse_bind.as_dmat4().inverse());
    }
    bound
}

/// Global transforms of all nodes, of which some are known.
fn composed(scene: &Scene, parts: &[Parts], bound: &[Option<DMat4>]) -> Vec<DMat4> {
    let mut globals = vec![DMat4::IDENTITY; scene.nodes.len()];
    for &node in &scene.node_order {
        let node = node as usize;
        globals[node] = bound[node].unwrap_or_else(|| match scene.nodes[node].parent {
            Some(parent) => globals[parent as usize] * parts[node].matrix(),
            None => parts[node].matrix(),
        });
    }
    globals
}

/// A node's transform while it is being animated: scale, rotation, translation.
enum Parts {
    Animated(DVec3, DQuat, DVec3),
    Fixed(DMat4),
}

impl Parts {
    fn of(local: &Local) -> Parts {
        match *local {
            Local::Parts { translation, rotation, scale } => {
                Parts::Animated(scale.as_dvec3(), rotation.as_dquat().normalize(), translation.as_dvec3())
            }
            Local::Matrix(matrix) => Parts::Fixed(matrix.as_dmat4()),
        }
    }

    fn matrix(&self) -> DMat4 {
        match *self {
            Parts::Animated(scale, rotation, translation) => {
                DMat4::from_scale_rotation_translation(scale, rotation, translation)
            }
            Parts::Fixed(matrix) => matrix,
        }
    }
}

/// What a channel says at one time.
enum Value {
    Translation(DVec3),
    Rotation(DQuat),
    Scale(DVec3),
}

/// Where a time falls among the keys of a channel.
enum Moment {
    /// On this key, or held there.
    At(usize),
    /// Between this key and the next: share of the way in 0..1, and the seconds between them.
    Between(usize, f64, f64),
}

impl Channel {
    fn moment(&self, time: f32) -> Moment {
        let after = self.times.partition_point(|&key| key <= time);
        let Some(key) = after.checked_sub(1) else { return Moment::At(0) };
        match self.times.get(after) {
            Some(&next) if self.times[key] < time && self.interpolation != Interpolation::Step => {
                let (from, to) = (f64::from(self.times[key]), f64::from(next));
                Moment::Between(key, (f64::from(time) - from) / (to - from), to - from)
            }
            _ => Moment::At(key),
        }
    }

    fn at(&self, time: f32) -> Value {
        let moment = self.moment(time);
        match &self.track {
            Track::Translation(values) => Value::Translation(self.vector(values, &moment)),
            Track::Scale(values) => Value::Scale(self.vector(values, &moment)),
            Track::Rotation(values) => Value::Rotation(self.rotation(values, &moment)),
        }
    }

    fn vector(&self, values: &[Vec3], moment: &Moment) -> DVec3 {
        let value = |index: usize| values[index].as_dvec3();
        let cubic = self.interpolation == Interpolation::CubicSpline;
        match *moment {
            Moment::At(key) => value(if cubic { 3 * key + 1 } else { key }),
            Moment::Between(key, t, seconds) if cubic => {
                hermite([3 * key + 1, 3 * key + 2, 3 * key + 3, 3 * key + 4].map(|i| value(i).extend(0.0)), t, seconds)
                    .truncate()
            }
            Moment::Between(key, t, _) => value(key).lerp(value(key + 1), t),
        }
    }

    fn rotation(&self, values: &[Quat], moment: &Moment) -> DQuat {
        let value = |index: usize| values[index].as_dquat();
        let cubic = self.interpolation == Interpolation::CubicSpline;
        let rotation = match *moment {
            Moment::At(key) => value(if cubic { 3 * key + 1 } else { key }),
            Moment::Between(key, t, seconds) if cubic => DQuat::from_vec4(hermite(
                [3 * key + 1, 3 * key + 2, 3 * key + 3, 3 * key + 4].map(|i| DVec4::from(value(i))),
                t,
                seconds,
            )),
            // glam's slerp goes the shorter way round.
            Moment::Between(key, t, _) => value(key).normalize().slerp(value(key + 1).normalize(), t),
        };
        let length = rotation.length();
        // A spline may pass through zero, where it names no rotation.
        if length > 1e-9 { rotation / length } else { DQuat::IDENTITY }
    }
}

/// glTF 2.0, appendix C.5: value and out-tangent of one key, in-tangent and value of the next, `t` of the way between
/// keys that are `seconds` apart.
fn hermite([value_0, out_0, in_1, value_1]: [DVec4; 4], t: f64, seconds: f64) -> DVec4 {
    let (t2, t3) = (t * t, t * t * t);
    value_0 * (2.0 * t3 - 3.0 * t2 + 1.0)
        + out_0 * (seconds * (t3 - 2.0 * t2 + t))
        + value_1 * (-2.0 * t3 + 3.0 * t2)
        + in_1 * (seconds * (t3 - t2))
}
