//! Where muscles lie round bones and joints: obstacles found, with the muscle's thickness and its side.

use super::resolve::find_wrap_joint;
use super::{Around, MuscleSpec};
use crate::error::MuscleError;
use crate::field::muscle::wrap::{
    CLEARANCE, Course, MuscleWrap, Spacing,
    cylinder::{self, Cylinder},
    sphere::{self, Side},
};
use crate::field::muscle::{Profile, profile::ellipse_squared};
use crate::math::transform_point;
use crate::rig::{Character, bones};
use glam::{Mat4, Vec3};

/// An obstacle in its own frame, without any muscle.
pub(super) struct Obstacle {
    /// From its frame to scene space at rest.
    to_rest: Mat4,
    /// The way back.
    to_local: Mat4,
    radius: f32,
    /// Heights of a bone's ends; none on a joint.
    heights: Option<[f32; 2]>,
    joint: u32,
    /// A point on the muscle's side, in the frame.
    locator: Option<Vec3>,
}

/// One fibre at rest, scene space.
pub(super) struct Fibre {
    pub origin: Vec3,
    pub insertion: Vec3,
    /// Section normals at both ends.
    pub normals: [Vec3; 2],
    /// The width w, metres.
    pub width: f32,
}

impl Obstacle {
    /// What a muscle lies round; none where it runs straight. `ends` are its fibres' ends at rest, scene space: a set lies on one
    /// side together.
    pub fn of(
        spec: &MuscleSpec,
        character: &Character,
        ends: &[(Vec3, Vec3)],
    ) -> Result<Option<Obstacle>, MuscleError> {
        let (Some(wrap), Some(joint)) = (&spec.wrap, find_wrap_joint(spec, character)?) else { return Ok(None) };
        let bind = character.joints[joint].bind();
        let scale = bind.determinant().abs().cbrt();
        let (centre, top) = match &wrap.around {
            Around::Joint(_) => (bind.w_axis.truncate(), None),
            Around::Bone { ends: Some(ends), .. } => {
                let [from, to] = ends.map(|p| transform_point(&bind, p));
                (from, Some(to))
            }
            Around::Bone { ends: None, bone } => {
                let (from, to) = bones::axis(character, joint as u32).ok_or_else(|| MuscleError::Value {
                    muscle: spec.name.clone(),
                    key: "wrap.bone".into(),
                    what: format!("nothing says where bone `{bone}` goes; give the wrap `from` and `to`"),
                })?;
                (from, Some(to))
            }
        };
        let along = top.map_or(Vec3::Z, |top| (top - centre).normalize_or(Vec3::Z));
        let (x, y) = along.any_orthonormal_pair();
        let to_rest = Mat4::from_cols(x.extend(0.0), y.extend(0.0), along.extend(0.0), centre.extend(1.0));
        let to_local = to_rest.inverse();
        let middle = |(origin, insertion): &(Vec3, Vec3)| (*origin + *insertion) * 0.5;
        let locator = match wrap.side {
            Some(side) => Some(transform_point(&bind, side)),
            None if ends.len() > 1 => Some(ends.iter().map(middle).sum::<Vec3>() / ends.len() as f32),
            None => None,
        };
        Ok(Some(Obstacle {
            radius: wrap.radius * scale,
            heights: top.map(|top| [0.0, top.distance(centre)]),
            joint: joint as u32,
            locator: locator.map(|p| transform_point(&to_local, p)),
            to_rest,
            to_local,
        }))
    }

    /// A fibre's wrap. `tendon` are its segments of tendon at each end.
    ///
    /// The obstacle is as much larger as the muscle is thick towards it where their straight line comes nearest at rest; not so
    /// much that an end would be in it.
    pub fn wrap(&self, spec: &MuscleSpec, fibre: &Fibre, tendon: u32) -> Result<MuscleWrap, MuscleError> {
        let (origin, insertion) =
            (transform_point(&self.to_local, fibre.origin), transform_point(&self.to_local, fibre.insertion));
        for (role, end) in [("origin", origin), ("insertion", insertion)] {
            if !self.is_clear(end, self.radius) {
                return refuse(spec, "wrap.radius", self.inside(role, end));
            }
        }
        let mut radius = self.radius + self.thickness(spec, fibre, origin, insertion);
        for end in [origin, insertion] {
            if !self.is_clear(end, radius) {
                radius = radius.min(self.away(end) / (CLEARANCE * CLEARANCE)).max(self.radius);
            }
        }
        let [low, high] = self.heights.unwrap_or_default();
        let side = match self.heights {
            None => Side::at_rest(origin, insertion, radius, self.locator).map(|side| side.axis.extend(side.swept)),
            Some(_) => cylinder::side_at_rest(origin, insertion, &Cylinder { radius, low, high }, self.locator)
                .map(|swept| Vec3::Z.extend(swept)),
        };
        let Some(side) = side else {
            let what = "the muscle's ends and `wrap.side` do not tell on which side of it the muscle lies; give `side` a point \
                        on that side";
            return refuse(spec, "wrap.side", what.into());
        };
        let wrap = MuscleWrap {
            to_rest: self.to_rest,
            side,
            radius,
            low,
            high,
            rest_length: 0.0,
            joint: self.joint,
            sphere: self.heights.is_none().into(),
            tendon,
            segments: spec.segments,
        };
        let course = Course::new(&wrap, &self.to_rest, fibre.origin, fibre.insertion, Spacing::Even);
        Ok(MuscleWrap { rest_length: course.path().length(), ..wrap })
    }

    /// Distance of a point of the frame from the joint or the bone's axis.
    fn away(&self, p: Vec3) -> f32 {
        if self.heights.is_some() { p.truncate().length() } else { p.length() }
    }

    /// Whether a point of the frame is outside the obstacle if this had `radius`.
    fn is_clear(&self, p: Vec3, radius: f32) -> bool {
        match self.heights {
            None => sphere::pushed_out(p, radius) == p,
            Some([low, high]) => Cylinder { radius, low, high }.pushed_out(p) == p,
        }
    }

    fn inside(&self, role: &str, end: Vec3) -> String {
        let (radius, away) = (self.radius, self.away(end));
        let what = if self.heights.is_some() { "bone's axis" } else { "joint" };
        format!(
            "the {role} is {away} m from the {what}, inside the wrap's radius of {radius} m; make it smaller or move the {role}"
        )
    }

    /// Half the thickness of a fibre towards the obstacle, metres, where its straight line comes nearest to it.
    fn thickness(&self, spec: &MuscleSpec, fibre: &Fibre, origin: Vec3, insertion: Vec3) -> f32 {
        let flat = |p: Vec3| if self.heights.is_some() { p.with_z(0.0) } else { p };
        let (from, to) = (flat(origin), flat(insertion));
        let span = to - from;
        let share = (-from.dot(span) / span.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let towards = self.to_rest.transform_vector3(from + span * share).normalize_or_zero();
        let normal = fibre.normals[0].lerp(fibre.normals[1], share).normalize_or_zero();
        let (short_squared, long_squared) = ellipse_squared(spec.rest.eccentricity);
        let squared = towards.dot(normal) * towards.dot(normal);
        let polar = 1.0 / (short_squared * squared + long_squared * (1.0 - squared)).sqrt();
        fibre.width * spec.rest.width * Profile::of(spec.rest.alpha, spec.rest.beta).at(share).0 * polar
    }
}

fn refuse<T>(spec: &MuscleSpec, key: &str, what: String) -> Result<T, MuscleError> {
    Err(MuscleError::Value { muscle: spec.name.clone(), key: key.into(), what })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::{Attachment, FieldGroups, Influence, Joint, MuscleSize, Wrap, groups::Group, muscle::resolve};
    use glam::Vec2;

    /// Two bones along Y, of 30 cm each.
    fn limb() -> (Character, FieldGroups) {
        let joint = |name: &str, y: f32, parent| Joint {
            name: name.into(),
            parent,
            node: 0,
            inverse_bind: Mat4::from_translation(Vec3::Y * -y),
        };
        let character = Character {
            joints: vec![joint("upper", 0.0, None), joint("lower", 0.3, Some(0)), joint("end", 0.6, Some(1))],
            positions_rest: vec![Vec3::ZERO, Vec3::Y],
            normals_rest: vec![Vec3::X; 2],
            uvs: vec![Vec2::ZERO; 2],
            influences: vec![Influence { joint: 0, weight: 1.0 }; 2],
            influence_offsets: vec![0, 1, 2],
            ..Character::default()
        };
        let group = Group { name: "upper".into(), joint: 0, joints: vec![0], parent: None, passive: false, part: None };
        (character, FieldGroups { groups: vec![group], group_of_joint: vec![0; 3], owner: vec![0, 0] })
    }

    /// A muscle along the limb, in front of it at its ends, with a wrap.
    fn wrapped(around: Around, radius: f32, change: impl Fn(&mut MuscleSpec)) -> Result<(f32, MuscleWrap), String> {
        let end = |bone: &str, y| Attachment { bone: bone.into(), offset: Vec3::new(0.0, y, 0.03), normal: Vec3::X };
        let mut spec = MuscleSpec::new("m", "upper", end("upper", 0.1), end("lower", 0.1), MuscleSize::Width(0.01));
        spec.wrap = Some(Wrap { around, radius, side: None });
        change(&mut spec);
        let (character, groups) = limb();
        let found = resolve(&spec, &character, &groups).map_err(|e| e.to_string())?;
        Ok((found[0].0.origin_normal.w, found[0].1.expect("a wrap")))
    }

    fn joint() -> Around {
        Around::Joint("lower".into())
    }

    #[test]
    fn the_obstacle_is_larger_by_half_the_muscle() {
        let (length, wrap) = wrapped(joint(), 0.01, |_| ()).expect("a wrap");
        let share = 2.0 / 3.0;
        let radius = 0.01 / Profile::of(3, 3).max() * Profile::of(3, 3).at(share).0;
        assert!((wrap.radius - 0.01 - radius).abs() < 1e-6, "{} {radius}", wrap.radius);
        assert!((length - 0.3).abs() < 1e-6 && wrap.joint == 1 && wrap.sphere == 1, "{length}");
        assert_eq!((wrap.tendon, wrap.segments), (3, 29));
        // Half the side is the muscle's: with the long axis across, it is flatter towards the joint.
        let flat = wrapped(joint(), 0.01, |spec| spec.rest.eccentricity = 0.8).expect("a wrap").1;
        assert!(flat.radius < wrap.radius - 1e-3, "{}", flat.radius);
        // No end is in it, however thick the muscle is.
        let thick = wrapped(joint(), 0.01, |spec| {
            (spec.rest.beta, spec.size) = (1, MuscleSize::Width(0.2));
            spec.insertion.offset = Vec3::new(0.0, 0.01, 0.03);
        });
        let away = Vec3::new(0.0, 0.01, 0.03).length();
        assert!((thick.expect("a wrap").1.radius / away - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_muscle_that_bends_at_rest_is_as_long_as_its_path() {
        let behind = |spec: &mut MuscleSpec| {
            spec.wrap.as_mut().expect("a wrap").side = Some(Vec3::new(0.0, 0.0, -0.1));
        };
        let (length, wrap) = wrapped(joint(), 0.02, behind).expect("a wrap");
        assert!(length > 0.305 && (wrap.rest_length - length).abs() < 1e-7, "{length}");
        let bone = Around::Bone { bone: "upper".into(), ends: None };
        let (straight, cylinder) = wrapped(bone, 0.012, |_| ()).expect("a wrap");
        assert!((straight - 0.3).abs() < 1e-6 && cylinder.sphere == 0, "{straight}");
        assert!(cylinder.low == 0.0 && (cylinder.high - 0.3).abs() < 1e-6, "from the joint to its child");
    }

    #[test]
    fn fibres_of_a_set_lie_on_one_side() {
        let (character, groups) = limb();
        let end = |bone: &str, y| Attachment { bone: bone.into(), offset: Vec3::new(0.02, y, 0.03), normal: Vec3::X };
        let mut spec = MuscleSpec::new("m", "upper", end("upper", 0.1), end("lower", 0.1), MuscleSize::Width(0.004));
        spec.wrap = Some(Wrap { around: joint(), radius: 0.025, side: None });
        let line = |y: f32| vec![Vec3::new(-0.03, y, -0.028)];
        let set =
            crate::rig::muscle::FibreSet { count: 5, origin_line: line(0.1), insertion_line: line(0.1), overlap: true };
        spec.fibres = Some(set);
        let fibres = resolve(&spec, &character, &groups).expect("five fibres");
        let axes: Vec<Vec3> = fibres.iter().map(|(_, wrap)| wrap.expect("a wrap").side.truncate()).collect();
        assert!(axes.windows(2).all(|pair| pair[0].dot(pair[1]) > 0.5), "{axes:?}");
        let alone: Vec<Vec3> = fibres
            .iter()
            .filter_map(|(rest, wrap)| {
                let local = |p: glam::Vec4| p.truncate() - Vec3::Y * 0.3;
                Side::at_rest(local(rest.origin), local(rest.insertion), wrap.expect("a wrap").radius, None)
            })
            .map(|side| side.axis)
            .collect();
        assert!(alone.windows(2).any(|pair| pair[0].dot(pair[1]) < 0.0), "each by itself would part: {alone:?}");
    }

    #[test]
    fn obstacles_without_a_way_round_are_refused() {
        let refused =
            |around, radius, change: fn(&mut MuscleSpec)| wrapped(around, radius, change).expect_err("refused");
        let inside = refused(joint(), 0.2, |_| ());
        assert!(inside.contains("origin is 0.202") || inside.contains("insertion is 0.104"), "{inside}");
        assert!(inside.contains("inside the wrap's radius of 0.2 m; make it smaller"), "{inside}");
        let through = refused(joint(), 0.02, |spec| {
            spec.origin.offset.z = 0.0;
            spec.insertion.offset.z = 0.0;
        });
        assert!(through.contains("do not tell on which side"), "{through}");
        let last = Around::Bone { bone: "end".into(), ends: None };
        assert!(refused(last, 0.01, |_| ()).contains("give the wrap `from` and `to`"));
    }
}
