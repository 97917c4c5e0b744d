//! Friction by multipliers in space: patches that are pressed and sheared, a block that is drawn across a slab, balance and tangents.

use forms_contact::laws::mortar_bodies::mortar_bodies_with_friction as law;
use forms_contact::laws::mortar_bodies::{data, frictional_mortar_problem};
use forms_contact::multiplier_nodes::MultiplierError;
use forms_fem::contract::PairQuadrature;
use forms_fem::prelude::*;

use crate::exact::{check_tangent, multipliers, resultants};
use crate::patch::{LAMBDA, MU};

/// Cells, and the degree of displacements and multipliers.
const CASES: [(CellShape, usize); 4] = [
    (CellShape::Tetrahedron, 1),
    (CellShape::Hexahedron, 1),
    (CellShape::Tetrahedron, 2),
    (CellShape::Hexahedron, 2),
];
const OWN: &str = "block bottom";

/// The axis of the multipliers, which is not the normal of the block's bottom.
const AXIS: [f64; 3] = [0.6, 0.0, -0.8];

fn model(base: law::Data<3>, loaded: &str) -> law::Model<3> {
    model_at(PairQuadrature::Pieces, base, loaded)
}

fn model_at(places: PairQuadrature, base: law::Data<3>, loaded: &str) -> law::Model<3> {
    let touch = Pairing::onto(OWN, "slab top").at(places);
    let regions = law::Regions::default().touch(touch).own(OWN).gamma_n(loaded);
    law::Model { data: base.axis(AXIS), regions }
}

fn options() -> NewtonOptions {
    NewtonOptions {
        relative_tolerance: 1e-12,
        line_search: LineSearch::OnResidual,
        ..NewtonOptions::default()
    }
}

/// p and t of a node's multiplier.
fn parts(m: &[f64]) -> (f64, [f64; 3]) {
    let p = (0..3).map(|k| AXIS[k] * m[k]).sum::<f64>();
    (p, std::array::from_fn(|k| m[k] - p * AXIS[k]))
}

fn size(a: [f64; 3]) -> f64 {
    a.iter().map(|a| a * a).sum::<f64>().sqrt()
}

/// Slab and block of the same width, with other cells, in one uniform state of pressure and shear: the multipliers are uniform, and nothing slips.
#[test]
fn pressure_and_shear_are_uniform() {
    let (shear, stretch) = (0.02, 0.98_f64);
    let log = LAMBDA * stretch.ln();
    let pressure = MU * (1.0 / stretch - stretch) - log / stretch;
    let body = |from: f64, cells: [usize; 3], shape| {
        cuboid([0.0, 0.0, from], [1.0, 1.0, from + 0.5], cells, shape, 1).unwrap()
    };
    for (shape, degree) in CASES {
        let (slab, block) = (body(-0.5, [3, 2, 1], shape), body(0.0, [2, 3, 1], shape));
        let mut mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap();
        let is_side = |x: &[f64; 3]| (0..2).any(|k| x[k] < 1e-9 || x[k] > 1.0 - 1e-9);
        mesh.name_facets("sides", "boundary", is_side).unwrap();
        let space = Space::vector(&mesh, degree).unwrap();
        let traces = multipliers(&mesh, OWN, degree, &[3]);
        let exact = |x: &[f64; 3]| [shear * (x[2] + 0.5), 0.0, (stretch - 1.0) * (x[2] + 0.5)];
        let traction = move |x: &[f64; 3]| {
            let sign = |x: f64| if x < 1e-9 { -1.0 } else { f64::from(x > 1.0 - 1e-9) };
            let (along, across) = (sign(x[0]), sign(x[1]));
            [along * log, across * log, along * shear / stretch * (MU - log)]
        };
        let mut held = Constraints::new(&space);
        held.fix("slab bottom", exact).unwrap();
        held.fix("block top", exact).unwrap();
        let before = Field::interpolate(&space, exact).unwrap();
        let base = data().lambda(LAMBDA).mu(MU).gamma0(1000.0).friction(1.0);
        let model = model(base.displacement_before(Given::field(&before)).traction(traction), "sides");
        let start = Field::interpolate(&traces, |_| AXIS.map(|a| 0.8 * pressure * a)).unwrap();
        let (none, touching) = (Field::zero(&space), Field::zero(&traces));
        let solved = frictional_mortar_problem(&model, [&space, &traces], &held)
            .unwrap()
            .options(options())
            .start([&none, &start, &touching])
            .solve()
            .unwrap();
        let [u, m, _] = &solved.fields;
        let off = u.values().iter().zip(before.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let of_node = |m: &[f64]| {
            let (p, t) = parts(m);
            (p - pressure).abs().max((size(t) - MU * shear).abs()) / pressure
        };
        let multipliers = m.values().chunks_exact(3).map(of_node).fold(0.0, f64::max);
        println!(
            "{shape:?} {degree}: displacement {off:.1e}, multipliers {multipliers:.1e}, {} steps",
            solved.iterations()
        );
        assert!(off < 1e-12 && multipliers < 1e-10, "{shape:?} {degree}: {off:e} {multipliers:e}");
    }
}

/// Bodies at small strains, σ = ε, whose surfaces do not move along each other.
#[forms(dimension = 3)]
mod resting {
    pub use forms_contact::operators::multipliers::Own;
    use forms_contact::operators::multipliers::conditions;

    #[includes(forms_contact::operators::penalty::Data, forms_contact::operators::multipliers::Data)]
    pub struct Data {}
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    pub fn balance(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        g: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        r: Test<Scalar>,
    ) -> Form {
        integral(Omega, inner(eps(u), eps(v)))
            + integral(Touch, this(p) * dot(toward, jump(v)) + (gap - dot(toward, jump(u))) * this(r - q))
            + conditions(p, g, q, r, gamma0 / h)
    }
}

/// Surfaces of degree 2 that do not match, cut into pieces: a uniform pressure.
#[test]
fn pressure_of_degree_two_is_uniform() {
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        let body =
            |from: f64, cells| cuboid([0.0, 0.0, from], [1.0, 1.0, from + 0.5], cells, shape, 1).unwrap();
        let (slab, block) = (body(-0.5, [3, 2, 1]), body(0.0, [2, 3, 1]));
        let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap();
        let space = Space::vector(&mesh, 2).unwrap();
        let traces = multipliers(&mesh, OWN, 2, &[]);
        let mut held = Constraints::new(&space);
        held.fix("slab bottom", |_| [0.0; 3]).unwrap();
        held.fix("block top", |_| [0.0, 0.0, -0.1]).unwrap();
        for (side, axis) in [("left", 0), ("right", 0), ("front", 1), ("back", 1)] {
            held.fix_component(&format!("slab {side}"), axis, |_| 0.0).unwrap();
            held.fix_component(&format!("block {side}"), axis, |_| 0.0).unwrap();
        }
        let model = resting::Model {
            data: resting::data().gamma0(10.0),
            regions: resting::Regions::default().touch(Pairing::onto(OWN, "slab top")).own(OWN),
        };
        let form = model.balance();
        let start =
            [Field::zero(&space), Field::interpolate(&traces, |_| 0.01).unwrap(), Field::zero(&traces)];
        let problem = Problem::new(&form, [&space, &traces, &traces]).constrained(&held);
        let [_, p, _] = problem.start(start.each_ref()).solve().unwrap().fields;
        let off = p.values().iter().map(|p| (p / 0.1 - 1.0).abs()).fold(0.0, f64::max);
        println!("{shape:?}, degree 2: {off:.1e}");
        assert!(off < 1e-11, "{shape:?}: {off:e}");
    }
}

fn bodies(shape: CellShape) -> Mesh<3> {
    let slab = cuboid([0.0, 0.0, -0.4], [2.0, 1.6, 0.0], [4, 3, 1], shape, 1).unwrap();
    let block = cuboid([0.23, 0.17, 0.0], [1.13, 0.97, 0.5], [2, 2, 1], shape, 1).unwrap();
    Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap()
}

/// A block is drawn across a rigid slab: |t| = κ p at each node, against its slip.
#[test]
fn friction_is_that_of_coulomb_at_each_node() {
    let (friction, way) = (0.3, [0.5, 0.3]);
    for (shape, degree) in CASES {
        let mesh = bodies(shape);
        let space = Space::vector(&mesh, degree).unwrap();
        let traces = multipliers(&mesh, OWN, degree, &[3]);
        let mut u = Field::zero(&space);
        let mut m = Field::interpolate(&traces, |_| AXIS.map(|a| 5.0 * a)).unwrap();
        let mut d = Field::zero(&traces);
        let (mut force, mut steps) = ([0.0; 3], 0);
        // An iterate bends hexahedra of degree two so much that they are folded as the slab sees them.
        let places = match (shape, degree) {
            (CellShape::Hexahedron, 2) => PairQuadrature::WholeFacets,
            _ => PairQuadrature::Pieces,
        };
        for step in 0..=3 {
            let part = f64::from(step) / 3.0;
            let mut held = Constraints::new(&space);
            held.fix("slab", |_| [0.0; 3]).unwrap();
            held.fix("block top", |_| [part * way[0], part * way[1], -0.03]).unwrap();
            let base = data().lambda(LAMBDA).mu(MU).gamma0(1000.0).friction(friction);
            let base = base.displacement_before(Given::field(&u));
            let along = |k: usize| Given::constant(std::array::from_fn(|axis| f64::from(axis == k)));
            let solved = frictional_mortar_problem(
                &model_at(places, base.clone(), "block right"),
                [&space, &traces],
                &held,
            )
            .unwrap()
            .options(options())
            .start([&u, &m, &d])
            .solve()
            .unwrap_or_else(|error| panic!("{shape:?} {degree}, step {step}: {error}"));
            steps += solved.iterations();
            [u, m, d] = solved.fields;
            let assembler = Assembler::new(&mesh);
            force = std::array::from_fn(|k| {
                let model = model_at(places, base.clone().force_direction(along(k)), "block right");
                assembler.functional(&model.contact_force(&u, &m)).unwrap()
            });
        }
        let largest = m.values().chunks_exact(3).map(|m| parts(m).0).fold(0.0, f64::max);
        let mut covered = 0;
        for (m, d) in m.values().chunks_exact(3).zip(d.values().chunks_exact(3)) {
            let ((p, t), (_, slip)) = (parts(m), parts(d));
            let against = size(std::array::from_fn(|k| t[k] + friction * p * slip[k] / size(slip)));
            assert!((size(t) - friction * p).abs() < 1e-9 * largest, "{shape:?}: {p} {t:?}");
            assert!(p <= 1e-9 * largest || against < 1e-9 * largest, "{shape:?}: {t:?} {slip:?}");
            covered += usize::from(p > 1e-9 * largest);
        }
        println!("{shape:?} {degree}: {force:?}, {covered} nodes press, {steps} steps");
        assert!(covered > 3, "{shape:?}: {covered}");
        // Normals of lifted ends are not upright, and the block turns a little against the way.
        let across = (force[0] * way[1] - force[1] * way[0]).abs() / size([way[0], way[1], 0.0]);
        let along = force[0].hypot(force[1]) / (friction * force[2]);
        assert!(across < 0.05 * force[2] && (along - 1.0).abs() < 2e-2, "{shape:?}: {force:?}");
    }
}

/// Bent surfaces: forces cancel to rounding, and the tangent has the motion of the polygons and of the turned axes.
#[test]
fn forces_balance_and_tangents_are_exact() {
    for (shape, degree) in CASES {
        let mesh = bodies(shape);
        let space = Space::vector(&mesh, degree).unwrap();
        let traces = multipliers(&mesh, OWN, degree, &[3]);
        let bent = |phase: f64| {
            let value = |x: &[f64; 3]| -> [f64; 3] {
                let up = 0.02 * (x[0] * x[1] + phase).sin();
                [0.02 * (x[1] + phase).sin(), 0.02 * (2.0 * x[0] + phase).cos(), up]
            };
            Field::interpolate(&space, value).unwrap()
        };
        let nodal = |phase: f64| {
            let value = |x: &[f64; 3]| -> [f64; 3] {
                let pressed = 2.0 + (4.0 * x[0] + x[1] + phase).sin();
                let across = [(3.0 * x[1] + phase).cos(), (2.0 * x[0] + phase).sin(), 0.0];
                std::array::from_fn(|k| pressed * AXIS[k] + across[k])
            };
            Field::interpolate(&traces, value).unwrap()
        };
        let base = data().lambda(1.0).mu(1.0).gamma0(30.0).friction(0.4);
        let form = model(base.displacement_before(Given::field(bent(0.1))), "block right").direct();
        let at = [&bent(0.3), &nodal(0.0), &nodal(1.7)];
        let [force, _] = resultants(&form, at);
        assert!(force < 1e-13, "{shape:?} {degree}: {force:e}");
        check_tangent(&form, at, [&bent(1.1), &nodal(0.7), &nodal(2.9)], &format!("{shape:?} {degree}"));
    }
}

#[test]
fn an_axis_into_the_own_body_is_refused() {
    let mesh = bodies(CellShape::Tetrahedron);
    let space = Space::vector(&mesh, 1).unwrap();
    let traces = Space::vector_on_facets(&mesh, OWN, 1).unwrap();
    let mut model = model(data().lambda(1.0).mu(1.0).gamma0(30.0), "block right");
    model.data.axis = [0.1_f64.sin(), 0.0, 0.1_f64.cos()];
    let held = Constraints::new(&space);
    let Err(found) = frictional_mortar_problem(&model, [&space, &traces], &held) else {
        panic!("it is refused")
    };
    assert!(matches!(&found, MultiplierError::OppositeAxis { own, .. } if own == OWN), "{found}");
}
