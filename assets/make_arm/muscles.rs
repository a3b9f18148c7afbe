//! The known muscles: the table that makes the bulges of the skin and the muscle file beside it.

use crate::skeleton::{Frame, Skeleton};
use glam::DVec3;
use std::fmt::Write as _;

/// One muscle as the muscle file has it.
#[derive(Clone, Debug)]
pub struct Muscle {
    /// Name in the file.
    pub name: &'static str,
    /// The bone whose field it joins.
    pub bone: &'static str,
    /// Remark for the reader of the file.
    remark: &'static str,
    /// Where it starts: offset in the upper arm's space, metres.
    origin: DVec3,
    /// Where it ends: offset in the lower arm's space, metres.
    insertion: DVec3,
    /// Rough direction of the section's long axis in the upper arm's space.
    long_axis: DVec3,
    /// Profile exponents.
    exponents: (u32, u32),
    eccentricity: f64,
    /// Largest radius at rest with eccentricity 0, metres, of the flesh that shapes the skin.
    width: f64,
}

/// How wide a muscle is, of its flesh. The flesh lies on a straight axis and encloses bone; a muscle in motion is pushed
/// off the bone, and at its full width would stand out of the skin.
const MUSCLE_SHARE: f64 = 0.8;

/// Exponents of the muscles that bend the elbow when they are fully active: higher and fuller than at rest, not a ball.
const ACTIVE: (u32, u32) = (4, 4);
/// The muscles that bend the elbow; the others keep their shape.
const BENDERS: [&str; 3] = ["biceps", "brachialis", "brachioradialis"];

/// The muscles of the arm.
pub fn all() -> Vec<Muscle> {
    let v = DVec3::new;
    let muscle = |name, bone, remark, origin, insertion, long_axis, exponents, eccentricity, width| Muscle {
        name,
        bone,
        remark,
        origin,
        insertion,
        long_axis,
        exponents,
        eccentricity,
        width,
    };
    vec![
        muscle(
            "biceps",
            "upperarm",
            "Both heads as one belly, from the shoulder's front to the tuberosity of the radius.",
            v(0.008, 0.016, 0.034),
            v(-0.002, 0.046, 0.018),
            v(1.0, 0.0, 0.0),
            (3, 3),
            0.50,
            0.0290,
        ),
        muscle(
            "brachialis",
            "upperarm",
            "Under the biceps; it shows on the outer side above the elbow.",
            v(-0.020, 0.120, 0.011),
            v(0.004, 0.032, 0.010),
            v(1.0, 0.0, 0.0),
            (3, 3),
            0.40,
            0.0230,
        ),
        muscle(
            "triceps_long",
            "upperarm",
            "The long head, on the inner back of the upper arm.",
            v(0.014, 0.000, -0.024),
            v(0.004, -0.016, -0.021),
            v(1.0, 0.0, 0.3),
            (3, 3),
            0.50,
            0.0280,
        ),
        muscle(
            "triceps_lateral",
            "upperarm",
            "The lateral head, on the outer back: its belly lies higher, above the flat tendon.",
            v(-0.018, 0.030, -0.020),
            v(-0.004, -0.016, -0.021),
            v(0.6, 0.0, -0.8),
            (3, 4),
            0.50,
            0.0265,
        ),
        muscle(
            "brachioradialis",
            "lowerarm",
            "From the outer ridge above the elbow to the radius at the thumb's side of the wrist.",
            v(-0.026, 0.236, 0.006),
            v(-0.009, 0.235, 0.017),
            v(0.6, 0.0, 0.8),
            (3, 4),
            0.30,
            0.0225,
        ),
        muscle(
            "flexors",
            "lowerarm",
            "The forearm's flexors as one mass, from the inner epicondyle to the palm's side of the wrist.",
            v(0.025, 0.285, -0.004),
            v(0.011, 0.240, 0.005),
            v(0.2, 0.0, 1.0),
            (3, 5),
            0.50,
            0.0250,
        ),
        muscle(
            "extensors",
            "lowerarm",
            "The forearm's extensors as one mass, from the outer epicondyle to the back of the wrist.",
            v(-0.025, 0.280, -0.006),
            v(-0.010, 0.240, -0.005),
            v(-0.3, 0.0, 1.0),
            (3, 5),
            0.50,
            0.0240,
        ),
    ]
}

/// The file's precision, a tenth of a millimetre for offsets: everything is built from the rounded numbers.
fn rounded(v: DVec3) -> DVec3 {
    (v * 1e4).round() / 1e4
}

impl Muscle {
    /// The section's long axis in the bones' spaces, square to the muscle's axis.
    fn normals(&self, skeleton: &Skeleton) -> (DVec3, DVec3) {
        let axis = skeleton.lowerarm.point(self.insertion) - skeleton.upperarm.point(self.origin);
        let long = (skeleton.upperarm.rotation * self.long_axis).reject_from(axis).normalize();
        let in_bone = |bone: &Frame| rounded(bone.rotation.inverse() * long);
        (in_bone(&skeleton.upperarm), in_bone(&skeleton.lowerarm))
    }

    /// The flesh at rest as a sweep in scene space.
    pub fn sweep(&self, skeleton: &Skeleton) -> Sweep {
        let (alpha, beta) = (f64::from(self.exponents.0), f64::from(self.exponents.1));
        let long = (skeleton.upperarm.rotation * self.normals(skeleton).0).normalize();
        Sweep::new(
            [skeleton.upperarm.point(self.origin), skeleton.lowerarm.point(self.insertion)],
            long,
            (alpha, beta),
            self.eccentricity,
            self.width,
        )
    }

    fn table(&self, skeleton: &Skeleton) -> String {
        let (origin_normal, insertion_normal) = self.normals(skeleton);
        let triple = |v: DVec3| format!("[{:.4}, {:.4}, {:.4}]", v.x, v.y, v.z).replace("-0.0000", "0.0000");
        let end = |bone, offset, normal| {
            format!("{{ bone = \"{bone}\", offset = {}, normal = {} }}", triple(offset), triple(normal))
        };
        let active = match BENDERS.contains(&self.name) {
            true => format!("active = {{ alpha = {}, beta = {} }}\n", ACTIVE.0, ACTIVE.1),
            false => String::new(),
        };
        format!(
            "\n# {}\n[[muscle]]\nname = \"{}\"\nside = \"left\"\nbone = \"{}\"\norigin    = {}\ninsertion = {}\n\
             alpha = {}\nbeta = {}\neccentricity = {:.2}\nwidth = {:.4}\n{active}",
            self.remark,
            self.name,
            self.bone,
            end("upperarm", self.origin, origin_normal),
            end("lowerarm", self.insertion, insertion_normal),
            self.exponents.0,
            self.exponents.1,
            self.eccentricity,
            MUSCLE_SHARE * self.width,
        )
    }
}

/// The muscle file beside the model.
pub fn muscle_file(skeleton: &Skeleton) -> String {
    let mut text = String::from(
        "\
# The muscles of the built-in arm. `cargo run --example make-arm -- assets` writes this file: the same numbers
# shape the skin of arm.glb, so every bulge that you see has its muscle here. A muscle is 0.8 of its flesh's width.
#
# Lengths are metres. A bone's own space at rest has Y along the bone, X towards the body's midline and Z to the
# front; `offset` and `normal` are in that space.
#
#   bone          the bone whose skin the muscle shapes
#   origin        the end on the body's side; insertion: the end that moves
#   normal        direction of the section's long axis at that end; it matters when eccentricity is not 0
#   alpha, beta   1 to 9: the profile along the muscle is s^(alpha-1) (1-s)^(beta-1), so that a larger beta moves
#                 the belly towards the origin, and larger values of both make it more pointed
#   eccentricity  0 for a round section, towards 1 for a flat one
#   width         largest radius at rest if the section were round
#   active        the shape of a muscle that has become 30 % shorter than at rest, and so fully active
#
# Every other key is shown in sample.muscles.toml.

[character]
name = \"arm\"
",
    );
    for muscle in all() {
        let _ = write!(text, "{}", muscle.table(skeleton));
    }
    text
}

/// A straight muscle's swept section: paper A, equations 2 to 5.
#[derive(Clone, Debug)]
pub struct Sweep {
    origin: DVec3,
    axis: DVec3,
    length: f64,
    long: DVec3,
    exponents: (f64, f64),
    /// Short and long semi-axis of the section whose area is pi.
    semi: (f64, f64),
    width: f64,
}

impl Sweep {
    /// A sweep between two ends; `width` is its largest radius were the section round.
    pub fn new(ends: [DVec3; 2], long: DVec3, exponents: (f64, f64), eccentricity: f64, width: f64) -> Sweep {
        let along = ends[1] - ends[0];
        let axis = along.normalize();
        let short = (1.0 - eccentricity * eccentricity).sqrt().sqrt();
        Sweep {
            origin: ends[0],
            axis,
            length: along.length(),
            long: long.reject_from(axis).normalize(),
            exponents,
            semi: (short, 1.0 / short),
            width,
        }
    }

    /// Mean radius at `s`: the profile, scaled so that its largest value is the width.
    fn mean_radius(&self, s: f64) -> f64 {
        let (a, b) = (self.exponents.0 - 1.0, self.exponents.1 - 1.0);
        let profile = |s: f64| s.powf(a) * (1.0 - s).powf(b);
        self.width * profile(s) / profile(a / (a + b))
    }

    /// Radius of the section in the direction whose cosine with the long axis is `cosine`.
    fn shape(&self, cosine: f64) -> f64 {
        let (u, v) = self.semi;
        let c2 = cosine * cosine;
        1.0 / (u * u * c2 + v * v * (1.0 - c2)).sqrt()
    }

    /// Distance to the axis less the section's radius: negative inside.
    pub fn distance(&self, point: DVec3) -> f64 {
        let from = point - self.origin;
        let s = (from.dot(self.axis) / self.length).clamp(0.0, 1.0);
        let out = from - self.axis * (s * self.length);
        let d = out.length();
        let cosine = if d > 0.0 { out.dot(self.long) / d } else { 1.0 };
        d - self.mean_radius(s) * self.shape(cosine)
    }

    /// The point of the surface at `s` in 0..=1 and `turn` in 0..1 round the axis.
    #[cfg(test)]
    pub fn surface(&self, s: f64, turn: f64) -> DVec3 {
        let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
        let direction = self.long * cos + self.axis.cross(self.long) * sin;
        self.origin + self.axis * (s * self.length) + direction * (self.mean_radius(s) * self.shape(cos))
    }
}
