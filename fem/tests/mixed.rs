//! Several unknowns with their own spaces in one form: Taylor–Hood elements for Stokes flow.

use forms_fem::assemble::BlockPattern;
use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::prelude::*;
use forms_fem::solve::{NewtonFailure, SolverError};

#[forms]
mod stokes {
    pub struct Data {
        viscosity: Param,
        force: Given<Vector>,
        inertia: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn flow(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * viscosity * inner(eps(u), eps(v)) - p * div(v) - q * div(u) - dot(force, v))
    }

    pub fn navier(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        flow(u, p, v, q) + integral(Omega, inertia * dot(grad(u) * u, v))
    }
}

const VISCOSITY: f64 = 0.7;

type Exact = Box<dyn Fn(&[f64; 2], &mut [f64]) + Send + Sync>;

fn data(force: Given<[f64; 2], 2>, inertia: f64) -> stokes::Data<2> {
    stokes::data().viscosity(VISCOSITY).force(force).inertia(inertia)
}

#[test]
fn taylor_hood_elements_hold_poiseuille_flow_exactly() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = rectangle([0.0, 0.0], [2.0, 1.0], [4, 3], shape, 1).unwrap();
        let (velocities, pressures) = (Space::vector(&mesh, 2).unwrap(), Space::scalar(&mesh, 1).unwrap());
        // u = (y(1 − y), 0), p = 2ν (2 − x); the inertia of this flow vanishes.
        let profile = |x: &[f64; 2]| [x[1] * (1.0 - x[1]), 0.0];
        let pressure = |x: &[f64; 2]| 2.0 * VISCOSITY * (2.0 - x[0]);
        let assembler = Assembler::new(&mesh);
        let (u, p) = (Field::zero(&velocities), Field::zero(&pressures));
        let mut walls = Constraints::new(&velocities);
        walls.fix("boundary", profile).unwrap();
        let mut level = Constraints::new(&pressures);
        level.fix_nearest(&[0.0, 0.0], pressure(&[0.0, 0.0])).unwrap();

        let form = stokes::flow(&data(Given::constant([0.0; 2]), 0.0), &stokes::Omega::on("all"));
        let matrix = assembler.tangent(&form, &[&u, &p], &[&velocities, &pressures]).unwrap();
        assert!(matrix.is_symmetric(1e-14).unwrap());
        let problem = Problem::new(&form, [&velocities, &pressures]).assembler(&assembler);
        let mut solver = TangentSolver::default();
        let solution =
            problem.constrained(&walls).constrained(&level).solver(&mut solver).solve().unwrap().fields;
        let report = solver.report();
        assert_eq!((report.signed_factorisations, report.lu_factorisations), (1, 0));
        assert_eq!(report.negative_eigenvalues, Some(level.free().len()));

        let form = stokes::navier(&data(Given::constant([0.0; 2]), 3.0), &stokes::Omega::on("all"));
        let problem = Problem::new(&form, [&velocities, &pressures]).assembler(&assembler);
        let options = NewtonOptions::default();
        let solved = problem
            .start([&u, &p])
            .constrained(&walls)
            .constrained(&level)
            .solver(&mut solver)
            .options(options.clone())
            .solve()
            .unwrap();
        assert!(solved.history.len() <= 7, "{:?}", solved.history);

        for fields in [&solution, &solved.fields] {
            for (value, exact) in fields[0].values().chunks(2).zip(velocities.positions().iter().map(profile))
            {
                assert!((value[0] - exact[0]).abs() < 1e-11 && (value[1] - exact[1]).abs() < 1e-11);
            }
            for (value, exact) in fields[1].values().iter().zip(pressures.positions().iter().map(pressure)) {
                assert!((value - exact).abs() < 1e-10, "{value} against {exact}");
            }
        }
    }
}

// Orders 3 and 2 in L² for velocity and pressure.
#[test]
fn taylor_hood_elements_converge() {
    let mut errors = Vec::new();
    for cells in [8, 16] {
        let mesh = rectangle([0.0; 2], [1.0; 2], [cells, cells], CellShape::Triangle, 1).unwrap();
        let (velocities, pressures) = (Space::vector(&mesh, 2).unwrap(), Space::scalar(&mesh, 1).unwrap());
        // u = curl of sin(πx) sin(πy), p = sin(πx) cos(πy) with f = −ν Δu + ∇p.
        const PI: f64 = std::f64::consts::PI;
        let u = |x: &[f64; 2]| {
            let (s, t) = (PI * x[0], PI * x[1]);
            [PI * s.sin() * t.cos(), -PI * s.cos() * t.sin()]
        };
        let force = move |x: &[f64; 2]| {
            let (s, t) = (PI * x[0], PI * x[1]);
            let viscous = 2.0 * PI * PI * VISCOSITY;
            let [a, b] = u(x);
            [viscous * a + PI * s.cos() * t.cos(), viscous * b - PI * s.sin() * t.sin()]
        };
        let form = stokes::flow(&data(Given::function(force), 0.0), &stokes::Omega::on("all"));
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(6));
        let mut walls = Constraints::new(&velocities);
        walls.fix("boundary", u).unwrap();
        let mut level = Constraints::new(&pressures);
        level.fix_nearest(&[0.0, 0.0], 0.0).unwrap();
        let problem = Problem::new(&form, [&velocities, &pressures]).assembler(&assembler);
        let [velocity, pressure] = problem.constrained(&walls).constrained(&level).solve().unwrap().fields;
        let l2 = |field: &Field<2>, exact: Exact| {
            let no_slope = |_: &[f64; 2], slope: &mut [f64]| slope.fill(0.0);
            norms::errors(&assembler, field, exact, no_slope).unwrap().l2
        };
        // The pinned node moves the level by its own error: compared are pressures of equal mean.
        let exact = |x: &[f64; 2]| (PI * x[0]).sin() * (PI * x[1]).cos();
        let interpolated = Field::interpolate(&pressures, exact).unwrap();
        let mean = |field: &Field<2>| norms::mean(&assembler, field).unwrap()[0];
        let shift = mean(&pressure) - mean(&interpolated);
        let values = pressure.values().iter().map(|value| value - shift).collect();
        let pressure = Field::from_values(&pressures, values).unwrap();
        errors.push([
            l2(&velocity, Box::new(move |x, out| out.copy_from_slice(&u(x)))),
            l2(&pressure, Box::new(move |x, out| out[0] = exact(x))),
        ]);
    }
    let orders: Vec<f64> = errors[0].iter().zip(errors[1]).map(|(a, b)| (a / b).log2()).collect();
    assert!(orders[0] > 2.8 && orders[1] > 1.9, "orders {orders:?}, errors {errors:?}");
}

#[test]
fn what_no_integral_couples_is_not_stored() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [3, 3], CellShape::Triangle, 1).unwrap();
    let spaces = [&Space::vector(&mesh, 2).unwrap(), &Space::scalar(&mesh, 1).unwrap()];
    let form = stokes::flow(&data(Given::constant([0.0; 2]), 0.0), &stokes::Omega::on("all"));
    let (lean, full) = (
        BlockPattern::for_form(&form, &spaces, &spaces).unwrap(),
        BlockPattern::new(&spaces, &spaces).unwrap(),
    );
    let offset = lean.row_offset(1);
    for row in 0..lean.pattern().rows() {
        let kept: Vec<u32> = full.pattern().row(row).to_vec();
        let expected: Vec<u32> =
            kept.into_iter().filter(|&column| row < offset || (column as usize) < offset).collect();
        assert_eq!(lean.pattern().row(row), expected);
    }
    assert!(lean.pattern().is_symmetric());
    let zero = spaces.map(Field::zero);
    let zero = zero.each_ref();
    let matrix = Assembler::new(&mesh).tangent(&form, &zero, &spaces).unwrap();
    assert_eq!(**matrix.pattern(), **lean.pattern());
}

#[test]
fn a_pattern_of_another_form_is_an_error() {
    let mut mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1).unwrap();
    mesh.name_cells("part", |centre| centre[0] < 0.5).unwrap();
    let spaces = [&Space::vector(&mesh, 1).unwrap(), &Space::scalar(&mesh, 1).unwrap()];
    let assembler = Assembler::new(&mesh);
    let data = data(Given::constant([0.0; 2]), 0.0);
    let small = stokes::flow(&data, &stokes::Omega::on("part"));
    let pattern = BlockPattern::for_form(&small, &spaces, &spaces).unwrap();
    let form = stokes::flow(&data, &stokes::Omega::on("all"));
    let mut matrix = BlockMatrix::zero(pattern.sparsity());
    let zero = spaces.map(Field::zero);
    let error = assembler
        .add_tangent(&form, &zero.each_ref(), &spaces, Parts::ALL, &pattern, &mut matrix)
        .unwrap_err();
    assert_eq!(error.to_string(), "form `flow` couples `v` with `u` where the matrix pattern has no entries");
    // A pattern of other spaces.
    let others = [&Space::vector(&mesh, 2).unwrap(), spaces[1]];
    let pattern = BlockPattern::for_form(&form, &others, &others).unwrap();
    let error = assembler
        .add_tangent(&form, &zero.each_ref(), &spaces, Parts::ALL, &pattern, &mut matrix)
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "form `flow`: the positions of the matrix given for `v` belong to another space"
    );
}

#[test]
fn an_undetermined_pressure_is_named() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [6, 6], CellShape::Triangle, 1).unwrap();
    let (velocities, pressures) = (Space::vector(&mesh, 2).unwrap(), Space::scalar(&mesh, 1).unwrap());
    let form = stokes::flow(&data(Given::constant([1.0, 0.0]), 0.0), &stokes::Omega::on("all"));
    let mut walls = Constraints::new(&velocities);
    walls.fix("boundary", |_| [0.0, 0.0]).unwrap();
    let problem = || Problem::new(&form, [&velocities, &pressures]);
    let error = problem().constrained(&walls).solve().unwrap_err();
    assert!(
        matches!(
            &error.why,
            NewtonFailure::LinearSolver(SolverError::Undetermined { field: "p", component: None, .. })
        ),
        "{error}"
    );
    // Without any boundary condition the velocity is not determined either.
    let message = problem().solve().unwrap_err().to_string();
    assert!(message.contains("the matrix is singular: nothing determines component"), "{message}");

    let error = problem().constrained(&walls).constrained(&walls).solve();
    assert_eq!(
        error.map(|_| ()).unwrap_err().to_string(),
        "the problem was not solved: assembly failed: form `flow`: constraints were given for a space on which no unknown \
         is left without"
    );
}
