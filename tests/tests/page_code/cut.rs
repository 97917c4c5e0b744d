//! `docs/cut_domains.md` and `docs/level_set_descent.md`.

use forms_contact::ContactProblem;
use forms_contact::laws::cut_nitsche;
use forms_fem::prelude::*;

pub fn measures() -> Result<(), Failure> {
    let mesh = rectangle([-1.0; 2], [1.0; 2], [32, 32], CellShape::Triangle, 1)?;
    let phi = Field::interpolate(&Space::scalar(&mesh, 1)?, |x| x[0].hypot(x[1]) - 0.7)?;
    let disc = Assembler::new(&mesh).cut_by(&phi)?;
    let area = form!(|| -> Functional { integral(cells("all"), 1) });
    let length = form!(|| -> Functional { integral(interface("all"), 1) });
    println!("{} {}", disc.functional(&area)?, disc.functional(&length)?);
    Ok(())
}

pub fn contact(mesh: Mesh<2>, phi: Field<2>, gap: Given<f64, 2>) -> Result<Vec<f64>, Failure> {
    let space = Space::vector(&mesh, 1)?;
    let (cut, islands) = Cut::by(&phi)?.without_islands(&["top"])?;
    let body = Assembler::new(&mesh).with_cut(&cut)?;
    let mut held = Constraints::new(&space);
    held.fix("top", |_| [0.0, -0.01])?;
    cut.hold_outside(&mut held)?;
    let data = cut_nitsche::data().lambda(1.0).mu(1.0).gamma0(30.0).obstacle_normal([0.0, -1.0]).gap(gap).theta(1.0);
    let regions = cut_nitsche::regions().gamma_c("all").gamma_d("all").gamma_n("right");
    let law = cut_nitsche::Model { data, regions };
    let problem = ContactProblem::new(&space, law, held).assembler(body);
    let u = problem.direct()?.solve()?.into_field();
    println!("{} parts hang on nothing", islands.len());
    let p = problem.state(problem.law.discrete_adjoint(&u), &u)?.solve()?.into_field();
    let gradient: Vec<f64> = problem.law.level_set_gradient(&problem.assembler, &u, &p)?;
    Ok(gradient)
}
