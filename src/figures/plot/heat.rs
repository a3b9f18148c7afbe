//! Heat maps: a number at every place of a plane.

use super::lines::{inside, names, number, tick_font};
use super::{Align, Axis, FINE, INK, Label, Page, Rect, polyline, ramp, rgb};
use crate::error::FigureError;
use plotters::chart::ChartBuilder;
use plotters::style::{Color, IntoTextStyle};
use rayon::prelude::*;

/// Room beside a map for its colour bar, pixels.
const BAR: u32 = 84;
const BAR_WIDTH: u32 = 18;
/// How much every other band is darkened.
const SHADE: f64 = 0.86;

/// Values over a plane by colour, with a bar that tells which.
pub struct HeatMap<'a> {
    /// Above it.
    pub title: &'a str,
    /// The axis to the right.
    pub x: Axis<'a>,
    /// The axis upward. Units are as large on either axis: of the two, one gives way.
    pub y: Axis<'a>,
    /// What the colours tell.
    pub value: Axis<'a>,
    /// The value at a place; blank where there is none.
    pub at: &'a (dyn Fn([f64; 2]) -> Option<f64> + Sync),
    /// Bands of equal steps of the value, every other one shaded, so that its lines of equal value show; 0 for none.
    pub bands: u32,
    /// Lines on top, in the axes' units, with a colour and a width in pixels.
    pub lines: Vec<(Vec<[f64; 2]>, [u8; 3], f64)>,
    /// Points on top.
    pub points: Vec<[f64; 2]>,
    /// Whether the colour bar is drawn.
    pub bar: bool,
}

impl HeatMap<'_> {
    /// Draws it into a part of a page; returns the plot's inside, which has the axes' own proportions.
    ///
    /// # Errors
    /// [`FigureError::Draw`].
    pub fn draw(&self, page: &mut Page, place: Rect) -> Result<Rect, FigureError> {
        let place = self.shaped(place);
        let inner = inside(place);
        let (columns, rows) = ((inner.width * FINE) as usize, (inner.height * FINE) as usize);
        let (x, y) = (&self.x.range, &self.y.range);
        let pixels: Vec<[u8; 3]> = (0..rows * columns)
            .into_par_iter()
            .map(|i| {
                let across = (i % columns) as f64 + 0.5;
                let down = (i / columns) as f64 + 0.5;
                let at = [
                    x.start + (x.end - x.start) * across / columns as f64,
                    y.end - (y.end - y.start) * down / rows as f64,
                ];
                (self.at)(at).map_or([255; 3], |value| self.color(value))
            })
            .collect();
        page.put(inner, &pixels);
        page.on(place, |area| {
            let outer = |inner: u32, place: u32| ((inner - place) * FINE) as i32;
            let mut chart = ChartBuilder::on(area)
                .margin_top(outer(inner.top, place.top))
                .margin_right(outer(place.left + place.width, inner.left + inner.width))
                .x_label_area_size(outer(place.top + place.height, inner.top + inner.height))
                .y_label_area_size(outer(inner.left, place.left))
                .build_cartesian_2d(x.clone(), y.clone())?;
            let ink = rgb(INK);
            let ticks = tick_font().into_text_style(area).color(&ink);
            chart
                .configure_mesh()
                .disable_mesh()
                .axis_style(rgb(INK).stroke_width(FINE * 3 / 2))
                .set_all_tick_mark_size((5 * FINE) as i32)
                .label_style(ticks)
                .x_labels(self.x.ticks)
                .y_labels(self.y.ticks)
                .x_label_formatter(&|v| number(*v, self.x.digits))
                .y_label_formatter(&|v| number(*v, self.y.digits))
                .draw()?;
            Ok(())
        })?;
        names(page, inner, self.title, self.x.name, self.y.name)?;
        let to_page = |p: &[f64; 2]| {
            [
                f64::from(inner.left) + (p[0] - x.start) / (x.end - x.start) * f64::from(inner.width),
                f64::from(inner.top) + (y.end - p[1]) / (y.end - y.start) * f64::from(inner.height),
            ]
        };
        for (line, color, width) in &self.lines {
            polyline(page, &line.iter().map(to_page).collect::<Vec<_>>(), *color, *width)?;
        }
        for point in self.points.iter().map(to_page) {
            page.dot(point, 4.5, [255; 3])?;
            page.dot(point, 3.2, INK)?;
        }
        if self.bar {
            let place = Rect { left: inner.left + inner.width + 20, width: BAR_WIDTH, ..inner };
            bar(page, place, &self.value, &|value| self.color(value))?;
        }
        Ok(inner)
    }

    /// The part of a place in which a unit is as long to the right as upward.
    fn shaped(&self, place: Rect) -> Rect {
        let place = if self.bar { Rect { width: place.width.saturating_sub(BAR), ..place } } else { place };
        let inner = inside(place);
        let wanted = (self.x.range.end - self.x.range.start) / (self.y.range.end - self.y.range.start);
        let (width, height) = (f64::from(inner.width), f64::from(inner.height));
        if width > wanted * height {
            let spare = (width - wanted * height) as u32;
            Rect { left: place.left + spare / 2, width: place.width - spare, ..place }
        } else {
            let spare = (height - width / wanted) as u32;
            Rect { top: place.top + spare / 2, height: place.height - spare, ..place }
        }
    }

    fn share(&self, value: f64) -> f64 {
        (value - self.value.range.start) / (self.value.range.end - self.value.range.start)
    }

    fn color(&self, value: f64) -> [u8; 3] {
        let share = self.share(value);
        let color = ramp(share);
        let dark = self.bands > 0 && (share.clamp(0.0, 1.0) * f64::from(self.bands)) as u32 % 2 == 1;
        if dark { color.map(|c| (f64::from(c) * SHADE) as u8) } else { color }
    }
}

/// Draws a bar that tells which colour is which value, its name above and its ticks at the right of `place`.
///
/// # Errors
/// [`FigureError::Draw`].
pub fn bar(page: &mut Page, place: Rect, value: &Axis<'_>, color: &dyn Fn(f64) -> [u8; 3]) -> Result<(), FigureError> {
    let at = |share: f64| value.range.start + (value.range.end - value.range.start) * share;
    let rows = (place.height * FINE) as usize;
    let row = |j: usize| vec![color(at(1.0 - (j as f64 + 0.5) / rows as f64)); (place.width * FINE) as usize];
    page.put(place, &(0..rows).flat_map(row).collect::<Vec<_>>());
    let right = f64::from(place.left + place.width);
    for i in 0..value.ticks {
        let share = i as f64 / (value.ticks.max(2) - 1) as f64;
        let y = f64::from(place.top) + f64::from(place.height) * (1.0 - share);
        polyline(page, &[[right, y], [right + 4.0, y]], INK, 1.0)?;
        Label::new(&number(at(share), value.digits), 14.0).align(Align::Left).draw(page, right + 8.0, y)?;
    }
    let over = f64::from(place.left) + 0.5 * f64::from(place.width);
    Label::new(value.name, 17.0).draw(page, over, f64::from(place.top) - 20.0)
}
