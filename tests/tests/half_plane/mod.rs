//! The set-up of the half-plane problems on \[−1,1\]×\[0,1\] with Γ_C = {y = 0} on a flat obstacle: exact
//! values on the top, exact tractions on the sides.
#![allow(dead_code, reason = "each test uses a part")]

use std::collections::BTreeMap;
use std::sync::{Mutex, OnceLock};

use forms_contact::ContactProblem;
use forms_contact::forms;
use forms_contact::threshold::required_gamma0;
use forms_fem::norms::{Norms, errors};
use forms_fem::prelude::*;

use crate::closed_forms::{HalfPlaneField, Material, Potential};

/// c in σ_yy = −c √r.
pub const INTENSITY: f64 = 1.0;
/// γ₀ over the threshold at θ = 1.
pub const MARGIN: f64 = 1.5;
/// Degree of the quadrature.
pub const DEGREE: usize = 8;
/// The region of the vertical sides.
pub const SIDES: &str = "sides";
/// The region of the cells at Γ_C.
pub const CONTACT_CELLS: &str = "contact cells";

/// E = 1, ν = 0.3.
pub fn material() -> Material {
    Material::new(1.0, 0.3)
}

/// Problem A's displacement.
pub fn signorini_transition() -> HalfPlaneField {
    HalfPlaneField { material: material(), potential: Potential::SignoriniTransition(INTENSITY) }
}

/// The mesh with `divisions` cells along Γ_C: x = 0 is a node when it is even, else the middle of a facet.
pub fn mesh(shape: CellShape, divisions: usize) -> Mesh<2> {
    let mut mesh = rectangle([-1.0, 0.0], [1.0, 1.0], [divisions, divisions.div_ceil(2)], shape, 1).unwrap();
    mesh.name_facets(SIDES, "boundary", |centre| centre[0].abs() > 1.0 - 1e-9).unwrap();
    mesh.name_cells_of_facets(CONTACT_CELLS, "bottom").unwrap();
    mesh
}

/// Problem A with γ₀ = [`MARGIN`] times what θ = 1 asks for.
pub fn direct_problem(mesh: &Mesh<2>, degree: usize, theta: f64) -> ContactProblem<2> {
    let exact = signorini_transition();
    let space = Space::vector(mesh, degree).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix("top", |x| exact.displacement(x)).unwrap();
    let data = forms::data()
        .lambda(exact.material.lambda)
        .mu(exact.material.mu)
        .gamma0(1.0)
        .obstacle_normal([0.0, -1.0])
        .gap(0.0)
        .theta(1.0)
        .traction(Given::function(move |x| exact.side_traction(x)));
    let regions = forms::Regions::default().gamma_n(SIDES).gamma_c("bottom");
    let mut problem = ContactProblem::new(&space, forms::Model { data, regions }, constraints)
        .quadrature(Quadrature::Degree(DEGREE));
    problem.law.data.gamma0 = MARGIN * required_gamma0(&problem, CONTACT_CELLS).unwrap();
    problem.law.data.theta = theta;
    assert!(problem.law.data.gamma0 > required_gamma0(&problem, CONTACT_CELLS).unwrap());
    problem
}

/// A shape, the cells along Γ_C, a degree, the bits of θ.
type Case = (CellShape, usize, usize, u64);

/// u_h of (14) by the case, solved for once: the tests of problems A and B share the cases.
static SOLVED: Mutex<BTreeMap<Case, Arc<OnceLock<Vec<f64>>>>> = Mutex::new(BTreeMap::new());

/// Problem A on a mesh of its own, and u_h of (14).
pub fn solved_direct(
    shape: CellShape,
    divisions: usize,
    degree: usize,
    theta: f64,
) -> (ContactProblem<2>, Field<2>) {
    let problem = direct_problem(&mesh(shape, divisions), degree, theta);
    let case = (shape, divisions, degree, theta.to_bits());
    let values = SOLVED.lock().unwrap().entry(case).or_default().clone();
    let solve = || {
        let (mut solver, options) = (TangentSolver::default(), NewtonOptions::default());
        problem
            .direct()
            .unwrap()
            .solver(&mut solver)
            .options(options.clone())
            .solve()
            .unwrap()
            .into_field()
            .values()
            .to_vec()
    };
    let u = Field::from_values(&problem.space, values.get_or_init(solve).clone()).unwrap();
    (problem, u)
}

/// The error of a state.
pub fn error(assembler: &Assembler<2>, field: &Field<2>, exact: HalfPlaneField) -> Norms {
    let value = move |x: &[f64; 2], out: &mut [f64]| out.copy_from_slice(&exact.displacement(x));
    let slope = move |x: &[f64; 2], out: &mut [f64]| out.copy_from_slice(exact.gradient(x).as_flattened());
    errors(assembler, field, value, slope).unwrap()
}

/// σn on the vertical sides, zero elsewhere: a function on all of ∂Ω.
pub fn on_sides(x: &[f64; 2], field: HalfPlaneField) -> [f64; 2] {
    if x[0].abs() > 1.0 - 1e-12 { field.side_traction(x) } else { [0.0; 2] }
}
