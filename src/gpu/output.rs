//! Where deformed vertices go: a buffer of ours, or a caller's with its own vertex format.

use super::rig_buffers::fits;
use crate::error::SetupError;

/// Where a vertex lies in the output, in bytes; every number is a multiple of 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutputLayout {
    /// Bytes before the first vertex.
    pub offset: u32,
    /// Bytes from one vertex to the next.
    pub stride: u32,
    /// Bytes from a vertex's start to its position, three `f32` in scene space.
    pub position_at: u32,
    /// Bytes from a vertex's start to its unit normal, three `f32`.
    pub normal_at: u32,
}

impl Default for OutputLayout {
    /// Position and normal, 24 bytes, one after another.
    fn default() -> Self {
        OutputLayout { offset: 0, stride: 24, position_at: 0, normal_at: 12 }
    }
}

impl OutputLayout {
    /// Vertex attributes of the layout: position at location 0, normal at location 1.
    pub fn attributes(&self) -> [wgpu::VertexAttribute; 2] {
        [(self.position_at, 0), (self.normal_at, 1)].map(|(offset, shader_location)| wgpu::VertexAttribute {
            format: wgpu::VertexFormat::Float32x3,
            offset: u64::from(offset),
            shader_location,
        })
    }

    /// Bytes that `vertices` vertices reach to.
    pub fn end(&self, vertices: u64) -> u64 {
        u64::from(self.offset) + u64::from(self.stride) * vertices
    }
}

/// Who owns the output buffer.
#[derive(Clone, Debug)]
pub enum Output {
    /// The library: usable as vertex and storage buffer and as a copy's source, laid out as the default
    /// [`OutputLayout`].
    Owned,
    /// The caller: usage `STORAGE` is needed, and room for every vertex of every instance. Bytes that are neither
    /// position nor normal keep what the caller put there.
    Caller {
        /// The buffer.
        buffer: wgpu::Buffer,
        /// Its vertex format.
        layout: OutputLayout,
    },
}

impl Output {
    pub(super) fn layout(&self) -> OutputLayout {
        match self {
            Output::Owned => OutputLayout::default(),
            Output::Caller { layout, .. } => *layout,
        }
    }

    /// Whether the caller's buffer takes vertices up to byte `end`.
    pub(super) fn check(&self, end: u64, limits: &wgpu::Limits) -> Result<(), SetupError> {
        let Output::Caller { buffer, layout } = self else { return Ok(()) };
        let refuse = |what: String| Err(SetupError::Output { what });
        if !buffer.usage().contains(wgpu::BufferUsages::STORAGE) {
            return refuse("it was made without usage STORAGE".into());
        }
        let OutputLayout { offset, stride, position_at, normal_at } = *layout;
        if [offset, stride, position_at, normal_at].iter().any(|n| n % 4 != 0) {
            return refuse(format!("{layout:?} has a number that is not a multiple of 4"));
        }
        if u64::from(position_at.max(normal_at)) + 12 > u64::from(stride) || position_at.abs_diff(normal_at) < 12 {
            return refuse(format!("{layout:?} leaves no room for 12 bytes each of position and normal"));
        }
        fits(limits, "the caller's output buffer, bound whole", buffer.size())?;
        if end > buffer.size() {
            return refuse(format!("the vertices end at byte {end} and it has {}", buffer.size()));
        }
        Ok(())
    }
}
