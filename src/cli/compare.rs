//! The compare view: the skin under a ghost of linear skinning, in colours of how far it is from there (paper B, figure 3 e).

use crate::deform::{OnCpu, Skin};
use crate::failure::Failure;
use serde::Serialize;
use sinew::figures::plot::{Axis, Page, Rect, bar};
use sinew::render::{ColorMesh, Picture, colored_skin, signed_color};
use sinew::rig::{Image, Pose, Rig};
use sinew::schedule::{FrameOptions, Skinning};
use std::sync::Arc;

/// Displacement from which colours are full, millimetres.
const FULL_MILLIMETRES: f32 = 20.0;
/// Place of the legend in the picture's upper left corner: a card, and the bar on it, pixels.
const CARD: [u32; 2] = [96, 236];
const BAR: Rect = Rect { left: 18, top: 44, width: 22, height: 172 };

/// A skin and linear skinning, frame after frame.
pub struct Against {
    linear: OnCpu,
    /// Of squares of displacements, square millimetres, and how many there are.
    sum: f64,
    count: u64,
    most: f32,
}

/// What was measured over all vertices and frames that were drawn, millimetres.
#[derive(Serialize)]
pub struct Summary {
    full_color_millimetres: f32,
    root_mean_square_millimetres: f64,
    most_millimetres: f32,
}

impl Against {
    /// Of a rig's skin, none of it seen yet.
    pub fn of(rig: &Arc<Rig>) -> Against {
        let options = FrameOptions { skinning: Skinning::Linear, dynamics: None, ..FrameOptions::default() };
        Against { linear: OnCpu::new(rig, &options), sum: 0.0, count: 0, most: 0.0 }
    }

    /// The skin of one pose in colours, its displacements measured, and linear skinning of the same pose. Red is outside of linear
    /// skinning, blue inside.
    pub fn mesh(&mut self, rig: &Rig, pose: &Pose, skin: &Skin) -> Result<(ColorMesh, Skin), Failure> {
        let linear = self.linear.skin(pose)?;
        let places = skin.positions.iter().zip(&linear.positions).zip(&linear.normals);
        let signed: Vec<f32> = places
            .map(|((ours, theirs), normal)| {
                let way = (*ours - *theirs) * 1e3;
                way.length().copysign(way.dot(*normal))
            })
            .collect();
        self.sum += signed.iter().map(|d| f64::from(*d).powi(2)).sum::<f64>();
        self.count += signed.len() as u64;
        self.most = signed.iter().fold(self.most, |most, d| most.max(d.abs()));
        let measures: Vec<f32> = signed.iter().map(|d| d / FULL_MILLIMETRES).collect();
        Ok((colored_skin(&rig.character, &skin.positions, &skin.normals, &measures), linear))
    }

    /// A picture with the legend on it; as it is where it has no room for it.
    pub fn legend(picture: Picture) -> Result<Picture, Failure> {
        let Picture { width, height, rgba } = picture;
        if width < CARD[0] || height < CARD[1] {
            return Ok(Picture { width, height, rgba });
        }
        let drawn = || {
            let mut page = Page::new(CARD[0], CARD[1])?;
            let full = f64::from(FULL_MILLIMETRES);
            let axis = Axis { name: "mm", range: -full..full, ticks: 5, digits: 0 };
            bar(&mut page, BAR, &axis, &|value| bytes(signed_color(value as f32 / FULL_MILLIMETRES)))?;
            Ok(page.finish())
        };
        let card: Image = drawn().map_err(|error: sinew::error::FigureError| Failure::input(error))?;
        let mut rgba = rgba;
        let row = CARD[0] as usize * 4;
        for (y, line) in card.rgba.chunks_exact(row).enumerate() {
            let at = y * width as usize * 4;
            rgba[at..at + row].copy_from_slice(line);
        }
        Ok(Picture { width, height, rgba })
    }

    /// What was measured; `None` where nothing was seen.
    pub fn summary(&self) -> Option<Summary> {
        (self.count > 0).then(|| Summary {
            full_color_millimetres: FULL_MILLIMETRES,
            root_mean_square_millimetres: (self.sum / self.count as f64).sqrt(),
            most_millimetres: self.most,
        })
    }
}

/// sRGB bytes of linear RGB.
fn bytes(linear: [f32; 3]) -> [u8; 3] {
    linear.map(|v| {
        let srgb = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (255.0 * srgb).round() as u8
    })
}

impl Summary {
    /// The view's legend, and the figures.
    pub fn note(&self) -> String {
        format!(
            "compare view: the skin under a ghost of linear skinning, red outside of it, blue inside, white where it is the same, in \
             full from {:.0} mm on; over all vertices and frames {:.2} mm apart in the root mean square, {:.1} mm at most",
            self.full_color_millimetres, self.root_mean_square_millimetres, self.most_millimetres
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew::clip::ClipChoice;
    use sinew::rig::{BuildOptions, muscle_file};

    #[test]
    fn linear_skinning_is_white_and_muscles_are_measured() {
        let scene = sinew::io::gltf::from_bytes(include_bytes!("../../assets/arm.glb"), "arm").expect("the arm");
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/arm.muscles.toml");
        let muscles = muscle_file::read(&file).expect("the arm's muscles").muscles;
        let rig = Arc::new(Rig::build(scene.character.clone(), &muscles, &BuildOptions::default()).expect("a rig"));
        let pose = scene.pose(ClipChoice::Clip(0), 1.0);
        let apart = |skinning| {
            let options = FrameOptions { skinning, dynamics: None, ..FrameOptions::default() };
            let skin = OnCpu::new(&rig, &options).skin(&pose).expect("a skin");
            let mut against = Against::of(&rig);
            assert!(against.summary().is_none());
            let (mesh, linear) = against.mesh(&rig, &pose, &skin).expect("a mesh");
            assert_eq!((mesh.positions.len(), linear.positions.len()), (skin.positions.len(), skin.positions.len()));
            (against.summary().expect("vertices"), mesh.colors)
        };
        let (same, colors) = apart(Skinning::Linear);
        assert!(same.most_millimetres == 0.0 && colors.iter().all(|c| *c == signed_color(0.0)), "{}", same.note());
        let (hybrid, colors) = apart(Skinning::Hybrid);
        assert!(hybrid.most_millimetres > 2.0, "{}", hybrid.note());
        assert!(hybrid.root_mean_square_millimetres < f64::from(hybrid.most_millimetres));
        assert!(colors.iter().any(|c| c[0] > c[2] + 0.05), "no vertex goes out");
    }

    #[test]
    fn the_legend_is_in_the_corner_and_small_pictures_have_none() {
        let plain = |width: u32, height: u32| Picture { width, height, rgba: vec![7; (width * height * 4) as usize] };
        let drawn = Against::legend(plain(200, 300)).expect("a picture");
        let pixel = |x: usize, y: usize| &drawn.rgba[(y * 200 + x) * 4..][..3];
        assert_eq!(pixel(199, 0), [7; 3], "outside of the card");
        let [top, bottom] = [50, 210].map(|y| pixel(25, y));
        assert!(top[0] > top[2] + 50 && bottom[2] > bottom[0] + 30, "{top:?} {bottom:?}");
        assert_eq!(Against::legend(plain(50, 50)).expect("a picture"), plain(50, 50));
    }
}
