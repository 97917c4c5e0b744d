//! γ₀'s threshold against closed forms: γ_F ≥ (1+θ)²/4 · (λ+2μ) k(k+d−1)/d · |F|/|T| on a simplex of degree k in
//! d dimensions with one contact facet, and the known figures of the paper's cylinder.

use forms_contact::forms;
use forms_contact::hollow_cylinder::{CONTACT_CELLS, Settings, hollow_cylinder};
use forms_contact::laws::frictional_nitsche;
use forms_contact::threshold::required_gamma0;
use forms_contact::{Adjoint, ContactProblem};
use forms_fem::prelude::*;

const LAMBDA: f64 = 1.7;
const MU: f64 = 0.9;

/// One simplex; Γ_C is its facet in the plane x_d = 0.
fn simplex<const D: usize>(shape: CellShape, vertices: Vec<[f64; D]>) -> Mesh<D> {
    let cells = (0..=D as u32).collect();
    let mut mesh = Mesh::from_parts(shape, 1, vertices, cells).unwrap();
    mesh.name_facets("contact", "boundary", |centre| centre[D - 1].abs() < 1e-12).unwrap();
    assert_eq!(mesh.facet_region("contact").unwrap().len(), 1);
    mesh
}

/// On a mesh with Γ_C = "contact".
fn problem<const D: usize>(mesh: &Mesh<D>, degree: usize, theta: f64) -> ContactProblem<D>
where
    Dim: Dimension<D>,
{
    let space = Space::vector(mesh, degree).unwrap();
    let mut normal = [0.0; D];
    normal[D - 1] = -1.0;
    let data = forms::data().lambda(LAMBDA).mu(MU).gamma0(1.0).obstacle_normal(normal).gap(0.0).theta(theta);
    let constraints = Constraints::new(&space);
    let regions = forms::Regions::default().gamma_n("contact").gamma_c("contact");
    ContactProblem::new(&space, forms::Model { data, regions }, constraints)
}

/// The γ₀ of [`required_gamma0`] on a mesh with Γ_C = "contact", all of whose cells own facets of it.
fn required<const D: usize>(mesh: &Mesh<D>, degree: usize, theta: f64) -> f64
where
    Dim: Dimension<D>,
{
    required_gamma0(&problem(mesh, degree, theta), "all").unwrap()
}

/// (1+θ)²/4 (λ+2μ) k(k+d−1)/d |F|/|T| h.
fn closed_form(dimension: f64, degree: usize, theta: f64, facet_over_cell: f64, diameter: f64) -> f64 {
    let k = degree as f64;
    let c = (LAMBDA + 2.0 * MU) * k * (k + dimension - 1.0) / dimension * facet_over_cell;
    (1.0 + theta).powi(2) / 4.0 * c * diameter
}

fn agree(found: f64, expected: f64) {
    println!("{found} {expected}");
    assert!((found - expected).abs() <= 1e-10 * expected, "{found} is not {expected}");
}

#[test]
fn one_triangle() {
    // Base 2, height 0.75.
    let mesh = simplex(CellShape::Triangle, vec![[0.0, 0.0], [2.0, 0.0], [0.5, 0.75]]);
    let (facet_over_cell, diameter) = (2.0 / 0.75, 2.0);
    for degree in [1, 2] {
        for theta in [-1.0, -0.5, 0.0, 1.0] {
            let expected = closed_form(2.0, degree, theta, facet_over_cell, diameter);
            agree(required(&mesh, degree, theta), expected);
        }
    }
}

#[test]
fn one_tetrahedron() {
    // Base ½·2·1, height 1.5; the longest edge lies in the base.
    let vertices = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.25, 1.5]];
    let mesh = simplex(CellShape::Tetrahedron, vertices);
    let (facet_over_cell, diameter) = (1.0 / (1.5 / 3.0), 5.0_f64.sqrt());
    for degree in [1, 2] {
        for theta in [-1.0, 0.0, 1.0] {
            let expected = closed_form(3.0, degree, theta, facet_over_cell, diameter);
            agree(required(&mesh, degree, theta), expected);
        }
    }
}

/// With friction the whole traction counts. On a simplex of degree 1 the largest of |σ(v)n|² relative to σ:ε is the largest
/// eigenvalue of the acoustic tensor μ I + (λ+μ) n⊗n, which is λ+2μ: the threshold is the one without friction.
#[test]
fn with_friction() {
    fn check<const D: usize>(mesh: &Mesh<D>)
    where
        Dim: Dimension<D>,
    {
        for theta in [-0.5, 0.0, 1.0] {
            let ContactProblem { assembler, space, law, constraints, .. } = problem(mesh, 1, theta);
            let data = frictional_nitsche::data_from(law.data);
            let regions = frictional_nitsche::Regions::default().gamma_n("contact").gamma_c("contact");
            let law = frictional_nitsche::Model { data, regions };
            let problem = ContactProblem::new(&space, law, constraints).assembler(assembler);
            agree(required_gamma0(&problem, "all").unwrap(), required(mesh, 1, theta));
        }
    }
    check(&simplex(CellShape::Triangle, vec![[0.0, 0.0], [2.0, 0.0], [0.5, 0.75]]));
    let vertices = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.25, 1.5]];
    check(&simplex(CellShape::Tetrahedron, vertices));
}

#[test]
fn the_worst_cell_counts() {
    // Two triangles over the same base line, the flat one asks for more.
    let nodes = vec![[0.0, 0.0], [1.0, 0.0], [0.5, 1.0], [2.0, 0.0], [1.5, 0.1]];
    let mut mesh = Mesh::from_parts(CellShape::Triangle, 1, nodes, vec![0, 1, 2, 1, 3, 4]).unwrap();
    mesh.name_facets("contact", "boundary", |centre| centre[1].abs() < 1e-12).unwrap();
    agree(required(&mesh, 2, 1.0), closed_form(2.0, 2, 1.0, 2.0 / 0.1, 1.0));
}

#[test]
fn two_contact_facets_of_a_cell_add_up() {
    // A P1 triangle, σ constant, all three facets in Γ_C: the products of the facets add up in one matrix.
    let vertices = vec![[0.0, 0.0], [2.0, 0.0], [0.5, 0.75]];
    let mut mesh = Mesh::from_parts(CellShape::Triangle, 1, vertices, vec![0, 1, 2]).unwrap();
    mesh.name_facets("contact", "boundary", |_| true).unwrap();
    let all = required(&mesh, 1, 1.0);
    // σ n·n_y = σ_xy n_x·(−1) + σ_yy n_y·(−1): with uniaxial strain alone, σ_yy = λ+2μ and σ_xy = 0, the Rayleigh
    // quotient is a lower bound: Σ_F |F| n_y² (λ+2μ)/|T| · h.
    let (left, right) = (0.5_f64.hypot(0.75), 1.5_f64.hypot(0.75));
    let sum = 2.0 + 0.5_f64.powi(2) / left + 1.5_f64.powi(2) / right;
    assert!(all >= sum / 0.75 * (LAMBDA + 2.0 * MU) * 2.0 * (1.0 - 1e-12), "{all}");
}

/// Figures of an independent computation (the bare 18 × 18 matrices of every contact cell, 5 Gauss points per
/// direction, dense eigenvalues). They settle to three digits, 9.47 E, from n_r = 32 on.
#[test]
fn the_cylinder() {
    let figures =
        [(1, 9.083243389147466), (4, 9.425185180562158), (16, 9.46443231473962), (32, 9.472033059487908)];
    for (radial, figure) in figures {
        for (theta, factor) in [(1.0, 1.0), (0.0, 0.25), (-1.0, 0.0)] {
            let settings = Settings { theta, radial, ..Settings::default() };
            let problem = hollow_cylinder(&settings).unwrap();
            let found = required_gamma0(&problem, CONTACT_CELLS).unwrap() / settings.young;
            agree(found, factor * figure);
            let in_print = factor * 9.47;
            assert!(radial < 32 || (found - in_print).abs() < 0.005, "{found} E is not {in_print} E");
        }
    }
}

/// Data with which a wrong γ₀ would pass for a right one, or obstacles would pull, are an error that names them.
#[test]
fn contact_cells_that_lack_one_and_gamma0_that_is_not_positive_are_errors() {
    let settings = Settings { radial: 4, theta: 1.0, ..Settings::default() };
    let mut cylinder = hollow_cylinder(&settings).unwrap();
    let error = required_gamma0(&cylinder, "fewer").unwrap_err().to_string();
    assert!(error.contains("fewer"), "{error}");
    let u = Field::zero(&cylinder.space);
    for gamma0 in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        cylinder.law.data.gamma0 = gamma0;
        let solver = &mut TangentSolver::default();
        let direct: Result<Solved<2>, SolveError> =
            cylinder.direct().map_err(SolveError::from).and_then(|mut problem| problem.solve());
        let direct = direct.unwrap_err();
        let adjoint = cylinder.solve_adjoint(Adjoint::Discrete, &u, solver).unwrap_err();
        for error in [direct.to_string(), adjoint.to_string()] {
            assert!(error.contains("`gamma0`") && error.contains(&gamma0.to_string()), "{error}");
        }
    }
    // One of two triangles of a square has the facet below, the other does not.
    let mut mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 1).unwrap();
    mesh.name_facets("contact", "bottom", |_| true).unwrap();
    let owner = mesh.facet_region("contact").unwrap()[0].cell as usize;
    let centre = mesh.cell_centre(owner);
    mesh.name_cells("above", |other| *other != centre).unwrap();
    let error = required_gamma0(&problem(&mesh, 1, 1.0), "above").unwrap_err().to_string();
    assert!(error.contains("\"above\" lack the one at") && error.contains("\"contact\""), "{error}");
}
