//! `skin_linear` against its twin, and the twin against f64.

use crate::support::{JUNK, Random, SIZES, gpu, run};
use glam::{DVec3, Mat4, Vec3, Vec4, Vec4Swizzles};
use sinew::{
    parity,
    rig::{Influence, JointFrame},
    schedule::KernelId,
    skinning::{self, SkinInput, VertexParams},
};

/// Random joints and vertices with 0 to 9 influences each.
pub struct Skin {
    pub joints: Vec<JointFrame>,
    pub rest: Vec<Vec4>,
    pub offsets: Vec<u32>,
    pub influences: Vec<Influence>,
}

impl Skin {
    pub fn random(vertices: usize, instances: usize, seed: u64) -> Skin {
        let mut random = Random(seed);
        const JOINTS: usize = 7;
        let joints = (0..JOINTS * instances).map(|_| joint(&random.matrix())).collect();
        let mut skin = Skin { joints, rest: Vec::new(), offsets: vec![0], influences: Vec::new() };
        for vertex in 0..vertices {
            skin.rest.push(random.vec3().extend(1.0));
            let count = if vertices > 1 { vertex % 10 } else { 3 };
            let mut weights: Vec<f32> = (0..count).map(|_| random.next().abs() + 0.01).collect();
            weights.sort_by(|a, b| b.total_cmp(a));
            let sum: f32 = weights.iter().sum();
            for (k, weight) in weights.iter().enumerate() {
                skin.influences.push(Influence { joint: ((vertex + 3 * k) % JOINTS) as u32, weight: weight / sum });
            }
            skin.offsets.push(skin.influences.len() as u32);
        }
        skin
    }

    pub fn input(&self, instance: usize) -> SkinInput<'_> {
        let joints = &self.joints[instance * 7..(instance + 1) * 7];
        SkinInput { joints, positions_rest: &self.rest, offsets: &self.offsets, influences: &self.influences }
    }

    pub fn params(&self, instances: u32) -> VertexParams {
        VertexParams { vertex_count: self.rest.len() as u32, instance_count: instances, joint_count: 7, pad_0: 0 }
    }

    /// Runs a skinning kernel; the result has one item more than there are vertices, which must stay junk.
    pub fn gpu(&self, id: KernelId, instances: u32) -> Option<Vec<Vec4>> {
        let gpu = gpu()?;
        let threads = self.rest.len() * instances as usize;
        let params = self.params(instances);
        let inputs: [(&str, &[u8]); 5] = [
            ("params", bytemuck::bytes_of(&params)),
            ("joints", bytemuck::cast_slice(&self.joints)),
            ("positions_rest", bytemuck::cast_slice(&self.rest)),
            ("offsets", bytemuck::cast_slice(&self.offsets)),
            ("influences", bytemuck::cast_slice(&self.influences)),
        ];
        let out = run(&gpu, id, threads as u64, &inputs, &[("skinned", (threads + 1) * 16)]);
        let mut positions: Vec<Vec4> = bytemuck::pod_collect_to_vec(&out[0]);
        let beyond = positions.pop().expect("one item more");
        assert_eq!(beyond.to_array().map(f32::to_bits), [JUNK; 4], "written beyond the last vertex");
        Some(positions)
    }
}

pub fn joint(matrix: &Mat4) -> JointFrame {
    let (rotation, translation, stretch) = sinew::math::polar(matrix);
    let half = glam::Quat::from_xyzw(translation.x / 2.0, translation.y / 2.0, translation.z / 2.0, 0.0) * rotation;
    JointFrame { matrix: *matrix, real: rotation.into(), dual: half.into(), stretch }
}

#[test]
fn matches_its_twin_at_every_size() {
    for size in SIZES {
        let skin = Skin::random(size, 3, 11);
        let Some(gpu) = skin.gpu(KernelId::SkinLinear, 3) else { return };
        for instance in 0..3 {
            let mut cpu = vec![Vec4::ZERO; size];
            skinning::linear(&skin.input(instance), &mut cpu);
            let gpu = &gpu[instance * size..(instance + 1) * size];
            let report = parity::vectors("skinned", gpu, &cpu, 1.0, parity::SKINNED);
            assert!(report.pass, "size {size}: {report:?}");
        }
    }
}

#[test]
fn a_changed_weight_is_found() {
    let skin = Skin::random(65, 1, 12);
    let Some(gpu) = skin.gpu(KernelId::SkinLinear, 1) else { return };
    let mut changed = Skin::random(65, 1, 12);
    changed.influences[40].weight += 1e-3;
    let mut cpu = vec![Vec4::ZERO; 65];
    skinning::linear(&changed.input(0), &mut cpu);
    let report = parity::vectors("skinned", &gpu, &cpu, 1.0, parity::SKINNED);
    assert!(!report.pass && report.over == 1, "{report:?}");
}

#[test]
fn folds_above_65535_workgroups() {
    let vertices = 65_535 * 64 + 65;
    let skin = Skin {
        joints: vec![joint(&Mat4::from_translation(Vec3::X)); 7],
        rest: (0..vertices).map(|i| Vec4::new(i as f32, 0.0, 0.0, 1.0)).collect(),
        offsets: (0..=vertices as u32).collect(),
        influences: vec![Influence { joint: 3, weight: 1.0 }; vertices],
    };
    let Some(gpu) = skin.gpu(KernelId::SkinLinear, 1) else { return };
    let wrong = gpu.iter().zip(&skin.rest).position(|(g, r)| g.x != r.x + 1.0);
    assert_eq!(wrong, None);
}

#[test]
fn twin_matches_f64() {
    let skin = Skin::random(200, 1, 13);
    let mut cpu = vec![Vec4::ZERO; 200];
    skinning::linear(&skin.input(0), &mut cpu);
    for (vertex, posed) in cpu.iter().enumerate().filter(|(v, _)| skin.offsets[*v] < skin.offsets[v + 1]) {
        let p = skin.rest[vertex].xyz().as_dvec3();
        let exact: DVec3 = skin.influences[skin.offsets[vertex] as usize..skin.offsets[vertex + 1] as usize]
            .iter()
            .map(|i| skin.joints[i.joint as usize].matrix.as_dmat4().transform_point3(p) * f64::from(i.weight))
            .sum();
        assert!((posed.xyz().as_dvec3() - exact).length() < 1e-6, "vertex {vertex}");
    }
}

#[test]
fn junk_in_a_joint_reaches_only_its_vertices() {
    let mut skin = Skin::random(64, 1, 14);
    skin.joints[2].matrix.x_axis.x = f32::NAN;
    let Some(gpu) = skin.gpu(KernelId::SkinLinear, 1) else { return };
    for (vertex, position) in gpu.iter().enumerate() {
        let range = skin.offsets[vertex] as usize..skin.offsets[vertex + 1] as usize;
        let bound = skin.influences[range].iter().any(|i| i.joint == 2);
        assert_eq!(position.x.is_nan(), bound, "vertex {vertex}");
    }
}
