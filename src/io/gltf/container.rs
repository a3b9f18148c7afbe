//! The outermost layer: GLB framing, or plain JSON text.

use super::Context;
use crate::error::{GltfError, one_line};

const MAGIC: &[u8] = b"glTF";
const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BIN_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");
const BYTE_ORDER_MARK: &[u8] = &[0xEF, 0xBB, 0xBF];

/// The two payloads of a file.
pub(super) struct Container<'a> {
    /// The JSON text.
    pub json: &'a [u8],
    /// The binary chunk of a GLB.
    pub bin: Option<&'a [u8]>,
}

/// Tells GLB from text and takes the file apart.
pub(super) fn split<'a>(bytes: &'a [u8], cx: &Context) -> Result<Container<'a>, GltfError> {
    let container = match bytes.starts_with(MAGIC) {
        true => split_glb(bytes, cx)?,
        false => Container { json: bytes, bin: None },
    };
    let json = container.json.strip_prefix(BYTE_ORDER_MARK).unwrap_or(container.json);
    match json.iter().find(|b| !b.is_ascii_whitespace()) {
        Some(b'{') => Ok(Container { json, bin: container.bin }),
        Some(_) => {
            let start = one_line(&String::from_utf8_lossy(&json[..json.len().min(12)]));
            Err(GltfError::NotGltf { file: cx.file(), what: format!("it starts with `{start}`") })
        }
        None => Err(GltfError::NotGltf { file: cx.file(), what: "it is empty".into() }),
    }
}

/// A GLB of both payloads, each filled up to whole words.
pub(super) fn join(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let mut bytes = [MAGIC, &2u32.to_le_bytes(), &[0; 4]].concat();
    for (kind, payload, filler) in [(JSON_CHUNK, json, b' '), (BIN_CHUNK, bin, 0)] {
        let size = payload.len().next_multiple_of(4);
        bytes.extend((size as u32).to_le_bytes());
        bytes.extend(kind.to_le_bytes());
        bytes.extend(payload);
        bytes.resize(bytes.len() + size - payload.len(), filler);
    }
    let length = bytes.len() as u32;
    bytes[8..12].copy_from_slice(&length.to_le_bytes());
    bytes
}

fn split_glb<'a>(bytes: &'a [u8], cx: &Context) -> Result<Container<'a>, GltfError> {
    let framing = |what: String| GltfError::Framing { file: cx.file(), what };
    let word = |at: usize| -> Option<u32> {
        let four = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(four.try_into().ok()?))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(framing(format!("it ends after {} bytes, inside its header", bytes.len())));
    };
    if version != 2 {
        return Err(GltfError::Version { file: cx.file(), version: format!("{version} (binary)") });
    }
    let length = length as usize;
    if length > bytes.len() {
        return Err(framing(format!("its header promises {length} bytes and it has {}", bytes.len())));
    }
    let (mut json, mut bin) = (None, None);
    let mut at = 12;
    while at + 8 <= length {
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else { break };
        let start = at + 8;
        let Some(chunk) = start.checked_add(size as usize).filter(|&end| end <= length).map(|end| &bytes[start..end])
        else {
            return Err(framing(format!("the chunk at byte {at} promises {size} bytes, {} are left", length - start)));
        };
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(chunk),
            BIN_CHUNK if bin.is_none() => bin = Some(chunk),
            _ => {}
        }
        at = start + chunk.len();
    }
    let json = json.ok_or_else(|| framing("it has no JSON chunk".into()))?;
    Ok(Container { json, bin })
}
