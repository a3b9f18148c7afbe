//! Muscles in motion on the device: what a frame hands on to the next one, and how to keep it.

use crate::support::{Gpu, gpu};
use sinew::{
    clip::Scene,
    gpu::{Instance, Output, RigBuffers, readback},
    rig::{BuildOptions, Pose, Rig, muscle_file},
    schedule::{DynamicsOptions, FrameOptions, Step},
};
use std::{path::Path, sync::Arc};

struct Arm {
    scene: Scene,
    buffers: Arc<RigBuffers>,
}

impl Arm {
    fn new(gpu: &Gpu) -> Arm {
        let scene = sinew::io::gltf::from_bytes(include_bytes!("../assets/arm.glb"), "arm").expect("the arm");
        let text = include_str!("../assets/arm.muscles.toml");
        let file = muscle_file::parse(text, Path::new("arm.muscles.toml")).expect("good");
        let rig = Rig::build(scene.character.clone(), &file.muscles, &BuildOptions::default()).expect("a rig");
        let buffers = RigBuffers::upload(&gpu.device, Arc::new(rig)).expect("buffers");
        Arm { scene, buffers: Arc::new(buffers) }
    }

    fn pose(&self, frame: u32) -> Pose {
        self.scene.pose(self.scene.choose_clip(Some("shake")).expect("the clip"), frame as f32 / 30.0)
    }

    fn instance(&self, gpu: &Gpu) -> Instance {
        let mut instance =
            Instance::new(&gpu.kernels, &gpu.device, &gpu.queue, &self.buffers, Output::Owned).expect("an instance");
        let options = FrameOptions { dynamics: Some(DynamicsOptions::default()), ..FrameOptions::default() };
        instance.set_options(&gpu.queue, &options);
        instance
    }

    /// Plays a frame, or its muscles alone.
    fn play(&self, gpu: &Gpu, instance: &mut Instance, frame: u32, whole: bool) {
        instance.set_pose(&gpu.queue, &self.pose(frame)).expect("a pose");
        gpu.submit(|encoder| instance.batch().encode_where(encoder, None, |step| whole || step.is_of_motion()));
    }

    /// Bits of the vertices of the last of some frames, those before it played whole or their muscles alone.
    fn last(&self, gpu: &Gpu, instance: &mut Instance, frames: std::ops::RangeInclusive<u32>, whole: bool) -> Vec<u32> {
        let last = *frames.end();
        frames.for_each(|frame| self.play(gpu, instance, frame, whole || frame == last));
        readback::read(gpu, instance.output(), ..).expect("vertices")
    }
}

#[test]
fn frames_whose_skin_is_left_out_hand_on_the_same_motion() {
    let Some(gpu) = gpu() else { return };
    let arm = Arm::new(&gpu);
    let whole = arm.last(&gpu, &mut arm.instance(&gpu), 0..=20, true);
    assert!(arm.last(&gpu, &mut arm.instance(&gpu), 0..=20, false) == whole, "frame 20 alone is another one");
    let mut played = arm.instance(&gpu);
    arm.last(&gpu, &mut played, 0..=6, true);
    played.reset(&gpu.queue);
    assert!(arm.last(&gpu, &mut played, 0..=20, true) == whole, "after a reset");
    assert!(arm.last(&gpu, &mut arm.instance(&gpu), 20..=20, true) != whole, "the motion must be seen");
    assert!(played.batch().steps().iter().any(Step::is_of_motion));
}

#[test]
fn a_checkpoint_goes_on_to_the_bit() {
    let Some(gpu) = gpu() else { return };
    let arm = Arm::new(&gpu);
    let mut instance = arm.instance(&gpu);
    let (mut tenth, mut ninth) = (None, None);
    for frame in 0..=10 {
        arm.play(&gpu, &mut instance, frame, false);
        gpu.submit(|encoder| ninth = tenth.replace(instance.save(&gpu.device, encoder)));
    }
    let (tenth, ninth) = (tenth.expect("saved"), ninth.expect("saved"));
    let expected = arm.last(&gpu, &mut instance, 11..=16, false);
    gpu.submit(|encoder| instance.restore(encoder, &tenth));
    assert!(arm.last(&gpu, &mut instance, 11..=16, false) == expected, "back on the same instance");
    let mut other = arm.instance(&gpu);
    gpu.submit(|encoder| other.restore(encoder, &tenth));
    assert!(arm.last(&gpu, &mut other, 11..=16, false) == expected, "on another instance");
    gpu.submit(|encoder| other.restore(encoder, &ninth));
    assert!(arm.last(&gpu, &mut other, 11..=16, false) != expected, "another checkpoint must be seen");
}
