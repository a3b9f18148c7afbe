//! Writes the built-in character: `cargo run --example make-arm -- assets`.
//!
//! The arm's skin is the zero set of one function of bones and known muscles, so that the muscle file beside the
//! models names what makes their bulges. The same sources give the same bytes.

mod clips;
mod field;
mod glb;
mod hand;
mod mesh;
mod muscles;
mod place;
mod skeleton;
#[cfg(test)]
mod tests;
mod texture;
mod topology;

use skeleton::Skeleton;
use std::{error::Error, path::Path};

/// File, fineness and rings of the two models: 2,172 and 19,976 vertices.
const MODELS: [(&str, usize, usize); 2] = [("arm.glb", 1, 60), ("arm_20k.glb", 3, 186)];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "assets".into());
    let folder = Path::new(&folder);
    let skeleton = Skeleton::bind();
    std::fs::write(folder.join("arm.muscles.toml"), muscles::muscle_file(&skeleton))?;
    let texture = texture::png()?;
    let clips = [clips::curl(), clips::shake(&skeleton)];
    for (name, m, rings) in MODELS {
        let mesh = mesh::build(&skeleton, m, rings);
        let file = glb::write(&mesh, &skeleton, &clips, &texture);
        std::fs::write(folder.join(name), &file)?;
        let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
        println!("{name}: {vertices} vertices, {triangles} triangles, {} bytes", file.len());
    }
    Ok(())
}
