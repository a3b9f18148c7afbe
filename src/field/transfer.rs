//! From raw distance to a field with compact support (background 1.5; the polynomial of Implicit Skinning).

/// Value and derivative of the transfer `t_r` at raw distance `d` for support radius `r`, both in metres.
///
/// `t_r` falls from 1 at `d <= -r` through 1/2 at 0 to 0 at `d >= r`, twice continuously differentiable.
#[inline]
pub fn transfer(d: f32, r: f32) -> (f32, f32) {
    if d <= -r {
        return (1.0, 0.0);
    }
    if d >= r {
        return (0.0, 0.0);
    }
    let x = d / r;
    let x2 = x * x;
    let rest = 1.0 - x2;
    let value = 0.5 - x * (0.9375 - x2 * (0.625 - 0.1875 * x2));
    (value, -0.9375 * rest * rest / r)
}

#[cfg(test)]
mod tests {
    use super::transfer;

    #[test]
    fn check_values_of_the_background() {
        for (d, expected) in [(0.0, 0.5), (-0.5, 0.89648), (0.25, 0.27521), (0.5, 0.10352), (1.0, 0.0), (-1.0, 1.0)] {
            let (value, _) = transfer(d * 0.04, 0.04);
            assert!((value - expected).abs() < 1e-5, "t({d} r) = {value}");
        }
        assert!((transfer(0.0, 0.04).1 + 15.0 / (16.0 * 0.04)).abs() < 1e-4);
    }

    #[test]
    fn derivative_is_that_of_the_value_and_support_closes_smoothly() {
        let r = 0.05f64;
        let exact = |d: f64| {
            let x = d / r;
            -3.0 / 16.0 * x.powi(5) + 5.0 / 8.0 * x.powi(3) - 15.0 / 16.0 * x + 0.5
        };
        for i in -99..100 {
            let d = f64::from(i) * 0.01 * r;
            let slope = (exact(d + 1e-6) - exact(d - 1e-6)) / 2e-6;
            let (value, derivative) = transfer(d as f32, r as f32);
            assert!((f64::from(value) - exact(d)).abs() < 1e-6);
            assert!((f64::from(derivative) - slope).abs() < 2e-4 * (1.0 + slope.abs()));
        }
        assert_eq!(transfer(0.06, 0.05), (0.0, 0.0));
        assert_eq!(transfer(-0.06, 0.05), (1.0, 0.0));
    }
}
