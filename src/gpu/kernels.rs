//! Pipelines, made once per device.

use crate::{
    error::SetupError,
    kernel::{Access, KERNELS, Kernel, kernel, source::assemble},
    schedule::KernelId,
};
use std::{
    collections::BTreeMap,
    sync::{Arc, OnceLock},
};

/// Every kernel's pipelines and bind group layout on one device.
#[derive(Debug)]
pub struct Kernels {
    pipelines: BTreeMap<KernelId, Arc<Pipelines>>,
}

/// One kernel's pipelines, made when they are first asked for.
#[derive(Debug)]
pub(super) struct Pipelines {
    id: KernelId,
    device: wgpu::Device,
    module: wgpu::ShaderModule,
    layout: wgpu::BindGroupLayout,
    /// One per variant ([`Kernel::variants`]).
    variants: Vec<OnceLock<wgpu::ComputePipeline>>,
}

impl Kernels {
    /// Builds the pipeline of every kernel that has only one; the others are built for the options that need them.
    ///
    /// # Errors
    /// The device has fewer storage buffers per stage or smaller workgroups than WebGPU promises.
    pub fn new(device: &wgpu::Device) -> Result<Kernels, SetupError> {
        let limits = device.limits();
        let most = KERNELS.iter().map(|k| k.bindings.iter().filter(|b| b.access != Access::Uniform).count()).max();
        require(
            "the widest kernel",
            most.unwrap_or(0) as u64,
            "maxStorageBuffersPerShaderStage",
            u64::from(limits.max_storage_buffers_per_shader_stage),
        )?;
        require(
            "a workgroup",
            u64::from(crate::kernel::WORKGROUP),
            "maxComputeInvocationsPerWorkgroup",
            u64::from(limits.max_compute_invocations_per_workgroup),
        )?;
        Ok(Kernels { pipelines: KERNELS.iter().map(|k| (k.id, Arc::new(Pipelines::new(device, k)))).collect() })
    }

    /// The pipeline of a kernel that can do everything.
    pub fn pipeline(&self, id: KernelId) -> &wgpu::ComputePipeline {
        self.variant(id, 0)
    }

    /// One pipeline of a kernel ([`Kernel::all_constants`]).
    ///
    /// # Panics
    /// The kernel has no such variant.
    pub fn variant(&self, id: KernelId, variant: usize) -> &wgpu::ComputePipeline {
        self.pipelines[&id].variant(variant)
    }

    pub(super) fn pipelines(&self, id: KernelId) -> Arc<Pipelines> {
        Arc::clone(&self.pipelines[&id])
    }

    /// Binds buffers to a kernel by name.
    ///
    /// # Errors
    /// A name that the kernel does not have, or one that it has and was not given.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        id: KernelId,
        buffers: &[(&str, &wgpu::Buffer)],
    ) -> Result<wgpu::BindGroup, SetupError> {
        let table = kernel(id);
        let wrong = |binding: &str| SetupError::Binding { kernel: table.stem, binding: binding.to_owned() };
        if let Some((stranger, _)) = buffers.iter().find(|(name, _)| table.bindings.iter().all(|b| b.name != *name)) {
            return Err(wrong(stranger));
        }
        let entries = table
            .bindings
            .iter()
            .enumerate()
            .map(|(slot, binding)| {
                let (_, buffer) =
                    buffers.iter().find(|(n, _)| *n == binding.name).ok_or_else(|| wrong(binding.name))?;
                Ok(wgpu::BindGroupEntry { binding: slot as u32, resource: buffer.as_entire_binding() })
            })
            .collect::<Result<Vec<_>, SetupError>>()?;
        Ok(device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&format!("sinew.{}", table.stem)),
            layout: &self.pipelines[&id].layout,
            entries: &entries,
        }))
    }
}

impl Pipelines {
    fn new(device: &wgpu::Device, kernel: &Kernel) -> Pipelines {
        let label = format!("sinew.{}", kernel.stem);
        let entries: Vec<_> = kernel
            .bindings
            .iter()
            .enumerate()
            .map(|(slot, binding)| wgpu::BindGroupLayoutEntry {
                binding: slot as u32,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: match binding.access {
                        Access::Uniform => wgpu::BufferBindingType::Uniform,
                        Access::Read => wgpu::BufferBindingType::Storage { read_only: true },
                        Access::Write => wgpu::BufferBindingType::Storage { read_only: false },
                    },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        let layout = device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(&label), entries: &entries });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(&label),
            source: wgpu::ShaderSource::Wgsl(assemble(kernel).text.into()),
        });
        let variants = (0..kernel.variants()).map(|_| OnceLock::new()).collect();
        let pipelines = Pipelines { id: kernel.id, device: device.clone(), module, layout, variants };
        if kernel.variants() == 1 {
            pipelines.variant(0);
        }
        pipelines
    }

    pub fn variant(&self, variant: usize) -> &wgpu::ComputePipeline {
        self.variants[variant].get_or_init(|| {
            let kernel = kernel(self.id);
            let label = format!("sinew.{}", kernel.stem);
            let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(&label),
                bind_group_layouts: &[Some(&self.layout)],
                immediate_size: 0,
            });
            self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&label),
                layout: Some(&layout),
                module: &self.module,
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &kernel.all_constants(variant),
                    ..Default::default()
                },
                cache: None,
            })
        })
    }
}

fn require(what: &str, needed: u64, limit: &'static str, had: u64) -> Result<(), SetupError> {
    if needed <= had {
        return Ok(());
    }
    let remedy = "open the device with WebGPU's default limits or better";
    Err(SetupError::Limit { what: what.to_owned(), needed, limit, had, remedy })
}
