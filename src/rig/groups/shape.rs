//! The bone of a field group: its axis, its neighbours' joints, and what of the skin shapes the field.

use super::{BodyPart, FieldGroups};
use crate::field::hrbf::HermiteSample;
use crate::field::poisson::{PatchTriangle, SurfaceSample};
use crate::rig::Character;
use glam::DVec3;

/// Share of the bone next to a joint whose samples are dropped: caps close the surface there (background 1.3).
const JOINT_DROP: f64 = 0.2;
/// The junction radius is this quantile of the patch's distances from the bone: low, but deaf to single vertices.
const JUNCTION_QUANTILE: f64 = 0.1;
/// A joint moves a group's vertices in earnest where it is the strongest in this share of them.
const EARNEST_SHARE: f64 = 0.01;
/// Directions in which a closing ball may have a cap.
const BALL_CAPS: u32 = 32;
/// A direction is covered where a sample lies within this angle of it, radians.
const BALL_COVER: f64 = 0.5;
/// A sample near the shoulder lies in the armpit where the cosine between its direction from the bone and the way to
/// the parent's bone exceeds this.
const FOLD_SIDE: f64 = 0.3;

/// Where a group meets a child.
#[derive(Clone, Copy, Debug)]
struct Junction {
    /// Centre of the joint, metres.
    joint: DVec3,
    /// Unit vector out of the group.
    outward: DVec3,
    /// How far beyond the joint the closing cap lies, metres.
    radius: f64,
}

/// A group's bone and patch at rest.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    /// The joint that the bone starts with.
    pub joint: u32,
    /// Where the bone starts, metres.
    pub start: DVec3,
    /// Unit vector along the bone.
    pub axis: DVec3,
    /// Length of the bone, metres; above zero.
    pub length: f64,
    /// Vertices the group owns.
    pub vertices: Vec<u32>,
    /// Triangles between them.
    pub patch: Vec<PatchTriangle>,
    /// Median distance of the vertices from the bone, metres.
    pub median_radius: f64,
    /// Distance of the closing caps from the joints, metres.
    junction_radius: f64,
    /// Whether samples next to the start, and next to the end, are dropped.
    drops: [bool; 2],
    /// The stretch of the bone that skin lies around: short of the tips where the skin closes itself, metres.
    core: [f64; 2],
    /// How the surface is closed where the bone starts.
    closing: Closing,
    children: Vec<Junction>,
}

/// How a group's surface is closed where its bone starts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Closing {
    /// Nothing hangs above: the skin itself ends there.
    None,
    /// One cap on the bone's line.
    Cap,
    /// A ball around the joint wherever no skin covers it. The upper arm keeps its skin up to the shoulder's top and
    /// drops only the armpit's; towards the chest it has none, and a single cap lets its field swell into the torso.
    Ball {
        /// Unit vector from the joint to the nearest point of the parent's bone.
        inward: DVec3,
    },
}

impl Shape {
    /// Shapes of all groups.
    pub fn of_groups(character: &Character, groups: &FieldGroups) -> Vec<Shape> {
        let count = groups.groups.len() as u32;
        let mut shapes: Vec<Shape> = (0..count).map(|g| Shape::of(character, groups, g)).collect();
        for g in 0..count {
            let ends: Vec<Junction> = groups
                .children(g)
                .map(|c| {
                    let child = &shapes[c as usize];
                    let leaf = groups.children(c).next().is_none();
                    let own = &shapes[g as usize];
                    // Where the bone ends in this joint, the cap continues the bone.
                    let continues = child.start.distance(own.start + own.axis * own.length) < 0.25 * own.length;
                    Junction {
                        joint: child.start,
                        outward: if continues { own.axis } else { child.axis },
                        radius: if leaf { own.junction_radius } else { child.junction_radius },
                    }
                })
                .collect();
            shapes[g as usize].children = ends;
            let parent = groups.groups[g as usize].parent.map(|p| &shapes[p as usize]);
            if let (Closing::Ball { .. }, Some(parent)) = (shapes[g as usize].closing, parent) {
                let out = from_segment(parent.start, parent.axis, parent.length, shapes[g as usize].start);
                let inward = (-out).normalize_or(-shapes[g as usize].axis);
                shapes[g as usize].closing = Closing::Ball { inward };
            }
        }
        shapes
    }

    fn of(character: &Character, groups: &FieldGroups, g: u32) -> Shape {
        let group = &groups.groups[g as usize];
        let vertices: Vec<u32> = (0..groups.owner.len() as u32).filter(|&v| groups.owner[v as usize] == g).collect();
        let points: Vec<DVec3> = vertices.iter().map(|&v| character.positions_rest[v as usize].as_dvec3()).collect();
        let joint = first_joint(character, groups, g);
        let start = joint_position(character, joint);
        let children: Vec<u32> = groups.children(g).collect();
        let towards =
            main_child(groups, g, &children).map(|c| joint_position(character, first_joint(character, groups, c)));
        let centroid = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let height = f64::from(character.height_rest());
        let (axis, length) = match towards.map(|t| t - start).filter(|d| d.length() > 0.01 * height) {
            Some(d) => (d.normalize(), d.length()),
            None => {
                let axis = (centroid - start).try_normalize().unwrap_or(DVec3::Y);
                let reach = points.iter().map(|p| (p - start).dot(axis)).fold(0.0, f64::max);
                (axis, reach.max(1e-3 * height))
            }
        };
        let mut distances: Vec<f64> = points.iter().map(|&p| from_segment(start, axis, length, p).length()).collect();
        distances.sort_by(f64::total_cmp);
        let quantile = |q: f64| distances.get((distances.len() as f64 * q) as usize).copied().unwrap_or(0.0);
        let least = 1e-4 * height;
        let junction_radius = quantile(JUNCTION_QUANTILE).max(least);
        let first = points.iter().map(|p| (p - start).dot(axis)).fold(f64::INFINITY, f64::min);
        let low = if group.parent.is_none() { (first + junction_radius).min(length) } else { 0.0 };
        let high = if children.is_empty() { length - junction_radius } else { length };
        let single = children.len() == 1;
        let arm = group.part == Some(BodyPart::UpperArm);
        Shape {
            joint,
            start,
            axis,
            length,
            patch: patch(character, groups, g),
            vertices,
            median_radius: quantile(0.5).max(least),
            junction_radius,
            core: if low < high { [low, high] } else { [0.5 * (low + high); 2] },
            // The deltoid sits where the upper arm starts: dropping it flattens the shoulder.
            drops: [group.parent.is_some() && children.len() < 2 && !arm, single],
            closing: match (group.parent.is_some(), arm) {
                (false, _) => Closing::None,
                (true, false) => Closing::Cap,
                (true, true) => Closing::Ball { inward: -axis },
            },
            children: Vec::new(),
        }
    }

    /// Whether a sample lies away from the joints: `drop` 1 for the usual share of the bone, 0 for all of it.
    pub fn is_clear(&self, position: DVec3, drop: f64) -> bool {
        let along = (position - self.start).dot(self.axis);
        let share = JOINT_DROP * drop * self.length;
        let in_fold = match self.closing {
            Closing::Ball { inward } => {
                let out = from_segment(self.start, self.axis, self.length, position).normalize_or_zero();
                along < share && out.dot(inward) > FOLD_SIDE
            }
            _ => false,
        };
        let near_start = self.drops[0] && along < share;
        let near_end = self.drops[1] && along > self.length - share;
        !(in_fold || near_start || near_end)
    }

    /// Whether a sample's normal faces away from the bone; a fold's does not.
    pub fn faces_out(&self, sample: &SurfaceSample) -> bool {
        let [low, high] = self.core;
        from_segment(self.start + self.axis * low, self.axis, high - low, sample.position).dot(sample.normal) >= 0.0
    }

    /// Points beyond the joints that close the surface through `samples`.
    pub fn caps(&self, samples: &[HermiteSample]) -> Vec<HermiteSample> {
        let cap = |from: DVec3, outward: DVec3, radius: f64| HermiteSample {
            position: from + outward * radius,
            normal: outward,
        };
        let mut caps = match self.closing {
            Closing::None => Vec::new(),
            Closing::Cap => vec![cap(self.start, -self.axis, self.junction_radius)],
            Closing::Ball { .. } => {
                let covers = |u: DVec3| samples.iter().any(|s| (s.position - self.start).angle_between(u) < BALL_COVER);
                directions().filter(|&u| !covers(u)).map(|u| cap(self.start, u, self.median_radius)).collect()
            }
        };
        caps.extend(self.children.iter().map(|c| cap(c.joint, c.outward, c.radius)));
        caps
    }
}

/// Unit vectors spread evenly over the sphere by the golden angle.
fn directions() -> impl Iterator<Item = DVec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..BALL_CAPS).map(move |k| {
        let y = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(BALL_CAPS);
        let (sin, cos) = (golden * f64::from(k)).sin_cos();
        let ring = (1.0 - y * y).sqrt();
        DVec3::new(cos * ring, y, sin * ring)
    })
}

/// Vector from the nearest point of the segment to `p`.
fn from_segment(start: DVec3, axis: DVec3, length: f64, p: DVec3) -> DVec3 {
    let along = (p - start).dot(axis).clamp(0.0, length);
    p - (start + axis * along)
}

fn joint_position(character: &Character, joint: u32) -> DVec3 {
    character.joints[joint as usize].bind().w_axis.truncate().as_dvec3()
}

/// The uppermost joint that moves the group's vertices in earnest.
fn first_joint(character: &Character, groups: &FieldGroups, g: u32) -> u32 {
    let group = &groups.groups[g as usize];
    let mut votes = vec![0_usize; character.joints.len()];
    let mut total = 0;
    for v in (0..groups.owner.len()).filter(|&v| groups.owner[v] == g) {
        for influence in character.influences_of(v).iter().filter(|i| i.weight >= 0.5) {
            votes[influence.joint as usize] += 1;
        }
        total += 1;
    }
    let earnest = |j: &u32| votes[*j as usize] as f64 > EARNEST_SHARE * f64::from(total);
    group.joints.iter().copied().find(earnest).unwrap_or(group.joint)
}

/// The child that the bone points at: the next part of the trunk or limb, else the only or farthest one.
fn main_child(groups: &FieldGroups, g: u32, children: &[u32]) -> Option<u32> {
    let part = |c: u32| groups.groups[c as usize].part;
    let next: &[BodyPart] = match part(g) {
        Some(BodyPart::Trunk) => &[BodyPart::Neck, BodyPart::Head],
        Some(BodyPart::Neck) => &[BodyPart::Head],
        Some(BodyPart::UpperArm) => &[BodyPart::Forearm, BodyPart::Hand],
        Some(BodyPart::Forearm) => &[BodyPart::Hand],
        Some(BodyPart::Thigh) => &[BodyPart::Calf, BodyPart::Foot],
        Some(BodyPart::Calf) => &[BodyPart::Foot],
        Some(_) => return None,
        None => &[],
    };
    let named = next.iter().find_map(|&p| children.iter().copied().find(|&c| part(c) == Some(p)));
    named.or(if children.len() == 1 { Some(children[0]) } else { None })
}

/// Triangles whose three vertices the group owns.
fn patch(character: &Character, groups: &FieldGroups, g: u32) -> Vec<PatchTriangle> {
    character
        .triangles
        .iter()
        .filter(|t| t.iter().all(|&v| groups.owner[v as usize] == g))
        .map(|t| PatchTriangle {
            positions: t.map(|v| character.positions_rest[v as usize].as_dvec3()),
            normals: t.map(|v| character.normals_rest[v as usize].as_dvec3()),
        })
        .collect()
}
