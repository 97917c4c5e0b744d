//! Estimates that are exact, a goal on the L-shaped membrane, and what ends a cycle of adaptivity.

use forms_fem::adaptivity::{Adaptation, AdaptationError, AdaptiveSolution, ErrorEstimate, EstimateError};
use forms_fem::mesh::OctreeMesh;
use forms_fem::prelude::*;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

#[forms]
mod membrane {
    pub struct Data {
        source: Given<Scalar>,
        weight: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[interior_facets]
    pub struct Interior;

    pub fn direct(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - source * v)
    }
    pub fn goal(u: State<Scalar>) -> Functional {
        integral(Omega, weight * u)
    }
    pub fn adjoint(u: State<Scalar>, p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
        derivative(direct(u, p), u, q) + derivative(goal(u), u, q)
    }
    pub fn localised(u: State<Scalar>, z: State<Scalar>, q: Test<Scalar>) -> Form {
        direct(u, q * z)
    }
}

fn held<const D: usize>(space: &Arc<Space<D>>, regions: &[&str]) -> Outcome<Constraints<D>> {
    let mut constraints = Constraints::new(space);
    constraints.join_hanging_nodes()?;
    for region in regions {
        constraints.fix(region, |_| 0.0)?;
    }
    Ok(constraints)
}

/// u_h of a degree with its goal and the estimate by an adjoint state of one degree more.
fn solve<const D: usize>(
    mesh: &Mesh<D>,
    data: membrane::Data<D>,
    degree: usize,
    regions: &[&str],
) -> Outcome<AdaptiveSolution<D>>
where
    Dim: Dimension<D>,
{
    let (space, higher) = (Space::scalar(mesh, degree)?, Space::scalar(mesh, degree + 1)?);
    let model = membrane::Model::new(data);
    let direct = model.direct();
    let solved = Problem::new(&direct, &space).constrained(&held(&space, regions)?).solve()?;
    let u = solved.field();
    let adjoint = model.adjoint(u);
    let p = Problem::new(&adjoint, &higher).homogeneous(&held(&higher, regions)?).solve()?.into_field();
    let localised = |z: &Field<D>| model.localised(u, z);
    let estimate = ErrorEstimate::dual_weighted(&Assembler::new(mesh), &p, &space, localised)?;
    let goal = solved.functional(&model.goal(u))?;
    Ok(AdaptiveSolution::new(u.clone(), estimate).with_goal(goal))
}

/// u = x(1 − x) between x = 0 and x = 1 lies in the space of the adjoint state: then J(u − u_h) = R(u_h; p) for the discrete p
/// of degree 2, to rounding. J = ∫ w u with w = x + 2y: ∫ x²(1−x) + (2·½) ∫ x(1−x) = 1/12 + 1/6.
fn estimate_is_exact<const D: usize>(mesh: Mesh<D>) -> Outcome<()>
where
    Dim: Dimension<D>,
{
    let data = membrane::data().source(2.0).weight(|x: &[f64; D]| x[0] + 2.0 * x[1]);
    let found = solve(&mesh, data, 1, &["left", "right"])?;
    let error = 0.25 - found.goal.expect("it was given");
    assert!(error > 1e-3);
    assert!((found.estimate.value() - error).abs() < 1e-11, "{} {error}", found.estimate.value());
    assert!(found.estimate.indicators().iter().sum::<f64>() >= error - 1e-11);
    Ok(())
}

/// Some cells divided, and some of their parts.
fn with_hanging_nodes<const D: usize>(mesh: Mesh<D>) -> Outcome<Mesh<D>> {
    let mesh = OctreeMesh::new(mesh)?.refined(&[1])?.0.refined(&[2, 3])?.0;
    Ok(Mesh::clone(mesh.mesh()))
}

#[test]
fn the_dual_weighted_estimate_is_exact_where_the_solution_lies_in_the_higher_space() -> Outcome<()> {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        estimate_is_exact(rectangle([0.0; 2], [1.0; 2], [4, 3], shape, 1)?)?;
    }
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        estimate_is_exact(cuboid([0.0; 3], [1.0; 3], [3, 2, 2], shape, 1)?)?;
    }
    // With hanging nodes: p less its interpolation is orthogonal to the residual where both are continuous.
    estimate_is_exact(with_hanging_nodes(rectangle(
        [0.0; 2],
        [1.0; 2],
        [4, 3],
        CellShape::Quadrilateral,
        1,
    )?)?)?;
    estimate_is_exact(with_hanging_nodes(cuboid([0.0; 3], [1.0; 3], [2, 2, 1], CellShape::Hexahedron, 1)?)?)?;
    Ok(())
}

/// (−1, 1)² without x > 0, y < 0.
fn l_shape(shape: CellShape) -> Outcome<Mesh<2>> {
    let nodes =
        [[-1.0, -1.0], [0.0, -1.0], [-1.0, 0.0], [0.0, 0.0], [1.0, 0.0], [-1.0, 1.0], [0.0, 1.0], [1.0, 1.0]];
    let squares: [[u32; 4]; 3] = [[0, 1, 3, 2], [2, 3, 6, 5], [3, 4, 7, 6]];
    let cells = match shape {
        CellShape::Triangle => squares.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect(),
        _ => squares.concat(),
    };
    Ok(Mesh::from_parts(shape, 1, nodes.to_vec(), cells)?.refined()?)
}

/// ∫u of −Δu = 1; `the_goal_by_a_higher_degree` computes it.
const L_SHAPE_GOAL: f64 = 0.214_075_80;

/// Degree 3 with the estimate added: the digits of the constant above.
#[test]
fn the_goal_by_a_higher_degree() -> Outcome<()> {
    let data = || membrane::data().source(1.0).weight(1.0);
    let on_mesh = |mesh: &Mesh<2>, _: Option<&Field<2>>| solve(mesh, data(), 3, &["boundary"]);
    let adapted = Adaptation::to_unknowns(6_000).run(l_shape(CellShape::Triangle)?, on_mesh, |_| ())?;
    let step = adapted.steps.last().expect("there are meshes");
    let goal = step.goal.expect("it was given") + step.estimate;
    assert!(step.estimate.abs() < 1e-7 && (goal - L_SHAPE_GOAL).abs() < 6e-9, "{goal:.12} {}", step.estimate);
    Ok(())
}

/// The estimate comes to J − J_h, and the error falls as 1/N though ∇u is infinite in the corner.
fn the_goal_on(shape: CellShape) -> Outcome<()> {
    let (count, least) = match std::env::var_os("FORMS_SWEEPS") {
        Some(_) => (20_000, 0.99),
        None => (2_500, 0.98),
    };
    let data = || membrane::data().source(1.0).weight(1.0);
    let on_mesh = |mesh: &Mesh<2>, _: Option<&Field<2>>| solve(mesh, data(), 1, &["boundary"]);
    let adapted = Adaptation::to_unknowns(count).run(l_shape(shape)?, on_mesh, |_| ())?;
    let errors: Vec<(f64, f64, f64)> = adapted
        .steps
        .iter()
        .map(|step| (step.unknowns as f64, L_SHAPE_GOAL - step.goal.unwrap_or(f64::NAN), step.estimate))
        .collect();
    let &(unknowns, error, estimate) = errors.last().expect("there are meshes");
    assert!((least..1.01).contains(&(estimate / error)), "{}", estimate / error);
    let &(before, larger, _) = errors.iter().rfind(|row| row.0 < unknowns / 8.0).expect("a coarser mesh");
    let order = (error / larger).ln() / (unknowns / before).ln();
    assert!((-1.1..-0.9).contains(&order), "{order}");
    // The cells in the corner are much smaller than the largest.
    let mesh = adapted.mesh.mesh();
    let diameters = || (0..mesh.cell_count()).map(|cell| mesh.diameter(cell));
    let smallest = (0..mesh.cell_count())
        .filter(|&cell| mesh.cell(cell).iter().any(|&node| mesh.nodes()[node as usize] == [0.0; 2]))
        .map(|cell| mesh.diameter(cell))
        .fold(f64::INFINITY, f64::min);
    assert!(smallest < 0.05 * diameters().fold(0.0, f64::max));
    assert!(diameters().all(|diameter| diameter >= 0.5 * smallest));
    Ok(())
}

#[test]
fn the_goal_on_the_l_shape() -> Outcome<()> {
    the_goal_on(CellShape::Triangle)
}

/// The same with hanging nodes.
#[test]
fn the_goal_on_the_l_shape_in_quadrilaterals() -> Outcome<()> {
    the_goal_on(CellShape::Quadrilateral)
}

/// The tolerance is kept by the true error, and a limit that is too low is an error that says so.
#[test]
fn a_tolerance_is_reached_or_the_limit_named() -> Outcome<()> {
    let data = || membrane::data().source(1.0).weight(1.0);
    let on_mesh = |mesh: &Mesh<2>, _: Option<&Field<2>>| solve(mesh, data(), 1, &["boundary"]);
    let cycle = Adaptation::to_tolerance(2e-3);
    let mut rows = 0;
    let adapted = cycle.clone().run(l_shape(CellShape::Triangle)?, on_mesh, |_| rows += 1)?;
    assert_eq!(rows, adapted.steps.len());
    assert!(rows > 2);
    let error = L_SHAPE_GOAL - adapted.solution.goal.expect("it was given");
    assert!(error.abs() < 1.1 * 2e-3, "{error}");
    let refused = cycle.with_at_most(40).run(l_shape(CellShape::Triangle)?, on_mesh, |_| ());
    match refused {
        Err(AdaptationError::TooManyUnknowns { unknowns, most: 40, tolerance, .. }) => {
            assert!(unknowns > 40 && (tolerance - 2e-3).abs() < 1e-15);
        }
        other => panic!("{other:?}"),
    }
    Ok(())
}

#[test]
fn what_does_not_fit_is_named() -> Outcome<()> {
    let mesh = l_shape(CellShape::Triangle)?;
    let squares = ErrorEstimate::of_squares(&[1.0, 4.0, -1.0]).map_err(|error| error.to_string());
    assert_eq!(squares, Err("the square of the indicator of cell 2 is -1".to_owned()));
    assert_eq!(ErrorEstimate::of_squares(&[9.0, 16.0])?.value(), 5.0);
    // Each over its sum, whatever their units; what has no error marks nothing.
    let (both, zeros) = (ErrorEstimate::of_squares(&[9.0, 27.0])?, ErrorEstimate::of_squares(&[0.0; 2])?);
    let both = both.marking_also_by(&ErrorEstimate::of_squares(&[1e-9, 1e-9])?)?;
    assert_eq!((both.value(), both.indicators()), (6.0, &[0.75, 1.25][..]));
    assert_eq!(both.clone().marking_also_by(&zeros)?.indicators(), [0.375, 0.625]);
    let apart = both.marking_also_by(&ErrorEstimate::of_squares(&[1.0; 3])?);
    assert_eq!(apart, Err(EstimateError::Cells { cells: 2, others: 3 }));
    let (linear, quadratic) = (Space::scalar(&mesh, 1)?, Space::scalar(&mesh, 2)?);
    let model = membrane::Model::new(membrane::data().source(1.0).weight(1.0));
    let (assembler, u) = (Assembler::new(&mesh), Field::zero(&linear));
    let of = |p: &Field<2>, space: &Arc<Space<2>>| {
        ErrorEstimate::dual_weighted(&assembler, p, space, |z| model.localised(&u, z))
    };
    assert_eq!(of(&u, &linear), Err(EstimateError::Degree { adjoint: 1, primal: 1 }));
    let elsewhere = Space::scalar(&l_shape(CellShape::Triangle)?, 1)?;
    assert!(matches!(of(&Field::zero(&quadratic), &elsewhere), Err(EstimateError::Space(_))));

    let zeros = |mesh: &Mesh<2>| -> Outcome<AdaptiveSolution<2>> {
        let estimate = ErrorEstimate::of_squares(&vec![0.0; mesh.cell_count()])?;
        Ok(AdaptiveSolution::new(Field::zero(&Space::scalar(mesh, 1)?), estimate))
    };
    let stopped = Adaptation::to_unknowns(1_000).run(mesh.clone(), |mesh, _| zeros(mesh), |_| ());
    assert!(matches!(stopped, Err(AdaptationError::NothingToMark { number: 0 })));
    let other =
        Adaptation::to_unknowns(1_000).run(mesh.clone(), |_, _| zeros(&elsewhere.mesh().clone()), |_| ());
    assert!(matches!(other, Err(AdaptationError::OtherMesh { number: 0, .. })));
    let failed = Adaptation::to_unknowns(1).run(mesh, |_, _| Err("no bread"), |_| ());
    let message = failed.map(|_| ()).map_err(|error: AdaptationError<&str>| error.to_string());
    assert_eq!(message, Err("mesh 0 of 24 cells: no bread".to_owned()));
    assert!(matches!(
        Adaptation::to_tolerance(0.0).run(l_shape(CellShape::Triangle)?, |mesh, _| zeros(mesh), |_| ()),
        Err(AdaptationError::Tolerance { .. })
    ));
    Ok(())
}
