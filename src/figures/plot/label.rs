//! Text with italic letters and indices, arrows and lines anywhere on a page.

use super::{Area, FINE, FONT, INK, Page, rgb};
use crate::error::FigureError;
use plotters::element::{PathElement, Polygon};
use plotters::style::{Color, FontDesc, FontFamily, FontStyle, FontTransform, IntoTextStyle, ShapeStyle};

/// Which point of a text stands at the place that it is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Align {
    /// Its left end.
    Left,
    /// Its middle.
    #[default]
    Middle,
    /// Its right end.
    Right,
}

/// A line of text. `*s*` is italic, `_0` and `_{01}` an index, `^2` and `^{-1}` an exponent.
#[derive(Clone, Copy, Debug)]
pub struct Label<'a> {
    /// The text.
    pub text: &'a str,
    /// Height of the letters' em, pixels.
    pub size: f64,
    /// sRGB.
    pub color: [u8; 3],
    /// What stands at the place.
    pub align: Align,
    /// Whether it runs upward.
    pub upward: bool,
    /// Whether it has a white rim, to be read on a picture.
    pub rimmed: bool,
}

/// Letters of one kind.
#[derive(Clone, Debug, Default, PartialEq)]
struct Run {
    text: String,
    italic: bool,
    /// 1 above, -1 below, 0 on the line.
    level: i32,
}

/// Size of an index beside its letter's, and how far it is moved up or down, in letter sizes.
const INDEX: f64 = 0.68;
const RAISE: f64 = 0.36;
const LOWER: f64 = 0.20;
/// From the middle of a capital letter down to its baseline, in ems.
const HALF_LETTER: f64 = 0.36;
/// From the top of the font's highest letters to the bottom of its lowest, in ems: what plotters calls a size.
const EM: f64 = 1.36;

fn runs(text: &str) -> Vec<Run> {
    let mut found = vec![Run::default()];
    let mut italic = false;
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        let level = match letter {
            '*' => {
                italic = !italic;
                found.push(Run { italic, ..Run::default() });
                continue;
            }
            '_' => -1,
            '^' => 1,
            _ => {
                if let Some(last) = found.last_mut() {
                    last.text.push(letter);
                }
                continue;
            }
        };
        let index: String = match letters.peek() {
            Some('{') => letters.by_ref().skip(1).take_while(|&c| c != '}').collect(),
            _ => letters.next().into_iter().collect(),
        };
        found.push(Run { text: index, italic, level });
        found.push(Run { italic, ..Run::default() });
    }
    found.retain(|run| !run.text.is_empty());
    found
}

impl<'a> Label<'a> {
    /// Dark text about its middle.
    pub fn new(text: &'a str, size: f64) -> Label<'a> {
        Label { text, size, color: INK, align: Align::Middle, upward: false, rimmed: false }
    }

    /// The same text with another point at its place.
    pub fn align(self, align: Align) -> Label<'a> {
        Label { align, ..self }
    }

    /// The same text in another colour.
    pub fn color(self, color: [u8; 3]) -> Label<'a> {
        Label { color, ..self }
    }

    /// Draws it with the middle of its letters' height at `y`, and its `align` at `x`.
    ///
    /// # Errors
    /// [`FigureError::Draw`].
    pub fn draw(&self, page: &mut Page, x: f64, y: f64) -> Result<(), FigureError> {
        page.on(page.whole(), |area| self.draw_on(area, x, y))
    }

    fn font(&self, run: &Run) -> (FontDesc<'static>, f64) {
        let size = self.size * EM * f64::from(FINE) * if run.level == 0 { 1.0 } else { INDEX };
        let style = if run.italic { FontStyle::Italic } else { FontStyle::Normal };
        (FontDesc::new(FontFamily::Name(FONT), size, style), size)
    }

    /// Pixels from its left to its right.
    ///
    /// # Errors
    /// [`FigureError::Draw`] where the font fails.
    pub fn width(&self) -> Result<f64, FigureError> {
        let failed = |e: &dyn std::fmt::Display| FigureError::Draw { problem: format!("{:?}: {e}", self.text) };
        runs(self.text).iter().try_fold(0.0, |sum, run| {
            let (width, _) = self.font(run).0.box_size(&run.text).map_err(|e| failed(&e))?;
            Ok(sum + f64::from(width) / f64::from(FINE))
        })
    }

    /// As [`draw`](Label::draw), with places relative to the area.
    pub(super) fn draw_on(&self, area: &Area<'_>, x: f64, y: f64) -> Result<(), FigureError> {
        if self.rimmed {
            let rim = Label { color: [255; 3], rimmed: false, ..*self };
            for i in 0..12 {
                let turn = f64::from(i) / 12.0 * std::f64::consts::TAU;
                rim.draw_on(area, x + 1.6 * turn.cos(), y + 1.6 * turn.sin())?;
            }
        }
        let width = self.width()?;
        let mut along = match self.align {
            Align::Left => 0.0,
            Align::Middle => -0.5 * width,
            Align::Right => -width,
        };
        for run in runs(self.text) {
            let (font, fine_size) = self.font(&run);
            let shift = match run.level {
                0 => 0.0,
                1 => -RAISE,
                _ => LOWER,
            };
            // Down from the middle of the letters to the run's baseline; plotters puts the baseline half a size under
            // the place that it is given.
            let baseline = self.size * (HALF_LETTER + shift);
            let fine = f64::from(FINE);
            let down = baseline * fine - 0.5 * fine_size;
            let (place, turn) = if self.upward {
                ((x * fine + down, (y - along) * fine), FontTransform::Rotate270)
            } else {
                (((x + along) * fine, y * fine + down), FontTransform::None)
            };
            let (run_width, _) = font.box_size(&run.text).unwrap_or_default();
            let color = rgb(self.color);
            let style = font.transform(turn).into_text_style(area).color(&color);
            area.draw_text(&run.text, &style, (place.0.round() as i32, place.1.round() as i32))?;
            along += f64::from(run_width) / fine;
        }
        Ok(())
    }
}

fn fine([x, y]: [f64; 2]) -> (i32, i32) {
    ((x * f64::from(FINE)).round() as i32, (y * f64::from(FINE)).round() as i32)
}

fn stroke(color: [u8; 3], width: f64) -> ShapeStyle {
    rgb(color).stroke_width((width * f64::from(FINE)).round().max(1.0) as u32)
}

/// A line through points, `width` pixels wide.
///
/// # Errors
/// [`FigureError::Draw`].
pub fn polyline(page: &mut Page, points: &[[f64; 2]], color: [u8; 3], width: f64) -> Result<(), FigureError> {
    let points: Vec<(i32, i32)> = points.iter().copied().map(fine).collect();
    page.on(page.whole(), |area| Ok(area.draw(&PathElement::new(points, stroke(color, width)))?))
}

/// An arrow from a point to another.
///
/// # Errors
/// [`FigureError::Draw`].
pub fn arrow(page: &mut Page, from: [f64; 2], to: [f64; 2], color: [u8; 3], width: f64) -> Result<(), FigureError> {
    let along = [to[0] - from[0], to[1] - from[1]];
    let length = along[0].hypot(along[1]).max(1e-9);
    let unit = along.map(|x| x / length);
    let head = (4.5 * width).min(0.6 * length);
    let at = |back: f64, side: f64| [to[0] - unit[0] * back - unit[1] * side, to[1] - unit[1] * back + unit[0] * side];
    polyline(page, &[from, at(head * 0.8, 0.0)], color, width)?;
    let tip: Vec<(i32, i32)> = [to, at(head, 0.36 * head), at(head, -0.36 * head)].map(fine).to_vec();
    page.on(page.whole(), |area| Ok(area.draw(&Polygon::new(tip, rgb(color).filled()))?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_falls_into_runs() {
        let run = |text: &str, italic, level| Run { text: text.into(), italic, level };
        assert_eq!(runs("plain"), [run("plain", false, 0)]);
        assert_eq!(
            runs("*n*_i of *x*^{-1}"),
            [run("n", true, 0), run("i", false, -1), run(" of ", false, 0), run("x", true, 0), run("-1", false, 1)]
        );
        assert_eq!(runs(""), []);
        assert_eq!(runs("*a_0*b"), [run("a", true, 0), run("0", true, -1), run("b", false, 0)]);
    }

    #[test]
    fn longer_text_is_wider() {
        Page::new(4, 4).expect("registers the font");
        let width = |text| Label::new(text, 14.0).width().expect("a width");
        assert!(width("wider") > width("wide") && width("x_0") < width("x0"));
        assert!((20.0..60.0).contains(&width("wide")), "{}", width("wide"));
    }
}
