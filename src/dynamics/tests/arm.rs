//! A real arm.

use super::*;
use crate::rig::{BuildOptions, Pose, Rig, muscle_file};
use crate::schedule::{Contacts, DynamicsOptions, Solver};
use glam::Vec4Swizzles;
use std::path::Path;

pub struct Arm {
    pub scene: crate::clip::Scene,
    pub rig: Rig,
    pub bodies: std::sync::Arc<Bodies>,
}

impl Arm {
    pub fn new(group: &str, keep: &[&str]) -> Option<Arm> {
        let data = std::env::var_os("SINEW_DATA").map(std::path::PathBuf::from)?;
        let scene = crate::io::gltf::read(&data.join("humans/arm_nohand_dense_2172.glb")).expect("the arm");
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("kernels-tests/fixtures/arm_nohand_dense_2172.muscles.toml");
        let mut file = muscle_file::read(&path).expect("the fixture");
        file.muscles.retain(|m| keep.is_empty() || keep.iter().any(|k| m.name.contains(k)));
        for m in &mut file.muscles {
            m.collision_group = group.into();
        }
        let rig = Rig::build(scene.character.clone(), &file.muscles, &BuildOptions::default()).expect("a rig");
        let bodies = std::sync::Arc::new(Bodies::new(&rig));
        Some(Arm { scene, rig, bodies })
    }

    pub fn pose(&self, clip: &str, time: f32) -> Pose {
        self.scene.pose(self.scene.choose_clip(Some(clip)).expect("the clip"), time)
    }

    pub fn skins(&self) -> Skins<'_> {
        Skins { grids: &self.rig.grids, nodes: &self.rig.nodes }
    }

    pub fn inputs(&self, pose: &Pose, activation: Option<f32>) -> FrameInputs {
        let mut pose = pose.clone();
        if let Some(a) = activation {
            pose.activations = vec![a; self.rig.specs.len()];
        }
        FrameInputs::new(&self.rig, &pose).expect("a pose")
    }
}

#[derive(Default, Debug, Clone)]
pub struct Measured {
    bone: Vec<f32>,
    skin: f32,
    overlap: f32,
    speed: f32,
    /// Farthest from the straight axis.
    bow: f32,
}

pub fn measure(arm: &Arm, s: &Simulation, inputs: &FrameInputs) -> Measured {
    let mut moved = vec![MovedJoint::default(); inputs.joints.len()];
    let both: Vec<JointFrame> = inputs.joints.iter().chain(&inputs.joints).copied().collect();
    joints::step(&StepClock::default(), true, &both, &mut moved);
    let half = crate::field::muscle::axis::half(arm.bodies.muscles.len() as u32, s.particles.len() as u32);
    let around = contact::Surroundings {
        muscles: &arm.bodies.muscles,
        bones: &arm.bodies.bones,
        links: &arm.bodies.links,
        moved: &moved,
        grids: &arm.rig.grids,
        nodes: &arm.rig.nodes,
        iterates: &s.iterates[..half],
    };
    let mut out = Measured::default();
    for muscle in &arm.bodies.muscles {
        let own = &s.particles[muscle.first_point as usize..][..=muscle.segments as usize];
        let n = own.len() - 1;
        for i in 1..n {
            let p = own[i].position.xyz();
            let share = i as f32 / n as f32;
            let (radius, clear) = (own[i].position.w, own[i].traits.x);
            let straight = own[0].position.xyz().lerp(own[n].position.xyz(), share);
            out.bow = out.bow.max(p.distance(straight));
            out.speed = out.speed.max(own[i].velocity.xyz().length());
            let links = |a: u32, b: u32| &arm.bodies.links[a as usize..b as usize];
            if clear >= 1.0 {
                for link in links(muscle.bones_begin, muscle.peers_begin) {
                    let c = around.bone(link, p, radius, clear, share);
                    out.bone.push((-c.distance / radius).max(0.0));
                }
                for link in links(muscle.peers_begin, muscle.skins_begin) {
                    out.overlap = out.overlap.max(-around.muscle(link, p, radius).distance);
                }
                let c = around.skin(links(muscle.skins_begin, muscle.links_end), p, straight);
                if -c.distance > out.skin {
                    out.skin = -c.distance;
                }
            }
        }
    }
    out.bone.sort_by(f32::total_cmp);
    out
}

fn line(label: &str, m: &Measured) {
    let p = |q: f32| m.bone.get(((m.bone.len() as f32 - 1.0) * q) as usize).copied().unwrap_or(0.0);
    println!(
        "{label}: bone p95 {:.2} % max {:.2} %  skin {:.3} mm overlap {:.2} mm speed {:.3} mm/s bow {:.2} mm",
        p(0.95) * 100.0,
        p(1.0) * 100.0,
        m.skin * 1e3,
        m.overlap * 1e3,
        m.speed * 1e3,
        m.bow * 1e3
    );
}

#[test]
fn variants() {
    let sets: [&[&str]; 2] = [&["biceps", "brachialis", "triceps"], &[]];
    for (set, (var, outer, deadband, hz)) in sets.iter().flat_map(|s| {
        [(0u32, 2, 0.0f32, 3e-4f32), (0, 2, 5e-5, 3e-4), (0, 2, 5e-5, 5e-4), (0, 2, 1e-4, 3e-4)].map(|c| (s, c))
    }) {
        let Some(arm) = Arm::new("all", set) else { return };
        for a in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let o = DynamicsOptions { outer, deadband, play: hz, ..DynamicsOptions::default() };
            let mut s = Simulation::new(arm.bodies.clone());
            let pose = arm.pose("biceps_curl", 43.0 / 30.0);
            let run = |k: u32, s: &mut Simulation| {
                let pose = arm.pose("biceps_curl", k.min(43) as f32 / 30.0);
                let inputs = arm.inputs(&pose, Some(a));
                s.advance(arm.skins(), &inputs, f64::from(k) / 30.0, &o);
            };
            for k in 0..=91 {
                run(k, &mut s);
            }
            let inputs = arm.inputs(&pose, Some(a));
            let before: Vec<Vec3> = s.particles.iter().map(|p| p.position.xyz()).collect();
            let mut wander = vec![0.0f32; before.len()];
            for k in 0..240 {
                s.advance(arm.skins(), &inputs, 92.0 / 30.0 + f64::from(k) / 240.0, &o);
                for (w, (p, q)) in wander.iter_mut().zip(s.particles.iter().zip(&before)) {
                    *w = w.max(p.position.xyz().distance(*q));
                }
            }
            let per: Vec<String> = arm
                .bodies
                .muscles
                .iter()
                .zip(&arm.rig.muscle_names)
                .map(|(m, n)| {
                    let own = &wander[m.first_point as usize..][..=m.segments as usize];
                    format!("{n} {:.2}", own.iter().fold(0.0f32, |a, b| a.max(*b)) * 1e3)
                })
                .collect();
            let m = measure(&arm, &s, &inputs);
            line(&format!("{set:?} slack {hz} var {var} outer {outer} dead {deadband} a {a}"), &m);
            println!("    {}", per.join("  "));
        }
    }
}

#[test]
fn explore() {
    for (group, keep) in [("all", Vec::<&str>::new())] {
        let Some(arm) = Arm::new(group, &keep) else { return };
        println!("group `{group}`: {} muscles, bones {:?}", arm.rig.muscles.len(), arm.rig.bones.len());
        for a in [0.0, 1.0] {
            for o in [DynamicsOptions::default(), DynamicsOptions { solver: Solver::Jacobi, ..Default::default() }] {
                let mut s = Simulation::new(arm.bodies.clone());
                let t0 = std::time::Instant::now();
                for k in 0..=43 {
                    let pose = arm.pose("biceps_curl", k as f32 / 30.0);
                    let inputs = arm.inputs(&pose, Some(a));
                    s.advance(arm.skins(), &inputs, f64::from(k) / 30.0, &o);
                    if k % 14 == 0 {
                        line(&format!("a {a} {:?} curl {k}", o.solver), &measure(&arm, &s, &inputs));
                    }
                }
                let pose = arm.pose("biceps_curl", 43.0 / 30.0);
                let inputs = arm.inputs(&pose, Some(a));
                for k in 0..48 {
                    s.advance(arm.skins(), &inputs, f64::from(44 + k) / 30.0, &o);
                }
                line(&format!("a {a} {:?} held 1.6 s", o.solver), &measure(&arm, &s, &inputs));
                let before: Vec<Vec3> = s.particles.iter().map(|p| p.position.xyz()).collect();
                let mut wander = 0.0f32;
                let mut speed = 0.0f32;
                for k in 0..240 {
                    s.advance(arm.skins(), &inputs, 92.0 / 30.0 + f64::from(k) / 240.0, &o);
                    for (p, q) in s.particles.iter().zip(&before) {
                        wander = wander.max(p.position.xyz().distance(*q));
                        speed = speed.max(p.velocity.xyz().length());
                    }
                }
                println!(
                    "   wander {:.4} mm over 1 s, speed {:.4} mm/s; {:?}",
                    wander * 1e3,
                    speed * 1e3,
                    t0.elapsed()
                );
            }
        }
        let _ = Contacts::ALL;
        for f in [6.0, 12.0, 24.0] {
            let o = DynamicsOptions { frequency: f, ..Default::default() };
            let mut s = Simulation::new(arm.bodies.clone());
            let mut all = Measured::default();
            for k in 0..60 {
                let pose = arm.pose("arm_shake", k as f32 / 30.0);
                let inputs = arm.inputs(&pose, None);
                s.advance(arm.skins(), &inputs, f64::from(k) / 30.0, &o);
                let m = measure(&arm, &s, &inputs);
                all.bone.extend(&m.bone);
                all.skin = all.skin.max(m.skin);
                all.overlap = all.overlap.max(m.overlap);
                all.bow = all.bow.max(m.bow);
            }
            all.bone.sort_by(f32::total_cmp);
            line(&format!("shake {f} Hz"), &all);
        }
    }
}
