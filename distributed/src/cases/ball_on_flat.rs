//! Hertz's ball of R = 8 on a rigid flat: a quarter of it, cut at the height of its centre, where it is pressed down.

use forms_contact::ContactProblem;
use forms_contact::forms;
use forms_contact::threshold::required_gamma0;
use forms_fem::mesh::{MeshError, structured};
use forms_fem::prelude::*;

use super::parts::refined;

const RADIUS: f64 = 8.0;
const WIDTH: f64 = 4.0;
/// Γ_C is the lower boundary where x and y are below this.
const REACH: f64 = 2.0;
/// Displacement of the top.
const PRESSED: f64 = 0.05;
const YOUNG: f64 = 200.0;
const POISSON: f64 = 0.3;

/// On `divisions`³ cells of degree 2, smaller towards the contact, with 1.5 times the γ₀ that θ = 1 asks for, so that this variant's matrix is positive
/// definite.
///
/// # Errors
/// Too many cells, or too few for a contact.
pub fn ball_on_flat(divisions: usize, theta: f64) -> Result<ContactProblem<3>, Box<dyn std::error::Error>> {
    let mut mesh = structured([divisions; 3], CellShape::Hexahedron, 2, place)?;
    mesh.name_facets("contact", "bottom", is_near)?;
    mesh.name_cells_of_facets("contact cells", "contact")?;
    let mut problem = pressed(&mesh, theta)?;
    problem.law.data.theta = 1.0;
    problem.law.data.gamma0 = 1.5 * required_gamma0(&problem, "contact cells")?;
    problem.law.data.theta = theta;
    Ok(problem)
}

/// The quarter with cells that are divided next to the contact, so that nodes hang on Γ_C, too.
///
/// # Errors
/// Too many cells.
pub fn refined_quarter(divisions: usize) -> Result<Mesh<3>, MeshError> {
    let mut mesh = refined(
        structured([divisions; 3], CellShape::Hexahedron, 2, place)?,
        &[0.0, 0.0, -RADIUS],
        &[REACH],
    )?;
    mesh.name_facets("contact", "bottom", is_near)?;
    Ok(mesh)
}

/// The map from the unit cube to the quarter of the ball.
pub fn place([s, t, w]: [f64; 3]) -> [f64; 3] {
    let graded = |t: f64| 0.4 * t + 0.6 * t * t;
    let (x, y) = (WIDTH * graded(s), WIDTH * graded(t));
    [x, y, -(RADIUS * RADIUS - x * x - y * y).sqrt() * (1.0 - graded(w))]
}

/// Whether a facet of the lower boundary is one of Γ_C, by its centre.
pub fn is_near(centre: &[f64; 3]) -> bool {
    centre[0].max(centre[1]) < REACH
}

/// The problem on a mesh of the quarter whose Γ_C is called "contact", or a part of it, with γ₀ = E.
///
/// # Errors
/// A mesh without these regions.
pub fn pressed(mesh: &Mesh<3>, theta: f64) -> Result<ContactProblem<3>, Box<dyn std::error::Error>> {
    let space = Space::vector(mesh, 2)?;
    let mut constraints = Constraints::new(&space);
    constraints.join_hanging_nodes()?;
    constraints.fix_component("left", 0, |_| 0.0)?;
    constraints.fix_component("front", 1, |_| 0.0)?;
    constraints.fix_component("top", 2, |_| -PRESSED)?;
    let data = forms::data()
        .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
        .mu(YOUNG / (2.0 * (1.0 + POISSON)))
        .gamma0(YOUNG)
        .obstacle_normal([0.0, 0.0, -1.0])
        .gap(|x: &[f64; 3]| x[2] + RADIUS)
        .theta(theta)
        .criterion_force([0.0, 0.0, -1.0]);
    let assembler = Assembler::new(space.mesh()).with_quadrature(Quadrature::Degree(6));
    let regions = forms::Regions::default().gamma_n("right").gamma_c("contact");
    let assembler = assembler.with_threads(Threads::new(1));
    Ok(ContactProblem::new(&space, forms::Model { data, regions }, constraints).assembler(assembler))
}
