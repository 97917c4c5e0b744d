//! Areas, gaps and integrals of fields of both sides, against closed forms.

use forms_fem::contract::{PairQuadrature, Projection};
use forms_fem::prelude::*;

use super::{cubes, squares, together};

#[forms]
mod pairs {
    #[pairs]
    pub struct Touch;

    pub fn area() -> Functional {
        integral(Touch, 1)
    }
    pub fn opening() -> Functional {
        integral(Touch, gap)
    }
    pub fn distance() -> Scalar {
        gap
    }
    /// Defining equations of an opposite point: x + g n_y = y, n_y is a unit vector, against the opposite normal.
    pub fn contradiction() -> Scalar {
        let off = x + gap * toward - other(x);
        dot(off, off) + pow(dot(toward, toward) - 1, 2)
    }
    pub fn opposite_normal() -> Vector {
        other(n)
    }
    pub fn product(u: State<Scalar>, w: State<Scalar>) -> Functional {
        integral(Touch, this(u) * other(w))
    }
    pub fn jump_of(u: State<Scalar>) -> Functional {
        integral(Touch, jump(u) * jump(u))
    }
    pub fn sizes() -> Functional {
        integral(Touch, this(h) + 10 * other(h) + 100 * this(cell_volume) + 1000 * other(cell_volume))
    }
    pub fn bend() -> Scalar {
        curvature
    }
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs().max(1.0), "{found} is not {expected}");
}

/// Both ways, one way and back, by rays and nearest points.
fn pairings() -> Vec<(Pairing, f64)> {
    let mut all = Vec::new();
    for projection in [Projection::Ray, Projection::Nearest] {
        all.push((Pairing::between("below", "above").by(projection), 2.0));
        all.push((Pairing::onto("below", "above").by(projection), 1.0));
        all.push((Pairing::onto("above", "below").by(projection), 1.0));
    }
    all
}

/// ∫ 1 and ∫ g for bodies a distance apart, and ∫ u(X) w(Y) of polynomials: u = a·x + …, w the same shifted back.
macro_rules! parallel_surfaces {
    ($mesh:expr, $area:expr, $gap:expr, $degree:expr) => {
        let (mesh, area, gap): (_, f64, f64) = ($mesh, $area, $gap);
        let assembler = Assembler::new(&mesh).with_threads(Threads::new(2));
        for (pairing, sides) in pairings() {
            let touch = pairs::Touch::on(pairing.clone());
            close(assembler.functional(&pairs::area(&touch)).unwrap(), sides * area, 1e-12);
            close(assembler.functional(&pairs::opening(&touch)).unwrap(), sides * area * gap, 1e-12);
            let report = assembler.pairs(&pairing, $degree).unwrap();
            close(report.paired_measure, sides * area, 1e-12);
            close(report.measure, sides * area, 1e-12);
            assert_eq!(report.open, 0);
            close(report.largest_gap, gap.max(0.0), 1e-12);
            close(report.deepest_overlap, (-gap).max(0.0), 1e-12);
            for whole in [PairQuadrature::Pieces, PairQuadrature::WholeFacets] {
                let pairing = pairing.clone().at(whole);
                let gaps = assembler.at_pairs(&pairs::distance(), &pairing, 3).unwrap();
                close(gaps.weights.iter().sum(), sides * area, 1e-12);
                gaps.values.iter().for_each(|value| close(value[0], gap, 1e-12));
                let off = assembler.at_pairs(&pairs::contradiction(), &pairing, 3).unwrap();
                off.values.iter().for_each(|value| close(value[0], 0.0, 1e-24));
            }
        }
    };
}

#[test]
fn areas_and_gaps_of_parallel_surfaces() {
    // Sheared and turned: the surfaces are sloped.
    let slope = |[x, y]: [f64; 2]| [x - 0.2 * y, y + 0.5 * x];
    // Apart by 0.05 along the normal of the slope; overlapping by as much.
    for (gap, degree) in [(0.0, 1), (0.05, 2), (-0.05, 1)] {
        let normal = [-0.5 / 1.25_f64.sqrt(), 1.0 / 1.25_f64.sqrt()];
        let moved = |p: [f64; 2]| {
            let [x, y] = slope(p);
            [x + gap * normal[0], y + gap * normal[1]]
        };
        for shapes in [
            [CellShape::Quadrilateral; 2],
            [CellShape::Triangle; 2],
            [CellShape::Triangle, CellShape::Quadrilateral],
        ] {
            parallel_surfaces!(squares(shapes, degree, [&slope, &moved]), 1.25_f64.sqrt(), gap, 2);
        }
    }
    let slope = |[x, y, z]: [f64; 3]| [x - 0.3 * z, y - 0.4 * z, z + 0.3 * x + 0.4 * y];
    for (gap, degree) in [(0.05, 1), (-0.05, 2)] {
        let length = 1.25_f64.sqrt();
        let moved = |p: [f64; 3]| {
            let [x, y, z] = slope(p);
            [x - gap * 0.3 / length, y - gap * 0.4 / length, z + gap / length]
        };
        for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
            parallel_surfaces!(cubes(shape, degree, [&slope, &moved]), length, gap, 2);
        }
    }
}

/// Faces that are no parallelograms: the own outline and the opposite one are general quadrilaterals.
#[test]
fn areas_of_irregular_quadrilaterals() {
    let bent = |[x, y, z]: [f64; 3]| [x + 0.15 * x * (1.0 - x) * y, y + 0.1 * x * y * (1.0 - y), z];
    let apart = |[x, y, z]: [f64; 3]| [x - 0.1 * x * (1.0 - x) * y, y, z + 0.1];
    let mesh = cubes(CellShape::Hexahedron, 1, [&bent, &apart]);
    let assembler = Assembler::new(&mesh);
    for pairing in [Pairing::onto("below", "above"), Pairing::onto("above", "below")] {
        let report = assembler.pairs(&pairing, 2).unwrap();
        close(report.paired_measure, 1.0, 1e-12);
        close(report.largest_gap, 0.1, 1e-12);
    }
}

/// A part of the own surface faces nothing: the upper body is shifted aside.
#[test]
fn what_faces_nothing_is_left_out() {
    let (still, aside) = (|x| x, |[x, y]: [f64; 2]| [x + 0.3, y + 0.1]);
    let mesh = squares([CellShape::Quadrilateral; 2], 1, [&still, &aside]);
    let assembler = Assembler::new(&mesh);
    for (pairing, _) in pairings() {
        let report = assembler.pairs(&pairing, 4).unwrap();
        close(report.paired_measure, 0.7 * report.measure, 1e-12);
        assert_eq!(report.open, 0);
        let whole = assembler.pairs(&pairing.at(PairQuadrature::WholeFacets), 4).unwrap();
        assert!(whole.open > 0 && whole.rejected == 0, "{whole:?}");
    }
    let near = assembler.pairs(&Pairing::onto("below", "above").within_reach(0.11), 4).unwrap();
    close(near.paired_measure, 0.7, 1e-12);
    let (still, aside) = (|x| x, |[x, y, z]: [f64; 3]| [x + 0.3, y - 0.2, z + 0.1]);
    for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
        let mesh = cubes(shape, 1, [&still, &aside]);
        for (pairing, sides) in pairings() {
            let report = Assembler::new(&mesh).pairs(&pairing, 2).unwrap();
            close(report.paired_measure, 0.56 * sides, 1e-12);
        }
    }
}

/// The nearer of two surfaces that lie behind each other counts, once.
#[test]
fn a_surface_hides_what_is_behind_it() {
    let below = rectangle([0.0; 2], [1.0, 1.0], [3, 1], CellShape::Quadrilateral, 1).unwrap();
    let near = rectangle([0.0, 1.1], [1.0, 1.2], [4, 1], CellShape::Quadrilateral, 1).unwrap();
    let far = rectangle([0.0, 1.3], [1.0, 1.5], [5, 1], CellShape::Quadrilateral, 1).unwrap();
    let both = together([&near, &far], ["bottom", "bottom"], [&|x| x, &|x| x]);
    let mesh = together([&below, &both], ["top", "second bottom"], [&|x| x, &|x| x]);
    let mut mesh = mesh;
    let facets = |name: &str| mesh.facet_region(name).unwrap().to_vec();
    let shells = [facets("second first bottom"), facets("second second bottom")].concat();
    mesh.name_listed_facets("shells", &shells).unwrap();
    let report = Assembler::new(&mesh).pairs(&Pairing::onto("below", "shells"), 2).unwrap();
    close(report.paired_measure, 1.0, 1e-12);
    close(report.largest_gap, 0.1, 1e-12);

    let below = cuboid([0.0; 3], [1.0; 3], [2, 2, 1], CellShape::Tetrahedron, 1).unwrap();
    let near = cuboid([0.0, 0.0, 1.1], [1.0, 1.0, 1.2], [3, 2, 1], CellShape::Tetrahedron, 1).unwrap();
    let far = cuboid([0.0, 0.0, 1.3], [1.0, 1.0, 1.5], [2, 3, 1], CellShape::Tetrahedron, 1).unwrap();
    let both = together([&near, &far], ["bottom", "bottom"], [&|x| x, &|x| x]);
    let mut mesh = together([&below, &both], ["top", "second bottom"], [&|x| x, &|x| x]);
    let facets = |name: &str| mesh.facet_region(name).unwrap().to_vec();
    let shells = [facets("second first bottom"), facets("second second bottom")].concat();
    mesh.name_listed_facets("shells", &shells).unwrap();
    let report = Assembler::new(&mesh).pairs(&Pairing::onto("below", "shells"), 2).unwrap();
    close(report.paired_measure, 1.0, 1e-12);
    close(report.largest_gap, 0.1, 1e-12);
}

/// ∫ u(X) w(Y) and ∫ [u]² of polynomials of each side's own degree.
#[test]
fn integrals_of_fields_of_both_sides_are_exact() {
    // A gap of 0.1: X = (x, 1), Y = (x, 1.1).
    let (still, apart) = (|x| x, |[x, y]: [f64; 2]| [x, y + 0.1]);
    for shapes in [[CellShape::Quadrilateral; 2], [CellShape::Triangle; 2]] {
        for degree in 1..=4 {
            let mesh = squares(shapes, 1, [&still, &apart]);
            let assembler = Assembler::new(&mesh);
            let space = Space::scalar(&mesh, degree).unwrap();
            let power = degree as i32;
            let u = Field::interpolate(&space, |x: &[f64; 2]| x[0].powi(power) + x[1]).unwrap();
            let w = Field::interpolate(&space, |x: &[f64; 2]| 1.0 - x[0].powi(power) + x[1]).unwrap();
            let k = f64::from(power);
            let (first, second) = (1.0 / (k + 1.0), 1.0 / (2.0 * k + 1.0));
            for (pairing, sides) in
                [(Pairing::onto("below", "above"), 1.0), (Pairing::between("below", "above"), 2.0)]
            {
                let touch = pairs::Touch::on(pairing);
                // At y = 1: xᵏ + 1; at y = 1.1: 2.1 − xᵏ; and the other way xᵏ + 1.1, 2 − xᵏ.
                let product = |a: f64, b: f64| -second + (b - a) * first + a * b;
                let expected = product(1.0, 2.1) + (sides - 1.0) * product(1.1, 2.0);
                close(assembler.functional(&pairs::product(&touch, &u, &w)).unwrap(), expected, 1e-12);
                close(assembler.functional(&pairs::jump_of(&touch, &u)).unwrap(), 0.01 * sides, 1e-12);
            }
        }
    }
    let (still, apart) = (|x| x, |[x, y, z]: [f64; 3]| [x, y, z + 0.1]);
    for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
        for degree in 1..=2 {
            let mesh = cubes(shape, 1, [&still, &apart]);
            let assembler = Assembler::new(&mesh);
            let space = Space::scalar(&mesh, degree).unwrap();
            let power = degree as i32;
            let u = Field::interpolate(&space, |x: &[f64; 3]| x[0].powi(power) + x[2]).unwrap();
            let w = Field::interpolate(&space, |x: &[f64; 3]| x[1].powi(power) + x[2]).unwrap();
            let touch = pairs::Touch::on(Pairing::onto("below", "above"));
            // (x² + 1)(y² + 1.1)
            let mean = 1.0 / (f64::from(power) + 1.0);
            let expected = (mean + 1.0) * (mean + 1.1);
            close(assembler.functional(&pairs::product(&touch, &u, &w)).unwrap(), expected, 1e-12);
            close(assembler.functional(&pairs::jump_of(&touch, &u)).unwrap(), 0.01, 1e-12);
        }
    }
}

/// h and |T| of both cells: rectangles of 1/3 × 1/2 below and 1/4 × 1/3 above.
#[test]
fn sizes_of_both_cells() {
    let mesh = squares([CellShape::Quadrilateral; 2], 1, [&|x| x, &|x| x]);
    let touch = pairs::Touch::on(Pairing::onto("below", "above"));
    let expected = (1.0 / 9.0 + 0.25_f64).sqrt()
        + 10.0 * (1.0 / 16.0 + 1.0 / 9.0_f64).sqrt()
        + 100.0 / 6.0
        + 1000.0 / 12.0;
    close(Assembler::new(&mesh).functional(&pairs::sizes(&touch)).unwrap(), expected, 1e-12);
}

/// Arcs of two circles about one centre: rays and nearest points are radial, the gap is the difference of the radii as
/// far as quadratic facets are circles (their error falls with h⁴).
#[test]
fn gaps_between_concentric_circles() {
    let error = |around: usize, projection: Projection| {
        let inner = annulus(1.0, 2.0, 1, around, CellShape::Triangle, 2).unwrap();
        let outer = annulus(2.1, 3.0, 1, around * 4 / 3, CellShape::Quadrilateral, 2).unwrap();
        let mesh = together([&inner, &outer], ["outer", "inner"], [&|x| x, &|x| x]);
        let assembler = Assembler::new(&mesh);
        let mut worst = 0.0_f64;
        for pairing in [Pairing::onto("below", "above"), Pairing::onto("above", "below")] {
            let pairing = pairing.by(projection);
            let gaps = assembler.at_pairs(&pairs::distance(), &pairing, 4).unwrap();
            gaps.values.iter().for_each(|gap| worst = worst.max((gap[0] - 0.1).abs()));
            let report = assembler.pairs(&pairing, 4).unwrap();
            close(report.paired_measure, report.measure, 1e-6);
            assert_eq!(report.open, 0);
            // Of both surfaces the outward normals are radial, so that n·n(Y) = −1.
            let normals = assembler.at_pairs(&pairs::opposite_normal(), &pairing, 4).unwrap();
            for (x, normal) in normals.positions.iter().zip(&normals.values) {
                let radius = (x[0] * x[0] + x[1] * x[1]).sqrt();
                let along = (x[0] * normal[0] + x[1] * normal[1]) / radius;
                assert!((along.abs() - 1.0).abs() < 1e-3, "{along}");
            }
            let bends = assembler.at_pairs(&pairs::bend(), &pairing, 4).unwrap();
            for (x, bend) in bends.positions.iter().zip(&bends.values) {
                let radius = (x[0] * x[0] + x[1] * x[1]).sqrt();
                assert!((bend[0].abs() * radius - 1.0).abs() < 0.05, "{bend:?}");
            }
        }
        worst
    };
    for projection in [Projection::Ray, Projection::Nearest] {
        let (coarse, fine) = (error(24, projection), error(48, projection));
        assert!(fine < 1e-5 && coarse / fine > 10.0, "{projection:?}: {coarse:e} {fine:e}");
    }
}

/// Coaxial cylinders in space, the gap in closed form.
#[test]
fn gaps_between_coaxial_cylinders() {
    for projection in [Projection::Ray, Projection::Nearest] {
        let inner = hollow_cylinder(1.0, 2.0, 1.0, [1, 16, 2], CellShape::Tetrahedron, 2).unwrap();
        let outer = hollow_cylinder(2.1, 3.0, 1.0, [1, 24, 3], CellShape::Tetrahedron, 2).unwrap();
        let mesh = together([&inner, &outer], ["outer", "inner"], [&|x| x, &|x| x]);
        let assembler = Assembler::new(&mesh);
        let pairing = Pairing::onto("below", "above").by(projection);
        let gaps = assembler.at_pairs(&pairs::distance(), &pairing, 4).unwrap();
        gaps.values.iter().for_each(|gap| close(gap[0], 0.1, 3e-4));
        let report = assembler.pairs(&pairing, 4).unwrap();
        close(report.paired_measure / report.measure, 1.0, 1e-3);
    }
}
