//! `sinew muscles weights`: how far muscles take the skin with them, written into the character for an artist to paint.

use crate::args::{MusclesWeights, Skin};
use crate::failure::Failure;
use crate::load;
use crate::print;
use serde::Serialize;
use sinew::io::{atomic::WholeFile, gltf};
use sinew::schedule::Skinning;
use std::path::PathBuf;

#[derive(Serialize)]
struct Written {
    output: PathBuf,
    muscles: Vec<One>,
}

#[derive(Serialize)]
struct One {
    attribute: String,
    muscle: String,
    vertices: usize,
    largest: f32,
}

pub fn run(args: &MusclesWeights) -> Result<(), Failure> {
    load::threads(args.threads)?;
    let (scene, muscles) = load::input(&args.input)?;
    if muscles.muscles.is_empty() {
        return Err(Failure::Usage("muscles weights needs --muscles with a file that has some".into()));
    }
    let options = load::options(Skin { skinning: args.skinning, ..Skin::DEFAULT }, &args.dynamics, &muscles, true)?;
    let hybrid = match options.skinning {
        Skinning::Hybrid => true,
        Skinning::Weighted => false,
        _ => return Err(Failure::Usage("weights are of --skinning weighted or hybrid; give one of them".into())),
    };
    let mut file = WholeFile::create(&args.output).map_err(Failure::input)?;
    let rig = load::rig_for(&options, &args.input, &scene, &muscles, true)?;
    let painted = rig.painted_weights(hybrid);
    let bytes = gltf::with_muscle_weights(&args.input.file, &rig.character, &painted).map_err(Failure::input)?;
    file.put(&bytes).map_err(Failure::input)?;
    file.finish().map_err(Failure::input)?;
    let one = |(n, spec): (usize, &sinew::rig::MuscleSpec)| {
        let own = painted.iter().filter(|p| p.muscle as usize == n).flat_map(|p| &p.weights);
        One {
            attribute: format!("_MUSCLE_{n}"),
            muscle: spec.name.clone(),
            vertices: own.clone().filter(|w| **w > 0.0).count(),
            largest: own.fold(0.0, |most, w| most.max(*w)),
        }
    };
    let written = Written { output: args.output.clone(), muscles: rig.specs.iter().enumerate().map(one).collect() };
    print::result(args.json, &written, text)
}

fn text(written: &Written) -> String {
    let line = |one: &One| {
        format!("\n  {} {}: {} vertices, {:.2} at most", one.attribute, one.muscle, one.vertices, one.largest)
    };
    format!("{}{}", written.output.display(), written.muscles.iter().map(line).collect::<String>())
}
