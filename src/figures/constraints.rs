//! Figure 8: the constraints of a muscle: the springs of its axis, and what holds its particles off bones, off other
//! muscles and in the skin. Each is a moment of the arm's own motion, cut at a particle that is pushed.

use super::motion::{BICEPS, Play, away, flexed, humerus, muscle};
use super::plot::{INK, Label, PALE, Page, Rect, SERIES, arrow, polyline};
use super::section::{Moment, Plane, circle, outline, spring};
use super::{Arm, Drawn, Figure, Finding};
use crate::dynamics::{Particle, settle};
use crate::error::FigureError;
use crate::rig::Rig;
use crate::schedule::DynamicsOptions;
use glam::{Mat3, Vec3, Vec4Swizzles};

const PANEL: [u32; 2] = [640, 430];
const TITLE: u32 = 66;
const GAP: u32 = 16;
/// Metres across the pictures: the whole muscle, and what touches.
const WHOLE: f32 = 0.34;
const NEAR: f32 = 0.16;
/// Gap or overlap, metres, that cannot be seen in them: it is less than a pixel.
const TOUCHES: f32 = 2e-4;
/// sRGB of springs and tendons.
const SPRING: [u8; 3] = [0, 90, 50];
const TENDON: [u8; 3] = [60, 50, 40];

/// What pushes a particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Bone,
    Muscle,
    Skin,
}

impl Kind {
    const ALL: [Kind; 3] = [Kind::Bone, Kind::Muscle, Kind::Skin];

    fn title(self) -> &'static str {
        match self {
            Kind::Bone => "Bone: spheres of radius *w* Φ(*p*_i) stay off it",
            Kind::Muscle => "Muscle: spheres stay off the other's *f*_{ M}, and it gives way",
            Kind::Skin => "Skin: particles stay in the HRBF's 0.5-surface",
        }
    }

    fn name(self) -> &'static str {
        match self {
            Kind::Bone => "bone",
            Kind::Muscle => "muscle",
            Kind::Skin => "skin",
        }
    }

    /// As the view of muscles has it.
    fn color(self) -> [u8; 3] {
        match self {
            Kind::Bone => SERIES[5],
            Kind::Muscle => SERIES[1],
            Kind::Skin => SERIES[3],
        }
    }

    /// How far it kept a particle from where its springs would have it in the last substep, metres.
    fn push(self, particle: &Particle) -> f32 {
        let pushes = particle.pushes;
        let push = match self {
            Kind::Bone => pushes.z,
            Kind::Muscle => pushes.x.max(pushes.y),
            Kind::Skin => pushes.w,
        };
        push * particle.velocity.w
    }
}

/// A particle that is pushed.
#[derive(Clone, Copy)]
struct Held {
    kind: Kind,
    /// Its muscle, and its own number in it.
    muscle: usize,
    number: usize,
    /// How far the contact keeps it, in the last substep, from where its springs would have it, metres.
    push: f32,
    /// That times its radius.
    shows: f32,
}

/// The arm whose upper muscles collide with one another too.
fn crowded(arm: &Arm) -> Rig {
    let mut rig = (*arm.rig).clone();
    for spec in rig.specs.iter_mut().filter(|spec| spec.bone == "upperarm") {
        spec.collision_group = "upper arm".into();
    }
    settle(&mut rig, &DynamicsOptions::default());
    rig
}

/// A muscle's own particles.
fn own<'a>(rig: &Rig, play: &'a Play<'_>, index: usize) -> &'a [Particle] {
    let rest = &rig.muscles[index];
    &play.simulation.particles[rest.first_point as usize..][..=rest.segments as usize]
}

/// The particle outside the tendons that is pushed most by a kind alone and touches it; large ones show more, so that less
/// will do.
fn most_held(moment: &Moment<'_>, kind: Kind) -> Held {
    let mut most = Held { kind, muscle: 0, number: 0, push: 0.0, shows: 0.0 };
    for muscle in 0..moment.rig.muscles.len() {
        let own = own(moment.rig, &moment.play, muscle);
        for (number, particle) in own.iter().enumerate().filter(|(_, p)| p.traits.x >= 1.0) {
            let alone = Kind::ALL.into_iter().all(|other| other == kind || other.push(particle) == 0.0);
            let push = if alone { kind.push(particle) } else { 0.0 };
            let held = Held { kind, muscle, number, push, shows: push * particle.position.w };
            if held.shows > most.shows && held.contact(moment).1.abs() < TOUCHES {
                most = held;
            }
        }
    }
    most
}

/// Of all frames of the flexion, the moments at which each kind pushes most.
///
/// # Errors
/// A kind pushes nowhere.
fn moments<'a>(arm: &Arm, rig: &'a Rig) -> Result<Vec<(Held, Moment<'a>)>, FigureError> {
    let mut play = Play::new(rig, &DynamicsOptions::default());
    let mut found: Vec<(Held, Moment<'a>)> = Vec::new();
    for pose in flexed(arm) {
        play.next(&pose)?;
        let moment = Moment { rig, pose, play: play.clone() };
        for (i, kind) in Kind::ALL.into_iter().enumerate() {
            let held = most_held(&moment, kind);
            match found.get_mut(i) {
                None => found.push((held, moment.clone())),
                Some(known) if held.shows > known.0.shows => *known = (held, moment.clone()),
                Some(_) => {}
            }
        }
    }
    if found.iter().any(|(held, _)| held.push == 0.0) {
        return Err(Figure::Constraints.lacks("muscles of the built-in arm that touch bone, muscle and skin"));
    }
    Ok(found)
}

impl Held {
    fn particle<'a>(&self, moment: &'a Moment<'_>) -> &'a Particle {
        &own(moment.rig, &moment.play, self.muscle)[self.number]
    }

    /// The other muscle that presses on it, and the plane's normal in scene space at rest.
    fn peer(&self, moment: &Moment<'_>) -> Option<(usize, Vec3)> {
        let p = self.particle(moment);
        let (name, plane) = if p.pushes.x >= p.pushes.y { (p.traits.z, p.peer_0) } else { (p.traits.w, p.peer_1) };
        (name > 0.0).then(|| (name as usize - 1, plane.xyz()))
    }

    /// Unit direction in which it is pushed, and the gap that is left, metres.
    fn contact(&self, moment: &Moment<'_>) -> (Vec3, f32) {
        let particle = self.particle(moment);
        let (p, radius) = (particle.position.xyz(), particle.position.w);
        match self.kind {
            Kind::Bone => {
                let (distance, outward) = moment.bone(p);
                (outward, distance - radius)
            }
            Kind::Skin => {
                let (distance, outward) = moment.skin(p);
                (-outward.normalize_or_zero(), -distance)
            }
            Kind::Muscle => {
                let Some((other, normal)) = self.peer(moment) else { return (Vec3::Y, 0.0) };
                let joint = moment.rig.muscles[self.muscle].joint;
                let turn = Mat3::from_mat4(moment.pose.palette[joint as usize]).inverse().transpose();
                ((turn * normal).normalize_or_zero(), moment.muscle(other, p) - radius)
            }
        }
    }

    fn words(&self, moment: &Moment<'_>) -> String {
        let names = &moment.rig.muscle_names;
        let by = self.peer(moment).filter(|_| self.kind == Kind::Muscle);
        let by = by.map_or(String::new(), |(other, _)| format!(" on {}", names[other]));
        let text = format!(
            "{}{by}, particle {} of {}",
            names[self.muscle],
            self.number,
            moment.rig.muscles[self.muscle].segments + 1
        );
        text.replace('_', " ")
    }

    /// The picture of what holds it.
    fn page(&self, moment: &Moment<'_>) -> Result<Page, FigureError> {
        let particles = own(moment.rig, &moment.play, self.muscle);
        let center = particles[self.number].position.xyz();
        let (direction, _) = self.contact(moment);
        let along = particles[self.number + 1].position.xyz() - particles[self.number - 1].position.xyz();
        let plane = Plane::new(center, along, direction, PANEL, NEAR);
        let mut page = moment.page(&plane, self.muscle)?;
        for particle in particles.iter().filter(|p| plane.shows(plane.at(p.position.xyz()))) {
            let radius = f64::from(particle.position.w * plane.scale);
            polyline(&mut page, &circle(plane.at(particle.position.xyz()), radius), [150, 120, 115], 0.8)?;
        }
        axis(&mut page, &plane, particles)?;
        let [x, y] = plane.at(center);
        if self.kind != Kind::Skin {
            let radius = f64::from(particles[self.number].position.w * plane.scale);
            polyline(&mut page, &circle([x, y], radius), self.kind.color(), 2.6)?;
            polyline(&mut page, &[[x, y], [x, y + radius]], INK, 1.4)?;
            Label { rimmed: true, ..Label::new("*w* Φ", 17.0) }.draw(&mut page, x + 26.0, y + 0.55 * radius)?;
        }
        arrow(&mut page, [x, y], [x, y - 62.0], self.kind.color(), 4.0)?;
        page.dot([x, y], 6.5, self.kind.color())?;
        Label { rimmed: true, ..Label::new("*p*_i", 17.0) }.draw(&mut page, x + 20.0, y - 12.0)?;
        Ok(page)
    }
}

/// Springs, tendons and particles of an axis.
fn axis(page: &mut Page, plane: &Plane, particles: &[Particle]) -> Result<(), FigureError> {
    for pair in particles.windows(2) {
        let [from, to] = [&pair[0], &pair[1]].map(|p| plane.at(p.position.xyz()));
        if !plane.shows(from) || !plane.shows(to) {
            continue;
        }
        if pair[0].traits.y > 1.0 {
            polyline(page, &[from, to], TENDON, 4.0)?;
        } else {
            polyline(page, &spring(from, to, 4.0), SPRING, 1.5)?;
        }
    }
    for particle in particles.iter().filter(|p| plane.shows(plane.at(p.position.xyz()))) {
        let fixed = particle.velocity.w == 0.0;
        page.dot(plane.at(particle.position.xyz()), if fixed { 6.0 } else { 3.6 }, if fixed { INK } else { SPRING })?;
    }
    Ok(())
}

/// The springs of the bent arm's biceps.
fn elastic(moment: &Moment<'_>) -> Option<(Plane, usize)> {
    let index = muscle(moment.rig, BICEPS)?;
    let (line, _) = humerus(moment.rig, &moment.pose)?;
    let particles = own(moment.rig, &moment.play, index);
    let belly = particles[particles.len() / 2].position.xyz();
    let center = (particles[0].position.xyz() + particles[particles.len() - 1].position.xyz() + belly) / 3.0;
    Some((Plane::new(center, line[1] - line[0], away(line, belly), PANEL, WHOLE), index))
}

/// The figure.
pub(super) fn figure(arm: &Arm) -> Result<Drawn, FigureError> {
    let rig = crowded(arm);
    let moments = moments(arm, &rig)?;
    let lacks = || Figure::Constraints.lacks("the built-in arm's biceps and humerus");
    let (plane, index) = moments.first().and_then(|(_, moment)| elastic(moment)).ok_or_else(lacks)?;
    let mut page = Page::new(2 * PANEL[0] + GAP, 2 * (PANEL[1] + TITLE))?;
    let first = &moments[0].1;
    let mut springs = first.page(&plane, index)?;
    axis(&mut springs, &plane, own(&rig, &first.play, index))?;
    let words = "biceps: *l*_0 is 2 % of a segment at rest, 100 % in the tendons, which are ten times stiffer";
    place(&mut page, 0, springs, "Elasticity: springs under tension between the ends", words)?;
    let mut findings = Vec::new();
    for (i, (held, moment)) in (1..).zip(&moments) {
        place(&mut page, i, held.page(moment)?, held.kind.title(), &held.words(moment))?;
        let named = |what: &str| format!("{}: {what}", held.kind.name());
        let (_, gap) = held.contact(moment);
        findings.push(Finding::new(named("gap at the particle shown"), f64::from(gap) * 1000.0, "mm"));
        findings.push(Finding::new(named("springs held off by it, a substep"), f64::from(held.push) * 1000.0, "mm"));
        let particles = &moment.play.simulation.particles;
        let count = particles.iter().filter(|p| held.kind.push(p) > 0.0).count();
        findings.push(Finding::new(named("particles pushed then"), count as f64, ""));
    }
    Ok(Drawn { image: page.finish(), findings })
}

/// Puts a panel into its quarter under its title.
fn place(page: &mut Page, quarter: u32, panel: Page, title: &str, words: &str) -> Result<(), FigureError> {
    let [left, top] = [quarter % 2 * (PANEL[0] + GAP), quarter / 2 * (PANEL[1] + TITLE)];
    page.paste(&panel.finish(), left, top + TITLE);
    outline(page, Rect { left, top: top + TITLE, width: PANEL[0], height: PANEL[1] })?;
    let middle = f64::from(left + PANEL[0] / 2);
    Label::new(title, 19.0).draw(page, middle, f64::from(top) + 24.0)?;
    Label::new(words, 14.0).color(PALE).draw(page, middle, f64::from(top) + 50.0)
}

#[cfg(test)]
mod tests {
    use super::super::motion::tests::arm;
    use super::*;

    #[test]
    fn each_kind_holds_a_particle_where_it_touches() {
        let arm = arm();
        let rig = crowded(&arm);
        for (held, mut moment) in moments(&arm, &rig).expect("frames") {
            assert!(held.push > 0.0, "{:?} pushes nothing", held.kind);
            let (direction, gap) = held.contact(&moment);
            assert!(gap.abs() < TOUCHES, "{:?}: {gap} m", held.kind);
            let first = rig.muscles[held.muscle].first_point as usize;
            let moved = direction.extend(0.0) * 0.005;
            moment.play.simulation.particles[first + held.number].position += moved;
            let (_, beyond) = held.contact(&moment);
            assert!(beyond - gap > 0.003, "pushed farther must be seen, {:?}: {gap} {beyond}", held.kind);
        }
    }
}
