//! Puts the parts of a file together: one character from all skinned meshes of the scene, and the rigid parts.

use super::accessor::Source;
use super::material::Materials;
use super::nodes::Graph;
use super::skin::{self, SkinJoint};
use super::surface::{self, Surface};
use super::{influences, label, painted};
use crate::clip::{ClipChoice, RigidPart, Scene, node_globals};
use crate::error::GltfError;
use crate::rig::{Character, Material, Part};
use gltf::json::Mesh;

/// The scene without its animation.
pub(super) fn scene(source: &Source, graph: Graph) -> Result<Scene, GltfError> {
    let Graph { nodes, order, in_scene } = graph;
    let Carriers { skinned, rigid } = carriers(source, &in_scene)?;
    if skinned.is_empty() && rigid.is_empty() {
        return Err(GltfError::NoMesh { file: source.cx.file() });
    }
    if skinned.is_empty() {
        return Err(GltfError::NoSkin { file: source.cx.file() });
    }
    let mut skins: Vec<usize> = skinned.iter().map(|s| s.skin).collect();
    skins.sort_unstable();
    skins.dedup();
    let mut scene = Scene {
        character: Character { influence_offsets: vec![0], ..Character::default() },
        nodes,
        node_order: order,
        clips: Vec::new(),
        rigid: Vec::new(),
        notes: Vec::new(),
        made: Default::default(),
    };
    let globals = node_globals(&scene, ClipChoice::Default, 0.0);
    let skeleton = skin::merge(source, &skins, &scene.nodes, &scene.node_order, &globals)?;
    let mut materials = Materials::default();
    for carrier in &skinned {
        add_skinned(source, carrier, &skeleton.skins[carrier.skin], &mut materials, &mut scene.character)?;
    }
    if scene.character.triangles.is_empty() {
        return Err(GltfError::NoMesh { file: source.cx.file() });
    }
    for &(node, mesh) in &rigid {
        add_rigid(source, node, mesh, &mut materials, &mut scene.rigid)?;
    }
    scene.character.joints = skeleton.joints;
    scene.character.materials = materials.materials;
    scene.character.images = materials.images;
    if scene.character.materials.is_empty() {
        scene.character.materials.push(Material::default());
    }
    Ok(scene)
}

/// A node that carries a skinned mesh.
struct Skinned {
    node: u32,
    mesh: usize,
    skin: usize,
}

/// The nodes of the scene that carry a mesh, by ascending index.
#[derive(Default)]
struct Carriers {
    skinned: Vec<Skinned>,
    /// Node and mesh.
    rigid: Vec<(u32, usize)>,
}

fn carriers(source: &Source, in_scene: &[bool]) -> Result<Carriers, GltfError> {
    let mut carriers = Carriers::default();
    let (meshes, skins) = (source.root.meshes.len(), source.root.skins.len());
    for (index, node) in source.root.nodes.iter().enumerate().filter(|(index, _)| in_scene[*index]) {
        let Some(mesh) = node.mesh.map(|m| m.value()) else { continue };
        let element = || label("node", index, node.name.as_deref());
        if mesh >= meshes {
            return Err(source.cx.dangling(element(), "mesh", mesh, meshes));
        }
        match node.skin.map(|s| s.value()) {
            Some(skin) if skin >= skins => return Err(source.cx.dangling(element(), "skin", skin, skins)),
            Some(skin) => carriers.skinned.push(Skinned { node: index as u32, mesh, skin }),
            None => carriers.rigid.push((index as u32, mesh)),
        }
    }
    Ok(carriers)
}

fn mesh_name(mesh: &Mesh, index: usize, primitive: usize) -> String {
    let name = match mesh.name.as_deref() {
        Some(name) if !name.is_empty() => crate::error::one_line(name),
        _ => format!("mesh {index}"),
    };
    if mesh.primitives.len() > 1 { format!("{name} #{primitive}") } else { name }
}

fn add_skinned(
    source: &Source,
    carrier: &Skinned,
    skin: &[SkinJoint],
    materials: &mut Materials,
    character: &mut Character,
) -> Result<(), GltfError> {
    let mesh = &source.root.meshes[carrier.mesh];
    let (first_vertex, first_triangle) = (character.positions_rest.len(), character.triangles.len());
    for (number, primitive) in mesh.primitives.iter().enumerate() {
        let place = surface::place(source, carrier.mesh, number);
        let Some(read) = surface::read(source, primitive, &place)? else { continue };
        let Surface { positions, normals, uvs, triangles } = read;
        influences::read(
            source,
            primitive,
            &place,
            skin,
            positions.len(),
            &mut character.influences,
            &mut character.influence_offsets,
        )?;
        let vertex = character.positions_rest.len() as u32;
        let triangle = character.triangles.len() as u32;
        character.painted.extend(painted::read(source, primitive, &place, vertex, positions.len())?);
        character.parts.push(Part {
            name: mesh_name(mesh, carrier.mesh, number),
            node: carrier.node,
            vertices: vertex..vertex + positions.len() as u32,
            triangles: triangle..triangle + triangles.len() as u32,
            material: materials.place(source, primitive.material.map(|m| m.value()), &place),
        });
        character.triangles.extend(triangles.iter().map(|t| t.map(|corner| corner + vertex)));
        character.positions_rest.extend(positions);
        character.normals_rest.extend(normals);
        character.uvs.extend(uvs);
    }
    surface::fill_normals(
        &character.positions_rest[first_vertex..],
        &mut character.normals_rest[first_vertex..],
        &character.triangles[first_triangle..],
        first_vertex as u32,
    );
    Ok(())
}

fn add_rigid(
    source: &Source,
    node: u32,
    index: usize,
    materials: &mut Materials,
    rigid: &mut Vec<RigidPart>,
) -> Result<(), GltfError> {
    let mesh = &source.root.meshes[index];
    for (number, primitive) in mesh.primitives.iter().enumerate() {
        let place = surface::place(source, index, number);
        let Some(read) = surface::read(source, primitive, &place)? else { continue };
        let Surface { positions, mut normals, uvs, triangles } = read;
        surface::fill_normals(&positions, &mut normals, &triangles, 0);
        rigid.push(RigidPart {
            name: mesh_name(mesh, index, number),
            node,
            positions,
            normals,
            uvs,
            triangles,
            material: materials.place(source, primitive.material.map(|m| m.value()), &place),
        });
    }
    Ok(())
}
