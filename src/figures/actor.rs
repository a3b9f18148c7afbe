//! The built-in arm on a device, deformed there and drawn from there.

use super::scene::{Studio, tube};
use crate::dynamics::Particle;
use crate::error::FigureError;
use crate::field::muscle::{AxisPoint, MuscleFrame};
use crate::gpu::{Instance, Kernels, Output, RigBuffers, readback};
use crate::render::{
    Camera, ColorMesh, Direction, Frame, Light, Look, SkinMesh, Surface, View, bone_meshes, muscle_meshes,
};
use crate::rig::{FrameInputs, Image, Pose, Rig};
use crate::schedule::{DynamicsOptions, FrameOptions, Step};
use crate::skinning::{self, SkinInput};
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};
use std::sync::Arc;

/// From the inner side, where the biceps shows.
const DIRECTION: Direction = Direction { azimuth: -75.0, elevation: 5.0 };
/// Radius of an axis, metres, and its green, linear RGB.
const AXIS: f32 = 0.0018;
const GREEN: [f32; 3] = [0.02, 0.55, 0.10];

/// A rig on its way through poses.
pub(super) struct Actor<'a> {
    studio: &'a Studio<'a>,
    rig: Arc<Rig>,
    mesh: SkinMesh,
    instance: Instance,
}

/// One frame on the host.
pub(super) struct Seen {
    /// Vertices of the skin, scene space, metres.
    pub positions: Vec<Vec3>,
    /// Their unit normals.
    pub normals: Vec<Vec3>,
    /// The muscles, each in the space of its field group at rest.
    pub muscles: Vec<MuscleFrame>,
    /// Points of their axes.
    pub axes: Vec<AxisPoint>,
    /// The same in motion, scene space.
    pub particles: Vec<Particle>,
}

impl<'a> Actor<'a> {
    /// Brings a rig to the studio's device; muscles move where there are dynamics.
    pub fn new(
        studio: &'a Studio<'a>,
        rig: &Arc<Rig>,
        dynamics: Option<DynamicsOptions>,
    ) -> Result<Actor<'a>, FigureError> {
        Actor::with(studio, rig, &FrameOptions { dynamics, ..FrameOptions::default() })
    }

    /// The same with all of a frame's options.
    pub fn with(studio: &'a Studio<'a>, rig: &Arc<Rig>, options: &FrameOptions) -> Result<Actor<'a>, FigureError> {
        let headless = studio.headless();
        let (device, queue) = (&headless.device, &headless.queue);
        let kernels = Kernels::new(device)?;
        let buffers = Arc::new(RigBuffers::upload(device, Arc::clone(rig))?);
        let mut instance = Instance::new(&kernels, device, queue, &buffers, Output::Owned)?;
        instance.set_options(queue, options);
        let look = Arc::new(Look::of(headless, studio.renderer(), &rig.character)?);
        let mesh = SkinMesh::of(headless, &look, &rig.character)?;
        headless.check()?;
        Ok(Actor { studio, rig: Arc::clone(rig), mesh, instance })
    }

    /// Moves its muscles on through poses that nobody sees.
    pub fn pass(&mut self, poses: &[Pose]) -> Result<(), FigureError> {
        let headless = self.studio.headless();
        for pose in poses {
            self.instance.set_pose(&headless.queue, pose)?;
            let batch = self.instance.batch();
            headless.run(|encoder| batch.encode_where(encoder, None, Step::is_of_motion))?;
        }
        Ok(())
    }

    /// Goes on to a pose, deforms the skin, and brings everything to the host.
    pub fn show(&mut self, pose: &Pose) -> Result<Seen, FigureError> {
        let headless = self.studio.headless();
        self.instance.set_pose(&headless.queue, pose)?;
        headless.run(|encoder| self.instance.encode(encoder))?;
        let (batch, rig) = (self.instance.batch(), &self.rig);
        let (vertices, points) = (rig.character.vertex_count(), rig.point_count as usize);
        let skin: Vec<[f32; 6]> = readback::read(headless, batch.output(), ..vertices)?;
        Ok(Seen {
            positions: skin.iter().map(|v| Vec3::new(v[0], v[1], v[2])).collect(),
            normals: skin.iter().map(|v| Vec3::new(v[3], v[4], v[5])).collect(),
            muscles: readback::read(headless, batch.muscles(), ..rig.muscles.len())?,
            axes: readback::read(headless, batch.axes(), ..points)?,
            particles: readback::read(headless, batch.particles(), ..points)?,
        })
    }

    /// The frame that was shown last, in its pose: the skin as it is; or its muscles on their bones, with green axes,
    /// under a breath of skin.
    pub fn draw(&self, camera: &Camera, pose: &Pose, seen: &Seen, view: View) -> Result<Image, FigureError> {
        let vertices = self.instance.output().slice(..);
        let surfaces = [Surface { mesh: &self.mesh, vertices, model: Mat4::IDENTITY }];
        let (mut solids, mut marks) = (Vec::new(), Vec::new());
        if view != View::Skin {
            solids = muscle_meshes(&self.rig, pose, &seen.muscles, &seen.axes);
            solids.extend(bone_meshes(&self.rig, pose));
            marks = seen.muscles.iter().map(|muscle| axis(muscle, seen)).collect();
        }
        let frame = Frame { camera, view, light: Light::Paper, surfaces: &surfaces, solids: &solids, marks: &marks };
        self.studio.frame(&frame)
    }
}

fn axis(muscle: &MuscleFrame, seen: &Seen) -> ColorMesh {
    let own = &seen.particles[muscle.first_point as usize..][..=muscle.segments as usize];
    tube(&own.iter().map(|p| p.position.xyz()).collect::<Vec<_>>(), AXIS, GREEN)
}

/// The camera that holds a rig in all of some poses, by linear skinning: fields move the skin by less than the camera's
/// margin.
pub(super) fn camera(rig: &Rig, poses: &[&Pose], aspect: f32) -> Result<Camera, FigureError> {
    let mut points = Vec::new();
    for pose in poses {
        let inputs = FrameInputs::new(rig, pose)?;
        let mut skinned = vec![Vec4::ZERO; rig.character.vertex_count()];
        let input = SkinInput {
            joints: &inputs.joints,
            positions_rest: &rig.positions_rest,
            offsets: &rig.character.influence_offsets,
            influences: &rig.character.influences,
        };
        skinning::linear(&input, &mut skinned);
        points.extend(skinned.iter().map(|p| p.xyz()));
    }
    Ok(Camera::around(&points, DIRECTION, aspect))
}
