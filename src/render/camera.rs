//! Where a picture is taken from.

use glam::{Mat4, Vec3, Vec4};

/// Vertical angle of view, degrees: long enough a lens that a body keeps its proportions.
const FIELD_OF_VIEW_DEGREES: f32 = 28.0;
/// Share of the picture's half side that is left free on every side.
const MARGIN: f32 = 0.06;
/// Thinnest side of a framed box, relative to its longest: keeps flat and empty boxes in front of the eye.
const THINNEST: f32 = 0.05;

/// From which side the camera looks, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Turn about Y: 0 looks along -Z from +Z, 90 along -X from +X.
    pub azimuth: f32,
    /// Height above the horizon; 90 looks straight down.
    pub elevation: f32,
}

impl Direction {
    /// From +Z, where a glTF character looks to.
    pub const FRONT: Direction = Direction { azimuth: 0.0, elevation: 0.0 };
    /// From +X, the character's left.
    pub const SIDE: Direction = Direction { azimuth: 90.0, elevation: 0.0 };
    /// Between the two, from a little above.
    pub const THREE_QUARTER: Direction = Direction { azimuth: 38.0, elevation: 8.0 };
}

/// A perspective camera with Y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the eye, metres.
    pub eye: Vec3,
    /// Unit vector to the right of the picture.
    pub right: Vec3,
    /// Unit vector to the top of the picture.
    pub up: Vec3,
    /// Unit vector from the scene to the eye.
    pub toward: Vec3,
    /// Tangent of half the vertical angle of view.
    pub tangent: f32,
    /// Width over height of the picture.
    pub aspect: f32,
    /// Distance of the nearest plane that is drawn, metres.
    pub near: f32,
    /// Distance of the farthest plane that is drawn, metres.
    pub far: f32,
}

impl Camera {
    /// The camera that shows the whole box `bounds` (low and high corner, metres) as large as fits, with a margin.
    ///
    /// For a clip, pass the box around all its frames. An empty or non-finite box counts as a unit cube about the
    /// origin, a flat one is thickened, a non-finite direction is the front and a non-positive `aspect` (width over
    /// height) is 1: every call yields a usable camera.
    pub fn frame(bounds: (Vec3, Vec3), direction: Direction, aspect: f32) -> Camera {
        let (center, half) = usable(bounds);
        Camera::hold(center, half, corners(half), direction, aspect)
    }

    /// The camera that shows all `points` (metres) as large as fits, with the same margin: closer than
    /// [`frame`](Camera::frame) around their box, which reaches where no point is.
    ///
    /// Where a point is not finite, or there are none, this is [`frame`](Camera::frame).
    pub fn around(points: &[Vec3], direction: Direction, aspect: f32) -> Camera {
        let (low, high) =
            points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        if points.is_empty() || !points.iter().all(|p| p.is_finite()) {
            return Camera::frame((low, high), direction, aspect);
        }
        let (center, half) = usable((low, high));
        // A small box among them keeps a single point in front of the eye.
        let least = corners(Vec3::splat(half.max_element() * THINNEST));
        Camera::hold(center, half, points.iter().map(|&p| p - center).chain(least), direction, aspect)
    }

    /// Holds points given relative to `center`, all in a box with half sides `half`.
    fn hold(center: Vec3, half: Vec3, points: impl Iterator<Item = Vec3>, direction: Direction, aspect: f32) -> Camera {
        let aspect = if aspect.is_finite() && aspect > 0.0 { aspect } else { 1.0 };
        let (azimuth, elevation) = if direction.azimuth.is_finite() && direction.elevation.is_finite() {
            (direction.azimuth.to_radians(), direction.elevation.to_radians())
        } else {
            (0.0, 0.0)
        };
        let right = Vec3::new(azimuth.cos(), 0.0, -azimuth.sin());
        let toward = Vec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos());
        let up = toward.cross(right);

        let tangent = (0.5 * FIELD_OF_VIEW_DEGREES.to_radians()).tan();
        let (across, down) = (tangent * aspect * (1.0 - MARGIN), tangent * (1.0 - MARGIN));
        // A point (x, y, z) relative to the centre is inside when |x - eye.x| <= across * (distance - z), and so for
        // y: four families of planes, whose outermost members fix the eye.
        let (mut left, mut rightmost, mut bottom, mut top) = (f32::MIN, f32::MIN, f32::MIN, f32::MIN);
        let (mut nearest, mut farthest) = (f32::MIN, f32::MAX);
        for point in points {
            let (x, y, z) = (point.dot(right), point.dot(up), point.dot(toward));
            rightmost = rightmost.max(x + across * z);
            left = left.max(across * z - x);
            top = top.max(y + down * z);
            bottom = bottom.max(down * z - y);
            nearest = nearest.max(z);
            farthest = farthest.min(z);
        }
        let distance = ((left + rightmost) / (2.0 * across)).max((bottom + top) / (2.0 * down));
        let eye = center + right * (0.5 * (rightmost - left)) + up * (0.5 * (top - bottom)) + toward * distance;
        let (near, far) = (0.5 * (distance - nearest), distance - farthest + half.length());
        Camera { eye, right, up, toward, tangent, aspect, near, far }
    }

    /// World to clip space: x right, y up, depth 0 at the near plane and 1 at the far plane.
    pub fn view_projection(&self) -> Mat4 {
        let turn =
            Mat4::from_cols(self.right.extend(0.0), self.up.extend(0.0), self.toward.extend(0.0), Vec4::W).transpose();
        let depth = self.far / (self.near - self.far);
        let projection = Mat4::from_cols(
            Vec4::new(1.0 / (self.tangent * self.aspect), 0.0, 0.0, 0.0),
            Vec4::new(0.0, 1.0 / self.tangent, 0.0, 0.0),
            Vec4::new(0.0, 0.0, depth, -1.0),
            Vec4::new(0.0, 0.0, depth * self.near, 0.0),
        );
        projection * turn * Mat4::from_translation(-self.eye)
    }
}

/// The smallest box around `points`, as [`Camera::frame`] takes it; points that are not finite are left out.
///
/// Without points the low corner lies above the high one, and joining it with another box yields that box.
pub fn enclose(points: impl IntoIterator<Item = Vec3>) -> (Vec3, Vec3) {
    points
        .into_iter()
        .filter(|p| p.is_finite())
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

/// Centre and half sides of the box, made finite and nowhere too thin.
fn usable((low, high): (Vec3, Vec3)) -> (Vec3, Vec3) {
    // Beyond this a squared distance leaves f32.
    const LARGEST: f32 = 1e15;
    let sane = low.is_finite() && high.is_finite() && low.cmple(high).all();
    if !sane || low.abs().max(high.abs()).max_element() > LARGEST {
        return (Vec3::ZERO, Vec3::splat(0.5));
    }
    let center = 0.5 * (low + high);
    let half = 0.5 * (high - low);
    // A point far from the origin needs room for the rounding of its own coordinates.
    let longest = half.max_element().max(center.abs().max_element() * 1e-4);
    let longest = if longest > 1e-12 { longest } else { 0.5 };
    (center, half.max(Vec3::splat(longest * THINNEST)))
}

fn corners(half: Vec3) -> impl Iterator<Item = Vec3> {
    (0..8).map(move |i: u32| {
        let sign = |bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
        half * Vec3::new(sign(1), sign(2), sign(4))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const DIRECTIONS: [Direction; 6] = [
        Direction::FRONT,
        Direction::SIDE,
        Direction::THREE_QUARTER,
        Direction { azimuth: 200.0, elevation: -35.0 },
        Direction { azimuth: 10.0, elevation: 90.0 },
        Direction { azimuth: -120.0, elevation: -90.0 },
    ];

    fn projected(camera: &Camera, (low, high): (Vec3, Vec3)) -> Vec<Vec3> {
        let center = 0.5 * (low + high);
        corners(0.5 * (high - low)).map(|c| camera.view_projection().project_point3(center + c)).collect()
    }

    /// Largest |x| or |y| of the box's corners in the picture, and the range of depths.
    fn extent(camera: &Camera, bounds: (Vec3, Vec3)) -> (f32, f32, f32) {
        let points = projected(camera, bounds);
        let reach = points.iter().map(|p| p.x.abs().max(p.y.abs())).fold(0.0, f32::max);
        let (near, far) = points.iter().fold((f32::MAX, f32::MIN), |(n, f), p| (n.min(p.z), f.max(p.z)));
        (reach, near, far)
    }

    #[test]
    fn the_whole_box_fills_the_picture_from_everywhere() {
        let boxes = [
            (Vec3::new(-0.9, 0.0, -0.2), Vec3::new(0.9, 1.8, 0.3)),
            (Vec3::new(5.0, -2.0, 7.0), Vec3::new(7.0, 30.0, 9.0)),
            (Vec3::splat(-1e-4), Vec3::splat(1e-4)),
            (Vec3::splat(-3e5), Vec3::splat(3e5)),
        ];
        for bounds in boxes {
            for direction in DIRECTIONS {
                for aspect in [0.3, 0.8, 1.0, 2.5] {
                    let camera = Camera::frame(bounds, direction, aspect);
                    let (reach, near, far) = extent(&camera, bounds);
                    assert!((0.93..=0.9401).contains(&reach), "{reach} for {bounds:?} {direction:?} {aspect}");
                    assert!(near > 0.0 && far < 1.0, "{near} {far} for {bounds:?} {direction:?}");
                }
            }
        }
    }

    #[test]
    fn a_box_that_grew_after_framing_leaves_the_picture() {
        let bounds = (Vec3::splat(-1.0), Vec3::splat(1.0));
        let camera = Camera::frame(bounds, Direction::FRONT, 1.0);
        let (reach, ..) = extent(&camera, (Vec3::splat(-1.1), Vec3::splat(1.1)));
        assert!(reach > 1.0);
    }

    #[test]
    fn points_fill_the_picture_where_their_box_would_not() {
        // A leaning rod: its box is far wider, seen from this side, than the rod.
        let rod: Vec<Vec3> = (0..100).map(|i| Vec3::new(1.0, 2.0, 0.7) * (i as f32 / 99.0)).collect();
        let direction = Direction { azimuth: 55.0, elevation: 0.0 };
        let reach = |camera: &Camera| {
            let seen = rod.iter().map(|&p| camera.view_projection().project_point3(p));
            seen.map(|p| p.x.abs().max(p.y.abs())).fold(0.0, f32::max)
        };
        let around = Camera::around(&rod, direction, 0.3);
        assert!((0.93..=0.9401).contains(&reach(&around)), "{}", reach(&around));
        let boxed = Camera::frame((Vec3::ZERO, Vec3::new(1.0, 2.0, 0.7)), direction, 0.3);
        assert!(reach(&boxed) < 0.9 * reach(&around));
        for odd in [vec![], vec![Vec3::ONE], vec![Vec3::NAN, Vec3::ONE]] {
            let camera = Camera::around(&odd, direction, 1.0);
            assert!(camera.near > 0.0 && camera.far > camera.near && camera.view_projection().is_finite());
        }
    }

    #[test]
    fn odd_boxes_yield_finite_cameras() {
        let odd = [
            (Vec3::INFINITY, Vec3::NEG_INFINITY),
            (Vec3::NAN, Vec3::ONE),
            (Vec3::ONE, Vec3::ONE),
            (Vec3::ZERO, Vec3::ZERO),
            (Vec3::splat(1e6), Vec3::splat(1e6)),
            (Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0)),
            (Vec3::new(0.0, 0.0, -1.0), Vec3::new(0.0, 0.0, 1.0)),
            (Vec3::splat(-1e30), Vec3::splat(1e30)),
            (Vec3::splat(1e-30), Vec3::splat(2e-30)),
        ];
        for bounds in odd {
            for direction in DIRECTIONS {
                let camera = Camera::frame(bounds, direction, 1.5);
                assert!(camera.near > 0.0 && camera.far > camera.near, "{camera:?}");
                let m = camera.view_projection();
                assert!(m.is_finite() && m.determinant() != 0.0, "{bounds:?} {direction:?} {m}");
            }
        }
        assert!(
            Camera::frame((Vec3::ZERO, Vec3::ONE), Direction { azimuth: f32::NAN, elevation: 0.0 }, -1.0)
                .view_projection()
                .is_finite()
        );
    }

    #[test]
    fn boxes_enclose_what_is_finite() {
        let points = [Vec3::new(1.0, -2.0, 3.0), Vec3::NAN, Vec3::new(-1.0, 5.0, 3.0), Vec3::INFINITY];
        assert_eq!(enclose(points), (Vec3::new(-1.0, -2.0, 3.0), Vec3::new(1.0, 5.0, 3.0)));
        assert_eq!(enclose([]), (Vec3::INFINITY, Vec3::NEG_INFINITY));
    }

    #[test]
    fn directions_look_where_they_say() {
        let bounds = (Vec3::splat(-1.0), Vec3::splat(1.0));
        let front = Camera::frame(bounds, Direction::FRONT, 1.0);
        assert!(front.eye.z > 1.0 && front.eye.x.abs() < 1e-5 && front.eye.y.abs() < 1e-5);
        assert!(front.view_projection().project_point3(Vec3::X).x > 0.1);
        assert!(front.view_projection().project_point3(Vec3::Y).y > 0.1);
        let side = Camera::frame(bounds, Direction::SIDE, 1.0);
        assert!(side.eye.x > 1.0);
        assert!(side.view_projection().project_point3(Vec3::Z).x < -0.1);
        let above = Camera::frame(bounds, Direction { azimuth: 0.0, elevation: 90.0 }, 1.0);
        assert!(above.eye.y > 1.0);
        assert!(above.view_projection().project_point3(Vec3::NEG_Z).y > 0.1);
    }
}
