//! Split facets in space: (14) on a block of tetrahedra of degree 1, whose β_h is affine on each facet, so that the split is
//! exact. A residual that follows the split is differentiable where facets are partly in contact, and its tangent has no
//! term of the moving cut.

use forms_contact::forms;
use forms_contact::{Adjoint, ContactProblem};
use forms_fem::prelude::*;
use forms_fem::verification::{Sample, taylor};

const TOTAL: f64 = -3.0;

/// A block above an obstacle that is tilted against its faces' edges, pressed down by its upper face.
fn block(theta: f64) -> ContactProblem<3> {
    let mut mesh = cuboid([0.0; 3], [1.0, 1.0, 0.6], [3, 3, 2], CellShape::Tetrahedron, 1).unwrap();
    mesh.name_cells_of_facets("contact cells", "bottom").unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix_component("left", 0, |_| 0.0).unwrap();
    constraints.fix_component("front", 1, |_| 0.0).unwrap();
    let data = forms::data()
        .lambda(57.0)
        .mu(38.0)
        .gamma0(4000.0)
        .obstacle_normal([0.0, 0.0, -1.0])
        .gap(|x: &[f64; 3]| x[2] + 0.031 * x[0] + 0.047 * x[1] - 0.02)
        .theta(theta)
        .traction([0.0, 0.0, TOTAL])
        .criterion_force([0.0, 0.0, -1.0]);
    ContactProblem::new(
        &space,
        forms::Model { data, regions: forms::Regions::default().gamma_n("top").gamma_c("bottom") },
        constraints,
    )
    .quadrature(Quadrature::Degree(2))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The residual at u + t v, each with its own split, against the tangent at u.
#[test]
fn the_residual_is_differentiable_where_facets_are_partly_in_contact() {
    for theta in [-1.0, 0.0, 1.0] {
        let whole = block(theta);
        let split = whole.clone().with_split_facets();
        let space = &whole.space;
        let u = Field::interpolate(space, |x| [0.01 * x[1], 0.0, -0.02 - 0.02 * x[0] * x[1]]).unwrap();
        let v = Field::interpolate(space, |x| [x[2], (3.0 * x[0]).sin(), (5.0 * x[1] + x[0]).cos()]).unwrap();
        let residual = |problem: &ContactProblem<3>, u: &Field<3>| {
            let assembler = problem.assembler_at(u).unwrap();
            assembler.residual(&problem.law.direct(), &[u], &[space]).unwrap()
        };
        let test = |problem: &ContactProblem<3>| {
            let derivative = problem
                .assembler_at(&u)
                .unwrap()
                .action(&problem.law.direct(), &[&u], &[&v], &[space])
                .unwrap();
            taylor(1e-2, &derivative, |t| {
                let value = residual(problem, &Field::combination(&[(1.0, &u), (t, &v)]).unwrap());
                Ok::<_, AssemblyError>(Sample { value, active_set: None })
            })
            .unwrap()
        };
        let order = test(&split).second_order().unwrap_or_else(|failure| panic!("θ = {theta}: {failure}"));
        // With whole facets points jump in and out of contact. The test has to notice that.
        let jumps = test(&whole).second_order();
        println!("θ = {theta}: order {order:.3} with split facets");
        assert!(jumps.is_err(), "θ = {theta}: no facet is partly in contact");
    }
}

#[test]
fn newtons_method_and_the_adjoint_follow_the_split() {
    for theta in [-1.0, 0.0, 1.0] {
        let problem = block(theta).with_split_facets();
        let mut solver = TangentSolver::default();
        let options = NewtonOptions { relative_tolerance: 1e-11, ..NewtonOptions::default() };
        let solved = problem.direct().unwrap().solver(&mut solver).options(options.clone()).solve().unwrap();
        let u = solved.field().clone();
        let steps = solved.history.len();
        assert!(steps <= 15, "θ = {theta}: {steps} steps");
        assert!(solved.history.iter().all(|step| step.active_points.is_none()));
        // What presses from below holds what presses from above.
        let assembler = problem.assembler_at(&u).unwrap();
        let gamma_c = &problem.law.regions.gamma_c;
        let force = assembler.functional(&forms::contact_force(&problem.law.data, gamma_c, &u)).unwrap();
        assert!((force + TOTAL).abs() < 1e-9, "θ = {theta}: {force}");
        // The derivative of ∫F·u by the height of the obstacle, by (21) and by differences.
        let lifted = |height: f64| {
            let mut lifted = problem.clone();
            lifted.law.data.gap =
                Given::function(move |x: &[f64; 3]| x[2] + 0.031 * x[0] + 0.047 * x[1] - 0.02 - height);
            lifted
        };
        let criterion = |problem: &ContactProblem<3>| {
            let solved = problem
                .direct()
                .unwrap()
                .solver(&mut TangentSolver::default())
                .options(options.clone())
                .solve()
                .unwrap();
            let (regions, u) = (&problem.law.regions, solved.into_field());
            let form = forms::criterion(&problem.law.data, &regions.omega, &regions.boundary, &u);
            problem.assembler.functional(&form).unwrap()
        };
        let p = problem.solve_adjoint(Adjoint::Discrete, &u, &mut solver).unwrap().into_field();
        let residual = |height: f64| {
            let lifted = lifted(height);
            let assembler = lifted.assembler_at(&u).unwrap();
            assembler.residual(&lifted.law.direct(), &[&u], &[&lifted.space]).unwrap()
        };
        // Small compared with the depths, of about 1e-3, by which facets sink in.
        let step = 1e-7;
        let slope: Vec<f64> =
            residual(step).iter().zip(residual(-step)).map(|(a, b)| (a - b) / (2.0 * step)).collect();
        let found = dot(&slope, p.values());
        let height = 1e-4;
        let expected = (criterion(&lifted(height)) - criterion(&lifted(-height))) / (2.0 * height);
        // The body is lifted as a whole: minus its volume.
        assert!((expected + 0.6).abs() < 1e-9, "θ = {theta}: {expected}");
        println!("θ = {theta}: {steps} steps, dJ {found:.8e}, differences {expected:.8e}");
        assert!((found - expected).abs() < 1e-7 * expected.abs(), "θ = {theta}: {found} and {expected}");
    }
}
