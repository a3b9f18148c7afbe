//! Random skins of any size under way to their poses, for the tracker's kernels and their twins.

use crate::support::{JUNK, Random, gpu, run};
use glam::{Mat4, Vec3, Vec4, Vec4Swizzles};
use sinew::{
    field::evaluate::Place,
    kernel::kernel,
    math::product,
    rig::{Influence, NO_JOINT, Reach, Role, SkinEdge, VertexTarget},
    schedule::{Counts, KernelId, TrackOptions},
    tracking::{AverageInput, CarryInput, RelaxInput, Track, TrackJoint, TrackParams, Way},
};

pub const JOINTS: usize = 4;
/// One in three sub-poses, one in a single one, one that only ends, one that got no pose.
pub const WAYS: [Way; 4] = [
    Way { count: 3, turn: 1.0, posed: 1 },
    Way { count: 1, turn: 0.3, posed: 1 },
    Way { count: 0, turn: 0.0, posed: 1 },
    Way { count: 0, turn: 0.0, posed: 0 },
];
pub const SUB_POSES: usize = 3;

#[derive(Clone)]
pub struct Crowd {
    pub count: usize,
    pub joints: Vec<TrackJoint>,
    pub rest: Vec<Vec4>,
    pub offsets: Vec<u32>,
    pub influences: Vec<Influence>,
    pub targets: Vec<VertexTarget>,
    pub edges: Vec<SkinEdge>,
    /// Random, not of any ring: one per edge, up to twice their mean.
    pub mean_values: Vec<f32>,
    pub reaches: Vec<Reach>,
    pub blends: Vec<Influence>,
    pub positions: Vec<Vec4>,
    pub tracks: Vec<Track>,
}

impl Crowd {
    pub fn random(count: usize, seed: u64) -> Crowd {
        let mut random = Random(seed);
        let mut crowd = Crowd {
            count,
            joints: Vec::new(),
            rest: (0..count).map(|_| (random.vec3() * 0.4).extend(1.0)).collect(),
            offsets: vec![0],
            influences: Vec::new(),
            targets: Vec::new(),
            edges: Vec::new(),
            mean_values: Vec::new(),
            reaches: Vec::new(),
            blends: Vec::new(),
            positions: Vec::new(),
            tracks: Vec::new(),
        };
        for v in 0..count {
            crowd.vertex(v, &mut random);
        }
        for way in WAYS.iter().cycle().take(WAYS.len() * SUB_POSES) {
            for _ in 0..JOINTS {
                let turn = |random: &mut Random| {
                    let turn = glam::Quat::from_scaled_axis(random.vec3() * 0.3);
                    Mat4::from_rotation_translation(turn, random.vec3() * 0.1)
                };
                let (before, now) = (turn(&mut random), turn(&mut random));
                let carry = product(&(now - before), &before.inverse());
                let swing = random.vec3().normalize().extend(if way.count > 1 { random.next().abs() } else { 0.0 });
                crowd.joints.push(TrackJoint { matrix: now, carry, swing });
            }
        }
        for _ in 0..WAYS.len() {
            let turn = glam::Quat::from_scaled_axis(random.vec3() * 0.4);
            for v in 0..count {
                let moved = turn * crowd.rest[v].xyz() + random.vec3() * 0.02;
                crowd.positions.push(moved.extend(1.0));
                crowd.tracks.push(Track {
                    normal: random.vec3().normalize().extend(0.01 * random.next()),
                    rotation: glam::Quat::from_scaled_axis(random.vec3() * 0.3).into(),
                    contact: [0.0, 0.0, 0.4, 1.0][v % 4],
                    stop: v as u32 % 6,
                    passes: 3,
                    runs: 1,
                });
            }
        }
        crowd
    }

    fn vertex(&mut self, v: usize, random: &mut Random) {
        let joints = 1 + v % 3;
        let weights: Vec<f32> = (0..joints).map(|_| 0.1 + random.next().abs()).collect();
        let sum: f32 = weights.iter().sum();
        let own = (0..joints).map(|k| Influence { joint: ((v + k) % JOINTS) as u32, weight: weights[k] / sum });
        self.influences.extend(own.clone());
        self.offsets.push(self.influences.len() as u32);
        let edge_begin = self.edges.len() as u32;
        if v % 11 != 5 {
            let neighbours = [1, 7, 12, 20, 33].map(|k| (v + k) % self.count);
            let others = neighbours.into_iter().filter(|&other| other != v);
            let weigh = |other| SkinEdge { neighbour: other as u32, weight: 0.001 + random.next().abs() };
            self.edges.extend(others.map(weigh));
            self.mean_values.extend(self.edges[edge_begin as usize..].iter().map(|edge| 0.4 * edge.weight));
        }
        let edge_end = self.edges.len() as u32;
        let reach_begin = self.reaches.len() as u32;
        for group in 0..v as u32 % 3 {
            let blend_begin = self.blends.len() as u32;
            self.blends.extend(own.clone());
            self.reaches.push(Reach {
                side: random.vec3().normalize().extend(0.0),
                group,
                limit: 0.4,
                blend_begin,
                blend_end: self.blends.len() as u32,
                other: if v.is_multiple_of(2) { (v % JOINTS) as u32 } else { NO_JOINT },
                share: 0.6,
                gate: if v.is_multiple_of(4) { ((v + 1) % JOINTS) as u32 } else { NO_JOINT },
                ..Reach::default()
            });
        }
        let role = match v % 7 {
            3 => Role::Passive,
            6 => Role::Copy,
            _ => Role::Active,
        };
        self.targets.push(VertexTarget {
            normal_rest: random.vec3().normalize().extend(0.02 + 0.01 * random.next()),
            iso: 0.5,
            role: role as u32,
            copy_of: if role == Role::Copy { v as u32 - 2 } else { v as u32 },
            reach_begin,
            reach_end: self.reaches.len() as u32,
            edge_begin,
            edge_end,
            slides: u32::from(edge_begin < edge_end && v % 5 != 4),
            turns: u32::from(role != Role::Copy && v % 11 != 3),
            ..VertexTarget::default()
        });
    }

    pub fn params(&self, sub_pose: usize) -> TrackParams {
        self.params_of(sub_pose, false)
    }

    pub fn params_of(&self, sub_pose: usize, projects: bool) -> TrackParams {
        let counts = Counts {
            vertices: self.count as u32,
            joints: JOINTS as u32,
            reaches: self.reaches.len() as u32,
            ..Counts::default()
        };
        TrackParams::new(&counts, WAYS.len() as u32, &TrackOptions::default(), sub_pose as u32, projects)
    }

    /// Joints of one instance at a sub-pose.
    pub fn joints_of(&self, sub_pose: usize, instance: usize) -> &[TrackJoint] {
        &self.joints[(sub_pose * WAYS.len() + instance) * JOINTS..][..JOINTS]
    }

    pub fn carry_input(&self, sub_pose: usize, instance: usize) -> CarryInput<'_> {
        CarryInput {
            joints: self.joints_of(sub_pose, instance),
            positions_rest: &self.rest,
            offsets: &self.offsets,
            influences: &self.influences,
            targets: &self.targets,
        }
    }

    pub fn relax_input(&self) -> RelaxInput<'_> {
        RelaxInput { targets: &self.targets, edges: &self.edges, positions_rest: &self.rest }
    }

    pub fn average_input(&self) -> AverageInput<'_> {
        AverageInput { targets: &self.targets, edges: &self.edges, mean_values: &self.mean_values }
    }

    /// Where geometric skinning would have all instances' vertices.
    pub fn skinned(&self) -> Vec<Vec4> {
        self.positions.iter().map(|p| Vec4::new(p.y, p.z, -p.x, 1.0)).collect()
    }

    /// What the edges of all instances' vertices come to.
    pub fn spans(&self) -> Vec<Vec4> {
        let mut spans = vec![Vec4::ZERO; self.tracks.len()];
        for instance in 0..WAYS.len() {
            let own = self.of(instance);
            sinew::tracking::span(&self.relax_input(), &self.tracks[own.clone()], &mut spans[own]);
        }
        spans
    }

    /// Vertices of one instance.
    pub fn of(&self, instance: usize) -> std::ops::Range<usize> {
        instance * self.count..(instance + 1) * self.count
    }

    /// Runs a kernel of the tracker; the outputs' lengths are in items, and one item behind them must stay as it is.
    pub fn gpu(&self, id: KernelId, sub_pose: usize, items: usize, outputs: &[(&str, usize)]) -> Option<Vec<Vec<u8>>> {
        self.gpu_with(&self.params(sub_pose), id, items, outputs)
    }

    /// [`Crowd::gpu`] with other parameters.
    pub fn gpu_with(
        &self,
        params: &TrackParams,
        id: KernelId,
        items: usize,
        outputs: &[(&str, usize)],
    ) -> Option<Vec<Vec<u8>>> {
        let gpu = gpu()?;
        let skinned = self.skinned();
        let spans = self.spans();
        let inputs: [(&str, &[u8]); 15] = [
            ("params", bytemuck::bytes_of(params)),
            ("joints", bytemuck::cast_slice(&self.joints)),
            ("ways", bytemuck::cast_slice(&WAYS)),
            ("positions_rest", bytemuck::cast_slice(&self.rest)),
            ("offsets", bytemuck::cast_slice(&self.offsets)),
            ("influences", bytemuck::cast_slice(&self.influences)),
            ("targets", bytemuck::cast_slice(&self.targets)),
            ("edges", bytemuck::cast_slice(&self.edges)),
            ("mean_values", bytemuck::cast_slice(&self.mean_values)),
            ("skinned", bytemuck::cast_slice(&skinned)),
            ("reaches", bytemuck::cast_slice(&self.reaches)),
            ("blends", bytemuck::cast_slice(&self.blends)),
            ("positions", bytemuck::cast_slice(&self.positions)),
            ("tracks", bytemuck::cast_slice(&self.tracks)),
            ("spans", bytemuck::cast_slice(&spans)),
        ];
        let written = |name: &str| outputs.iter().any(|(output, _)| *output == name && name == "spans");
        let wanted = |name: &str| kernel(id).bindings.iter().any(|b| b.name == name) && !written(name);
        let bound: Vec<_> = inputs.into_iter().filter(|(name, _)| wanted(name)).collect();
        let sizes: Vec<_> = outputs.iter().map(|(name, size)| (*name, (items + 1) * size)).collect();
        let mut out = run(&gpu, id, items as u64, &bound, &sizes);
        for (bytes, (name, size)) in out.iter_mut().zip(outputs) {
            let behind = bytes.split_off(items * size);
            assert_eq!(behind[..4], JUNK.to_le_bytes(), "{name} is written beyond its last item");
        }
        Some(out)
    }
}

/// Largest difference of two lists of vectors, all four components; infinite where one is not a number.
pub fn apart(a: &[Vec4], b: &[Vec4]) -> f32 {
    assert_eq!(a.len(), b.len());
    let off = |(a, b): (&Vec4, &Vec4)| {
        let off = (*a - *b).abs().max_element();
        if (*a - *b).is_nan() { f32::INFINITY } else { off }
    };
    a.iter().zip(b).map(off).fold(0.0, f32::max)
}

/// Turns of tracks as vectors.
pub fn rotations(tracks: &[Track]) -> Vec<Vec4> {
    tracks.iter().map(|t| t.rotation).collect()
}

/// Matrices of places, column by column.
pub fn columns(places: &[Place]) -> Vec<Vec4> {
    places.iter().flat_map(|p| [0, 1, 2, 3].map(|k| p.to_rest.col(k))).collect()
}

/// What no skin should have, and some have: places that coincide, edges of no length, sizes beyond reason.
pub fn degenerate(count: usize, seed: u64) -> Crowd {
    let mut crowd = Crowd::random(count, seed);
    let spoil = |v: usize, p: Vec4| match v % 6 {
        0 => Vec3::ZERO.extend(1.0),
        1 => (p.xyz() * 1e30).extend(1.0),
        2 => (p.xyz() * 1e-30).extend(1.0),
        3 => (p.xyz() * 1e18).extend(1.0),
        _ => p,
    };
    crowd.rest.iter_mut().enumerate().for_each(|(v, p)| *p = spoil(v / 3, *p));
    crowd.positions.iter_mut().enumerate().for_each(|(v, p)| *p = spoil(v, *p));
    crowd.edges.iter_mut().step_by(3).for_each(|e| e.weight = 1e-3);
    crowd.joints.iter_mut().step_by(5).for_each(|j| j.carry *= 1e25);
    crowd.joints.iter_mut().step_by(7).for_each(|j| j.matrix *= 1e4);
    crowd
}
