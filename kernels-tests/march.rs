//! `march` against its twin, and the twin against what a march is for.

use crate::support::{JUNK, SIZES, bent, gpu, limb_rig, run};
use glam::{Vec3, Vec4, Vec4Swizzles};
use sinew::{
    parity,
    reference::Reference,
    rig::{FrameInputs, Pose, Rig, VertexTarget},
    schedule::{Counts, FrameOptions, KernelId, MarchOptions},
    tracking::{self, FieldInput, MarchParams, MarchReport, StopReason},
    wrap::{self, ShapeInput},
};

struct March {
    rig: Rig,
    inputs: FrameInputs,
    muscles: Vec<sinew::field::muscle::MuscleFrame>,
    axes: Vec<sinew::field::muscle::AxisPoint>,
    targets: Vec<VertexTarget>,
    skinned: Vec<Vec4>,
}

impl March {
    /// The limb's first `count` active vertices, bent; `count` may be anything.
    fn new(count: usize, degrees: f32) -> March {
        let rig = limb_rig(40);
        let inputs = FrameInputs::new(&rig, &bent(degrees)).expect("pose");
        let mut muscles = vec![Default::default(); rig.muscles.len()];
        let mut axes = vec![Default::default(); rig.point_count as usize];
        let input =
            ShapeInput { joints: &inputs.joints, groups: &inputs.groups, inputs: &inputs.muscles, iterates: &[] };
        wrap::shape(&rig.muscles, &input, &mut muscles, &mut axes);
        let options = FrameOptions { skinning: sinew::schedule::Skinning::Linear, ..FrameOptions::default() };
        let skinned = Reference::new(&rig).frame(&bent(degrees), &options).expect("pose").skinned;
        let chosen: Vec<usize> = (0..skinned.len()).filter(|&v| v % 7 == 3).cycle().take(count).collect();
        let targets = chosen.iter().map(|&v| rig.targets[v]).collect();
        let skinned = chosen.iter().map(|&v| skinned[v]).collect();
        March { rig, inputs, muscles, axes, targets, skinned }
    }

    fn params(&self) -> MarchParams {
        let counts = Counts {
            vertices: self.targets.len() as u32,
            muscles: self.muscles.len() as u32,
            points: self.axes.len() as u32,
            most_segments: 0,
            groups: self.inputs.groups.len() as u32,
        };
        MarchParams::new(&counts, 1, &MarchOptions::default())
    }

    fn cpu(&self) -> (Vec<Vec4>, Vec<MarchReport>) {
        let mut tracked = vec![Vec4::ZERO; self.targets.len()];
        let mut reports = vec![MarchReport::default(); self.targets.len()];
        let field = FieldInput {
            groups: &self.inputs.groups,
            nodes: &self.rig.nodes,
            muscles: &self.muscles,
            axes: &self.axes,
        };
        tracking::march(&self.params(), &field, &self.targets, &self.skinned, &mut tracked, &mut reports);
        (tracked, reports)
    }

    fn gpu(&self) -> Option<(Vec<Vec4>, Vec<MarchReport>)> {
        let gpu = gpu()?;
        let params = self.params();
        let inputs: [(&str, &[u8]); 7] = [
            ("params", bytemuck::bytes_of(&params)),
            ("groups", bytemuck::cast_slice(&self.inputs.groups)),
            ("nodes", bytemuck::cast_slice(&self.rig.nodes)),
            ("muscles", bytemuck::cast_slice(&self.muscles)),
            ("axes", bytemuck::cast_slice(&self.axes)),
            ("targets", bytemuck::cast_slice(&self.targets)),
            ("skinned", bytemuck::cast_slice(&self.skinned)),
        ];
        let count = self.targets.len();
        let outputs = [("tracked", (count + 1) * 16), ("reports", (count + 1) * size_of::<MarchReport>())];
        let out = run(&gpu, KernelId::March, count as u64, &inputs, &outputs);
        let mut tracked: Vec<Vec4> = bytemuck::pod_collect_to_vec(&out[0]);
        let mut reports: Vec<MarchReport> = bytemuck::pod_collect_to_vec(&out[1]);
        assert_eq!(tracked.pop().map(|p| p.x.to_bits()), Some(JUNK), "written beyond the last vertex");
        assert_eq!(reports.pop().map(|r| r.stop), Some(JUNK), "written beyond the last vertex");
        Some((tracked, reports))
    }
}

#[test]
fn matches_its_twin_at_every_size() {
    for size in SIZES.into_iter().chain([3000]) {
        let march = March::new(size, 70.0);
        let Some((gpu, gpu_reports)) = march.gpu() else { return };
        let (cpu, reports) = march.cpu();
        let report = parity::vectors("tracked", &gpu, &cpu, 1.0 / 0.64, parity::TRACKED);
        assert!(report.pass, "size {size}: {report:?}");
        let differ = gpu_reports.iter().zip(&reports).filter(|(g, c)| g.stop != c.stop).count();
        assert!(differ as f32 <= (1.0 - parity::STOP_AGREEMENT) * size as f32, "size {size}: {differ} stop reasons");
    }
}

#[test]
fn another_target_is_found() {
    let march = March::new(65, 70.0);
    let Some((gpu, _)) = march.gpu() else { return };
    let mut changed = March::new(65, 70.0);
    let active = changed.targets.iter().position(|t| t.follows == 1).expect("an active vertex");
    changed.targets[active].iso -= 0.02;
    let report = parity::vectors("tracked", &gpu, &changed.cpu().0, 1.0 / 0.64, parity::TRACKED);
    assert!(!report.pass && report.over == 1 && report.worst == Some(active), "{report:?}");
}

#[test]
fn a_position_that_is_not_finite_stays_and_says_so() {
    let mut march = March::new(64, 70.0);
    let active = march.targets.iter().position(|t| t.follows == 1).expect("an active vertex");
    march.targets[active].iso = f32::NAN;
    let (tracked, reports) = march.cpu();
    assert_eq!(reports[active].stop, StopReason::NonFinite as u32);
    assert_eq!(tracked[active].xyz(), march.skinned[active].xyz());
    let Some((gpu, gpu_reports)) = march.gpu() else { return };
    assert_eq!(gpu_reports[active].stop, StopReason::NonFinite as u32);
    assert_eq!(gpu[active], tracked[active]);
    let neighbours = gpu_reports.iter().enumerate().filter(|(i, _)| *i != active);
    assert!(
        neighbours.clone().count() == 63 && neighbours.into_iter().all(|(_, r)| r.stop != StopReason::NonFinite as u32)
    );
}

#[test]
fn twin_leaves_the_rest_pose_alone_and_passive_vertices_follow_skinning() {
    let rig = limb_rig(40);
    let trace = Reference::new(&rig).frame(&Pose::rest(&rig.character), &FrameOptions::default()).expect("pose");
    assert!(rig.active_count() * 10 > rig.targets.len() * 7, "{} active", rig.active_count());
    for (v, (tracked, rest)) in trace.tracked.iter().zip(&rig.positions_rest).enumerate() {
        assert!((*tracked - *rest).length() < 1e-5 * 0.64, "vertex {v} moved by {}", (*tracked - *rest).length());
    }
    let trace = Reference::new(&rig).frame(&bent(90.0), &FrameOptions::default()).expect("pose");
    for (v, target) in rig.targets.iter().enumerate().filter(|(_, t)| t.follows == 0) {
        assert_eq!(trace.tracked[v], trace.skinned[v], "{target:?}");
    }
}

#[test]
fn twin_reaches_its_targets_and_lifts_skin_over_the_muscle() {
    let march = March::new(3000, 60.0);
    let (tracked, reports) = march.cpu();
    let active = march.targets.iter().filter(|t| t.follows == 1).count();
    let arrived = reports.iter().filter(|r| r.stop == StopReason::Converged as u32).count();
    assert!(arrived * 100 > active * 90, "{arrived} of {active} arrived");
    assert!(reports.iter().all(|r| r.stop != StopReason::Converged as u32 || r.residual.abs() < 1e-4));
    let moved = tracked.iter().zip(&march.skinned).map(|(t, s)| (*t - *s).length()).fold(0.0, f32::max);
    assert!((0.001..0.05).contains(&moved), "the furthest vertex moved by {moved} m");
    let front = Vec3::new(0.0, 0.15, 0.05);
    let with = march.cpu_value(front);
    let without =
        March { muscles: vec![Default::default(); march.muscles.len()], ..March::new(1, 60.0) }.cpu_value(front);
    assert!(with > without, "the muscle adds to the field in front of the bone: {with} {without}");
}

impl March {
    fn cpu_value(&self, p: Vec3) -> f32 {
        FieldInput { groups: &self.inputs.groups, nodes: &self.rig.nodes, muscles: &self.muscles, axes: &self.axes }
            .composed(p)
            .sample
            .value
    }
}
