//! Gauss-Jacobi points and weights on \[0, 1\], by Newton's method on the Jacobi polynomials.

/// Points t and weights w with Σ w f(t) = ∫₀¹ (1 − t)^alpha f(t) dt for polynomials f up to degree
/// 2 `points` − 1. Gauss-Legendre is `alpha = 0`. The points ascend.
pub fn gauss_jacobi(points: usize, alpha: u32) -> Vec<(f64, f64)> {
    let mut roots: Vec<f64> = Vec::with_capacity(points);
    for index in 0..points {
        // Between the last root and the next Chebyshev point; deflation keeps Newton's method away from
        // the roots that are already known (Karniadakis and Sherwin, appendix B).
        let mut x = -(std::f64::consts::PI * (2 * index + 1) as f64 / (2 * points) as f64).cos();
        if let Some(previous) = roots.last() {
            x = 0.5 * (x + previous);
        }
        for _ in 0..100 {
            let (value, slope) = jacobi(points, f64::from(alpha), x);
            let poles: f64 = roots.iter().map(|root| 1.0 / (x - root)).sum();
            let step = value / (slope - value * poles);
            x -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        // Undeflated steps to the last digit.
        for _ in 0..2 {
            let (value, slope) = jacobi(points, f64::from(alpha), x);
            x -= value / slope;
        }
        roots.push(x);
    }
    if alpha == 0 {
        // The Legendre roots are symmetric; round-off must not break that.
        for index in 0..points / 2 {
            let half = 0.5 * (roots[points - 1 - index] - roots[index]);
            roots[index] = -half;
            roots[points - 1 - index] = half;
        }
        if points % 2 == 1 {
            roots[points / 2] = 0.0;
        }
    }
    roots
        .into_iter()
        .map(|x| {
            let (_, slope) = jacobi(points, f64::from(alpha), x);
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x) * (1.0 + x) * slope * slope))
        })
        .collect()
}

// Value and slope of the Jacobi polynomial P_n^(alpha, 0) at x in (-1, 1), by the three-term recurrence.
fn jacobi(degree: usize, alpha: f64, x: f64) -> (f64, f64) {
    if degree == 0 {
        return (1.0, 0.0);
    }
    let (mut previous, mut value) = (1.0, 0.5 * (alpha + (alpha + 2.0) * x));
    let (mut previous_slope, mut slope) = (0.0, 0.5 * (alpha + 2.0));
    for n in 2..=degree {
        let n = n as f64;
        let c = 2.0 * n + alpha;
        let scale = 2.0 * n * (n + alpha) * (c - 2.0);
        let linear = (c - 1.0) * c * (c - 2.0) / scale;
        let constant = (c - 1.0) * alpha * alpha / scale;
        let back = 2.0 * (n + alpha - 1.0) * (n - 1.0) * c / scale;
        let next = (linear * x + constant) * value - back * previous;
        let next_slope = linear * value + (linear * x + constant) * slope - back * previous_slope;
        (previous, value) = (value, next);
        (previous_slope, slope) = (slope, next_slope);
    }
    (value, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    // ∫₀¹ (1-t)^a t^k dt = a! k! / (a+k+1)!
    fn moment(alpha: u32, k: u32) -> f64 {
        (1..=alpha).fold(1.0 / f64::from(k + 1), |m, a| m * f64::from(a) / f64::from(k + 1 + a))
    }

    #[test]
    fn moments_are_exact() {
        for alpha in 0..=2 {
            for points in 1..=40 {
                let rule = gauss_jacobi(points, alpha);
                assert!(rule.windows(2).all(|pair| pair[0].0 < pair[1].0));
                assert!(rule.iter().all(|&(t, w)| t > 0.0 && t < 1.0 && w > 0.0));
                for k in 0..2 * points as u32 {
                    let sum: f64 = rule.iter().map(|&(t, w)| w * t.powi(k as i32)).sum();
                    assert!((sum - moment(alpha, k)).abs() < 1e-14, "{alpha} {points} {k}");
                }
            }
        }
    }

    #[test]
    fn five_legendre_points_in_closed_form() {
        let rule = gauss_jacobi(5, 0);
        let outer = (5.0 + 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0;
        let inner = (5.0 - 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0;
        let (low, high) = ((322.0 - 13.0 * 70f64.sqrt()) / 1800.0, (322.0 + 13.0 * 70f64.sqrt()) / 1800.0);
        let expected = [(-outer, low), (-inner, high), (0.0, 64.0 / 225.0), (inner, high), (outer, low)];
        for ((t, w), (x, v)) in rule.into_iter().zip(expected) {
            assert!((t - 0.5 * (1.0 + x)).abs() < 2e-16 && (w - v).abs() < 4e-16);
        }
    }
}
