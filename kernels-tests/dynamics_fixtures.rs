//! Muscles in motion made by code: random ones that lie across each other, a capsule, and a ball in a grid as a bone and
//! as the skin.

use crate::support::{JUNK, Random};
use crate::wrap_fixtures::across;
use glam::{Mat4, Quat, Vec3, Vec4, Vec4Swizzles};
use sinew::{
    dynamics::{
        BoneRest, DynamicsParams, Link, MovedJoint, MuscleBody, Particle, StepClock, Surroundings, joints,
        predict::{self, Predicted},
        project,
    },
    field::{
        GroupGrid,
        evaluate::GroupFrame,
        muscle::{AxisPoint, MuscleInput, Profile, axis, wrap::MuscleWrap},
    },
    math::polar,
    rig::JointFrame,
    schedule::{Counts, DynamicsOptions},
};

/// Joints of the fixture.
pub const JOINTS: usize = 4;
/// Joint of the balls.
const CENTRE: u32 = 3;
/// Nodes along a grid's edge, and the edge, metres.
const NODES: u32 = 20;
const EDGE: f32 = 1.2;

/// A joint's frame of any matrix.
pub fn joint_frame(matrix: Mat4) -> JointFrame {
    let (rotation, _, stretch) = polar(&matrix);
    JointFrame { matrix, real: rotation.into(), dual: Vec4::ZERO, stretch }
}

/// Muscles of all instances, and what is round them.
#[derive(Clone)]
pub struct Crowd {
    pub instances: usize,
    pub muscles: Vec<MuscleBody>,
    pub wraps: Vec<MuscleWrap>,
    pub inputs: Vec<MuscleInput>,
    pub bones: Vec<BoneRest>,
    pub links: Vec<Link>,
    pub grids: Vec<GroupGrid>,
    pub nodes: Vec<Vec4>,
    pub clocks: Vec<StepClock>,
    pub moved: Vec<MovedJoint>,
    pub axes: Vec<AxisPoint>,
    pub particles: Vec<Particle>,
    /// Two halves an instance.
    pub iterates: Vec<Vec4>,
}

impl Crowd {
    /// `count` muscles of 4 to 64 points, or of `points` each, in a step from somewhere to somewhere else.
    pub fn new(count: usize, instances: usize, points: Option<u32>, seed: u64) -> Crowd {
        let mut random = Random(seed);
        let (grids, nodes) = balls();
        let mut crowd = Crowd {
            instances,
            muscles: Vec::new(),
            wraps: Vec::new(),
            inputs: Vec::new(),
            bones: vec![
                BoneRest {
                    start: Vec4::new(0.02, -0.3, 0.01, 0.012),
                    end: Vec4::new(-0.01, 0.3, -0.02, 0.0),
                    joint: 0,
                    ..BoneRest::default()
                },
                BoneRest { grid: grids[0], joint: CENTRE, ..BoneRest::default() },
            ],
            links: Vec::new(),
            grids: grids[1..].to_vec(),
            nodes,
            clocks: (0..instances)
                .map(|_| StepClock {
                    fade: 1,
                    age: 3,
                    turns: 4,
                    turn: 1,
                    first: 0.3,
                    step: 0.2,
                    full_retention: 0.9,
                    ..StepClock::default()
                })
                .collect(),
            moved: Vec::new(),
            axes: Vec::new(),
            particles: Vec::new(),
            iterates: Vec::new(),
        };
        for index in 0..count {
            let segments = points.map_or(3 + (index as u32 * 17) % 61, |p| p - 1);
            crowd.add(index, count, segments, &mut random);
        }
        let bodies = crowd.muscles.clone();
        for _ in 0..instances {
            let place = Mat4::from_rotation_translation(random.rotation(), random.vec3());
            let frames: Vec<JointFrame> = (0..2 * JOINTS).map(|_| joint_frame(place * slight(&mut random))).collect();
            let mut moved = vec![MovedJoint::default(); JOINTS];
            joints::step(&crowd.clocks[0], false, &frames, &mut moved);
            for muscle in &bodies {
                crowd.motion(muscle, &place, &mut random);
            }
            crowd.moved.extend(moved);
        }
        crowd.iterates = vec![Vec4::from_array([f32::from_bits(JUNK); 4]); 2 * instances * crowd.half()];
        crowd
    }

    /// Two of three muscles lie round something that a joint carries.
    pub fn wrapped(mut self, seed: u64) -> Crowd {
        let mut random = Random(seed);
        for (i, muscle) in self.muscles.iter_mut().enumerate().filter(|(i, _)| i % 3 > 0) {
            let (origin, insertion) = (muscle.origin.xyz(), muscle.insertion.xyz());
            self.wraps.extend(across(origin, insertion, i % JOINTS, muscle.segments, i % 2 == 0, &mut random));
            muscle.wrap = self.wraps.len() as u32;
        }
        self
    }

    /// A muscle through the middle, so that all of them cross, with links to everything.
    fn add(&mut self, index: usize, count: usize, segments: u32, random: &mut Random) {
        let along = random.vec3().normalize_or(Vec3::X) * (0.12 + 0.05 * random.next());
        let middle = random.vec3() * 0.05;
        let begin = self.links.len() as u32;
        let link = |index: u32, depth: f32| Link { index, origin_depth: depth, insertion_depth: -0.002, joint: 0 };
        self.links.extend([link(0, -0.004), link(1, 0.0)]);
        let others = (0..count as u32).filter(|i| *i != index as u32).take(8);
        self.links.extend(others.map(|i| link(i, 0.0)));
        let skins_begin = self.links.len() as u32;
        self.links.extend((0..self.grids.len() as u32).map(|i| Link { joint: i % JOINTS as u32, ..link(i, 0.0) }));
        self.muscles.push(MuscleBody {
            origin: (middle - along).extend(2e-4 * (1.0 + 0.5 * random.next())),
            insertion: (middle + along).extend(0.2 + 0.1 * random.next()),
            first_point: self.muscles.last().map_or(0, |m| m.first_point + m.segments + 1),
            segments,
            origin_joint: index as u32 % 2,
            insertion_joint: 1 + index as u32 % 2,
            driver: CENTRE,
            collides: 7,
            bones_begin: begin,
            peers_begin: begin + 2,
            skins_begin,
            links_end: self.links.len() as u32,
            looseness: 30.0 + 20.0 * random.next(),
            frequency: [0.0, 0.0, 9.0][index % 3],
            jiggle: [0.7, 0.0, 1.0][index % 3],
            ..MuscleBody::default()
        });
    }

    /// One muscle's input, axis and particles in one instance.
    fn motion(&mut self, muscle: &MuscleBody, place: &Mat4, random: &mut Random) {
        let share = random.next().abs();
        let profile = Profile::blend(&[((3, 4), share), ((4, 7), 1.0 - share)]);
        let input = MuscleInput::new(&profile, 0.8 * random.next().abs());
        self.inputs.push(MuscleInput { stiffness: 0.1 + 0.6 * share, ..input });
        let n = muscle.segments as f32;
        let length = muscle.origin.xyz().distance(muscle.insertion.xyz());
        let bow = random.vec3() * 0.01;
        // Shift and its velocity, as a substep before may have left them.
        let jiggle = Vec4::new(0.0, 0.0, 0.1 * random.next(), random.next());
        let bare = muscle.jiggle == 1.0;
        for i in 0..=muscle.segments {
            let s = i as f32 / n;
            let rest = muscle.origin.xyz().lerp(muscle.insertion.xyz(), s) + bow * (4.0 * s * (1.0 - s));
            let is_end = i == 0 || i == muscle.segments;
            let middle = (i as f32 + 0.5) / n;
            let tendon = !(0.1..=0.9).contains(&middle);
            let mobility = if is_end { 0.0 } else { n * (1.0 + 0.4 * random.next()) / muscle.insertion.w };
            let shaken = if is_end { Vec3::ZERO } else { random.vec3() * 0.001 };
            self.particles.push(Particle {
                position: (place.transform_point3(rest) + shaken).extend(0.0),
                velocity: (random.vec3() * if i % 8 == 5 { 20.0 } else { 0.3 }).extend(mobility),
                spring: Vec3::ZERO.extend(if tendon { length / n } else { 0.02 * length / n }),
                pushes: Vec4::ZERO,
                // Every third muscle has no tendons.
                traits: Vec4::new(
                    if bare { 1.0 } else { (s.min(1.0 - s) / 0.1).min(1.0) },
                    if tendon { 10.0 } else { 1.0 },
                    0.0,
                    0.0,
                ) + if i == 0 { jiggle } else { Vec4::ZERO },
                ..Particle::default()
            });
            self.axes
                .push(AxisPoint { normal: random.vec3().normalize_or(Vec3::X).extend(0.0), ..AxisPoint::default() });
        }
    }

    pub fn points(&self) -> usize {
        self.muscles.last().map_or(0, |m| (m.first_point + m.segments + 1) as usize)
    }

    pub fn half(&self) -> usize {
        axis::half(self.muscles.len() as u32, self.points() as u32)
    }

    pub fn params(&self, options: &DynamicsOptions, outer: u32) -> DynamicsParams {
        let counts = Counts {
            vertices: 0,
            muscles: self.muscles.len() as u32,
            points: self.points() as u32,
            most_segments: self.muscles.iter().map(|m| m.segments).max().unwrap_or(0),
            groups: self.grids.len() as u32,
            ..Counts::default()
        };
        DynamicsParams::new(&counts, self.instances as u32, JOINTS as u32, options, outer)
    }

    /// Every instance's groups, as the kernels get them.
    pub fn groups(&self) -> Vec<GroupFrame> {
        let of_one = self.grids.iter().map(|grid| GroupFrame { grid: *grid, present: 1, ..GroupFrame::default() });
        (0..self.instances).flat_map(|_| of_one.clone()).collect()
    }

    fn body_of(&self, instance: usize) -> std::ops::Range<usize> {
        instance * self.points()..(instance + 1) * self.points()
    }

    /// Plays the twin of `muscle_predict` into the first halves.
    pub fn predict(&mut self, params: &DynamicsParams) {
        let (half, count) = (self.half(), self.muscles.len());
        for instance in 0..self.instances {
            let all = self.body_of(instance);
            let moved = &self.moved[instance * JOINTS..][..JOINTS];
            for (index, muscle) in self.muscles.iter().enumerate() {
                let points = muscle.segments as usize + 1;
                let first = all.start + muscle.first_point as usize;
                let run = 2 * instance * half + axis::run(index, muscle.first_point);
                let predicted = Predicted {
                    muscle,
                    input: &self.inputs[instance * count + index],
                    axis: &self.axes[first..][..points],
                    wrap: muscle.wrap(&self.wraps),
                };
                predict::predict(
                    params,
                    &predicted,
                    moved,
                    &mut self.particles[first..][..points],
                    &mut self.iterates[run..][..2 + 2 * points],
                );
            }
            let clock = &mut self.clocks[instance];
            clock.turn = (clock.turn + 1).min(clock.turns);
        }
    }

    /// Plays the twin of `muscle_project`.
    pub fn project(&mut self, params: &DynamicsParams) {
        let half = self.half();
        for instance in 0..self.instances {
            let all = self.body_of(instance);
            let halves = &mut self.iterates[2 * instance * half..][..2 * half];
            let (first, second) = halves.split_at_mut(half);
            let (read, write) = if params.from_half == 0 { (&*first, second) } else { (&*second, first) };
            let around = Surroundings {
                muscles: &self.muscles,
                bones: &self.bones,
                links: &self.links,
                moved: &self.moved[instance * JOINTS..][..JOINTS],
                grids: &self.grids,
                nodes: &self.nodes,
                iterates: read,
            };
            for (index, muscle) in self.muscles.iter().enumerate() {
                let points = muscle.segments as usize + 1;
                let own = &mut self.particles[all.start + muscle.first_point as usize..][..points];
                let run = axis::run(index, muscle.first_point);
                project::project(params, index, &around, own, &mut write[run..][..2 + 2 * points]);
            }
        }
    }

    /// Of each particle of all instances, the length of its muscle, metres.
    pub fn lengths(&self) -> Vec<f32> {
        let length = |m: &MuscleBody| m.origin.xyz().distance(m.insertion.xyz()).max(1e-3);
        let one = self.muscles.iter().flat_map(|m| std::iter::repeat_n(length(m), m.segments as usize + 1));
        (0..self.instances).flat_map(|_| one.clone()).collect()
    }
}

/// A joint near the place where it stands.
fn slight(random: &mut Random) -> Mat4 {
    let turn = Quat::from_scaled_axis(random.vec3() * 0.05);
    Mat4::from_scale_rotation_translation(Vec3::splat(1.0 + 0.05 * random.next()), turn, random.vec3() * 0.01)
}

/// The grids of balls: a bone of 5 cm beside the middle, and skins of 12 and 10 cm round it.
fn balls() -> (Vec<GroupGrid>, Vec<Vec4>) {
    let mut nodes = Vec::new();
    let mut ball = |centre: Vec3, radius: f32| {
        let cell = EDGE / (NODES - 1) as f32;
        let offset = nodes.len() as u32;
        for k in 0..NODES.pow(3) {
            let at = Vec3::new((k % NODES) as f32, (k / NODES % NODES) as f32, (k / NODES / NODES) as f32);
            let away = at * cell - EDGE / 2.0 - centre;
            nodes.push(away.normalize_or(Vec3::X).extend(away.length() - radius));
        }
        let to_grid = Mat4::from_scale(Vec3::splat(1.0 / cell)) * Mat4::from_translation(Vec3::splat(EDGE / 2.0));
        GroupGrid {
            rest_to_grid: to_grid,
            offset,
            size_x: NODES,
            size_y: NODES,
            size_z: NODES,
            joint: CENTRE,
            ..GroupGrid::default()
        }
    };
    let grids = vec![
        ball(Vec3::new(0.09, 0.02, 0.0), 0.05),
        ball(Vec3::new(0.01, 0.0, 0.0), 0.12),
        ball(Vec3::new(-0.1, 0.02, 0.03), 0.1),
    ];
    (grids, nodes)
}
