//! What options say: devices, frames, sizes, numbers.

use std::num::NonZeroUsize;
use std::str::FromStr;

/// `--device`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Device {
    /// The best adapter.
    Auto,
    /// The CPU reference.
    Cpu,
    /// The adapter whose name contains this.
    Named(String),
}

impl FromStr for Device {
    type Err = String;

    fn from_str(text: &str) -> Result<Device, String> {
        match text {
            "auto" => Ok(Device::Auto),
            "cpu" => Ok(Device::Cpu),
            "" => Err("give auto, cpu or part of an adapter's name".into()),
            name => Ok(Device::Named(name.into())),
        }
    }
}

/// `--frames`: both ends belong to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// First frame.
    pub first: u32,
    /// Last frame.
    pub last: u32,
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<FrameRange, String> {
        let number =
            |s: &str| s.parse::<u32>().map_err(|_| format!("{s:?} is no frame number; give A..B or one frame"));
        let (first, last) = match text.split_once("..") {
            Some((a, b)) => (number(a)?, number(b)?),
            None => (number(text)?, number(text)?),
        };
        if last < first {
            return Err(format!("ends before it begins; {last}..{first}?"));
        }
        Ok(FrameRange { first, last })
    }
}

/// `--size`: pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Size, String> {
        let pixels = |s: &str| s.parse::<u32>().ok().filter(|n| (1..=16384).contains(n));
        text.split_once(['x', 'X'])
            .and_then(|(w, h)| Some(Size { width: pixels(w)?, height: pixels(h)? }))
            .ok_or_else(|| "give WIDTHxHEIGHT, each 1 to 16384".into())
    }
}

pub(super) fn parse_threads(text: &str) -> Result<NonZeroUsize, String> {
    text.parse::<NonZeroUsize>().ok().filter(|n| n.get() <= 1024).ok_or_else(|| "give 1 to 1024".into())
}

pub(super) fn parse_fps(text: &str) -> Result<f32, String> {
    text.parse::<f32>().ok().filter(|fps| (0.001..=10_000.0).contains(fps)).ok_or_else(|| "give 0.001 to 10000".into())
}

pub(super) fn parse_angle(text: &str) -> Result<f32, String> {
    text.parse::<f32>().ok().filter(|a| a.is_finite()).ok_or_else(|| "give degrees".into())
}

pub(super) fn parse_elevation(text: &str) -> Result<f32, String> {
    parse_angle(text).ok().filter(|a| a.abs() <= 89.0).ok_or_else(|| "give degrees from -89 to 89".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_inclusive() {
        assert_eq!("0..47".parse(), Ok(FrameRange { first: 0, last: 47 }));
        assert_eq!("7".parse(), Ok(FrameRange { first: 7, last: 7 }));
        for wrong in ["", "..", "3..", "5..4", "a..b", "-1..2", "1...3"] {
            assert!(wrong.parse::<FrameRange>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes_have_two_positive_numbers() {
        assert_eq!("96x128".parse(), Ok(Size { width: 96, height: 128 }));
        for wrong in ["", "96", "x", "0x5", "5x0", "5x99999", "5x5x5", "-5x5"] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong}");
        }
    }
}
