//! `normals` against its twin, into layouts of every kind.

use crate::support::{JUNK, Random, SIZES, gpu, run};
use glam::{Vec3, Vec4, Vec4Swizzles};
use sinew::{
    normals::{self, Fans, NormalParams},
    parity,
    schedule::KernelId,
};

struct Mesh {
    positions: Vec<Vec4>,
    triangles: Vec<u32>,
    fans: Vec<[u32; 2]>,
    members: Vec<u32>,
}

impl Mesh {
    /// Random vertices in `instances` instances; vertex `v` has the triangles `v`, `v + 1` and every seventh none.
    fn random(vertices: usize, instances: usize, seed: u64) -> Mesh {
        let mut random = Random(seed);
        let positions = (0..vertices * instances).map(|_| random.vec3().extend(1.0)).collect();
        let n = vertices as u32;
        let triangles: Vec<u32> = (0..n).flat_map(|t| [t, (t + 1) % n, (t * 5 + 2) % n]).collect();
        let (mut fans, mut members) = (Vec::new(), Vec::new());
        for v in 0..n {
            let begin = members.len() as u32;
            if v % 7 != 6 {
                members.extend([v, (v + 1) % n]);
            }
            fans.push([begin, members.len() as u32]);
        }
        Mesh { positions, triangles, fans, members }
    }

    fn cpu(&self, instance: usize) -> Vec<Vec4> {
        let vertices = self.fans.len();
        let fans = Fans { triangles: &self.triangles, fans: &self.fans, members: &self.members };
        let mut out = vec![Vec4::ZERO; vertices];
        normals::from_faces(&fans, &self.positions[instance * vertices..][..vertices], &mut out);
        out
    }

    /// The output words, from a buffer of junk.
    fn gpu(&self, params: NormalParams) -> Option<Vec<u32>> {
        let gpu = gpu()?;
        let items = params.vertex_count * params.instance_count;
        let inputs: [(&str, &[u8]); 5] = [
            ("params", bytemuck::bytes_of(&params)),
            ("triangles", bytemuck::cast_slice(&self.triangles)),
            ("fans", bytemuck::cast_slice(&self.fans)),
            ("members", bytemuck::cast_slice(&self.members)),
            ("positions", bytemuck::cast_slice(&self.positions)),
        ];
        let words = params.offset + (items + 1) * params.stride;
        let out = run(&gpu, KernelId::Normals, items.into(), &inputs, &[("vertices", words as usize * 4)]);
        Some(bytemuck::pod_collect_to_vec(&out[0]))
    }
}

fn params(vertices: usize, instances: u32, [offset, stride, position_at, normal_at]: [u32; 4]) -> NormalParams {
    let vertex_count = vertices as u32;
    NormalParams { vertex_count, instance_count: instances, offset, stride, position_at, normal_at, pad_0: 0, pad_1: 0 }
}

#[test]
fn matches_its_twin_at_every_size_and_layout() {
    for size in SIZES {
        for layout in [[0, 6, 0, 3], [5, 9, 4, 1], [2, 12, 0, 8]] {
            let mesh = Mesh::random(size, 2, 51);
            let params = params(size, 2, layout);
            let Some(words) = mesh.gpu(params) else { return };
            let float = |at: u32| f32::from_bits(words[at as usize]);
            let vector = |at: u32| Vec3::new(float(at), float(at + 1), float(at + 2));
            for instance in 0..2 {
                let cpu = mesh.cpu(instance);
                let first = |v: usize| params.offset + (instance * size + v) as u32 * params.stride;
                let gpu: Vec<Vec4> = (0..size).map(|v| vector(first(v) + params.normal_at).extend(0.0)).collect();
                let report = parity::vectors("normals", &gpu, &cpu, 1.0, parity::SKINNED);
                assert!(report.pass, "size {size}, {layout:?}: {report:?}");
                for v in 0..size {
                    let position = vector(first(v) + params.position_at);
                    assert_eq!(position, mesh.positions[instance * size + v].xyz());
                }
            }
            let written = words.iter().filter(|w| **w != JUNK).count();
            assert_eq!(written, size * 2 * 6, "words outside position and normal keep what was there");
        }
    }
}

#[test]
fn a_flipped_triangle_is_found() {
    let mesh = Mesh::random(64, 1, 52);
    let Some(words) = mesh.gpu(params(64, 1, [0, 6, 0, 3])) else { return };
    let gpu: Vec<Vec4> =
        (0..64).map(|v| Vec4::from_array([3, 4, 5, 3].map(|k| f32::from_bits(words[v * 6 + k])))).collect();
    let mut flipped = Mesh::random(64, 1, 52);
    flipped.triangles.swap(30, 31);
    assert!(parity::vectors("normals", &gpu, &mesh.cpu(0), 1.0, parity::SKINNED).pass);
    assert!(!parity::vectors("normals", &gpu, &flipped.cpu(0), 1.0, parity::SKINNED).pass);
}

#[test]
fn twin_gives_a_cube_its_corner_directions() {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32);
    let quads = [[0u32, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<u32> = quads.iter().flat_map(|q| [q[0], q[1], q[2], q[0], q[2], q[3]]).collect();
    let (mut fans, mut members) = (Vec::new(), Vec::new());
    for v in 0..8 {
        let begin = members.len() as u32;
        members.extend((0..12u32).filter(|t| triangles[*t as usize * 3..][..3].contains(&v)));
        fans.push([begin, members.len() as u32]);
    }
    let positions: Vec<Vec4> = (0..8).map(|i| corner(i).extend(1.0)).collect();
    let mut out = vec![Vec4::ZERO; 8];
    normals::from_faces(&Fans { triangles: &triangles, fans: &fans, members: &members }, &positions, &mut out);
    for (i, normal) in out.iter().enumerate() {
        let outward = corner(i as u32) - Vec3::splat(0.5);
        // A corner's faces count by area, once or twice with the diagonal: the direction is within 20 degrees.
        assert!(normal.xyz().dot(outward.normalize()) > 0.94, "corner {i}: {normal}");
        assert!((normal.xyz().length() - 1.0).abs() < 1e-6);
    }
    let lone = Mesh { positions: vec![Vec4::ZERO; 1], triangles: vec![], fans: vec![[0, 0]], members: vec![] };
    assert_eq!(lone.cpu(0)[0], Vec4::Y, "a vertex without faces");
}
