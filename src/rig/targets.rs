//! Where the tracker takes every vertex, and through which frames the vertex sees the field groups around it.

use super::{FrameInputs, Influence, Pose, Rig, groups::BodyPart};
use crate::field::{
    Sample,
    compose::{JointOperatorParams, joint},
    evaluate::{APART, CONTACT_GAP, FieldInput, NO_GROUP, Place, Side},
};
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

crate::gpu_struct! {
    /// Where the tracker takes a vertex.
    pub struct VertexTarget {
        /// Direction of the composed field's gradient at rest, and in `w` how far from linear skinning the vertex may be before it
        /// counts as lost, metres.
        pub normal_rest: Vec4,
        /// Field value at rest: muscles set into their groups, groups joined.
        pub iso: f32,
        /// Field of a group above which the vertex is in contact with it, unless a reach says otherwise: the iso-value less
        /// a gap.
        pub limit: f32,
        /// A [`Role`] as a number.
        pub role: u32,
        /// The group with the largest field at rest, whose side the vertex stays on.
        pub owner: u32,
        /// The vertex that this one is a copy of; itself where it is the first.
        pub copy_of: u32,
        /// Where its reaches begin.
        pub reach_begin: u32,
        /// One past its last reach.
        pub reach_end: u32,
        /// Where its edges begin.
        pub edge_begin: u32,
        /// One past its last edge.
        pub edge_end: u32,
        /// 1 where it may slide along the field: not on open boundaries, nor alone.
        pub slides: u32,
        /// What the join of groups adds to the owner's field at rest.
        pub lift: f32,
        /// 1 where its rotation is asked for: by itself or by a neighbour that slides.
        pub turns: u32,
    }
}

impl VertexTarget {
    /// Which side of the field it is on.
    #[inline]
    pub fn side(&self) -> Side {
        Side { owner: self.owner, limit: self.limit, lift: self.lift }
    }
}

/// What moves a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Role {
    /// Linear skinning: no field holds it, or it belongs to a head, hand or foot.
    Passive = 0,
    /// The tracker.
    Active = 1,
    /// The vertex that it is a copy of.
    Copy = 2,
}

crate::gpu_struct! {
    /// A field group that a vertex sees in a way of its own: because the two overlap at rest, or through a frame blended of
    /// joints' matrices and drawn towards another joint's beside hips and shoulders (prototypes 5).
    pub struct Reach {
        /// Where the vertex lies about the joint that gates the draw, a unit vector at rest; unused without a gate.
        pub side: Vec4,
        /// The group.
        pub group: u32,
        /// Field of the group above which the vertex is in contact with it.
        pub limit: f32,
        /// Where the blended joints begin.
        pub blend_begin: u32,
        /// One past the last of them.
        pub blend_end: u32,
        /// The joint that the frame is drawn to.
        pub other: u32,
        /// By how much, 0..=1.
        pub share: f32,
        /// The joint whose swing gates the draw, [`NO_JOINT`] where nothing does.
        pub gate: u32,
        /// What joins the group to the vertex's own where the two overlap at rest, [`APART`] elsewhere.
        pub join: u32,
    }
}

/// No joint.
pub const NO_JOINT: u32 = u32::MAX;

/// Field by which a rest overlap of two groups may grow before it counts as a contact.
const REST_MARGIN: f32 = 0.005;
/// Share of a vertex's weight that a trunk must have for the vertex to know its own place in it.
const KNOWN_SHARE: f32 = 0.3;
/// Points of a trunk's skin that tell vertices elsewhere how the trunk moves beside them.
const TRUNK_POINTS: usize = 512;
/// Joints of a trunk that a frame blends at most, and the weight below which they are left out.
const MOST_BLENDED: usize = 8;
const LEAST_BLENDED: f32 = 0.01;
/// How strongly trunk and thigh draw each other's frames beside a hip, and trunk and arm beside a shoulder.
const HIP_DRAW: f32 = 0.75;
const SHOULDER_DRAW: f32 = 1.0;

/// Where the skin goes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Targets {
    /// One per vertex.
    pub vertices: Vec<VertexTarget>,
    /// Those of the active vertices once more, in the order of the device's march ([`march_order`]).
    pub marched: Vec<VertexTarget>,
    /// Of all vertices; ascending by group within one.
    pub reaches: Vec<Reach>,
    /// Joints that reaches blend.
    pub blends: Vec<Influence>,
}

/// A reach with its blended joints.
type Seen = (Reach, Vec<Influence>);

impl Targets {
    /// Why no field of a rig holds vertex `v`; `None` where one does.
    pub fn unheld(rig: &Rig, v: usize) -> Option<Unheld> {
        let inputs = FrameInputs::new(rig, &Pose::rest(&rig.character)).ok()?;
        let (muscles, axes) = rig.muscles_at_rest();
        let field = FieldInput { groups: &inputs.groups, nodes: &rig.nodes, muscles: &muscles, axes: &axes };
        let (_, owner, sample) = at_rest(&field, rig.positions_rest[v].xyz());
        unheld(rig, v, owner, &sample)
    }

    /// Targets of a rig's skin in its rest pose, with its muscles at rest.
    pub(super) fn new(rig: &Rig) -> Targets {
        let count = rig.character.vertex_count();
        let vertex = |v: usize| VertexTarget {
            copy_of: rig.graph.copy_of[v],
            edge_begin: rig.graph.ranges[v][0],
            edge_end: rig.graph.ranges[v][1],
            owner: NO_GROUP,
            role: if rig.graph.copy_of[v] == v as u32 { Role::Passive } else { Role::Copy } as u32,
            ..VertexTarget::default()
        };
        let mut targets = Targets { vertices: (0..count).map(vertex).collect(), ..Targets::default() };
        let Ok(inputs) = FrameInputs::new(rig, &Pose::rest(&rig.character)) else { return targets };
        if rig.grids.is_empty() {
            return targets;
        }
        let (muscles, axes) = rig.muscles_at_rest();
        let field = FieldInput { groups: &inputs.groups, nodes: &rig.nodes, muscles: &muscles, axes: &axes };
        let trunk = Trunk::of(rig);
        let seen: Vec<Vec<Seen>> = targets
            .vertices
            .par_iter_mut()
            .enumerate()
            .map(
                |(v, target)| {
                    if target.role == Role::Copy as u32 { Vec::new() } else { aim(rig, &trunk, &field, v, target) }
                },
            )
            .collect();
        for (target, reaches) in targets.vertices.iter_mut().zip(seen) {
            target.reach_begin = targets.reaches.len() as u32;
            for (reach, blend) in reaches {
                let blend_begin = targets.blends.len() as u32;
                targets.blends.extend(blend);
                targets.reaches.push(Reach { blend_begin, blend_end: targets.blends.len() as u32, ..reach });
            }
            target.reach_end = targets.reaches.len() as u32;
        }
        targets.ask_for_turns(rig);
        targets.marched = march_order(&targets.vertices, &targets.reaches);
        targets
    }

    /// Marks the vertices whose rotations the relaxation reads.
    fn ask_for_turns(&mut self, rig: &Rig) {
        for v in 0..self.vertices.len() {
            let VertexTarget { role, slides, edge_begin, edge_end, .. } = self.vertices[v];
            if role == Role::Active as u32 && slides != 0 {
                self.vertices[v].turns = 1;
                for edge in &rig.graph.edges[edge_begin as usize..edge_end as usize] {
                    self.vertices[edge.neighbour as usize].turns = 1;
                }
            }
        }
    }
}

/// The active vertices' targets, those side by side that look at the same field groups: threads that run in step then take the
/// same way. A target's vertex is its `copy_of`, since active vertices are first copies.
pub fn march_order(vertices: &[VertexTarget], reaches: &[Reach]) -> Vec<VertexTarget> {
    let mut order: Vec<VertexTarget> = vertices.iter().filter(|t| t.role == Role::Active as u32).copied().collect();
    order.sort_by_cached_key(|target| {
        let seen = &reaches[target.reach_begin as usize..target.reach_end as usize];
        (target.owner, seen.iter().map(|reach| reach.group).collect::<Vec<u32>>())
    });
    order
}

/// Distance to linear skinning from which a vertex is lost, in support radii of its group: skin in closed elbows and knees lies up to
/// 30 mm from it.
const LOST_RADII: f32 = 0.9;

/// Fills in one vertex's target, and lists the groups that it sees in a way of its own.
fn aim(rig: &Rig, trunk: &Option<Trunk>, field: &FieldInput, v: usize, target: &mut VertexTarget) -> Vec<Seen> {
    let p = rig.positions_rest[v].xyz();
    let (samples, owner, sample) = at_rest(field, p);
    if unheld(rig, v, owner, &sample).is_some() {
        return Vec::new();
    }
    target.iso = sample.value;
    target.limit = sample.value - CONTACT_GAP;
    target.owner = owner;
    target.role = Role::Active as u32;
    target.normal_rest =
        sample.gradient.normalize_or_zero().extend(LOST_RADII * rig.grids[owner as usize].support_radius);
    target.slides = (!rig.graph.boundary[v] && target.edge_begin < target.edge_end).into();
    let drawn = trunk.as_ref().and_then(|trunk| trunk.drawn(rig, v));
    let mut seen = Vec::new();
    for (g, sample) in (0..).zip(&samples) {
        let limit = target.limit.max(sample.value + REST_MARGIN);
        let of_trunk = trunk.as_ref().is_some_and(|trunk| trunk.group == g);
        let mut reach = Reach {
            group: g,
            limit,
            other: NO_JOINT,
            gate: NO_JOINT,
            join: if sample.value > 0.0 { rig.join(owner, g) } else { APART },
            ..Reach::default()
        };
        if let Some(drawn) = drawn.as_ref().filter(|drawn| of_trunk || drawn.limb == g) {
            reach.share = drawn.share;
            reach.other = if of_trunk { rig.grids[drawn.limb as usize].joint } else { drawn.trunk_joint };
            (reach.gate, reach.side) = (drawn.gate, drawn.side.extend(0.0));
        }
        let blend = match trunk {
            Some(trunk) if of_trunk => trunk.weights(rig, v),
            _ => vec![Influence { joint: rig.grids[g as usize].joint, weight: 1.0 }],
        };
        // The own group by itself is seen as all others see it.
        if of_trunk || reach.other != NO_JOINT || (sample.value > 0.0 && g != owner) {
            seen.push((reach, blend));
        }
    }
    join(field, p, &samples, &seen, target);
    seen
}

/// Puts what joins a vertex's own group to the one that overlaps it most into its target.
fn join(field: &FieldInput, p: Vec3, samples: &[Sample], seen: &[Seen], target: &mut VertexTarget) {
    let others = seen.iter().map(|(reach, _)| reach).filter(|r| r.group != target.owner && r.join != APART);
    let value = |reach: &&Reach| samples[reach.group as usize].value;
    let most = others.max_by(|a, b| value(a).total_cmp(&value(b)));
    let Some(other) = most.filter(|other| other.join != 0) else { return };
    let own = samples[target.owner as usize];
    let operator = JointOperatorParams::of_code(other.join);
    target.iso = joint(own, samples[other.group as usize], &operator).value;
    target.lift = target.iso - own.value;
    // Near a contact the own side counts as well.
    let at_rest = |(reach, _): &Seen| Place {
        to_rest: Mat4::IDENTITY,
        group: reach.group,
        limit: reach.limit,
        join: reach.join,
        ..Place::default()
    };
    let places: Vec<Place> = seen.iter().map(at_rest).collect();
    let gradient = field.own_side(&target.side(), &places, p).sample.gradient;
    target.normal_rest = gradient.normalize_or_zero().extend(target.normal_rest.w);
}

/// The field of every group at a point, and the group with the largest.
fn at_rest(field: &FieldInput, p: Vec3) -> (Vec<Sample>, u32, Sample) {
    let samples: Vec<Sample> = field.groups.iter().map(|frame| field.group(frame, p)).collect();
    let strongest = |best: (u32, Sample), (g, s): (u32, &Sample)| if s.value > best.1.value { (g, *s) } else { best };
    let (owner, sample) = (0..).zip(&samples).fold((NO_GROUP, Sample::default()), strongest);
    (samples, owner, sample)
}

/// Why no field holds a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unheld {
    /// No field reaches it, or the rig has none.
    NoField,
    /// The field's value there is too near to 0 or 1 to be an iso-value.
    Value(f32),
    /// It is bound, by this weight, to groups that follow geometric skinning as a whole.
    Bound(f32),
    /// The field has hardly a slope there: this one, per support radius.
    Slope(f32),
    /// The field's outward direction and the skin's normal part: the cosine between them.
    Facing(f32),
}

/// Whether the field has a usable value and direction at a vertex, and the vertex is not bound to a group that
/// follows geometric skinning as a whole (prototypes 3); what is amiss first otherwise.
fn unheld(rig: &Rig, vertex: usize, owner: u32, sample: &Sample) -> Option<Unheld> {
    if owner == NO_GROUP {
        return Some(Unheld::NoField);
    }
    if !(0.03..=0.97).contains(&sample.value) {
        return Some(Unheld::Value(sample.value));
    }
    let passive = |group: &u32| rig.groups.groups.get(*group as usize).is_some_and(|g| g.passive);
    let bound: f32 = rig
        .character
        .influences_of(vertex)
        .iter()
        .filter(|i| rig.groups.group_of_joint.get(i.joint as usize).is_some_and(passive))
        .map(|i| i.weight)
        .sum();
    let free = bound <= 0.98;
    if !free {
        return Some(Unheld::Bound(bound));
    }
    let slope = sample.gradient.length();
    let per_radius = slope * rig.grids[owner as usize].support_radius;
    let facing = -sample.gradient.dot(rig.character.normals_rest[vertex]);
    // What is not a number holds nothing.
    let (steep, faces) = (per_radius >= 0.1, facing >= 0.3 * slope);
    match steep {
        true if faces => None,
        true => Some(Unheld::Facing(facing / slope)),
        false => Some(Unheld::Slope(per_radius)),
    }
}

/// A group of many joints whose frame differs from place to place.
struct Trunk {
    group: u32,
    /// Points of its skin and how its joints move them: weights in the order of the group's joints.
    points: Vec<(Vec3, Vec<f32>)>,
    limbs: Vec<Limb>,
}

/// A limb that hangs on a trunk.
struct Limb {
    group: u32,
    joint: u32,
    trunk_joint: u32,
    draw: f32,
    gated: bool,
    origin: Vec3,
    axis: Vec3,
}

/// How a vertex beside a hip or shoulder sees the two groups there.
struct Drawn {
    limb: u32,
    trunk_joint: u32,
    share: f32,
    gate: u32,
    side: Vec3,
}

impl Trunk {
    fn of(rig: &Rig) -> Option<Trunk> {
        let is_trunk = |g: &super::groups::Group| g.part == Some(BodyPart::Trunk);
        let group = rig.groups.groups.iter().position(is_trunk)? as u32;
        let owned: Vec<usize> = (0..rig.groups.owner.len()).filter(|&v| rig.groups.owner[v] == group).collect();
        let stride = owned.len().div_ceil(TRUNK_POINTS).max(1);
        let mut trunk = Trunk { group, points: Vec::new(), limbs: Vec::new() };
        let joints = &rig.groups.groups[group as usize].joints;
        trunk.points = owned
            .iter()
            .step_by(stride)
            .map(|&v| (rig.character.positions_rest[v], own_weights(rig, joints, v).0))
            .collect();
        for swing in &rig.swings {
            let part = rig.groups.groups[swing.group as usize].part;
            let (draw, gated) = match part {
                Some(BodyPart::Thigh) => (HIP_DRAW, false),
                Some(BodyPart::UpperArm) => (SHOULDER_DRAW, true),
                _ => continue,
            };
            if rig.groups.group_of_joint[swing.parent as usize] == group {
                let (joint, trunk_joint) = (swing.joint, swing.parent);
                let (origin, axis) = (swing.origin, swing.axis);
                trunk.limbs.push(Limb { group: swing.group, joint, trunk_joint, draw, gated, origin, axis });
            }
        }
        Some(trunk)
    }

    /// The trunk's joints that move a vertex's surroundings: its own weights, and where it hardly has any those of the
    /// trunk's skin around it.
    fn weights(&self, rig: &Rig, v: usize) -> Vec<Influence> {
        let joints = &rig.groups.groups[self.group as usize].joints;
        let (own, total) = own_weights(rig, joints, v);
        let known = (total / KNOWN_SHARE).min(1.0);
        let mut weights: Vec<f32> = own.iter().map(|w| w * known).collect();
        if known < 1.0 && !self.points.is_empty() {
            let p = rig.character.positions_rest[v];
            let mut around = vec![0.0f32; joints.len()];
            let mut sum = 0.0;
            for (point, moved) in &self.points {
                // Shepard's interpolation: smooth everywhere, and by the fourth power near enough to local.
                let squared = p.distance_squared(*point).max(1e-8);
                let closeness = 1.0 / (squared * squared);
                sum += closeness;
                around.iter_mut().zip(moved).for_each(|(a, w)| *a += closeness * w);
            }
            weights.iter_mut().zip(around).for_each(|(w, a)| *w += (1.0 - known) * a / sum);
        }
        let mut blend: Vec<Influence> =
            joints.iter().zip(weights).map(|(&joint, weight)| Influence { joint, weight }).collect();
        blend.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        blend.truncate(MOST_BLENDED);
        blend.retain(|i| i.weight >= LEAST_BLENDED);
        let sum: f32 = blend.iter().map(|i| i.weight).sum();
        if blend.is_empty() || sum <= 0.0 {
            return vec![Influence { joint: rig.grids[self.group as usize].joint, weight: 1.0 }];
        }
        blend.iter_mut().for_each(|i| i.weight /= sum);
        blend
    }

    /// The limb whose frame and the trunk's draw each other most at a vertex.
    fn drawn(&self, rig: &Rig, v: usize) -> Option<Drawn> {
        let of_group = |g: u32| {
            let own = rig.character.influences_of(v).iter();
            own.filter(|i| rig.groups.group_of_joint[i.joint as usize] == g).map(|i| i.weight).sum::<f32>()
        };
        let trunk = of_group(self.group);
        let drawn = self.limbs.iter().filter_map(|limb| {
            let own = of_group(limb.group);
            let w = own / (own + trunk);
            let share = 2.0 * limb.draw * w * (1.0 - w);
            let out = (rig.character.positions_rest[v] - limb.origin).reject_from_normalized(limb.axis);
            (share > 1e-3).then(|| Drawn {
                limb: limb.group,
                trunk_joint: limb.trunk_joint,
                share,
                gate: if limb.gated { limb.joint } else { NO_JOINT },
                side: out.normalize_or_zero(),
            })
        });
        drawn.max_by(|a, b| a.share.total_cmp(&b.share))
    }
}

/// A vertex's weights of the given joints, to a sum of 1, and what their sum was.
fn own_weights(rig: &Rig, joints: &[u32], v: usize) -> (Vec<f32>, f32) {
    let mut weights = vec![0.0f32; joints.len()];
    for influence in rig.character.influences_of(v) {
        if let Ok(k) = joints.binary_search(&influence.joint) {
            weights[k] += influence.weight;
        }
    }
    let total: f32 = weights.iter().sum();
    if total > 0.0 {
        weights.iter_mut().for_each(|w| *w /= total);
    }
    (weights, total)
}
