//! Muscles as their author gives them, and as the stages read them.

pub(in crate::rig) mod check;
mod lie;
mod resolve;
mod spec;

pub use resolve::resolve;
pub(in crate::rig) use resolve::{find_bone, find_driver_joint, find_joint, find_wrap_joint, rest_input};
pub use spec::{
    Around, Attachment, BodySide, BoneShape, BoneSpec, Collides, Combine, Curve, Drive, Driver, Ease, FibreSet,
    JointSpec, Keys, MarkSpec, MuscleShape, MuscleSize, MuscleSpec, ShapeCurve, Source, Wrap,
};
