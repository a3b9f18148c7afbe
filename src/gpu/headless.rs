//! A device of our own, for the command, tests and benches. An engine brings its own and never comes here.

use crate::error::{DeviceError, one_line};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Longest wait for submitted work; a software adapter may need many seconds for a large picture.
const TIMEOUT: Duration = Duration::from_secs(60);

/// Which adapter to take.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum DeviceChoice {
    /// The best there is: discrete, integrated, virtual, any other, and a software adapter only as the last resort.
    #[default]
    Auto,
    /// A software adapter, which runs on the processor.
    Software,
    /// The best one whose name contains this, whatever the case.
    Named(String),
}

/// A device without a window, its queue, and what went wrong on it.
///
/// Errors that wgpu reports outside of any call are recorded instead of ending the program;
/// [`check`](Headless::check) and [`wait`](Headless::wait) return them.
pub struct Headless {
    /// The device.
    pub device: wgpu::Device,
    /// Its only queue.
    pub queue: wgpu::Queue,
    /// What the adapter says about itself.
    pub info: wgpu::AdapterInfo,
    /// The limits the device was made with: wgpu's defaults, and the adapter's own for buffers and pictures.
    pub limits: wgpu::Limits,
    /// Whether timestamps can be taken at the borders of passes. A software adapter's are not to be trusted: lavapipe
    /// may take both of a compute pass before the work between them.
    pub timestamps: bool,
    failure: Arc<Mutex<Failure>>,
    pub(super) staging: Mutex<Option<wgpu::Buffer>>,
}

#[derive(Default)]
struct Failure {
    /// First error since the last check.
    error: Option<DeviceError>,
    /// Set once, for good.
    lost: Option<DeviceError>,
}

/// What every adapter of this machine says about itself, best first.
pub fn adapters() -> Vec<wgpu::AdapterInfo> {
    sorted_adapters().iter().map(wgpu::Adapter::get_info).collect()
}

fn sorted_adapters() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.sort_by_key(|a| rank(a.get_info().device_type));
    adapters
}

fn rank(device_type: wgpu::DeviceType) -> u32 {
    match device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

/// Index of the adapter that `choice` means, among adapters given best first.
fn choose(found: &[(String, wgpu::DeviceType)], choice: &DeviceChoice) -> Result<usize, DeviceError> {
    if found.is_empty() {
        return Err(DeviceError::NoAdapter);
    }
    let had = || found.iter().map(|(name, _)| name.clone()).collect();
    match choice {
        DeviceChoice::Auto => Ok(0),
        DeviceChoice::Software => found
            .iter()
            .position(|&(_, kind)| kind == wgpu::DeviceType::Cpu)
            .ok_or_else(|| DeviceError::NoSoftwareAdapter { had: had() }),
        DeviceChoice::Named(wanted) => found
            .iter()
            .position(|(name, _)| name.to_lowercase().contains(&wanted.to_lowercase()))
            .ok_or_else(|| DeviceError::NoSuchAdapter { wanted: wanted.clone(), had: had() }),
    }
}

/// wgpu's default limits, raised to the adapter's own where a larger one spares a refusal.
fn wanted_limits(adapter: &wgpu::Limits) -> wgpu::Limits {
    let default = wgpu::Limits::default();
    wgpu::Limits {
        max_buffer_size: adapter.max_buffer_size.max(default.max_buffer_size),
        max_storage_buffer_binding_size: adapter
            .max_storage_buffer_binding_size
            .max(default.max_storage_buffer_binding_size),
        max_storage_buffers_per_shader_stage: adapter
            .max_storage_buffers_per_shader_stage
            .max(default.max_storage_buffers_per_shader_stage),
        max_texture_dimension_2d: adapter.max_texture_dimension_2d.max(default.max_texture_dimension_2d),
        ..default
    }
}

impl Headless {
    /// Opens the adapter that `choice` means.
    ///
    /// # Errors
    /// No adapter, none that fits the choice (the message lists those there are), or an adapter that gives no device.
    pub fn new(choice: &DeviceChoice) -> Result<Headless, DeviceError> {
        let adapters = sorted_adapters();
        let found: Vec<_> = adapters.iter().map(|a| (a.get_info().name, a.get_info().device_type)).collect();
        let adapter = &adapters[choose(&found, choice)?];
        let info = adapter.get_info();
        let limits = wanted_limits(&adapter.limits());
        let features = adapter.features() & wgpu::Features::TIMESTAMP_QUERY;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("sinew"),
            required_features: features,
            required_limits: limits.clone(),
            ..Default::default()
        }))
        .map_err(|e| DeviceError::Refused { adapter: info.name.clone(), reason: one_line(&e.to_string()) })?;

        let failure = Arc::new(Mutex::new(Failure::default()));
        let (name, record) = (info.name.clone(), failure.clone());
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let error = match error {
                wgpu::Error::OutOfMemory { .. } => DeviceError::OutOfMemory { adapter: name.clone() },
                other => DeviceError::Invalid { adapter: name.clone(), reason: one_line(&other.to_string()) },
            };
            locked(&record).error.get_or_insert(error);
        }));
        let (name, record) = (info.name.clone(), failure.clone());
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                let lost = DeviceError::Lost { adapter: name.clone(), reason: one_line(&message) };
                locked(&record).lost.get_or_insert(lost);
            }
        });
        let timestamps = features.contains(wgpu::Features::TIMESTAMP_QUERY);
        Ok(Headless { device, queue, info, limits, timestamps, failure, staging: Mutex::new(None) })
    }

    /// The first error since the last check, if any. A lost device stays lost.
    ///
    /// # Errors
    /// Whatever wgpu reported on this device.
    pub fn check(&self) -> Result<(), DeviceError> {
        let mut failure = locked(&self.failure);
        match failure.lost.clone().or_else(|| failure.error.take()) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// Records commands and submits them; [`wait`](Headless::wait) or a readback waits for them.
    pub fn submit(&self, record: impl FnOnce(&mut wgpu::CommandEncoder)) {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("sinew") });
        record(&mut encoder);
        self.queue.submit([encoder.finish()]);
    }

    /// Records commands, submits them and waits until they are done.
    ///
    /// # Errors
    /// As [`wait`](Headless::wait).
    pub fn run(&self, record: impl FnOnce(&mut wgpu::CommandEncoder)) -> Result<(), DeviceError> {
        self.submit(record);
        self.wait()
    }

    /// Waits until everything submitted so far is done.
    ///
    /// # Errors
    /// [`DeviceError::Timeout`] after 60 s, or whatever [`check`](Headless::check) finds.
    pub fn wait(&self) -> Result<(), DeviceError> {
        self.wait_within(TIMEOUT)
    }

    fn wait_within(&self, timeout: Duration) -> Result<(), DeviceError> {
        let polled = self.device.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(timeout) });
        self.check()?;
        match polled {
            Ok(_) => Ok(()),
            Err(wgpu::PollError::Timeout) => {
                Err(DeviceError::Timeout { adapter: self.info.name.clone(), seconds: timeout.as_secs() })
            }
            Err(other) => Err(DeviceError::Invalid { adapter: self.info.name.clone(), reason: other.to_string() }),
        }
    }

    /// Refuses a buffer that the device cannot hold, before it is made.
    ///
    /// # Errors
    /// [`DeviceError::BufferTooLarge`] with the bytes needed and the bytes had.
    pub fn check_buffer_size(&self, what: &str, needed: u64) -> Result<(), DeviceError> {
        let had = self.limits.max_buffer_size;
        if needed > had { Err(DeviceError::BufferTooLarge { what: what.to_string(), needed, had }) } else { Ok(()) }
    }
}

impl std::fmt::Debug for Headless {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Headless({})", self.info.name)
    }
}

/// The guarded value, also after a panic elsewhere: what is guarded here is whole at any time.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found() -> Vec<(String, wgpu::DeviceType)> {
        vec![
            ("Radeon RX".to_string(), wgpu::DeviceType::DiscreteGpu),
            ("llvmpipe (LLVM 15)".to_string(), wgpu::DeviceType::Cpu),
        ]
    }

    #[test]
    fn choices_pick_what_they_say() {
        assert_eq!(choose(&found(), &DeviceChoice::Auto), Ok(0));
        assert_eq!(choose(&found(), &DeviceChoice::Software), Ok(1));
        assert_eq!(choose(&found(), &DeviceChoice::Named("LLVMPipe".to_string())), Ok(1));
        assert_eq!(choose(&found(), &DeviceChoice::Named("radeon".to_string())), Ok(0));
    }

    #[test]
    fn choices_that_nothing_fits_are_typed() {
        assert_eq!(choose(&[], &DeviceChoice::Auto), Err(DeviceError::NoAdapter));
        assert!(matches!(
            choose(&found(), &DeviceChoice::Named("geforce".to_string())),
            Err(DeviceError::NoSuchAdapter { had, .. }) if had.len() == 2
        ));
        assert!(matches!(
            choose(&found()[..1], &DeviceChoice::Software),
            Err(DeviceError::NoSoftwareAdapter { had }) if had == ["Radeon RX"]
        ));
    }

    #[test]
    fn limits_are_raised_and_never_lowered() {
        let adapter = wgpu::Limits { max_buffer_size: 1 << 40, max_texture_dimension_2d: 64, ..Default::default() };
        let wanted = wanted_limits(&adapter);
        assert_eq!(wanted.max_buffer_size, 1 << 40);
        assert_eq!(wanted.max_texture_dimension_2d, wgpu::Limits::default().max_texture_dimension_2d);
    }
}
