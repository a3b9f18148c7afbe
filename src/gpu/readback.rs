//! Bringing results to the host: the one place that maps memory.

use super::headless::{Headless, locked};
use crate::error::DeviceError;
use std::ops::{Bound, RangeBounds};
use std::sync::mpsc;

/// Elements `range` of `buffer`, counted in `T`; `..` is the whole buffer.
///
/// Waits for everything submitted before. `buffer` needs `COPY_SRC`; borders must fall on multiples of 4 bytes.
///
/// # Errors
/// [`DeviceError::Readback`] for a range outside the buffer, a border inside a word, or a buffer that cannot be copied;
/// otherwise what the device reports.
pub fn read<T: bytemuck::Pod>(
    headless: &Headless,
    buffer: &wgpu::Buffer,
    range: impl RangeBounds<usize>,
) -> Result<Vec<T>, DeviceError> {
    let problem = |problem: String| DeviceError::Readback { what: "a buffer".to_string(), problem };
    let size = size_of::<T>().max(1);
    let count = buffer.size() as usize / size;
    let begin = match range.start_bound() {
        Bound::Included(&b) => b,
        Bound::Excluded(&b) => b.saturating_add(1),
        Bound::Unbounded => 0,
    };
    let end = match range.end_bound() {
        Bound::Included(&e) => e.saturating_add(1),
        Bound::Excluded(&e) => e,
        Bound::Unbounded => count,
    };
    if begin > end || end > count {
        return Err(problem(format!("elements {begin}..{end} of {count} were asked for")));
    }
    if !buffer.usage().contains(wgpu::BufferUsages::COPY_SRC) {
        return Err(problem("it was made without COPY_SRC".to_string()));
    }
    let (offset, bytes) = ((begin * size) as u64, ((end - begin) * size) as u64);
    if offset % wgpu::COPY_BUFFER_ALIGNMENT != 0 || bytes % wgpu::COPY_BUFFER_ALIGNMENT != 0 {
        return Err(problem(format!("{bytes} bytes at {offset} are not whole words of 4 bytes")));
    }
    if bytes == 0 {
        return Ok(Vec::new());
    }
    staged(
        headless,
        bytes,
        |encoder, staging| encoder.copy_buffer_to_buffer(buffer, offset, staging, 0, bytes),
        bytemuck::pod_collect_to_vec,
    )
}

/// Bytes of the first mip level of a 2D texture with 4 bytes a pixel, rows from the top without gaps.
///
/// # Errors
/// [`DeviceError::Readback`] for a texture that cannot be copied, [`DeviceError::BufferTooLarge`] for one that does
/// not fit into a buffer; otherwise what the device reports.
pub fn read_rgba(headless: &Headless, texture: &wgpu::Texture) -> Result<Vec<u8>, DeviceError> {
    let four_bytes = texture.format().block_copy_size(None) == Some(4) && texture.sample_count() == 1;
    if !four_bytes || !texture.usage().contains(wgpu::TextureUsages::COPY_SRC) {
        let problem = format!("a {:?} texture made for {:?}", texture.format(), texture.usage());
        return Err(DeviceError::Readback { what: "a picture".to_string(), problem });
    }
    let row = texture.width() * 4;
    let padded = padded_row(texture.width());
    let bytes = picture_bytes(texture.width(), texture.height());
    headless.check_buffer_size("reading a picture", bytes)?;
    staged(
        headless,
        bytes,
        |encoder, staging| {
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None };
            encoder.copy_texture_to_buffer(
                texture.as_image_copy(),
                wgpu::TexelCopyBufferInfo { buffer: staging, layout },
                texture.size(),
            );
        },
        |mapped| mapped.chunks_exact(padded as usize).flat_map(|line| &line[..row as usize]).copied().collect(),
    )
}

/// Bytes of the buffer through which a picture with 4 bytes a pixel is read back.
pub fn picture_bytes(width: u32, height: u32) -> u64 {
    padded_row(width) as u64 * height as u64
}

fn padded_row(width: u32) -> u32 {
    (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

/// Copies into the staging buffer, waits, maps it and hands the bytes to `take`. The buffer is kept for the next call.
fn staged<R>(
    headless: &Headless,
    bytes: u64,
    copy: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::Buffer),
    take: impl FnOnce(&[u8]) -> R,
) -> Result<R, DeviceError> {
    headless.check_buffer_size("reading back", bytes)?;
    let kept = locked(&headless.staging).take().filter(|b| b.size() >= bytes);
    let staging = kept.unwrap_or_else(|| {
        headless.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size: bytes,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    });
    let mut encoder =
        headless.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("readback") });
    copy(&mut encoder, &staging);
    headless.queue.submit([encoder.finish()]);
    let (sender, receiver) = mpsc::channel();
    staging.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
        // The receiver is gone only if waiting failed, and then that is the error to report.
        let _ = sender.send(result);
    });
    headless.wait()?;
    let unmapped = |reason: String| DeviceError::Readback { what: "staging memory".to_string(), problem: reason };
    receiver.try_recv().map_err(|e| unmapped(e.to_string()))?.map_err(|e| unmapped(e.to_string()))?;
    let view = staging.get_mapped_range(..bytes).map_err(|e| unmapped(e.to_string()))?;
    let result = take(&view);
    drop(view);
    staging.unmap();
    *locked(&headless.staging) = Some(staging);
    Ok(result)
}
