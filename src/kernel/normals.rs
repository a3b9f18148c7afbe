//! Normals and output vertices; twin [`crate::normals::from_faces`].

use super::{Binding, Kernel, SharedStruct, WORKGROUP, read, shared, source, uniform, write};
use crate::{normals::NormalParams, schedule::KernelId};

pub(super) const KERNEL: Kernel = Kernel {
    id: KernelId::Normals,
    stem: "normals",
    source: include_str!("../../shaders/kernels/normals.wgsl"),
    parts: &[source::DISPATCH, source::MATH],
    structs: STRUCTS,
    constants: &[],
    switches: &[],
    bindings: BINDINGS,
    workgroup: WORKGROUP,
    items_per_workgroup: WORKGROUP,
    twin: "normals::from_faces",
};

const STRUCTS: &[SharedStruct] = &[shared::<NormalParams>()];

const BINDINGS: &[Binding] =
    &[uniform("params"), read("triangles"), read("fans"), read("members"), read("positions"), write("vertices")];
