//! Relations whose frames turn from node to node: a sector that repeats by rotation, and bodies that slide along curved
//! and skew boundaries, in the plane and in space.

use forms_fem::constraints::RigidMap;
use forms_fem::mesh::{annulus, structured};
use forms_fem::prelude::*;

#[forms]
mod bodies {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Loaded;

    pub struct Data {
        load: Given<Vector>,
    }

    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, 2 * inner(eps(u), eps(v)) + div(u) * div(v)) - integral(Loaded, dot(load, v))
    }
}

const PI: f64 = std::f64::consts::PI;

fn solve<const D: usize>(
    space: &Arc<Space<D>>,
    constraints: &Constraints<D>,
    load: Given<[f64; D], D>,
    loaded: &str,
) -> Field<D>
where
    Dim: Dimension<D>,
{
    let (data, assembler) = (bodies::data().load(load), Assembler::new(space.mesh()));
    let form = bodies::elasticity(&data, &bodies::Omega::on("all"), &bodies::Loaded::on(loaded));
    let problem = Problem::new(&form, space).assembler(&assembler);
    problem.constrained(constraints).solve().unwrap().into_field()
}

// A traction that turns with the annulus sixfold: radial and tangential parts have the period of a sector.
fn sixfold(x: &[f64; 2]) -> [f64; 2] {
    let angle = x[1].atan2(x[0]);
    let (radial, tangential) = (0.3 + (6.0 * angle).cos(), 0.2 - 0.5 * (6.0 * angle).sin());
    let (sin, cos) = angle.sin_cos();
    [radial * cos - tangential * sin, radial * sin + tangential * cos]
}

// The solution on the whole annulus is unique, so it has the load's period, and restricted to a sector it solves the
// sector's discrete problem: both agree to rounding, on meshes that agree.
#[test]
fn a_sector_that_repeats_by_rotation_is_a_sixth_of_the_annulus() {
    let (sin, cos) = (PI / 3.0).sin_cos();
    let sixth = RigidMap::rotation([[cos, -sin], [sin, cos]], [0.0; 2]);
    for degree in [1, 2, 3] {
        let whole = annulus(1.0, 2.0, 2, 24, CellShape::Quadrilateral, 2).unwrap();
        let polar = |[s, t]: [f64; 2]| {
            let (sin, cos) = (PI / 3.0 * t).sin_cos();
            [(1.0 + s) * cos, (1.0 + s) * sin]
        };
        let sector = structured([2, 4], CellShape::Quadrilateral, 2, polar).unwrap();
        let spaces = [&whole, &sector].map(|mesh| Space::vector(mesh, degree).unwrap());
        let mut clamped = Constraints::new(&spaces[0]);
        clamped.fix("inner", |_| [0.0; 2]).unwrap();
        let expected = solve(&spaces[0], &clamped, Given::function(sixfold), "outer");
        let mut periodic = Constraints::new(&spaces[1]);
        periodic.fix("left", |_| [0.0; 2]).unwrap();
        periodic.periodic("bottom", "top", &sixth).unwrap();
        let found = solve(&spaces[1], &periodic, Given::function(sixfold), "right");
        let largest = expected.values().iter().fold(0.0_f64, |largest, u| largest.max(u.abs()));
        for (node, x) in spaces[1].positions().iter().enumerate() {
            let other = spaces[0].nearest_node(x).unwrap();
            let at = spaces[0].positions()[other];
            assert!((x[0] - at[0]).hypot(x[1] - at[1]) < 1e-12);
            for (a, b) in found.at_node(node).iter().zip(expected.at_node(other)) {
                assert!((a - b).abs() < 1e-11 * largest, "degree {degree} at {x:?}: {a} not {b}");
            }
        }
        // Vectors are turned: on both cuts the parts along and across the radius are the same.
        let frame = |node: usize| {
            let (x, u) = (spaces[1].positions()[node], found.at_node(node));
            let r = x[0].hypot(x[1]);
            [(u[0] * x[0] + u[1] * x[1]) / r, (u[1] * x[0] - u[0] * x[1]) / r]
        };
        let [first, second] =
            [[2.0, 0.0], [2.0 * cos, 2.0 * sin]].map(|x| spaces[1].nearest_node(&x).unwrap());
        let ([a, b], [c, d]) = (frame(first), frame(second));
        assert!((a - c).abs() < 1e-12 && (b - d).abs() < 1e-12 && b.abs() > 1e-3, "{a} {b} {c} {d}");
    }
}

/// The way in which the radial displacement is prescribed on the inner boundary.
#[derive(Clone, Copy, Debug)]
enum Normals {
    /// By the mesh's normals.
    Mean,
    /// By the exact ones.
    Given,
}

// Lamé: u_r = A r + B / r in plane strain, with mu = lambda = 1: sigma_r = 4 A - 2 B / r². From sigma_r(2) = 0 and u_r(1) = 1
// follow A = 1/9 and B = 8/9.
fn lame(r: f64) -> f64 {
    (r + 8.0 / r) / 9.0
}

fn times<const D: usize>(rows: &[[f64; D]; D], x: &[f64; D]) -> [f64; D] {
    rows.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
}

fn transposed<const D: usize>(rows: &[[f64; D]; D]) -> [[f64; D]; D] {
    std::array::from_fn(|i| std::array::from_fn(|j| rows[j][i]))
}

// The largest error at nodes of a turned wedge of 50°: it slides along its plane sides, and its inner side is pushed
// outwards by 1. The axis is the last one before the turn.
fn error_of_wedge<const D: usize>(
    divisions: [usize; D],
    shape: CellShape,
    turn: [[f64; D]; D],
    sides: &[&str],
    normals: Normals,
) -> f64
where
    Dim: Dimension<D>,
{
    let wedge = |x: [f64; D]| {
        let ((sin, cos), r) = ((PI * 50.0 / 180.0 * x[1]).sin_cos(), 1.0 + x[0]);
        let mut place = x;
        (place[0], place[1]) = (r * cos, r * sin);
        times(&turn, &place)
    };
    let mesh = structured(divisions, shape, 2, wedge).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let back = transposed(&turn);
    let radial = move |x: &[f64; D]| {
        let mut direction = times(&back, x);
        direction[2..].fill(0.0);
        direction
    };
    let mut constraints = Constraints::new(&space);
    for side in sides {
        constraints.slide_along(side, |_| 0.0).unwrap();
    }
    match normals {
        // The outward normal points to the axis.
        Normals::Mean => constraints.slide_along("left", |_| -1.0).unwrap(),
        Normals::Given => constraints.slide("left", |x| times(&turn, &radial(x)), |_| 1.0).unwrap(),
    }
    let u = solve(&space, &constraints, Given::constant([0.0; D]), "right");
    let error = |(node, x): (usize, &[f64; D])| {
        let direction = radial(x);
        let r = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        let exact = times(&turn, &direction.map(|x| x / r * lame(r)));
        u.at_node(node).iter().zip(exact).map(|(u, exact)| (u - exact).powi(2)).sum::<f64>().sqrt()
    };
    space.positions().iter().enumerate().map(error).fold(0.0, f64::max)
}

#[test]
fn a_skew_wedge_slides_along_its_cuts_and_its_curved_side() {
    let (sin, cos) = 0.4_f64.sin_cos();
    let turn = [[cos, -sin], [sin, cos]];
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        for normals in [Normals::Mean, Normals::Given] {
            let error = |n: usize| error_of_wedge([n, n], shape, turn, &["bottom", "top"], normals);
            let errors = [4, 8, 16].map(error);
            println!("{shape:?}, {normals:?}: {errors:?}");
            // Degree 2: the third order.
            assert!(
                errors[2] < 2e-5 && (errors[1] / errors[2]).log2() > 2.8,
                "{shape:?} {normals:?} {errors:?}"
            );
        }
    }
}

#[test]
fn a_wedge_in_space_slides_along_all_its_sides() {
    // About the first axis, then about the third one.
    let ((a, b), (c, d)) = (0.5_f64.sin_cos(), 0.7_f64.sin_cos());
    let turn = [[d, -c * b, c * a], [c, d * b, -d * a], [0.0, a, b]];
    for normals in [Normals::Mean, Normals::Given] {
        let error = |n: usize| {
            let sides = ["front", "back", "bottom", "top"];
            error_of_wedge([n, n, 1], CellShape::Hexahedron, turn, &sides, normals)
        };
        let errors = [2, 4, 8].map(error);
        println!("{normals:?}: {errors:?}");
        assert!(errors[2] < 1e-5 && (errors[1] / errors[2]).log2() > 2.8, "{normals:?} {errors:?}");
    }
}
