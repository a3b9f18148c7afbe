//! Pictures on the host: sRGB bytes, smaller copies, contact sheets.

/// An sRGB picture, 8 bits per channel, opaque where a renderer drew it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// `width * height * 4` bytes, rows from the top.
    pub rgba: Vec<u8>,
}

/// Linear value of an sRGB byte.
pub(super) fn to_linear(byte: u8) -> f32 {
    let v = byte as f32 / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB byte nearest to a linear value.
pub(super) fn to_srgb(linear: f32) -> u8 {
    let v = linear.clamp(0.0, 1.0);
    let encoded = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

impl Picture {
    /// A picture of one colour (sRGB bytes).
    pub fn filled(width: u32, height: u32, rgba: [u8; 4]) -> Picture {
        Picture { width, height, rgba: rgba.repeat(width as usize * height as usize) }
    }

    /// The pixel at `x`, `y`, counted from the top left corner.
    ///
    /// # Panics
    /// Outside the picture.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        let at = (y as usize * self.width as usize + x as usize) * 4;
        [self.rgba[at], self.rgba[at + 1], self.rgba[at + 2], self.rgba[at + 3]]
    }

    /// A copy with sides `factor` times shorter, each pixel the mean light of the square it stands for.
    ///
    /// What is left over at the right and the bottom joins the last pixel's square; `factor` 0 counts as 1.
    pub fn reduced(&self, factor: u32) -> Picture {
        let factor = factor.max(1);
        if factor == 1 || self.width == 0 || self.height == 0 {
            return self.clone();
        }
        let linear: [f32; 256] = std::array::from_fn(|b| to_linear(b as u8));
        let (width, height) = ((self.width / factor).max(1), (self.height / factor).max(1));
        let last = |i: u32, count: u32, side: u32| if i + 1 == count { side } else { ((i + 1) * factor).min(side) };
        let mut rgba = Vec::with_capacity(width as usize * height as usize * 4);
        for y in 0..height {
            for x in 0..width {
                let (mut sum, mut count) = ([0.0f32; 4], 0.0f32);
                for v in y * factor..last(y, height, self.height) {
                    for u in x * factor..last(x, width, self.width) {
                        let p = self.pixel(u, v);
                        for c in 0..3 {
                            sum[c] += linear[p[c] as usize];
                        }
                        sum[3] += p[3] as f32;
                        count += 1.0;
                    }
                }
                rgba.extend([0, 1, 2].map(|c| to_srgb(sum[c] / count)));
                rgba.push((sum[3] / count + 0.5) as u8);
            }
        }
        Picture { width, height, rgba }
    }

    fn paste(&mut self, other: &Picture, left: u32, top: u32) {
        let row = other.width as usize * 4;
        for y in 0..other.height {
            let from = y as usize * row;
            let to = ((top + y) as usize * self.width as usize + left as usize) * 4;
            self.rgba[to..to + row].copy_from_slice(&other.rgba[from..from + row]);
        }
    }

    fn fill(&mut self, (left, top): (u32, u32), (width, height): (u32, u32), rgba: [u8; 4]) {
        for y in top..(top + height).min(self.height) {
            for x in left..(left + width).min(self.width) {
                let at = (y as usize * self.width as usize + x as usize) * 4;
                self.rgba[at..at + 4].copy_from_slice(&rgba);
            }
        }
    }

    /// Writes a number, its top left corner at `left`, `top`, in squares of `scale` pixels.
    fn write_number(&mut self, number: u32, left: u32, top: u32, scale: u32) {
        for (i, digit) in number.to_string().bytes().enumerate() {
            for (row, bits) in DIGITS[(digit - b'0') as usize].into_iter().enumerate() {
                for column in 0..3u32 {
                    if bits & (0b100 >> column) != 0 {
                        let place = (left + (i as u32 * 4 + column) * scale, top + row as u32 * scale);
                        self.fill(place, (scale, scale), INK);
                    }
                }
            }
        }
    }
}

const PAPER: [u8; 4] = [24, 25, 28, 255];
const INK: [u8; 4] = [226, 228, 232, 255];
/// Pixels between the pictures of a sheet.
const GAP: u32 = 4;
/// Rows of each digit, three bits a row.
const DIGITS: [[u8; 5]; 10] = [
    [0b111, 0b101, 0b101, 0b101, 0b111],
    [0b010, 0b110, 0b010, 0b010, 0b111],
    [0b111, 0b001, 0b111, 0b100, 0b111],
    [0b111, 0b001, 0b111, 0b001, 0b111],
    [0b101, 0b101, 0b111, 0b001, 0b001],
    [0b111, 0b100, 0b111, 0b001, 0b111],
    [0b111, 0b100, 0b111, 0b101, 0b111],
    [0b111, 0b001, 0b010, 0b010, 0b010],
    [0b111, 0b101, 0b111, 0b101, 0b111],
    [0b111, 0b101, 0b111, 0b001, 0b111],
];

/// All `pictures` on one sheet, `columns` side by side, with thin gaps.
///
/// `numbers[i]`, where there is one, is written into the top left corner of picture `i`: its frame. Cells take the
/// largest picture's size. No pictures give a picture of 0 x 0; `columns` 0 counts as 1.
pub fn contact_sheet(pictures: &[Picture], numbers: &[u32], columns: u32) -> Picture {
    let count = pictures.len() as u32;
    if count == 0 {
        return Picture::default();
    }
    let columns = columns.clamp(1, count);
    let rows = count.div_ceil(columns);
    let cell_width = pictures.iter().map(|p| p.width).max().unwrap_or(0);
    let cell_height = pictures.iter().map(|p| p.height).max().unwrap_or(0);
    let mut sheet = Picture::filled(columns * (cell_width + GAP) + GAP, rows * (cell_height + GAP) + GAP, PAPER);
    let scale = (cell_height / 160).max(1);
    for (i, picture) in pictures.iter().enumerate() {
        let (column, row) = (i as u32 % columns, i as u32 / columns);
        let (left, top) = (GAP + column * (cell_width + GAP), GAP + row * (cell_height + GAP));
        sheet.paste(picture, left, top);
        if let Some(&number) = numbers.get(i) {
            sheet.write_number(number, left + 3 * scale, top + 3 * scale, scale);
        }
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_bytes_survive_the_way_there_and_back() {
        for b in 0..=255u8 {
            assert_eq!(to_srgb(to_linear(b)), b);
        }
        // The standard's own midpoint: linear 0.5 is byte 188, and half the byte range is much darker.
        assert_eq!(to_srgb(0.5), 188);
        assert!((to_linear(128) - 0.2159).abs() < 1e-4);
    }

    #[test]
    fn reducing_averages_light_and_not_bytes() {
        let mut picture = Picture::filled(5, 2, [0, 0, 0, 255]);
        picture.fill((0, 0), (1, 2), [255, 255, 255, 255]);
        let small = picture.reduced(2);
        assert_eq!((small.width, small.height), (2, 1));
        assert_eq!(small.pixel(0, 0), [188, 188, 188, 255]);
        assert_eq!(small.pixel(1, 0), [0, 0, 0, 255]);
        assert_eq!(picture.reduced(0), picture);
    }

    #[test]
    fn a_sheet_holds_every_picture_in_reading_order() {
        let colors = [[10, 0, 0, 255], [20, 0, 0, 255], [30, 0, 0, 255]];
        let pictures = colors.map(|c| Picture::filled(20, 30, c));
        let sheet = contact_sheet(&pictures, &[], 2);
        assert_eq!((sheet.width, sheet.height), (2 * 24 + 4, 2 * 34 + 4));
        assert_eq!(sheet.pixel(4, 4), colors[0]);
        assert_eq!(sheet.pixel(28, 4), colors[1]);
        assert_eq!(sheet.pixel(23, 38 + 29), colors[2]);
        assert_eq!(sheet.pixel(24, 10), PAPER);
        assert_eq!(sheet.pixel(40, 50), PAPER);
        assert_eq!(contact_sheet(&[], &[], 3), Picture::default());
    }

    #[test]
    fn numbers_differ_on_the_sheet() {
        let picture = [Picture::filled(20, 30, [10, 0, 0, 255])];
        let inked = |n: u32| contact_sheet(&picture, &[n], 1).rgba.chunks(4).filter(|p| *p == INK).count();
        assert_eq!(inked(1), 8);
        assert_eq!(inked(8), 13);
        assert_ne!(contact_sheet(&picture, &[1], 1), contact_sheet(&picture, &[2], 1));
    }
}
