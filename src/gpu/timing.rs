//! How long passes take on the device, by timestamps at their borders.
//!
//! On a software adapter these are times of the processor.

use super::{Headless, readback};
use crate::error::DeviceError;
use std::time::Duration;

/// Timestamps around a fixed number of passes; made once, used every frame.
pub struct Timer {
    queries: wgpu::QuerySet,
    results: wgpu::Buffer,
    passes: u32,
    nanoseconds_per_tick: f32,
}

impl Timer {
    /// A timer for up to `passes` passes a frame; `None` where the adapter takes no timestamps or cannot hold as many.
    pub fn new(headless: &Headless, passes: u32) -> Option<Timer> {
        let fits = passes > 0 && passes <= wgpu::QUERY_SET_MAX_QUERIES / 2;
        if !headless.timestamps || !fits {
            return None;
        }
        let queries = headless.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("timer"),
            ty: wgpu::QueryType::Timestamp,
            count: passes * 2,
        });
        let results = headless.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("timer"),
            size: passes as u64 * 2 * wgpu::QUERY_SIZE as u64,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let nanoseconds_per_tick = headless.queue.get_timestamp_period();
        Some(Timer { queries, results, passes, nanoseconds_per_tick })
    }

    /// What the descriptor of compute pass `pass` needs to be timed; `None` beyond the timer's size.
    pub fn pass(&self, pass: u32) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        (pass < self.passes).then(|| wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(pass * 2),
            end_of_pass_write_index: Some(pass * 2 + 1),
        })
    }

    /// Encodes the gathering of all times behind the timed passes. Every pass of the timer must have been encoded.
    pub fn gather(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..self.passes * 2, &self.results, 0);
    }

    /// Waits for the submitted passes and returns how long each took.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read(&self, headless: &Headless) -> Result<Vec<Duration>, DeviceError> {
        let ticks = readback::read::<[u64; 2]>(headless, &self.results, ..)?;
        let duration = |[begin, end]: [u64; 2]| {
            Duration::from_nanos((end.saturating_sub(begin) as f64 * self.nanoseconds_per_tick as f64) as u64)
        };
        Ok(ticks.into_iter().map(duration).collect())
    }
}
