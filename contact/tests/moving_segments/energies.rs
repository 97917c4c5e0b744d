//! Energies over moving segments in the plane: residuals are the gradients of what is assembled, tangents its second derivatives.

use forms_fem::contract::PairQuadrature;
use forms_fem::linear_algebra::CsrMatrix;
use forms_fem::prelude::*;
use forms_fem::threads::Threads;

use crate::balance::{bent, plates};
use crate::tangent::{
    block_under_a_tool, hairpin, off_differences, plate_before_another, taylor_order, wave,
};

#[forms(dimension = 2)]
mod stored {
    pub struct Data {
        #[default(7)]
        gamma: Param,
        #[default(0.6)]
        kappa: Param,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    fn density(u: Vector) -> Scalar {
        gamma / 2 * sqr(gap)
            + kappa * this(dot(u, u)) * other(dot(u, u))
            + kappa * gap * this(inner(grad(u), grad(u)) + dot(n, u) * dot(x, x))
            + gamma * exp(dot(toward, jump(u)))
    }
    pub fn springs(u: Unknown<Vector>) -> Energy {
        integral(Touch(u), gamma / 2 * sqr(gap))
    }
    /// Reads fields on both sides, gradients, normals and positions.
    pub fn all(u: Unknown<Vector>) -> Energy {
        integral(Touch(u), density(u))
    }
    /// The covered length, whose gradient comes only from the motion of the points.
    pub fn covered(u: Unknown<Vector>) -> Energy {
        integral(Touch(u), kappa)
    }
    pub fn penalty(u: Unknown<Vector>) -> Energy {
        integral(Touch(u), gamma / 2 * sqr(neg_part(gap)))
    }
    /// The same as a form: points are held in the force.
    pub fn held(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(penalty(u), u, v)
    }
    pub fn held_springs(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(springs(u), u, v)
    }
    /// With a second unknown at the own points, and cells.
    pub fn pressed(u: Unknown<Vector>, p: Unknown<Scalar>) -> Energy {
        integral(Touch(u), this(p) * gap - kappa / 2 * this(sqr(p)) + gamma / 4 * sqr(sqr(gap)))
            + integral(Omega, kappa / 2 * (inner(grad(u), grad(u)) + dot(grad(p), grad(p))))
    }
    pub fn bodies(u: Unknown<Vector>) -> Energy {
        integral(Omega, 10 * inner(sym(grad(u)), sym(grad(u)))) + integral(Touch(u), 500 * sqr(neg_part(gap)))
    }
}

fn model(pairing: &Pairing) -> stored::Model<2> {
    let regions = stored::Regions::default().touch(pairing.clone().at(PairQuadrature::Pieces));
    stored::Model { data: stored::data(), regions: regions.omega("all") }
}

fn moved(u: &Field<2>, w: &Field<2>, t: f64) -> Field<2> {
    let values = u.values().iter().zip(w.values()).map(|(u, w)| u + t * w).collect();
    Field::from_values(u.space(), values).unwrap()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, f64::max)
}

/// The difference of a gradient along a direction and that of fourth order of the energy, as a part of its terms' sizes.
fn off_gradient(assembler: &Assembler<2>, energy: &Energy<2>, (u, w): (&Field<2>, &Field<2>), h: f64) -> f64 {
    let at = |t: f64| assembler.energy(energy, &[&moved(u, w, t)]).unwrap();
    let gradient = assembler.residual(&energy.to_form(), &[u], &[u.space()]).unwrap();
    let terms = || gradient.iter().zip(w.values()).map(|(a, b)| a * b);
    let difference = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
    let size = terms().map(f64::abs).sum::<f64>();
    (terms().sum::<f64>() - difference).abs() / size
}

/// The largest difference of entries across the diagonal, as a part of the largest entry.
fn asymmetry(matrix: &CsrMatrix) -> f64 {
    let entries = |row: usize| {
        let (columns, values) = matrix.row(row);
        columns.iter().zip(values).map(move |(column, value)| (*column as usize, *value))
    };
    let all =
        || (0..matrix.rows()).flat_map(|row| entries(row).map(move |(column, value)| (row, column, value)));
    let off = largest(all().map(|(row, column, value)| value - matrix.get(column, row)));
    off / largest(all().map(|(.., value)| value))
}

fn energy_forces(assembler: &Assembler<2>, energy: &Energy<2>, u: &Field<2>) -> impl Iterator<Item = f64> {
    assembler.residual(&energy.to_form(), &[u], &[u.space()]).unwrap().into_iter()
}

/// Gradient, tangent and symmetry of energies at a state, along a direction.
fn check(
    name: &str,
    assembler: &Assembler<2>,
    energies: &[(&str, Energy<2>)],
    along: (&Field<2>, &Field<2>),
) {
    for (energy_name, energy) in energies {
        assert!(
            largest(energy_forces(assembler, energy, along.0)) > 1e-3,
            "{name} {energy_name}: nothing touches"
        );
        let (form, space) = (energy.to_form(), along.0.space());
        let gradient = off_gradient(assembler, energy, along, 2e-4);
        let tangent = off_differences(assembler, &form, along, 2e-4);
        let asymmetry = asymmetry(&assembler.tangent(&form, &[along.0], &[space]).unwrap());
        println!(
            "{name} {energy_name}: gradient {gradient:.1e}, tangent {tangent:.1e}, symmetric {asymmetry:.1e}"
        );
        assert!(gradient < 1e-9 && tangent < 1e-9 && asymmetry < 1e-13, "{name} {energy_name}");
    }
}

/// Those whose forces do not vanish: an own surface that is covered as a whole has a covered length that stays.
fn energies_of(pairing: &Pairing, cover: Cover) -> Vec<(&'static str, Energy<2>)> {
    let model = model(pairing);
    let mut energies = vec![("springs", model.springs()), ("all", model.all())];
    energies.extend((cover == Cover::Part).then(|| ("covered", model.covered())));
    energies
}

/// The part of an own surface that is covered.
#[derive(Clone, Copy, PartialEq)]
enum Cover {
    Part,
    Whole,
}

trait ToForm {
    fn to_form(&self) -> Form<2>;
}

impl ToForm for Energy<2> {
    fn to_form(&self) -> Form<2> {
        self.into()
    }
}

fn pairings_of(lower: &str, upper: &str) -> [Pairing; 3] {
    [Pairing::between(lower, upper), Pairing::onto(lower, upper), Pairing::onto(upper, lower)]
}

/// Bent plates with free ends inside of facets, for all kinds of facets, one surface or both.
#[test]
fn residuals_and_tangents_are_derivatives_of_the_energy() {
    for (shape, geometry, degree) in [
        (CellShape::Quadrilateral, 1, 1),
        (CellShape::Triangle, 1, 1),
        (CellShape::Quadrilateral, 1, 2),
        (CellShape::Triangle, 2, 2),
        (CellShape::Quadrilateral, 2, 2),
    ] {
        let mesh = plates(shape, geometry, [7, 9]);
        let space = Space::vector(&mesh, degree).unwrap();
        let pairings = pairings_of("lower top", "upper bottom");
        for (pairing, cover) in pairings.into_iter().zip([Cover::Part, Cover::Part, Cover::Whole]) {
            let (u, w) = (bent(&space, 0.2), wave(&space, 1.0, 0.9));
            for assembler in
                [Assembler::new(&mesh), Assembler::new(&mesh).with_quadrature(Quadrature::Degree(7))]
            {
                let name = format!("{shape:?} {geometry} {degree} {pairing}");
                check(&name, &assembler, &energies_of(&pairing, cover), (&u, &w));
                // On curved own facets the length of an element is no polynomial, and the rule's length depends on the cuts.
                if cover == Cover::Whole && geometry == 1 {
                    let rest = largest(energy_forces(&assembler, &model(&pairing).covered(), &u));
                    assert!(rest < 1e-13, "{name}: {rest:e}");
                }
            }
        }
    }
}

/// A hairpin that touches itself, a rigid tool with kinks, and a plate that hides a part of another one.
#[test]
fn self_contact_tools_and_hidden_plates() {
    for degree in [1, 2] {
        let pin = hairpin();
        let space = Space::vector(&pin, degree).unwrap();
        let (u, w) = (wave(&space, 0.02, 0.4), wave(&space, 1.0, 1.7));
        let pairing = Pairing::within("top").within_reach(0.5);
        check(
            &format!("hairpin {degree}"),
            &Assembler::new(&pin),
            &energies_of(&pairing, Cover::Part),
            (&u, &w),
        );

        let (mesh, [u, w]) = block_under_a_tool(degree);
        let energies = energies_of(&Pairing::onto("top", "tool"), Cover::Whole);
        check(&format!("tool {degree}"), &Assembler::new(&mesh), &energies, (&u, &w));

        let mesh = plate_before_another();
        let space = Space::vector(&mesh, degree).unwrap();
        let (u, w) = (wave(&space, 0.01, 0.4), wave(&space, 1.0, 1.7));
        let energies = energies_of(&Pairing::onto("own top", "lids").within_reach(0.6), Cover::Part);
        check(&format!("hidden {degree}"), &Assembler::new(&mesh), &energies, (&u, &w));
    }
}

/// Sums: the motion of the points completes the part of the energy only, since the force of the form is no gradient.
#[test]
fn sums_of_energies_and_forms() {
    let mesh = plates(CellShape::Quadrilateral, 1, [7, 9]);
    let space = Space::vector(&mesh, 2).unwrap();
    let model = model(&Pairing::between("lower top", "upper bottom"));
    let (u, w) = (bent(&space, 0.2), wave(&space, 1.0, 0.9));
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(7));
    let sum: Form<2> = &(0.7 * &model.springs().to_form()) + &model.held_springs();
    let off = off_differences(&assembler, &sum, (&u, &w), 2e-4);
    let asymmetry = asymmetry(&assembler.tangent(&sum, &[&u], &[&space]).unwrap());
    println!("{off:.1e}, asymmetry {asymmetry:.1e}");
    assert!(off < 1e-9 && asymmetry > 1e-3, "{off:e} {asymmetry:e}");
}

/// Matrices are the same to the last bit on any number of threads.
#[test]
fn threads_leave_the_bits() {
    let mesh = plates(CellShape::Quadrilateral, 1, [150, 190]);
    let space = Space::vector(&mesh, 1).unwrap();
    let form = model(&Pairing::between("lower top", "upper bottom")).all().to_form();
    let u = bent(&space, 0.2);
    let on = |count: usize| {
        let assembler = Assembler::new(&mesh).with_threads(Threads::new(count));
        let tangent = assembler.tangent(&form, &[&u], &[&space]).unwrap();
        (tangent.into_values(), assembler.residual(&form, &[&u], &[&space]).unwrap())
    };
    let one = on(1);
    assert!([2, 3].into_iter().all(|count| on(count) == one));
}

/// Couplings of the displacement with another unknown, both ways.
#[test]
fn energies_of_two_unknowns() {
    for degree in [1, 2] {
        let mesh = plates(CellShape::Quadrilateral, 1, [7, 9]);
        let (space, scalars) = (Space::vector(&mesh, degree).unwrap(), Space::scalar(&mesh, 1).unwrap());
        let tests = [&space, &scalars];
        let energy = model(&Pairing::between("lower top", "upper bottom")).pressed();
        let form = energy.to_form();
        let assembler = Assembler::new(&mesh);
        let (u, w) = (bent(&space, 0.2), wave(&space, 1.0, 0.9));
        let p = Field::interpolate(&scalars, |x| (3.0 * x[0]).sin()).unwrap();
        let q = Field::interpolate(&scalars, |x| (2.0 * x[0] + x[1]).cos()).unwrap();
        let along = |t: f64| [moved(&u, &w, t), moved(&p, &q, t)];
        let direction: Vec<f64> = w.values().iter().chain(q.values()).copied().collect();
        let h = 2e-4;
        let four =
            |at: &dyn Fn(f64) -> f64| (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
        let residual = |t: f64| {
            let [u, p] = along(t);
            assembler.residual(&form, &[&u, &p], &tests).unwrap()
        };
        let value = |t: f64| {
            let [u, p] = along(t);
            assembler.energy(&energy, &[&u, &p]).unwrap()
        };
        let terms: Vec<f64> = residual(0.0).iter().zip(&direction).map(|(a, b)| a * b).collect();
        let size: f64 = terms.iter().map(|term| term.abs()).sum();
        let gradient = (terms.iter().sum::<f64>() - four(&value)).abs() / size;
        let tangent = assembler.tangent(&form, &[&u, &p], &tests).unwrap();
        let product = tangent.multiply(&direction).unwrap();
        let sides = [h, -h, 2.0 * h, -2.0 * h].map(residual);
        let difference =
            |k: usize| (8.0 * (sides[0][k] - sides[1][k]) - (sides[2][k] - sides[3][k])) / (12.0 * h);
        let off = largest((0..product.len()).map(|k| product[k] - difference(k)))
            / largest(product.iter().copied());
        let asymmetry = asymmetry(&tangent);
        println!("degree {degree}: gradient {gradient:.1e}, tangent {off:.1e}, symmetric {asymmetry:.1e}");
        assert!(gradient < 1e-9 && off < 1e-9 && asymmetry < 1e-13, "{degree}");
    }
}

/// Orders from a start at which segments appear, with free ends inside of facets: two of the gradient, three with the second derivatives.
#[test]
fn taylor_tests_start_where_segments_appear() {
    for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
        let layer = rectangle([0.0, -0.5], [3.0, 0.0], [6, 2], shape, 1).unwrap();
        let block = rectangle([0.3, 0.03], [1.7, 0.53], [4, 2], shape, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("layer", &layer), ("block", &block)]).unwrap();
        let (space, assembler) = (Space::vector(&mesh, 1).unwrap(), Assembler::new(&mesh));
        let energy = model(&Pairing::onto("layer top", "block bottom")).springs();
        let form = energy.to_form();
        let u = Field::zero(&space);
        for phase in [0.3, 1.7, 2.9] {
            let w = wave(&space, 0.3, phase);
            let product = |a: &[f64]| a.iter().zip(w.values()).map(|(a, b)| a * b).sum::<f64>();
            let at = |t: f64| assembler.energy(&energy, &[&moved(&u, &w, t)]).unwrap();
            let slope = product(&assembler.residual(&form, &[&u], &[&space]).unwrap());
            let tangent = assembler.tangent(&form, &[&u], &[&space]).unwrap();
            let bend = product(&tangent.multiply(w.values()).unwrap());
            let order = |with: f64| -> Vec<f64> {
                let rest = |t: f64| (at(t) - at(0.0) - t * slope - with * 0.5 * t * t * bend).abs();
                let rests: Vec<f64> = (0..4).map(|k| rest(0.01 * 0.5_f64.powi(k))).collect();
                rests.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
            };
            let (first, second) = (order(0.0), order(1.0));
            let [least, most] = taylor_order(&assembler, &form, &u, &w);
            println!("{shape:?} {phase}: {first:.3?} {second:.3?}, of the residual {least:.3} to {most:.3}");
            assert!(first.iter().all(|order| (order - 2.0).abs() < 0.05), "{first:?}");
            assert!(second.iter().all(|order| (order - 3.0).abs() < 0.05), "{second:?}");
        }
    }
}

/// Between flat surfaces that cover each other the points' motion does no work: the force is that of the form, and so is the tangent.
#[test]
fn forces_of_flat_contact_are_those_of_the_form() {
    for degree in [1, 2] {
        let layer = rectangle([0.0, -0.5], [3.0, 0.0], [5, 2], CellShape::Quadrilateral, 1).unwrap();
        let block = rectangle([0.37, -0.02], [2.1, 0.48], [4, 2], CellShape::Quadrilateral, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("layer", &layer), ("block", &block)]).unwrap();
        let space = Space::vector(&mesh, degree).unwrap();
        let law = model(&Pairing::onto("block bottom", "layer top"));
        let (assembler, u) = (Assembler::new(&mesh), Field::zero(&space));
        let [energy, form] = [law.penalty().to_form(), law.held()]
            .map(|form| assembler.residual(&form, &[&u], &[&space]).unwrap());
        let off = largest(energy.iter().zip(&form).map(|(a, b)| a - b)) / largest(form.iter().copied());
        println!("degree {degree}: {off:.1e}");
        assert!(off < 1e-13, "{degree}: {off:e}");
    }
}

/// Newton's method for bodies in contact whose whole potential is assembled converges quadratically to its stationary point.
#[test]
fn newton_finds_the_stationary_point() {
    let layer = rectangle([0.0, -0.5], [3.0, 0.0], [7, 3], CellShape::Quadrilateral, 1).unwrap();
    let block = rectangle([0.33, 0.0], [1.9, 0.5], [4, 2], CellShape::Quadrilateral, 1).unwrap();
    let mesh = Mesh::of_bodies(&[("layer", &layer), ("block", &block)]).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("layer bottom", |_| [0.0; 2]).unwrap();
    held.fix("block top", |_| [0.02, -0.05]).unwrap();
    let energy = model(&Pairing::onto("layer top", "block bottom")).bodies();
    let solved = Problem::new(&energy, &space).constrained(&held).solve().unwrap();
    let (assembler, u) = (Assembler::new(&mesh), solved.field());
    // No neighbour with the same prescribed values has a lower energy, to second order.
    let w = wave(&space, 1.0, 0.4);
    let fixed = |x: &[f64; 2]| (x[1] + 0.5) * (0.5 - x[1]);
    let shape = Field::interpolate(&space, |x| [fixed(x); 2]).unwrap();
    let values = w.values().iter().zip(shape.values()).map(|(w, s)| w * s).collect();
    let w = Field::from_values(&space, values).unwrap();
    let at = |t: f64| assembler.energy(&energy, &[&moved(u, &w, t)]).unwrap();
    let (h, start) = (1e-4, at(0.0));
    let slope = (at(h) - at(-h)) / (2.0 * h);
    let bend = (at(h) - 2.0 * start + at(-h)) / (h * h);
    println!("slope {slope:.1e}, bend {bend:.1e}, energy {start:.3}");
    assert!(slope.abs() < 1e-8 * bend && bend > 0.0, "{slope} {bend}");
}
