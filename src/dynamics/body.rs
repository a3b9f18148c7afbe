//! What of muscles and bones does not change while they move: masses, rest lengths, who can touch whom.

use super::{Particle, contact::nearest_on_segment, kinds, predict::compliance};
use crate::{
    field::{
        GroupGrid, grid,
        muscle::{
            AxisPoint, MuscleRest, Profile,
            wrap::{Course, MuscleWrap, REST_SHARE, Spacing, TENDON_STIFFNESS},
        },
    },
    math::{product, transform_point},
    rig::{BoneCollider, ColliderShape, JointFrame, MuscleSpec, Rig, SettledPoint, groups::BodyPart},
};
use glam::{Vec3, Vec4, Vec4Swizzles};

/// No group, bone or muscle.
pub const NO_INDEX: u32 = u32::MAX;
/// Density of muscle, kg/m^3 (paper A, section 6.2).
const DENSITY: f32 = 1060.0;
/// Least mass of a particle, in that of the thickest one: lighter ones make the tendons ill balanced (prototypes 1).
const MASS_FLOOR: f32 = 0.3;
/// Most bones and groups that one muscle can touch.
const MOST_LINKS: usize = 8;
/// Swings per substep at which a muscle's looseness is taken: 12 Hz at 240 substeps a second.
const NOMINAL_CYCLES: f32 = 0.05;

crate::gpu_struct! {
    /// A muscle as the dynamics hold it.
    pub struct MuscleBody {
        /// Origin in scene space at rest, metres, and in `w` the volume, cubic metres.
        pub origin: Vec4,
        /// Insertion in scene space at rest, metres, and in `w` the mass, kg.
        pub insertion: Vec4,
        /// First of the muscle's points among its instance's.
        pub first_point: u32,
        /// Segments of the axis.
        pub segments: u32,
        /// Joint that carries the origin.
        pub origin_joint: u32,
        /// Joint that carries the insertion.
        pub insertion_joint: u32,
        /// Joint that drives the field group which the muscle joins.
        pub driver: u32,
        /// What it collides with: bit 0 bones, bit 1 muscles, bit 2 skin.
        pub collides: u32,
        /// First link to a bone.
        pub bones_begin: u32,
        /// Past the last link to a bone, and first link to a muscle.
        pub peers_begin: u32,
        /// Past the last link to a muscle, and first link to a field group whose skin may hold it.
        pub skins_begin: u32,
        /// Past the last link to a field group.
        pub links_end: u32,
        /// Frequency of the sideways swing, hertz; 0 where the stiffness says.
        pub frequency: f32,
        /// Mobility 1/kg of a uniform chain of as many segments whose Jacobi sweeps converge as slowly as this one's do.
        pub looseness: f32,
        /// How much of the bones' acceleration along the axis shifts the profile, 0..=1.
        pub jiggle: f32,
        /// What it lies round among the character's wraps, counted from 1; 0 where it runs straight.
        pub wrap: u32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
    }
}

crate::gpu_struct! {
    /// A bone's shape in scene space at rest.
    pub struct BoneRest {
        /// Distance field of a mesh, metres; without nodes for a capsule.
        pub grid: GroupGrid,
        /// Centre of one end of a capsule, and in `w` its radius, metres.
        pub start: Vec4,
        /// Centre of the other end; `w` unused.
        pub end: Vec4,
        /// Joint that moves it.
        pub joint: u32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
        /// Unused.
        pub pad_2: u32,
    }
}

crate::gpu_struct! {
    /// Something that one muscle can touch.
    pub struct Link {
        /// The bone, muscle or field group.
        pub index: u32,
        /// Distance of the muscle's origin from the bone at rest, metres, at most 0: how deep the bone holds it.
        pub origin_depth: f32,
        /// Distance of the insertion from it, metres, at most 0.
        pub insertion_depth: f32,
        /// The joint that moves a field group where the muscle is.
        pub joint: u32,
    }
}

/// All bodies of a character; immutable, shared by all its instances on either side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bodies {
    /// One per muscle.
    pub muscles: Vec<MuscleBody>,
    /// What muscles lie round.
    pub wraps: Vec<MuscleWrap>,
    /// Bones that muscles collide with.
    pub bones: Vec<BoneRest>,
    /// Who can touch whom, muscle by muscle: bones, muscles, field groups.
    pub links: Vec<Link>,
    /// Particles in the rest pose, all muscles' one after the other.
    pub particles_rest: Vec<Particle>,
    /// Their axes in the rest pose.
    pub axes_rest: Vec<AxisPoint>,
}

impl Bodies {
    /// The bodies of a rig's muscles, on their axes in the rest pose, or where they have settled.
    pub fn new(rig: &Rig) -> Bodies {
        let bones = rig.bones.iter().map(|bone| bone_rest(rig, bone)).collect();
        let mut bodies = Bodies { bones, wraps: rig.wraps.clone(), ..Bodies::default() };
        let (_, axes) = rig.muscles_at_rest();
        for (index, rest) in rig.muscles.iter().enumerate() {
            let spec = &rig.specs[rig.spec_of[index] as usize];
            let mut particles = particles(rest, spec, &axes[rest.first_point as usize..]);
            for (particle, settled) in particles.iter_mut().zip(rig.settled().iter().skip(rest.first_point as usize)) {
                put(particle, settled);
            }
            let bones_begin = bodies.links.len() as u32;
            let bones = bone_links(rig, index, &bodies.bones);
            bodies.links.extend(bones);
            let peers_begin = bodies.links.len() as u32;
            bodies.links.extend(peers(rig, index).map(link));
            let skins_begin = bodies.links.len() as u32;
            let skin = |group| Link { joint: skin_joint(rig, rest, group), ..link(group) };
            bodies.links.extend(skins(rig, index).map(skin));
            bodies.muscles.push(MuscleBody {
                driver: rest.joint,
                bones_begin,
                peers_begin,
                skins_begin,
                links_end: bodies.links.len() as u32,
                ..muscle_body(rest, spec, &particles)
            });
            bodies.particles_rest.extend(particles);
        }
        bodies.axes_rest = axes;
        bodies
    }

    /// Particles at rest, carried into a pose by the joints at their ends, and round what their muscles lie round.
    pub fn particles(&self, joints: &[JointFrame]) -> Vec<Particle> {
        let mut particles = self.particles_rest.clone();
        for muscle in &self.muscles {
            let own = &mut particles[muscle.first_point as usize..][..=muscle.segments as usize];
            let from = &joints[muscle.origin_joint as usize].matrix;
            let to = &joints[muscle.insertion_joint as usize].matrix;
            let courses = muscle.wrap(&self.wraps).map(|wrap| {
                let around = product(&joints[wrap.joint as usize].matrix, &wrap.to_rest);
                let (origin, insertion) = (muscle.origin.xyz(), muscle.insertion.xyz());
                let posed = (transform_point(from, origin), transform_point(to, insertion));
                let at_rest = Course::new(wrap, &wrap.to_rest, origin, insertion, Spacing::Tension);
                (at_rest, Course::new(wrap, &around, posed.0, posed.1, Spacing::Tension))
            });
            for (i, particle) in own.iter_mut().enumerate() {
                let share = i as f32 / muscle.segments as f32;
                let carried = |p: Vec3| transform_point(from, p) * (1.0 - share) + transform_point(to, p) * share;
                let mut posed = carried(particle.position.xyz());
                if let Some((at_rest, now)) = &courses {
                    posed += now.point(i as u32) - carried(at_rest.point(i as u32));
                }
                particle.position = posed.extend(0.0);
            }
        }
        particles
    }
}

impl MuscleBody {
    /// What it lies round, of a character's wraps.
    pub fn wrap<'a>(&self, wraps: &'a [MuscleWrap]) -> Option<&'a MuscleWrap> {
        wraps.get((self.wrap as usize).checked_sub(1)?)
    }
}

/// A muscle without driver and links.
pub(super) fn muscle_body(rest: &MuscleRest, spec: &MuscleSpec, particles: &[Particle]) -> MuscleBody {
    let mass = DENSITY * rest.origin.w;
    MuscleBody {
        origin: rest.origin,
        insertion: rest.insertion.xyz().extend(mass),
        first_point: rest.first_point,
        segments: rest.segments,
        origin_joint: rest.origin_joint,
        insertion_joint: rest.insertion_joint,
        collides: kinds(spec.collides.bones, spec.collides.muscles, spec.collides.skin),
        frequency: spec.frequency.unwrap_or(0.0),
        jiggle: spec.jiggle,
        wrap: rest.wrap,
        looseness: looseness(mass, particles),
        ..MuscleBody::default()
    }
}

/// The joint that moves a group's skin around a muscle: a trunk moves with the joints that the muscle hangs on.
fn skin_joint(rig: &Rig, rest: &MuscleRest, group: u32) -> u32 {
    let driver = rig.grids[group as usize].joint;
    if rig.groups.groups[group as usize].part != Some(BodyPart::Trunk) {
        return driver;
    }
    let near = [rest.joint, rest.origin_joint, rest.insertion_joint];
    near.into_iter().find(|&j| rig.groups.group_of_joint[j as usize] == group).unwrap_or(driver)
}

fn link(index: u32) -> Link {
    Link { index, ..Link::default() }
}

/// Puts a particle where it has settled, with the planes that hold it there: two muscles that touch have many places of
/// rest, of which these planes choose one.
fn put(particle: &mut Particle, settled: &SettledPoint) {
    particle.position = settled.position.extend(0.0);
    [particle.peer_0, particle.peer_1] = settled.planes;
    [particle.traits.z, particle.traits.w] = settled.muscles.map(|muscle| muscle as f32);
}

/// One muscle's particles: masses by the profile at rest, rest lengths, tendons.
pub(super) fn particles(rest: &MuscleRest, spec: &MuscleSpec, axis: &[AxisPoint]) -> Vec<Particle> {
    let n = rest.segments as usize;
    let profile = Profile::of(spec.rest.alpha, spec.rest.beta);
    let floor = MASS_FLOOR * profile.max();
    let width = |i: usize| profile.at(i as f32 / n as f32).0.max(floor);
    let sum: f32 = (1..n).map(width).sum();
    let mass = DENSITY * rest.origin.w;
    let segment = rest.origin_normal.w / n as f32;
    (0..=n)
        .map(|i| {
            let middle = (i as f32 + 0.5) / n as f32;
            let is_tendon = middle < spec.tendon || middle > 1.0 - spec.tendon;
            let (rest_length, stiffer) = if is_tendon { (1.0, TENDON_STIFFNESS) } else { (REST_SHARE, 1.0) };
            let mobility = if i == 0 || i == n { 0.0 } else { sum / (mass * width(i)) };
            let share = i as f32 / n as f32;
            let from_end = share.min(1.0 - share);
            let clear = if spec.tendon > 0.0 { (from_end / spec.tendon).min(1.0) } else { 1.0 };
            Particle {
                position: axis[i].position.xyz().extend(0.0),
                velocity: Vec3::ZERO.extend(mobility),
                spring: Vec3::ZERO.extend(if i < n { rest_length * segment } else { 0.0 }),
                traits: Vec4::new(clear, stiffer, 0.0, 0.0),
                ..Particle::default()
            }
        })
        .collect()
}

/// `w` with which `2 w / (2 w + a) cos(pi / n)`, the spectral radius of Jacobi's sweeps over a uniform chain of `n`
/// segments, is that over this chain at 12 Hz and 240 substeps a second, whose compliance is `a` (by power iteration).
fn looseness(mass: f32, particles: &[Particle]) -> f32 {
    let n = particles.len() - 1;
    let compliance = f64::from(compliance(mass, n as f32, NOMINAL_CYCLES));
    let mobility: Vec<f64> = particles.iter().map(|p| f64::from(p.velocity.w)).collect();
    let diagonal: Vec<f64> =
        (0..n).map(|j| mobility[j] + mobility[j + 1] + compliance / f64::from(particles[j].traits.y)).collect();
    let mut x: Vec<f64> = (0..n).map(|j| 1.0 + 0.1 * (j % 3) as f64).collect();
    let mut radius = 0.0;
    for _ in 0..200 {
        let at = |x: &[f64], j: usize| x[j] / diagonal[j];
        // The matrix is similar to a symmetric one of non-negative entries; two sweeps at once, since its spectrum is
        // symmetric about 0.
        let sweep = |x: &[f64]| -> Vec<f64> {
            (0..n)
                .map(|j| {
                    let below = if j > 0 { mobility[j] * at(x, j - 1) } else { 0.0 };
                    let above = if j + 1 < n { mobility[j + 1] * at(x, j + 1) } else { 0.0 };
                    below + above
                })
                .collect()
        };
        let next = sweep(&sweep(&x));
        let largest = next.iter().copied().fold(0.0, f64::max);
        radius = (largest / x.iter().copied().fold(0.0, f64::max)).sqrt();
        x = next.iter().map(|v| v / largest.max(f64::MIN_POSITIVE)).collect();
    }
    let uniform = (radius / (std::f64::consts::PI / n as f64).cos().max(0.1)).min(0.9999);
    (0.5 * compliance * uniform / (1.0 - uniform)) as f32
}

/// A collider in scene space at rest.
fn bone_rest(rig: &Rig, bone: &BoneCollider) -> BoneRest {
    let bind = rig.character.joints[bone.joint as usize].bind();
    match &bone.shape {
        ColliderShape::Capsule { from, to, radius } => {
            let scale = bind.determinant().abs().cbrt();
            BoneRest {
                start: transform_point(&bind, *from).extend(radius * scale),
                end: transform_point(&bind, *to).extend(0.0),
                joint: bone.joint,
                ..BoneRest::default()
            }
        }
        ColliderShape::Mesh { .. } => BoneRest { grid: bone.grid, joint: bone.joint, ..BoneRest::default() },
    }
}

/// The bones that a muscle can touch: those of the joints at its ends, between them, and of its field group; the nearest
/// first.
fn bone_links(rig: &Rig, index: usize, bones: &[BoneRest]) -> Vec<Link> {
    let rest = &rig.muscles[index];
    let ancestors = |joint: u32| {
        let parent = |j: &u32| rig.character.joints[*j as usize].parent;
        std::iter::successors(Some(joint), parent).collect::<Vec<u32>>()
    };
    let (from, to) = (ancestors(rest.origin_joint), ancestors(rest.insertion_joint));
    let common = from.iter().find(|j| to.contains(j)).copied();
    let path = |up: &[u32]| up.iter().copied().take_while(|j| Some(*j) != common).collect::<Vec<u32>>();
    let mut joints = [path(&from), path(&to), common.into_iter().collect()].concat();
    joints.extend(&rig.groups.groups[rest.group as usize].joints);
    let middle = (rest.origin.xyz() + rest.insertion.xyz()) * 0.5;
    let mut links: Vec<(f32, Link)> = bones
        .iter()
        .enumerate()
        .filter(|(_, bone)| joints.contains(&bone.joint))
        .map(|(i, bone)| {
            let depth = |p: Vec4| bone_distance(bone, &rig.nodes, p.xyz()).min(0.0);
            let link = Link {
                index: i as u32,
                origin_depth: depth(rest.origin),
                insertion_depth: depth(rest.insertion),
                joint: bone.joint,
            };
            (bone_distance(bone, &rig.nodes, middle), link)
        })
        .collect();
    links.sort_by(|a, b| a.0.total_cmp(&b.0));
    links.into_iter().take(MOST_LINKS).map(|(_, link)| link).collect()
}

/// Distance of a point from a bone, both in scene space at rest, metres; infinite beyond a mesh's grid.
pub(crate) fn bone_distance(bone: &BoneRest, nodes: &[Vec4], p: Vec3) -> f32 {
    if bone.grid.size_x > 0 {
        return grid::sample(&bone.grid, nodes, p).map_or(f32::INFINITY, |(d, _)| d);
    }
    nearest_on_segment(bone.start.xyz(), bone.end.xyz(), p).distance(p) - bone.start.w
}

/// The muscles that a muscle collides with: those of its collision group, and the other fibres of its set where these may
/// not overlap.
fn peers(rig: &Rig, index: usize) -> impl Iterator<Item = u32> {
    let own = rig.spec_of[index] as usize;
    let together = move |other: usize| {
        let (a, b) = (&rig.specs[own], &rig.specs[other]);
        if other == own {
            a.fibres.as_ref().is_some_and(|f| !f.overlap)
        } else {
            !a.collision_group.is_empty() && a.collision_group == b.collision_group
        }
    };
    let others = rig.spec_of.iter().enumerate().filter(move |&(i, _)| i != index);
    others.filter(move |(_, other)| together(**other as usize)).map(|(i, _)| i as u32)
}

/// The field groups whose skin may hold a muscle: its own, those of its ends, and those between.
fn skins(rig: &Rig, index: usize) -> impl Iterator<Item = u32> {
    let rest = &rig.muscles[index];
    let group = |joint: u32| rig.groups.group_of_joint[joint as usize];
    let mut found = vec![rest.group];
    for end in [rest.origin_joint, rest.insertion_joint] {
        let mut joint = Some(end);
        while let Some(j) = joint {
            let g = group(j);
            if g != NO_INDEX && !found.contains(&g) {
                found.push(g);
            }
            // The nearest joint up the chain that has a field, and one group beyond it.
            joint = if found.len() > 3 { None } else { rig.character.joints[j as usize].parent };
        }
    }
    found.truncate(MOST_LINKS);
    found.into_iter()
}
