//! Attack and decay: activation that cannot change at once.

use super::Drives;
use crate::error::PoseError;
use crate::rig::Pose;

/// Steps a second at which activation is limited, whatever the frame rate: those of the dynamics.
const STEPS: f64 = 240.0;
/// Seconds between two poses that are still one motion.
const LONGEST: f64 = 1.0;

/// The effort of every muscle of one character in motion: the state behind attack and decay.
///
/// A clone is a checkpoint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Effort {
    time: f64,
    /// What drivers and keys asked for at `time`.
    targets: Vec<f32>,
    /// What attack and decay let through at `time`.
    activations: Vec<f32>,
}

impl Effort {
    /// Nothing has moved yet.
    pub fn new() -> Effort {
        Effort::default()
    }

    /// Forgets the motion: the next call starts anew.
    pub fn reset(&mut self) {
        *self = Effort::default();
    }

    /// Goes on to the pose's time and writes [`Pose::activations`].
    ///
    /// Each activation follows what drivers and keys say, straight from the last call's pose to this one's, but rises by
    /// no more than one per `attack` seconds and falls by no more than one per `decay`, in steps that end at whole
    /// 1/240 s and at the pose: so the result hardly depends on how often this is called. A muscle whose attack and decay
    /// are 0 passes through as it is. The first call, and one that is earlier than the last or more than a second later,
    /// starts at what drivers and keys say. Activations that the pose already has stand in for those, so empty them where
    /// a pose is used again.
    ///
    /// # Errors
    /// As [`Drives::parameters`]; nothing has changed then.
    pub fn advance(&mut self, drives: &Drives, pose: &mut Pose, ratios: &[f32]) -> Result<(), PoseError> {
        let targets: Vec<f32> = drives.parameters(pose, ratios)?.iter().map(|p| p.activation).collect();
        let time = f64::from(pose.time);
        let seconds = time - self.time;
        // NaN is in no range.
        if self.targets.len() == targets.len() && (0.0..=LONGEST).contains(&seconds) {
            for (muscle, (activation, &target)) in self.activations.iter_mut().zip(&targets).enumerate() {
                *activation = match drives.attack_and_decay(muscle) {
                    (0.0, 0.0) => target,
                    limits => limited(*activation, limits, (self.time, self.targets[muscle]), (time, target)),
                };
            }
        } else {
            self.activations.clone_from(&targets);
        }
        self.targets = targets;
        self.time = time;
        pose.activations.clone_from(&self.activations);
        Ok(())
    }
}

/// Where an activation arrives that follows a target from one moment, time and target, to another.
fn limited(start: f32, (attack, decay): (f32, f32), from: (f64, f32), to: (f64, f32)) -> f32 {
    if from.0 >= to.0 {
        return start;
    }
    // A limit of 0 s is none; a target moves by 1 at most.
    let most = |seconds: f64, limit: f32| if limit == 0.0 { 1.0 } else { seconds as f32 / limit };
    let mut activation = start;
    let mut now = from.0;
    // Times that are a second apart at most are small enough to count steps at.
    let steps = (now * STEPS).floor() as i64..=(to.0 * STEPS).ceil() as i64;
    for next in steps.map(|step| (step as f64 / STEPS).min(to.0)) {
        if next > now {
            let share = ((next - from.0) / (to.0 - from.0)) as f32;
            let target = from.1 + (to.1 - from.1) * share;
            let (fall, rise) = (most(next - now, decay), most(next - now, attack));
            activation = target.clamp(activation - fall, activation + rise);
            now = next;
        }
    }
    activation.clamp(0.0, 1.0)
}
