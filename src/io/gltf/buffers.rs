//! The bytes behind buffers and buffer views, loaded when first asked for.

use super::{Context, label, uri};
use crate::error::GltfError;
use gltf::json::{Index, Root, buffer};
use std::borrow::Cow;
use std::cell::OnceCell;
use std::io::Read;
use std::path::Path;

type Loaded<'a> = OnceCell<Result<Cow<'a, [u8]>, GltfError>>;

/// All buffers of a file. One that nothing needs is never opened.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    bin: Option<&'a [u8]>,
    folder: Option<&'a Path>,
    cx: &'a Context,
    loaded: Vec<Loaded<'a>>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(root: &'a Root, bin: Option<&'a [u8]>, folder: Option<&'a Path>, cx: &'a Context) -> Self {
        Buffers { root, bin, folder, cx, loaded: root.buffers.iter().map(|_| OnceCell::new()).collect() }
    }

    /// The bytes of a view and its stride, for `element`.
    pub(super) fn view(&self, index: Index<buffer::View>, element: &str) -> Result<(&[u8], Option<usize>), GltfError> {
        let views = &self.root.buffer_views;
        let Some(view) = views.get(index.value()) else {
            return Err(self.cx.dangling(element, "buffer view", index.value(), views.len()));
        };
        let bytes = self.bytes(view.buffer.value(), element)?;
        let offset = view.byte_offset.unwrap_or_default().0;
        let range = offset.checked_add(view.byte_length.0).filter(|&end| end <= bytes.len() as u64);
        let Some(end) = range else {
            return Err(self.cx.malformed(
                element,
                format!(
                    "buffer view {} covers {} bytes from {offset} and its buffer has {}",
                    index.value(),
                    view.byte_length.0,
                    bytes.len()
                ),
                "export the file again",
            ));
        };
        Ok((&bytes[offset as usize..end as usize], view.byte_stride.map(|s| s.0)))
    }

    /// The bytes of a URI that belongs to `element`; at most `limit` of them.
    pub(super) fn fetch(&self, uri: &str, element: &str, limit: u64) -> Result<Vec<u8>, GltfError> {
        let fail = |what: String| GltfError::Buffer { file: self.cx.file(), element: element.into(), what };
        let path = match uri::resolve(uri).map_err(fail)? {
            uri::Target::Data(bytes) => return Ok(bytes),
            uri::Target::File(path) => path,
        };
        let shown = crate::error::one_line(&path.display().to_string());
        let Some(folder) = self.folder else {
            return Err(fail(format!("its bytes are in the file `{shown}`, and this file was read from memory")));
        };
        let path = folder.join(path);
        let mut bytes = Vec::new();
        super::plain_file(&path)
            .and_then(|()| std::fs::File::open(&path))
            .and_then(|file| file.take(limit).read_to_end(&mut bytes))
            .map_err(|e| fail(format!("`{shown}` cannot be read ({e})")))?;
        Ok(bytes)
    }

    fn bytes(&self, index: usize, element: &str) -> Result<&[u8], GltfError> {
        let Some(cell) = self.loaded.get(index) else {
            return Err(self.cx.dangling(element, "buffer", index, self.loaded.len()));
        };
        match cell.get_or_init(|| self.load(index)) {
            Ok(bytes) => Ok(bytes),
            Err(e) => Err(e.clone()),
        }
    }

    fn load(&self, index: usize) -> Result<Cow<'a, [u8]>, GltfError> {
        let buffer = &self.root.buffers[index];
        let element = label("buffer", index, buffer.name.as_deref());
        let declared = buffer.byte_length.0;
        let bytes = match (&buffer.uri, self.bin) {
            (Some(uri), _) => Cow::Owned(self.fetch(uri, &element, declared)?),
            (None, Some(bin)) if index == 0 => Cow::Borrowed(bin),
            (None, _) => {
                let what = "it has no URI and the file has no binary chunk for it".into();
                return Err(GltfError::Buffer { file: self.cx.file(), element, what });
            }
        };
        if (bytes.len() as u64) < declared {
            let what = format!("it declares {declared} bytes and has {}", bytes.len());
            return Err(GltfError::Buffer { file: self.cx.file(), element, what });
        }
        Ok(bytes)
    }
}
