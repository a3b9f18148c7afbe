//! Closed outlines of sections: sampled evenly, smoothed, and their curvature.

use glam::DVec2;
use std::f64::consts::TAU;

/// Length of a closed polygon.
pub fn perimeter(points: &[DVec2]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| a.distance(*b)).sum()
}

/// `count` points at even distances along a closed polygon, from its first point on.
pub fn resample(points: &[DVec2], count: usize) -> Vec<DVec2> {
    let step = perimeter(points) / count as f64;
    let mut out = Vec::with_capacity(count);
    let mut gone = 0.0;
    for (k, a) in points.iter().enumerate() {
        let b = points[(k + 1) % points.len()];
        let length = a.distance(b);
        while out.len() < count && out.len() as f64 * step <= gone + length {
            let share = if length > 0.0 { (out.len() as f64 * step - gone) / length } else { 0.0 };
            out.push(a.lerp(b, share.clamp(0.0, 1.0)));
        }
        gone += length;
    }
    out.resize(count, points[0]);
    out
}

/// A turn smaller than this is none, radians.
const STRAIGHT: f64 = 2e-4;

/// Points of a closed polygon at which it turns: those along a straight side, as of a mesh that was divided flat, tell nothing.
pub fn corners(points: &[DVec2]) -> usize {
    let least = 1e-6 * perimeter(points) / points.len().max(1) as f64;
    // Through a vertex a plane cuts several edges at one place.
    let apart = |&k: &usize| points[k].distance(points[(k + 1) % points.len()]) > least;
    let points: Vec<DVec2> = (0..points.len()).filter(apart).map(|k| points[k]).collect();
    let count = points.len();
    let turns = |&k: &usize| {
        let (before, after) = (points[k] - points[(k + count - 1) % count], points[(k + 1) % count] - points[k]);
        before.perp_dot(after).abs() > STRAIGHT * before.length() * after.length()
    };
    (0..count).filter(turns).count()
}

/// A closed polygon from where a ray from its middle along the first axis leaves it: outlines of successive sections, of left
/// and right, and of a finer mesh then have their samples at the same places.
///
/// `bridged` tells of every point whether the way from it to the next is a bridge over what was cut away.
pub fn from_front(points: &[DVec2], bridged: &[bool]) -> (Vec<DVec2>, Vec<bool>) {
    let count = points.len();
    let middle = points.iter().sum::<DVec2>() / count.max(1) as f64;
    let leaves = |k: &usize| {
        let (a, b) = (points[*k] - middle, points[(k + 1) % count] - middle);
        ((a.y > 0.0) != (b.y > 0.0)).then(|| (*k, a.x - a.y * (b.x - a.x) / (b.y - a.y)))
    };
    let crossings = (0..count).filter_map(|k| leaves(&k)).filter(|(_, x)| *x > 0.0);
    let Some((at, x)) = crossings.max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return (points.to_vec(), bridged.to_vec());
    };
    let first = (middle + DVec2::X * x, bridged[at]);
    let others = (1..=count).map(|k| (at + k) % count).map(|k| (points[k], bridged[k]));
    std::iter::once(first).chain(others).unzip()
}

/// Which of `count` even samples of a closed polygon are on bridges.
pub fn bridged_samples(points: &[DVec2], bridged: &[bool], count: usize) -> Vec<bool> {
    let step = perimeter(points) / count as f64;
    let mut out = Vec::with_capacity(count);
    let mut gone = 0.0;
    for (k, a) in points.iter().enumerate() {
        gone += a.distance(points[(k + 1) % points.len()]);
        while out.len() < count && out.len() as f64 * step <= gone {
            out.push(bridged[k]);
        }
    }
    out.resize(count, false);
    out
}

/// A closed, evenly sampled outline under a Gaussian of standard deviation `sigma`, metres.
///
/// What the Gaussian takes of a circle's radius is given back to first order: the outline is scaled about its centre to
/// have the perimeter that it had.
pub fn smooth(points: &[DVec2], sigma: f64) -> Vec<DVec2> {
    let count = points.len();
    let before = perimeter(points);
    let deviation = sigma / (before / count as f64);
    if deviation < 0.1 {
        return points.to_vec();
    }
    let reach = ((3.0 * deviation).ceil() as usize).min(count / 2);
    let weight = |k: usize| (-0.5 * (k as f64 / deviation).powi(2)).exp();
    let total = 1.0 + 2.0 * (1..=reach).map(weight).sum::<f64>();
    let smoothed: Vec<DVec2> = (0..count)
        .map(|i| {
            let pair = |k: usize| (points[(i + k) % count] + points[(i + count - k) % count]) * weight(k);
            (points[i] + (1..=reach).map(pair).sum::<DVec2>()) / total
        })
        .collect();
    let centre = smoothed.iter().sum::<DVec2>() / count as f64;
    let grow = before / perimeter(&smoothed);
    smoothed.into_iter().map(|p| centre + (p - centre) * grow).collect()
}

/// Curvature at every point of a closed, evenly sampled, anticlockwise outline, times `perimeter / 2 pi`: 1 on a circle,
/// negative in hollows.
pub fn curvature(points: &[DVec2]) -> Vec<f64> {
    let count = points.len();
    let scale = perimeter(points) / TAU;
    (0..count)
        .map(|i| {
            let (a, b, c) = (points[(i + count - 1) % count], points[i], points[(i + 1) % count]);
            let sides = a.distance(b) * b.distance(c) * c.distance(a);
            // The circle through three points: four times the triangle's area over the product of its sides.
            if sides > 0.0 { 2.0 * (b - a).perp_dot(c - b) / sides * scale } else { 0.0 }
        })
        .collect()
}

/// How far every point of a closed, evenly sampled, anticlockwise outline stands out of the same outline under a wide Gaussian of
/// deviation `sigma`, metres: what varies along the outline, without its shape at large.
pub fn variation(points: &[DVec2], sigma: f64) -> Vec<f64> {
    let count = points.len();
    let large = smooth(points, sigma);
    let one = |i: usize| {
        let along = (large[(i + 1) % count] - large[(i + count - 1) % count]).normalize_or_zero();
        // Inside is on the left of an anticlockwise way.
        -along.perp_dot(points[i] - large[i])
    };
    (0..count).map(one).collect()
}

/// How rough a closed, evenly sampled outline is, metres: the deviation of noise whose fourth differences would be as large as
/// the outline's own.
pub fn roughness(points: &[DVec2]) -> f64 {
    let count = points.len();
    let at = |i: usize, k: usize| points[(i + k) % count];
    let fourth = |i: usize| at(i, 0) - 4.0 * at(i, 1) + 6.0 * at(i, 2) - 4.0 * at(i, 3) + at(i, 4);
    // Both coordinates; one, four, six, four and one squared add up to 70.
    ((0..count).map(|i| fourth(i).length_squared()).sum::<f64>() / (70.0 * count as f64)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ellipse(count: usize, a: f64, b: f64) -> Vec<DVec2> {
        let point = |k: usize| DVec2::from_angle(TAU * k as f64 / count as f64) * DVec2::new(a, b);
        (0..count).map(point).collect()
    }

    #[test]
    fn circles_stay_circles() {
        let sampled = resample(&ellipse(40, 0.05, 0.05), 96);
        let smoothed = smooth(&sampled, 0.03 * perimeter(&sampled));
        assert!((perimeter(&smoothed) - perimeter(&sampled)).abs() < 1e-9);
        for (p, k) in smoothed.iter().zip(curvature(&smoothed)) {
            assert!((p.length() - 0.05).abs() < 1e-4 && (k - 1.0).abs() < 0.02, "{p} {k}");
        }
    }

    #[test]
    fn curvature_is_an_ellipses_own() {
        let (a, b) = (0.06, 0.04);
        let points = resample(&ellipse(40_000, a, b), 500);
        let scale = perimeter(&points) / TAU;
        for (p, k) in points.iter().zip(curvature(&points)) {
            let expected = 1.0 / (a * a * b * b * ((p.x / (a * a)).powi(2) + (p.y / (b * b)).powi(2)).powf(1.5));
            assert!((k - expected * scale).abs() < 0.01 * expected * scale, "{p}: {k} {}", expected * scale);
        }
    }

    #[test]
    fn samples_are_even() {
        let sampled = resample(&ellipse(37, 0.06, 0.02), 96);
        let steps: Vec<f64> = (0..96).map(|k| sampled[k].distance(sampled[(k + 1) % 96])).collect();
        let mean = steps.iter().sum::<f64>() / 96.0;
        assert!(steps.iter().all(|s| (s / mean - 1.0).abs() < 0.1), "{steps:?}");
    }

    #[test]
    fn points_along_sides_are_no_corners() {
        let coarse = ellipse(40, 0.06, 0.02);
        assert_eq!(corners(&coarse), 40);
        let halved = |k: usize| [coarse[k], coarse[k].lerp(coarse[(k + 1) % 40], 0.3)];
        assert_eq!(corners(&(0..40).flat_map(halved).collect::<Vec<_>>()), 40);
        assert_eq!(corners(&coarse.iter().flat_map(|p| [*p, *p]).collect::<Vec<_>>()), 40);
    }
}
