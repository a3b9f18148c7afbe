//! Linear blend skinning from our palettes and influences against Blender's positions.

use super::files::data;
use crate::clip::{ClipChoice, Scene};
use crate::io::gltf::read;
use glam::Vec3;
use npyz::npz::NpzArchive;

/// Metres. Blender rounds matrices and vertices to f32 (up to 5e-6 on the 4 m robot, 1e-6 on the humans) and joins
/// rotation keys by a straight line between quaternions where glTF asks for the arc, which leaves 1.7e-5 in the fastest
/// step of `run_on_spot`; joined its way, that pose too comes within 1e-6.
const TOLERANCE: f32 = 2e-5;

fn skinned(scene: &Scene, choice: ClipChoice, time: f32) -> Vec<Vec3> {
    let palette = scene.pose(choice, time).palette;
    let character = &scene.character;
    let position = |vertex: usize| {
        let rest = character.positions_rest[vertex];
        character
            .influences_of(vertex)
            .iter()
            .map(|i| palette[i.joint as usize].transform_point3(rest) * i.weight)
            .sum::<Vec3>()
    };
    (0..character.vertex_count()).map(position).collect()
}

/// An array of N x 3, stored by rows or by columns.
fn rows<R: std::io::Read>(array: npyz::NpyFile<R>) -> Vec<Vec3> {
    let by_columns = array.order() == npyz::Order::Fortran;
    assert_eq!(array.shape()[1..], [3]);
    let flat: Vec<f32> = array.into_vec().unwrap();
    let count = flat.len() / 3;
    let row = |v: usize| match by_columns {
        true => Vec3::new(flat[v], flat[count + v], flat[2 * count + v]),
        false => Vec3::from_slice(&flat[3 * v..]),
    };
    (0..count).map(row).collect()
}

fn worst(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (*a - *b).length()).fold(0.0, f32::max)
}

#[test]
fn skinned_positions_equal_blenders() {
    let Some(data) = data() else { return };
    let mut compared = 0;
    for (file, reference) in [
        ("characters/CesiumMan.glb", "CesiumMan"),
        ("characters/quaternius_robot.glb", "quaternius_robot"),
        ("humans/arm_male_athletic_2172.glb", "arm_male_athletic_2172"),
        ("humans/mh_male_athletic.glb", "mh_male_athletic"),
    ] {
        let scene = read(&data.join(file)).unwrap();
        let mut archive = NpzArchive::open(data.join(format!("reference/{reference}_blender_lbs.npz"))).unwrap();
        let keys: Vec<String> = archive.array_names().map(str::to_owned).collect();
        assert!(!keys.is_empty());
        for key in keys {
            let expected = rows(archive.by_name(&key).unwrap().unwrap());
            let (clip, seconds) = key.rsplit_once('|').unwrap();
            // Six decimals stand for a frame of 1/24 s.
            let seconds = (seconds.parse::<f32>().unwrap() * 24.0).round() / 24.0;
            let choice = scene.choose_clip(Some(clip)).unwrap();
            let ClipChoice::Clip(index) = choice else { panic!("{clip} is no clip") };
            // The key counts in the file's time, a pose from the clip's start.
            let start = scene.clips[index].start;
            let difference = worst(&skinned(&scene, choice, seconds - start), &expected);
            println!("{reference} {key}: {difference:.2e} m");
            assert!(difference <= TOLERANCE, "{reference} {key}: {difference}");
            compared += 1;
        }
    }
    println!("{compared} poses compared");
}

#[test]
fn the_comparison_fails_a_frame_later_and_with_a_joint_exchanged() {
    let Some(data) = data() else { return };
    let mut scene = read(&data.join("humans/mh_male_athletic.glb")).unwrap();
    let walk = scene.choose_clip(Some("walk")).unwrap();
    let right = skinned(&scene, walk, 0.5);
    assert!(worst(&right, &skinned(&scene, walk, 0.5 + 1.0 / 24.0)) > TOLERANCE);
    let last = scene.character.joints.len() as u32 - 1;
    scene.character.influences.iter_mut().for_each(|i| i.joint = if i.joint == 3 { last } else { i.joint });
    assert!(worst(&right, &skinned(&scene, walk, 0.5)) > TOLERANCE);
}
