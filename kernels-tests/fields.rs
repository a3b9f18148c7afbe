//! Field groups and fields of every character in the test data: names, fit, coverage, repeatability.

use glam::Vec3;
use sinew::field::{grid, transfer::transfer};
use sinew::rig::Character;
use sinew::rig::groups::{FieldGroups, FieldOptions, Fields, build_fields};
use std::path::PathBuf;

/// Reads a character below `SINEW_DATA`; `None`, said aloud, where that is not set.
fn read(path: &str) -> Option<Character> {
    let Some(data) = std::env::var_os("SINEW_DATA") else {
        eprintln!("SINEW_DATA is not set: {path} is not tested");
        return None;
    };
    Some(sinew::io::gltf::read(&PathBuf::from(data).join(path)).unwrap().character)
}

fn fields(character: &Character) -> (FieldGroups, Fields) {
    let groups = FieldGroups::detect(character);
    let fields = build_fields(character, &groups, &FieldOptions::default()).unwrap();
    (groups, fields)
}

/// Names of the groups, sorted, without a part of unknown name.
fn names(groups: &FieldGroups) -> Vec<&str> {
    let mut names: Vec<&str> = groups.groups.iter().map(|g| g.name.as_str()).collect();
    names.sort_unstable();
    names
}

/// What the composed field says of the vertices that limbs and trunk own.
#[derive(Debug)]
struct Coverage {
    /// Vertices of groups that are not passive.
    vertices: usize,
    /// Share of them with a value in .03..=.97 and a gradient within acos(.3) of the mesh normal.
    active: f32,
    /// Largest over the groups: median raw distance over the support radius.
    off: f32,
}

fn coverage(character: &Character, groups: &FieldGroups, fields: &Fields) -> Coverage {
    let limbs: Vec<usize> = (0..character.vertex_count())
        .filter(|&v| groups.groups.get(groups.owner[v] as usize).is_some_and(|g| !g.passive))
        .collect();
    let active = limbs.iter().filter(|&&v| {
        let mut best = (0.0, Vec3::ZERO);
        for grid in &fields.grids {
            let Some((d, outward)) = grid::sample(grid, &fields.nodes, character.positions_rest[v]) else { continue };
            let (value, _) = transfer(d, grid.support_radius);
            if value > best.0 {
                best = (value, outward);
            }
        }
        (0.03..=0.97).contains(&best.0) && best.1.normalize_or_zero().dot(character.normals_rest[v]) >= 0.3
    });
    let ratio = fields.fits.iter().zip(&groups.groups).filter(|(_, g)| !g.passive);
    Coverage {
        vertices: limbs.len(),
        active: active.count() as f32 / limbs.len().max(1) as f32,
        off: ratio.map(|(f, _)| f.median_distance / f.support_radius).fold(0.0, f32::max),
    }
}

const HUMAN: [&str; 15] = [
    "calf_l",
    "calf_r",
    "foot_l",
    "foot_r",
    "forearm_l",
    "forearm_r",
    "hand_l",
    "hand_r",
    "head",
    "neck",
    "thigh_l",
    "thigh_r",
    "trunk",
    "upperarm_l",
    "upperarm_r",
];

#[test]
fn humans_have_fifteen_groups_that_lie_on_the_skin() {
    for path in
        ["humans/mh_male_athletic.glb", "humans/mh_male_average_default163.glb", "humans/mh_male_athletic_cc1.glb"]
    {
        let Some(character) = read(path) else { return };
        let started = std::time::Instant::now();
        let (groups, fields) = fields(&character);
        let seconds = started.elapsed().as_secs_f32();
        assert_eq!(names(&groups), HUMAN, "{path}");
        let drivers: Vec<&str> =
            groups.groups.iter().map(|g| character.joints[g.joint as usize].name.as_str()).collect();
        assert!(
            !drivers.iter().any(|d| d.contains("finger") || d.contains("toe") || d.contains("spine04")),
            "{drivers:?}"
        );
        assert!(groups.owner.iter().all(|&o| o != u32::MAX));
        let coverage = coverage(&character, &groups, &fields);
        eprintln!("{path}: {coverage:?}, {seconds:.2} s");
        // The prototypes aimed at limbs and trunk alone; a few vertices of the armpit face into the fold.
        assert!(coverage.active > 0.99 && coverage.vertices > 4000, "{path}: {coverage:?}");
        // 100 samples a group: the surface between them keeps within a millimetre, about 3 % of a forearm's support.
        assert!(coverage.off < 0.03, "{path}: {coverage:?}");
        for fit in &fields.fits {
            assert!(fit.rms_distance < 0.15 * fit.support_radius && fit.raised_nodes < 50, "{path}: {fit:?}");
        }
        // The same measure on a skin that stands off by a third of a forearm's radius must not pass.
        let mut swollen = character.clone();
        for (p, n) in swollen.positions_rest.iter_mut().zip(&character.normals_rest) {
            *p += *n * 0.02;
        }
        assert!(self::coverage(&swollen, &groups, &fields).active < 0.99);
    }
}

#[test]
fn other_characters_have_sensible_groups_and_finite_fields() {
    let expected = [
        ("humans/arm_male_athletic_2172.glb", vec!["forearm_l", "hand_l", "upperarm_l"], 0.99),
        ("humans/arm_nohand_dense_2172.glb", vec!["forearm_l", "upperarm_l"], 0.98),
        ("characters/CesiumMan.glb", HUMAN.to_vec(), 0.9),
        // Hard edges and armour plates: normals stand apart from any smooth field.
        ("characters/kaykit_Barbarian.glb", HUMAN.into_iter().filter(|&n| n != "neck").collect(), 0.7),
        ("characters/quaternius_robot.glb", HUMAN.into_iter().filter(|&n| n != "neck").collect(), 0.6),
        ("characters/SimpleSkin.gltf", vec![], 0.0),
        ("characters/quad_skin.glb", vec![], 0.0),
        ("characters/unassigned-skeleton.gltf", vec![], 0.0),
    ];
    for (path, groups_expected, active) in expected {
        let Some(character) = read(path) else { return };
        let (groups, fields) = fields(&character);
        assert_eq!(names(&groups), groups_expected, "{path}");
        assert!(fields.nodes.iter().all(|n| n.is_finite()), "{path}");
        let coverage = coverage(&character, &groups, &fields);
        eprintln!("{path}: {coverage:?}");
        assert!(coverage.active >= active, "{path}: {coverage:?}");
        for (k, group) in groups.groups.iter().enumerate() {
            assert!(group.parent != Some(k as u32) && group.joints.contains(&group.joint), "{path}: {group:?}");
        }
    }
}

#[test]
fn the_same_character_gives_the_same_bytes() {
    let Some(character) = read("humans/arm_male_athletic_2172.glb") else { return };
    let (first, second) = (fields(&character), fields(&character));
    assert_eq!(first, second);
    let mut moved = character.clone();
    moved.positions_rest[7].x += 1e-3;
    assert_ne!(first.1.nodes, fields(&moved).1.nodes);
}
