//! Colours that differ in lightness too, so that all eyes, and a grey print, can tell them apart.

/// Text and axes.
pub const INK: [u8; 3] = [34, 36, 40];
/// Grid lines.
pub const RULE: [u8; 3] = [225, 227, 231];
/// Notes beside the matter.
pub const PALE: [u8; 3] = [110, 114, 122];

/// Colours for lines that have no order: Okabe's and Ito's, from dark to light, without the yellow that white swallows.
pub const SERIES: [[u8; 3]; 7] =
    [[0, 0, 0], [0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233]];

/// The map `viridis` (CC0), every eighth of it.
const RAMP: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 45, 123],
    [59, 82, 139],
    [44, 114, 142],
    [33, 145, 140],
    [40, 174, 128],
    [94, 201, 98],
    [173, 220, 48],
    [253, 231, 37],
];

/// A colour for a share 0..=1, dark to light: perceptually even, also for colour-blind eyes.
pub fn ramp(share: f64) -> [u8; 3] {
    let place = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) } * (RAMP.len() - 1) as f64;
    let i = (place as usize).min(RAMP.len() - 2);
    let t = place - i as f64;
    std::array::from_fn(|c| (f64::from(RAMP[i][c]) * (1.0 - t) + f64::from(RAMP[i + 1][c]) * t).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lightness([r, g, b]: [u8; 3]) -> f64 {
        0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
    }

    #[test]
    fn the_ramp_gets_lighter_all_the_way() {
        let steps: Vec<f64> = (0..=40).map(|i| lightness(ramp(f64::from(i) / 40.0))).collect();
        assert!(steps.windows(2).all(|w| w[1] > w[0]), "{steps:?}");
        assert_eq!(ramp(f64::NAN), ramp(0.0));
        assert_eq!((ramp(-1.0), ramp(2.0)), (RAMP[0], RAMP[8]));
    }
}
