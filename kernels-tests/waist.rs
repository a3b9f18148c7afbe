//! How the waist is creased where a body runs and jumps: the angles between faces against those at rest.

use crate::support::data;
use glam::Vec4;
use sinew::{
    clip::Scene,
    normals::Creases,
    reference::{Motion, Reference},
    rig::{BuildOptions, Rig},
    schedule::{FrameOptions, Skinning, TrackOptions},
};

fn scene(name: &str) -> Option<Scene> {
    Some(sinew::io::gltf::read(&data()?.join(format!("humans/{name}.glb"))).expect("a human"))
}

/// Edges of the waist: between faces that the back holds most, whose corners lie between two heights at rest, metres.
fn waist(rig: &Rig, heights: [f32; 2]) -> Creases {
    let of_back = |v: u32| {
        let influences = rig.character.influences_of(v as usize).iter();
        let most = influences.max_by(|a, b| a.weight.total_cmp(&b.weight)).expect("an influence");
        let name = &rig.character.joints[most.joint as usize].name;
        name.starts_with("pelvis") || name.starts_with("spine")
    };
    let within = |v: &u32| (heights[0]..heights[1]).contains(&rig.positions_rest[*v as usize].y) && of_back(*v);
    let triangles: Vec<[u32; 3]> = rig.character.triangles.iter().filter(|t| t.iter().all(within)).copied().collect();
    Creases::new(&triangles, &rig.graph.copy_of, &rig.positions_rest)
}

/// The change that 99.5 % of the waist's edges stay under in all frames together, degrees; with the skin above the waist's middle
/// moved aside by `step` metres.
fn most_creased(rig: &Rig, scene: &Scene, options: &FrameOptions, case: &Case, step: f32) -> f32 {
    let creases = waist(rig, case.heights);
    let clip = scene.choose_clip(Some(case.clip)).expect("the clip");
    let reference = Reference::new(rig);
    let mut motion = Motion::new(rig, options);
    let mut changes: Vec<f32> = Vec::new();
    for &frame in case.frames {
        let trace = reference.next(&mut motion, &scene.pose(clip, frame as f32 / 30.0), options).expect("a frame");
        let above = |v: usize| rig.positions_rest[v].y > 0.5 * (case.heights[0] + case.heights[1]);
        let stepped = |(v, p): (usize, &Vec4)| if above(v) { *p + Vec4::X * step } else { *p };
        let positions: Vec<Vec4> = trace.positions().iter().enumerate().map(stepped).collect();
        changes.extend(creases.changes(&positions).into_iter().map(f32::abs));
    }
    changes.sort_unstable_by(f32::total_cmp);
    assert!(changes.len() > 1000 * case.frames.len(), "{} edges", changes.len());
    changes[(changes.len() as f32 * 0.995) as usize]
}

struct Case {
    clip: &'static str,
    heights: [f32; 2],
    frames: &'static [u32],
}

const ATHLETIC: [Case; 2] = [
    Case { clip: "run_on_spot", heights: [0.92, 1.22], frames: &[21, 45, 86] },
    Case { clip: "jump", heights: [0.92, 1.22], frames: &[10, 21, 26] },
];
const AVERAGE: [Case; 2] = [
    Case { clip: "jump_series", heights: [0.94, 1.24], frames: &[30, 47, 70] },
    Case { clip: "squat", heights: [0.94, 1.24], frames: &[15, 27, 45] },
];

#[test]
fn the_waist_is_creased_hardly_more_than_by_linear_skinning() {
    for (human, cases) in [("mh_male_athletic", &ATHLETIC), ("mh_male_average_default163", &AVERAGE)] {
        let Some(scene) = scene(human) else { return };
        let rig = Rig::build(scene.character.clone(), &[], &BuildOptions::default()).expect("a rig");
        for case in cases {
            let linear = FrameOptions { skinning: Skinning::Linear, ..FrameOptions::default() };
            let single = FrameOptions { track: TrackOptions::single_pose(), ..FrameOptions::default() };
            let found = [linear, FrameOptions::default(), single].map(|o| most_creased(&rig, &scene, &o, case, 0.0));
            let [by_linear, by_history, by_pose] = found;
            println!(
                "{human}, {}: 99.5 % of the waist's edges change by less than {by_linear:.1} degrees in linear \
                 skinning, {by_history:.1} tracked, {by_pose:.1} from the pose alone",
                case.clip
            );
            assert!(by_history <= 2.0 * by_linear && by_pose <= 2.0 * by_linear, "{human} {}", case.clip);
            let stepped = most_creased(&rig, &scene, &linear, case, 3e-2);
            assert!(stepped > 2.0 * by_linear, "a step of 3 cm round the waist is seen: {stepped}");
        }
    }
}
