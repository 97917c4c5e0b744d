//! A ball that an STL file gives, pressed onto a flat tool without a mesh of it: the reaction is that of a fitted mesh.

use forms_contact::ContactProblem;
use forms_contact::forms;
use forms_contact::laws::cut_nitsche;
use forms_fem::cut::{Cut, signed_distance};
use forms_fem::mesh::{RigidSurface, ball};
use forms_fem::prelude::*;

const YOUNG: f64 = 70.0;
const POISSON: f64 = 0.3;
const PRESSED: f64 = 0.1;
const LAMBDA: f64 = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
const MU: f64 = YOUNG / (2.0 * (1.0 + POISSON));

/// The unit sphere as text: an octahedron whose edges are halved again and again.
fn sphere(halvings: usize) -> String {
    let mut triangles = Vec::new();
    for signs in 0..8 {
        let [x, y, z] = [0, 1, 2].map(|k| {
            let mut corner = [0.0; 3];
            corner[k] = if signs >> k & 1 == 0 { 1.0 } else { -1.0 };
            corner
        });
        let even = [0, 3, 5, 6].contains(&signs);
        triangles.push(if even { [x, y, z] } else { [x, z, y] });
    }
    for _ in 0..halvings {
        let middle = |a: [f64; 3], b: [f64; 3]| {
            let sum = [0, 1, 2].map(|k| a[k] + b[k]);
            let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
            sum.map(|x| x / length)
        };
        let quarters = |[a, b, c]: [[f64; 3]; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(quarters).collect();
    }
    let corner = |[x, y, z]: [f64; 3]| format!("vertex {x:e} {y:e} {z:e}\n");
    let facet = |triangle: [[f64; 3]; 3]| {
        let corners = triangle.map(corner).concat();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    let facets: String = triangles.into_iter().map(facet).collect();
    format!("solid ball\n{facets}endsolid ball\n")
}

/// The contact force and the reaction of a quarter of the lower half whose flat side is pushed down, with n cells along 1.13 radii.
fn cut_reaction(surface: &RigidSurface<3>, cells: usize) -> [f64; 2] {
    let size = 1.13;
    let mesh = cuboid([0.0, 0.0, -size], [size, size, 0.0], [cells; 3], CellShape::Tetrahedron, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let cut = Cut::by(&signed_distance(surface, &mesh).unwrap()).unwrap();
    let mut held = Constraints::new(&space);
    hold(&mut held, "top");
    cut.hold_outside(&mut held).unwrap();
    let data = cut_nitsche::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(10.0 * (2.0 * MU + LAMBDA))
        .obstacle_normal([0.0, 0.0, -1.0])
        .gap(|x: &[f64; 3]| x[2] + 1.0)
        .theta(1.0);
    let law = cut_nitsche::Model { data, regions: cut_nitsche::regions().gamma_c("all").gamma_n("top") };
    let body = Assembler::new(&mesh).with_cut(&cut).unwrap();
    let problem = ContactProblem::new(&space, law, held).assembler(body);
    let solved = problem.direct().unwrap().solve().unwrap();
    let force = solved.functional(&problem.law.contact_force(solved.field())).unwrap();
    [force, -solved.reaction("top").unwrap()[2]]
}

fn hold(held: &mut Constraints<3>, flat: &str) {
    held.fix_component("left", 0, |_| 0.0).unwrap();
    held.fix_component("front", 1, |_| 0.0).unwrap();
    held.fix(flat, |_| [0.0, 0.0, -PRESSED]).unwrap();
}

/// The same with hexahedra and degree 2.
fn fitted_reaction(cells: usize) -> f64 {
    let octant = ball(1.0, [true; 3], cells, cells, CellShape::Hexahedron, 2).unwrap();
    // Half a turn about the first diagonal of the horizontal plane.
    let turned = octant.nodes().iter().map(|[x, y, z]| [*y, *x, -z]).collect();
    let mesh = octant.with_nodes(turned).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let mut held = Constraints::new(&space);
    held.fix_component("left", 1, |_| 0.0).unwrap();
    held.fix_component("front", 0, |_| 0.0).unwrap();
    held.fix("bottom", |_| [0.0, 0.0, -PRESSED]).unwrap();
    let data = forms::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(40.0 * (2.0 * MU + LAMBDA))
        .obstacle_normal([0.0, 0.0, -1.0])
        .gap(|x: &[f64; 3]| x[2] + 1.0)
        .theta(1.0);
    let law = forms::Model { data, regions: forms::Regions::default().gamma_c("sphere").gamma_n("bottom") };
    let problem = ContactProblem::new(&space, law, held);
    let solved = problem.direct().unwrap().solve().unwrap();
    solved.functional(&problem.law.contact_force(solved.field())).unwrap()
}

#[test]
fn ball_from_a_file_presses_as_a_fitted_one() {
    let surface = RigidSurface::from_stl(sphere(5).as_bytes()).unwrap();
    // With 8 cells along the radius it is 1.0497.
    let fitted = fitted_reaction(4);
    assert!((fitted / 1.0497 - 1.0).abs() < 3e-3, "{fitted}");
    let errors = [8, 16].map(|cells| {
        let [force, reaction] = cut_reaction(&surface, cells);
        println!("{cells} cells: contact force {force}, reaction {reaction}, fitted {fitted}");
        assert!((force / reaction - 1.0).abs() < 1e-2, "{force} {reaction}");
        (reaction / fitted - 1.0).abs()
    });
    assert!(errors[0] < 5e-2 && errors[1] < 1e-2, "{errors:?}");
}
