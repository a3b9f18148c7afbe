//! What a character is: skeleton, mesh, influences, field groups, muscles; and what one pose makes of it.

mod bone_fields;
mod bones;
mod build;
mod character;
pub mod drive;
mod fold_patch;
mod frame;
pub mod groups;
mod joins;
mod mean_value;
pub mod muscle;
pub mod muscle_file;
mod muscle_joints;
mod muscle_weights;
mod nearest;
pub mod roles;
mod skin_graph;
mod targets;
mod topology;

pub use bones::{BoneCollider, BoneMesh, ColliderShape};
pub use build::{BuildOptions, Rig, SettledPoint};
pub use character::{Character, Image, Influence, Joint, Key, Keyed, Material, Part, Pose};
pub use drive::{Drives, Effort, MuscleParameters, ShapeBlend};
pub use fold_patch::{FoldPatch, FoldTriangle};
pub use frame::{FrameInputs, JointFrame, group_frames};
pub use groups::{FieldGroups, GroupSpec};
pub use joins::Join;
pub use muscle::{Around, Attachment, MuscleShape, MuscleSize, MuscleSpec, Wrap};
pub use muscle_joints::{MuscleJoint, MuscleJoints};
pub use muscle_weights::{MuscleWeights, PaintedMuscle, WeightTarget};
pub use skin_graph::{SkinEdge, SkinGraph};
pub use targets::{NO_JOINT, Reach, Role, Targets, Unheld, VertexTarget, march_order};
pub use topology::Topology;
