//! Weights of muscles that a file paints on its vertices: attributes `_MUSCLE_n` of one float, n counted as in the muscle
//! file.

use super::accessor::Source;
use super::surface::same_count;
use crate::error::GltfError;
use crate::rig::PaintedMuscle;
use gltf::json::accessor::Type;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

/// What such an attribute's name begins with.
pub(super) const PREFIX: &str = "_MUSCLE_";
/// How far a weight may be outside 0..=1 as an exporter's rounding.
const ROUNDING: f32 = 1e-3;

/// The painted weights of a primitive whose vertices are those of the character from `first` on.
pub(super) fn read(
    source: &Source,
    primitive: &Primitive,
    place: &str,
    first: u32,
    count: usize,
) -> Result<Vec<PaintedMuscle>, GltfError> {
    let mut painted = Vec::new();
    for (semantic, &index) in &primitive.attributes {
        let Checked::Valid(Semantic::Extras(name)) = semantic else { continue };
        // The crate leaves out the first underscore.
        let Some(muscle) = name.strip_prefix(&PREFIX[1..]).and_then(|n| n.parse().ok()) else { continue };
        let name = format!("{PREFIX}{muscle}");
        let mut weights = source.decimals(index, &[Type::Scalar], &format!("{place}, {name}"))?;
        same_count(source, place, &name, weights.len(), count)?;
        for (vertex, weight) in weights.iter_mut().enumerate() {
            if !weight.is_finite() {
                return Err(source.cx.non_finite(place, format!("{name} of vertex {vertex}")));
            }
            if !(-ROUNDING..=1.0 + ROUNDING).contains(weight) {
                let what = format!("{name} of vertex {vertex} is {weight}");
                return Err(source.cx.malformed(place, what, "paint weights from 0 to 1 and export again"));
            }
            *weight = weight.clamp(0.0, 1.0);
        }
        painted.push(PaintedMuscle { muscle, vertices: first..first + count as u32, weights });
    }
    painted.sort_by_key(|painted| painted.muscle);
    Ok(painted)
}
