//! `sinew inspect`: what a file holds and what is made of it. Needs no adapter.

use crate::args;
use crate::failure::Failure;
use crate::{explain, load, print};
use serde::Serialize;
use sinew::clip::{ClipChoice, Scene, TestClip};
use sinew::rig::groups::FoldRest;
use sinew::rig::{BoneCollider, ColliderShape, Join, Rig, Role, VertexTarget};
use std::fmt::Write;

#[derive(Serialize)]
struct Inspected {
    character: String,
    vertices: usize,
    triangles: usize,
    height_metres: f32,
    most_influences: usize,
    active_vertices: usize,
    following_vertices: usize,
    parts: Vec<Part>,
    joints: Vec<Joint>,
    groups: Vec<Group>,
    muscles: Vec<Muscle>,
    bones: Vec<Bone>,
    clips: Vec<Clip>,
    test_clips: Vec<Made>,
    materials: Vec<Material>,
    rigid: Vec<String>,
    notes: Vec<String>,
}

#[derive(Serialize)]
struct Part {
    name: String,
    first_vertex: u32,
    vertices: u32,
    triangles: u32,
    material: u32,
}

#[derive(Serialize)]
struct Joint {
    name: String,
    parent: Option<u32>,
}

#[derive(Serialize)]
struct Group {
    name: String,
    joints: Vec<String>,
    /// The joint that moves its field.
    driver: String,
    parent: Option<String>,
    /// Whether vertices bound almost wholly to it follow linear skinning.
    passive: bool,
    /// Vertices that it moves most.
    vertices: usize,
    /// Vertices that track it.
    active_vertices: usize,
    support_radius_metres: f32,
    muscles: usize,
    /// Groups against which it folds.
    folds: Vec<String>,
    /// Groups to which an operator of the muscle file joins it, with the operator.
    joined: Vec<String>,
}

#[derive(Serialize)]
struct Muscle {
    name: String,
    group: u32,
    rest_length_metres: f32,
    volume_cubic_metres: f32,
    /// Vertices that the weighted skinning moves with it.
    weighted_vertices: usize,
    /// Whether their weights are the character's own.
    painted: bool,
}

/// A bone's shape for collisions.
#[derive(Serialize)]
struct Bone {
    joint: String,
    shape: &'static str,
    given: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    length_metres: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    radius_metres: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    triangles: Option<usize>,
}

#[derive(Serialize)]
struct Clip {
    name: String,
    start_seconds: f32,
    seconds: f32,
    channels: usize,
    muscle_channels: usize,
}

/// A clip made by code.
#[derive(Serialize)]
struct Made {
    name: &'static str,
    seconds: f32,
    /// Why the character has no such clip, where it has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    lacks: Option<String>,
}

#[derive(Serialize)]
struct Material {
    name: String,
    base_color: [f32; 4],
    texture: Option<[u32; 2]>,
}

pub fn run(args: &args::Inspect) -> Result<(), Failure> {
    load::threads(args.threads)?;
    let (scene, muscles) = load::input(&args.input)?;
    if args.schedule || args.vertex.is_some() {
        return explain::run(args, &scene, &muscles);
    }
    let rig = load::rig(&args.input, &scene, &muscles, true, None)?;
    print::result(args.json, &inspect(&scene, &rig), text)
}

fn inspect(scene: &Scene, rig: &Rig) -> Inspected {
    let character = &scene.character;
    let active = rig.active_count();
    let mut weighted = vec![0; rig.muscles.len()];
    rig.weights.weights.iter().for_each(|weight| weighted[weight.muscle as usize] += 1);
    Inspected {
        character: character.name.clone(),
        vertices: character.vertex_count(),
        triangles: character.triangles.len(),
        height_metres: character.height_rest(),
        most_influences: character.influence_offsets.windows(2).map(|w| (w[1] - w[0]) as usize).max().unwrap_or(0),
        active_vertices: active,
        following_vertices: character.vertex_count() - active,
        parts: character
            .parts
            .iter()
            .map(|p| Part {
                name: p.name.clone(),
                first_vertex: p.vertices.start,
                vertices: p.vertices.len() as u32,
                triangles: p.triangles.len() as u32,
                material: p.material,
            })
            .collect(),
        joints: character.joints.iter().map(|j| Joint { name: j.name.clone(), parent: j.parent }).collect(),
        groups: (0..rig.groups.groups.len()).map(|g| group(rig, g)).collect(),
        muscles: rig
            .muscles
            .iter()
            .zip(&rig.muscle_names)
            .enumerate()
            .map(|(index, (m, name))| Muscle {
                name: name.clone(),
                group: m.group,
                rest_length_metres: m.origin_normal.w,
                volume_cubic_metres: m.origin.w,
                weighted_vertices: weighted.get(index).copied().unwrap_or(0),
                painted: character.painted.iter().any(|painted| painted.muscle == rig.spec_of[index]),
            })
            .collect(),
        bones: rig.bones.iter().map(|b| bone(b, rig)).collect(),
        clips: scene
            .clips
            .iter()
            .map(|c| Clip {
                name: c.name.clone(),
                start_seconds: c.start,
                seconds: c.end - c.start,
                channels: c.channels.len(),
                muscle_channels: c.muscle_channels.len(),
            })
            .collect(),
        test_clips: TestClip::ALL
            .into_iter()
            .map(|clip| Made {
                name: clip.name(),
                seconds: scene.duration(ClipChoice::Test(clip)),
                lacks: scene.check_test(clip).err().map(|error| error.to_string()),
            })
            .collect(),
        materials: character
            .materials
            .iter()
            .map(|m| Material {
                name: m.name.clone(),
                base_color: m.base_color,
                texture: m.texture.and_then(|t| character.images.get(t as usize)).map(|i| [i.width, i.height]),
            })
            .collect(),
        rigid: scene.rigid.iter().map(|r| r.name.clone()).collect(),
        notes: scene.notes.clone(),
    }
}

fn group(rig: &Rig, index: usize) -> Group {
    let (all, g) = (&rig.groups.groups, index as u32);
    let group = &all[index];
    let joint = |j: u32| rig.character.joints[j as usize].name.clone();
    let name = |g: u32| all[g as usize].name.clone();
    let tracks = |t: &&VertexTarget| t.role == Role::Active as u32 && t.owner == g;
    let beside = |fold: &FoldRest| match g {
        _ if fold.parent == g => Some(name(fold.child)),
        _ if fold.child == g => Some(name(fold.parent)),
        _ => None,
    };
    let joined = |join: &Join| {
        let other = join.groups.iter().find(|&&other| other != g)?;
        join.groups.contains(&g).then(|| format!("{} by {}", name(*other), join.operator.name()))
    };
    Group {
        name: group.name.clone(),
        joints: group.joints.iter().map(|&j| joint(j)).collect(),
        driver: joint(group.joint),
        parent: group.parent.map(name),
        passive: group.passive,
        vertices: rig.groups.owner.iter().filter(|&&owner| owner == g).count(),
        active_vertices: rig.targets.vertices.iter().filter(tracks).count(),
        support_radius_metres: rig.grids.get(index).map_or(0.0, |grid| grid.support_radius),
        muscles: rig.muscles.iter().filter(|muscle| muscle.group == g).count(),
        folds: rig.folds.iter().filter_map(beside).collect(),
        joined: rig.joins.iter().filter_map(joined).collect(),
    }
}

fn bone(bone: &BoneCollider, rig: &Rig) -> Bone {
    let joint = rig.character.joints[bone.joint as usize].name.clone();
    let found =
        Bone { joint, shape: "mesh", given: bone.given, length_metres: None, radius_metres: None, triangles: None };
    match &bone.shape {
        ColliderShape::Capsule { from, to, radius } => {
            Bone { shape: "capsule", length_metres: Some(from.distance(*to)), radius_metres: Some(*radius), ..found }
        }
        ColliderShape::Mesh { triangles, .. } => Bone { triangles: Some(triangles.len()), ..found },
    }
}

fn text(found: &Inspected) -> String {
    let mut text = String::new();
    let mut section = |title: String, lines: Vec<String>| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{title}");
        for line in lines {
            let _ = writeln!(text, "  {line}");
        }
    };
    section(
        format!(
            "{}: {} vertices, {} triangles, {:.3} m, up to {} influences",
            found.character, found.vertices, found.triangles, found.height_metres, found.most_influences
        ),
        vec![format!(
            "{} vertices follow the fields, {} follow geometric skinning",
            found.active_vertices, found.following_vertices
        )],
    );
    let parts = found.parts.iter().map(|p| {
        format!(
            "{}: {} vertices from {}, {} triangles, material {}",
            p.name, p.vertices, p.first_vertex, p.triangles, p.material
        )
    });
    section(format!("parts: {}", found.parts.len()), parts.collect());
    let joints: Vec<_> = found.joints.iter().map(|j| j.name.as_str()).collect();
    section(format!("joints: {}", joints.len()), vec![joints.join(" ")]);
    let groups = found.groups.iter().map(|g| {
        let parent = g.parent.as_ref().map_or(String::new(), |parent| format!(" on {parent}"));
        let passive = if g.passive { ", passive" } else { "" };
        let folds = if g.folds.is_empty() { String::new() } else { format!(", folds with {}", g.folds.join(" ")) };
        let joined = if g.joined.is_empty() { String::new() } else { format!(", joined to {}", g.joined.join(", ")) };
        format!(
            "{}{parent}, driven by {}{passive}: {} vertices track it, {} are bound to it, support {:.1} cm{folds}{joined}; joints {}",
            g.name,
            g.driver,
            g.active_vertices,
            g.vertices,
            100.0 * g.support_radius_metres,
            g.joints.join(" ")
        )
    });
    section(format!("field groups: {}", found.groups.len()), groups.collect());
    let muscles = found.muscles.iter().map(|m| {
        let group = found.groups.get(m.group as usize).map_or("?", |g| g.name.as_str());
        let (centimetres, millilitres) = (m.rest_length_metres * 100.0, m.volume_cubic_metres * 1e6);
        let (painted, vertices) = (if m.painted { ", painted" } else { "" }, m.weighted_vertices);
        format!(
            "{}: on {group}, {centimetres:.1} cm, {millilitres:.0} ml, weights of {vertices} vertices{painted}",
            m.name
        )
    });
    section(format!("muscles: {}", found.muscles.len()), muscles.collect());
    let bones = found.bones.iter().map(|b| {
        let centimetres = |metres: Option<f32>| metres.unwrap_or(0.0) * 100.0;
        let shape = match b.triangles {
            Some(triangles) => format!("mesh of {triangles} triangles"),
            None => format!("{:.1} cm, radius {:.2} cm", centimetres(b.length_metres), centimetres(b.radius_metres)),
        };
        format!("{}: {shape}{}", b.joint, if b.given { ", from the muscle file" } else { "" })
    });
    section(format!("bones: {}", found.bones.len()), bones.collect());
    let clips = found.clips.iter().enumerate();
    let clips = clips.map(|(i, c)| {
        let channels = c.channels + c.muscle_channels;
        let muscles = if c.muscle_channels > 0 { format!(", {} of muscles", c.muscle_channels) } else { String::new() };
        format!("{i} {}: {:.3} s, {channels} channels{muscles}", c.name, c.seconds)
    });
    section(format!("clips: {}", found.clips.len()), clips.collect());
    let (made, lacking): (Vec<_>, Vec<_>) = found.test_clips.iter().partition(|c| c.lacks.is_none());
    let lines = made.iter().map(|c| format!("{}: {:.3} s", c.name, c.seconds));
    let lacks = lacking.iter().filter_map(|c| c.lacks.clone());
    section(format!("test clips made by code: {}", made.len()), lines.chain(lacks).collect());
    let materials = found.materials.iter().map(|m| {
        let [r, g, b, a] = m.base_color;
        let texture = m.texture.map_or("no texture".into(), |[w, h]| format!("texture {w} x {h}"));
        format!("{}: {r:.2} {g:.2} {b:.2} {a:.2}, {texture}", if m.name.is_empty() { "(unnamed)" } else { &m.name })
    });
    section(format!("materials: {}", found.materials.len()), materials.collect());
    if !found.rigid.is_empty() {
        section(format!("rigid parts: {}", found.rigid.len()), vec![found.rigid.join(" ")]);
    }
    if !found.notes.is_empty() {
        section(format!("notes: {}", found.notes.len()), found.notes.clone());
    }
    text
}
