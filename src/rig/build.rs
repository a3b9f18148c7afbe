//! A character made ready to deform: field groups, cached fields, muscles, and the skin's targets in the rest pose.

use super::{
    BoneCollider, BoneMesh, Character, Drives, FieldGroups, FoldPatch, FoldTriangle, MuscleJoints, MuscleSpec,
    MuscleWeights, Pose, Role, SkinGraph, Targets, Topology, bone_fields, bones, fold_patch,
    groups::{FieldOptions, Fields, FitReport, FoldRest, GroupSpec, Swing, build_fields},
    joins::{Join, joins},
    mean_value::mean_values,
    muscle::{self, BoneSpec, JointSpec},
};
use crate::math::{transform_point, transform_vector};
use crate::{
    error::RigError,
    field::{
        GroupGrid,
        muscle::{
            AxisPoint, MuscleFrame, MuscleInput, MuscleRest, shape,
            wrap::{Course, MuscleWrap, Spacing, points_at_rest},
        },
    },
};
use glam::{Vec3, Vec4, Vec4Swizzles};

/// How a rig is built.
#[derive(Clone, Debug)]
pub struct BuildOptions {
    /// Whether fields are fitted. Without them only geometric skinning is to be had, and building is instant.
    pub fields: bool,
    /// Settings of the fit.
    pub fit: FieldOptions,
    /// Field groups that are given; the others are found.
    pub groups: Vec<GroupSpec>,
    /// Bones whose shape for collisions is given; other bones that muscles need get capsules.
    pub bones: Vec<BoneSpec>,
    /// Meshes that `bones` may name besides the character's own parts.
    pub bone_meshes: Vec<BoneMesh>,
    /// What joins limbs at joints, where it is not the plain union.
    pub joints: Vec<JointSpec>,
}

impl Default for BuildOptions {
    fn default() -> Self {
        let (groups, bones, bone_meshes, joints) = Default::default();
        BuildOptions { fields: true, fit: FieldOptions::default(), groups, bones, bone_meshes, joints }
    }
}

/// A character ready to deform; immutable, shared by all its instances on either side.
#[derive(Clone)]
pub struct Rig {
    /// The character it was built from.
    pub character: Character,
    /// Positions at rest with `w = 1`, as the kernels read them.
    pub positions_rest: Vec<Vec4>,
    /// Which joints share a field.
    pub groups: FieldGroups,
    /// Cached field per group; empty without fields.
    pub grids: Vec<GroupGrid>,
    /// Grid nodes of all groups.
    pub nodes: Vec<Vec4>,
    /// How well each group's field fits.
    pub fits: Vec<FitReport>,
    /// The muscles as their author gave them, in the author's order.
    pub specs: Vec<MuscleSpec>,
    /// Their keys and drivers.
    pub drives: Drives,
    /// Names of the muscles below; fibres of a set are numbered from 1.
    pub muscle_names: Vec<String>,
    /// The muscles, one per fibre, sorted by group.
    pub muscles: Vec<MuscleRest>,
    /// Per muscle its author's entry in `specs`.
    pub spec_of: Vec<u32>,
    /// What muscles lie round, one for each muscle that does ([`MuscleRest::wrap`]).
    pub wraps: Vec<MuscleWrap>,
    /// Bones that muscles collide with, ascending by joint; empty without fields.
    pub bones: Vec<BoneCollider>,
    /// Points of all muscles' axes together.
    pub point_count: u32,
    /// Where those points are in the rest pose, scene space: even on their paths, until [`Rig::set_axes_rest`].
    axes_rest: Vec<Vec3>,
    /// The same points as the dynamics hold them, where they do; else empty.
    settled: Vec<SettledPoint>,
    /// Joints between field groups.
    pub swings: Vec<Swing>,
    /// Which groups are joined otherwise than by the plain union.
    pub joins: Vec<Join>,
    /// Joints beside which folding skin displaces what is under it.
    pub folds: Vec<FoldRest>,
    /// The skin around those joints.
    pub fold_patches: Vec<FoldPatch>,
    /// Its triangles.
    pub fold_triangles: Vec<FoldTriangle>,
    /// The skin as a graph.
    pub graph: SkinGraph,
    /// Where the skin goes, and how it sees the groups around it.
    pub targets: Targets,
    /// Mean value coordinates of every vertex among its neighbours at rest, one per edge of `graph`; 0 where there are none.
    pub mean_values: Vec<f32>,
    /// Which muscles take the skin with them where it has no field of its own.
    pub weights: MuscleWeights,
    /// The muscles as joints of linear skinning.
    pub muscle_joints: MuscleJoints,
    /// Triangles around every vertex.
    pub topology: Topology,
}

/// A point of a muscle that has come to rest among bones, other muscles and skin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SettledPoint {
    /// Position, metres in scene space at rest: kinked where something pushes, while axes are smooth.
    pub position: Vec3,
    /// Half spaces `n . p >= w` that other muscles keep it in, in scene space at rest; the zero normal is none.
    pub planes: [Vec4; 2],
    /// Those muscles, counted from 1; 0 for none.
    pub muscles: [u32; 2],
}

impl SettledPoint {
    fn is_finite(&self) -> bool {
        self.position.is_finite() && self.planes.iter().all(|plane| plane.is_finite())
    }
}

impl std::fmt::Debug for Rig {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (vertices, groups) = (self.character.vertex_count(), self.grids.len());
        write!(
            f,
            "Rig({}: {vertices} vertices, {groups} field groups, {} muscles)",
            self.character.name,
            self.muscles.len()
        )
    }
}

impl Rig {
    /// Fits fields, resolves muscles and finds every vertex's rest iso-value.
    ///
    /// # Errors
    /// The character is not consistent, a group, a muscle or a bone's shape does not fit it, or a field cannot be fitted.
    pub fn build(character: Character, muscles: &[MuscleSpec], options: &BuildOptions) -> Result<Rig, RigError> {
        check(&character).map_err(|what| RigError::Character { character: character.name.clone(), what })?;
        let bones = bones::given(&character, &options.bones, &options.bone_meshes)?;
        let groups = FieldGroups::detect_beside(&character, &options.groups)?;
        let joins = joins(&character, &groups, &options.joints)?;
        let fields = if options.fields { build_fields(&character, &groups, &options.fit)? } else { Fields::default() };
        let mut resolved: Vec<(String, u32, (MuscleRest, Option<MuscleWrap>))> = Vec::new();
        for (index, spec) in (0..).zip(muscles) {
            let fibres = muscle::resolve(spec, &character, &groups)?;
            let single = fibres.len() == 1;
            let name = |i| if single { spec.name.clone() } else { format!("{}/{i}", spec.name) };
            resolved.extend((1..).zip(fibres).map(|(i, rest)| (name(i), index, rest)));
        }
        // Muscles live in their groups' fields: without fields they are checked, and left out.
        resolved.retain(|_| options.fields);
        resolved.sort_by_key(|(_, _, (rest, _))| rest.group);
        let (mut point_count, mut wraps) = (0, Vec::new());
        for (_, _, (rest, wrap)) in &mut resolved {
            rest.first_point = point_count;
            point_count += rest.segments + 1;
            wraps.extend(*wrap);
            rest.wrap = if wrap.is_some() { wraps.len() as u32 } else { 0 };
        }
        let muscle_names = resolved.iter().map(|(name, _, _)| name.clone()).collect();
        let spec_of = resolved.iter().map(|(_, spec, _)| *spec).collect();
        let drives = Drives::new(&character, muscles)?;
        let (specs, drives) = if options.fields { (muscles.to_vec(), drives) } else { Default::default() };
        let muscles: Vec<MuscleRest> = resolved.into_iter().map(|(_, _, (rest, _))| rest).collect();
        let mut grids = fields.grids;
        for (g, grid) in grids.iter_mut().enumerate() {
            grid.muscle_begin = muscles.partition_point(|m: &MuscleRest| (m.group as usize) < g) as u32;
            grid.muscle_end = muscles.partition_point(|m: &MuscleRest| m.group as usize <= g) as u32;
        }
        let mut rig = Rig {
            positions_rest: character.positions_rest.iter().map(|p| p.extend(1.0)).collect(),
            topology: Topology::new(&character),
            folds: fields.folds,
            fold_patches: Vec::new(),
            fold_triangles: Vec::new(),
            graph: SkinGraph::new(&character),
            targets: Targets::default(),
            mean_values: Vec::new(),
            weights: MuscleWeights::default(),
            muscle_joints: MuscleJoints::default(),
            character,
            groups,
            grids,
            nodes: fields.nodes,
            fits: fields.fits,
            swings: fields.swings,
            joins,
            specs,
            drives,
            muscle_names,
            muscles,
            spec_of,
            wraps,
            bones: Vec::new(),
            point_count,
            axes_rest: Vec::new(),
            settled: Vec::new(),
        };
        rig.axes_rest = rig.paths_at_rest();
        (rig.fold_patches, rig.fold_triangles) = fold_patch::patches(&rig, &rig.graph);
        rig.aim();
        if options.fields {
            rig.bones = bones::with_capsules(&rig, bones, &options.bones);
            bone_fields::build(&mut rig)?;
        }
        Ok(rig)
    }

    /// What joins two groups: a [`JointOperator::code`](crate::field::compose::JointOperator::code).
    pub fn join(&self, a: u32, b: u32) -> u32 {
        self.joins
            .iter()
            .find(|join| join.groups == [a, b] || join.groups == [b, a])
            .map_or(0, |join| join.operator.code())
    }

    /// Number of active vertices.
    pub fn active_count(&self) -> usize {
        self.targets.vertices.iter().filter(|t| t.role == Role::Active as u32).count()
    }

    /// Every muscle in the rest pose with activation 0, and the points of their axes.
    pub fn muscles_at_rest(&self) -> (Vec<MuscleFrame>, Vec<AxisPoint>) {
        self.muscles_along(&self.axes_rest)
    }

    /// [`Rig::muscles_at_rest`] with other positions of the axes' points, one per point, metres in scene space.
    pub fn muscles_along(&self, positions: &[Vec3]) -> (Vec<MuscleFrame>, Vec<AxisPoint>) {
        let point = |p: &Vec3| AxisPoint { position: p.extend(0.0), ..AxisPoint::default() };
        let mut axes: Vec<AxisPoint> = positions.iter().map(point).collect();
        let inputs = self.rest_inputs();
        let shaped = self.muscles.iter().zip(&inputs).map(|(rest, input)| {
            let first = rest.first_point as usize;
            let own = &mut axes[first..=first + rest.segments as usize];
            shape(rest, input, own, rest.origin_normal.xyz(), rest.insertion_normal.xyz())
        });
        (shaped.collect(), axes)
    }

    /// Takes other positions, metres in scene space, for the points of all muscles' axes in the rest pose, such as those at
    /// which the muscles come to rest among bones and skin. The skin's targets follow, so that the rest pose stays at rest.
    ///
    /// Motions start from these positions, without any contact. Positions that are not one per point, or not finite,
    /// change nothing.
    pub fn set_axes_rest(&mut self, positions: &[Vec3]) {
        if positions.len() == self.axes_rest.len() && positions.iter().all(|p| p.is_finite()) {
            self.axes_rest.copy_from_slice(positions);
            self.settled.clear();
            self.aim();
        }
    }

    /// [`Rig::set_axes_rest`] where muscles have come to rest, so that motions start from there: `points` are the axes'
    /// points as the dynamics hold them, one per position. Points that are not finite change nothing.
    pub fn set_settled(&mut self, positions: &[Vec3], points: Vec<SettledPoint>) {
        if points.len() == positions.len() && points.iter().all(SettledPoint::is_finite) {
            self.set_axes_rest(positions);
            self.settled = points;
        }
    }

    /// Where the dynamics hold the points of all muscles' axes at rest; empty until [`Rig::set_settled`].
    pub fn settled(&self) -> &[SettledPoint] {
        &self.settled
    }

    fn paths_at_rest(&self) -> Vec<Vec3> {
        let of = |rest: &MuscleRest| {
            let mut own = vec![AxisPoint::default(); rest.segments as usize + 1];
            points_at_rest(rest, &self.wraps, &mut own);
            own.into_iter().map(|p| p.position.xyz())
        };
        self.muscles.iter().flat_map(of).collect()
    }

    /// Segments of the axis that has most of them.
    pub fn most_segments(&self) -> u32 {
        self.muscles.iter().map(|muscle| muscle.segments).max().unwrap_or(0)
    }

    /// Length of each muscle's path in a pose over its length at rest, the mean over its fibres, in the order of `specs`: what
    /// length drivers read. The path is straight from end to end, or round what the muscle lies round. Joints that the pose
    /// lacks leave a ratio at 1.
    pub fn axis_ratios(&self, pose: &Pose) -> Vec<f32> {
        let mut sums = vec![(0.0f32, 0u32); self.specs.len()];
        for (rest, &spec) in self.muscles.iter().zip(&self.spec_of) {
            let Some(length) = self.path_length(rest, pose) else { continue };
            let sum = &mut sums[spec as usize];
            *sum = (sum.0 + length / rest.origin_normal.w, sum.1 + 1);
        }
        sums.into_iter().map(|(sum, count)| if count > 0 { sum / count as f32 } else { 1.0 }).collect()
    }

    /// Length of a muscle's path in a pose, metres; none where the pose lacks a joint of it.
    pub fn path_length(&self, rest: &MuscleRest, pose: &Pose) -> Option<f32> {
        let joint = |index: u32| pose.palette.get(index as usize);
        let (from, to) = (joint(rest.origin_joint)?, joint(rest.insertion_joint)?);
        let (origin, insertion) = (transform_point(from, rest.origin.xyz()), transform_point(to, rest.insertion.xyz()));
        // In a bone's space at rest, so that a pose's scale is no stretch.
        if let Some(wrap) = rest.wrap(&self.wraps) {
            let to_posed = *joint(wrap.joint)? * wrap.to_rest;
            return Some(Course::new(wrap, &to_posed, origin, insertion, Spacing::Even).path().length());
        }
        Some(transform_vector(&joint(rest.joint)?.inverse(), insertion - origin).length())
    }

    /// The inputs of all muscles in their rest shapes.
    pub fn rest_inputs(&self) -> Vec<MuscleInput> {
        self.spec_of.iter().map(|&spec| muscle::rest_input(&self.specs[spec as usize])).collect()
    }

    /// Finds the skin's targets and weights with the muscles where they are at rest.
    fn aim(&mut self) {
        self.targets = Targets::new(self);
        self.mean_values = mean_values(&self.character, &self.graph, &self.targets);
        self.weights = MuscleWeights::new(self);
        self.muscle_joints = MuscleJoints::new(self);
    }
}

/// What every later stage relies on; the first thing that does not hold is named.
fn check(character: &Character) -> Result<(), String> {
    let vertices = character.vertex_count();
    let joints = character.joints.len();
    if character.normals_rest.len() != vertices || character.uvs.len() != vertices {
        return Err(format!("{vertices} positions need as many normals and texture coordinates"));
    }
    if character.influence_offsets.len() != vertices + 1
        || character.influence_offsets.windows(2).any(|w| w[0] > w[1])
        || character.influence_offsets.last().copied() != Some(character.influences.len() as u32)
    {
        return Err(
            "influence_offsets must ascend from 0 to the number of influences, one longer than the vertices".into()
        );
    }
    if let Some(v) = character.positions_rest.iter().position(|p| !p.is_finite()) {
        return Err(format!("the position of vertex {v} is not finite"));
    }
    if let Some(t) = character.triangles.iter().position(|t| t.iter().any(|&i| i as usize >= vertices)) {
        return Err(format!("triangle {t} names a vertex beyond the {vertices} there are"));
    }
    for painted in &character.painted {
        let (n, part) = (painted.muscle, &painted.vertices);
        if part.end as usize > vertices || part.start > part.end || painted.weights.len() != part.len() {
            return Err(format!("the weights of muscle {n} need one for each of their vertices {part:?}"));
        }
        if let Some(v) = painted.weights.iter().position(|w| !(0.0..=1.0).contains(w)) {
            let vertex = part.start as usize + v;
            return Err(format!("the weight of muscle {n} at vertex {vertex} is outside 0..=1"));
        }
    }
    if let Some(i) =
        character.influences.iter().position(|i| i.joint as usize >= joints || !(0.0..=1.001).contains(&i.weight))
    {
        return Err(format!("influence {i} names a joint beyond the {joints} there are, or a weight outside 0..=1"));
    }
    if let Some(j) = character
        .joints
        .iter()
        .enumerate()
        .position(|(j, joint)| joint.parent.is_some_and(|p| p as usize >= j) || !joint.inverse_bind.is_finite())
    {
        return Err(format!("joint {j} precedes its parent or has an inverse bind matrix that is not finite"));
    }
    Ok(())
}
