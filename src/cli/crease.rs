//! The crease view: how much more the skin is folded at its edges than at rest.

use crate::deform::Skin;
use glam::Vec4;
use serde::Serialize;
use sinew::normals::Creases;
use sinew::render::{ColorMesh, colored_skin};
use sinew::rig::Rig;

/// Change from which colours are full, degrees.
const FULL_DEGREES: f32 = 60.0;
/// Bins of the distribution, per degree.
const BINS_PER_DEGREE: f32 = 10.0;

/// A skin's creases, frame after frame.
pub struct Folds {
    creases: Creases,
    /// Edges by the size of their change, over all frames.
    bins: Vec<u64>,
    /// Largest change in size, with its sign, degrees.
    most: f32,
}

/// What was measured over all frames that were drawn, degrees.
#[derive(Serialize)]
pub struct Summary {
    full_color_degrees: f32,
    median_degrees: f32,
    p995_degrees: f32,
    most_degrees: f32,
}

impl Folds {
    /// Those of a rig's skin, none of it seen yet.
    pub fn of(rig: &Rig) -> Folds {
        let creases = Creases::new(&rig.character.triangles, &rig.graph.copy_of, &rig.positions_rest);
        Folds { creases, bins: vec![0; (180.0 * BINS_PER_DEGREE) as usize + 1], most: 0.0 }
    }

    /// The skin of one frame in colours, its creases counted.
    pub fn mesh(&mut self, rig: &Rig, skin: &Skin) -> ColorMesh {
        let positions: Vec<Vec4> = skin.positions.iter().map(|p| p.extend(1.0)).collect();
        let changes = self.creases.changes(&positions);
        for &change in &changes {
            let last = self.bins.len() - 1;
            self.bins[((change.abs() * BINS_PER_DEGREE) as usize).min(last)] += 1;
            if change.abs() > self.most.abs() {
                self.most = change;
            }
        }
        let measures: Vec<f32> =
            self.creases.of_vertices(&changes).iter().map(|degrees| degrees / FULL_DEGREES).collect();
        colored_skin(&rig.character, &skin.positions, &skin.normals, &measures)
    }

    /// What was measured; `None` where no edge was seen.
    pub fn summary(&self) -> Option<Summary> {
        let total: u64 = self.bins.iter().sum();
        let quantile = |share: f64| {
            let mut left = (share * total as f64).ceil().max(1.0) as u64;
            let bin = self.bins.iter().position(|&count| {
                let there = count >= left;
                left = left.saturating_sub(count);
                there
            });
            bin.map(|bin| (bin as f32 + 0.5) / BINS_PER_DEGREE)
        };
        Some(Summary {
            full_color_degrees: FULL_DEGREES,
            median_degrees: quantile(0.5).filter(|_| total > 0)?,
            p995_degrees: quantile(0.995)?,
            most_degrees: self.most,
        })
    }
}

impl Summary {
    /// The view's legend, and the figures.
    pub fn note(&self) -> String {
        format!(
            "crease view: edges against rest, red folded into a valley, blue into a ridge, white as at rest, in full from {:.0} \
             degrees; over all edges and frames the change is {:.1} degrees at the median, {:.1} at 99.5 %, {:+.1} at most",
            self.full_color_degrees, self.median_degrees, self.p995_degrees, self.most_degrees
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4Swizzles;
    use sinew::clip::ClipChoice;
    use sinew::reference::Reference;
    use sinew::rig::BuildOptions;
    use sinew::schedule::{FrameOptions, Skinning};

    #[test]
    fn rest_is_white_and_a_bent_arm_is_not() {
        let scene = sinew::io::gltf::from_bytes(include_bytes!("../../assets/arm.glb"), "arm").expect("the arm");
        let plain = BuildOptions { fields: false, ..BuildOptions::default() };
        let rig = Rig::build(scene.character.clone(), &[], &plain).expect("a rig");
        let options = FrameOptions { skinning: Skinning::Linear, ..FrameOptions::default() };
        let measured = |clip, time| {
            let trace = Reference::new(&rig).frame(&scene.pose(clip, time), &options).expect("a frame");
            let points = |list: &[Vec4]| list.iter().map(|p| p.xyz()).collect();
            let skin = Skin { positions: points(trace.positions()), normals: points(&trace.normals) };
            let mut folds = Folds::of(&rig);
            assert!(folds.summary().is_none());
            folds.mesh(&rig, &skin);
            folds.summary().expect("edges")
        };
        let rest = measured(ClipChoice::Rest, 0.0);
        assert!(rest.most_degrees.abs() < 0.1 && rest.p995_degrees < 0.1, "{}", rest.note());
        let bent = measured(ClipChoice::Clip(0), 1.0);
        assert!(bent.most_degrees.abs() > 30.0 && bent.p995_degrees > 10.0, "{}", bent.note());
        assert!(bent.median_degrees < bent.p995_degrees && bent.p995_degrees <= bent.most_degrees.abs() + 0.1);
    }
}
