//! Tutorial 1: Poisson's equation, `−Δu = 1` on the unit square with u = 0 on its boundary.
//!
//! u is the deflection of a soap film under pressure, or the stress function of a square bar in torsion.
//! Its value at the centre is known as a series, so the program can check itself.
//!
//! Run it with `cargo run --release --bin 01_poisson`.

use std::f64::consts::PI;

use forms_fem::output::picture::{FieldMap, Picture, Shown};
use forms_fem::prelude::*;

// A module under `#[forms]` holds the physics and nothing else. Data are what the program passes in;
// a region is a set of cells or facets that the mesh knows by name; a form is an ordinary function.
#[forms]
mod poisson {
    pub struct Data {
        /// Load per area.
        pub load: Given<Scalar>,
    }

    #[cells]
    pub struct Omega;

    /// ∫ ∇u·∇v − ∫ f v. A form is always the whole residual: it contains the load with its sign.
    pub fn residual(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - load * v)
    }
}

/// u at the centre: 1/8 − 4/π³ Σ (−1)^((n−1)/2) / (n³ cosh(nπ/2)) over odd n. Five terms are exact to rounding.
fn exact_centre() -> f64 {
    let term = |k: i32| {
        let n = f64::from(2 * k + 1);
        (-1.0_f64).powi(k) / (n.powi(3) * (n * PI / 2.0).cosh())
    };
    0.125 - 4.0 / PI.powi(3) * (0..8).map(term).sum::<f64>()
}

fn main() -> Result<(), Failure> {
    // Mesh, space, boundary condition.
    let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [16, 16], CellShape::Triangle, 1)?;
    let space = Space::scalar(&mesh, 2)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix("boundary", |_| 0.0)?;

    // The module with its data. Its regions go by their own names in the mesh, a single one of cells is all of it.
    let model = poisson::Model::new(poisson::data().load(1.0));
    // The compiler has proved that the form is linear in u and symmetric: one assembly, one Cholesky
    // factor. The quadrature degree is its estimate.
    let u = Problem::new(&model.residual(), &space).constrained(&constraints).solve()?.into_field();

    let (centre, exact) = (u.evaluate(&[0.5, 0.5])?[0], exact_centre());
    println!("unknowns          {}", space.unknowns());
    println!("u at the centre   {centre:.8}");
    println!("series            {exact:.8}");

    FieldMap::of(&u, Shown::Component(0), "u").levels(12).without_axes().write_png("out/01_poisson.png")?;
    println!("picture           out/01_poisson.png");

    assert!((centre - exact).abs() < 1e-5 * exact, "u at the centre is {centre}, the series gives {exact}");
    Ok(())
}
