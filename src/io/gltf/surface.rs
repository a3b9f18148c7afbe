//! The surface of one primitive: points, normals, texture coordinates, triangles.

use super::accessor::Source;
use super::label;
use crate::error::GltfError;
use glam::{DVec3, Vec2, Vec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, accessor};
use std::collections::HashMap;

/// Squared length below which a normal has no direction.
const NO_DIRECTION: f32 = 1e-12;

/// What one primitive shows. Normals of length zero wait for [`fill_normals`].
pub(super) struct Surface {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<[u32; 3]>,
}

/// An attribute's accessor.
pub(super) fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<accessor::Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}

/// The element's name in messages.
pub(super) fn place(source: &Source, mesh: usize, primitive: usize) -> String {
    let name = source.root.meshes.get(mesh).and_then(|m| m.name.as_deref());
    format!("{}, primitive {primitive}", label("mesh", mesh, name))
}

/// Reads a primitive; nothing where it shows no triangles.
pub(super) fn read(source: &Source, primitive: &Primitive, place: &str) -> Result<Option<Surface>, GltfError> {
    let cx = source.cx;
    let mode = match primitive.mode.as_ref() {
        Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => *mode,
        Checked::Valid(mode) => {
            cx.note(format!("{place}: {mode:?} are not shown"));
            return Ok(None);
        }
        Checked::Invalid => return Err(cx.malformed(place, "its mode is unknown", "export it as triangles")),
    };
    let Some(position) = attribute(primitive, Semantic::Positions).filter(|&p| !source.is_empty(p)) else {
        cx.note(format!("{place}: it has no positions and is not shown"));
        return Ok(None);
    };
    let positions: Vec<Vec3> = vectors(source.decimals(position, &[Type::Vec3], &format!("{place}, POSITION"))?);
    if let Some(v) = positions.iter().position(|p| !p.is_finite()) {
        return Err(cx.non_finite(place, format!("the position of vertex {v}")));
    }
    let normals = normals(source, primitive, place, positions.len())?;
    let uvs = match attribute(primitive, Semantic::TexCoords(0)) {
        Some(index) => {
            let flat = source.decimals(index, &[Type::Vec2], &format!("{place}, TEXCOORD_0"))?;
            same_count(source, place, "TEXCOORD_0", flat.len() / 2, positions.len())?;
            let finite = |uv: Vec2| if uv.is_finite() { uv } else { Vec2::ZERO };
            flat.chunks_exact(2).map(|uv| finite(Vec2::new(uv[0], uv[1]))).collect()
        }
        None => vec![Vec2::ZERO; positions.len()],
    };
    let triangles = triangles(source, primitive, mode, place, positions.len())?;
    Ok(Some(Surface { positions, normals, uvs, triangles }))
}

fn vectors(flat: Vec<f32>) -> Vec<Vec3> {
    flat.chunks_exact(3).map(Vec3::from_slice).collect()
}

/// Refuses an attribute that does not go with the positions.
pub(super) fn same_count(source: &Source, place: &str, name: &str, has: usize, needs: usize) -> Result<(), GltfError> {
    if has == needs {
        return Ok(());
    }
    let what = format!("{name} has {has} elements and POSITION has {needs}");
    Err(source.cx.malformed(place, what, "export the file again"))
}

/// The file's normals at length 1, zero where they have no direction.
fn normals(source: &Source, primitive: &Primitive, place: &str, count: usize) -> Result<Vec<Vec3>, GltfError> {
    let Some(index) = attribute(primitive, Semantic::Normals) else { return Ok(vec![Vec3::ZERO; count]) };
    let mut normals = vectors(source.decimals(index, &[Type::Vec3], &format!("{place}, NORMAL"))?);
    same_count(source, place, "NORMAL", normals.len(), count)?;
    let mut replaced = 0;
    for normal in &mut normals {
        let direction = normal.is_finite() && normal.length_squared() > NO_DIRECTION;
        *normal = if direction { normal.as_dvec3().normalize().as_vec3() } else { Vec3::ZERO };
        replaced += usize::from(!direction);
    }
    if replaced > 0 {
        source.cx.note(format!("{place}: {replaced} normals have no direction and are taken from the faces"));
    }
    Ok(normals)
}

/// The triangles of a list, strip or fan (glTF 2.0, section 3.7.2.1), with or without indices.
fn triangles(
    source: &Source,
    primitive: &Primitive,
    mode: Mode,
    place: &str,
    vertices: usize,
) -> Result<Vec<[u32; 3]>, GltfError> {
    let cx = source.cx;
    let corners: Vec<u32> = match primitive.indices {
        Some(index) => source.integers(index, &[Type::Scalar], &format!("{place}, indices"))?,
        None => (0..vertices as u32).collect(),
    };
    if let Some((at, corner)) = corners.iter().enumerate().find(|(_, corner)| **corner as usize >= vertices) {
        let what = format!("index {at} is {corner}, and there are {vertices} vertices");
        return Err(cx.malformed(place, what, "export the file again"));
    }
    let mut triangles: Vec<[u32; 3]> = match mode {
        Mode::TriangleStrip => {
            let turn = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
            corners.windows(3).enumerate().map(turn).collect()
        }
        Mode::TriangleFan => {
            let fan = corners.get(1..).unwrap_or_default();
            fan.windows(2).map(|w| [w[0], w[1], corners[0]]).collect()
        }
        _ => {
            if !corners.len().is_multiple_of(3) {
                cx.note(format!("{place}: {} corners are left over after its last triangle", corners.len() % 3));
            }
            corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()
        }
    };
    let before = triangles.len();
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    // Strips repeat corners on purpose, to turn or to jump.
    if triangles.len() < before && mode != Mode::TriangleStrip {
        cx.note(format!("{place}: {} triangles use a vertex twice and are left out", before - triangles.len()));
    }
    Ok(triangles)
}

/// Gives vertices without a normal the area-weighted normal of the faces around their position, so that a surface
/// split along seams of texture or material stays smooth. `positions`, `normals` and `triangles` belong to one mesh;
/// corner indices start at `first`.
pub(super) fn fill_normals(positions: &[Vec3], normals: &mut [Vec3], triangles: &[[u32; 3]], first: u32) {
    if normals.iter().all(|n| *n != Vec3::ZERO) {
        return;
    }
    // Adding zero makes -0 and 0 the same key.
    let key = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut sums: HashMap<[u32; 3], DVec3> = HashMap::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| positions[(corner - first) as usize]);
        let (edge_1, edge_2) = ((b - a).as_dvec3(), (c - a).as_dvec3());
        let area = edge_1.cross(edge_2);
        for p in [a, b, c] {
            *sums.entry(key(p)).or_default() += area;
        }
    }
    for (normal, &position) in normals.iter_mut().zip(positions).filter(|(n, _)| **n == Vec3::ZERO) {
        let sum = sums.get(&key(position)).copied().unwrap_or_default();
        *normal = sum.try_normalize().map_or(Vec3::Y, |n| n.as_vec3());
    }
}
