//! −Δu + u = f on the unit square with u = cos πx as its solution, and no other dependency than forms-fem.

use forms_fem::prelude::*;

#[forms]
mod reaction {
    pub struct Data {
        pub rate: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn equation(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let load = (PI * PI + rate) * cos(PI * x[0]);
        integral(Omega, dot(grad(u), grad(v)) + rate * u * v - load * v)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [16, 2], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 2)?;
    let form = reaction::Model::<2>::new(reaction::data().rate(1.0)).equation();
    let u = Problem::new(&form, &space).solve()?.into_field();
    let end = u.evaluate(&[0.0, 0.5])?[0];
    assert!((end - 1.0).abs() < 1e-4, "u(0) = {end}, the exact solution has 1");
    println!("u(0) = {end}");
    Ok(())
}
