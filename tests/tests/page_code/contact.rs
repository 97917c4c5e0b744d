//! `docs/contact_between_bodies.md`, `docs/points_segments_means.md`, `docs/friction.md` and `docs/new_contact_law.md`.

use forms_contact::laws::sliding_bodies;
use forms_contact::ContactProblem;
use forms_fem::constraints::RigidMap;
use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::RigidSurface;
use forms_fem::pairs::Approach;
use forms_fem::prelude::*;

use super::tresca::tresca;

type Sliding = ContactProblem<2, sliding_bodies::Model<2>>;

pub fn materials(
    mesh: &Mesh<3>,
    height: f64,
    (soft, stiff): (f64, f64),
    (mu, gamma0): (Field<3>, Field<3>),
) -> Result<sliding_bodies::Data<3>, Failure> {
    let cells = Space::discontinuous_scalar(&mesh, 0)?;
    let lambda = Field::interpolate(&cells, |x| if x[2] < height { soft } else { stiff })?;
    let data = sliding_bodies::data().lambda(&lambda);
    Ok(data.mu(&mu).gamma0(&gamma0).share(1.0))
}

pub fn segments() -> Pairing {
    let touch = Pairing::between("slab top", "block bottom").at(PairQuadrature::Pieces);
    touch
}

pub fn first_touch(
    assembler: &Assembler<2>,
    space: &Arc<Space<2>>,
    (pairing, problem): (Pairing, Sliding),
) -> Result<Field<2>, Failure> {
    let down = Approach { moving: "punch".to_owned(), direction: [0.0, -1.0], overlap: 1e-3 };
    let touch = assembler.first_touch(&pairing, 4, &Field::zero(&space), &down)?;
    let solved = problem.direct()?.start(&touch.start).solve()?;
    Ok(solved.into_field())
}

pub fn steps(
    space: &Arc<Space<2>>,
    problem: impl Fn(f64, &Field<2>) -> Result<Sliding, Failure>,
) -> Result<Field<2>, Failure> {
    let path = LoadSteps::uniform(10, 0.6).advance(Field::zero(&space), |step| {
        let solved = problem(step.factor, step.before)?.direct()?.increment(step).solve()?;
        Ok::<_, Failure>(solved.into_field())
    })?;
    Ok(path.state)
}

pub fn tools(
    block: &Mesh<3>,
    constraints: &mut Constraints<3>,
    solved: Solved<3>,
) -> Result<(Mesh<3>, Pairing, f64), Failure> {
    let mesh = block.with_rigid_surfaces(&[("punch", &RigidSurface::from_stl_file("punch.stl")?)])?;
    let down = RigidMap::translation([0.0, 0.0, -0.2]);
    constraints.move_rigidly("punch", &RigidMap::<3>::turn([0.0, 0.0, 0.1], [0.0; 3]).then(&down))?;
    let touch = Pairing::onto("block top", "punch");
    let (force, moment) = (solved.reaction("punch")?, solved.reaction_moment("punch", [0.0; 3])?);
    Ok((mesh, touch, force[2] + moment[2]))
}

pub fn two_steps_with_friction(
    space: &Arc<Space<2>>,
    contact_data: forms_contact::nitsche::Data<2>,
    (regions, constraints): (forms_contact::laws::frictional_nitsche::Regions, Constraints<2>),
) -> Result<(), Failure> {
    use forms_contact::laws::frictional_nitsche as law;

    let data = law::data_from(contact_data).friction(0.3);
    let problem = ContactProblem::new(&space, law::Model { data, regions }, constraints);
    let mut problem = problem.quadrature(Quadrature::Degree(6));
    let u = problem.from_stick()?.solve()?.into_field();
    problem.law.data.displacement_before = Given::field(&u);
    Ok(())
}

pub fn press(space: Arc<Space<2>>, constraints: Constraints<2>) -> Result<[Field<2>; 2], Failure> {
    let data = tresca::data().lambda(1.0).mu(1.0).gamma0(20.0).obstacle_normal([0.0, -1.0]);
    let data = data.gap(0.0).theta(0.0).slip_stress(0.05);
    let model = tresca::Model { data, regions: tresca::Regions::default().gamma_c("bottom") };
    let problem = ContactProblem::new(&space, model, constraints);
    let u = problem.direct()?.solve()?.into_field();
    let p = problem.adjoint(&u)?.solve()?.into_field();
    Ok([u, p])
}
