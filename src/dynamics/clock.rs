//! Which substeps a frame has.

use super::joints;
use crate::rig::JointFrame;
use crate::schedule::DynamicsOptions;

crate::gpu_struct! {
    /// One instance's substeps of one frame.
    pub struct StepClock {
        /// Share of the way from the last substep's pose to the frame's at which the frame's first substep ends.
        pub first: f32,
        /// Share from one substep to the next.
        pub step: f32,
        /// Substeps of the frame.
        pub turns: u32,
        /// Substeps of it that are done.
        pub turn: u32,
        /// First substeps of the frame in which the muscles settle, and no velocity outlives a substep.
        pub settling: u32,
        /// Substeps since the motion began, at the frame's start.
        pub age: u32,
        /// Substeps over which velocities come to their full life.
        pub fade: u32,
        /// Share of a velocity relative to the bones that outlives a substep, in the end.
        pub full_retention: f32,
    }
}

impl StepClock {
    /// Share of a velocity relative to the bones that outlives the present substep.
    pub fn retention(&self) -> f32 {
        if self.turn < self.settling {
            return 0.0;
        }
        let age = (self.age + self.turn - self.settling) as f32;
        self.full_retention * (age / self.fade.max(1) as f32).min(1.0)
    }
}

/// Seconds between two poses that are still one motion; what is longer, or goes back, begins anew.
const LONGEST: f64 = 1.0;
/// Share of a substep by which a frame may miss its end and still be on it.
const ON_STEP: f64 = 1e-3;

/// The time of one instance: at which substep it stands, and where its joints were then. A clone is a checkpoint.
#[derive(Clone, Debug, Default)]
pub struct Clock {
    /// Substep that was simulated last, counted from time 0; none before the first frame.
    at: Option<i64>,
    /// Substeps since the motion began.
    age: u32,
    /// Joints at the end of the last substep.
    joints: Vec<JointFrame>,
}

/// What a frame asks of the dynamics.
#[derive(Clone, Debug, Default)]
pub struct Turn {
    /// Its substeps.
    pub clock: StepClock,
    /// Whether muscles start from rest.
    pub starts: bool,
    /// Joints at the end of the last substep before the frame.
    pub joints_before: Vec<JointFrame>,
}

impl Clock {
    /// Forgets the motion: the next frame starts anew, as after a teleport.
    pub fn reset(&mut self) {
        *self = Clock::default();
    }

    /// Goes on to a frame at `time`, seconds, with its joints.
    ///
    /// The first frame, and one that is earlier than the last or more than a second later, starts anew: muscles settle in
    /// its pose for a while without any motion, then their velocities are let in gradually.
    pub fn advance(&mut self, time: f64, joints: &[JointFrame], options: &DynamicsOptions) -> Turn {
        let rate = f64::from(options.rate);
        let exact = time * rate;
        let last = (exact + ON_STEP).floor();
        let starts = self.at.is_none_or(|at| {
            let steps = exact - at as f64;
            !(-ON_STEP..=LONGEST * rate + 1.0).contains(&steps) || self.joints.len() != joints.len()
        });
        let retention = options.retention.powf(60.0 / options.rate as f32);
        let fade = (options.fade * options.rate as f32).round() as u32;
        if starts {
            let settling = (options.settle * options.rate as f32).round().max(0.0) as u32;
            *self = Clock { at: Some(last as i64), age: 0, joints: joints.to_vec() };
            // Joints stand still while muscles settle, so that no share matters.
            let clock =
                StepClock { turns: settling, settling, fade, full_retention: retention, ..StepClock::default() };
            return Turn { clock, starts, joints_before: joints.to_vec() };
        }
        let at = self.at.unwrap_or_default() as f64;
        let turns = (last - at).max(0.0) as u32;
        let span = (exact - at).max(ON_STEP);
        let on_step = (exact - last).abs() <= ON_STEP;
        let span = if on_step { (last - at).max(1.0) } else { span };
        let share = (1.0 / span) as f32;
        let clock = StepClock {
            first: share,
            step: share,
            turns,
            turn: 0,
            settling: 0,
            age: self.age,
            fade,
            full_retention: retention,
        };
        let before = std::mem::replace(&mut self.joints, joints.to_vec());
        if !on_step || turns == 0 {
            let reached = share * turns as f32;
            let pairs = before.iter().zip(joints);
            self.joints = pairs.map(|(before, now)| joints::frame_between(before, now, reached)).collect();
        }
        self.at = Some(last as i64);
        self.age = self.age.saturating_add(turns);
        Turn { clock, starts, joints_before: before }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat4;

    fn joints(x: f32) -> Vec<JointFrame> {
        let matrix = Mat4::from_translation(glam::Vec3::X * x);
        vec![JointFrame { matrix, real: glam::Vec4::W, stretch: Mat4::IDENTITY, ..JointFrame::default() }]
    }

    fn turns(clock: &mut Clock, time: f64) -> Turn {
        clock.advance(time, &joints(time as f32), &DynamicsOptions::default())
    }

    #[test]
    fn substeps_end_at_whole_multiples_at_every_frame_rate() {
        for fps in [24.0, 25.0, 29.97, 30.0, 50.0, 60.0, 144.0, 500.0] {
            let mut clock = Clock::default();
            assert!(turns(&mut clock, 0.0).starts);
            let mut sum = 0;
            for frame in 1..=fps as u32 {
                let time = f64::from(frame) / fps;
                let turn = turns(&mut clock, time);
                assert!(!turn.starts);
                sum += turn.clock.turns;
                // Where the joints were when the last substep ended, which is where they are straight on their way.
                let at = clock.joints[0].matrix.w_axis.x;
                let ended = f64::from(sum) / 240.0;
                assert!((f64::from(at) - ended).abs() < 2e-6, "{fps}: {at} {ended}");
                assert!(time - ended < 1.0 / 240.0 + 1e-9 && time - ended > -1e-5, "{fps}: {time} {ended}");
            }
        }
    }

    #[test]
    fn motion_starts_at_rest_and_fades_in() {
        let mut clock = Clock::default();
        let start = turns(&mut clock, 2.0);
        assert_eq!((start.clock.turns, start.clock.settling), (120, 120));
        assert_eq!(StepClock { turn: 119, ..start.clock }.retention(), 0.0);
        let first = turns(&mut clock, 2.0 + 1.0 / 30.0).clock;
        assert_eq!((first.turns, first.retention()), (8, 0.0));
        let full = 0.9f32.powf(0.25);
        let last = StepClock { turn: 7, ..turns(&mut clock, 2.5).clock };
        assert!(last.retention() < full && (0.2..0.5).contains(&(last.retention() / full)), "{}", last.retention());
        let later = turns(&mut clock, 2.6).clock;
        assert_eq!(StepClock { turn: 0, ..later }.retention(), full);
    }

    #[test]
    fn what_is_no_motion_starts_anew() {
        let mut clock = Clock::default();
        turns(&mut clock, 1.0);
        assert!(!turns(&mut clock, 1.0).starts, "the same moment again");
        assert!(!turns(&mut clock, 2.0).starts, "a second later");
        assert!(turns(&mut clock, 1.9).starts, "back");
        assert!(turns(&mut clock, 3.5).starts, "far on");
        clock.reset();
        assert!(turns(&mut clock, 3.51).starts, "after a reset");
        assert!(clock.advance(3.52, &[joints(0.0), joints(1.0)].concat(), &DynamicsOptions::default()).starts);
    }
}
