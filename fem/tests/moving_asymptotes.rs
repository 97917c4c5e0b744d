//! The method of moving asymptotes compared with the examples of its author and closed forms.

use std::convert::Infallible;

use forms_fem::inverse::{
    Bounds, ConstrainedMinimum, Inequality, MovingAsymptotes, ReducedProblem, StopReason,
};
use forms_fem::verification::Sample;

type Function = fn(&[f64]) -> (f64, Vec<f64>);

/// A function with its gradient, and a start.
struct Given(Vec<f64>, Function);

impl ReducedProblem for Given {
    type Error = Infallible;

    fn start(&self) -> Vec<f64> {
        self.0.clone()
    }

    fn sample(&mut self, m: &[f64]) -> Result<Sample, Infallible> {
        Ok((self.1)(m).0.into())
    }

    fn value_and_gradient(&mut self, m: &[f64]) -> Result<(f64, Vec<f64>), Infallible> {
        Ok((self.1)(m))
    }
}

fn solved(start: &[f64], value: Function, bounds: &Bounds, constraints: &[Function]) -> ConstrainedMinimum {
    let inequality = |function: &Function| -> Box<Inequality<'static, Infallible>> {
        let function = *function;
        Box::new(move |m| Ok(function(m)))
    };
    let mut constraints: Vec<_> = constraints.iter().map(inequality).collect();
    let options = MovingAsymptotes { tolerance: 1e-6, ..MovingAsymptotes::default() };
    options.run(&mut Given(start.to_vec(), value), bounds, &mut constraints, |_| ()).unwrap()
}

/// Svanberg's beam of five hollow elements (1987, section 4.1): the weight under a bound of the deflection, 1.340.
#[test]
fn a_beam_of_five_elements() {
    let weight = |x: &[f64]| (0.0624 * x.iter().sum::<f64>(), vec![0.0624; 5]);
    let deflection = |x: &[f64]| {
        let of = [61.0, 37.0, 19.0, 7.0, 1.0];
        let value = of.iter().zip(x).map(|(a, x)| a / x.powi(3)).sum::<f64>() - 1.0;
        (value, of.iter().zip(x).map(|(a, x)| -3.0 * a / x.powi(4)).collect::<Vec<_>>())
    };
    let found = solved(&[5.0; 5], weight, &Bounds::between(5, 1.0, 10.0), &[deflection]);
    assert_eq!(found.finish, StopReason::Tolerance, "{:?}", found.history.last());
    // By Lagrange's conditions x_i is a multiple of a_i^¼.
    let roots: Vec<f64> = [61.0_f64, 37.0, 19.0, 7.0, 1.0].iter().map(|a| a.powf(0.25)).collect();
    let factor = roots.iter().sum::<f64>().cbrt();
    for (found, root) in found.controls.iter().zip(&roots) {
        assert!((found - factor * root).abs() < 1e-4, "{found} {}", factor * root);
    }
    assert!((found.value - 1.340).abs() < 5e-4 && found.constraints[0].abs() < 1e-6, "{found:?}");
    assert!(found.history.len() < 40, "{}", found.history.len());
}

/// His truss of two bars (section 4.2): area and half the distance of the supports under two bounds of stress, 1.51 at (1.41, 0.38).
#[test]
fn a_truss_of_two_bars() {
    fn stress(x: &[f64], sign: f64) -> (f64, Vec<f64>) {
        let (root, sum) = ((1.0 + x[1] * x[1]).sqrt(), 8.0 / x[0] + sign / (x[0] * x[1]));
        let by_area = -root * sum / x[0];
        let by_distance = x[1] / root * sum - sign * root / (x[0] * x[1] * x[1]);
        (0.124 * root * sum - 1.0, vec![0.124 * by_area, 0.124 * by_distance])
    }
    let weight = |x: &[f64]| {
        let root = (1.0 + x[1] * x[1]).sqrt();
        (x[0] * root, vec![root, x[0] * x[1] / root])
    };
    let bounds = Bounds::each(vec![0.2, 0.1], vec![4.0, 1.6]);
    let found = solved(&[1.5, 0.5], weight, &bounds, &[|x| stress(x, 1.0), |x| stress(x, -1.0)]);
    assert_eq!(found.finish, StopReason::Tolerance, "{:?}", found.history.last());
    assert!((found.value - 1.51).abs() < 5e-3, "{found:?}");
    assert!((found.controls[0] - 1.41).abs() < 5e-3 && (found.controls[1] - 0.38).abs() < 5e-3, "{found:?}");
    assert!(found.multipliers[0] > 0.1 && found.multipliers[1] == 0.0, "{:?}", found.multipliers);
}

/// Two constraints that hold with equality at once: x² + y² + z² from below by x + y ≥ 2 and y + z ≥ 3: Lagrange's conditions by hand.
#[test]
fn two_constraints_at_once() {
    let squares =
        |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>(), x.iter().map(|x| 2.0 * x).collect::<Vec<_>>());
    let found = solved(
        &[3.0; 3],
        squares,
        &Bounds::between(3, -5.0, 5.0),
        &[|x| (2.0 - x[0] - x[1], vec![-1.0, -1.0, 0.0]), |x| (3.0 - x[1] - x[2], vec![0.0, -1.0, -1.0])],
    );
    // x = λ/2, y = (λ + μ)/2, z = μ/2 with 2λ + μ = 4 and λ + 2μ = 6.
    for (found, exact) in found.controls.iter().zip([1.0 / 3.0, 5.0 / 3.0, 4.0 / 3.0]) {
        assert!((found - exact).abs() < 1e-4, "{found} {exact}");
    }
    let multipliers = [2.0 / 3.0, 8.0 / 3.0];
    for (found, exact) in found.multipliers.iter().zip(multipliers) {
        assert!((found - exact).abs() < 1e-2, "{found} {exact}");
    }
}

#[test]
fn what_does_not_fit_is_named() {
    let run = |bounds: &Bounds, gradient: Vec<f64>| {
        let mut constraints: Vec<Box<Inequality<'_, Infallible>>> =
            vec![Box::new(move |_| Ok((0.0, gradient.clone())))];
        let mut problem = Given(vec![0.0; 2], |m| (m[0], vec![1.0, 0.0]));
        let found = MovingAsymptotes::default().run(&mut problem, bounds, &mut constraints, |_| ());
        found.map(|_| ()).unwrap_err().to_string()
    };
    let infinite = run(&Bounds::none(2), vec![0.0; 2]);
    assert!(infinite.contains("control 0 has no finite bounds"), "{infinite}");
    let short = run(&Bounds::between(2, -1.0, 1.0), vec![0.0]);
    assert!(short.contains("constraint 0 has a gradient of 1 entries for 2 controls"), "{short}");
    let nan = run(&Bounds::between(2, -1.0, 1.0), vec![0.0, f64::NAN]);
    assert!(nan.contains("iteration 0: constraint 0 or its gradient is not finite"), "{nan}");
}
