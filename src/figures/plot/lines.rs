//! Line plots: axes, ticks, labels, legends.

use super::{Align, FINE, FONT, INK, Label, Page, RULE, Rect, polyline, rgb};
use crate::error::FigureError;
use plotters::chart::ChartBuilder;
use plotters::series::{DashedLineSeries, LineSeries};
use plotters::style::{Color, FontDesc, FontFamily, FontStyle, IntoTextStyle, ShapeStyle};
use std::ops::Range;

/// Sizes of text, pixels.
const TICK: f64 = 15.0;
const NAME: f64 = 17.0;
const TITLE: f64 = 19.0;
const LEGEND: f64 = 15.0;
/// Pixels that a plot keeps beside its axes for ticks and names, and above it for its title.
const LEFT: u32 = 84;
const BELOW: u32 = 62;
const ABOVE: u32 = 40;
const RIGHT: u32 = 22;
/// Pixels of a dash and of the gap behind it.
const DASH: (u32, u32) = (9, 6);

/// One axis.
#[derive(Clone, Debug)]
pub struct Axis<'a> {
    /// What it shows, with its unit; written as [`Label`]s are.
    pub name: &'a str,
    /// What is shown of it.
    pub range: Range<f64>,
    /// About how many ticks.
    pub ticks: usize,
    /// Digits behind the point.
    pub digits: usize,
}

/// One line of a plot.
#[derive(Clone, Debug)]
pub struct Line {
    /// Its entry in the legend, written as [`Label`]s are; none where it is empty.
    pub name: String,
    /// Places, in the axes' units.
    pub points: Vec<[f64; 2]>,
    /// sRGB.
    pub color: [u8; 3],
    /// Pixels across.
    pub width: f64,
    /// Whether it is dashed.
    pub dashed: bool,
}

impl Line {
    /// An unbroken line.
    pub fn new(name: impl Into<String>, points: Vec<[f64; 2]>, color: [u8; 3]) -> Line {
        Line { name: name.into(), points, color, width: 2.4, dashed: false }
    }

    /// A thin dashed line at one height, to compare with.
    pub fn level(name: impl Into<String>, height: f64, across: &Range<f64>, color: [u8; 3]) -> Line {
        let points = vec![[across.start, height], [across.end, height]];
        Line { width: 1.4, dashed: true, ..Line::new(name, points, color) }
    }
}

/// Where a legend stands inside its plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corner {
    /// Top left.
    TopLeft,
    /// Top right.
    TopRight,
    /// Bottom left.
    BottomLeft,
    /// Bottom right.
    BottomRight,
}

/// Lines over two axes.
#[derive(Clone, Debug)]
pub struct LinePlot<'a> {
    /// Above it.
    pub title: &'a str,
    /// The axis to the right.
    pub x: Axis<'a>,
    /// The axis upward.
    pub y: Axis<'a>,
    /// What is drawn, the last on top.
    pub lines: Vec<Line>,
    /// Where the lines' names stand.
    pub legend: Option<Corner>,
}

/// Height of axis labels' text as plotters measures it.
pub(super) fn tick_font() -> FontDesc<'static> {
    FontDesc::new(FontFamily::Name(FONT), TICK * 1.36 * f64::from(FINE), FontStyle::Normal)
}

/// A number with a typographer's minus.
pub(super) fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    // What rounds to nothing has no sign.
    if text.chars().any(|c| c.is_ascii_digit() && c != '0') {
        text.replace('-', "\u{2212}")
    } else {
        text.replace('-', "")
    }
}

/// The inside of a plot that fills `place` with its ticks and names.
pub fn inside(place: Rect) -> Rect {
    Rect {
        left: place.left + LEFT,
        top: place.top + ABOVE,
        width: place.width.saturating_sub(LEFT + RIGHT).max(1),
        height: place.height.saturating_sub(ABOVE + BELOW).max(1),
    }
}

/// Writes a plot's title and its axes' names round its inside.
pub(super) fn names(page: &mut Page, inner: Rect, title: &str, x: &str, y: &str) -> Result<(), FigureError> {
    let (left, top) = (f64::from(inner.left), f64::from(inner.top));
    let (width, height) = (f64::from(inner.width), f64::from(inner.height));
    Label::new(title, TITLE).draw(page, left + 0.5 * width, top - 20.0)?;
    Label::new(x, NAME).draw(page, left + 0.5 * width, top + height + 46.0)?;
    Label { upward: true, ..Label::new(y, NAME) }.draw(page, left - 64.0, top + 0.5 * height)
}

impl LinePlot<'_> {
    /// Draws it into a part of a page, of at least 200 x 200 pixels.
    ///
    /// # Errors
    /// [`FigureError::Draw`].
    pub fn draw(&self, page: &mut Page, place: Rect) -> Result<(), FigureError> {
        let inner = inside(place);
        page.on(place, |area| {
            let mut chart = ChartBuilder::on(area)
                .margin_top((ABOVE * FINE) as i32)
                .margin_right((RIGHT * FINE) as i32)
                .x_label_area_size((BELOW * FINE) as i32)
                .y_label_area_size((LEFT * FINE) as i32)
                .build_cartesian_2d(self.x.range.clone(), self.y.range.clone())?;
            let ink = rgb(INK);
            let ticks = tick_font().into_text_style(area).color(&ink);
            chart
                .configure_mesh()
                .light_line_style(rgb([255; 3]).stroke_width(0))
                .max_light_lines(0)
                .bold_line_style(rgb(RULE).stroke_width(FINE))
                .axis_style(rgb(INK).stroke_width(FINE * 3 / 2))
                .set_all_tick_mark_size((5 * FINE) as i32)
                .label_style(ticks)
                .x_labels(self.x.ticks)
                .y_labels(self.y.ticks)
                .x_label_formatter(&|x| number(*x, self.x.digits))
                .y_label_formatter(&|y| number(*y, self.y.digits))
                .draw()?;
            for line in &self.lines {
                let style = stroke(line);
                let points = line.points.iter().map(|p| (p[0], p[1]));
                if line.dashed {
                    let (dash, gap) = ((DASH.0 * FINE) as i32, (DASH.1 * FINE) as i32);
                    chart.draw_series(DashedLineSeries::new(points, dash, gap, style))?;
                } else {
                    chart.draw_series(LineSeries::new(points, style))?;
                }
            }
            Ok(())
        })?;
        names(page, inner, self.title, self.x.name, self.y.name)?;
        match self.legend {
            Some(corner) => self.draw_legend(page, inner, corner),
            None => Ok(()),
        }
    }

    fn draw_legend(&self, page: &mut Page, inner: Rect, corner: Corner) -> Result<(), FigureError> {
        const ROW: f64 = 23.0;
        const SWATCH: f64 = 30.0;
        const AWAY: f64 = 14.0;
        let named: Vec<&Line> = self.lines.iter().filter(|line| !line.name.is_empty()).collect();
        let mut widest = 0.0f64;
        for line in &named {
            widest = widest.max(Label::new(&line.name, LEGEND).width()?);
        }
        let (width, height) = (widest + SWATCH + 28.0, ROW * named.len() as f64 + 10.0);
        let right = f64::from(inner.left + inner.width) - AWAY - width;
        let bottom = f64::from(inner.top + inner.height) - AWAY - height;
        let (left, top) = (f64::from(inner.left) + AWAY, f64::from(inner.top) + AWAY);
        let (x, y) = match corner {
            Corner::TopLeft => (left, top),
            Corner::TopRight => (right, top),
            Corner::BottomLeft => (left, bottom),
            Corner::BottomRight => (right, bottom),
        };
        page.fill(Rect { left: x as u32, top: y as u32, width: width as u32, height: height as u32 }, [255; 3]);
        for (i, line) in named.into_iter().enumerate() {
            let middle = y + 5.0 + ROW * (i as f64 + 0.5);
            let swatch = [x + 8.0, x + 8.0 + SWATCH];
            let dash = f64::from(DASH.0);
            let pieces: &[[f64; 2]] =
                if line.dashed { &[[0.0, dash], [SWATCH - dash, SWATCH]] } else { &[[0.0, SWATCH]] };
            for piece in pieces {
                let ends = piece.map(|along| [swatch[0] + along, middle]);
                polyline(page, &ends, line.color, line.width)?;
            }
            Label::new(&line.name, LEGEND).align(Align::Left).draw(page, swatch[1] + 10.0, middle)?;
        }
        Ok(())
    }
}

fn stroke(line: &Line) -> ShapeStyle {
    rgb(line.color).stroke_width((line.width * f64::from(FINE)).round() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_minus_and_nothing_has_none() {
        assert_eq!(number(-1.5, 1), "\u{2212}1.5");
        assert_eq!(number(-1e-9, 2), "0.00");
        assert_eq!(number(0.25, 2), "0.25");
    }

    /// Rows of pixels of a colour in a picture of one flat line.
    fn row_of(height: f64) -> Option<u32> {
        let range = 0.0..1.0;
        let color = [213, 94, 0];
        let axis = |name| Axis { name, range: 0.0..1.0, ticks: 5, digits: 1 };
        let line = Line { dashed: false, ..Line::level("", height, &range, color) };
        let plot = LinePlot { title: "t", x: axis("x"), y: axis("y"), lines: vec![line], legend: None };
        let mut page = Page::new(300, 300).expect("a page");
        let whole = page.whole();
        plot.draw(&mut page, whole).expect("drawn");
        let image = page.finish();
        let at = image.rgba.chunks(4).position(|p| p[..3] == color)?;
        Some(at as u32 / image.width)
    }

    #[test]
    fn a_line_stands_at_its_height() {
        let inner = inside(Rect { left: 0, top: 0, width: 300, height: 300 });
        let expected = |height: f64| f64::from(inner.top) + f64::from(inner.height) * (1.0 - height);
        for height in [0.25, 0.6] {
            let row = f64::from(row_of(height).expect("the line is drawn"));
            assert!((row - expected(height)).abs() <= 2.0, "{height}: {row} {}", expected(height));
            assert!((row - expected(height + 0.1)).abs() > 2.0, "another height must be seen");
        }
    }
}
