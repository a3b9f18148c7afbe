//! The pipelines of one device.

use super::mesh::VERTEX_STRIDE;
use super::shader::{self, Module};
use super::targets::{COLOR_FORMAT, DEPTH_FORMAT, SAMPLES};
use wgpu::{VertexFormat, VertexStepMode};

/// Pipelines and layouts; made once per device.
pub struct Renderer {
    pub(super) view_layout: wgpu::BindGroupLayout,
    pub(super) material_layout: wgpu::BindGroupLayout,
    /// The backdrop, behind everything.
    pub(super) background: wgpu::RenderPipeline,
    /// Coloured meshes.
    pub(super) solid: wgpu::RenderPipeline,
    /// Opaque skin.
    pub(super) skin: wgpu::RenderPipeline,
    /// Depth of the skin alone, before its glass.
    pub(super) skin_depth: wgpu::RenderPipeline,
    /// Glass, on the skin's front-most layer.
    pub(super) skin_ghost: wgpu::RenderPipeline,
}

/// Bytes of a coloured vertex: position, normal, colour.
pub(super) const SOLID_STRIDE: u64 = 36;

const VERTEX: [wgpu::VertexAttribute; 2] = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
const UV: [wgpu::VertexAttribute; 1] = wgpu::vertex_attr_array![2 => Float32x2];
const MODEL: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![3 => Float32x4, 4 => Float32x4, 5 => Float32x4, 6 => Float32x4];
const SOLID: [wgpu::VertexAttribute; 3] = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3];

const fn layout(
    array_stride: u64,
    step_mode: VertexStepMode,
    attributes: &[wgpu::VertexAttribute],
) -> Option<wgpu::VertexBufferLayout<'_>> {
    Some(wgpu::VertexBufferLayout { array_stride, step_mode, attributes })
}

const SURFACE_BUFFERS: [Option<wgpu::VertexBufferLayout<'static>>; 3] = [
    layout(VERTEX_STRIDE, VertexStepMode::Vertex, &VERTEX),
    layout(VertexFormat::Float32x2.size(), VertexStepMode::Vertex, &UV),
    layout(64, VertexStepMode::Instance, &MODEL),
];
const SOLID_BUFFERS: [Option<wgpu::VertexBufferLayout<'static>>; 1] =
    [layout(SOLID_STRIDE, VertexStepMode::Vertex, &SOLID)];

/// What tells one pipeline from another.
struct Kind<'a> {
    label: &'a str,
    module: &'a wgpu::ShaderModule,
    layout: &'a wgpu::PipelineLayout,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    vertex: &'a str,
    fragment: &'a str,
    compare: wgpu::CompareFunction,
    writes_depth: bool,
    blend: Option<wgpu::BlendState>,
    colors: wgpu::ColorWrites,
}

fn pipeline(device: &wgpu::Device, kind: &Kind<'_>) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(kind.label),
        layout: Some(kind.layout),
        vertex: wgpu::VertexState {
            module: kind.module,
            entry_point: Some(kind.vertex),
            compilation_options: Default::default(),
            buffers: kind.buffers,
        },
        // Nothing is culled: many models are open, and glTF's single-sided ones still look better whole than pierced.
        primitive: wgpu::PrimitiveState { cull_mode: None, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(kind.writes_depth),
            depth_compare: Some(kind.compare),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: SAMPLES, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: kind.module,
            entry_point: Some(kind.fragment),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: COLOR_FORMAT,
                blend: kind.blend,
                write_mask: kind.colors,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn uniform_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

impl Renderer {
    /// Compiles every pipeline. What the device has against it shows in [`Headless::check`](crate::gpu::Headless::check).
    pub fn new(device: &wgpu::Device) -> Renderer {
        let module = |m: &Module| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(m.name),
                source: wgpu::ShaderSource::Wgsl(m.source().into()),
            })
        };
        let (background, solid, surface) =
            (module(&shader::BACKGROUND), module(&shader::SOLID), module(&shader::SURFACE));
        let view_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("view"),
            entries: &[uniform_entry(0)],
        });
        let fragment_entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let material_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("material"),
            entries: &[
                uniform_entry(0),
                fragment_entry(
                    1,
                    wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: true },
                        view_dimension: wgpu::TextureViewDimension::D2,
                        multisampled: false,
                    },
                ),
                fragment_entry(2, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
            ],
        });
        let pipeline_layout = |label, groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let plain = pipeline_layout("plain", &[Some(&view_layout)]);
        let textured = pipeline_layout("textured", &[Some(&view_layout), Some(&material_layout)]);

        let opaque_skin = Kind {
            label: "skin",
            module: &surface,
            layout: &textured,
            buffers: &SURFACE_BUFFERS,
            vertex: "surface_vertex",
            fragment: "surface_skin",
            compare: wgpu::CompareFunction::Less,
            writes_depth: true,
            blend: None,
            colors: wgpu::ColorWrites::ALL,
        };
        let skin_depth =
            Kind { label: "skin depth", fragment: "surface_depth", colors: wgpu::ColorWrites::empty(), ..opaque_skin };
        let skin_ghost = Kind {
            label: "skin ghost",
            fragment: "surface_ghost",
            compare: wgpu::CompareFunction::LessEqual,
            writes_depth: false,
            blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
            ..opaque_skin
        };
        let coloured = Kind {
            label: "solid",
            module: &solid,
            layout: &plain,
            buffers: &SOLID_BUFFERS,
            vertex: "solid_vertex",
            fragment: "solid_fragment",
            ..opaque_skin
        };
        let backdrop = Kind {
            label: "background",
            module: &background,
            buffers: &[],
            vertex: "background_vertex",
            fragment: "background_fragment",
            compare: wgpu::CompareFunction::Always,
            writes_depth: false,
            ..coloured
        };
        Renderer {
            background: pipeline(device, &backdrop),
            solid: pipeline(device, &coloured),
            skin: pipeline(device, &opaque_skin),
            skin_depth: pipeline(device, &skin_depth),
            skin_ghost: pipeline(device, &skin_ghost),
            view_layout,
            material_layout,
        }
    }
}
