//! Which field groups are joined at a joint by an operator of the muscle file.

use super::{
    Character, FieldGroups,
    muscle::{JointSpec, find_joint},
};
use crate::{
    error::JointError,
    field::{compose::JointOperator, evaluate::NO_GROUP},
};

/// Two field groups that meet at a joint, and what joins them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Join {
    /// The group of the joint, and that of the limb that it hangs on.
    pub groups: [u32; 2],
    /// The operator.
    pub operator: JointOperator,
}

/// The groups on either side of every given joint; the last word on two groups counts.
///
/// # Errors
/// A name that the character lacks, or a joint that does not lie between two groups.
pub(super) fn joins(character: &Character, groups: &FieldGroups, specs: &[JointSpec]) -> Result<Vec<Join>, JointError> {
    let group = |j: usize| groups.group_of_joint[j];
    let mut found: Vec<Join> = Vec::new();
    for spec in specs {
        let joint = || spec.joint.clone();
        let at =
            find_joint(&spec.joint, character).map_err(|nearest| JointError::Unknown { joint: joint(), nearest })?;
        let above = |j: &usize| character.joints[*j].parent.map(|p| p as usize);
        let mut chain = std::iter::successors(Some(at), above).skip(1).map(group);
        let (own, other) = (group(at), chain.find(|g| *g != NO_GROUP).unwrap_or(NO_GROUP));
        if own == NO_GROUP || other == NO_GROUP || own == other {
            return Err(JointError::Within { joint: joint() });
        }
        let (groups, operator) = ([own, other], spec.operator);
        found.retain(|join| join.groups != groups);
        found.push(Join { groups, operator });
    }
    found.retain(|join| join.operator != JointOperator::Union);
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::{BuildOptions, Influence, Joint, Rig};
    use glam::{Mat4, Vec2, Vec3};

    /// A tube along Y over an upper bone and a lower one that has a twist joint and a tip, which moves nothing.
    fn limb() -> Character {
        let joint = |name: &str, parent, y: f32| Joint {
            name: name.into(),
            parent,
            node: 0,
            inverse_bind: Mat4::from_translation(Vec3::Y * -y),
        };
        let joints = vec![
            joint("upperarm_l", None, 0.0),
            joint("lowerarm_l", Some(0), 0.3),
            joint("lowerarm_twist_01_l", Some(1), 0.4),
            joint("tip", Some(1), 0.6),
        ];
        let mut c = Character { name: "limb".into(), joints, influence_offsets: vec![0], ..Character::default() };
        for v in 0..24 * 16u32 {
            let (ring, angle) = (v / 16, (v % 16) as f32 / 16.0 * std::f32::consts::TAU);
            let (y, out) = (ring as f32 / 23.0 * 0.6, Vec3::new(angle.cos(), 0.0, angle.sin()));
            c.positions_rest.push(out * 0.04 + Vec3::Y * y);
            c.normals_rest.push(out);
            c.uvs.push(Vec2::ZERO);
            c.influences.push(Influence { joint: if y < 0.3 { 0 } else { 1 + u32::from(y > 0.45) }, weight: 1.0 });
            c.influence_offsets.push(v + 1);
            let corner = |ring: u32, k: u32| ring * 16 + k % 16;
            if ring > 0 {
                let [a, b] = [corner(ring - 1, v), corner(ring - 1, v + 1)];
                c.triangles.extend([[a, v, b], [b, v, corner(ring, v + 1)]]);
            }
        }
        c
    }

    fn built(specs: &[(&str, JointOperator)]) -> Result<Rig, crate::error::RigError> {
        let joints = specs.iter().map(|(joint, operator)| JointSpec { joint: joint.to_string(), operator: *operator });
        Rig::build(limb(), &[], &BuildOptions { joints: joints.collect(), ..BuildOptions::default() })
    }

    #[test]
    fn a_joint_joins_the_groups_on_its_sides() {
        let rig = built(&[("lowerarm_l", JointOperator::Blend), ("lowerarm_l", JointOperator::Bulge)]).expect("a limb");
        let groups = [1, 0].map(|j: usize| rig.groups.group_of_joint[j]);
        assert_ne!(groups[0], groups[1]);
        assert_eq!(rig.joins, [Join { groups, operator: JointOperator::Bulge }], "the last word counts");
        assert_eq!(rig.join(groups[0], groups[1]), JointOperator::Bulge.code());
        assert_eq!(rig.join(groups[1], groups[0]), rig.join(groups[0], groups[1]));
        assert_eq!(rig.join(groups[0], 7), 0);
        let blended = rig.targets.vertices.iter().filter(|t| t.lift != 0.0).count();
        let plain = built(&[("lowerarm_l", JointOperator::Union)]).expect("a limb");
        assert!(plain.joins.is_empty() && plain.targets.vertices.iter().all(|t| t.lift == 0.0));
        // A straight limb's elbow bulges only as far as the union; a blend is wide there.
        let wide = built(&[("lowerarm_l", JointOperator::Blend)]).expect("a limb");
        let wide = wide.targets.vertices.iter().filter(|t| t.lift > 0.01).count();
        assert!(wide > 16 && blended <= wide, "{wide} {blended}");
    }

    #[test]
    fn joints_within_a_group_are_refused() {
        let refused = |joint: &str| match built(&[(joint, JointOperator::Blend)]) {
            Err(crate::error::RigError::Joint(error)) => error,
            other => panic!("{joint}: {other:?}"),
        };
        for joint in ["upperarm_l", "lowerarm_twist_01_l"] {
            assert_eq!(refused(joint), JointError::Within { joint: joint.into() });
        }
        let unknown = refused("lowerar_l").to_string();
        assert!(unknown.contains("`lowerar_l`") && unknown.contains("lowerarm_l"), "{unknown}");
    }
}
