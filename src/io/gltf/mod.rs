//! Reads a rigged character from glTF 2.0: `.glb`, or `.gltf` with data URIs or files beside it.
//!
//! What is read: skinned and rigid triangle meshes of the default scene with every `JOINTS_n`/`WEIGHTS_n` set, skins, painted muscle weights (`_MUSCLE_n`, one float from 0 to 1 per vertex, for
//! muscle n of the muscle file, counted from 0),
//! base colours and their textures, animations of translation, rotation and scale, and keys of muscles through
//! `KHR_animation_pointer` and the extension `SINEW_muscles`. Everything else in the file is set aside before it is looked at, so that it cannot make the file unreadable; what was odd but accepted is
//! listed in [`Scene::notes`].
//!
//! The bytes are taken as hostile: every index, offset and count is checked in 64 bits before it is used, memory is
//! bounded by what the file holds, and no recursion follows the file's own depth. The `gltf` crate lends its JSON
//! types; its validation and accessors are not used, because both trust indices that a file can get wrong.

mod accessor;
mod animation;
mod assemble;
mod buffers;
mod container;
mod influences;
mod lift;
mod material;
mod muscle_keys;
mod nodes;
mod paint;
mod painted;
mod shape;
mod skin;
mod surface;
mod uri;

#[cfg(test)]
mod tests;

pub use paint::with_muscle_weights;

use crate::clip::Scene;
use crate::error::{GltfError, one_line};
use std::cell::RefCell;
use std::path::Path;

/// Notes kept per file; what comes after them is only counted.
const NOTES: usize = 64;

/// Reads the file at `path`, with its buffers and images beside it.
///
/// # Errors
/// [`GltfError`] where the file is not glTF 2.0, is damaged, contradicts itself, or shows no skinned mesh.
pub fn read(path: &Path) -> Result<Scene, GltfError> {
    let file = one_line(&path.display().to_string());
    let bytes = plain_file(path).and_then(|()| std::fs::read(path));
    let bytes = bytes.map_err(|e| GltfError::Unreadable { file: file.clone(), reason: one_line(&e.to_string()) })?;
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let folder = path.parent().unwrap_or(Path::new(""));
    load(&bytes, Some(folder), &Context::new(file), &stem)
}

/// Reads a self-contained file from memory; `name` stands for the file in messages and names the character.
///
/// # Errors
/// As [`read`]; a buffer that is a file of its own counts as missing.
pub fn from_bytes(bytes: &[u8], name: &str) -> Result<Scene, GltfError> {
    load(bytes, None, &Context::new(one_line(name)), name)
}

fn load(bytes: &[u8], folder: Option<&Path>, cx: &Context, name: &str) -> Result<Scene, GltfError> {
    let container = container::split(bytes, cx)?;
    let (root, muscle_keys) = lift::root(container.json, cx)?;
    let graph = nodes::Graph::build(&root, cx)?;
    let buffers = buffers::Buffers::new(&root, container.bin, folder, cx);
    let source = accessor::Source::new(&root, &buffers, cx);
    let mut scene = assemble::scene(&source, graph)?;
    animation::read(&source, &muscle_keys, &mut scene)?;
    scene.character.name = one_line(name);
    scene.notes = cx.take_notes();
    Ok(scene)
}

/// Refuses what is not a plain file: reading a pipe or a device might never end.
fn plain_file(path: &Path) -> std::io::Result<()> {
    if std::fs::metadata(path)?.is_file() { Ok(()) } else { Err(std::io::Error::other("it is not a plain file")) }
}

/// The file being read, for messages, and the notes collected on the way.
struct Context {
    file: String,
    notes: RefCell<Vec<String>>,
    notes_left_out: std::cell::Cell<usize>,
}

impl Context {
    fn new(file: String) -> Context {
        Context { file, notes: RefCell::default(), notes_left_out: Default::default() }
    }

    fn file(&self) -> String {
        self.file.clone()
    }

    fn note(&self, note: String) {
        let mut notes = self.notes.borrow_mut();
        if notes.len() < NOTES {
            notes.push(note);
        } else {
            self.notes_left_out.set(self.notes_left_out.get() + 1);
        }
    }

    fn take_notes(&self) -> Vec<String> {
        let mut notes = self.notes.take();
        match self.notes_left_out.take() {
            0 => {}
            more => notes.push(format!("and {more} more notes of this kind")),
        }
        notes
    }

    fn malformed(&self, element: impl Into<String>, what: impl Into<String>, remedy: &'static str) -> GltfError {
        GltfError::Malformed { file: self.file(), element: element.into(), what: what.into(), remedy }
    }

    fn non_finite(&self, element: impl Into<String>, what: impl Into<String>) -> GltfError {
        GltfError::NonFinite { file: self.file(), element: element.into(), what: what.into() }
    }

    /// An index that points at nothing.
    fn dangling(&self, element: impl Into<String>, kind: &str, index: usize, count: usize) -> GltfError {
        self.malformed(element, format!("refers to {kind} {index} of {count}"), "export the file again")
    }
}

/// An element in words: kind, index and, where it has one, name.
fn label(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => format!("{kind} {index} `{}`", one_line(name)),
        _ => format!("{kind} {index}"),
    }
}
