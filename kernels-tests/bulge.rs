//! What muscles do to skin: the dense arm of the test data at full flexion of its curl, with the fixture's muscles and with those
//! that extraction finds in it.

use crate::support::data;
use glam::{DVec2, DVec3, Mat4, Vec3, Vec3Swizzles, Vec4, Vec4Swizzles};
use sinew::{
    clip::Scene,
    dynamics,
    extract::{
        self,
        section::{Plane, Surface, cut},
    },
    reference::{Motion, Reference},
    rig::{BuildOptions, Character, MuscleSpec, Pose, Rig, muscle_file, roles::Roles},
    schedule::{DynamicsOptions, FrameOptions, Skinning},
};
use std::path::Path;

/// Frame of `biceps_curl` at 30 fps where the elbow is bent most, by 130 degrees.
const BENT: u32 = 43;

struct Arm {
    scene: Scene,
    rig: Rig,
}

impl Arm {
    /// The arm with the fixture's muscles, or with none.
    fn new(muscles: bool) -> Option<Arm> {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("kernels-tests/fixtures/arm_nohand_dense_2172.muscles.toml");
        let file = muscle_file::read(&path).expect("the fixture");
        Arm::with(|_| if muscles { file.muscles.clone() } else { Vec::new() })
    }

    /// The arm with muscles that may be found in it.
    fn with(muscles: impl Fn(&Character) -> Vec<MuscleSpec>) -> Option<Arm> {
        let scene = sinew::io::gltf::read(&data()?.join("humans/arm_nohand_dense_2172.glb")).expect("the arm");
        let muscles = muscles(&scene.character);
        let mut rig = Rig::build(scene.character.clone(), &muscles, &BuildOptions::default()).expect("a rig");
        dynamics::settle(&mut rig, &DynamicsOptions::default());
        Some(Arm { scene, rig })
    }

    fn pose(&self, frame: u32) -> Pose {
        self.scene.pose(self.scene.choose_clip(Some("biceps_curl")).expect("the clip"), frame as f32 / 30.0)
    }

    /// The bent arm in the space of the upper arm's bone, metres, Y along the bone and Z front: implicitly skinned, its
    /// muscles simulated over the whole curl, and linearly skinned.
    fn skins(&self) -> [Vec<Vec3>; 2] {
        self.skinned([Skinning::Implicit, Skinning::Linear])
    }

    /// The same by other skinnings.
    fn skinned<const N: usize>(&self, skinnings: [Skinning; N]) -> [Vec<Vec3>; N] {
        let pose = self.pose(BENT);
        let joint = self.rig.character.joints.iter().position(|j| j.name == "upperarm_l").expect("the upper arm");
        let to_bone: Mat4 = (pose.palette[joint] * self.rig.character.joints[joint].bind()).inverse();
        skinnings.map(|skinning| {
            let options =
                FrameOptions { skinning, dynamics: Some(DynamicsOptions::default()), ..FrameOptions::default() };
            let reference = Reference::new(&self.rig);
            let mut motion = Motion::new(&self.rig, &options);
            for frame in 0..BENT {
                reference.next(&mut motion, &self.pose(frame), &options).expect("a frame");
            }
            let trace = reference.next(&mut motion, &pose, &options).expect("a frame");
            trace.positions().iter().map(|p: &Vec4| to_bone.transform_point3(p.xyz())).collect()
        })
    }

    /// Girths of the upper arm across its bone at 30, 40 and 50 % of it, metres.
    fn girths(&self, skin: &[Vec3]) -> [f64; 3] {
        let character = &self.rig.character;
        let joint = |name: &str| character.joints.iter().position(|j| j.name == name).expect("a joint");
        let (upper, lower) = (joint("upperarm_l"), joint("lowerarm_l"));
        let length = (character.joints[upper].bind().inverse() * character.joints[lower].bind()).w_axis.y;
        let own = |v: u32| {
            let most = character.influences_of(v as usize).iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
            most.is_some_and(|most| most.joint as usize == upper)
        };
        let surface = Surface {
            positions_rest: skin.iter().map(|p| p.as_dvec3()).collect(),
            triangles: character.triangles.iter().filter(|t| t.iter().all(|&v| own(v))).copied().collect(),
            ..Surface::default()
        };
        [0.3, 0.4, 0.5].map(|share| {
            let plane = Plane::across(DVec3::Y * f64::from(length) * share, DVec3::Y, DVec3::X);
            let round = cut(&surface, &plane).into_iter().filter(|cut| cut.surrounds(DVec2::ZERO));
            round.map(|cut| cut.length()).next().expect("the arm's outline")
        })
    }

    /// How far skin stands out from the bone's axis beyond linear skinning, metres, at every vertex of the upper arm's
    /// front between two shares of the bone's length (the elbow is at 1).
    fn rises(&self, [implicit, linear]: &[Vec<Vec3>; 2], from: f32, to: f32) -> Vec<(usize, f32)> {
        let character = &self.rig.character;
        let joint = |name: &str| character.joints.iter().position(|j| j.name == name).expect("a joint");
        let (upper, lower) = (joint("upperarm_l"), joint("lowerarm_l"));
        let length = (character.joints[upper].bind().inverse() * character.joints[lower].bind()).w_axis.y;
        let away = |p: Vec3| p.xz().length();
        let front = |v: &usize| {
            let (p, share) = (linear[*v], linear[*v].y / length);
            let own = character.influences_of(*v).iter().find(|i| i.joint as usize == upper).map_or(0.0, |i| i.weight);
            (from..to).contains(&share) && p.z > 0.6 * away(p) && own > 0.5
        };
        (0..linear.len()).filter(front).map(|v| (v, away(implicit[v]) - away(linear[v]))).collect()
    }
}

fn mean(rises: &[(usize, f32)]) -> f32 {
    rises.iter().map(|(_, rise)| rise).sum::<f32>() / rises.len() as f32
}

#[test]
fn the_biceps_lifts_the_skin_at_full_flexion_smoothly() {
    let Some(arm) = Arm::new(true) else { return };
    let pose = arm.pose(BENT);
    let parameters = arm.rig.drives.parameters(&pose, &arm.rig.axis_ratios(&pose)).expect("parameters");
    assert!(parameters[0].activation > 0.95, "the biceps is active: {}", parameters[0].activation);
    let skins = arm.skins();
    let belly = arm.rises(&skins, 0.3, 0.55);
    println!("the belly's skin stands out by {} m in the mean, {} vertices", mean(&belly), belly.len());
    assert!(belly.len() > 30 && mean(&belly) > 4e-3, "{} m over {} vertices", mean(&belly), belly.len());
    // No ball: the rise comes and goes along the arm, and few edges climb it steeper than 45 degrees. Some do, since
    // neighbours are tracked each by itself.
    let all = arm.rises(&skins, 0.15, 0.5);
    let highest = all.iter().map(|(_, rise)| *rise).fold(0.0, f32::max);
    let mut slopes = Vec::new();
    let rise_of = |v: u32| all.iter().find(|(w, _)| *w == v as usize).map(|(_, rise)| *rise);
    let [_, linear] = &skins;
    for t in &arm.rig.character.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            if let (Some(from), Some(to)) = (rise_of(a), rise_of(b)) {
                let slope = (from - to).abs() / linear[a as usize].distance(linear[b as usize]);
                slopes.push(slope);
            }
        }
    }
    slopes.sort_by(f32::total_cmp);
    let [most, steepest] = [0.95, 1.0].map(|share| slopes[((slopes.len() - 1) as f32 * share) as usize]);
    println!("at most by {highest} m; 95 % of its edges climb by {most} at most, the steepest one by {steepest}");
    assert!(highest < 0.016, "a rise of {highest} m");
    assert!(most < 1.0, "edges climb by {most}");
    // The fields alone lift it less: what is measured is the muscles' doing.
    let bare = Arm::new(false).expect("as above");
    let without = mean(&bare.rises(&bare.skins(), 0.3, 0.55));
    assert!(without < 4e-3, "without muscles: {without}");
    assert!(mean(&belly) > without + 2e-3, "{} with, {without} without", mean(&belly));
}

/// How much larger girths are than those of linear skinning.
fn over(girths: [f64; 3], linear: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| girths[k] / linear[k] - 1.0)
}

fn most(shares: [f64; 3]) -> f64 {
    shares.into_iter().fold(f64::MIN, f64::max)
}

#[test]
fn extracted_muscles_give_a_bent_arm_its_girth() {
    let found = |character: &Character| {
        let extraction = extract::extract(character, &Roles::find(character), &[]).expect("muscles");
        extraction.muscles.into_iter().map(|m| m.spec).collect::<Vec<_>>()
    };
    let Some(arm) = Arm::with(found) else { return };
    let bare = Arm::new(false).expect("as above");
    let [implicit, hybrid, linear] = arm.skinned([Skinning::Implicit, Skinning::Hybrid, Skinning::Linear]);
    let linear = arm.girths(&linear);
    let [implicit, hybrid] = [implicit, hybrid].map(|skin| over(arm.girths(&skin), linear));
    let without = over(arm.girths(&bare.skins()[0]), linear);
    println!(
        "girth over linear skinning at 30, 40, 50 %: implicit {implicit:.3?} hybrid {hybrid:.3?} bare {without:.3?}"
    );
    for girths in [implicit, hybrid] {
        assert!((0.04..0.12).contains(&most(girths)), "{girths:?}");
    }
    // The fold gives volume back beside the elbow, and the muscles add to that.
    let sum = |girths: [f64; 3]| girths.iter().sum::<f64>();
    assert!(sum(implicit) > sum(without) + 0.02, "{implicit:?} with, {without:?} without");
}
