//! Small mathematics that every room may use, and the one way a struct crosses to the GPU.
//!
//! Everything a kernel also computes is written with plain `+ - * / sqrt` in a fixed order, so that a CPU twin
//! and its kernel agree to the bit where the driver does not fuse multiplications and additions.

use glam::{DMat3, DQuat, Mat4, Quat, Vec3, Vec4};
use std::f32::consts::{FRAC_PI_2, PI};

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

/// `m * (p, 1)` in the order that kernels use: `m0 x + m1 y + m2 z + m3`.
#[inline]
pub fn transform_point(m: &Mat4, p: Vec3) -> Vec3 {
    (m.x_axis * p.x + m.y_axis * p.y + m.z_axis * p.z + m.w_axis).truncate()
}

/// `m * (v, 0)`: a direction or displacement, without the translation.
#[inline]
pub fn transform_vector(m: &Mat4, v: Vec3) -> Vec3 {
    (m.x_axis * v.x + m.y_axis * v.y + m.z_axis * v.z).truncate()
}

/// The transposed upper 3x3 of `m` times `v`: takes a gradient from `m`'s target space back to its source space.
#[inline]
pub fn transpose_vector(m: &Mat4, v: Vec3) -> Vec3 {
    Vec3::new(m.x_axis.truncate().dot(v), m.y_axis.truncate().dot(v), m.z_axis.truncate().dot(v))
}

/// Volume factors below this have no inverse.
pub(crate) const FLAT: f32 = 1e-18;

/// The inverse of an affine map, and its volume factor; the identity where there is none.
#[inline]
pub fn affine_inverse(m: &Mat4) -> (Mat4, f32) {
    let (x, y, z) = (m.x_axis.truncate(), m.y_axis.truncate(), m.z_axis.truncate());
    let (yz, zx, xy) = (y.cross(z), z.cross(x), x.cross(y));
    let volume = x.dot(yz);
    if volume.abs() < FLAT {
        return (Mat4::IDENTITY, volume);
    }
    let scale = 1.0 / volume;
    let (a, b, c) = (yz * scale, zx * scale, xy * scale);
    let t = m.w_axis.truncate();
    let inverse = Mat4::from_cols(
        Vec4::new(a.x, b.x, c.x, 0.0),
        Vec4::new(a.y, b.y, c.y, 0.0),
        Vec4::new(a.z, b.z, c.z, 0.0),
        Vec4::new(-a.dot(t), -b.dot(t), -c.dot(t), 1.0),
    );
    (inverse, volume)
}

/// A product of matrices with its sums in the order of the kernels.
#[inline]
pub fn product(a: &Mat4, b: &Mat4) -> Mat4 {
    let column = |v: Vec4| a.x_axis * v.x + a.y_axis * v.y + a.z_axis * v.z + a.w_axis * v.w;
    Mat4::from_cols(column(b.x_axis), column(b.y_axis), column(b.z_axis), column(b.w_axis))
}

/// `x` to a small whole power by repeated multiplication: `pow` differs between drivers, multiplication does not.
#[inline]
pub fn power(x: f32, exponent: u32) -> f32 {
    let mut result = 1.0;
    for _ in 0..exponent {
        result *= x;
    }
    result
}

/// Arc sine of `x` in 0..=1, to 1e-6: the drivers' own is off by up to 1.6e-4 (Abramowitz and Stegun 4.4.46).
#[inline]
pub fn arc_sine(x: f32) -> f32 {
    let series = FRAC_PI_2
        + x * (-0.214_598_8
            + x * (0.088_978_99
                + x * (-0.050_174_3
                    + x * (0.030_891_88 + x * (-0.017_088_126 + x * (0.006_670_09 + x * -0.001_262_491_1))))));
    FRAC_PI_2 - (1.0 - x).sqrt() * series
}

/// The angle of the vector `(x, y)`, radians, -pi..=pi, to 1e-6; 0 of no vector. Drivers' own `atan2` differ.
#[inline]
pub fn polar_angle(x: f32, y: f32) -> f32 {
    let (across, up) = (x.abs(), y.abs());
    let length = (x * x + y * y).sqrt();
    if length < f32::MIN_POSITIVE {
        return 0.0;
    }
    // The sine of the smaller of the angles to the two axes is where the arc sine is least steep.
    let acute = if up <= across { arc_sine(up / length) } else { FRAC_PI_2 - arc_sine(across / length) };
    let half = if x < 0.0 { PI - acute } else { acute };
    if y < 0.0 { -half } else { half }
}

/// Sine and cosine of `x` in 0..=pi, to 2e-7: drivers' own differ, sums and products do not.
#[inline]
pub fn sine_cosine(x: f32) -> (f32, f32) {
    // Both series are about a right angle: sin x = cos(y), cos x = -sin(y).
    let y = x - FRAC_PI_2;
    let y2 = y * y;
    let sine = y
        * (1.0
            + y2 * (-0.166_666_67
                + y2 * (0.008_333_334 + y2 * (-0.000_198_412_7 + y2 * (2.755_731_9e-6 + y2 * -2.505_210_8e-8)))));
    let cosine = 1.0
        + y2 * (-0.5
            + y2 * (0.041_666_668
                + y2 * (-0.001_388_888_9 + y2 * (2.480_158_7e-5 + y2 * (-2.755_732e-7 + y2 * 2.087_675_7e-9)))));
    (cosine, -sine)
}

/// Cube root of a normal `x > 0`, to 3e-7 of it; drivers have none. 0 for what is smaller.
#[inline]
pub fn cube_root(x: f32) -> f32 {
    if x < f32::MIN_POSITIVE {
        return 0.0;
    }
    // A third of the exponent is within 6 %, and each of Newton's steps squares what is missing.
    let mut root = f32::from_bits(x.to_bits() / 3 + 0x2a51_37a0);
    for _ in 0..3 {
        root = (2.0 * root + x / (root * root)) * (1.0 / 3.0);
    }
    root
}

/// `0` below 0, `1` above 1, and a smooth cubic between.
#[inline]
pub fn smoothstep(x: f32) -> f32 {
    let t = x.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Splits an affine map into rotation, translation and the stretch that comes first: `m p = r (s p) + t`.
///
/// Polar decomposition of the upper 3x3 by Higham's iteration in f64. A reflection stays in the stretch, so the
/// rotation is always proper; a singular matrix keeps the identity rotation and is all stretch.
pub fn polar(m: &Mat4) -> (Quat, Vec3, Mat4) {
    let a = DMat3::from_mat4(m.as_dmat4());
    let translation = m.w_axis.truncate();
    let size = a.x_axis.length().max(a.y_axis.length()).max(a.z_axis.length());
    let all_stretch = (Quat::IDENTITY, translation, Mat4::from_mat3(a.as_mat3()));
    if size == 0.0 || (a * (1.0 / size)).determinant().abs() < 1e-9 {
        return all_stretch;
    }
    let mut r = a * (1.0 / size);
    for _ in 0..64 {
        let next = (r + r.inverse().transpose()) * 0.5;
        let change =
            (next.x_axis - r.x_axis).length() + (next.y_axis - r.y_axis).length() + (next.z_axis - r.z_axis).length();
        r = next;
        if change < 1e-14 {
            break;
        }
    }
    if r.determinant() < 0.0 {
        r *= -1.0;
    }
    let stretch = r.transpose() * a;
    if !stretch.is_finite() {
        return all_stretch;
    }
    (DQuat::from_mat3(&r).normalize().as_quat(), translation, Mat4::from_mat3(stretch.as_mat3()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rebuilt(r: Quat, t: Vec3, s: &Mat4, p: Vec3) -> Vec3 {
        r * transform_point(s, p) + t
    }

    #[test]
    fn our_own_functions_are_the_real_ones() {
        for i in 0..=1000 {
            let x = f64::from(i) / 1000.0;
            let found = f64::from(arc_sine(x as f32));
            assert!((found - x.asin()).abs() < 1e-6, "asin {x}: {found}");
            let angle = x * std::f64::consts::PI;
            let (sine, cosine) = sine_cosine(angle as f32);
            assert!((f64::from(sine) - angle.sin()).abs() < 3e-7, "sin {angle}: {sine}");
            assert!((f64::from(cosine) - angle.cos()).abs() < 3e-7, "cos {angle}: {cosine}");
        }
        for i in -1800..=1800 {
            let angle = f64::from(i) / 1800.0 * std::f64::consts::PI;
            let (x, y) = ((3e-3 * angle.cos()) as f32, (3e-3 * angle.sin()) as f32);
            let error = (f64::from(polar_angle(x, y)) - f64::from(y).atan2(f64::from(x))).abs();
            assert!(error < 1e-6, "angle {angle}: off by {error}");
        }
        assert_eq!(polar_angle(0.0, 0.0), 0.0);
        assert!((arc_sine(0.5) - 0.5237).abs() > 5e-5, "a rounder value must be seen");
        assert_eq!((smoothstep(-1.0), smoothstep(0.5), smoothstep(2.0)), (0.0, 0.5, 1.0));
    }

    #[test]
    fn polar_parts_rebuild_the_map() {
        let p = Vec3::new(0.3, -1.2, 2.0);
        for m in [
            Mat4::IDENTITY,
            Mat4::from_scale_rotation_translation(Vec3::new(2.0, 0.5, 1.5), Quat::from_rotation_y(2.1), Vec3::ONE),
            Mat4::from_rotation_x(1.0) * Mat4::from_scale(Vec3::new(-1.0, 1.0, 3.0)) * Mat4::from_rotation_z(0.4),
            Mat4::from_scale(Vec3::splat(100.0)),
            Mat4::from_scale(Vec3::new(1.0, 1.0, 0.0)),
        ] {
            let (r, t, s) = polar(&m);
            let expected = m.transform_point3(p);
            assert!((rebuilt(r, t, &s, p) - expected).length() <= 1e-5 * (1.0 + expected.length()), "{m}");
            assert!((rebuilt(r, t, &s, p + Vec3::X * 0.1) - expected).length() > 1e-3, "a moved point must be seen");
            assert!((r.length() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn rigid_maps_have_no_stretch() {
        let m = Mat4::from_rotation_translation(Quat::from_rotation_z(0.7), Vec3::new(1.0, 2.0, 3.0));
        let (r, _, s) = polar(&m);
        assert!(s.abs_diff_eq(Mat4::IDENTITY, 1e-6));
        assert!(r.dot(Quat::from_rotation_z(0.7)).abs() > 1.0 - 1e-6);
    }

    #[test]
    fn power_is_repeated_multiplication() {
        assert_eq!(power(1.5, 0), 1.0);
        assert_eq!(power(1.5, 3), 1.5 * 1.5 * 1.5);
    }
}
