//! A kernel's WGSL, assembled by concatenation, with a map from its lines back to the files they came from.

use super::{Kernel, SharedStruct, WORKGROUP};
use crate::field::{
    compose, evaluate, fold,
    muscle::{self, axis, wrap},
};
use crate::{dynamics, math};
use std::ops::Range;

/// Shared WGSL.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// The file, relative to the repository.
    pub file: &'static str,
    /// Its text.
    pub text: &'static str,
    /// Its WGSL overrides, with the host's values.
    pub constants: &'static [Constant],
}

/// A WGSL override and the host's value for it: no number that decides anything is written twice.
pub type Constant = (&'static str, f64);

/// Thread indices of folded dispatches.
pub const DISPATCH: Part = Part {
    file: "shaders/shared/dispatch.wgsl",
    text: include_str!("../../shaders/shared/dispatch.wgsl"),
    constants: &[("DISPATCH_WORKGROUP", WORKGROUP as f64)],
};
/// Vector helpers.
pub const MATH: Part =
    Part { file: "shaders/shared/math.wgsl", text: include_str!("../../shaders/shared/math.wgsl"), constants: &[] };
/// Inverses of affine maps.
pub const INVERSE: Part = Part {
    file: "shaders/shared/inverse.wgsl",
    text: include_str!("../../shaders/shared/inverse.wgsl"),
    constants: &[("INVERSE_FLAT", math::FLAT as f64)],
};
/// Offsets beside folding joints.
pub const FOLD: Part = Part {
    file: "shaders/shared/fold.wgsl",
    text: include_str!("../../shaders/shared/fold.wgsl"),
    constants: &[("FOLD_SPREAD", fold::SPREAD as f64), ("FOLD_LEAST_RADIUS", fold::LEAST_RADIUS as f64)],
};
/// Unit quaternions.
pub const QUATERNION: Part = Part {
    file: "shaders/shared/quaternion.wgsl",
    text: include_str!("../../shaders/shared/quaternion.wgsl"),
    constants: &[],
};
/// From raw distance to a compact field.
pub const TRANSFER: Part = Part {
    file: "shaders/shared/transfer.wgsl",
    text: include_str!("../../shaders/shared/transfer.wgsl"),
    constants: &[],
};
/// Frames of a muscle's axis.
pub const AXIS: Part = Part {
    file: "shaders/shared/axis.wgsl",
    text: include_str!("../../shaders/shared/axis.wgsl"),
    constants: &[
        ("AXIS_CLEAR_TURN", axis::CLEAR_TURN as f64),
        ("AXIS_CLEAR_SHARE", axis::CLEAR_SHARE as f64),
        ("AXIS_NO_DIRECTION", axis::NO_DIRECTION as f64),
        ("AXIS_SMOOTHING", muscle::SMOOTHING as f64),
    ],
};
/// A string round a circle.
pub const CIRCLE: Part = Part {
    file: "shaders/shared/circle.wgsl",
    text: include_str!("../../shaders/shared/circle.wgsl"),
    constants: &[("CIRCLE_CLEARANCE", wrap::CLEARANCE as f64), ("CIRCLE_POINT", wrap::POINT as f64)],
};
/// A path past an obstacle.
pub const PATH: Part =
    Part { file: "shaders/shared/path.wgsl", text: include_str!("../../shaders/shared/path.wgsl"), constants: &[] };
/// Paths round joints and bones.
pub const WRAP: Part = Part {
    file: "shaders/shared/wrap.wgsl",
    text: include_str!("../../shaders/shared/wrap.wgsl"),
    constants: &[("WRAP_HOLD", wrap::HOLD as f64), ("WRAP_SHORT", wrap::SHORT as f64)],
};
/// A muscle's path in a pose.
pub const COURSE: Part = Part {
    file: "shaders/shared/course.wgsl",
    text: include_str!("../../shaders/shared/course.wgsl"),
    constants: &[
        ("COURSE_REST_SHARE", wrap::REST_SHARE as f64),
        ("COURSE_TENDON_STIFFNESS", wrap::TENDON_STIFFNESS as f64),
    ],
};
/// A muscle's paths in a substep.
pub const COURSES: Part = Part {
    file: "shaders/shared/courses.wgsl",
    text: include_str!("../../shaders/shared/courses.wgsl"),
    constants: &[],
};
/// The nearest segment of a muscle's axis.
pub const NEAREST: Part = Part {
    file: "shaders/shared/nearest.wgsl",
    text: include_str!("../../shaders/shared/nearest.wgsl"),
    constants: &[("NEAREST_KEY_BITS", muscle::KEY_BITS as f64)],
};
/// A muscle's profile.
pub const PROFILE: Part = Part {
    file: "shaders/shared/profile.wgsl",
    text: include_str!("../../shaders/shared/profile.wgsl"),
    constants: &[],
};
/// Projection on a muscle's axis.
pub const MUSCLE: Part = Part {
    file: "shaders/shared/muscle.wgsl",
    text: include_str!("../../shaders/shared/muscle.wgsl"),
    constants: &[("MUSCLE_NO_DIRECTION", axis::NO_DIRECTION as f64)],
};
/// A muscle's compact field.
pub const MUSCLE_FIELD: Part = Part {
    file: "shaders/shared/muscle_field.wgsl",
    text: include_str!("../../shaders/shared/muscle_field.wgsl"),
    constants: &[],
};
/// Cached distance fields.
pub const GRID: Part =
    Part { file: "shaders/shared/grid.wgsl", text: include_str!("../../shaders/shared/grid.wgsl"), constants: &[] };
/// Where a muscle stands among the iterates of the dynamics.
pub const RUN: Part =
    Part { file: "shaders/shared/run.wgsl", text: include_str!("../../shaders/shared/run.wgsl"), constants: &[] };
/// Contacts of a particle.
pub const TOUCH: Part = Part {
    file: "shaders/shared/touch.wgsl",
    text: include_str!("../../shaders/shared/touch.wgsl"),
    constants: &[("TOUCH_NOTHING", f32::MAX as f64)],
};
/// A muscle's springs and planes.
pub const CHAIN: Part = Part {
    file: "shaders/shared/chain.wgsl",
    text: include_str!("../../shaders/shared/chain.wgsl"),
    constants: &[
        ("CHAIN_JACOBI_SHARE", dynamics::JACOBI_SHARE as f64),
        ("CHAIN_NO_DIRECTION", dynamics::NO_DIRECTION as f64),
        ("CHAIN_THREADS", super::muscle_project::THREADS as f64),
    ],
};
/// What holds one muscle.
pub const HOLD: Part = Part {
    file: "shaders/shared/hold.wgsl",
    text: include_str!("../../shaders/shared/hold.wgsl"),
    constants: &[
        ("HOLD_BONES", dynamics::BONES as f64),
        ("HOLD_MUSCLES", dynamics::MUSCLES as f64),
        ("HOLD_SKIN", dynamics::SKIN as f64),
    ],
};
/// The contact passes that end a substep.
pub const SETTLE: Part = Part {
    file: "shaders/shared/settle.wgsl",
    text: include_str!("../../shaders/shared/settle.wgsl"),
    constants: &[
        ("SETTLE_LEAST_TURN", dynamics::LEAST_TURN as f64),
        ("SETTLE_LEAST_WAY_SQUARED", dynamics::LEAST_WAY_SQUARED as f64),
    ],
};
/// A particle against another muscle's axis.
pub const PEER_AXIS: Part = Part {
    file: "shaders/shared/peer_axis.wgsl",
    text: include_str!("../../shaders/shared/peer_axis.wgsl"),
    constants: &[],
};
/// What holds a muscle against its neighbours.
pub const PEERS: Part = Part {
    file: "shaders/shared/peers.wgsl",
    text: include_str!("../../shaders/shared/peers.wgsl"),
    constants: &[("PEER_FACING", dynamics::FACING as f64), ("PEER_TURN", dynamics::TURN as f64)],
};
/// Composition of fields.
pub const FIELD: Part = Part {
    file: "shaders/shared/field.wgsl",
    text: include_str!("../../shaders/shared/field.wgsl"),
    constants: &[
        ("FIELD_NO_GROUP", evaluate::NO_GROUP as f64),
        ("FIELD_SATURATION", compose::SATURATION as f64),
        ("FIELD_HEADROOM", compose::HEADROOM as f64),
        ("FIELD_FILLET", compose::FILLET as f64),
    ],
};

/// The clean union of two fields.
pub const CLEAN_UNION: Part = Part {
    file: "shaders/shared/clean_union.wgsl",
    text: include_str!("../../shaders/shared/clean_union.wgsl"),
    constants: &[
        ("CLEAN_SURFACE", compose::SURFACE as f64),
        ("CLEAN_SMALL", compose::SMALL as f64),
        ("CLEAN_ITERATIONS", compose::ITERATIONS as f64),
    ],
};
/// Operators that join two limbs.
pub const JOINT: Part = Part {
    file: "shaders/shared/joint.wgsl",
    text: include_str!("../../shaders/shared/joint.wgsl"),
    constants: &[
        ("JOINT_CLOSED", compose::CLOSED as f64),
        ("JOINT_PIECES", compose::PIECES as f64),
        ("JOINT_UNION", compose::PROFILE_UNION as f64),
        ("JOINT_BULGE", compose::PROFILE_BULGE as f64),
        ("JOINT_SURFACE", compose::SURFACE as f64),
        ("JOINT_STEPS", compose::STEPS as f64),
    ],
};

/// A vertex's own side of a contact.
pub const CONTACT: Part = Part {
    file: "shaders/shared/contact.wgsl",
    text: include_str!("../../shaders/shared/contact.wgsl"),
    constants: &[
        ("CONTACT_AGREE", evaluate::CONTACT_AGREE as f64),
        ("CONTACT_TURN", evaluate::CONTACT_TURN as f64),
        ("CONTACT_APART", evaluate::APART as f64),
        ("CONTACT_CODE_SHIFT", compose::CODE_SHIFT as f64),
    ],
};

/// Every shared part.
pub const PARTS: [Part; 28] = [
    DISPATCH,
    MATH,
    INVERSE,
    FOLD,
    QUATERNION,
    TRANSFER,
    AXIS,
    CIRCLE,
    PATH,
    WRAP,
    COURSE,
    COURSES,
    NEAREST,
    PROFILE,
    MUSCLE,
    MUSCLE_FIELD,
    GRID,
    FIELD,
    CLEAN_UNION,
    JOINT,
    CONTACT,
    RUN,
    TOUCH,
    CHAIN,
    PEER_AXIS,
    PEERS,
    HOLD,
    SETTLE,
];

/// An assembled kernel.
#[derive(Clone, Debug)]
pub struct Assembled {
    /// The whole WGSL text.
    pub text: String,
    /// Which lines, from 1, came from which file.
    pub files: Vec<(String, Range<usize>)>,
}

impl Assembled {
    /// The file and its own line, from 1, that a line of the whole text came from.
    pub fn locate(&self, line: usize) -> Option<(&str, usize)> {
        self.files
            .iter()
            .find(|(_, lines)| lines.contains(&line))
            .map(|(file, lines)| (file.as_str(), line - lines.start + 1))
    }
}

/// Joins the host's structs, the shared parts and the kernel's own file.
pub fn assemble(kernel: &Kernel) -> Assembled {
    let structs: String = kernel.structs.iter().map(|s: &SharedStruct| (s.wgsl)()).collect();
    let own = format!("shaders/kernels/{}.wgsl", kernel.stem);
    let pieces = std::iter::once(("structs shared with the host".to_owned(), structs.as_str()))
        .chain(kernel.parts.iter().map(|part| (part.file.to_owned(), part.text)))
        .chain(std::iter::once((own, kernel.source)));
    let mut assembled = Assembled { text: String::new(), files: Vec::new() };
    let mut line = 1;
    for (file, text) in pieces {
        assembled.text.push_str(text);
        if !text.is_empty() && !text.ends_with('\n') {
            assembled.text.push('\n');
        }
        let next = assembled.text.lines().count() + 1;
        assembled.files.push((file, line..next));
        line = next;
    }
    assembled
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::KERNELS;

    #[test]
    fn lines_lead_back_to_their_files() {
        for kernel in &KERNELS {
            let assembled = assemble(kernel);
            for (number, line) in assembled.text.lines().enumerate() {
                let (file, own) = assembled.locate(number + 1).expect("every line has a file");
                let source = if file.starts_with("shaders/kernels") {
                    kernel.source
                } else if let Some(part) = PARTS.iter().find(|p| p.file == file) {
                    part.text
                } else {
                    continue;
                };
                assert_eq!(source.lines().nth(own - 1), Some(line), "{file}:{own}");
            }
            assert_eq!(assembled.locate(assembled.text.lines().count() + 1), None);
        }
    }
}
