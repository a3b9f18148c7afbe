//! All `JOINTS_n`/`WEIGHTS_n` sets of a primitive, brought to the character's joints.

use super::accessor::Source;
use super::skin::SkinJoint;
use super::surface::{attribute, same_count};
use crate::error::GltfError;
use crate::rig::Influence;
use gltf::json::accessor::Type;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

/// How far the weights of a vertex may be from a sum of 1 before the report says so.
const SUM: f64 = 1e-3;
/// Weights below this are an exporter's rounding where positive or negative; more negative ones are refused.
const NEGATIVE: f32 = -1e-3;

/// One set: four joints and four weights per vertex.
struct Set {
    joints: Vec<u32>,
    weights: Vec<f32>,
}

/// Appends the influences of a primitive's `count` vertices, and the offset after each.
pub(super) fn read(
    source: &Source,
    primitive: &Primitive,
    place: &str,
    skin: &[SkinJoint],
    count: usize,
    influences: &mut Vec<Influence>,
    offsets: &mut Vec<u32>,
) -> Result<(), GltfError> {
    let sets = sets(source, primitive, place, count)?;
    let (mut off, mut worst, mut unweighted) = (0usize, 1.0f64, 0usize);
    let mut shares: Vec<(u32, f64)> = Vec::new();
    for vertex in 0..count {
        shares.clear();
        for set in &sets {
            let range = vertex * 4..vertex * 4 + 4;
            for (&joint, &weight) in set.joints[range.clone()].iter().zip(&set.weights[range]) {
                if let Some(share) = share(source, place, skin, vertex, joint, weight)? {
                    shares.push(share);
                }
            }
        }
        let sum: f64 = shares.iter().map(|s| s.1).sum();
        if shares.is_empty() {
            unweighted += 1;
            shares.push((first_joint(skin), 1.0));
        } else {
            if (sum - 1.0).abs() > SUM {
                off += 1;
                worst = if (sum - 1.0).abs() > (worst - 1.0).abs() { sum } else { worst };
            }
            shares.iter_mut().for_each(|s| s.1 /= sum);
        }
        merge(&mut shares);
        influences.extend(shares.iter().map(|&(joint, weight)| Influence { joint, weight: weight as f32 }));
        offsets.push(influences.len() as u32);
    }
    if off > 0 {
        source.cx.note(format!(
            "{place}: the weights of {off} of {count} vertices do not add up to 1 (the worst to {worst:.4}) and are normalised"
        ));
    }
    if unweighted > 0 {
        source.cx.note(format!("{place}: {unweighted} of {count} vertices have no weight and follow the first joint"));
    }
    Ok(())
}

fn first_joint(skin: &[SkinJoint]) -> u32 {
    skin.iter().find(|local| local.broken.is_none()).or(skin.first()).map_or(0, |local| local.joint)
}

/// One joint's raw share of a vertex; nothing where it is zero.
fn share(
    source: &Source,
    place: &str,
    skin: &[SkinJoint],
    vertex: usize,
    joint: u32,
    weight: f32,
) -> Result<Option<(u32, f64)>, GltfError> {
    let cx = source.cx;
    if !weight.is_finite() {
        return Err(cx.non_finite(place, format!("the weight of vertex {vertex} for joint {joint}")));
    }
    if weight < NEGATIVE {
        let what = format!("vertex {vertex} has the negative weight {weight} for joint {joint}");
        return Err(cx.malformed(place, what, "paint weights from 0 to 1 and export again"));
    }
    if weight <= 0.0 {
        return Ok(None);
    }
    let Some(local) = skin.get(joint as usize) else {
        let (element, joints) = (place.to_string(), skin.len());
        return Err(GltfError::JointRange { file: cx.file(), element, vertex, joint, joints });
    };
    if let Some(why) = local.broken {
        let what = format!("vertex {vertex} follows joint {joint}, whose inverse bind matrix {why}");
        return Err(cx.malformed(place, what, "bind the mesh to its armature again and export it"));
    }
    Ok(Some((local.joint, f64::from(weight))))
}

/// One entry per joint, strongest first, equals by joint.
fn merge(shares: &mut Vec<(u32, f64)>) {
    shares.sort_unstable_by_key(|s| s.0);
    shares.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
}

fn sets(source: &Source, primitive: &Primitive, place: &str, count: usize) -> Result<Vec<Set>, GltfError> {
    let mut sets = Vec::new();
    for semantic in primitive.attributes.keys() {
        let number = match semantic {
            Checked::Valid(Semantic::Joints(n) | Semantic::Weights(n)) => *n,
            _ => continue,
        };
        let joints = attribute(primitive, Semantic::Joints(number));
        let weights = attribute(primitive, Semantic::Weights(number));
        let (Some(joints), Some(weights)) = (joints, weights) else {
            let missing = if joints.is_none() { "JOINTS" } else { "WEIGHTS" };
            let what = format!("its set {number} of influences has no {missing}_{number}");
            return Err(source.cx.malformed(place, what, "export joints and weights together"));
        };
        if matches!(semantic, Checked::Valid(Semantic::Weights(_))) {
            continue;
        }
        let joints = source.integers(joints, &[Type::Vec4], &format!("{place}, JOINTS_{number}"))?;
        same_count(source, place, &format!("JOINTS_{number}"), joints.len() / 4, count)?;
        let weights = source.decimals(weights, &[Type::Vec4], &format!("{place}, WEIGHTS_{number}"))?;
        same_count(source, place, &format!("WEIGHTS_{number}"), weights.len() / 4, count)?;
        sets.push(Set { joints, weights });
    }
    Ok(sets)
}
