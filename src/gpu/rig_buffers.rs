//! A character's static data on the device, uploaded once and shared by all its instances.

use crate::{dynamics::Bodies, error::SetupError, field::compose, rig::Rig};
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// One character's static buffers.
#[derive(Debug)]
pub struct RigBuffers {
    pub(super) rig: Arc<Rig>,
    pub(super) bodies_rest: Arc<Bodies>,
    pub(super) positions_rest: wgpu::Buffer,
    pub(super) influence_offsets: wgpu::Buffer,
    pub(super) influences: wgpu::Buffer,
    pub(super) muscles: wgpu::Buffer,
    pub(super) wraps: wgpu::Buffer,
    pub(super) nodes: wgpu::Buffer,
    pub(super) targets: wgpu::Buffer,
    pub(super) marched: wgpu::Buffer,
    pub(super) reaches: wgpu::Buffer,
    pub(super) blends: wgpu::Buffer,
    pub(super) edges: wgpu::Buffer,
    pub(super) mean_values: wgpu::Buffer,
    pub(super) fold_patches: wgpu::Buffer,
    pub(super) fold_triangles: wgpu::Buffer,
    pub(super) weight_targets: wgpu::Buffer,
    pub(super) weights: wgpu::Buffer,
    pub(super) joint_rests: wgpu::Buffer,
    pub(super) hybrid_offsets: wgpu::Buffer,
    pub(super) hybrid_influences: wgpu::Buffer,
    pub(super) corners: wgpu::Buffer,
    pub(super) fans: wgpu::Buffer,
    pub(super) fan_members: wgpu::Buffer,
    pub(super) bodies: wgpu::Buffer,
    pub(super) bones: wgpu::Buffer,
    pub(super) links: wgpu::Buffer,
    pub(super) curves: wgpu::Buffer,
    bytes: u64,
}

impl RigBuffers {
    /// Uploads a rig.
    ///
    /// # Errors
    /// A buffer would be larger than the device allows; nothing has been allocated then.
    pub fn upload(device: &wgpu::Device, rig: Arc<Rig>) -> Result<RigBuffers, SetupError> {
        let character = &rig.character;
        let bodies_rest = Arc::new(Bodies::new(&rig));
        let data: [(&'static str, &[u8]); 25] = [
            ("positions at rest", bytemuck::cast_slice(&rig.positions_rest)),
            ("influence offsets", bytemuck::cast_slice(&character.influence_offsets)),
            ("influences", bytemuck::cast_slice(&character.influences)),
            ("muscles", bytemuck::cast_slice(&rig.muscles)),
            ("wraps", bytemuck::cast_slice(&rig.wraps)),
            ("field grids", bytemuck::cast_slice(&rig.nodes)),
            ("vertex targets", bytemuck::cast_slice(&rig.targets.vertices)),
            ("marched targets", bytemuck::cast_slice(&rig.targets.marched)),
            ("reaches", bytemuck::cast_slice(&rig.targets.reaches)),
            ("blended joints", bytemuck::cast_slice(&rig.targets.blends)),
            ("skin edges", bytemuck::cast_slice(&rig.graph.edges)),
            ("mean value coordinates", bytemuck::cast_slice(&rig.mean_values)),
            ("folds", bytemuck::cast_slice(&rig.fold_patches)),
            ("triangles of folds", bytemuck::cast_slice(&rig.fold_triangles)),
            ("vertices of muscle weights", bytemuck::cast_slice(&rig.weights.vertices)),
            ("muscle weights", bytemuck::cast_slice(&rig.weights.weights)),
            ("muscle joints at rest", bytemuck::cast_slice(&rig.muscle_joints.joints)),
            ("offsets of bones and muscles", bytemuck::cast_slice(&rig.muscle_joints.offsets)),
            ("influences of bones and muscles", bytemuck::cast_slice(&rig.muscle_joints.influences)),
            ("triangles", bytemuck::cast_slice(&rig.topology.corners)),
            ("fans", bytemuck::cast_slice(&rig.topology.fans)),
            ("fan members", bytemuck::cast_slice(&rig.topology.members)),
            ("muscle bodies", bytemuck::cast_slice(&bodies_rest.muscles)),
            ("bones", bytemuck::cast_slice(&bodies_rest.bones)),
            ("links", bytemuck::cast_slice(&bodies_rest.links)),
        ];
        let bytes = data.iter().map(|(_, bytes)| bytes.len() as u64).sum();
        let limits = device.limits();
        for (name, bytes) in &data {
            fits(&limits, &format!("`{}`: {name}", character.name), bytes.len() as u64)?;
        }
        let [
            positions_rest,
            influence_offsets,
            influences,
            muscles,
            wraps,
            nodes,
            targets,
            marched,
            reaches,
            blends,
            edges,
            mean_values,
            fold_patches,
            fold_triangles,
            weight_targets,
            weights,
            joint_rests,
            hybrid_offsets,
            hybrid_influences,
            corners,
            fans,
            fan_members,
            bodies,
            bones,
            links,
        ] = data.map(|(name, bytes)| upload(device, name, bytes, wgpu::BufferUsages::STORAGE));
        let curves = bytemuck::cast_slice(compose::curves());
        let curves = upload(device, "operators", curves, wgpu::BufferUsages::UNIFORM);
        Ok(RigBuffers {
            rig,
            bodies_rest,
            positions_rest,
            influence_offsets,
            influences,
            muscles,
            wraps,
            nodes,
            targets,
            marched,
            reaches,
            blends,
            edges,
            mean_values,
            fold_patches,
            fold_triangles,
            weight_targets,
            weights,
            joint_rests,
            hybrid_offsets,
            hybrid_influences,
            corners,
            fans,
            fan_members,
            bodies,
            bones,
            links,
            curves,
            bytes,
        })
    }

    /// Bytes on the device, shared by all instances.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The rig that was uploaded.
    pub fn rig(&self) -> &Arc<Rig> {
        &self.rig
    }
}

/// Smallest buffer that is made: WebGPU refuses empty bindings, and no kernel's array element is larger.
pub(super) const MIN_BYTES: u64 = 256;

fn upload(device: &wgpu::Device, name: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let label = format!("sinew.{name}");
    if bytes.len() as u64 >= MIN_BYTES {
        return device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(&label),
            contents: bytes,
            usage,
        });
    }
    let mut padded = bytes.to_vec();
    padded.resize(MIN_BYTES as usize, 0);
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(&label), contents: &padded, usage })
}

/// Whether a storage buffer of `bytes` may be made and bound whole.
///
/// # Errors
/// It may not: which limit, the number needed and the number had.
pub fn fits(limits: &wgpu::Limits, what: &str, bytes: u64) -> Result<(), SetupError> {
    let remedy = "open the device with larger limits, batch fewer instances, or use a coarser mesh";
    for (limit, had) in [
        ("maxStorageBufferBindingSize", limits.max_storage_buffer_binding_size),
        ("maxBufferSize", limits.max_buffer_size),
    ] {
        if bytes > had {
            return Err(SetupError::Limit {
                what: format!("{what} ({bytes} bytes)"),
                needed: bytes,
                limit,
                had,
                remedy,
            });
        }
    }
    Ok(())
}
