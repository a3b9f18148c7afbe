//! Against lengths and moment arms that OpenSim 4.6 computed, with the bodies' poses at every angle: `SINEW_DATA`.

use super::*;
use glam::{DMat3, DMat4, DVec3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Largest error of a length, metres.
const LENGTH: f64 = 1e-4;
/// Largest error of a moment arm, metres, or that share of it. The arm is the slope of the lengths 5 degrees to both sides,
/// which is not quite the arm where a wrap takes hold in between.
const ARM: (f64, f64) = (6e-4, 0.02);

/// A cylinder in its body's frame.
struct Obstacle {
    body: String,
    to_body: DMat4,
    radius: f32,
    half_length: f32,
    /// The side of its frame on which muscles lie, where the model says it.
    quadrant: Option<Vec3>,
}

/// A model's muscles over the angles of one joint.
struct Model {
    /// Body and place on it, of every point of every muscle.
    points: BTreeMap<String, Vec<(String, DVec3)>>,
    obstacles: BTreeMap<String, Obstacle>,
    /// The obstacles of every muscle.
    wraps: BTreeMap<String, Vec<String>>,
    /// Bodies' poses at every angle, degrees.
    poses: Vec<(f64, BTreeMap<String, DMat4>)>,
    /// OpenSim's length and moment arm at every angle, metres.
    expected: BTreeMap<String, Vec<(f64, f64)>>,
}

/// The rows of a table, by column.
fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    reader.deserialize().map(|row| row.expect("a row")).collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|e| panic!("{column} `{}`: {e}", row[column]))
}

fn numbers<const N: usize>(row: &BTreeMap<String, String>, columns: [&str; N]) -> [f64; N] {
    columns.map(|column| number(row, column))
}

impl Model {
    fn read(folder: &Path, name: &str, joint: &str, angle: &str) -> Model {
        let table = |what: &str| rows(&folder.join(format!("{name}_{what}.csv")));
        let mut points: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for row in table("points").iter().filter(|row| row["kind"] != "wrap") {
            let at = DVec3::from(numbers(row, ["x", "y", "z"]));
            points.entry(row["muscle"].clone()).or_default().push((row["body"].clone(), at));
        }
        let cylinders = table("wraps").into_iter().filter(|row| row["type"] == "cylinder");
        let obstacle = |row: BTreeMap<String, String>| {
            let [x, y, z] = numbers(&row, ["rx", "ry", "rz"]);
            let turn = DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y) * DMat3::from_rotation_z(z);
            let half_space = |name: &str| match name {
                "x" => Vec3::X,
                "-x" => Vec3::NEG_X,
                "y" => Vec3::Y,
                "-y" => Vec3::NEG_Y,
                _ => panic!("quadrant {name}"),
            };
            let obstacle = Obstacle {
                body: row["body"].clone(),
                to_body: DMat4::from_translation(DVec3::from(numbers(&row, ["px", "py", "pz"])))
                    * DMat4::from_mat3(turn),
                radius: number(&row, "radius") as f32,
                half_length: 0.5 * number(&row, "length") as f32,
                quadrant: (row["quadrant"] != "all").then(|| half_space(&row["quadrant"])),
            };
            (row["wrap"].clone(), obstacle)
        };
        let obstacles: BTreeMap<_, _> = cylinders.map(obstacle).collect();
        let wraps_of = |row: &BTreeMap<String, String>| {
            let names = row["wraps"].split(';').filter(|wrap| obstacles.contains_key(*wrap));
            (row["muscle"].clone(), names.map(str::to_owned).collect())
        };
        let wraps = table("muscles").iter().map(wraps_of).collect();
        let mut poses: Vec<(f64, BTreeMap<String, DMat4>)> = Vec::new();
        for row in table(&format!("{joint}_sweep_bodies")) {
            let degrees = number(&row, angle);
            if poses.last().is_none_or(|(last, _)| *last != degrees) {
                poses.push((degrees, BTreeMap::new()));
            }
            let column = |c: usize| DVec3::from([0, 1, 2].map(|r| number(&row, &format!("r{r}{c}"))));
            let turn = DMat3::from_cols(column(0), column(1), column(2));
            let pose = DMat4::from_translation(DVec3::from(numbers(&row, ["tx", "ty", "tz"]))) * DMat4::from_mat3(turn);
            poses.last_mut().expect("a pose").1.insert(row["body"].clone(), pose);
        }
        let mut expected: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for row in table(&format!("{joint}_sweep")) {
            let pair = (number(&row, "mt_length_m"), number(&row, "moment_arm_m"));
            expected.entry(row["muscle"].clone()).or_default().push(pair);
        }
        Model { points, obstacles, wraps, poses, expected }
    }

    fn places(&self, muscle: &str, pose: usize) -> Vec<DVec3> {
        let bodies = &self.poses[pose].1;
        self.points[muscle].iter().map(|(body, at)| bodies[body].transform_point3(*at)).collect()
    }

    /// The ends of every straight part of a muscle, in an obstacle's frame.
    fn parts(&self, muscle: &str, obstacle: &Obstacle, pose: usize) -> Vec<[Vec3; 2]> {
        let to_frame = (self.poses[pose].1[&obstacle.body] * obstacle.to_body).inverse();
        let places: Vec<Vec3> =
            self.places(muscle, pose).iter().map(|p| to_frame.transform_point3(*p).as_vec3()).collect();
        places.windows(2).map(|w| [w[0], w[1]]).collect()
    }

    /// Lengths at every angle, metres. Sides are chosen at the first one.
    fn lengths(&self, muscle: &str, with_wraps: bool, finite: bool) -> Vec<f64> {
        let length = |pose: usize| {
            let straight: f64 = self.places(muscle, pose).windows(2).map(|w| w[0].distance(w[1])).sum();
            let wraps = self.wraps[muscle].iter().filter(|_| with_wraps).map(|name| &self.obstacles[name]);
            straight + wraps.map(|obstacle| self.added(muscle, obstacle, pose, finite)).sum::<f64>()
        };
        (0..self.poses.len()).map(length).collect()
    }

    /// What an obstacle adds to the length: OpenSim bends the first part that it hits, and none with an end inside it.
    fn added(&self, muscle: &str, obstacle: &Obstacle, pose: usize, finite: bool) -> f64 {
        let (radius, half) = (obstacle.radius, obstacle.half_length);
        let bone = if finite { Cylinder { radius, low: -half, high: half } } else { Cylinder::endless(radius) };
        let rest = self.parts(muscle, obstacle, 0);
        for (ends, rest) in self.parts(muscle, obstacle, pose).into_iter().zip(rest) {
            if ends.iter().any(|end| end.xy().length() < radius) {
                continue;
            }
            let side = cylinder::side_at_rest(rest[0], rest[1], &bone, obstacle.quadrant).expect("a side");
            let path = cylinder::path(ends[0], ends[1], &bone, side);
            if path.touches() {
                return f64::from(path.length()) - f64::from(ends[0].distance(ends[1]));
            }
        }
        0.0
    }

    /// Largest errors of length (metres) and of moment arm (in what is allowed).
    fn errors(&self, muscle: &str, lengths: &[f64]) -> (f64, f64) {
        let (mut worst, mut worst_arm) = (0.0f64, 0.0f64);
        for (i, &(length, arm)) in self.expected[muscle].iter().enumerate() {
            worst = worst.max((lengths[i] - length).abs());
            if i > 0 && i + 1 < lengths.len() {
                let angle = (self.poses[i + 1].0 - self.poses[i - 1].0).to_radians();
                let error = (-(lengths[i + 1] - lengths[i - 1]) / angle - arm).abs();
                worst_arm = worst_arm.max(error / ARM.0.max(ARM.1 * arm.abs()));
            }
        }
        (worst, worst_arm)
    }
}

/// The two models, or nothing with a word in the output where the data folder is absent.
fn models() -> Option<[Model; 2]> {
    let Some(folder) = std::env::var_os("SINEW_DATA").map(|data| PathBuf::from(data).join("muscles")) else {
        println!("SINEW_DATA is not set: paths are not compared with OpenSim's");
        return None;
    };
    let arm = Model::read(&folder, "arm26", "elbow", "r_elbow_flex_deg");
    Some([arm, Model::read(&folder, "rajagopal2016", "knee", "knee_angle_r_deg")])
}

/// Muscles whose lengths in the sweeps are fair to compare with and that a cylinder bends somewhere, by model.
const BENT: [&[&str]; 2] = [
    &["TRIlat", "TRImed", "BRA"],
    &["bfsh_r", "grac_r", "semimem_r", "semiten_r", "recfem_r", "vasint_r", "vaslat_r", "vasmed_r"],
];
/// Muscles of straight parts alone.
const STRAIGHT: [&[&str]; 2] = [&["BICshort"], &["bflh_r", "sart_r", "tfl_r"]];

#[test]
fn lengths_and_moment_arms_are_those_of_opensim() {
    let Some(models) = models() else { return };
    for (model, (bent, straight)) in models.iter().zip(BENT.into_iter().zip(STRAIGHT)) {
        for muscle in bent.iter().chain(straight) {
            // All of these touch between their cylinders' ends.
            for finite in [false, true] {
                let (length, arm) = model.errors(muscle, &model.lengths(muscle, true, finite));
                println!("{muscle}: length {:.4} mm, moment arm {arm:.3} of what is allowed", length * 1e3);
                assert!(length < LENGTH, "{muscle}: length off by {length} m");
                assert!(arm < 1.0, "{muscle}: moment arm off by {arm} times what is allowed");
            }
        }
        for muscle in bent {
            let (length, arm) = model.errors(muscle, &model.lengths(muscle, false, true));
            println!("{muscle} without its wrap: length {:.4} mm, moment arm {arm:.3}", length * 1e3);
            assert!(length > LENGTH && arm > 1.0, "{muscle}: a missing wrap must be seen: {length} m, {arm}");
        }
    }
}

#[test]
fn a_muscle_far_past_a_short_wrap_is_not_bent() {
    // The long head of the triceps has a wrap of 30 mm at the shoulder, whose cylinder goes on through the arm.
    let Some([arm, _]) = models() else { return };
    let (length, moment) = arm.errors("TRIlong", &arm.lengths("TRIlong", true, true));
    println!("TRIlong: length {:.4} mm, moment arm {moment:.3} of what is allowed", length * 1e3);
    assert!(length < LENGTH && moment < 1.0, "{length} m, {moment}");
    let (endless, _) = arm.errors("TRIlong", &arm.lengths("TRIlong", true, false));
    assert!(endless > 1e-3, "an endless wrap must be seen: {endless} m");
}
