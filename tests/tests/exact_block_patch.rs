//! The contact patch test: a block w × H on a flat obstacle, pressed by δ from above, free to slide. The
//! solution is linear, so every element has it to rounding: σ_yy = −E′δ/H, J = ½ a(u,u) = ½ E′δ²w/H,
//! contact force E′δw/H, with E′ = E/(1−ν²) in plane strain.

use forms_contact::ContactProblem;
use forms_contact::forms;
use forms_contact::threshold::required_gamma0;
use forms_fem::prelude::*;

const YOUNG: f64 = 70.0;
const POISSON: f64 = 0.3;
/// w, H and, in three dimensions, the thickness \[length\].
const WIDTH: f64 = 1.5;
const HEIGHT: f64 = 0.8;
const THICKNESS: f64 = 0.6;
/// δ.
const PRESSED: f64 = 0.02;
const THETAS: [f64; 3] = [-1.0, 0.0, 1.0];

/// E′.
const PLANE_MODULUS: f64 = YOUNG / (1.0 - POISSON * POISSON);

fn relative(found: f64, expected: f64, what: &str) {
    let error = (found - expected).abs() / expected.abs();
    assert!(error < 1e-10, "{what}: {found} is not {expected} ({error:.1e})");
}

/// `axis` is the direction of pressing, the last one. In three dimensions "front" and "back" are held in
/// plane strain.
fn check<const D: usize>(mesh: Mesh<D>, degree: usize, theta: f64)
where
    Dim: Dimension<D>,
{
    let (axis, area) = (D - 1, if D == 3 { WIDTH * THICKNESS } else { WIDTH });
    let mut mesh = mesh;
    mesh.name_cells_of_facets("contact cells", "bottom").unwrap();
    let space = Space::vector(&mesh, degree).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix_component("top", axis, |_| -PRESSED).unwrap();
    constraints.fix_component("left", 0, |_| 0.0).unwrap();
    if D == 3 {
        constraints.fix_component("front", 1, |_| 0.0).unwrap();
        constraints.fix_component("back", 1, |_| 0.0).unwrap();
    }
    let mut normal = [0.0; D];
    normal[axis] = -1.0;
    let data = forms::data()
        .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
        .mu(YOUNG / (2.0 * (1.0 + POISSON)))
        .gamma0(1.0)
        .obstacle_normal(normal)
        .gap(move |x: &[f64; D]| x[D - 1])
        .theta(theta);
    let (assembler, regions) =
        (Assembler::new(&mesh), forms::Regions::default().gamma_n("right").gamma_c("bottom"));
    let mut problem =
        ContactProblem::new(&space, forms::Model { data, regions }, constraints).assembler(assembler);
    problem.law.data.gamma0 = (1.5 * required_gamma0(&problem, "contact cells").unwrap()).max(YOUNG);
    let solved = problem.direct().unwrap().solver(&mut TangentSolver::default()).solve();
    let solved = solved.unwrap();
    let (u, assembler) = (solved.field(), &problem.assembler);
    println!("{:?} k={degree} θ={theta}: {} steps", mesh.shapes(), solved.history.len() - 1);

    let transverse = POISSON / (1.0 - POISSON) * PRESSED / HEIGHT;
    for (node, x) in space.positions().iter().enumerate() {
        let mut expected = [0.0; D];
        expected[axis] = -PRESSED * x[axis] / HEIGHT;
        expected[0] = transverse * x[0];
        for (found, expected) in u.at_node(node).iter().zip(expected) {
            assert!((found - expected).abs() < 1e-10 * PRESSED, "u at {x:?}: {found} is not {expected}");
        }
    }
    let pressure = PLANE_MODULUS * PRESSED / HEIGHT;
    let stresses =
        assembler.at_quadrature_points(&forms::stress(&problem.law.data, u), Entity::Cells, "all", 4);
    let stresses = stresses.unwrap();
    for (x, stress) in stresses.positions.iter().zip(&stresses.values) {
        for i in 0..D {
            for j in 0..D {
                let expected = match (i, j) {
                    _ if i == axis && j == axis => -pressure,
                    (1, 1) => -POISSON * pressure,
                    _ => 0.0,
                };
                let error = (stress[i * D + j] - expected).abs();
                assert!(error < 1e-9 * pressure, "σ{i}{j} at {x:?}: {}", stress[i * D + j]);
            }
        }
    }
    // J = ½ a(u, u).
    let form = forms::elasticity(&problem.law.data, &problem.law.regions.omega);
    let internal = assembler.residual(&form, &[u], &[&space]).unwrap();
    let energy: f64 = 0.5 * internal.iter().zip(u.values()).map(|(force, u)| force * u).sum::<f64>();
    relative(energy, 0.5 * PLANE_MODULUS * PRESSED.powi(2) * area / HEIGHT, "J");
    let forms::Regions { gamma_c, .. } = &problem.law.regions;
    let force = assembler.functional(&forms::contact_force(&problem.law.data, gamma_c, u)).unwrap();
    relative(force, pressure * area, "contact force");
    let length = assembler.functional(&forms::contact_length(&problem.law.data, gamma_c, u)).unwrap();
    relative(length, area, "contact area");
    // The reaction of the top holds the contact force.
    let top = space.nodes_on("top").unwrap();
    let reaction: f64 = top.iter().map(|&node| solved.residual[node as usize * D + axis]).sum();
    relative(reaction, -pressure * area, "reaction");
}

#[test]
fn plane_strain() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        for degree in [1, 2] {
            for theta in THETAS {
                check(rectangle([0.0, 0.0], [WIDTH, HEIGHT], [5, 3], shape, 1).unwrap(), degree, theta);
            }
        }
    }
}

#[test]
fn plane_strain_on_a_skewed_mesh() {
    // Inner nodes are moved, the outline stays.
    let skew = |[s, t]: [f64; 2]| {
        let bump = 0.15 * s * (1.0 - s) * t * (1.0 - t) * 4.0;
        [WIDTH * (s + bump), HEIGHT * (t - bump)]
    };
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        for degree in [1, 2] {
            for theta in THETAS {
                check(forms_fem::mesh::structured([4, 4], shape, 1, skew).unwrap(), degree, theta);
            }
        }
    }
}

/// The columns of a skewed grid alternately of quadrilaterals and of pairs of triangles, on the boundaries too.
fn of_two_shapes(columns: usize, rows: usize) -> Mesh<2> {
    let mut nodes = Vec::new();
    for j in 0..=rows {
        for i in 0..=columns {
            let [s, t] = [i as f64 / columns as f64, j as f64 / rows as f64];
            let bump = 0.6 * s * (1.0 - s) * t * (1.0 - t);
            nodes.push([WIDTH * (s + bump), HEIGHT * (t - bump)]);
        }
    }
    let (mut squares, mut triangles) = (vec![], vec![]);
    for j in 0..rows {
        for i in 0..columns {
            let at = |a: usize, b: usize| (i + a + (j + b) * (columns + 1)) as u32;
            match i % 2 {
                0 => squares.extend([at(0, 0), at(1, 0), at(1, 1), at(0, 1)]),
                _ => triangles.extend([at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)]),
            }
        }
    }
    let blocks = vec![(CellShape::Triangle, triangles), (CellShape::Quadrilateral, squares)];
    let mut mesh = Mesh::from_blocks(1, nodes, blocks).unwrap();
    for (name, axis, at) in [("left", 0, 0.0), ("right", 0, WIDTH), ("bottom", 1, 0.0), ("top", 1, HEIGHT)] {
        mesh.name_facets(name, "boundary", |centre| (centre[axis] - at).abs() < 1e-12).unwrap();
    }
    mesh
}

#[test]
fn plane_strain_on_triangles_and_quadrilaterals() {
    for degree in [1, 2, 3] {
        for theta in THETAS {
            check(of_two_shapes(5, 4), degree, theta);
        }
    }
}

#[test]
fn plane_strain_in_three_dimensions() {
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        for degree in [1, 2] {
            for theta in THETAS {
                let mesh = cuboid([0.0; 3], [WIDTH, THICKNESS, HEIGHT], [3, 2, 2], shape, 1).unwrap();
                check(mesh, degree, theta);
            }
        }
    }
}

/// Half the energy a(u, u) as a criterion. Its derivative by u is a(u, ·): the adjoint state needs no other form.
#[forms(dimension = 2)]
mod stored {
    pub use forms_contact::forms::{Data, GammaC, GammaN, Omega, direct, elasticity};

    pub fn energy(u: State<Vector>) -> Functional {
        elasticity(u, u) / 2
    }
    /// (21).
    pub fn adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(energy(u), u, q)
    }
    pub fn gradient(u: State<Vector>, p: State<Vector>, Theta: Test<Vector>) -> Form {
        derivative(energy(u) + direct(u, p), shape, Theta)
    }
}

/// J = ½ E′δ²w/H: ∂J/∂H = −J/H and ∂J/∂w = J/w, to rounding, by moving all points with the top or the right side.
#[test]
fn the_shape_gradient_of_the_block_is_exact() {
    for (shape, degree) in [(CellShape::Triangle, 1), (CellShape::Triangle, 2), (CellShape::Quadrilateral, 1)]
    {
        for theta in THETAS {
            let mesh = rectangle([0.0, 0.0], [WIDTH, HEIGHT], [5, 3], shape, 1).unwrap();
            let space = Space::vector(&mesh, degree).unwrap();
            let mut constraints = Constraints::new(&space);
            constraints.fix_component("top", 1, |_| -PRESSED).unwrap();
            constraints.fix_component("left", 0, |_| 0.0).unwrap();
            let data = forms::data()
                .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
                .mu(YOUNG / (2.0 * (1.0 + POISSON)))
                .gamma0(20.0 * YOUNG)
                .obstacle_normal([0.0, -1.0])
                .gap(Given::function_with_gradient(|x: &[f64; 2]| x[1], |_| [0.0, 1.0]))
                .theta(theta);
            let (omega, gamma_n) = (stored::Omega::on("all"), stored::GammaN::on("right"));
            let gamma_c = stored::GammaC::on("bottom");
            let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
            let direct = stored::direct(&data, &omega, &gamma_n, &gamma_c);
            let mut solver = TangentSolver::default();
            let options = NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() };
            let u = Problem::new(&direct, &space)
                .assembler(&assembler)
                .constrained(&constraints)
                .solver(&mut solver)
                .options(options.clone())
                .solve()
                .unwrap()
                .into_field();
            let adjoint = stored::adjoint(&data, &omega, &gamma_n, &gamma_c, &u);
            let p = Problem::new(&adjoint, &space)
                .assembler(&assembler)
                .homogeneous(&constraints)
                .solver(&mut solver)
                .solve()
                .unwrap()
                .into_field();
            let movements = Space::of_geometry(&mesh).unwrap();
            let form = stored::gradient(&data, &omega, &gamma_n, &gamma_c, &u, &p);
            let gradient = assembler.linear_form(&form, &movements).unwrap();
            let energy = 0.5 * PLANE_MODULUS * PRESSED.powi(2) * WIDTH / HEIGHT;
            for (axis, length, exact) in [(1, HEIGHT, -energy / HEIGHT), (0, WIDTH, energy / WIDTH)] {
                // All points move in proportion, or those near the moving side alone.
                for power in [1, 4] {
                    let movement = |x: &[f64; 2]| {
                        let mut by = [0.0; 2];
                        by[axis] = (x[axis] / length).powi(power);
                        by
                    };
                    let movement = Field::interpolate(&movements, movement).unwrap();
                    let found: f64 = gradient.iter().zip(movement.values()).map(|(g, t)| g * t).sum();
                    relative(found, exact, &format!("{shape:?} k={degree} θ={theta}, axis {axis}"));
                }
            }
        }
    }
}
