//! Accessors: typed arrays in buffer views, with stride, normalised integers and sparse overlays.

use super::Context;
use super::buffers::Buffers;
use crate::error::GltfError;
use gltf::json::accessor::{Accessor, ComponentType, Type, sparse::Sparse};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};
use std::cell::Cell;

/// Numbers that one file may have decoded in all, so that small arrays used many times cannot exhaust memory. A skin of
/// 2,000,000 vertices with two sets of influences takes a third of it.
const NUMBERS: u64 = 1 << 27;
/// The same for accessors without bytes behind them, whose count costs a file nothing.
const ZEROS: u64 = 1 << 24;

/// A file's accessors.
pub(super) struct Source<'a> {
    pub root: &'a Root,
    pub buffers: &'a Buffers<'a>,
    pub cx: &'a Context,
    numbers_left: Cell<u64>,
    zeros_left: Cell<u64>,
}

/// How the numbers of an accessor are stored.
#[derive(Clone, Copy)]
struct Layout {
    component: ComponentType,
    normalised: bool,
    per_element: usize,
    count: usize,
}

impl<'a> Source<'a> {
    pub(super) fn new(root: &'a Root, buffers: &'a Buffers<'a>, cx: &'a Context) -> Self {
        Source { root, buffers, cx, numbers_left: Cell::new(NUMBERS), zeros_left: Cell::new(ZEROS) }
    }

    /// Decodes an accessor of one of the given types to decimals, flattened; normalised integers by glTF's formulas.
    pub(super) fn decimals(&self, index: Index<Accessor>, types: &[Type], of: &str) -> Result<Vec<f32>, GltfError> {
        let element = format!("{of} (accessor {})", index.value());
        let layout = self.layout(index, types, &element)?;
        if layout.component == ComponentType::U32 {
            return Err(self.cx.malformed(element, "32-bit integers cannot be used here", "export it as floats"));
        }
        self.decode(index, layout, &element, |bytes| decimal(layout.component, layout.normalised, bytes))
    }

    /// Decodes an accessor of one of the given types to unsigned integers, flattened.
    pub(super) fn integers(&self, index: Index<Accessor>, types: &[Type], of: &str) -> Result<Vec<u32>, GltfError> {
        let element = format!("{of} (accessor {})", index.value());
        let layout = self.layout(index, types, &element)?;
        let unsigned = matches!(layout.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
        if !unsigned {
            let what = format!("{:?} components cannot be used here", layout.component);
            return Err(self.cx.malformed(element, what, "export it as unsigned integers"));
        }
        self.decode(index, layout, &element, |bytes| unsigned_integer(layout.component, bytes))
    }

    /// Whether an accessor declares that it has no elements. One that is not there declares nothing.
    pub(super) fn is_empty(&self, index: Index<Accessor>) -> bool {
        self.root.accessors.get(index.value()).is_some_and(|a| a.count.0 == 0)
    }

    fn layout(&self, index: Index<Accessor>, types: &[Type], element: &str) -> Result<Layout, GltfError> {
        let accessors = &self.root.accessors;
        let Some(accessor) = accessors.get(index.value()) else {
            return Err(self.cx.dangling(element, "accessor", index.value(), accessors.len()));
        };
        let remedy = "export the file again";
        let Checked::Valid(component) = accessor.component_type.as_ref() else {
            return Err(self.cx.malformed(element, "its componentType is unknown", remedy));
        };
        let type_ = match accessor.type_.as_ref() {
            Checked::Valid(type_) if types.contains(type_) => type_,
            Checked::Valid(type_) => {
                return Err(self.cx.malformed(element, format!("it is {type_:?} where {types:?} is needed"), remedy));
            }
            Checked::Invalid => return Err(self.cx.malformed(element, "its type is unknown", remedy)),
        };
        let per_element = type_.multiplicity();
        let asked = accessor.count.0.saturating_mul(per_element as u64);
        let budget = if accessor.buffer_view.is_some() { &self.numbers_left } else { &self.zeros_left };
        let Some(left) = budget.get().checked_sub(asked) else {
            let allowed = budget.get();
            return Err(GltfError::TooLarge { file: self.cx.file(), element: element.into(), asked, allowed });
        };
        budget.set(left);
        let count = accessor.count.0 as usize;
        Ok(Layout { component: component.0, normalised: accessor.normalized, per_element, count })
    }

    fn decode<T: Copy + Default>(
        &self,
        index: Index<Accessor>,
        layout: Layout,
        element: &str,
        convert: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, GltfError> {
        let accessor = &self.root.accessors[index.value()];
        let size = layout.component.size();
        let element_size = size * layout.per_element;
        let mut numbers = Vec::new();
        match accessor.buffer_view {
            Some(view) => {
                let (bytes, stride) = self.buffers.view(view, element)?;
                let offset = accessor.byte_offset.unwrap_or_default().0;
                let strided = strided(bytes, offset, stride, element_size, layout.count as u64)
                    .map_err(|what| self.cx.malformed(element, what, "export the file again"))?;
                numbers.reserve_exact(layout.count * layout.per_element);
                for item in strided {
                    numbers.extend(item.chunks_exact(size).map(&convert));
                }
            }
            None => numbers.resize(layout.count * layout.per_element, T::default()),
        }
        if let Some(sparse) = &accessor.sparse {
            self.overlay(sparse, layout, element, &mut numbers, &convert)?;
        }
        Ok(numbers)
    }

    /// Lays the elements of a sparse accessor over its base.
    fn overlay<T>(
        &self,
        sparse: &Sparse,
        layout: Layout,
        element: &str,
        numbers: &mut [T],
        convert: &impl Fn(&[u8]) -> T,
    ) -> Result<(), GltfError> {
        let element = format!("{element}, sparse");
        let fail = |what: String| self.cx.malformed(element.as_str(), what, "export the file again");
        let Checked::Valid(index_type) = sparse.indices.component_type.as_ref() else {
            return Err(fail("the componentType of its indices is unknown".into()));
        };
        let (index_bytes, _) = self.buffers.view(sparse.indices.buffer_view, &element)?;
        let (value_bytes, _) = self.buffers.view(sparse.values.buffer_view, &element)?;
        let size = layout.component.size();
        let count = sparse.count.0;
        let index_size = index_type.0.size();
        let indices = strided(index_bytes, sparse.indices.byte_offset.0, None, index_size, count).map_err(fail)?;
        let value_size = size * layout.per_element;
        let values = strided(value_bytes, sparse.values.byte_offset.0, None, value_size, count).map_err(fail)?;
        for (index, value) in indices.zip(values) {
            let at = unsigned_integer(index_type.0, index) as usize;
            if at >= layout.count {
                return Err(fail(format!("it replaces element {at} of {}", layout.count)));
            }
            let target = &mut numbers[at * layout.per_element..(at + 1) * layout.per_element];
            target.iter_mut().zip(value.chunks_exact(size)).for_each(|(to, from)| *to = convert(from));
        }
        Ok(())
    }
}

/// `count` elements of `size` bytes, `stride` bytes apart, all of them inside `bytes`; the error says what is missing.
fn strided(
    bytes: &[u8],
    offset: u64,
    stride: Option<usize>,
    size: usize,
    count: u64,
) -> Result<impl Iterator<Item = &[u8]>, String> {
    let stride = stride.unwrap_or(size);
    if stride < size {
        return Err(format!("its stride of {stride} bytes is less than an element's {size}"));
    }
    let need = match count.checked_sub(1) {
        Some(steps) => steps.checked_mul(stride as u64).and_then(|b| b.checked_add(size as u64)),
        None => Some(0),
    };
    let have = bytes.len() as u64;
    match need.and_then(|need| need.checked_add(offset)) {
        Some(end) if end <= have => {
            let start = if count == 0 { bytes.len() } else { offset as usize };
            Ok(bytes[start..].chunks(stride).take(count as usize).map(move |chunk| &chunk[..size]))
        }
        Some(end) => Err(format!("its {count} elements end at byte {end} of a view of {have} bytes")),
        None => Err(format!("its {count} elements pass any view's end")),
    }
}

/// One component as a decimal, by the formulas of glTF 2.0, section 3.11.
fn decimal(component: ComponentType, normalised: bool, bytes: &[u8]) -> f32 {
    let (value, full) = match (component, bytes) {
        (ComponentType::I8, &[b]) => (f32::from(b as i8), 127.0),
        (ComponentType::U8, &[b]) => (f32::from(b), 255.0),
        (ComponentType::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
        (ComponentType::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
        (ComponentType::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
        _ => return 0.0,
    };
    if normalised { (value / full).max(-1.0) } else { value }
}

fn unsigned_integer(component: ComponentType, bytes: &[u8]) -> u32 {
    match (component, bytes) {
        (ComponentType::U8, &[b]) => u32::from(b),
        (ComponentType::U16, &[a, b]) => u32::from(u16::from_le_bytes([a, b])),
        (ComponentType::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
        _ => 0,
    }
}
