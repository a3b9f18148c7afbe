//! Every intermediate of a frame brought back from the GPU.

use super::GpuResult;
use crate::{
    error::DeviceError,
    gpu::{Batch, Headless, OutputLayout, readback},
    schedule::{KernelId, Positions},
};

/// Reads back what the last submitted frame of a batch left for one instance: the stages that its steps ran.
///
/// # Errors
/// What the device reports, or an output with a layout of the caller's own, which is the caller's to read.
pub fn capture(headless: &Headless, batch: &Batch, instance: u32) -> Result<GpuResult, DeviceError> {
    if batch.layout() != OutputLayout::default() {
        let problem = "it has a layout of the caller's own".to_owned();
        return Err(DeviceError::Readback { what: "the output buffer".to_owned(), problem });
    }
    let range = |kernel: &[KernelId]| {
        let items = batch.steps().iter().find(|s| kernel.contains(&s.kernel)).map_or(0, |s| s.items as usize);
        let first = instance as usize * items;
        first..first + items
    };
    let skin = range(&[KernelId::SkinLinear, KernelId::SkinDualQuaternion, KernelId::SkinHybrid]);
    let shapes = batch.steps().iter().any(|s| s.kernel == KernelId::MuscleShape);
    let points = if shapes { batch.rig().point_count as usize } else { 0 };
    let axes = instance as usize * points..(instance as usize + 1) * points;
    let moves = batch.steps().iter().any(|s| s.kernel == KernelId::MusclePredict);
    let particles = if moves { axes.clone() } else { 0..0 };
    let track = range(&[KernelId::TrackSpread]);
    let placed = range(&[KernelId::TrackSpread, KernelId::SkinWeighted]);
    Ok(GpuResult {
        skinned: readback::read(headless, batch.positions(Positions::Skinned), skin)?,
        muscles: readback::read(headless, batch.muscles(), range(&[KernelId::MuscleShape]))?,
        axes: readback::read(headless, batch.axes(), axes)?,
        particles: readback::read(headless, batch.particles(), particles)?,
        tracked: readback::read(headless, batch.positions(Positions::Tracked), placed)?,
        tracks: readback::read(headless, batch.tracks(), track)?,
        vertices: readback::read(headless, batch.output(), range(&[KernelId::Normals]))?,
    })
}
