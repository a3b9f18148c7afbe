//! A frame's schedule as people read it: what repeats is written once (paper A, figure 10).

use super::{KernelId, Step};

/// One entry of a schedule whose repetitions have been folded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Entry {
    /// One dispatch.
    Step {
        /// What runs.
        kernel: KernelId,
        /// Threads per instance.
        items: u32,
        /// Whether it is of the tracker's last passes.
        projects: bool,
        /// Whether it carries joints and axes on to the frame, rather than through a substep.
        carries: bool,
    },
    /// Entries that follow each other several times.
    Repeat {
        /// How often.
        times: u32,
        /// What repeats.
        entries: Vec<Entry>,
    },
}

impl KernelId {
    /// Its name as its files have it.
    pub fn name(self) -> String {
        let mut name = String::new();
        for letter in format!("{self:?}").chars() {
            if letter.is_uppercase() && !name.is_empty() {
                name.push('_');
            }
            name.push(letter.to_ascii_lowercase());
        }
        name
    }
}

/// Folds what repeats in a schedule. Buffers, sub-poses and outer iterations, which differ from one repetition to the next, are
/// left out.
pub fn outline(steps: &[Step]) -> Vec<Entry> {
    let entry = |s: &Step| Entry::Step { kernel: s.kernel, items: s.items, projects: s.projects, carries: s.carries };
    let mut entries: Vec<Entry> = steps.iter().map(entry).collect();
    let mut length = 1;
    while 2 * length <= entries.len() {
        let before = entries.len();
        entries = folded(&entries, length);
        // What has been folded may repeat in shorter blocks than it did.
        length = if entries.len() < before { 1 } else { length + 1 };
    }
    entries
}

/// Folds blocks of one length.
fn folded(entries: &[Entry], length: usize) -> Vec<Entry> {
    let mut result = Vec::new();
    let mut at = 0;
    while at < entries.len() {
        let block = entries.get(at..at + length);
        let same = |k: &usize| block.is_some() && entries.get(at + k * length..at + (k + 1) * length) == block;
        let times = (1..).take_while(same).count() + 1;
        match block {
            Some(block) if times > 1 => {
                result.push(Entry::Repeat { times: times as u32, entries: block.to_vec() });
                at += times * length;
            }
            _ => {
                result.push(entries[at].clone());
                at += 1;
            }
        }
    }
    result
}

impl Entry {
    /// In one line: `5 x { track_fold, track_march, track_turn, track_span, 4 x track_slide }`.
    pub fn line(&self) -> String {
        match self {
            Entry::Step { kernel, .. } => kernel.name(),
            Entry::Repeat { times, entries } => match &entries[..] {
                [one @ Entry::Step { .. }] => format!("{times} x {}", one.line()),
                several => format!("{times} x {{ {} }}", lines(several)),
            },
        }
    }

    /// Dispatches in it.
    pub fn dispatches(&self) -> u32 {
        match self {
            Entry::Step { .. } => 1,
            Entry::Repeat { times, entries } => times * entries.iter().map(Entry::dispatches).sum::<u32>(),
        }
    }
}

fn lines(entries: &[Entry]) -> String {
    entries.iter().map(Entry::line).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::super::{Counts, DynamicsOptions, FrameOptions, frame};
    use super::*;

    fn steps(sub_poses: u32) -> Vec<Step> {
        let counts = Counts {
            vertices: 9,
            marched: 9,
            joints: 2,
            muscles: 2,
            points: 8,
            most_segments: 3,
            groups: 2,
            reaches: 5,
            folds: 1,
        };
        let options = FrameOptions { dynamics: Some(DynamicsOptions::default()), ..FrameOptions::default() };
        frame(&counts, &options, 8, sub_poses)
    }

    #[test]
    fn a_frame_is_read_in_a_few_lines() {
        let entries = outline(&steps(3));
        assert_eq!(
            entries.iter().map(Entry::line).collect::<Vec<_>>(),
            [
                "8 x { joint_step, muscle_predict, 2 x muscle_project }",
                "joint_step",
                "muscle_predict",
                "muscle_shape",
                "group_bound",
                "3 x { track_carry, track_place, 5 x { track_fold, track_march, track_turn, track_span, 4 x track_slide } }",
                "6 x track_march",
                "track_spread",
                "normals",
            ]
        );
        assert_ne!(outline(&steps(2)), entries, "another number of sub-poses must be seen");
    }

    #[test]
    fn nothing_is_lost_in_folding() {
        fn unfolded(entries: &[Entry], found: &mut Vec<KernelId>) {
            for entry in entries {
                match entry {
                    Entry::Step { kernel, .. } => found.push(*kernel),
                    Entry::Repeat { times, entries } => (0..*times).for_each(|_| unfolded(entries, found)),
                }
            }
        }
        for sub_poses in [0, 1, 2, 18] {
            let steps = steps(sub_poses);
            let entries = outline(&steps);
            let mut found = Vec::new();
            unfolded(&entries, &mut found);
            assert_eq!(found, steps.iter().map(|s| s.kernel).collect::<Vec<_>>());
            assert_eq!(entries.iter().map(Entry::dispatches).sum::<u32>() as usize, steps.len());
        }
    }

    #[cfg(feature = "gpu")]
    #[test]
    fn kernels_go_by_the_names_of_their_files() {
        for kernel in crate::kernel::KERNELS {
            assert_eq!(kernel.id.name(), kernel.stem);
        }
    }
}
