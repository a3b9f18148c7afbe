//! What muscles do over time, for whoever tunes them: numbers per muscle and frame, and a page of graphs per muscle.

use super::plot::{Axis, INK, Label, Line, LinePlot, PALE, Page, Rect, SERIES};
use crate::dynamics::{Bodies, Depth, Particle, Skins, depths, elastic};
use crate::error::FigureError;
use crate::field::muscle::{AxisPoint, MuscleFrame, volume};
use crate::rig::{FrameInputs, Image, Rig};
use crate::schedule::Mode;
use glam::{Vec4, Vec4Swizzles};
use rayon::prelude::*;
use std::ops::Range;

/// Edge of the cells that volumes are counted in, in the muscle's width.
const CELL: f32 = 0.125;

/// One muscle at one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Seconds since the clip's start.
    pub time: f64,
    /// Length of the axis, metres, at the size that the character has at rest.
    pub length: f64,
    /// The width w of the paper's equation 2, metres, at that size.
    pub width: f64,
    /// 0 at rest to 1 fully active.
    pub activation: f64,
    /// Volume, cubic centimetres, by quadrature of the muscle's field.
    pub volume: f64,
    /// Volume that it is to have, cubic centimetres.
    pub wanted: f64,
    /// Speed of the fastest particle, m/s, in the scene: that of the bones is in it.
    pub speed: f64,
    /// Largest violation of a spring, percent of its length ([`elastic`]); NaN in `pbd` mode, where no spring
    /// is ever in balance.
    pub violation: f64,
    /// Deepest in a bone, percent of the particle's radius.
    pub bone: f64,
    /// Deepest in another muscle, millimetres.
    pub muscle: f64,
    /// Farthest outside the skin, millimetres.
    pub outside: f64,
}

/// A column of the table: its heading and its value.
type Column = (&'static str, fn(&Moment) -> f64);

impl Moment {
    /// All values with their headings, units included.
    pub const COLUMNS: [Column; 11] = [
        ("time_s", |m| m.time),
        ("length_m", |m| m.length),
        ("width_m", |m| m.width),
        ("activation", |m| m.activation),
        ("volume_cm3", |m| m.volume),
        ("wanted_volume_cm3", |m| m.wanted),
        ("fastest_particle_m_per_s", |m| m.speed),
        ("elastic_violation_percent", |m| m.violation),
        ("deepest_in_bone_percent_of_radius", |m| m.bone),
        ("deepest_in_muscle_mm", |m| m.muscle),
        ("farthest_outside_skin_mm", |m| m.outside),
    ];
}

/// One instance's muscles as a frame left them.
#[derive(Clone, Copy, Debug)]
pub struct Moving<'a> {
    /// The character.
    pub rig: &'a Rig,
    /// Its bodies.
    pub bodies: &'a Bodies,
    /// The frame's muscles, each in the space of its field group at rest.
    pub muscles: &'a [MuscleFrame],
    /// Points of their axes.
    pub axes: &'a [AxisPoint],
    /// The same points in motion, posed scene space.
    pub particles: &'a [Particle],
    /// First half of the iterates.
    pub iterates: &'a [Vec4],
    /// Whether springs have a balance: in `xpbd` mode.
    pub balances: bool,
}

impl Moving<'_> {
    /// Measures all muscles at a frame of the given inputs, `time` seconds after the clip's start.
    pub fn moments(&self, inputs: &FrameInputs, time: f64) -> Vec<Moment> {
        let depths = depths(self.bodies, Skins::of(self.rig), &inputs.joints, self.iterates);
        let one = |index: usize| self.moment(index, inputs, &depths, time);
        (0..self.muscles.len()).into_par_iter().map(one).collect()
    }

    fn moment(&self, index: usize, inputs: &FrameInputs, depths: &[Depth], time: f64) -> Moment {
        let (muscle, rest) = (&self.muscles[index], &self.rig.muscles[index]);
        let own = rest.first_point as usize..=(rest.first_point + rest.segments) as usize;
        let speeds = self.particles[own.clone()].iter().map(|p| p.velocity.xyz().length());
        let most = |value: fn(&Depth) -> f32| f64::from(depths[own.clone()].iter().map(value).fold(0.0, f32::max));
        let violation = || elastic(self.bodies, index, &inputs.joints, self.particles, self.iterates, Mode::Xpbd);
        Moment {
            time,
            length: muscle.length.into(),
            width: muscle.width.into(),
            activation: muscle.activation.into(),
            volume: 1e6 * volume(muscle, muscle.points(self.axes), CELL * muscle.width),
            wanted: 1e6 * f64::from(rest.origin.w) * f64::from(inputs.muscles[index].width).powi(2),
            speed: speeds.fold(0.0, f32::max).into(),
            violation: if self.balances { 100.0 * f64::from(violation()) } else { f64::NAN },
            bone: 100.0 * most(|d| d.bone / d.radius.max(1e-9)),
            muscle: 1e3 * most(|d| d.muscle),
            outside: 1e3 * most(|d| d.outside),
        }
    }
}

/// What a graph shows of its values.
#[derive(Clone, Copy)]
enum Span {
    /// From 0 to a given value.
    Fixed(f64),
    /// From 0 up to the largest, or to this at least.
    Upward(f64),
    /// Around the values, and at least this share of the largest.
    Around(f64),
}

impl Span {
    fn range(self, values: impl Iterator<Item = f64>) -> Range<f64> {
        let finite = values.filter(|v| v.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        match self {
            Span::Fixed(most) => 0.0..most,
            Span::Upward(least) => 0.0..(1.1 * high).max(least),
            Span::Around(_) if low > high => 0.0..1.0,
            Span::Around(share) => {
                let half = (0.6 * (high - low)).max(0.5 * share * high.abs()).max(1e-6);
                let middle = 0.5 * (low + high);
                middle - half..middle + half
            }
        }
    }
}

/// One graph of a page: title, unit, what it shows, and a value to compare with.
struct Graph {
    title: &'static str,
    unit: &'static str,
    span: Span,
    value: fn(&Moment) -> f64,
    beside: Option<fn(&Moment) -> f64>,
}

/// Column by column.
const GRAPHS: [[Graph; 4]; 2] = {
    const fn graph(title: &'static str, unit: &'static str, span: Span, value: fn(&Moment) -> f64) -> Graph {
        Graph { title, unit, span, value, beside: None }
    }
    [
        [
            graph("Length of the axis", "m", Span::Around(0.02), |m| m.length),
            graph("Width *w*", "mm", Span::Around(0.02), |m| 1e3 * m.width),
            graph("Activation", "", Span::Fixed(1.0), |m| m.activation),
            Graph {
                beside: Some(|m| m.wanted),
                ..graph("Volume; dashed: as it is to be", "cm^3", Span::Around(0.04), |m| m.volume)
            },
        ],
        [
            graph("Fastest particle", "m/s", Span::Upward(0.1), |m| m.speed),
            graph("Largest violation of a spring", "% of its length", Span::Upward(1.0), |m| m.violation),
            Graph {
                beside: Some(|_| 2.0),
                ..graph("Deepest in a bone; dashed: 2 %", "% of the radius", Span::Upward(4.0), |m| m.bone)
            },
            Graph {
                beside: Some(|m| m.outside),
                ..graph("Deepest in a muscle; dashed: outside the skin", "mm", Span::Upward(1.0), |m| m.muscle)
            },
        ],
    ]
};

/// Pixels of a page, of its head and of a graph.
const WIDTH: u32 = 1360;
const HEAD: u32 = 54;
const GRAPH: u32 = 236;

/// Draws a muscle's page: `name` and `motion` are its heading.
///
/// # Errors
/// [`FigureError::Draw`].
pub fn page(name: &str, motion: &str, moments: &[Moment]) -> Result<Image, FigureError> {
    let mut page = Page::new(WIDTH, HEAD + 4 * GRAPH + 10)?;
    let title = plain(&format!("{name}: {motion}"));
    Label::new(&title, 22.0).draw(&mut page, f64::from(WIDTH) / 2.0, 28.0)?;
    let (start, end) = (moments.first().map_or(0.0, |m| m.time), moments.last().map_or(0.0, |m| m.time));
    // A single frame is a dot in the middle of its graph.
    let x = if end > start { start..end } else { start - 0.5..start + 0.5 };
    for (column, graphs) in GRAPHS.iter().enumerate() {
        for (row, graph) in graphs.iter().enumerate() {
            let (left, top) = (column as u32 * (WIDTH / 2), HEAD + row as u32 * GRAPH);
            draw(&mut page, graph, moments, x.clone(), Rect { left, top, width: WIDTH / 2, height: GRAPH })?;
        }
    }
    Ok(page.finish())
}

fn draw(page: &mut Page, graph: &Graph, moments: &[Moment], x: Range<f64>, place: Rect) -> Result<(), FigureError> {
    let values = |value: fn(&Moment) -> f64| moments.iter().map(move |m| [m.time, value(m)]);
    let known = |value| values(value).filter(|p| p[1].is_finite()).collect::<Vec<_>>();
    let all = values(graph.value).chain(graph.beside.into_iter().flat_map(values)).map(|p| p[1]);
    let y = graph.span.range(all);
    let mut lines = Vec::new();
    if let Some(beside) = graph.beside {
        lines.push(Line { width: 1.4, dashed: true, ..Line::new("", known(beside), PALE) });
    }
    let shown = known(graph.value);
    let none = shown.is_empty();
    lines.push(Line { width: 2.0, ..Line::new("", spread(shown), SERIES[1]) });
    let plot = LinePlot {
        title: graph.title,
        x: Axis { name: "time, s", digits: digits(&x), range: x, ticks: 8 },
        y: Axis { name: graph.unit, digits: digits(&y), range: y, ticks: 4 },
        lines,
        legend: None,
    };
    plot.draw(page, place)?;
    if none {
        let middle = [place.left + place.width / 2, place.top + place.height / 2].map(f64::from);
        Label::new("not in this mode", 17.0).color(INK).draw(page, middle[0], middle[1])?;
    }
    Ok(())
}

/// A single point as a short line, which can be seen.
fn spread(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    match points[..] {
        [[x, y]] => vec![[x - 0.05, y], [x + 0.05, y]],
        _ => points,
    }
}

/// Digits behind the point that tell a range's ticks apart.
fn digits(range: &Range<f64>) -> usize {
    let step = (range.end - range.start) / 4.0;
    (-step.log10().floor()).clamp(0.0, 6.0) as usize
}

/// Text without what labels take for signs of their own.
fn plain(text: &str) -> String {
    text.replace('`', "").replace(['_', '*', '^'], " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn graphs_show_all_values_and_no_change_that_is_none() {
        let values = [3.0, 5.0, f64::NAN, 4.0];
        let around = Span::Around(0.02).range(values.into_iter());
        assert!(around.start < 3.0 && around.end > 5.0 && around.end < 6.0, "{around:?}");
        let flat = Span::Around(0.04).range([100.0, 100.001].into_iter());
        assert!((flat.end - flat.start - 4.0).abs() < 0.01, "rounding is not enlarged: {flat:?}");
        assert_eq!(Span::Upward(1.0).range([0.1, 0.2].into_iter()), 0.0..1.0);
        assert!(Span::Upward(1.0).range(values.into_iter()).end > 5.0);
        for span in [Span::Fixed(1.0), Span::Upward(1.0), Span::Around(0.1)] {
            let range = span.range([f64::NAN].into_iter());
            assert!(range.start < range.end && range.end.is_finite(), "{range:?}");
        }
    }

    #[test]
    fn ticks_have_the_digits_they_need() {
        assert_eq!([0.0..1.0, 0.0..40.0, 0.21..0.25, 3.0..3.0005].map(|r| digits(&r)), [1, 0, 2, 4]);
    }

    #[test]
    fn a_page_shows_what_it_is_given() {
        let moment = |k: u32, length: f64| Moment { time: f64::from(k) / 30.0, length, ..Moment::default() };
        let drawn = |length: f64| {
            let moments: Vec<Moment> = (0..10).map(|k| moment(k, 0.2 + length * f64::from(k))).collect();
            page("biceps_l", "clip `arm_shake`", &moments).expect("a page")
        };
        let (flat, steep) = (drawn(0.0), drawn(0.01));
        assert_eq!((flat.width, flat.rgba.len()), (WIDTH, (WIDTH * flat.height * 4) as usize));
        assert!(flat.rgba == drawn(0.0).rgba && flat.rgba != steep.rgba);
        let one = page("m", "one frame", &[moment(0, 0.2)]).expect("a page");
        let blue = |image: &Image| image.rgba.chunks(4).filter(|p| p[..3] == SERIES[1]).count();
        assert!(blue(&one) > 100 && blue(&page("m", "no frame", &[]).expect("a page")) == 0);
    }
}
