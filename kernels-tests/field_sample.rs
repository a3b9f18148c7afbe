//! `field_sample`, the whole field by itself, against its twin; and the twin's gradient against its value.

use crate::support::{JUNK, Random, SIZES, bent, gpu, limb_rig, points, run};
use glam::{Vec3, Vec4, Vec4Swizzles};
use sinew::{
    parity::{self, Tolerance},
    rig::{FrameInputs, Rig},
    schedule::KernelId,
    tracking::{self, FieldInput, SampleParams},
    wrap::{self, ShapeInput},
};

/// A rig at one moment.
struct Posed {
    rig: Rig,
    inputs: FrameInputs,
    muscles: Vec<sinew::field::muscle::MuscleFrame>,
    axes: Vec<sinew::field::muscle::AxisPoint>,
}

impl Posed {
    fn new(degrees: f32) -> Posed {
        let rig = limb_rig(40);
        let inputs = FrameInputs::new(&rig, &bent(degrees)).expect("pose");
        let mut muscles = vec![Default::default(); rig.muscles.len()];
        let mut axes = vec![Default::default(); rig.point_count as usize];
        let input = ShapeInput { joints: &inputs.joints, inputs: &inputs.muscles, iterates: &[], wraps: &rig.wraps };
        wrap::shape(&rig.muscles, &input, &mut muscles, &mut axes);
        Posed { rig, inputs, muscles, axes }
    }

    fn field(&self) -> FieldInput<'_> {
        FieldInput { groups: &self.inputs.groups, nodes: &self.rig.nodes, muscles: &self.muscles, axes: &self.axes }
    }

    fn cpu(&self, at: &[Vec4]) -> Vec<Vec4> {
        let mut samples = vec![Vec4::ZERO; at.len()];
        tracking::sample(&self.field(), at, &mut samples);
        samples
    }

    fn gpu(&self, at: &[Vec4]) -> Option<Vec<Vec4>> {
        let gpu = gpu()?;
        let params = SampleParams {
            point_count: at.len() as u32,
            instance_count: 1,
            group_count: self.inputs.groups.len() as u32,
            muscle_count: self.muscles.len() as u32,
            axis_point_count: self.axes.len() as u32,
            ..SampleParams::default()
        };
        let inputs: [(&str, &[u8]); 6] = [
            ("params", bytemuck::bytes_of(&params)),
            ("groups", bytemuck::cast_slice(&self.inputs.groups)),
            ("nodes", bytemuck::cast_slice(&self.rig.nodes)),
            ("muscles", bytemuck::cast_slice(&self.muscles)),
            ("axes", bytemuck::cast_slice(&self.axes)),
            ("points", bytemuck::cast_slice(at)),
        ];
        let count = at.len();
        let out = run(&gpu, KernelId::FieldSample, count as u64, &inputs, &[("samples", (count + 1) * 16)]);
        let mut samples: Vec<Vec4> = bytemuck::pod_collect_to_vec(&out[0]);
        assert_eq!(samples.pop().map(|s| s.x.to_bits()), Some(JUNK), "written beyond the last point");
        Some(samples)
    }
}

fn around(count: usize, seed: u64) -> Vec<Vec4> {
    let mut random = Random(seed);
    let all: Vec<Vec3> = (0..count)
        .map(|_| Vec3::new(random.next() * 0.08, 0.3 + random.next() * 0.4, random.next() * 0.1 + 0.02))
        .collect();
    points(&all)
}

/// Values as they are; gradients in units of 25 per metre, the field's own slope.
fn scaled(samples: &[Vec4]) -> Vec<Vec4> {
    samples.iter().map(|s| (s.xyz() / 25.0).extend(s.w)).collect()
}

fn values(samples: &[Vec4]) -> Vec<Vec4> {
    samples.iter().map(|s| Vec4::new(s.w, 0.0, 0.0, 0.0)).collect()
}

/// A few ulp through some fifty operations on values up to 1; gradients differ more where two groups tie.
const FIELD: Tolerance = Tolerance { absolute: 1e-5, share_over: 0.0 };

#[test]
fn matches_its_twin_at_every_size() {
    let posed = Posed::new(80.0);
    for size in SIZES.into_iter().chain([5000]) {
        let at = around(size, 41);
        let Some(gpu) = posed.gpu(&at) else { return };
        let cpu = posed.cpu(&at);
        let report = parity::vectors("values", &values(&gpu), &values(&cpu), 1.0, FIELD);
        assert!(report.pass, "size {size}: {report:?}");
        let report = parity::vectors("gradients", &scaled(&gpu), &scaled(&cpu), 1.0, FIELD);
        assert!(report.pass, "size {size}: {report:?}");
    }
}

#[test]
fn another_pose_is_found() {
    let at = around(500, 42);
    let Some(gpu) = Posed::new(80.0).gpu(&at) else { return };
    let cpu = Posed::new(80.1).cpu(&at);
    assert!(!parity::vectors("values", &values(&gpu), &values(&cpu), 1.0, FIELD).pass);
}

#[test]
fn twin_is_bounded_and_its_gradient_descends_from_its_value() {
    let posed = Posed::new(60.0);
    let (mut seen, mut rough) = (0, 0);
    for p in around(20_000, 43) {
        let found = posed.field().composed(p.xyz());
        assert!((0.0..=1.0).contains(&found.sample.value) && found.sample.gradient.is_finite());
        // The bone itself has .9 and no direction.
        if !(0.05..0.8).contains(&found.sample.value) {
            continue;
        }
        let h = 2e-4;
        let slope = |axis: Vec3| {
            let value = |q: Vec3| posed.field().composed(q).sample.value;
            (value(p.xyz() + axis * h) - value(p.xyz() - axis * h)) / (2.0 * h)
        };
        let measured = Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z));
        seen += 1;
        rough += usize::from((measured - found.sample.gradient).length() > 0.2 * found.sample.gradient.length());
    }
    // A cell of 8 mm on a radius of 40 mm turns the interpolated value's slope by up to 10 % an axis from the
    // interpolated gradient; the maximum over groups and muscles has creases.
    assert!(seen > 1000 && rough * 50 < seen, "{rough} of {seen}");
}
