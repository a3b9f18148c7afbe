//! Plots and labels on a page: line plots with axes and legends, heat maps, text with indices, arrows.
//!
//! A page is drawn three times as fine as it is read out, so that lines, text and jumps in a field come out smooth.
//! Places on a page are in its own pixels, from the top left corner.

mod color;
mod heat;
mod label;
mod lines;

pub use color::{INK, PALE, RULE, SERIES, ramp};
pub use heat::{HeatMap, bar};
pub use label::{Align, Label, arrow, polyline};
pub use lines::{Axis, Corner, Line, LinePlot, inside};

use crate::error::FigureError;
use crate::rig::Image;
use plotters::coord::Shift;
use plotters::drawing::{DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::Circle;
use plotters::prelude::{BitMapBackend, DrawingArea};
use plotters::style::{Color, FontStyle, RGBColor, register_font};
use std::error::Error;

/// What plots are drawn on.
type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

/// Pixels drawn for one that is read out, along each side.
const FINE: u32 = 3;
const FONT: &str = "figures";

/// A rectangle on a page, in its pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// From the page's left.
    pub left: u32,
    /// From the page's top.
    pub top: u32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

/// A white sheet to draw on.
pub struct Page {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl Page {
    /// An empty page of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`FigureError::Draw`] where the built-in font cannot be read.
    pub fn new(width: u32, height: u32) -> Result<Page, FigureError> {
        for (name, style, bytes) in
            [("upright", FontStyle::Normal, notosans::REGULAR_TTF), ("italic", FontStyle::Italic, notosans::ITALIC_TTF)]
        {
            let failed = |_| FigureError::Draw { problem: format!("the built-in {name} font is not readable") };
            register_font(FONT, style, bytes).map_err(failed)?;
        }
        Ok(Page { width, height, rgb: vec![255; width as usize * height as usize * (FINE * FINE * 3) as usize] })
    }

    /// Pixels across and down.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Lets `draw` draw on a part of the page; what leaves it is cut off at the page's edge.
    fn on<R>(&mut self, place: Rect, draw: impl FnOnce(&Area<'_>) -> Result<R, FigureError>) -> Result<R, FigureError> {
        let size = (self.width * FINE, self.height * FINE);
        let root = BitMapBackend::with_buffer(&mut self.rgb, size).into_drawing_area();
        let fine = |x: u32| (x * FINE) as i32;
        let part = root.shrink((fine(place.left), fine(place.top)), (fine(place.width), fine(place.height)));
        let drawn = draw(&part)?;
        part.present()?;
        Ok(drawn)
    }

    /// Fills a part of the page with pixels, [`FINE`] times as many as it has along each side, rows from the top.
    fn put(&mut self, place: Rect, pixels: &[[u8; 3]]) {
        let (columns, row) = ((place.width * FINE) as usize, (self.width * FINE) as usize);
        for (y, line) in pixels.chunks_exact(columns).enumerate() {
            let start = ((place.top * FINE) as usize + y) * row + (place.left * FINE) as usize;
            if let Some(target) = self.rgb.get_mut(start * 3..(start + columns) * 3) {
                target.copy_from_slice(line.as_flattened());
            }
        }
    }

    /// Fills a part of the page with one colour.
    fn fill(&mut self, place: Rect, color: [u8; 3]) {
        self.put(place, &vec![color; (place.width * place.height * FINE * FINE) as usize]);
    }

    /// A filled circle.
    ///
    /// # Errors
    /// [`FigureError::Draw`].
    pub fn dot(&mut self, at: [f64; 2], radius: f64, color: [u8; 3]) -> Result<(), FigureError> {
        let fine = |x: f64| (x * f64::from(FINE)).round() as i32;
        let circle = Circle::new((fine(at[0]), fine(at[1])), fine(radius), rgb(color).filled());
        self.on(self.whole(), |area| Ok(area.draw(&circle)?))
    }

    /// The whole page as a rectangle.
    pub fn whole(&self) -> Rect {
        Rect { left: 0, top: 0, width: self.width, height: self.height }
    }

    /// Puts a picture on the page, its top left corner at `left`, `top`; what does not fit is cut off.
    pub fn paste(&mut self, image: &Image, left: u32, top: u32) {
        let row = (self.width * FINE) as usize * 3;
        let (across, down) =
            (image.width.min(self.width.saturating_sub(left)), image.height.min(self.height.saturating_sub(top)));
        if across == 0 {
            return;
        }
        for y in 0..down * FINE {
            let start = (top * FINE + y) as usize * row + (left * FINE) as usize * 3;
            let from = (y / FINE * image.width) as usize * 4;
            let line = &mut self.rgb[start..start + (across * FINE) as usize * 3];
            for (x, pixel) in line.chunks_exact_mut(3).enumerate() {
                let at = from + x / FINE as usize * 4;
                pixel.copy_from_slice(&image.rgba[at..at + 3]);
            }
        }
    }

    /// Reads the page out.
    ///
    /// Each pixel is the mean of its finer ones' bytes, not of their light: dark text and thin lines keep their weight
    /// on white that way.
    pub fn finish(self) -> Image {
        let (width, row) = (self.width as usize, (self.width * FINE) as usize * 3);
        let count = FINE * FINE;
        let mut rgba = Vec::with_capacity(width * self.height as usize * 4);
        for y in 0..self.height as usize {
            for x in 0..width {
                let mut sum = [count / 2; 3];
                for v in 0..FINE as usize {
                    let start = (y * FINE as usize + v) * row + x * FINE as usize * 3;
                    for pixel in self.rgb[start..start + FINE as usize * 3].chunks_exact(3) {
                        (0..3).for_each(|c| sum[c] += u32::from(pixel[c]));
                    }
                }
                rgba.extend(sum.map(|s| (s / count) as u8));
                rgba.push(255);
            }
        }
        Image { width: self.width, height: self.height, rgba }
    }
}

impl<E: Error + Send + Sync> From<DrawingAreaErrorKind<E>> for FigureError {
    fn from(error: DrawingAreaErrorKind<E>) -> FigureError {
        FigureError::Draw { problem: error.to_string() }
    }
}

/// Plotters' colour of sRGB bytes.
fn rgb(color: [u8; 3]) -> RGBColor {
    RGBColor(color[0], color[1], color[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inked(image: &Image) -> usize {
        image.rgba.chunks(4).filter(|p| p[0] < 128).count()
    }

    #[test]
    fn a_page_reads_out_what_was_drawn_and_the_same_twice() {
        let draw = |text: &str| {
            let mut page = Page::new(120, 60).expect("a page");
            Label::new(text, 20.0).draw(&mut page, 60.0, 30.0).expect("drawn");
            page.finish()
        };
        let image = draw("*s*_0 = 1");
        assert_eq!((image.width, image.height, image.rgba.len()), (120, 60, 120 * 60 * 4));
        assert!((100..2000).contains(&inked(&image)), "{}", inked(&image));
        assert_eq!(image.rgba, draw("*s*_0 = 1").rgba);
        assert_ne!(image.rgba, draw("*s*_1 = 1").rgba);
        assert_eq!(inked(&draw("")), 0);
    }

    #[test]
    fn a_pasted_picture_comes_back_pixel_for_pixel() {
        let rgba = (0..6 * 4 * 4u32).map(|i| if i % 4 == 3 { 255 } else { i as u8 }).collect();
        let image = Image { width: 6, height: 4, rgba };
        let mut page = Page::new(10, 8).expect("a page");
        page.paste(&image, 3, 2);
        let out = page.finish();
        let pixel = |image: &Image, x: u32, y: u32| {
            let at = (y * image.width + x) as usize * 4;
            image.rgba[at..at + 4].to_vec()
        };
        assert_eq!(pixel(&out, 3, 2), pixel(&image, 0, 0));
        assert_eq!(pixel(&out, 8, 5), pixel(&image, 5, 3));
        assert_eq!(pixel(&out, 2, 2), [255; 4]);
        assert_ne!(pixel(&out, 8, 5), pixel(&image, 4, 3), "another pixel must be seen");
        let mut page = Page::new(5, 3).expect("a page");
        page.paste(&image, 3, 2);
        assert_eq!(pixel(&page.finish(), 4, 2), pixel(&image, 1, 0), "what does not fit is cut off");
    }
}
