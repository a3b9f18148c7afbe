//! The muscle primitive: a profile swept along a polyline (paper A, sections 5.1 and 5.2, equations 1 to 5).

pub mod axis;
#[cfg(any(test, feature = "figures"))]
pub(crate) mod bent;
mod evaluate;
mod lanes;
pub mod mesh;
pub mod profile;
mod volume;
mod weighted;
pub mod wrap;

pub use axis::AxisPoint;
pub use evaluate::KEY_BITS;
pub use evaluate::{Projection, evaluate, project};
pub use lanes::{Instructions, POINTS_PER_THREAD, UnionInput, UnionParams, union, union_with};
pub use profile::Profile;
pub use volume::volume;
#[cfg(feature = "gpu")]
pub(crate) use weighted::{FACING, WIDENED};
pub use weighted::{MuscleWeight, Pull, pull, widened};

use glam::{Vec3, Vec4, Vec4Swizzles};
use wrap::MuscleWrap;

crate::gpu_struct! {
    /// One muscle at one moment, in scene space at rest of the field group that it joins. Its axis stands in a slice of
    /// [`AxisPoint`]s beside it.
    pub struct MuscleFrame {
        /// Factors of the profile's terms ([`Profile`]).
        pub factors: Vec4,
        /// Lowest corner of the box outside which the muscle has no field, and in `w` the squared distance from the axis
        /// beyond which it has none, square metres.
        pub lowest: Vec4,
        /// Highest corner of that box; `w` unused.
        pub highest: Vec4,
        /// Exponents of the profile's terms.
        pub exponents: u32,
        /// Number of the profile's terms.
        pub terms: u32,
        /// First of the muscle's points among its instance's.
        pub first_point: u32,
        /// Segments of the axis, one less than its points.
        pub segments: u32,
        /// Length of the axis, metres.
        pub length: f32,
        /// One over the length.
        pub inverse_length: f32,
        /// The width w of equation 2, metres.
        pub width: f32,
        /// Support radius of the muscle's field outside its surface, metres.
        pub support_radius: f32,
        /// Square of the ellipse's short semi-axis u, of an ellipse of area pi (equation 5).
        pub short_squared: f32,
        /// Square of the ellipse's long semi-axis v.
        pub long_squared: f32,
        /// 0 at rest to 1 fully active.
        pub activation: f32,
        /// 1 where the muscle has a field, 0 where its axis has collapsed to a point.
        pub present: u32,
        /// Shift of the profile along the axis.
        pub shift: f32,
        /// Unused.
        pub pad_0: u32,
        /// Unused.
        pub pad_1: u32,
        /// Unused.
        pub pad_2: u32,
    }
}

crate::gpu_struct! {
    /// A muscle as its rig holds it; points and directions in scene space at rest.
    pub struct MuscleRest {
        /// Origin, and in `w` the volume in cubic metres.
        pub origin: Vec4,
        /// Insertion, and in `w` the least support radius of the field, metres.
        pub insertion: Vec4,
        /// Section normal at the origin, and in `w` the rest length in metres.
        pub origin_normal: Vec4,
        /// Section normal at the insertion; `w` unused.
        pub insertion_normal: Vec4,
        /// Joint that carries the origin.
        pub origin_joint: u32,
        /// Joint that carries the insertion.
        pub insertion_joint: u32,
        /// Field group that the muscle joins.
        pub group: u32,
        /// Segments of the axis.
        pub segments: u32,
        /// First of the muscle's points among its instance's.
        pub first_point: u32,
        /// Joint in whose scene space at rest the muscle is shaped: its group's, or in a trunk the one nearest to it.
        pub joint: u32,
        /// What it lies round among the rig's wraps, counted from 1; 0 where it runs straight.
        pub wrap: u32,
        /// Unused.
        pub pad_0: u32,
    }
}

crate::gpu_struct! {
    /// What keys and drivers make of one muscle at one moment.
    pub struct MuscleInput {
        /// Factors of the profile's terms ([`Profile`]).
        pub factors: Vec4,
        /// Exponents of the profile's terms.
        pub exponents: u32,
        /// Number of the profile's terms.
        pub terms: u32,
        /// Bound on the profile's largest value without its shift.
        pub profile_bound: f32,
        /// Eccentricity, 0..=[`profile::MAX_ECCENTRICITY`].
        pub eccentricity: f32,
        /// Factor on the width that the volume gives.
        pub width: f32,
        /// 0 at rest to 1 fully active.
        pub activation: f32,
        /// Stiffness k, 0..=1.
        pub stiffness: f32,
        /// Shift of the profile along the axis; where the dynamics move the muscle, theirs stands for it.
        pub shift: f32,
    }
}

impl MuscleInput {
    /// An input of a given profile and eccentricity, at rest and with the width that the volume gives.
    pub fn new(profile: &Profile, eccentricity: f32) -> MuscleInput {
        MuscleInput {
            factors: profile.factors,
            exponents: profile.exponents,
            terms: profile.terms,
            profile_bound: Profile { shift: 0.0, ..*profile }.bound(),
            shift: profile.shift,
            eccentricity: eccentricity.clamp(0.0, profile::MAX_ECCENTRICITY),
            width: 1.0,
            ..MuscleInput::default()
        }
    }
}

/// Axes shorter than this, in metres, have no direction: the muscle drops out of the field.
pub(crate) const MIN_LENGTH: f32 = 1e-5;

/// Least support radius in largest radii: below it the inner field could not be monotone (background 3.2).
pub(crate) const LEAST_SUPPORT_RADII: f32 = 0.625;

/// Room for the rounding of distances, so that what lies beyond a muscle's reach has no field whichever way it is found.
pub(crate) const ROUNDING: f32 = 1.001;

/// Shapes a muscle on the axis whose positions stand in `points`: fills in their frames, and gives the width
/// `w = sqrt(V / (pi l))` at which the volume is what it was (paper A, equation 3).
///
/// `points` are the muscle's own, `rest.segments + 1` of them; the end normals need be neither unit nor across the axis.
pub fn shape(
    rest: &MuscleRest,
    input: &MuscleInput,
    points: &mut [AxisPoint],
    origin_normal: Vec3,
    insertion_normal: Vec3,
) -> MuscleFrame {
    let length = axis::frame(points, origin_normal, insertion_normal, SMOOTHING);
    if !(length.is_finite() && length >= MIN_LENGTH) {
        return MuscleFrame { first_point: rest.first_point, segments: rest.segments, ..MuscleFrame::default() };
    }
    let width = input.width * (rest.origin.w / (std::f32::consts::PI * length)).sqrt();
    let (short_squared, long_squared) = profile::ellipse_squared(input.eccentricity);
    let largest = width * (input.profile_bound * profile::stretch(input.shift)) * long_squared.sqrt();
    let support_radius = rest.insertion.w.max(LEAST_SUPPORT_RADII * largest);
    let mut lowest = points[0].position.xyz();
    let mut highest = lowest;
    for point in points.iter() {
        lowest = lowest.min(point.position.xyz());
        highest = highest.max(point.position.xyz());
    }
    let reach = largest + support_radius;
    MuscleFrame {
        factors: input.factors,
        lowest: (lowest - reach).extend(reach * reach * ROUNDING),
        highest: (highest + reach).extend(0.0),
        exponents: input.exponents,
        terms: input.terms,
        first_point: rest.first_point,
        segments: rest.segments,
        length,
        inverse_length: 1.0 / length,
        width,
        support_radius,
        short_squared,
        long_squared,
        activation: input.activation,
        present: 1,
        shift: input.shift,
        ..MuscleFrame::default()
    }
}

/// Puts an axis' points evenly on the straight line from `origin` to `insertion`.
pub fn straighten(points: &mut [AxisPoint], origin: Vec3, insertion: Vec3) {
    let segments = (points.len() - 1) as f32;
    for (i, point) in points.iter_mut().enumerate() {
        let share = i as f32 / segments;
        point.position = (origin * (1.0 - share) + insertion * share).extend(0.0);
    }
}

/// Passes of [`smooth`], and of the sections' normals: kinks of one to three points go, a bow of the whole axis stays.
pub const SMOOTHING: u32 = 8;

/// Smooths the inner points of an axis by [`SMOOTHING`] binomial passes. Tension alone joins the points of a muscle in
/// motion, so that an axis has a kink wherever a single point touches something; flesh has none, and a tube with kinks
/// sharper than it is thick would not keep its volume.
pub fn smooth(points: &mut [AxisPoint]) {
    for _ in 0..SMOOTHING {
        let mut before = points[0].position;
        for i in 1..points.len() - 1 {
            let own = points[i].position;
            points[i].position = (before + points[i + 1].position) * 0.25 + own * 0.5;
            before = own;
        }
    }
}

impl MuscleFrame {
    /// The profile that sweeps along the axis.
    #[inline]
    pub fn profile(&self) -> Profile {
        Profile { factors: self.factors, exponents: self.exponents, terms: self.terms, shift: self.shift }
    }

    /// The muscle's own points among those of its instance.
    #[inline]
    pub fn points<'a>(&self, points: &'a [AxisPoint]) -> &'a [AxisPoint] {
        let first = self.first_point as usize;
        &points[first..first + self.segments as usize + 1]
    }

    /// Distance from the axis to the surface, metres, at share `s` of the length and in a direction across the axis whose
    /// cosine to the section's long axis is `cosine` (equations 2 and 5).
    pub fn radius(&self, s: f32, cosine: f32) -> f32 {
        self.width * self.profile().at(s).0 * self.polar(cosine * cosine)
    }

    /// The unit-area ellipse's radius at a squared cosine to its long axis (equation 5).
    #[inline]
    fn polar(&self, squared: f32) -> f32 {
        1.0 / (self.short_squared * squared + self.long_squared * (1.0 - squared)).sqrt()
    }

    /// Squared distance from the axis beyond which the muscle has no field.
    #[inline]
    fn reach_squared(&self) -> f32 {
        self.lowest.w
    }

    /// Whether a point can be in the muscle's field.
    #[inline]
    pub fn reaches(&self, q: Vec3) -> bool {
        q.cmpge(self.lowest.xyz()).all() && q.cmple(self.highest.xyz()).all()
    }
}

impl MuscleRest {
    /// What it lies round, of a rig's wraps.
    #[inline]
    pub fn wrap<'a>(&self, wraps: &'a [MuscleWrap]) -> Option<&'a MuscleWrap> {
        wraps.get((self.wrap as usize).checked_sub(1)?)
    }

    /// The muscle in the rest pose, straight from end to end; `points` are its own.
    pub fn at_rest(&self, input: &MuscleInput, points: &mut [AxisPoint]) -> MuscleFrame {
        straighten(points, self.origin.xyz(), self.insertion.xyz());
        shape(self, input, points, self.origin_normal.xyz(), self.insertion_normal.xyz())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::bent::LENGTH;
    use super::*;

    /// The muscles' width at their own length, metres.
    const WIDTH: f32 = 0.02;

    /// A straight muscle in a skew direction.
    pub(crate) fn muscle(eccentricity: f32, exponents: profile::Exponents) -> (MuscleFrame, Vec<AxisPoint>) {
        let axis = Vec3::new(0.2, 0.9, -0.3).normalize();
        let origin = Vec3::new(0.01, -0.02, 0.03);
        let positions: Vec<Vec3> = (0..=29).map(|i| origin + axis * (LENGTH * i as f32 / 29.0)).collect();
        along(&positions, exponents, eccentricity, axis.cross(Vec3::X))
    }

    /// A muscle whose axis is bent evenly by `angle` radians. Its normal stands square to the plane of the bend, as that of
    /// a muscle on a bone does, or in that plane where the eccentricity is given as negative.
    pub(crate) fn arc_muscle(
        angle: f32,
        segments: u32,
        exponents: profile::Exponents,
        eccentricity: f32,
    ) -> (MuscleFrame, Vec<AxisPoint>) {
        let normal = if eccentricity < 0.0 { Vec3::X } else { Vec3::Z };
        bent::arc(angle, segments, &Profile::of(exponents.0, exponents.1), eccentricity.abs(), normal)
    }

    /// A muscle along given positions.
    pub(crate) fn along(
        positions: &[Vec3],
        exponents: profile::Exponents,
        eccentricity: f32,
        normal: Vec3,
    ) -> (MuscleFrame, Vec<AxisPoint>) {
        bent::along(positions.iter().copied(), &Profile::of(exponents.0, exponents.1), eccentricity, normal)
    }

    #[test]
    fn an_axis_without_length_has_no_field() {
        let (m, points) = along(&[Vec3::ONE; 4], (3, 3), 0.0, Vec3::X);
        assert_eq!(m.present, 0);
        assert_eq!(evaluate(&m, &points, Vec3::ONE), crate::field::Sample::default());
    }

    #[test]
    fn the_width_follows_the_length_and_the_input() {
        let (long, _) = along(&[Vec3::ZERO, Vec3::X * 0.1, Vec3::X * 0.3, Vec3::X * 0.5], (3, 3), 0.0, Vec3::Y);
        assert!((long.width / (WIDTH * 0.5f32.sqrt()) - 1.0).abs() < 1e-5, "{}", long.width);
        assert!((long.length - 0.5).abs() < 1e-6);
    }
}
