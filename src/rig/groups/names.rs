//! What a joint's name says about the body: part, side, and whether it moves skin at all.
//!
//! Vocabulary of the rigs in use: MakeHuman, Unreal, Mixamo, Biped, Daz, SMPL, CMU's BVH, Rigify. Anything else is
//! left to the structure of the skeleton.

/// A part of the body that has one field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum BodyPart {
    /// Pelvis, spine, clavicles and breasts.
    Trunk,
    /// The neck.
    Neck,
    /// Head and face.
    Head,
    /// Shoulder joint to elbow.
    UpperArm,
    /// Elbow to wrist.
    Forearm,
    /// Hand and fingers.
    Hand,
    /// Hip to knee.
    Thigh,
    /// Knee to ankle.
    Calf,
    /// Foot and toes.
    Foot,
}

impl BodyPart {
    /// The name of the part's field group, without its side.
    pub fn name(self) -> &'static str {
        match self {
            BodyPart::Trunk => "trunk",
            BodyPart::Neck => "neck",
            BodyPart::Head => "head",
            BodyPart::UpperArm => "upperarm",
            BodyPart::Forearm => "forearm",
            BodyPart::Hand => "hand",
            BodyPart::Thigh => "thigh",
            BodyPart::Calf => "calf",
            BodyPart::Foot => "foot",
        }
    }

    /// Whether the part ends a limb or the trunk: every joint below belongs to it, whatever its name.
    pub fn is_end(self) -> bool {
        matches!(self, BodyPart::Head | BodyPart::Hand | BodyPart::Foot)
    }

    /// Whether the part lies on the body's middle and has no side.
    pub fn is_middle(self) -> bool {
        matches!(self, BodyPart::Trunk | BodyPart::Neck | BodyPart::Head)
    }

    /// The part that this one hangs on.
    pub fn above(self) -> Option<BodyPart> {
        match self {
            BodyPart::Trunk => None,
            BodyPart::Thigh | BodyPart::Neck | BodyPart::UpperArm => Some(BodyPart::Trunk),
            BodyPart::Head => Some(BodyPart::Neck),
            BodyPart::Forearm => Some(BodyPart::UpperArm),
            BodyPart::Hand => Some(BodyPart::Forearm),
            BodyPart::Calf => Some(BodyPart::Thigh),
            BodyPart::Foot => Some(BodyPart::Calf),
        }
    }
}

/// Side of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// The character's left.
    Left,
    /// The character's right.
    Right,
}

/// What a name says, before the skeleton is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    /// Exactly this part.
    Part(BodyPart),
    /// Some part of the trunk: its height decides.
    Spine,
    /// `shoulder`: the clavicle, or the upper arm where joints are named after joints.
    Shoulder,
    /// `arm`: its place in the chain decides.
    Arm,
    /// `leg`: its place in the chain decides.
    Leg,
    /// Nothing that is known.
    Unknown,
}

/// A name read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Reading {
    /// The part.
    pub word: Word,
    /// The side, where the name has one.
    pub side: Option<Side>,
    /// A twist joint: it belongs to the limb bone before it.
    pub twist: bool,
    /// An animator's handle that moves no skin.
    pub control: bool,
}

/// Tokens that say nothing about the body.
const FILLER: &[&str] = &[
    "skeleton",
    "armature",
    "joint",
    "jnt",
    "bone",
    "def",
    "org",
    "bip",
    "biped",
    "mixamorig",
    "valve",
    "rig",
    "cc",
    "base",
    "b",
    "j",
    "bn",
    "sk",
    "skin",
    "main",
];
const TWIST: &[&str] = &["twist", "roll", "tw"];
const CONTROL: &[&str] = &["ik", "fk", "pole", "target", "ctrl", "control", "controller", "handle"];
/// Words that count where they stand alone, as the text inside others is common.
const ALONE: &[(&str, Word)] = &[
    ("index", Word::Part(BodyPart::Hand)),
    ("middle", Word::Part(BodyPart::Hand)),
    ("ring", Word::Part(BodyPart::Hand)),
    ("little", Word::Part(BodyPart::Hand)),
    ("ball", Word::Part(BodyPart::Foot)),
    ("radius", Word::Part(BodyPart::Forearm)),
    ("rib", Word::Part(BodyPart::Trunk)),
    ("ribs", Word::Part(BodyPart::Trunk)),
    ("body", Word::Spine),
    ("back", Word::Spine),
    ("arms", Word::Arm),
    ("legs", Word::Leg),
];
/// Words that count anywhere in a name, the more specific ones first.
const INSIDE: &[(&str, Word)] = &[
    ("wrist", Word::Part(BodyPart::Hand)),
    ("hand", Word::Part(BodyPart::Hand)),
    ("palm", Word::Part(BodyPart::Hand)),
    ("carpal", Word::Part(BodyPart::Hand)),
    ("finger", Word::Part(BodyPart::Hand)),
    ("thumb", Word::Part(BodyPart::Hand)),
    ("pink", Word::Part(BodyPart::Hand)),
    ("foot", Word::Part(BodyPart::Foot)),
    ("feet", Word::Part(BodyPart::Foot)),
    ("ankle", Word::Part(BodyPart::Foot)),
    ("toe", Word::Part(BodyPart::Foot)),
    ("heel", Word::Part(BodyPart::Foot)),
    ("metatars", Word::Part(BodyPart::Foot)),
    ("forearm", Word::Part(BodyPart::Forearm)),
    ("lowerarm", Word::Part(BodyPart::Forearm)),
    ("lowarm", Word::Part(BodyPart::Forearm)),
    ("elbow", Word::Part(BodyPart::Forearm)),
    ("ulna", Word::Part(BodyPart::Forearm)),
    ("upperarm", Word::Part(BodyPart::UpperArm)),
    ("uparm", Word::Part(BodyPart::UpperArm)),
    ("shldr", Word::Part(BodyPart::UpperArm)),
    ("humerus", Word::Part(BodyPart::UpperArm)),
    ("calf", Word::Part(BodyPart::Calf)),
    ("shin", Word::Part(BodyPart::Calf)),
    ("knee", Word::Part(BodyPart::Calf)),
    ("tibia", Word::Part(BodyPart::Calf)),
    ("lowerleg", Word::Part(BodyPart::Calf)),
    ("lowleg", Word::Part(BodyPart::Calf)),
    ("thigh", Word::Part(BodyPart::Thigh)),
    ("upperleg", Word::Part(BodyPart::Thigh)),
    ("upleg", Word::Part(BodyPart::Thigh)),
    ("femur", Word::Part(BodyPart::Thigh)),
    ("neck", Word::Part(BodyPart::Neck)),
    ("head", Word::Part(BodyPart::Head)),
    ("skull", Word::Part(BodyPart::Head)),
    ("jaw", Word::Part(BodyPart::Head)),
    ("tongue", Word::Part(BodyPart::Head)),
    ("clavicle", Word::Part(BodyPart::Trunk)),
    ("collar", Word::Part(BodyPart::Trunk)),
    ("scapula", Word::Part(BodyPart::Trunk)),
    ("chest", Word::Part(BodyPart::Trunk)),
    ("thorax", Word::Part(BodyPart::Trunk)),
    ("breast", Word::Part(BodyPart::Trunk)),
    ("pectoral", Word::Part(BodyPart::Trunk)),
    ("shoulder", Word::Shoulder),
    ("pelvis", Word::Part(BodyPart::Trunk)),
    ("hips", Word::Part(BodyPart::Trunk)),
    ("spine", Word::Spine),
    ("abdomen", Word::Spine),
    ("waist", Word::Spine),
    ("torso", Word::Spine),
    ("lowerback", Word::Spine),
    ("upperback", Word::Spine),
    ("arm", Word::Arm),
    ("leg", Word::Leg),
];

/// Reads one joint's name.
pub(super) fn read(name: &str) -> Reading {
    let mut reading = Reading { word: Word::Unknown, side: None, twist: false, control: false };
    let mut kept: Vec<String> = Vec::new();
    for token in tokens(name) {
        let token = match token.as_str() {
            "l" | "left" | "r" | "right" => {
                reading.side = Some(if token.starts_with('l') { Side::Left } else { Side::Right });
                continue;
            }
            t if TWIST.contains(&t) => {
                reading.twist = true;
                continue;
            }
            t if CONTROL.contains(&t) => {
                reading.control = true;
                continue;
            }
            t if FILLER.contains(&t) => continue,
            t => match (t.strip_prefix("left"), t.strip_prefix("right")) {
                (Some(rest), _) => {
                    reading.side = Some(Side::Left);
                    rest.to_owned()
                }
                (_, Some(rest)) => {
                    reading.side = Some(Side::Right);
                    rest.to_owned()
                }
                _ => token,
            },
        };
        kept.push(token);
    }
    let joined = kept.concat();
    let alone = ALONE.iter().find(|(word, _)| kept.iter().any(|t| t == word));
    let inside = INSIDE.iter().find(|(word, _)| joined.contains(word));
    reading.word = match (inside, alone) {
        // A hip with a side is the joint of a thigh.
        _ if joined == "hip" || joined == "hipjoint" => {
            Word::Part(if reading.side.is_some() { BodyPart::Thigh } else { BodyPart::Trunk })
        }
        (Some(&(_, Word::Arm | Word::Leg)), Some(&(_, word))) => word,
        (Some(&(_, word)), _) | (None, Some(&(_, word))) => word,
        (None, None) => Word::Unknown,
    };
    reading
}

/// Lower-case words of a name: cut at anything but letters and before capitals; digits are dropped.
fn tokens(name: &str) -> Vec<String> {
    let chars: Vec<char> = name.chars().collect();
    let mut tokens = vec![String::new()];
    for (k, &c) in chars.iter().enumerate() {
        let before = k.checked_sub(1).map(|p| chars[p]);
        let starts = c.is_uppercase()
            && (before.is_some_and(char::is_lowercase)
                || (before.is_some_and(char::is_uppercase) && chars.get(k + 1).is_some_and(|n| n.is_lowercase())));
        if starts || !c.is_alphabetic() {
            tokens.push(String::new());
        }
        if c.is_alphabetic() {
            tokens.last_mut().into_iter().for_each(|t| t.extend(c.to_lowercase()));
        }
    }
    tokens.retain(|t| !t.is_empty());
    tokens
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_many_rigs_are_read() {
        let part = |p| Word::Part(p);
        let cases = [
            ("upperarm_l", part(BodyPart::UpperArm), Some(Side::Left)),
            ("mixamorig:LeftForeArm", part(BodyPart::Forearm), Some(Side::Left)),
            ("mixamorig:RightArm", Word::Arm, Some(Side::Right)),
            ("mixamorig:LeftUpLeg", part(BodyPart::Thigh), Some(Side::Left)),
            ("mixamorig:Spine2", Word::Spine, None),
            ("Bip01 L Thigh", part(BodyPart::Thigh), Some(Side::Left)),
            ("Bip01 R Calf", part(BodyPart::Calf), Some(Side::Right)),
            ("lShldrBend", part(BodyPart::UpperArm), Some(Side::Left)),
            ("rForearmTwist", part(BodyPart::Forearm), Some(Side::Right)),
            ("upperleg02.R", part(BodyPart::Thigh), Some(Side::Right)),
            ("finger3-2.L", part(BodyPart::Hand), Some(Side::Left)),
            ("metacarpal1.L", part(BodyPart::Hand), Some(Side::Left)),
            ("DEF-upper_arm.L.001", part(BodyPart::UpperArm), Some(Side::Left)),
            ("Skeleton_arm_joint_L__4_", Word::Arm, Some(Side::Left)),
            ("leg_joint_R_1", Word::Leg, Some(Side::Right)),
            ("L_Hip", part(BodyPart::Thigh), Some(Side::Left)),
            ("Hips", part(BodyPart::Trunk), None),
            ("pelvis.L", part(BodyPart::Trunk), Some(Side::Left)),
            ("shoulder01.R", Word::Shoulder, Some(Side::Right)),
            ("Ring1.L", part(BodyPart::Hand), Some(Side::Left)),
            ("lefthand", part(BodyPart::Hand), Some(Side::Left)),
            ("ball_r", part(BodyPart::Foot), Some(Side::Right)),
            ("Body", Word::Spine, None),
            ("Armature", Word::Unknown, None),
            ("string_03", Word::Unknown, None),
            ("tail_01", Word::Unknown, None),
            ("joint_7", Word::Unknown, None),
            ("", Word::Unknown, None),
        ];
        for (name, word, side) in cases {
            let reading = read(name);
            assert_eq!((reading.word, reading.side), (word, side), "{name}");
        }
    }

    #[test]
    fn handles_and_twists_are_told_apart() {
        for name in ["heelIK.l", "IKFoot", "control-toe-roll.l", "PoleTarget.R", "elbowIK.r"] {
            assert!(read(name).control, "{name}");
        }
        assert!(read("LeftArmRoll").twist && read("upperarm_twist_01_l").twist);
        assert!(!read("spike").control && !read("trolley").twist);
    }
}
