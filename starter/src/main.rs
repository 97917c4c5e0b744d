//! Heat in a plate whose conductivity k(T) = 1 + c T grows with temperature: a form, Newton's method, a picture.

use forms_fem::output::picture::{FieldMap, Picture, Shown};
use forms_fem::prelude::*;

/// The physics. Change it: the tangent, the kernels and the quadrature degree follow.
#[forms]
pub mod heat {
    pub struct Data {
        /// Growth of the conductivity with temperature.
        pub growth: Param,
        /// Heat source per volume; a constant, a function of position, or a field.
        pub source: Given<Scalar>,
    }

    #[cells]
    pub struct Plate;

    fn conductivity(t: Scalar) -> Scalar {
        1 + growth * t
    }

    /// The heat flux, to be evaluated once the temperature is known.
    pub fn flux(t: State<Scalar>) -> Vector {
        -conductivity(t) * grad(t)
    }

    pub fn balance(t: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Plate, conductivity(t) * dot(grad(t), grad(v)) - source * v)
    }
}

fn main() -> Result<(), Failure> {
    // Hot at the left, cold at the right, insulated below and above.
    let mesh = rectangle([0.0, 0.0], [2.0, 1.0], [32, 16], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 2)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix("left", |_| 1.0)?;
    constraints.fix("right", |_| 0.0)?;

    let model = heat::Model::new(heat::data().growth(2.0).source(0.0));
    let solved = Problem::new(&model.balance(), &space)
        .constrained(&constraints)
        .each_step(|step| println!("Newton step {}: residual {:.2e}", step.iteration, step.residual))
        .solve()?;

    let flux = solved.at_points(&model.flux(solved.field()), &[[1.0, 0.5]])?;
    println!("heat flux in the middle: {:?}", flux.values[0]);

    // Kirchhoff: T + T²/2 · c falls linearly from left to right, so the flux is (1 + c/2)/2 everywhere.
    let exact = (1.0 + model.data.growth / 2.0) / 2.0;
    assert!((flux.values[0][0] - exact).abs() < 1e-3 * exact, "the flux is {:?}", flux.values[0]);

    FieldMap::of(solved.field(), Shown::Component(0), "T").write_png("out/temperature.png")?;
    println!("picture: out/temperature.png");
    Ok(())
}
