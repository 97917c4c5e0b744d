//! The tangent of moving segments is the derivative of what is assembled: compared with differences, and by Taylor tests that start where
//! segments appear.

use forms_contact::laws::sliding_bodies as sliding;
use forms_contact::laws::two_bodies as fixed;
use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::{RigidSurface, structured};
use forms_fem::prelude::*;

use crate::balance::{bent, forms as springs_between, model, plates};
use crate::patch::{Method, bodies, layers_of, methods, pairings};

/// A smooth field without symmetry.
pub fn wave(space: &Arc<Space<2>>, size: f64, phase: f64) -> Field<2> {
    Field::interpolate(space, |x| {
        let angle = 2.0 * x[0] + 2.7 * x[1] + phase;
        [size * angle.sin(), size * (1.3 * angle + 1.9).sin()]
    })
    .unwrap()
}

fn moved<const D: usize>(u: &Field<D>, w: &Field<D>, t: f64) -> Field<D> {
    let values = u.values().iter().zip(w.values()).map(|(u, w)| u + t * w).collect();
    Field::from_values(u.space(), values).unwrap()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, f64::max)
}

/// The largest difference of the tangent's product and a difference of fourth order, as a part of the largest entry.
pub fn off_differences<const D: usize>(
    assembler: &Assembler<D>,
    form: &Form<D>,
    (u, w): (&Field<D>, &Field<D>),
    h: f64,
) -> f64 {
    let space = [u.space()];
    let residual = |t: f64| assembler.residual(form, &[&moved(u, w, t)], &space).unwrap();
    let product = assembler.tangent(form, &[u], &space).unwrap().multiply(w.values()).unwrap();
    let [a, b, c, d] = [h, -h, 2.0 * h, -2.0 * h].map(residual);
    let difference = |k: usize| (8.0 * (a[k] - b[k]) - (c[k] - d[k])) / (12.0 * h);
    let off = largest((0..product.len()).map(|k| product[k] - difference(k)));
    let size = largest(product.into_iter());
    assert!(size > 0.0, "nothing touches");
    off / size
}

/// The least order of |R(u + t w) − R(u) − t K w| over halvings of t > 0.
pub fn taylor_order<const D: usize>(
    assembler: &Assembler<D>,
    form: &Form<D>,
    u: &Field<D>,
    w: &Field<D>,
) -> [f64; 2] {
    let space = [u.space()];
    let product = assembler.tangent(form, &[u], &space).unwrap().multiply(w.values()).unwrap();
    let start = assembler.residual(form, &[u], &space).unwrap();
    let rest = |t: f64| {
        let there = assembler.residual(form, &[&moved(u, w, t)], &space).unwrap();
        largest((0..start.len()).map(|k| there[k] - start[k] - t * product[k]))
    };
    let rests: Vec<f64> = (0..5).map(|k| rest(1e-2 * 0.5_f64.powi(k))).collect();
    let orders = rests.windows(2).map(|pair| (pair[0] / pair[1]).log2());
    [orders.clone().fold(f64::INFINITY, f64::min), orders.fold(0.0, f64::max)]
}

/// The largest difference of springs at points and with means.
fn off_springs(mesh: &Mesh<2>, pairing: &Pairing, along: (&Field<2>, &Field<2>)) -> f64 {
    let assembler = Assembler::new(mesh);
    largest(springs_between(pairing).iter().map(|form| off_differences(&assembler, form, along, 2e-4)))
}

/// Springs between bent plates, with free ends inside of facets, for all kinds of facets.
#[test]
fn tangents_of_springs_are_those_of_differences() {
    for (shape, geometry, degree) in [
        (CellShape::Quadrilateral, 1, 1),
        (CellShape::Triangle, 1, 1),
        (CellShape::Quadrilateral, 1, 2),
        (CellShape::Triangle, 2, 2),
        (CellShape::Quadrilateral, 2, 2),
    ] {
        let mesh = plates(shape, geometry, [7, 9]);
        let space = Space::vector(&mesh, degree).unwrap();
        for pairing in pairings_of("lower top", "upper bottom") {
            for phase in [0.2, 1.1] {
                let (u, w) = (bent(&space, phase), wave(&space, 1.0, 0.7 + phase));
                let off = off_springs(&mesh, &pairing, (&u, &w));
                println!("{shape:?} {geometry} {degree} {pairing} {phase}: {off:.1e}");
                assert!(off < 1e-9, "{shape:?} {degree} {pairing}: {off:e}");
            }
        }
    }
}

/// On straight facets that are covered the rule is exact and the gap continuous: forces at held points are the gradient of the energy.
#[test]
fn tangents_of_mean_gaps_are_symmetric() {
    for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
        let mesh = plates(shape, 1, [7, 9]);
        let space = Space::vector(&mesh, 1).unwrap();
        let form = model(&Pairing::onto("upper bottom", "lower top")).potential_forces();
        let (u, w) = (bent(&space, 0.2), wave(&space, 1.0, 0.9));
        let tangent = Assembler::new(&mesh).tangent(&form, &[&u], &[&space]).unwrap();
        let [there, back] = [tangent.multiply(w.values()), tangent.multiply_transposed(w.values())];
        let (there, back) = (there.unwrap(), back.unwrap());
        let off = largest(there.iter().zip(&back).map(|(a, b)| a - b)) / largest(there.iter().copied());
        println!("{shape:?}: {off:.1e}");
        assert!(off < 1e-12, "{shape:?}: {off:e}");
    }
}

/// Where segments change at the start, an energy over a flat own surface that is covered has two continuous derivatives. Forces at held points and
/// their tangent are the gradient and the second derivative there, and leave a rest of order three.
#[test]
fn taylor_tests_of_an_energy_have_order_three_over_flat_own_surfaces() {
    for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
        // Nodes of the block face nodes of the layer at x = 1 and x = 1.5.
        let layer = rectangle([0.0, -0.5], [3.0, 0.0], [6, 2], shape, 1).unwrap();
        let block = rectangle([0.75, 0.0], [1.75, 0.5], [4, 2], shape, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("layer", &layer), ("block", &block)]).unwrap();
        let (space, assembler) = (Space::vector(&mesh, 1).unwrap(), Assembler::new(&mesh));
        let law = model(&Pairing::onto("block bottom", "layer top"));
        let (energy, forces) = (law.energy(), law.gradient());
        for phase in [0.3, 1.7, 2.9] {
            let (_, u) =
                layers_of(&mesh, Method::Penalty, &pairings()[0], (&Field::zero(&space), 0.0, -0.03));
            let w = wave(&space, 0.3, phase);
            let product = |a: &[f64]| a.iter().zip(w.values()).map(|(a, b)| a * b).sum::<f64>();
            let at = |t: f64| assembler.energy(&energy, &[&moved(&u, &w, t)]).unwrap();
            let slope = product(&assembler.residual(&forces, &[&u], &[&space]).unwrap());
            let tangent = assembler.tangent(&forces, &[&u], &[&space]).unwrap();
            let bend = product(&tangent.multiply(w.values()).unwrap());
            let rest = |t: f64| (at(t) - at(0.0) - t * slope - 0.5 * t * t * bend).abs();
            let rests: Vec<f64> = (0..4).map(|k| rest(0.02 * 0.5_f64.powi(k))).collect();
            let orders: Vec<f64> = rests.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
            println!("{shape:?} {phase}: {orders:.3?}");
            assert!(orders.iter().all(|order| (order - 3.0).abs() < 0.05), "{shape:?} {phase}: {orders:?}");
        }
    }
}

fn pairings_of(lower: &str, upper: &str) -> [Pairing; 3] {
    [Pairing::between(lower, upper), Pairing::onto(lower, upper), Pairing::onto(upper, lower)]
}

/// Nitsche's method with three θ: stresses of own fields move with the points.
#[test]
fn tangents_of_nitsche_are_those_of_differences() {
    for (shape, degree) in
        [(CellShape::Quadrilateral, 1), (CellShape::Triangle, 2), (CellShape::Quadrilateral, 2)]
    {
        let mesh = bodies(shape, [5, 4]);
        let space = Space::vector(&mesh, degree).unwrap();
        for method in methods(degree).into_iter().filter(|method| *method != Method::Multiplier) {
            for pairing in pairings() {
                let (u, w) = (wave(&space, 0.01, 0.3), wave(&space, 1.0, 1.7));
                let (model, u) = layers_of(&mesh, method, &pairing, (&u, 0.173, -0.03));
                let off = off_differences(&Assembler::new(&mesh), &method.form(&model), (&u, &w), 2e-4);
                println!("{shape:?} {degree} {method:?} {pairing}: {off:.1e}");
                assert!(off < 1e-9, "{shape:?} {degree} {method:?} {pairing}: {off:e}");
            }
        }
    }
}

/// The library's law with friction, on rubber.
#[test]
fn tangents_with_friction_are_those_of_differences() {
    for degree in [1, 2] {
        let mesh = bodies(CellShape::Quadrilateral, [6, 5]);
        let space = Space::vector(&mesh, degree).unwrap();
        let pairing = Pairing::between("layer top", "block bottom").at(PairQuadrature::Pieces);
        let data = fixed::data().lambda(15.0).mu(10.0).gamma0(300.0).friction(0.3).share(0.5);
        let data = data.displacement_before(wave(&space, 0.01, 0.9));
        let regions = sliding::Regions::default().touch(pairing.clone()).gamma_n("layer left");
        let law = sliding::Model { data, regions };
        let (u, w) = (wave(&space, 0.01, 0.3), wave(&space, 1.0, 1.7));
        let (_, u) = layers_of(&mesh, Method::Penalty, &pairing, (&u, 0.173, -0.05));
        let off = off_differences(&Assembler::new(&mesh), &law.direct(), (&u, &w), 2e-4);
        println!("degree {degree}: {off:.1e}");
        assert!(off < 1e-9, "{degree}: {off:e}");
    }
}

/// A hairpin whose arms face each other.
pub fn hairpin() -> Mesh<2> {
    let place = |[s, t]: [f64; 2]| {
        let (along, inner) = (4.0 * s - 2.0, 0.45 - 0.3 * t);
        match along {
            a if a < -0.5 => [a + 0.5, -inner],
            a if a > 0.5 => [0.5 - a, inner],
            a => [inner * (std::f64::consts::PI * a).cos(), inner * (std::f64::consts::PI * a).sin()],
        }
    };
    structured([17, 1], CellShape::Quadrilateral, 1, place).unwrap()
}

/// A block under a rigid tool with kinks, with a displacement and a direction that move the tool's cell as one piece.
pub fn block_under_a_tool(degree: usize) -> (Mesh<2>, [Field<2>; 2]) {
    let block = rectangle([0.0, 0.0], [2.0, 0.6], [6, 2], CellShape::Quadrilateral, 1).unwrap();
    let points = [[-0.2, 0.9], [0.55, 0.64], [0.9, 0.58], [1.4, 0.6], [2.3, 0.75]];
    let tool = RigidSurface::along(&points).unwrap();
    let mesh = block.with_rigid_surfaces(&[("tool", &tool)]).unwrap();
    let space = Space::vector(&mesh, degree).unwrap();
    // Affine fields do.
    let u = Field::interpolate(&space, |x| [0.01 * x[1], 0.02 * x[0] - 0.01]).unwrap();
    let mut values = wave(&space, 1.0, 1.7).values().to_vec();
    let affine = |x: &[f64; 2]| [0.3 + 0.2 * x[1] - 0.1 * x[0], 0.7 - 0.5 * x[0] + 0.2 * x[1]];
    let rigid = Field::interpolate(&space, affine).unwrap();
    let carried = mesh.cell_region("tool").unwrap()[0] as usize;
    for node in space.cell_nodes(carried) {
        let first = 2 * *node as usize;
        values[first..first + 2].copy_from_slice(&rigid.values()[first..first + 2]);
    }
    let w = Field::from_values(&space, values).unwrap();
    (mesh, [u, w])
}

/// A small plate in front of a large one, both opposite to a third.
pub fn plate_before_another() -> Mesh<2> {
    let body = |low: [f64; 2], high: [f64; 2], cells: usize| {
        rectangle(low, high, [cells, 1], CellShape::Quadrilateral, 1).unwrap()
    };
    let own = body([0.0, -0.5], [3.0, 0.0], 7);
    let (far, near) = (body([0.2, 0.4], [2.8, 0.7], 5), body([0.9, 0.1], [1.7, 0.3], 3));
    let mut mesh = Mesh::clone(&Mesh::of_bodies(&[("own", &own), ("far", &far), ("near", &near)]).unwrap());
    mesh.name_facets("lids", "boundary", |x| x[1] == 0.4 || x[1] == 0.1).unwrap();
    mesh
}

/// A hairpin, and a rigid tool with kinks on a block.
#[test]
fn self_contact_and_rigid_tools() {
    let pin = hairpin();
    for degree in [1, 2] {
        let space = Space::vector(&pin, degree).unwrap();
        let (u, w) = (wave(&space, 0.02, 0.4), wave(&space, 1.0, 1.7));
        let pairing = Pairing::within("top").within_reach(0.5);
        let assembler = Assembler::new(&pin);
        let report = assembler.pairs_at(&pairing.clone().at(PairQuadrature::Pieces), 3, &u).unwrap();
        assert!(report.segments > 12 && report.paired_measure > 2.0, "{report:?}");
        let off = off_springs(&pin, &pairing, (&u, &w));
        println!("hairpin, degree {degree}: {off:.1e}");
        assert!(off < 1e-9, "{degree}: {off:e}");
        let (mesh, [u, w]) = block_under_a_tool(degree);
        let off = off_springs(&mesh, &Pairing::onto("top", "tool"), (&u, &w));
        println!("tool, degree {degree}: {off:.1e}");
        assert!(off < 1e-9, "{degree}: {off:e}");
    }
}

/// A node that ends a segment without being of what the segment sees: a plate in front of another one.
#[test]
fn a_plate_that_hides_another_one() {
    for degree in [1, 2] {
        let mesh = plate_before_another();
        let space = Space::vector(&mesh, degree).unwrap();
        let (u, w) = (wave(&space, 0.01, 0.4), wave(&space, 1.0, 1.7));
        let pairing = Pairing::onto("own top", "lids").within_reach(0.6);
        let off = off_springs(&mesh, &pairing, (&u, &w));
        println!("degree {degree}: {off:.1e}");
        assert!(off < 1e-9, "{degree}: {off:e}");
    }
}

/// Order two where opposite nodes face own ones at the start, so that segments appear, and a free end lies inside of a facet; on whole facets the
/// order is one.
#[test]
fn taylor_tests_start_where_segments_appear() {
    for (shape, degree) in
        [(CellShape::Quadrilateral, 1), (CellShape::Triangle, 1), (CellShape::Quadrilateral, 2)]
    {
        // A node of the block faces one of the layer at x = 1; its ends lie inside of facets.
        let layer = rectangle([0.0, -0.5], [3.0, 0.0], [6, 2], shape, 1).unwrap();
        let block = rectangle([0.3, 0.0], [1.7, 0.5], [4, 2], shape, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("layer", &layer), ("block", &block)]).unwrap();
        let space = Space::vector(&mesh, degree).unwrap();
        let none = Field::zero(&space);
        for pairing in pairings() {
            for (phase, method) in [0.3, 1.7].into_iter().flat_map(|phase| {
                [Method::Nitsche(0.0), Method::of_means(0.0, degree)].map(|method| (phase, method))
            }) {
                let (model, u) = layers_of(&mesh, method, &pairing, (&none, 0.0, -0.03));
                let w = wave(&space, 0.3, phase);
                let assembler = Assembler::new(&mesh);
                let [least, most] = taylor_order(&assembler, &method.form(&model), &u, &w);
                println!("{shape:?} {degree} {method:?} {pairing} {phase}: {least:.3} to {most:.3}");
                assert!(least > 1.95 && most < 2.05, "{shape:?} {degree} {method:?}: {least} {most}");
            }
        }
    }
}
