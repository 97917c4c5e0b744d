//! Residuals, tangents and actions on pairs: they fit each other, balance, and are the same on any number of threads.

use std::collections::BTreeMap;

use forms_fem::assemble::BlockPattern;
use forms_fem::contract::{PairQuadrature, Projection, Side};
use forms_fem::prelude::*;
use forms_fem::verification;

use super::{cubes, squares, together};

#[forms(matrix_free)]
mod loaded {
    pub struct Data {
        wanted: Given<Scalar>,
    }
    #[pairs]
    pub struct Touch;

    /// Nonlinear, with a kink, and with gradients of both sides.
    pub fn adhesion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let pressure = neg_part(gap - dot(jump(u), toward) - 0.05);
        integral(
            Touch,
            pressure / this(h) * dot(jump(v), toward)
                + (1 + dot(jump(u), jump(u))) * dot(this(grad(u) * n) + other(grad(u) * n), jump(v))
                + dot(other(u), other(grad(v) * n)) * other(wanted),
        )
    }
    /// The function of position at Y less that at X.
    pub fn given_jump() -> Functional {
        integral(Touch, other(wanted) - this(wanted))
    }
}

#[forms(matrix_free)]
mod springs {
    #[pairs]
    pub struct Touch;

    /// Linear, with constant coefficients.
    pub fn glue(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Touch, jump(u) * jump(v))
    }
    pub fn glued(u: Unknown<Scalar>) -> Energy {
        integral(Touch, 0.5 * jump(u) * jump(u) + gap * this(u))
    }
    /// A multiplier on the own facets.
    pub fn tied(u: Unknown<Vector>, l: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Touch, this(l) * dot(jump(v), toward) + this(q) * dot(jump(u), toward))
    }
    /// Second derivatives on both sides.
    pub fn bending(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Touch, tr(other(hess(u)) - this(hess(u))) * jump(v))
    }
}

fn irregular<const D: usize>(space: &Arc<Space<D>>, size: f64) -> Field<D> {
    let value = |index: usize| size * (((index * 7919 + 13) % 1009) as f64 / 1009.0 - 0.5);
    Field::from_values(space, (0..space.unknowns()).map(value).collect()).unwrap()
}

fn pairing(projection: Projection, quadrature: PairQuadrature) -> Pairing {
    Pairing::between("below", "above").by(projection).at(quadrature)
}

fn all_pairings() -> Vec<Pairing> {
    let mut all = vec![];
    for projection in [Projection::Ray, Projection::Nearest] {
        for quadrature in [PairQuadrature::Pieces, PairQuadrature::WholeFacets] {
            all.push(pairing(projection, quadrature));
        }
    }
    all
}

/// The tangent is the derivative of the residual, by Taylor tests and by the action; forces balance.
macro_rules! fits {
    ($mesh:expr, $degree:expr, $pairing:expr) => {
        let (mesh, pairing) = ($mesh, $pairing);
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(3));
        let space = Space::vector(&mesh, $degree).unwrap();
        let data = loaded::data().wanted(Given::function(|x| 1.0 + x[0]));
        let form = loaded::adhesion(&data, &loaded::Touch::on(pairing));
        let (u, w) = (irregular(&space, 0.1), irregular(&space, 1.0));
        let report = verification::tangent(&assembler, &form, &[&u], &[&w], 0.1).unwrap();
        report.second_order().unwrap();
        let matrix = assembler.tangent(&form, &[&u], &[&space]).unwrap();
        let action = assembler.action(&form, &[&u], &[&w], &[&space]).unwrap();
        let product = matrix.multiply(w.values()).unwrap();
        let size = product.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
        for (a, b) in action.iter().zip(&product) {
            assert!((a - b).abs() < 1e-12 * size, "{a} is not {b}");
        }
    };
}

#[test]
fn tangents_are_derivatives_of_residuals() {
    let (still, apart) = (|x| x, |[x, y]: [f64; 2]| [x + 0.05, y + 0.04 + 0.05 * x]);
    for pairing in all_pairings() {
        for shapes in [[CellShape::Quadrilateral; 2], [CellShape::Triangle, CellShape::Quadrilateral]] {
            fits!(squares(shapes, 2, [&still, &apart]), 2, pairing.clone());
        }
    }
    let (still, apart) = (|x| x, |[x, y, z]: [f64; 3]| [x + 0.05, y, z + 0.04 + 0.05 * x]);
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        fits!(cubes(shape, 1, [&still, &apart]), 1, pairing(Projection::Ray, PairQuadrature::Pieces));
    }
}

/// Matching meshes that touch: the pairs are the two sides of the interior facets that the same body in one piece has,
/// so that matrices agree.
#[test]
fn matching_meshes_give_the_matrix_of_interior_facets() {
    #[forms]
    mod skeleton {
        #[interior_facets]
        pub struct Skeleton;
        pub fn glue(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
            integral(Skeleton, jump(u) * jump(v))
        }
        pub fn bending(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
            integral(Skeleton, tr(other(hess(u)) - this(hess(u))) * jump(v))
        }
    }
    // By positions of the nodes and the bodies that they belong to: each value of a row times a column.
    fn entries<const D: usize>(
        space: &Space<D>,
        matrix: &forms_fem::linear_algebra::CsrMatrix,
    ) -> BTreeMap<String, f64> {
        let mesh = space.mesh();
        let mut body = vec![false; space.node_count()];
        for cell in 0..mesh.cell_count() {
            let upper = mesh.cell_centre(cell)[D - 1] > 1.0;
            space.cell_nodes(cell).iter().for_each(|node| body[*node as usize] = upper);
        }
        let name = |node: usize| format!("{:.6?} {}", space.positions()[node], body[node]);
        let mut found = BTreeMap::new();
        for row in 0..space.node_count() {
            for column in 0..space.node_count() {
                let value = matrix.get(row, column);
                if value.abs() > 1e-14 {
                    *found.entry(format!("{} × {}", name(row), name(column))).or_insert(0.0) += value;
                }
            }
        }
        found
    }
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let whole = rectangle([0.0; 2], [1.0, 2.0], [3, 2], shape, 1).unwrap();
        let lower = rectangle([0.0; 2], [1.0, 1.0], [3, 1], shape, 1).unwrap();
        let upper = rectangle([0.0, 1.0], [1.0, 2.0], [3, 1], shape, 1).unwrap();
        let halves = together([&lower, &upper], ["top", "bottom"], [&|x| x, &|x| x]);
        let mut whole = whole;
        whole.name_interior_facets("middle", "interior", |x| x[1] == 1.0).unwrap();
        // A pair adds up over both own surfaces; an interior facet counts once.
        let touch = springs::Touch::on(Pairing::onto("below", "above"));
        let skeleton = skeleton::Skeleton::on("middle");
        let [first, second] = [&halves, &whole].map(|mesh| Space::discontinuous_scalar(mesh, 2).unwrap());
        let zero = [Field::zero(&first), Field::zero(&second)];
        let (pairs, facets) = (Assembler::new(&halves), Assembler::new(&whole));
        let glued = pairs.tangent(&springs::glue(&touch), &[&zero[0]], &[&first]).unwrap();
        let expected = facets.tangent(&skeleton::glue(&skeleton), &[&zero[1]], &[&second]).unwrap();
        let bent = pairs.tangent(&springs::bending(&touch), &[&zero[0]], &[&first]).unwrap();
        let bent_too = facets.tangent(&skeleton::bending(&skeleton), &[&zero[1]], &[&second]).unwrap();
        for (found, expected) in [(glued, expected), (bent, bent_too)] {
            let (found, expected) = (entries(&first, &found), entries(&second, &expected));
            let size = expected.values().fold(0.0_f64, |size, value| size.max(value.abs()));
            assert!(found.len() >= 36 && found.len() == expected.len(), "{} {}", found.len(), expected.len());
            for ((a, x), (b, y)) in found.iter().zip(&expected) {
                assert!(a == b && (x - y).abs() < 1e-13 * size, "{a}: {x} is not {y}");
            }
        }
    }
}

#[test]
fn threads_and_parts_change_nothing() {
    let (still, apart) = (|x| x, |[x, y]: [f64; 2]| [x + 0.05, y + 0.04]);
    let lower = rectangle([0.0; 2], [1.0, 1.0], [700, 1], CellShape::Triangle, 1).unwrap();
    let upper = rectangle([0.0, 1.0], [1.0, 2.0], [613, 1], CellShape::Triangle, 1).unwrap();
    let mesh = together([&lower, &upper], ["top", "bottom"], [&still, &apart]);
    let space = Space::vector(&mesh, 2).unwrap();
    let u = irregular(&space, 0.1);
    let data = loaded::data().wanted(1.0);
    let form =
        loaded::adhesion(&data, &loaded::Touch::on(Pairing::between("below", "above").within_reach(0.1)));
    let run = |threads: usize| {
        let assembler = Assembler::new(&mesh).with_threads(Threads::new(threads));
        let residual = assembler.residual(&form, &[&u], &[&space]).unwrap();
        let matrix = assembler.tangent(&form, &[&u], &[&space]).unwrap();
        (residual, matrix)
    };
    let (residual, matrix) = run(1);
    for threads in [2, 5] {
        let (other, tangent) = run(threads);
        assert!(residual == other && matrix.values() == tangent.values(), "{threads} threads");
    }
    // What several assemblers own adds up.
    let cells = mesh.cell_order().cells();
    let mut sum = vec![0.0; space.unknowns()];
    let mut values: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    let (first, rest) = cells.split_at(cells.len() / 3);
    for owned in [first, rest] {
        let partial = Assembler::new(&mesh).on_owned_cells(owned).unwrap();
        let part = partial.residual(&form, &[&u], &[&space]).unwrap();
        sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        let part = partial.tangent(&form, &[&u], &[&space]).unwrap();
        for row in 0..space.unknowns() {
            let (columns, entries) = part.row(row);
            for (column, value) in columns.iter().zip(entries) {
                *values.entry((row, *column as usize)).or_default() += value;
            }
        }
    }
    let size = residual.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
    assert!(size > 1e-6 && sum.iter().zip(&residual).all(|(a, b)| (a - b).abs() < 1e-12 * size));
    let size = matrix.values().iter().fold(0.0_f64, |size, value| size.max(value.abs()));
    for ((row, column), value) in values {
        assert!((value - matrix.get(row, column)).abs() < 1e-12 * size, "{row} {column}");
    }
}

#[test]
fn energies_functions_of_position_and_multipliers() {
    let (still, apart) = (|x| x, |[x, y]: [f64; 2]| [x, y + 0.1]);
    let mesh = squares([CellShape::Triangle; 2], 1, [&still, &apart]);
    let assembler = Assembler::new(&mesh);
    let touch = springs::Touch::on(Pairing::onto("below", "above"));
    let data = loaded::data().wanted(Given::function(|x| 3.0 * x[1] + x[0]));
    let given = loaded::Touch::on(Pairing::onto("below", "above"));
    let found = assembler.functional(&loaded::given_jump(&data, &given)).unwrap();
    assert!((found - 0.3).abs() < 1e-14, "{found}");

    let space = Space::scalar(&mesh, 2).unwrap();
    let u = irregular(&space, 1.0);
    let energy = springs::glued(&touch);
    let report = verification::tangent(&assembler, &energy, &[&u], &[&irregular(&space, 0.3)], 0.1).unwrap();
    assert!(report.is_affine(), "{report}");
    let gradient = assembler.residual(&energy, &[&u], &[&space]).unwrap();
    let step = 1e-5;
    let moved = |factor: f64| {
        let values = u.values().iter().zip(&gradient).map(|(u, g)| u + factor * g).collect();
        assembler.energy(&energy, &[&Field::from_values(&space, values).unwrap()]).unwrap()
    };
    let square: f64 = gradient.iter().map(|g| g * g).sum();
    // Quadratic: the central difference is exact.
    let difference = (moved(step) - moved(-step)) / (2.0 * step);
    assert!((difference - square).abs() < 1e-9 * square, "{difference} {square}");

    // A multiplier on the own surface: the matrix holds ∫ l [v]·n_y, whose sum over all v is zero for constant v.
    let (vectors, multipliers) =
        (Space::vector(&mesh, 2).unwrap(), Space::discontinuous_on_facets(&mesh, "below", 1).unwrap());
    let form = springs::tied(&touch);
    let (u, l) = (irregular(&vectors, 1.0), irregular(&multipliers, 1.0));
    let residual = assembler.residual(&form, &[&u, &l], &[&vectors, &multipliers]).unwrap();
    let force: f64 = residual[..vectors.unknowns()].iter().skip(1).step_by(2).sum();
    assert!(force.abs() < 1e-13, "{force}");
    let matrix = assembler.tangent(&form, &[&u, &l], &[&vectors, &multipliers]).unwrap();
    let whole: Vec<f64> = u.values().iter().chain(l.values()).copied().collect();
    let product = matrix.multiply(&whole).unwrap();
    assert!(product.iter().zip(&residual).all(|(a, b)| (a - b).abs() < 1e-13));
    // The multiplier has no nodes on the other surface.
    let reversed = springs::tied(&springs::Touch::on(Pairing::onto("above", "below")));
    let refused = assembler.residual(&reversed, &[&u, &l], &[&vectors, &multipliers]);
    assert!(matches!(refused, Err(AssemblyError::OffItsFacets { .. })), "{refused:?}");
}

/// Element matrices name both cells; the pattern couples what faces each other and nothing else.
#[test]
fn the_pattern_couples_cells_that_face_each_other() {
    let mesh = squares([CellShape::Quadrilateral; 2], 1, [&|x| x, &|x| x]);
    let space = Space::scalar(&mesh, 1).unwrap();
    let form = springs::glue(&springs::Touch::on(Pairing::onto("below", "above")));
    let assembler = Assembler::new(&mesh);
    let zero = Field::zero(&space);
    let found = assembler.element_matrices(&form, &[&zero], &[&space]).unwrap();
    let units: Vec<_> = found
        .iter()
        .filter(|matrix| matrix.sides == [Side::This, Side::Other])
        .map(|matrix| (matrix.cell, matrix.opposite.unwrap().cell))
        .collect();
    let mut sorted = units.clone();
    sorted.sort_unstable();
    // Thirds below face quarters above; the upper row of the lower body are cells 3 to 5, the upper body starts at 6.
    assert_eq!(sorted, [(3, 6), (3, 7), (4, 7), (4, 8), (5, 8), (5, 9)]);
    let pattern = BlockPattern::for_form(&form, &[&space], &[&space]).unwrap();
    let row = |node: u32| pattern.pattern().row(node as usize).to_vec();
    let at = |cell: usize, x: f64| {
        let nodes = space.cell_nodes(cell).iter().copied();
        nodes.filter(|node| space.positions()[*node as usize][0] == x).collect::<Vec<u32>>()
    };
    // The left end below with the left and the right end above, where both are on the surfaces: the form reads values, and those of
    // other nodes vanish there.
    assert!(at(3, 0.0).len() == 2 && at(6, 0.0).len() == 2 && at(9, 1.0).len() == 2);
    let touches = |node: u32| space.positions()[node as usize][1] == 1.0;
    for a in at(3, 0.0) {
        for b in at(6, 0.0) {
            let coupled = touches(a) && touches(b);
            assert_eq!((row(a).contains(&b), row(b).contains(&a)), (coupled, coupled));
        }
        assert!(at(9, 1.0).iter().all(|b| !row(a).contains(b)));
    }
    assert_eq!(at(3, 0.0).into_iter().chain(at(6, 0.0)).filter(|node| touches(*node)).count(), 2);
}

/// Self contact: the arms of a C face each other, cells that share a vertex do not.
#[test]
fn arms_of_one_body_face_each_other() {
    // A bar of 12 × 1 cells bent to a C.
    let bent = |[x, y]: [f64; 2]| {
        let turn = std::f64::consts::PI * (x - 0.5);
        match x {
            x if x < 0.0 => [3.0 * x, -1.0 - y],
            x if x > 1.0 => [3.0 * (1.0 - x), 1.0 + y],
            _ => [(1.0 + y) * turn.cos(), (1.0 + y) * turn.sin()],
        }
    };
    let bar = rectangle([-1.0, 0.0], [2.0, 0.5], [12, 1], CellShape::Quadrilateral, 1).unwrap();
    let nodes = bar.nodes().iter().map(|x| bent(*x)).collect();
    let mut mesh = Mesh::from_parts(CellShape::Quadrilateral, 1, nodes, bar.cells().to_vec())
        .or_else(|_| {
            let mirrored = bar.nodes().iter().map(|x| bent([1.0 - x[0], x[1]])).collect();
            Mesh::from_parts(CellShape::Quadrilateral, 1, mirrored, bar.cells().to_vec())
        })
        .unwrap();
    let inner = bar.facet_region("bottom").unwrap().to_vec();
    mesh.name_listed_facets("inner", &inner).unwrap();
    let assembler = Assembler::new(&mesh);
    let report = assembler.pairs(&Pairing::within("inner").within_reach(2.5), 2).unwrap();
    // Both arms, each of length 3, a distance of 2 apart; of the four edges between them, whose normals are turned by π/8 and
    // 3π/8 against those of the arms, two see the other arm within reach.
    let turn = std::f64::consts::PI / 8.0;
    let (paired, all) = (6.0 + 4.0 * turn.sin(), 6.0 + 8.0 * turn.sin());
    assert!((report.paired_measure - paired).abs() < 1e-12, "{report:?}");
    assert!((report.measure - all).abs() < 1e-12, "{report:?}");
    assert!((2.0..2.0 / turn.cos()).contains(&report.largest_gap), "{report:?}");
    let space = Space::scalar(&mesh, 1).unwrap();
    let form = springs::glue(&springs::Touch::on(Pairing::within("inner").within_reach(2.5)));
    let (u, zero) = (irregular(&space, 1.0), Field::zero(&space));
    let residual = assembler.residual(&form, &[&u], &[&space]).unwrap();
    let product = assembler.tangent(&form, &[&zero], &[&space]).unwrap().multiply(u.values()).unwrap();
    assert!(residual.iter().zip(&product).all(|(a, b)| (a - b).abs() < 1e-13));
    assert!(residual.iter().sum::<f64>().abs() < 1e-13);
}
