//! One muscle against its springs, neighbours, bones and skin, in one outer iteration. Twin of the kernel
//! `muscle_project`.

use super::{
    BONES, DynamicsParams, Link, MUSCLES, MuscleBody, Particle, SKIN,
    chain::Chain,
    contact::{self, Contact, Surroundings},
    predict::MOST_STIFFNESS,
};
use crate::{field::muscle::axis::run, math::transform_point};
use glam::{Vec3, Vec4, Vec4Swizzles};

/// Order of the kinds in a particle's planes.
const PEERS: std::ops::Range<usize> = 0..2;
const BONE: usize = 2;
const WITHIN: usize = 3;

/// Projects one muscle of one instance: finds the planes it may not pass, runs the inner iterations, and writes its
/// points into `out`, its run of the half that is written. The outer iteration that ends the substep then makes contacts
/// exact, and gives the particles their new places and velocities.
pub fn project(params: &DynamicsParams, index: usize, around: &Surroundings, own: &mut [Particle], out: &mut [Vec4]) {
    let muscle = &around.muscles[index];
    if around.moved[muscle.driver as usize].runs == 0 {
        return;
    }
    let first = run(index, muscle.first_point);
    out.copy_from_slice(&around.iterates[first..first + out.len()]);
    let held = Held::new(params, around, muscle, own, out);
    let mut chain = load(params, around, muscle, own, out);
    for (i, particle) in own.iter_mut().enumerate().take(chain.points - 1).skip(1) {
        let p = chain.at[i];
        let [first, second] = held.peers(i, p, particle);
        chain.planes[i] = [first, second, held.deepest_bone(i, p).plane(p), held.within(i, p).plane(p)];
    }
    chain.iterate(params, out[1].w, params.done);
    if params.ends_substep != 0 {
        for i in 1..chain.points - 1 {
            for _ in 0..params.final_passes {
                let before = chain.at[i];
                held.settle(&mut chain, i);
                // What this has hardly moved, the next pass would not move either.
                if chain.at[i].distance_squared(before) <= contact::LEAST_WAY_SQUARED {
                    break;
                }
            }
        }
    }
    for i in 0..chain.points {
        out[2 + 2 * i] = chain.at[i].extend(out[2 + 2 * i].w);
        own[i].spring = chain.pull[i].extend(own[i].spring.w);
        own[i].pushes = chain.pushes[i].into();
    }
    if params.ends_substep != 0 {
        finish(params, around, muscle, &chain, own);
    }
}

/// Fills a chain from the half that is read.
fn load(params: &DynamicsParams, around: &Surroundings, muscle: &MuscleBody, own: &[Particle], read: &[Vec4]) -> Chain {
    let points = muscle.segments as usize + 1;
    let stiffness = read[0].w;
    let scale = around.moved[muscle.driver as usize].scale;
    let mut chain = Chain::new(points);
    chain.memory = if params.pbd != 0 { 0.0 } else { 1.0 };
    for (i, particle) in own.iter().enumerate() {
        chain.at[i] = read[2 + 2 * i].xyz();
        chain.mobility[i] = particle.velocity.w;
        chain.mass[i] = if particle.velocity.w > 0.0 { 1.0 / particle.velocity.w } else { 0.0 };
        chain.rest[i] = particle.spring.w * scale;
        chain.pull[i] = particle.spring.xyz();
        chain.pushes[i] = particle.pushes.to_array();
    }
    for (j, particle) in own.iter().enumerate().take(points - 1) {
        let mobility = chain.mobility[j] + chain.mobility[j + 1];
        let stiffer = particle.traits.y;
        if params.pbd != 0 {
            chain.gain[j] = (stiffness * stiffer).min(MOST_STIFFNESS) / mobility;
        } else {
            chain.gain[j] = 1.0 / (mobility + stiffness / stiffer);
        }
    }
    chain
}

/// What holds one muscle.
struct Held<'a> {
    around: &'a Surroundings<'a>,
    muscle: &'a MuscleBody,
    peers: &'a [Link],
    bones: &'a [Link],
    skins: &'a [Link],
    /// Radius and share that is kept clear of bones, per point.
    sizes: [(f32, f32); super::chain::MOST],
    /// The muscle's ends.
    ends: (Vec3, Vec3),
    /// How far a plane between muscles may be off before it follows, metres.
    play: f32,
}

impl<'a> Held<'a> {
    fn new(
        params: &DynamicsParams,
        around: &'a Surroundings<'a>,
        muscle: &'a MuscleBody,
        own: &[Particle],
        read: &[Vec4],
    ) -> Held<'a> {
        let range = |kind: u32, from: u32, to: u32| {
            let on = params.contacts & muscle.collides & kind != 0;
            if on { &around.links[from as usize..to as usize] } else { &[] }
        };
        let mut sizes = [(0.0, 0.0); super::chain::MOST];
        for (i, particle) in own.iter().enumerate() {
            sizes[i] = (read[2 + 2 * i].w, particle.traits.x);
        }
        Held {
            around,
            muscle,
            bones: range(BONES, muscle.bones_begin, muscle.peers_begin),
            peers: range(MUSCLES, muscle.peers_begin, muscle.skins_begin),
            skins: range(SKIN, muscle.skins_begin, muscle.links_end),
            sizes,
            ends: (read[2].xyz(), read[2 * own.len()].xyz()),
            play: params.play,
        }
    }

    fn share(&self, i: usize) -> f32 {
        i as f32 / self.muscle.segments as f32
    }

    /// The bone that a particle is deepest in or nearest to.
    fn deepest_bone(&self, i: usize, p: Vec3) -> Contact {
        let mut deepest = Contact::NONE;
        for link in self.bones {
            let found = self.bone(link, i, p);
            if found.distance < deepest.distance {
                deepest = found;
            }
        }
        deepest
    }

    /// Planes against the two muscles that a particle is deepest in or nearest to, in the order of the links.
    ///
    /// Each stands where the two muscles share the gap or the overlap: the lighter one has the larger part of it. The
    /// other one's own plane is the reaction. A plane stays where it was, as the particle's state keeps it, while it is
    /// off by no more than the play; else it follows and stays behind by the play: two muscles that answer one another a
    /// substep later would go on forever otherwise (prototypes 1).
    fn peers(&self, i: usize, p: Vec3, own: &mut Particle) -> [Vec4; 2] {
        // Tendons of one bone meet at it.
        if self.sizes[i].1 < 1.0 || self.peers.is_empty() {
            return [Vec4::ZERO; 2];
        }
        let mut found = [(Contact::NONE, 0); 2];
        for (k, link) in self.peers.iter().enumerate() {
            let contact = self.around.muscle(link, p, self.sizes[i].0);
            if contact.distance < found[0].0.distance {
                found = [(contact, k), found[0]];
            } else if contact.distance < found[1].0.distance {
                found[1] = (contact, k);
            }
        }
        if found[1].1 < found[0].1 && found[1].0.distance < f32::MAX {
            found.swap(0, 1);
        }
        let driver = &self.around.moved[self.muscle.driver as usize];
        let kept = [(own.traits.z, own.peer_0), (own.traits.w, own.peer_1)];
        let planes = found.map(|(contact, k)| {
            if contact.distance == f32::MAX {
                return (0.0, Vec4::ZERO);
            }
            let index = self.peers[k].index;
            let name = index as f32 + 1.0;
            let contact = self.shared(contact, &self.around.muscles[index as usize]);
            let before = kept.iter().find(|(other, _)| *other == name);
            let before = before.map(|(_, plane)| contact::posed(plane, driver));
            (name, contact::follow(before, &contact, p, self.play))
        });
        (own.traits.z, own.traits.w) = (planes[0].0, planes[1].0);
        (own.peer_0, own.peer_1) = (contact::rest(&planes[0].1, driver), contact::rest(&planes[1].1, driver));
        planes.map(|(_, plane)| plane)
    }

    /// This muscle's part of a gap or an overlap with another one.
    fn shared(&self, contact: Contact, other: &MuscleBody) -> Contact {
        let own = self.muscle.insertion.w * other.segments as f32;
        let others = other.insertion.w * self.muscle.segments as f32;
        Contact { distance: contact.distance * (others / (own + others)), ..contact }
    }

    fn bone(&self, link: &Link, i: usize, p: Vec3) -> Contact {
        let (radius, clear) = self.sizes[i];
        self.around.bone(link, p, radius, clear, self.share(i))
    }

    /// The skin around a particle; tendons may leave it, since attachments lie where the mesh has none.
    fn within(&self, i: usize, p: Vec3) -> Contact {
        if self.sizes[i].1 < 1.0 || self.skins.is_empty() {
            return Contact::NONE;
        }
        let share = self.share(i);
        self.around.skin(self.skins, p, self.ends.0 * (1.0 - share) + self.ends.1 * share)
    }

    /// One contact pass over particle `i`: its neighbour as found before, every bone and the skin as they are.
    fn settle(&self, chain: &mut Chain, i: usize) {
        for kind in PEERS {
            let plane = chain.planes[i][kind];
            let depth = plane.w - plane.xyz().dot(chain.at[i]);
            push(chain, i, kind, plane.xyz(), depth);
        }
        let mut touched = Vec3::ZERO;
        for link in self.bones {
            let found = self.bone(link, i, chain.at[i]);
            if found.distance < 0.0 {
                touched = found.normal;
            }
            push(chain, i, BONE, found.normal, -found.distance);
        }
        let found = self.within(i, chain.at[i]);
        push(chain, i, WITHIN, contact::along(found.normal, touched), -found.distance);
    }
}

/// Pushes a particle out of a contact by its depth, metres.
fn push(chain: &mut Chain, i: usize, kind: usize, normal: Vec3, depth: f32) {
    if depth > 0.0 {
        chain.at[i] += normal * depth;
        chain.pushes[i][kind] += depth * chain.mass[i];
    }
}

/// New places and velocities: the displacement over the substep, less what friction takes of its part along a touched
/// surface (background 4.3, Deul's form), and none at all below the deadband for a particle that presses against a muscle.
fn finish(params: &DynamicsParams, around: &Surroundings, muscle: &MuscleBody, chain: &Chain, own: &mut [Particle]) {
    let from = &around.moved[muscle.origin_joint as usize].carry;
    let to = &around.moved[muscle.insertion_joint as usize].carry;
    for (i, particle) in own.iter_mut().enumerate() {
        let share = i as f32 / muscle.segments as f32;
        let before = particle.position.xyz();
        let displaced = transform_point(from, before) * (1.0 - share) + transform_point(to, before) * share;
        let mut relative = chain.at[i] - before - displaced;
        let mut place = chain.at[i];
        let pressed = chain.pushes[i][PEERS].iter().any(|push| *push > 0.0);
        if pressed && relative.length() < params.deadband {
            relative = Vec3::ZERO;
            place = before + displaced;
        }
        for kind in [PEERS.start, PEERS.start + 1, BONE] {
            let normal = chain.planes[i][kind].xyz();
            let depth = chain.pushes[i][kind] * chain.mobility[i];
            let along = relative - normal * relative.dot(normal);
            let way = along.length();
            if depth > 0.0 && way > 0.0 {
                relative -= along * (params.friction * depth / way).min(1.0);
            }
        }
        particle.position = place.extend(particle.position.w);
        particle.velocity = ((displaced + relative) / params.seconds).extend(particle.velocity.w);
    }
}
