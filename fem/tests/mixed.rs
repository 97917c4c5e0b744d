//! Several unknowns with their own spaces in one form: Taylor–Hood elements for Stokes flow.

use std::collections::BTreeMap;

use forms_fem::prelude::*;
use forms_fem::solve::{Elimination, solve_linear};

#[forms]
mod stokes {
    pub struct Data {
        viscosity: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn flow(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * viscosity * inner(eps(u), eps(v)) - p * div(v) - q * div(u))
    }
}

#[test]
fn taylor_hood_elements_hold_poiseuille_flow_exactly() {
    const VISCOSITY: f64 = 0.7;
    let mesh = Arc::new(rectangle([0.0, 0.0], [2.0, 1.0], [4, 3], CellShape::Triangle, 1).unwrap());
    let (velocities, pressures) = (Space::vector(&mesh, 2).unwrap(), Space::scalar(&mesh, 1).unwrap());
    // u = (y(1 − y), 0), p = 2ν (2 − x).
    let profile = |x: &[f64; 2]| [x[1] * (1.0 - x[1]), 0.0];
    let pressure = |x: &[f64; 2]| 2.0 * VISCOSITY * (2.0 - x[0]);
    let form = stokes::flow(&stokes::Data { viscosity: VISCOSITY }, &stokes::Omega::on("all"));
    let assembler = Assembler::new(&mesh);
    let (u, p) = (Field::zero(&velocities), Field::zero(&pressures));
    let matrix = assembler.tangent(&form, &[&u, &p], &[&velocities, &pressures]).unwrap();
    assert!(matrix.is_symmetric(1e-14).unwrap());

    let mut walls = Constraints::new(&velocities);
    walls.fix("boundary", profile).unwrap();
    let mut prescribed: BTreeMap<usize, f64> = walls.prescribed().clone();
    // The pressure is fixed at one node.
    let offset = velocities.unknowns();
    prescribed.insert(offset, pressure(&pressures.positions()[0]));
    let mut elimination = Elimination::new(matrix.rows(), &prescribed).unwrap();
    let load = vec![0.0; matrix.rows()];
    let mut solver = TangentSolver::default();
    let solution = solve_linear(&matrix, &load, &mut elimination, &mut solver).unwrap().solution;

    let exact: Vec<f64> = velocities.positions().iter().flat_map(profile).collect();
    let exact: Vec<f64> = exact.into_iter().chain(pressures.positions().iter().map(pressure)).collect();
    for (value, exact) in solution.iter().zip(&exact) {
        assert!((value - exact).abs() < 1e-11, "{value} against {exact}");
    }
    // The residual of the solution vanishes on free unknowns.
    let u = Field::from_values(&velocities, solution[..offset].to_vec()).unwrap();
    let p = Field::from_values(&pressures, solution[offset..].to_vec()).unwrap();
    let residual = assembler.residual(&form, &[&u, &p], &[&velocities, &pressures]).unwrap();
    for unknown in elimination.free() {
        assert!(residual[*unknown].abs() < 1e-12);
    }
}
