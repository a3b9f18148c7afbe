//! One vertex of one frame, in words.

use glam::{Vec4, Vec4Swizzles};
use serde::Serialize;
use sinew::reference::{Explained, SeenReach, Sight};
use sinew::rig::{NO_JOINT, Rig, Role, Unheld};
use sinew::tracking::{StopReason, Track};
use std::fmt::Write;

/// What became of a vertex.
#[derive(Serialize)]
pub struct Vertex {
    vertex: u32,
    /// The vertex that it is a copy of.
    #[serde(skip_serializing_if = "Option::is_none")]
    copy_of: Option<u32>,
    part: Option<String>,
    motion: String,
    sub_poses: u32,
    role: &'static str,
    why: String,
    weights: Vec<Share>,
    owner: Option<String>,
    iso: f32,
    position_rest: [f32; 3],
    carried: Moment,
    ended: Moment,
    /// Field less iso-value before the last step.
    residual: f32,
    passes: u32,
    stop: &'static str,
    contact: f32,
    reaches: Vec<Frame>,
    neighbours: Vec<Neighbour>,
}

/// A joint's or a group's share.
#[derive(Serialize)]
struct Share {
    name: String,
    share: f32,
}

/// The fields around it.
#[derive(Serialize)]
struct Moment {
    position: [f32; 3],
    /// What it tracks: the composed field, or its own side of a contact.
    tracked: f32,
    /// That, less the iso-value.
    off: f32,
    own: f32,
    /// The group with the largest field besides its own.
    other: Option<Value>,
    groups: Vec<Value>,
    muscles: Vec<Value>,
}

#[derive(Clone, Serialize)]
struct Value {
    name: String,
    value: f32,
    /// Field above which it is in contact with the group.
    #[serde(skip_serializing_if = "Option::is_none")]
    contact_above: Option<f32>,
}

/// A group that it sees through a frame of its own.
#[derive(Serialize)]
struct Frame {
    group: String,
    contact_above: f32,
    joints: Vec<Share>,
    #[serde(skip_serializing_if = "Option::is_none")]
    drawn_to: Option<Drawn>,
}

#[derive(Serialize)]
struct Drawn {
    joint: String,
    /// At most.
    share: f32,
    /// In this pose, where a joint has moved.
    now: Option<f32>,
    gate: Option<String>,
}

#[derive(Serialize)]
struct Neighbour {
    vertex: u32,
    metres: f32,
    metres_rest: f32,
    residual: f32,
    stop: &'static str,
    contact: f32,
}

impl Vertex {
    /// Puts into words what was found; `positions` and `tracks` are those of the whole skin after the frame.
    pub fn new(
        rig: &Rig,
        vertex: u32,
        motion: String,
        found: &Explained,
        (positions, tracks): (&[Vec4], &[Track]),
    ) -> Vertex {
        let character = &rig.character;
        let group = |g: u32| rig.groups.groups.get(g as usize).map_or("?".to_string(), |g| g.name.clone());
        let joint = |j: u32| character.joints.get(j as usize).map_or("?".to_string(), |j| j.name.clone());
        let share = |i: &sinew::rig::Influence| Share { name: joint(i.joint), share: i.weight };
        let frame = |seen: &SeenReach| Frame {
            group: group(seen.reach.group),
            contact_above: seen.reach.limit,
            joints: seen.blend.iter().map(share).collect(),
            drawn_to: (seen.reach.other != NO_JOINT).then(|| Drawn {
                joint: joint(seen.reach.other),
                share: seen.reach.share,
                now: seen.drawn,
                gate: (seen.reach.gate != NO_JOINT).then(|| joint(seen.reach.gate)),
            }),
        };
        let v = found.vertex as usize;
        let [begin, end] = rig.graph.ranges[v];
        let edges = rig.graph.edges[begin as usize..end as usize].iter().filter_map(|edge| {
            let n = edge.neighbour as usize;
            let (track, position) = (tracks.get(n)?, positions.get(n)?);
            Some(Neighbour {
                vertex: edge.neighbour,
                metres: position.xyz().distance(found.after.position),
                metres_rest: character.positions_rest[n].distance(found.position_rest),
                residual: track.residual(),
                stop: stop(track),
                contact: track.contact,
            })
        });
        let active = found.target.role == Role::Active as u32;
        let part = character.parts.iter().find(|part| part.vertices.contains(&vertex));
        Vertex {
            vertex,
            copy_of: (found.vertex != vertex).then_some(found.vertex),
            part: part.map(|part| part.name.clone()),
            motion,
            sub_poses: found.sub_poses,
            role: if active { "active" } else { "passive" },
            why: why(found),
            weights: character.influences_of(v).iter().map(share).collect(),
            owner: active.then(|| group(found.target.owner)),
            iso: found.target.iso,
            position_rest: found.position_rest.to_array(),
            carried: moment(rig, found, &found.before),
            ended: moment(rig, found, &found.after),
            residual: found.track.residual(),
            passes: found.track.passes,
            stop: stop(&found.track),
            contact: found.track.contact,
            reaches: found.reaches.iter().map(frame).collect(),
            neighbours: edges.collect(),
        }
    }
}

fn why(found: &Explained) -> String {
    match found.unheld {
        None => "its field has a usable value and slope".into(),
        Some(Unheld::NoField) => "no field reaches it".into(),
        Some(Unheld::Value(value)) => format!("the field there is {value:.4}, and iso-values are from 0.03 to 0.97"),
        Some(Unheld::Bound(weight)) => {
            format!("it is bound by {weight:.3} to heads, hands or feet, which follow linear skinning above 0.98")
        }
        Some(Unheld::Slope(slope)) => {
            format!("the field hardly changes there: by {slope:.3} in a support radius, 0.1 is needed")
        }
        Some(Unheld::Facing(cosine)) => {
            format!("field and skin face different ways there: the cosine between them is {cosine:.2}, 0.3 is needed")
        }
    }
}

/// How the tracking of a vertex ended, in words.
fn stop(track: &Track) -> &'static str {
    const WORDS: [(StopReason, &str); 6] = [
        (StopReason::Passive, "passive"),
        (StopReason::Converged, "converged"),
        (StopReason::NoGradient, "no gradient"),
        (StopReason::Short, "short of passes"),
        (StopReason::Pressed, "pressed"),
        (StopReason::NonFinite, "not finite"),
    ];
    WORDS.iter().find(|(reason, _)| *reason as u32 == track.stop).map_or("unknown", |(_, word)| word)
}

fn moment(rig: &Rig, found: &Explained, sight: &Sight) -> Moment {
    let (owner, own_of) = (found.target.owner, |g: u32| &rig.groups.groups[g as usize]);
    let value = |seen: &sinew::reference::SeenGroup| Value {
        name: own_of(seen.group).name.clone(),
        value: seen.value,
        contact_above: (seen.group != owner).then_some(seen.limit),
    };
    let others = sight.groups.iter().filter(|seen| seen.group != owner && seen.value > 0.0);
    Moment {
        position: sight.position.to_array(),
        tracked: sight.tracked.sample.value,
        off: sight.tracked.sample.value - found.target.iso,
        own: sight.groups.iter().find(|seen| seen.group == owner).map_or(0.0, |seen| seen.value),
        other: others.max_by(|a, b| a.value.total_cmp(&b.value)).map(value),
        groups: sight.groups.iter().map(value).collect(),
        muscles: sight
            .muscles
            .iter()
            .map(|seen| Value {
                name: rig.muscle_names[seen.muscle as usize].clone(),
                value: seen.value,
                contact_above: None,
            })
            .collect(),
    }
}

/// The words.
pub fn text(found: &Vertex) -> String {
    let mut text = String::new();
    let mut line = |depth: usize, words: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}{words}", "  ".repeat(depth));
    };
    let part = found.part.as_ref().map_or(String::new(), |part| format!(" of {part}"));
    let copy = found.copy_of.map_or(String::new(), |of| format!(", a copy of vertex {of}, which the rest is about"));
    line(0, format!("vertex {}{part}{copy}", found.vertex));
    line(1, format!("{}, {} sub-poses", found.motion, found.sub_poses));
    let side = found.owner.as_ref().map_or(String::new(), |owner| format!(" on the side of {owner}"));
    line(1, format!("{}{side}: {}", found.role, found.why));
    line(1, format!("weights: {}", shares(&found.weights)));
    line(1, format!("at rest: {}", place(found.position_rest)));
    for (name, moment) in [("carried there", &found.carried), ("ended", &found.ended)] {
        line(1, format!("{name}: {}", place(moment.position)));
        if found.owner.is_some() {
            let other = moment.other.as_ref().map_or("none".into(), |o| format!("{} {:.4}", o.name, o.value));
            let (tracked, iso, off) = (moment.tracked, found.iso, moment.off);
            line(2, format!("field {tracked:.4}, iso-value {iso:.4}, off by {off:+.4}"));
            line(2, format!("own field {:.4}, largest other: {other}", moment.own));
        }
    }
    if found.owner.is_some() {
        line(
            1,
            format!(
                "{} passes, {}; {:+.5} off before the last step, contact {:.2}",
                found.passes, found.stop, found.residual, found.contact
            ),
        );
    }
    line(1, format!("groups around it: {}", found.ended.groups.len()));
    for after in &found.ended.groups {
        let before = value_of(&found.carried.groups, &after.name);
        let limit = after.contact_above.map_or("its own".into(), |limit| format!("contact above {limit:.4}"));
        line(2, format!("{}: {before:.4}, then {:.4}; {limit}", after.name, after.value));
    }
    line(1, format!("groups that it sees through frames of its own: {}", found.reaches.len()));
    for reach in &found.reaches {
        let drawn = reach.drawn_to.as_ref().map_or(String::new(), |d| {
            let now = d.now.map_or(String::new(), |now| format!("{:.0} % of the way, ", 100.0 * now));
            let gate = d.gate.as_ref().map_or(String::new(), |gate| format!(" as {gate} swings"));
            format!("; drawn {now}at most {:.0} %, to {}{gate}", 100.0 * d.share, d.joint)
        });
        line(2, format!("{}: {}{drawn}", reach.group, shares(&reach.joints)));
    }
    line(1, format!("muscles in reach: {}", found.ended.muscles.len()));
    for after in &found.ended.muscles {
        line(
            2,
            format!("{}: {:.4}, then {:.4}", after.name, value_of(&found.carried.muscles, &after.name), after.value),
        );
    }
    line(1, format!("neighbours: {}", found.neighbours.len()));
    for n in &found.neighbours {
        line(
            2,
            format!(
                "{}: {:.2} mm away, {:.2} mm at rest; {}, {:+.5} off, contact {:.2}",
                n.vertex,
                1000.0 * n.metres,
                1000.0 * n.metres_rest,
                n.stop,
                n.residual,
                n.contact
            ),
        );
    }
    text
}

fn value_of(values: &[Value], name: &str) -> f32 {
    values.iter().find(|v| v.name == name).map_or(0.0, |v| v.value)
}

fn shares(shares: &[Share]) -> String {
    shares.iter().map(|s| format!("{} {:.2}", s.name, s.share)).collect::<Vec<_>>().join(", ")
}

fn place([x, y, z]: [f32; 3]) -> String {
    format!("{x:.4} {y:.4} {z:.4} m")
}
