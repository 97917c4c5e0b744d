//! Dual multipliers over covers: patch tests with covers of every size, balance, tangents where covers move, and friction, compared with hats.

use forms_contact::laws::mortar_bodies as law;
use forms_contact::laws::mortar_bodies::mortar_bodies_with_friction as rough;
use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;
use forms_fem::solve::{LinearSolver, LocalUnknowns, TangentSolver};

use crate::exact::{check_tangent, dual, multipliers, nodal, resultants};
use crate::friction;
use crate::patch::{OFFSETS, bodies, errors};

/// The products of multipliers and hats over the cover.
#[forms]
mod product {
    #[pairs]
    pub struct Touch;
    pub fn of(u: State<Vector>, p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
        integral(Touch(u), this(p * q))
    }
    pub fn area(u: State<Vector>, q: Test<Scalar>) -> Form {
        integral(Touch(u), this(q))
    }
    pub fn value(p: State<Scalar>) -> Scalar {
        this(p)
    }
    pub fn pressed(u: Unknown<Vector>, v: Test<Vector>, p: State<Scalar>) -> Form {
        integral(Touch(u), this(p) * dot(toward, jump(v)))
    }
}

#[test]
fn functions_are_dual_over_covered_facets_and_have_the_areas_of_hats_over_others() {
    let mesh = bodies(CellShape::Quadrilateral, [9, 8]);
    let space = Space::vector(&mesh, 1).unwrap();
    let (own, dual) = ("layer top", dual(&mesh, "layer top", &[]));
    let hats = multipliers(&mesh, own, 1, &[]);
    let aside = |x: &[f64; 2]| [0.0, 1e-3 * x[1]];
    let u = Field::interpolate(&space, aside).unwrap();
    let touch = product::Touch::on(Pairing::onto(own, "block bottom").at(PairQuadrature::Pieces));
    let assembler = Assembler::new(&mesh);
    let zero = Field::zero(&hats);
    let matrix = assembler.tangent(&product::of(&touch, &u), &[&zero], &[&dual]).unwrap();
    let area = product::area(&touch, &u);
    let [of_dual, of_hats] = [&dual, &hats].map(|space| assembler.residual(&area, &[], &[space]).unwrap());
    for (row, (found, expected)) in of_dual.iter().zip(&of_hats).enumerate() {
        assert!((found - expected).abs() < 1e-15, "{row}: {found} {expected}");
        let (columns, values) = matrix.row(row);
        for (column, value) in columns.iter().zip(values) {
            let expected = if *column as usize == row { of_hats[row] } else { 0.0 };
            assert!((value - expected).abs() < 1e-15, "{row} {column}: {value} {expected}");
        }
    }
}

/// The largest error of the sum of all functions at the points of the cover, and the largest value of one of them.
fn sum_and_bound<const D: usize>(
    mesh: &Mesh<D>,
    (degree, elements): (usize, &Elements),
    pairing: &Pairing,
) -> [f64; 2]
where
    Dim: Dimension<D>,
{
    let own = pairing.surfaces[0].own.clone();
    let traces = Space::of(mesh, elements.clone(), Scope::Facets(own), &[]).unwrap();
    let still = Field::zero(&Space::vector(mesh, degree).unwrap());
    let assembler = Assembler::new(mesh);
    let values = |coefficients: Vec<f64>| {
        let p = Field::from_values(&traces, coefficients).unwrap();
        assembler.at_sliding_pairs(&product::value(&p), pairing, 2 * degree, &still).unwrap().values
    };
    let largest = |values: &[Vec<f64>], less: f64| {
        values.iter().map(|value| (value[0] - less).abs()).fold(0.0, f64::max)
    };
    let count = traces.unknowns();
    let off = largest(&values(vec![1.0; count]), 1.0);
    let of_one = |k: usize| largest(&values((0..count).map(|i| f64::from(i == k)).collect()), 0.0);
    [off, (0..count).map(of_one).fold(0.0, f64::max)]
}

/// Covers of facets between 1 and 10⁻⁸ of them, in the plane from one side, in space of an edge and of a corner.
#[test]
fn functions_over_covers_of_any_size_have_the_sum_one_and_a_bound() {
    for part in [1.0, 0.84, 0.5, 0.1, 1e-2, 1e-4, 1e-8] {
        let slab = rectangle([0.0, -0.4], [3.0, 0.0], [3, 1], CellShape::Quadrilateral, 1).unwrap();
        let block = rectangle([1.0 - part, 0.0], [1.7, 0.4], [4, 1], CellShape::Quadrilateral, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap();
        let pairing = Pairing::onto("slab top", "block bottom").at(PairQuadrature::Pieces);
        for (degree, elements) in KINDS {
            let [off, most] = sum_and_bound(&mesh, (degree, &elements), &pairing);
            println!("{degree} {elements} {part:e}: sum off by {off:.1e}, largest value {most:.2}");
            // Bernstein's whole facet has 3.
            let bound = if elements == Elements::Dual { 2.2 } else { 3.0 };
            assert!(off < 1e-12 && most < bound, "{degree} {elements} {part:e}: {off:e} {most}");
        }
        // Areas of a corner are squares.
        if part >= 1e-4 {
            for (shape, degree, elements) in [
                (CellShape::Tetrahedron, 1, Elements::Dual),
                (CellShape::Hexahedron, 1, Elements::Dual),
                (CellShape::Tetrahedron, 2, Elements::DualOfBernstein),
            ] {
                let low = [0.5 - 0.5 * part, 0.6 - 0.6 * part, 0.0];
                let slab = cuboid([0.0, 0.0, -0.4], [1.5, 1.2, 0.0], [3, 2, 1], shape, 1).unwrap();
                let block = cuboid(low, [1.7, 1.3, 0.4], [3, 2, 1], shape, 1).unwrap();
                let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap();
                let [off, most] = sum_and_bound(&mesh, (degree, &elements), &pairing);
                println!("{shape:?} {degree} {part:e}: sum off by {off:.1e}, largest value {most:.2}");
                // No larger than on whole facets.
                let bound = match (shape, degree) {
                    (_, 2) => 6.0,
                    (CellShape::Hexahedron, _) => 4.0,
                    _ => 3.0,
                };
                assert!(off < 1e-12 && most < bound, "{shape:?} {degree} {part:e}: {off:e} {most}");
            }
        }
    }
}

#[test]
fn known_dual_fields_are_refused_where_their_functions_change() {
    let mesh = bodies(CellShape::Quadrilateral, [9, 8]);
    let space = Space::vector(&mesh, 1).unwrap();
    let own = "layer top";
    let (u, assembler) = (Field::zero(&space), Assembler::new(&mesh));
    let tangent = |traces: &Arc<Space<2>>, pairing: Pairing| {
        let form = product::pressed(&product::Touch::on(pairing), Field::zero(traces));
        assembler.residual(&form, &[&u], &[&space]).unwrap();
        assembler.tangent(&form, &[&u], &[&space]).map(|_| ()).map_err(|error| error.to_string())
    };
    let (dual, hats) = (dual(&mesh, own, &[]), multipliers(&mesh, own, 1, &[]));
    let on_points = || Pairing::onto(own, "block bottom");
    let on_pieces = || on_points().at(PairQuadrature::Pieces);
    let error = tangent(&dual, on_pieces()).unwrap_err();
    assert!(error.contains("the dual functions of `p` change with the cover of moving segments"), "{error}");
    assert!(error.contains("Elements::Bernstein(1)"), "{error}");
    // Hats do not change, and neither do covers that are whole facets.
    tangent(&hats, on_pieces()).unwrap();
    tangent(&dual, on_points()).unwrap();
}

/// Degrees of displacements, and dual multipliers.
const KINDS: [(usize, Elements); 3] =
    [(1, Elements::Dual), (2, Elements::Dual), (2, Elements::DualOfBernstein)];

#[test]
fn pressure_is_constant_while_bodies_slide() {
    println!("| cells | degree of u | own surface | error of the stress | of the multiplier | steps |");
    for (shape, degree, elements, cells) in [
        (CellShape::Quadrilateral, 1, Elements::Dual, [9, 8]),
        (CellShape::Quadrilateral, 2, Elements::Dual, [6, 5]),
        (CellShape::Quadrilateral, 2, Elements::DualOfBernstein, [6, 5]),
        (CellShape::Triangle, 1, Elements::Dual, [6, 10]),
        (CellShape::Triangle, 2, Elements::DualOfBernstein, [9, 4]),
    ] {
        let mesh = bodies(shape, cells);
        let (layer, block) = ("layer top", "block bottom");
        for pairing in [Pairing::onto(block, layer), Pairing::onto(layer, block)] {
            let pairing = pairing.at(PairQuadrature::Pieces);
            let all = OFFSETS.map(|offset| errors(&mesh, (degree, &elements), &pairing, offset));
            let most = |of: fn(&(f64, f64, usize)) -> f64| all.iter().map(of).fold(0.0, f64::max);
            let [stress, multiplier, steps] = [most(|e| e.0), most(|e| e.1), most(|e| e.2 as f64)];
            println!(
                "| {shape:?} | {degree}, {elements} | {pairing} | {stress:.1e} | {multiplier:.1e} | {steps} |"
            );
            let tolerance = if degree == 1 { 1e-12 } else { 1e-11 };
            assert!(stress < tolerance, "{shape:?} {degree} {pairing}: {stress:e}");
            let is_covered = pairing.surfaces[0].own == block;
            assert!(!is_covered || multiplier < 1e-9, "{shape:?} {degree} {pairing}: {multiplier:e}");
        }
    }
}

/// The block covers a part 10⁻², 10⁻⁴ or 10⁻⁸ of a facet of the layer.
#[test]
fn slivers_of_cover_do_no_harm() {
    for (degree, elements) in KINDS {
        let mesh = bodies(CellShape::Quadrilateral, [9, 8]);
        let pairing = Pairing::onto("layer top", "block bottom").at(PairQuadrature::Pieces);
        for part in [1e-2, 1e-4, 1e-8] {
            let offset = 1.0 / 3.0 + part / 3.0;
            let (stress, _, steps) = errors(&mesh, (degree, &elements), &pairing, offset);
            println!("degree {degree}, {elements}, {part:e}: {stress:.1e} in {steps} steps");
            assert!(stress < 1e-7, "{degree} {part}: {stress:e}");
        }
    }
}

/// Bent plates, the own one wider than the other, whose cells are smaller: several facets lie opposite to those that are covered in part.
#[test]
fn forces_balance_and_tangents_have_the_change_of_the_functions() {
    for (degree, elements) in KINDS {
        let lower = structured([5, 1], CellShape::Quadrilateral, degree, |[s, t]: [f64; 2]| {
            [3.0 * s, 0.4 * t - 0.4 + 0.15 * (5.0 * s).sin()]
        });
        let upper = structured([11, 1], CellShape::Quadrilateral, degree, |[s, t]: [f64; 2]| {
            [0.35 + 2.1 * s, 0.02 + 0.4 * t + 0.15 * (0.6 + 3.5 * s).sin()]
        });
        let mesh = Mesh::of_bodies(&[("lower", &lower.unwrap()), ("upper", &upper.unwrap())]).unwrap();
        let space = Space::vector(&mesh, degree).unwrap();
        let own = "lower top";
        let traces = Space::of(&mesh, elements, Scope::Facets(own.to_owned()), &[]).unwrap();
        let regions = law::Regions::default()
            .touch(Pairing::onto(own, "upper bottom").at(PairQuadrature::Pieces))
            .own(own)
            .gamma_n("upper top");
        let form = law::Model { data: law::data().lambda(1.0).mu(1.0).gamma0(30.0), regions }.direct();
        let bent = |phase: f64| {
            let value = |x: &[f64; 2]| {
                [0.05 * (2.0 * x[0] + phase).sin(), 0.03 * (3.0 * x[0] + x[1] + 2.0 * phase).cos()]
            };
            Field::interpolate(&space, value).unwrap()
        };
        let pressures = |phase: f64| nodal(&traces, |x| [2.0 + (4.0 * x[0] + phase).sin()]);
        let at = [&bent(0.3), &pressures(0.0), &pressures(1.7)];
        let [force, moment] = resultants(&form, at);
        println!("degree {degree}: {force:.1e} {moment:.1e}");
        assert!(force < 1e-13 && moment < 1e-13, "{degree}: {force:e} {moment:e}");
        check_tangent(&form, at, [&bent(1.1), &pressures(0.7), &pressures(2.9)], &format!("degree {degree}"));
    }
}

/// Friction with the slab as the own surface, which the block covers in part.
#[test]
fn tangents_with_friction_in_the_plane() {
    let mesh = friction::mesh();
    for (degree, elements) in KINDS {
        let space = Space::vector(&mesh, degree).unwrap();
        let bent = |phase: f64| {
            let value = |x: &[f64; 2]| {
                let block = if x[1] > 1e-9 { 1.0 } else { 0.0 };
                let up = 0.02 * (3.0 * x[0] + x[1] + phase).sin();
                [block * 0.2 + 0.02 * (2.0 * x[1] + x[0] + phase).cos(), up - 0.03 * block]
            };
            Field::interpolate(&space, value).unwrap()
        };
        let traces = Space::of(&mesh, elements, Scope::Facets("slab top".into()), &[2]).unwrap();
        let across = |phase: f64| nodal(&traces, |x| [2.0 + (4.0 * x[0] + phase).sin(), (5.0 * x[0]).cos()]);
        let base = law::data().lambda(20.0).mu(10.0).gamma0(100.0).friction(0.3);
        let regions = rough::Regions::default()
            .touch(Pairing::onto("slab top", "block bottom").at(PairQuadrature::Pieces))
            .own("slab top")
            .gamma_n("block right");
        let data = base.displacement_before(Given::field(bent(0.1)));
        let form = rough::Model { data, regions }.direct();
        let along = [&bent(1.9), &across(2.2), &across(1.3)];
        check_tangent(&form, [&bent(0.4), &across(0.2), &across(0.9)], along, &format!("degree {degree}"));
    }
}

/// Facets of a slab of tetrahedra and hexahedra that a block covers in part.
#[test]
fn tangents_with_friction_in_space() {
    for (shape, degree, elements) in [
        (CellShape::Tetrahedron, 1, Elements::Dual),
        (CellShape::Hexahedron, 1, Elements::Dual),
        (CellShape::Tetrahedron, 2, Elements::DualOfBernstein),
    ] {
        let slab = cuboid([0.0, 0.0, -0.4], [1.5, 1.2, 0.0], [3, 2, 1], shape, 1).unwrap();
        let block = cuboid([0.2, 0.1, 0.0], [1.1, 0.9, 0.4], [3, 3, 1], shape, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap();
        let space = Space::vector(&mesh, degree).unwrap();
        let traces = Space::of(&mesh, elements, Scope::Facets("slab top".into()), &[3]).unwrap();
        let bent = |phase: f64| {
            let value = |x: &[f64; 3]| -> [f64; 3] {
                let up = 0.02 * (x[0] * x[1] + phase).sin();
                [0.02 * (x[1] + phase).sin(), 0.02 * (2.0 * x[0] + phase).cos(), up]
            };
            Field::interpolate(&space, value).unwrap()
        };
        let across = |phase: f64| {
            let value = |x: &[f64; 3]| -> [f64; 3] {
                let pressed = 2.0 + (4.0 * x[0] + x[1] + phase).sin();
                [(3.0 * x[1] + phase).cos(), (2.0 * x[0] + phase).sin(), pressed]
            };
            nodal(&traces, value)
        };
        let base = law::data().lambda(1.0).mu(1.0).gamma0(30.0).friction(0.4).axis([0.0, 0.0, 1.0]);
        let regions = rough::Regions::default()
            .touch(Pairing::onto("slab top", "block bottom").at(PairQuadrature::Pieces))
            .own("slab top")
            .gamma_n("block right");
        let data = base.displacement_before(Given::field(bent(0.1)));
        let form = rough::Model { data, regions }.direct();
        let at = [&bent(0.3), &across(0.0), &across(1.7)];
        let [force, _] = resultants(&form, at);
        assert!(force < 1e-13, "{shape:?} {degree}: {force:e}");
        check_tangent(&form, at, [&bent(1.1), &across(0.7), &across(2.9)], &format!("{shape:?} {degree}"));
    }
}

/// What sticks does not creep, what slides bears Coulomb's friction, and forces are those with hats up to the mesh's error.
#[test]
fn friction_is_that_of_hats() {
    for (degree, dual, hats) in [
        (1, Elements::Dual, Elements::Bernstein(1)),
        (2, Elements::Dual, Elements::Bernstein(1)),
        (2, Elements::DualOfBernstein, Elements::Bernstein(2)),
    ] {
        let (is_of_vertices, dual, hats) = (dual == Elements::Dual, (degree, &dual), (degree, &hats));
        // One multiplier per vertex holds the mean slip, and not each node of degree 2.
        let (_, moved, _) = friction::drawn(dual, 20.0, 0.004, 3);
        assert!(degree == 2 && is_of_vertices || moved < 1e-12, "it creeps by {moved:e}");
        let [(force, _, ratio), (other, ..)] = [dual, hats].map(|with| friction::drawn(with, 0.3, 1.1, 3));
        let apart = (force[0] - other[0]).hypot(force[1] - other[1]) / other[0].hypot(other[1]);
        println!("degree {degree}: |t|/κp − 1 {:.1e}, forces apart {apart:.1e}", ratio.abs() / 0.3 - 1.0);
        assert!((ratio.abs() / 0.3 - 1.0).abs() < 1e-10, "{degree}: {ratio}");
        assert!(apart < 2e-2, "{degree}: {force:?} {other:?}");
    }
}

/// Multipliers are eliminated from unsymmetric systems, where balances of displacements have one each: with covered facets all, else but those at
/// facets that are covered in part. Solutions are those of the whole systems.
#[test]
fn eliminated_multipliers_are_those_of_the_whole_system() {
    let mesh = friction::mesh();
    let space = Space::vector(&mesh, 1).unwrap();
    for (own, opposite, of_friction) in [
        ("block bottom", "slab top", 0.0),
        ("block bottom", "slab top", 0.3),
        ("slab top", "block bottom", 0.0),
    ] {
        let mut held = Constraints::new(&space);
        held.fix("slab bottom", |_| [0.0; 2]).unwrap();
        held.fix("block top", |_| [0.02, -0.05]).unwrap();
        let traces = dual(&mesh, own, &[2]);
        let base = law::data().lambda(115.0).mu(77.0).gamma0(1000.0).friction(of_friction);
        let touch = Pairing::onto(own, opposite).at(PairQuadrature::Pieces);
        let regions = rough::Regions::default().touch(touch).own(own).gamma_n("block right");
        let data = base.displacement_before(Given::field(Field::zero(&space)));
        let model = rough::Model { data, regions };
        let start = [Field::zero(&space), nodal(&traces, |_| [10.0, 0.0]), Field::zero(&traces)];
        let solve = |solver: &mut dyn LinearSolver| {
            let options = NewtonOptions {
                relative_tolerance: 1e-12,
                line_search: LineSearch::OnResidual,
                ..NewtonOptions::default()
            };
            let problem = law::frictional_mortar_problem(&model, [&space, &traces], &held).unwrap();
            problem.options(options).start(start.each_ref()).solver(solver).solve().unwrap()
        };
        let whole = solve(&mut TangentSolver::default());
        let condensed = solve(&mut LocalUnknowns::<TangentSolver>::default());
        let counts = condensed.report.as_ref().and_then(|report| report.local_unknowns).unwrap();
        let apart = |k: usize| {
            let pairs = whole.fields[k].values().iter().zip(condensed.fields[k].values());
            let largest = whole.fields[k].values().iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
        };
        let steps = [&whole, &condensed].map(|solved| solved.iterations());
        println!("{own}, {of_friction}: {counts:?}, {:.1e} {:.1e}, {steps:?} steps", apart(0), apart(1));
        assert!(apart(0) < 1e-10 && apart(1) < 1e-10, "{own}: {:e} {:e}", apart(0), apart(1));
        let (all, found) = (2 * traces.unknowns(), counts.eliminated);
        assert!(found == all || own == "slab top" && found > 0, "{own}: {counts:?} of {all}");
    }
}
