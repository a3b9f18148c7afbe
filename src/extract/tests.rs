//! Limbs made from known muscles: how many are found, and where; and what is found under odd skins.

use super::{
    chain::{Belly, Section, Settings, bellies, link},
    section::{Plane, Surface, cut},
    window::Outline,
};
use crate::error::ExtractNote;
use crate::field::muscle::profile::Profile;
use crate::rig::{Character, roles::Roles};
use glam::{DVec2, DVec3, Mat4, Quat, Vec3};
use std::f64::consts::TAU;

/// A muscle along a limb of a made size: where it lies around the bone, radians, its axis' distance from the bone, its
/// largest radius, metres, that radius out of the limb over it, its extent along the limb, 0..=1, and its exponents.
#[derive(Clone, Copy)]
pub struct Known {
    pub angle: f64,
    pub away: f64,
    pub radius: f64,
    pub flat: f64,
    pub from: f64,
    pub to: f64,
    pub exponents: (u32, u32),
}

impl Known {
    pub fn new(angle: f64) -> Known {
        Known { angle, away: 0.024, radius: 0.019, flat: 1.0, from: 0.12, to: 0.88, exponents: (3, 3) }
    }

    fn radius_at(&self, t: f64) -> f64 {
        let s = (t - self.from) / (self.to - self.from);
        if !(0.0..=1.0).contains(&s) {
            return 0.0;
        }
        let profile = Profile::of(self.exponents.0, self.exponents.1);
        self.radius * f64::from(profile.at(s as f32).0 / profile.max())
    }
}

pub const LENGTH: f64 = 0.3;

/// A limb along z, 30 cm long, whose skin is drawn over muscles on a cone that goes from 36 mm to 36 mm less `taper`.
pub fn limb(muscles: &[Known], taper: f64, noise: f64) -> Surface {
    let (rings, around) = (121, 120);
    let mut random = 12345u64;
    let mut next = || {
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (random >> 33) as f64 / (1u64 << 31) as f64 * 2.0 - 1.0
    };
    let mut surface = Surface::default();
    for ring in 0..rings {
        let t = ring as f64 / (rings - 1) as f64;
        for k in 0..around {
            let way = DVec2::from_angle(TAU * k as f64 / around as f64);
            let mut out = 0.036 - taper * t;
            for muscle in muscles {
                let (centre, radius) = (DVec2::from_angle(muscle.angle) * muscle.away, muscle.radius_at(t));
                // Across the limb the section is a circle's; out of the limb it is flatter.
                let (long, short) = (DVec2::from_angle(muscle.angle).perp(), DVec2::from_angle(muscle.angle));
                let in_units = |v: DVec2| DVec2::new(v.dot(long), v.dot(short) / muscle.flat);
                let (w, c) = (in_units(way), in_units(centre));
                let (size, along) = (w.length(), in_units(centre).dot(in_units(way)) / in_units(way).length());
                let off = w.perp_dot(c) / size;
                if off.abs() < radius {
                    let far = (along + (radius * radius - off * off).sqrt()) / size;
                    let h = (0.5 + 0.5 * (out - far) / 0.003).clamp(0.0, 1.0);
                    out = far + (out - far) * h + 0.003 * h * (1.0 - h);
                }
            }
            surface.positions_rest.push((way * (out + noise * next())).extend(LENGTH * t));
        }
    }
    for ring in 0..rings as u32 - 1 {
        for k in 0..around as u32 {
            let at = |r: u32, k: u32| r * around as u32 + k % around as u32;
            surface.triangles.push([at(ring, k), at(ring, k + 1), at(ring + 1, k + 1)]);
            surface.triangles.push([at(ring, k), at(ring + 1, k + 1), at(ring + 1, k)]);
        }
    }
    surface
}

fn sections(surface: &Surface) -> Vec<Section> {
    let planes =
        (0..33).map(|k| Plane::across(DVec3::Z * LENGTH * (0.01 + 0.98 * f64::from(k) / 32.0), DVec3::Z, DVec3::X));
    let section = |(k, plane): (usize, Plane)| {
        let cuts = cut(surface, &plane);
        Section::new(k, plane, &Outline::whole(cuts.first().expect("a cut")), &Settings::ARM).expect("simple")
    };
    planes.enumerate().map(section).collect()
}

fn found(surface: &Surface) -> (Vec<Section>, Vec<Belly>) {
    let sections = sections(surface);
    let found = link(&sections, &Settings::ARM).iter().flat_map(|chain| bellies(&sections, chain)).collect();
    (sections, found)
}

#[test]
fn muscles_are_counted_and_lie_where_they_are() {
    let (mut peaks, mut ends) = (Vec::new(), Vec::new());
    for (flat, noise) in [(1.0, 0.0), (1.0, 0.0003), (0.8, 0.0), (0.8, 0.0003)] {
        let known = [
            Known { flat, ..Known::new(0.5) },
            Known { flat, radius: 0.016, away: 0.026, exponents: (3, 5), ..Known::new(2.2) },
            Known { flat, radius: 0.017, away: 0.025, exponents: (4, 3), ..Known::new(3.9) },
            Known { flat, radius: 0.018, from: 0.2, ..Known::new(5.2) },
        ];
        for count in 0..=known.len() {
            let (sections, found) = found(&limb(&known[..count], 0.004, noise));
            let told = |b: &Belly| {
                format!(
                    "{} links at {:.2} up {:.4} long {:.3} prominence {:.2} sharp {:.2}",
                    b.links.len(),
                    b.roots_rest[0].truncate().to_angle().rem_euclid(TAU),
                    b.height,
                    b.length,
                    b.prominence,
                    b.sharpness
                )
            };
            assert_eq!(
                found.len(),
                count,
                "flat {flat} noise {noise}: {:#?}",
                found.iter().map(told).collect::<Vec<_>>()
            );
            for muscle in &known[..count] {
                let axis = DVec2::from_angle(muscle.angle) * muscle.away;
                let offs = |belly: &Belly| -> Vec<f64> {
                    belly.roots_rest.iter().map(|p| p.truncate().distance(axis)).collect()
                };
                let mean = |belly: &Belly| offs(belly).iter().sum::<f64>() / belly.links.len() as f64;
                let belly = found.iter().min_by(|a, b| mean(a).total_cmp(&mean(b))).expect("a belly");
                let most = offs(belly).iter().copied().fold(0.0, f64::max);
                let (s, out): (Vec<f64>, Vec<f64>) = belly.reach(&sections);
                let fit = super::fit::profile(&s, &out).expect("a profile");
                let [a, b] = belly.ends(&sections).map(|p| p.z / LENGTH);
                let place = a + (b - a) * fit.peak;
                let (alpha, beta) = muscle.exponents;
                let peak = f64::from(alpha - 1) / f64::from(alpha + beta - 2);
                let peak = muscle.from + (muscle.to - muscle.from) * peak;
                peaks.push((place - peak).abs() / (muscle.to - muscle.from));
                // Where a muscle thins out its neighbour's crease is nearer than its own crest: one end in some is off further.
                assert!(mean(belly) < 0.004 && most < 0.012, "flat {flat} noise {noise}: {:.4} {most:.4}", mean(belly));
                ends.push(most);
            }
        }
    }
    peaks.sort_by(f64::total_cmp);
    ends.sort_by(f64::total_cmp);
    println!("farthest off: median {:.4} most {:.4}", ends[ends.len() / 2], ends[ends.len() - 1]);
    assert!(ends[ends.len() / 2] < 0.005 && peaks[peaks.len() / 2] < 0.03 && peaks[peaks.len() - 1] < 0.12);
    println!("peaks: median {:.3} most {:.3}", peaks[peaks.len() / 2], peaks[peaks.len() - 1]);
}

/// The athletic man of the data folder; `None`, said aloud, where `SINEW_DATA` is not set.
fn athlete() -> Option<Character> {
    let Some(data) = std::env::var_os("SINEW_DATA").map(std::path::PathBuf::from) else {
        println!("SINEW_DATA is not set: odd skins are not tested");
        return None;
    };
    Some(crate::io::gltf::read(&data.join("humans/mh_male_athletic.glb")).expect("a human").character)
}

fn names(character: &Character) -> (Vec<String>, Vec<ExtractNote>) {
    let found = super::extract(character, &Roles::find(character), &[]).expect("muscles");
    (found.muscles.into_iter().map(|m| m.spec.name).collect(), found.notes)
}

/// A vertex with the influences of another.
fn add(character: &mut Character, at: Vec3, like: u32) -> u32 {
    let own = character.influences_of(like as usize).to_vec();
    character.positions_rest.push(at);
    character.normals_rest.push(Vec3::Y);
    character.uvs.push(Default::default());
    character.influences.extend(own);
    character.influence_offsets.push(character.influences.len() as u32);
    character.vertex_count() as u32 - 1
}

#[test]
fn odd_skins_have_their_muscles_and_a_note() {
    let Some(whole) = athlete() else { return };
    let (muscles, notes) = names(&whole);
    // Eye sockets and the mouth are open.
    assert!(muscles.len() > 40 && notes.iter().all(|n| matches!(n, ExtractNote::Open { .. })), "{notes:?}");
    let mut inside_out = whole.clone();
    inside_out.triangles.iter_mut().for_each(|t| t.reverse());
    let (found, notes) = names(&inside_out);
    assert!(found == muscles && notes.contains(&ExtractNote::InsideOut), "{notes:?}");
    let turn = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let mut z_up = whole.clone();
    z_up.positions_rest.iter_mut().for_each(|p| *p = turn * *p);
    z_up.joints.iter_mut().for_each(|j| j.inverse_bind *= Mat4::from_quat(turn.inverse()));
    let common = |found: &[String]| found.iter().filter(|name| muscles.contains(name)).count();
    let (found, _) = names(&z_up);
    assert!(common(&found) + 2 >= muscles.len(), "{found:?}");
    // A hole in a thigh takes planes from it, and no muscle from elsewhere.
    let mut open = whole.clone();
    let knee = Roles::find(&whole).legs[0].places[1];
    let near = |v: u32| whole.positions_rest[v as usize].distance(knee + Vec3::new(0.0, 0.2, 0.1)) < 0.05;
    open.triangles.retain(|t| !t.iter().all(|&v| near(v)));
    assert!(open.triangles.len() < whole.triangles.len());
    let (found, notes) = names(&open);
    let kept = muscles.iter().filter(|name| found.contains(name) || name.ends_with("_l")).count();
    assert!(kept + 1 >= muscles.len() && notes.iter().any(|n| matches!(n, ExtractNote::Open { .. })), "{found:?}");
    let mut odd = whole.clone();
    let [a, b, _] = odd.triangles[0];
    let (from, to) = (odd.positions_rest[a as usize], odd.positions_rest[b as usize]);
    let fin = add(&mut odd, from + Vec3::splat(0.01), a);
    let between = add(&mut odd, from.lerp(to, 0.5), a);
    let far = [0.0, 0.1, 0.2].map(|x| add(&mut odd, Vec3::new(3.0 + x, x * x, 0.0), a));
    odd.triangles.extend([[a, b, fin], [a, b, between], far]);
    let (found, notes) = names(&odd);
    assert!(common(&found) + 2 >= muscles.len(), "{found:?}");
    assert!(notes.iter().any(|n| matches!(n, ExtractNote::Crowded { .. })), "{notes:?}");
    assert!(notes.iter().any(|n| matches!(n, ExtractNote::Flat { .. })), "{notes:?}");
    assert!(notes.iter().any(|n| matches!(n, ExtractNote::Shells { .. })), "{notes:?}");
}
