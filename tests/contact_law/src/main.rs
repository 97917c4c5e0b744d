//! The law in two and three dimensions from one source: a block pressed onto a flat and dragged over it.

mod tresca;

use std::error::Error;

use forms_contact::ContactProblem;
use forms_fem::prelude::*;
use forms_fem::verification;

use tresca::tresca as law;

/// The driver.
fn drag<const D: usize>(mesh: &Mesh<D>, slip_stress: f64) -> Result<Dragged<D>, Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let space = Space::vector(mesh, 1)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix("top", |_| along::<D>(0.4, -0.05))?;
    let (obstacle_normal, gap) = (Given::constant(along::<D>(0.0, -1.0)), Given::constant(0.0));
    let (lambda, mu, gamma0, theta) = (1.0, 1.0, 20.0, 0.0);
    let data = law::data().lambda(lambda).mu(mu).gamma0(gamma0).obstacle_normal(obstacle_normal).gap(gap).theta(theta).slip_stress(slip_stress);
    let model = law::Model { data, regions: law::Regions::default().gamma_c("bottom") };
    let problem = ContactProblem::new(&space, model, constraints);
    let solved = problem.direct()?.solve()?;
    Ok((problem, solved))
}

type Dragged<const D: usize> = (ContactProblem<D, law::Model<D>>, Solved<D>);

/// A vector along the flat and up from it.
fn along<const D: usize>(drag: f64, up: f64) -> [f64; D] {
    std::array::from_fn(|axis| {
        if axis == 0 {
            drag
        } else if axis == D - 1 {
            up
        } else {
            0.0
        }
    })
}

fn check<const D: usize>(mesh: Mesh<D>) -> Result<(), Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let slip_stress = 0.05;
    let (problem, solved) = drag(&mesh, slip_stress)?;
    // All of the unit face slides: the support at the top holds against the slip stress. In space the direction of slip
    // varies a little along the sides.
    let held = solved.reaction("top")?;
    let largest = if D == 2 { 1e-10 } else { 1e-3 * slip_stress };
    assert!(held[0] < slip_stress + 1e-10 && held[0] > slip_stress - largest, "{held:?}");
    assert!(held[D - 1] < -0.05, "it is pressed down: {held:?}");
    println!("{D}D: {} Newton steps, held by {held:?}", solved.iterations());

    // dJ/ds of J = 1/2 |u|^2 over the contact boundary, through the adjoint state.
    let u = solved.field();
    let p = problem.adjoint(u)?.solve()?.into_field();
    let slope = solved.functional(&problem.law.by_slip_stress(u, &p))?;
    let report = verification::taylor(0.01, &[slope], |step| {
        let (problem, solved) = drag(&mesh, slip_stress + step)?;
        Ok::<_, Box<dyn Error>>(problem.criterion(solved.field())?.into())
    })?;
    println!("{report}");
    report.second_order()?;

    // A parameter out of its range is named.
    let mut problem = problem;
    problem.law.data.gamma0 = -1.0;
    let error = problem.direct().err().map(|error| error.to_string()).unwrap_or_default();
    assert!(error.contains("gamma0") && error.contains("positive"), "{error}");
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    check(rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Quadrilateral, 1)?)?;
    check(cuboid([0.0; 3], [1.0; 3], [3; 3], CellShape::Hexahedron, 1)?)
}
