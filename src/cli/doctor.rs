//! `sinew doctor`: what this machine offers and what is missing.

use crate::args;
use crate::failure::Failure;
use crate::print;
use serde::Serialize;
use std::fmt::Write;

#[derive(Serialize)]
struct Diagnosis {
    sinew: &'static str,
    gpu_support: bool,
    threads: usize,
    adapters: Vec<Adapter>,
    /// Limits of the device that `--device auto` opens.
    limits: Option<Limits>,
    missing: Vec<String>,
}

#[derive(Serialize)]
struct Adapter {
    name: String,
    kind: String,
    backend: String,
    driver: String,
}

#[derive(Serialize)]
struct Limits {
    adapter: String,
    buffer_bytes: u64,
    storage_binding_bytes: u64,
    storage_buffers_per_stage: u32,
    picture_side: u32,
    timestamps: bool,
}

pub fn run(args: &args::Doctor) -> Result<(), Failure> {
    let mut diagnosis = Diagnosis {
        sinew: env!("CARGO_PKG_VERSION"),
        gpu_support: cfg!(feature = "gpu"),
        threads: rayon::current_num_threads(),
        adapters: Vec::new(),
        limits: None,
        missing: Vec::new(),
    };
    let found = adapters(&mut diagnosis);
    if let Err(Failure::Device(text)) = &found {
        diagnosis.missing.push(text.clone());
    }
    print::result(args.json, &diagnosis, text)?;
    found
}

#[cfg(not(feature = "gpu"))]
fn adapters(_: &mut Diagnosis) -> Result<(), Failure> {
    Err(Failure::Device("this sinew was built without GPU support; build it with feature `gpu`".into()))
}

#[cfg(feature = "gpu")]
fn adapters(diagnosis: &mut Diagnosis) -> Result<(), Failure> {
    diagnosis.adapters = sinew::gpu::adapters()
        .iter()
        .map(|info| Adapter {
            name: info.name.clone(),
            kind: format!("{:?}", info.device_type),
            backend: info.backend.to_string(),
            driver: [info.driver.as_str(), info.driver_info.as_str()].join(" ").trim().to_owned(),
        })
        .collect();
    let headless = crate::device::open(&args::Device::Auto)?;
    diagnosis.limits = Some(Limits {
        adapter: headless.info.name.clone(),
        buffer_bytes: headless.limits.max_buffer_size,
        storage_binding_bytes: headless.limits.max_storage_buffer_binding_size,
        storage_buffers_per_stage: headless.limits.max_storage_buffers_per_shader_stage,
        picture_side: headless.limits.max_texture_dimension_2d,
        timestamps: headless.timestamps,
    });
    Ok(())
}

fn text(d: &Diagnosis) -> String {
    let mut text = format!("sinew {}, {} threads for the CPU reference\n", d.sinew, d.threads);
    // Writing to a string cannot fail.
    for a in &d.adapters {
        let _ = writeln!(text, "adapter: {} ({}, {}), driver {}", a.name, a.kind, a.backend, a.driver);
    }
    if let Some(l) = &d.limits {
        let _ = writeln!(
            text,
            "--device auto takes {}: buffers to {} MiB, bound to {} MiB, {} storage buffers per stage, pictures to {} pixels a side, timestamps {}",
            l.adapter,
            l.buffer_bytes >> 20,
            l.storage_binding_bytes >> 20,
            l.storage_buffers_per_stage,
            l.picture_side,
            if l.timestamps { "yes" } else { "no" }
        );
    }
    for missing in &d.missing {
        let _ = writeln!(text, "missing: {missing}");
    }
    text
}
