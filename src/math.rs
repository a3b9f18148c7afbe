//! Small mathematics that every room may use, and the one way a struct crosses to the GPU.
//!
//! Everything a kernel also computes is written with plain `+ - * / sqrt` in a fixed order, so that a CPU twin
//! and its kernel agree to the bit where the driver does not fuse multiplications and additions.

use glam::{Mat4, Vec4};

/// A Rust type with a WGSL counterpart of the same size and alignment.
pub trait WgslType {
    /// How WGSL spells the type.
    const WGSL: &'static str;
}

impl WgslType for u32 {
    const WGSL: &'static str = "u32";
}
impl WgslType for f32 {
    const WGSL: &'static str = "f32";
}
impl WgslType for Vec4 {
    const WGSL: &'static str = "vec4<f32>";
}
impl WgslType for Mat4 {
    const WGSL: &'static str = "mat4x4<f32>";
}

/// One member of a [`GpuStruct`]: name, WGSL type and byte offset on the Rust side.
#[derive(Clone, Copy, Debug)]
pub struct GpuField {
    /// Member name, the same on both sides.
    pub name: &'static str,
    /// WGSL spelling of its type.
    pub wgsl: &'static str,
    /// Byte offset in the Rust struct.
    pub offset: usize,
}

/// A plain struct shared by host and kernels, declared once by [`gpu_struct!`](crate::gpu_struct).
pub trait GpuStruct: bytemuck::Pod {
    /// Name of the struct, the same on both sides.
    const NAME: &'static str;
    /// Members in declaration order.
    const FIELDS: &'static [GpuField];

    /// The WGSL declaration that kernels are assembled with.
    fn wgsl() -> String {
        let members: String = Self::FIELDS.iter().map(|f| format!("    {}: {},\n", f.name, f.wgsl)).collect();
        format!("struct {} {{\n{members}}}\n", Self::NAME)
    }
}

/// Declares a `repr(C)` plain-old-data struct once for Rust and WGSL.
///
/// Members are `u32`, `f32`, `Vec4` or `Mat4`; `bytemuck` refuses implicit padding, and a test compares every
/// offset with what naga finds in the assembled kernels.
#[macro_export]
macro_rules! gpu_struct {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* pub $field:ident : $ty:ty),* $(,)? }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $($(#[$field_meta])* pub $field: $ty),* }

        impl $crate::math::GpuStruct for $name {
            const NAME: &'static str = stringify!($name);
            const FIELDS: &'static [$crate::math::GpuField] = &[
                $($crate::math::GpuField {
                    name: stringify!($field),
                    wgsl: <$ty as $crate::math::WgslType>::WGSL,
                    offset: core::mem::offset_of!($name, $field),
                }),*
            ];
        }
    };
}
