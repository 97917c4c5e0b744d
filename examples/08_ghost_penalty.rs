//! Tutorial 8: a penalty on jumps of the normal gradient. Transport with little diffusion.
//!
//! `−ε Δu + ∂u/∂x = 1` on the unit square, u = 0 on the left and on the right. The solution
//! `u = x − (e^((x−1)/ε) − e^(−1/ε)) / (1 − e^(−1/ε))` is a ramp with a layer of width ε on the right. On cells wider than the layer
//! the plain method oscillates everywhere. A small multiple of `∫ h² ⟦∂u/∂n⟧⟦∂v/∂n⟧` over the facets between cells cures it (continuous
//! interior penalty); the same term, then called ghost penalty, stabilises cut elements.
//!
//! Run it with `cargo run --release --bin 08_ghost_penalty`.

use forms_fem::output::picture::{Curve, LinePlot, Picture, Scale};
use forms_fem::prelude::*;

#[forms]
mod transport {
    pub struct Data {
        pub diffusivity: Param,
        pub wind: Param<Vector>,
        /// Weight of the penalty; zero switches it off.
        pub weight: Param,
    }

    #[cells]
    pub struct Omega;
    #[interior_facets]
    pub struct Inner;

    /// The jump of ∂w/∂n. A smooth function has none, so that the penalty does not spoil the solution.
    fn kink(w: Scalar) -> Scalar {
        dot(jump(grad(w)), n)
    }

    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, diffusivity * dot(grad(u), grad(v)) + dot(wind, grad(u)) * v - v)
            + integral(Inner, weight * pow(avg(h), 2) * abs(dot(wind, n)) * kink(u) * kink(v))
    }
}

const DIFFUSIVITY: f64 = 1e-3;

fn exact(x: f64) -> f64 {
    let low = (-1.0 / DIFFUSIVITY).exp();
    x - (((x - 1.0) / DIFFUSIVITY).exp() - low) / (1.0 - low)
}

fn solve(weight: f64) -> Result<Field<2>, Failure> {
    let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [20, 20], CellShape::Triangle, 1)?;
    let space = Space::scalar(&mesh, 1)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix("left", |_| 0.0)?;
    constraints.fix("right", |_| 0.0)?;
    let data = transport::data().diffusivity(DIFFUSIVITY).wind([1.0, 0.0]).weight(weight);
    let form = transport::Model::new(data).balance();
    Ok(Problem::new(&form, &space).constrained(&constraints).solve()?.into_field())
}

fn main() -> Result<(), Failure> {
    let x: Vec<f64> = (0..=200).map(|k| f64::from(k) / 200.0).collect();
    let closed_form: Vec<f64> = x.iter().map(|x| exact(*x)).collect();
    let mut plot = LinePlot::new()
        .x_axis("x", Scale::Linear)
        .y_axis("u", Scale::Linear)
        .curve(Curve::new("closed form", &x, &closed_form).without_markers());
    let mut errors = Vec::new();
    for (name, weight) in [("plain", 0.0), ("with the penalty", 0.05)] {
        let u = solve(weight)?;
        let mut values = Vec::new();
        for x in &x {
            values.push(u.evaluate(&[*x, 0.5])?[0]);
        }
        // Away from the layer, which four cells cover.
        let away = x.iter().zip(&values).filter(|(x, _)| **x <= 0.8);
        let error = away.map(|(x, u)| (u - exact(*x)).abs()).fold(0.0, f64::max);
        println!("{name:18} largest error for x ≤ 0.8: {error:.2e}");
        errors.push(error);
        plot = plot.curve(Curve::new(name, &x, &values).without_markers());
    }

    plot.write_png("out/08_ghost_penalty.png")?;

    assert!(errors[1] < 2e-2, "the stabilised solution is off by {}", errors[1]);
    assert!(errors[0] > 10.0 * errors[1], "the plain method is as good: {errors:?}");
    Ok(())
}
