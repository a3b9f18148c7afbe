//! `muscle_project` against its twin: random muscles through each other, a capsule, and balls as bone and as skin.

use crate::dynamics_fixtures::Crowd;
use crate::support::{JUNK, gpu, run_variant};
use glam::{Vec3, Vec4, Vec4Swizzles};
use sinew::{
    dynamics::{DynamicsParams, Particle},
    kernel::kernel,
    parity::PROJECTED,
    schedule::{Contacts, DynamicsOptions, KernelId, Mode, Solver},
};

fn played(crowd: &Crowd, params: &DynamicsParams) -> Option<(Vec<Particle>, Vec<Vec4>)> {
    played_by(0, crowd, params)
}

fn played_by(variant: usize, crowd: &Crowd, params: &DynamicsParams) -> Option<(Vec<Particle>, Vec<Vec4>)> {
    let gpu = gpu()?;
    let groups = crowd.groups();
    let inputs: [(&str, &[u8]); 9] = [
        ("params", bytemuck::bytes_of(params)),
        ("bodies", bytemuck::cast_slice(&crowd.muscles)),
        ("bones", bytemuck::cast_slice(&crowd.bones)),
        ("links", bytemuck::cast_slice(&crowd.links)),
        ("moved", bytemuck::cast_slice(&crowd.moved)),
        ("groups", bytemuck::cast_slice(&groups)),
        ("nodes", bytemuck::cast_slice(&crowd.nodes)),
        ("particles", bytemuck::cast_slice(&crowd.particles)),
        ("iterates", bytemuck::cast_slice(&crowd.iterates)),
    ];
    let sizes = [
        ("particles", (crowd.particles.len() + 1) * size_of::<Particle>()),
        ("iterates", (crowd.iterates.len() + 1) * 16),
    ];
    let items = crowd.muscles.len() * crowd.instances * params.threads_per_muscle as usize;
    let out = run_variant(&gpu, (KernelId::MuscleProject, variant), items as u64, &inputs, &sizes);
    let mut particles: Vec<Particle> = bytemuck::pod_collect_to_vec(&out[0]);
    let mut iterates: Vec<Vec4> = bytemuck::pod_collect_to_vec(&out[1]);
    assert_eq!(particles.pop().map(|p| p.traits.w.to_bits()), Some(JUNK), "written beyond the last particle");
    assert_eq!(iterates.pop().map(|v| v.w.to_bits()), Some(JUNK), "written beyond the last iterate");
    Some((particles, iterates))
}

/// Of each particle, how far places and displacements of a substep are apart, in lengths of its muscle.
fn distances(crowd: &Crowd, params: &DynamicsParams, particles: &[Particle]) -> Vec<f32> {
    let pairs = particles.iter().zip(&crowd.particles).zip(crowd.lengths());
    let off = |((a, b), length): ((&Particle, &Particle), f32)| {
        let moved = (a.velocity - b.velocity).xyz() * params.seconds;
        let off = (a.position - b.position).length().max(moved.length()) / length;
        let kept = (a.traits, a.velocity.w, a.spring.w) == (b.traits, b.velocity.w, b.spring.w);
        if off.is_nan() || !kept { f32::INFINITY } else { off }
    };
    pairs.map(off).collect()
}

/// Largest difference of the iterates, metres and directions alike; what is untouched must be the same bits.
fn iterates_apart(a: &[Vec4], b: &[Vec4]) -> f32 {
    let off = |(a, b): (&Vec4, &Vec4)| {
        if a.to_array().map(f32::to_bits) == b.to_array().map(f32::to_bits) {
            return 0.0;
        }
        let off = (*a - *b).length();
        if off.is_nan() { f32::INFINITY } else { off }
    };
    a.iter().zip(b).map(off).fold(0.0, f32::max)
}

fn options() -> Vec<(&'static str, DynamicsOptions)> {
    let usual = DynamicsOptions { deadband: 2e-5, ..DynamicsOptions::default() };
    vec![
        ("red-black", usual),
        ("jacobi", DynamicsOptions { solver: Solver::Jacobi, ..usual }),
        ("pbd red-black", DynamicsOptions { mode: Mode::Pbd, inner: 15, ..usual }),
        ("pbd jacobi", DynamicsOptions { mode: Mode::Pbd, inner: 15, solver: Solver::Jacobi, ..usual }),
    ]
}

/// What collides, one kind at a time and all of them.
fn kinds() -> [(&'static str, Contacts); 5] {
    let none = Contacts::NONE;
    [
        ("nothing", none),
        ("bones", Contacts { bones: true, ..none }),
        ("muscles", Contacts { muscles: true, ..none }),
        ("skin", Contacts { skin: true, ..none }),
        ("all", Contacts::ALL),
    ]
}

/// A crowd that is ready for its outer iteration number `outer`, of two.
fn ready(crowd: &Crowd, options: &DynamicsOptions, outer: u32) -> (Crowd, DynamicsParams) {
    let mut crowd = crowd.clone();
    crowd.predict(&crowd.params(options, 0));
    if outer == 1 {
        crowd.project(&crowd.params(options, 0));
    }
    let params = crowd.params(options, outer);
    (crowd, params)
}

#[test]
fn matches_its_twin_with_every_solver_and_contact() {
    let start = Crowd::new(61, 2, None, 71);
    assert!(start.muscles.iter().any(|m| m.segments == 3) && start.muscles.iter().any(|m| m.segments == 63));
    for (solver, options) in options() {
        for (kind, contacts) in kinds() {
            for outer in [0, 1] {
                let options = DynamicsOptions { contacts, ..options };
                let (mut crowd, params) = ready(&start, &options, outer);
                assert_eq!(params.ends_substep, outer);
                let Some((particles, iterates)) = played(&crowd, &params) else { return };
                crowd.project(&params);
                let off = distances(&crowd, &params, &particles);
                let worst = off.iter().copied().fold(0.0, f32::max);
                let pushed = crowd.particles.iter().filter(|p| p.pushes.max_element() > 0.0).count();
                println!(
                    "{solver}, {kind}, outer {outer}: {worst:.2e} of a muscle's length, iterates {:.2e} m, {pushed} pushed",
                    iterates_apart(&iterates, &crowd.iterates)
                );
                let over: Vec<usize> = (0..off.len()).filter(|&i| off[i] > PROJECTED.absolute).collect();
                assert!(
                    over.len() as f32 <= PROJECTED.share_over * off.len() as f32,
                    "{solver}, {kind}, outer {outer}: {over:?}"
                );
                assert!(iterates_apart(&iterates, &crowd.iterates) < PROJECTED.absolute, "{solver}, {kind}, {outer}");
                assert_eq!(pushed > 100, kind != "nothing", "{kind}: {pushed} particles of {} touch", off.len());
            }
        }
    }
}

#[test]
fn matches_its_twin_at_every_count() {
    for (count, points) in [(0, 4), (1, 4), (1, 64), (3, 31), (3, 32), (3, 33), (65, 5)] {
        let options = DynamicsOptions::default();
        let (mut crowd, params) = ready(&Crowd::new(count, 3, Some(points), 72), &options, 1);
        let runs = crowd.moved.len() / 3;
        // The second instance is at rest until its next frame.
        crowd.moved[runs..2 * runs].iter_mut().for_each(|m| m.runs = 0);
        let Some((particles, iterates)) = played(&crowd, &params) else { return };
        let before = crowd.clone();
        crowd.project(&params);
        let off = distances(&crowd, &params, &particles);
        assert!(off.iter().all(|o| *o <= PROJECTED.absolute), "{count} of {points}: {off:?}");
        assert!(iterates_apart(&iterates, &crowd.iterates) < PROJECTED.absolute, "{count} of {points}");
        let still = crowd.points()..2 * crowd.points();
        assert!(particles[still.clone()] == before.particles[still], "an instance without substeps has not moved");
    }
}

#[test]
fn pipelines_differ_where_one_lacks_what_is_asked_and_nowhere_else() {
    let table = kernel(KernelId::MuscleProject);
    let lacks = |variant: usize, name| table.switches.iter().position(|s| *s == name).map(|k| variant >> k & 1 == 1);
    for (kind, contacts) in kinds() {
        for outer in [0, 1] {
            let options = DynamicsOptions { contacts, ..DynamicsOptions::default() };
            let (crowd, params) = ready(&Crowd::new(20, 2, None, 76), &options, outer);
            let Some((particles, iterates)) = played(&crowd, &params) else { return };
            for variant in 1..table.variants() {
                let Some((others, others_iterates)) = played_by(variant, &crowd, &params) else { return };
                let asked = outer == 1 && lacks(variant, "ENDS").expect("a switch")
                    || contacts.muscles && lacks(variant, "HOLD_PEERS").expect("a switch")
                    || contacts.bones && lacks(variant, "TOUCH_GRIDS").expect("a switch");
                let same = particles == others && iterates == others_iterates;
                assert_eq!(same, !asked, "{kind}, outer {outer}, pipeline {variant}");
            }
        }
    }
}

#[test]
fn another_bone_and_another_neighbour_are_found() {
    let (mut crowd, params) = ready(&Crowd::new(9, 1, Some(30), 73), &DynamicsOptions::default(), 1);
    let Some((particles, _)) = played(&crowd, &params) else { return };
    let mut other = crowd.clone();
    other.bones[0].start.w += 1e-4;
    other.project(&params);
    let far = |crowd: &Crowd| distances(crowd, &params, &particles).iter().filter(|o| **o > PROJECTED.absolute).count();
    assert!(far(&other) > 3, "{} particles against a capsule a tenth of a millimetre wider", far(&other));
    let mut other = crowd.clone();
    other.links.iter_mut().for_each(|l| l.origin_depth += 0.02);
    other.project(&params);
    assert!(far(&other) > 0, "attachments two centimetres higher");
    crowd.project(&params);
    assert_eq!(far(&crowd), 0);
}

#[test]
fn the_same_step_twice_is_the_same_to_the_bit() {
    let (crowd, params) = ready(&Crowd::new(20, 2, None, 74), &DynamicsOptions::default(), 1);
    let Some((first, _)) = played(&crowd, &params) else { return };
    let Some((second, _)) = played(&crowd, &params) else { return };
    let bits = |p: &[Particle]| bytemuck::cast_slice::<Particle, u32>(p).to_vec();
    assert_eq!(bits(&first), bits(&second));
    let once = |mut crowd: Crowd| {
        crowd.project(&params);
        bits(&crowd.particles)
    };
    assert_eq!(once(crowd.clone()), once(crowd.clone()));
    let mut other = crowd.clone();
    other.particles[5].velocity.w *= 1.001;
    assert_ne!(once(crowd), once(other));
}

/// What no muscle should look like.
fn broken() -> Vec<(&'static str, Crowd)> {
    let sound = Crowd::new(8, 1, None, 75);
    let changed = |change: &dyn Fn(usize, &mut Particle)| {
        let mut crowd = sound.clone();
        crowd.particles.iter_mut().enumerate().for_each(|(i, p)| change(i, p));
        crowd
    };
    let mut short = changed(&|_, p| p.position = Vec3::ONE.extend(0.0));
    short.muscles.iter_mut().for_each(|m| m.insertion = m.origin.xyz().extend(m.insertion.w));
    short.muscles.iter_mut().for_each(|m| m.insertion_joint = m.origin_joint);
    let mut long = sound.clone();
    long.muscles.iter_mut().for_each(|m| m.insertion += Vec4::new(10.0, 0.0, 0.0, 0.0));
    let mut flat = sound.clone();
    flat.moved.iter_mut().for_each(|m| m.scale = 0.0);
    let mut thin = sound.clone();
    thin.muscles.iter_mut().for_each(|m| m.origin.w = 0.0);
    vec![
        ("coincident particles", changed(&|_, p| p.position = Vec3::ONE.extend(0.0))),
        (
            "two coincident particles",
            changed(&|i, p| {
                if i % 2 == 1 {
                    p.position = Vec3::ZERO.extend(0.0)
                }
            }),
        ),
        ("no length", short),
        ("ends 10 m apart", long),
        ("particles 10 m away", changed(&|i, p| p.position.x += if i % 3 == 1 { 10.0 } else { 0.0 })),
        ("100 m/s", changed(&|i, p| p.velocity.y = if i % 2 == 1 { 100.0 } else { -100.0 })),
        ("no scale", flat),
        ("no volume", thin),
    ]
}

/// Substeps a second: as usual, one of a second, and as short as a number says.
const RATES: [u32; 3] = [240, 1, u32::MAX];

#[test]
fn nothing_that_is_not_finite_leaves() {
    let sound = ("sound", Crowd::new(8, 1, None, 75));
    for ((name, start), rate) in broken().into_iter().chain([sound]).flat_map(|b| RATES.map(|rate| (b.clone(), rate))) {
        for (solver, options) in options() {
            let options = DynamicsOptions { rate, ..options };
            let mut ours = start.clone();
            let mut theirs = start.clone();
            for turn in 0..3 {
                ours.predict(&ours.params(&options, 0));
                theirs.predict(&theirs.params(&options, 0));
                for outer in [0, 1] {
                    let params = ours.params(&options, outer);
                    ours.project(&params);
                    let Some((particles, iterates)) = played(&theirs, &params) else { return };
                    (theirs.particles, theirs.iterates) = (particles, iterates);
                    for (side, crowd) in [("CPU", &ours), ("GPU", &theirs)] {
                        let sound = |p: &Particle| {
                            let all = [p.position, p.velocity, p.spring, p.pushes];
                            all.iter().all(|v| v.is_finite()) && p.position.length() < 1e3
                        };
                        let bad = crowd.particles.iter().position(|p| !sound(p));
                        let bad = bad.map(|i| crowd.particles[i]);
                        assert!(
                            bad.is_none(),
                            "{name}, {rate} Hz, {solver}, {side}, turn {turn}, outer {outer}: {bad:?}"
                        );
                    }
                }
            }
        }
    }
}
