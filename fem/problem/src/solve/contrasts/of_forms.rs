//! Forms whose coefficients differ between cells and between fields by many orders: each part is solved, or refused.

use super::*;

#[forms(dimension = 2)]
mod transport {
    pub struct Data {
        /// Stiffness of the first field.
        stiffness: Given<Scalar>,
        /// Speed, in the unit of the stiffness.
        drift: Given<Scalar>,
        /// Unit of the second field's equation.
        unit: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn fields(u: Unknown<Scalar>, w: Unknown<Scalar>, v: Test<Scalar>, q: Test<Scalar>) -> Form {
        integral(Omega, stiffness * dot(grad(u), grad(v)) + drift * grad(u)[0] * v - v)
            + integral(Omega, unit * (dot(grad(w), grad(q)) + 5 * grad(w)[0] * q - q))
    }
}

/// Gives up on one of two fields, and says so.
#[derive(Default)]
struct HalfDone(LuSolver);

impl LinearSolver for HalfDone {
    fn set_matrix(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        self.0.set_matrix(matrix)
    }

    fn solve_with(
        &mut self,
        b: &[f64],
        tolerance: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        let mut found = self.0.solve_with(b, tolerance, transpose)?;
        let half = b.len() / 2;
        found.solution[half..].fill(0.0);
        Ok(LinearSolution { relative_residual: 0.81, ..found })
    }
}

#[test]
fn forms_with_contrasts_between_cells_and_fields_are_solved_in_each() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [8, 8], CellShape::Triangle, 1).unwrap();
    let space = Space::scalar(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh);
    let mut held = Constraints::new(&space);
    held.fix("boundary", |_| 0.0).unwrap();
    let solve = |contrast: f64, unit: f64, solver: &mut dyn LinearSolver| {
        let data = transport::data()
            .stiffness(move |x: &[f64; 2]| if x[0] < 0.5 { contrast } else { 1.0 })
            .drift(|x: &[f64; 2]| if x[0] < 0.5 { 0.0 } else { 20.0 })
            .unit(unit);
        let form = transport::fields(&data, &transport::Omega::on("all"));
        let problem = Problem::new(&form, [&space, &space]).assembler(&assembler);
        problem
            .constrained(&held)
            .constrained(&held)
            .solver(solver)
            .solve()
            .map(|solved| solved.fields.map(|field| field.values().to_vec()))
    };
    for (contrast, unit) in
        [(1e12, 1.0), (1.0, 1e-16), (2e11, 1e-9), (1e-12, 2e11), (1e16, 1e16), (1e-16, 1.0)]
    {
        let [u, _] = solve(contrast, 1.0, &mut LuSolver::default()).unwrap();
        let [_, w] = solve(1.0, 1.0, &mut LuSolver::default()).unwrap();
        let soft = |values: &[f64], soft: bool| -> Vec<f64> {
            let of_side = values.iter().zip(space.positions()).filter(|(_, x)| (x[0] > 0.5) == soft);
            of_side.map(|(value, _)| *value).collect()
        };
        for (name, mut solver) in solvers() {
            let [found, beside] = solve(contrast, unit, &mut *solver).unwrap();
            let errors = [
                error(&soft(&found, true), &soft(&u, true)),
                error(&soft(&found, false), &soft(&u, false)),
                error(&beside, &w),
            ];
            assert!(errors.iter().all(|error| *error < 1e-9), "{name}, {contrast:e}, {unit:e}: {errors:?}");
        }
    }
    // Whatever solver it is that leaves an equation aside, the problem sees it, and names the field.
    let failed = solve(1.0, 1e-9, &mut HalfDone::default()).map(|_| ()).unwrap_err();
    assert!(
        matches!(&failed.why, NewtonFailure::LinearSolver(SolverError::Inaccurate { field: "w", .. })),
        "{failed}"
    );
}

#[forms(dimension = 3)]
mod heat {
    pub struct Data {
        conductivity: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn flow(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, conductivity * dot(grad(u), grad(v)) - v)
    }
}

#[test]
fn multigrid_is_right_in_each_half_or_refuses() {
    let mesh = cuboid([0.0; 3], [1.0; 3], [6; 3], CellShape::Tetrahedron, 1).unwrap();
    let space = Space::scalar(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh);
    let mut held = Constraints::new(&space);
    held.fix("boundary", |_| 0.0).unwrap();
    for contrast in CONTRASTS {
        let conductivity = Given::function(move |x: &[f64; 3]| if x[0] < 0.5 { contrast } else { 1.0 });
        let form = heat::flow(&heat::data().conductivity(conductivity), &heat::Omega::on("all"));
        let solve = |solver: &mut dyn LinearSolver| {
            let problem = Problem::new(&form, &space).assembler(&assembler);
            problem.constrained(&held).solver(solver).solve().map(|solved| solved.field().values().to_vec())
        };
        let options = MultigridSolverOptions {
            tolerance: 1e-13,
            multigrid: MultigridOptions { direct_size: 30, ..MultigridOptions::default() },
            ..MultigridSolverOptions::default()
        };
        let found = solve(&mut MultigridSolver::new(&held, options).unwrap());
        let exact = solve(&mut LuSolver::default()).unwrap();
        let found = match found {
            Ok(found) => found,
            Err(error) => {
                println!("contrast {contrast:e}: {error}");
                assert!(!(1e-4..=1e4).contains(&contrast), "{error}");
                continue;
            }
        };
        for soft in [false, true] {
            let part = |values: &[f64]| -> Vec<f64> {
                let of_side = values.iter().zip(space.positions()).filter(|(_, x)| (x[0] > 0.5) == soft);
                of_side.map(|(value, _)| *value).collect()
            };
            let error = error(&part(&found), &part(&exact));
            assert!(error < 1e-9, "contrast {contrast:e}, soft {soft}: off by {error:e}");
        }
    }
}
