//! A round body that is drawn without friction along a periodic slab in space, over one cell of the slab: the force along, which should be zero, at
//! points, on segments, with means and with multipliers.

use forms_fem::constraints::RigidMap;
use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

#[forms(dimension = 3)]
mod elastic {
    pub use forms_contact::operators::multipliers::Own;
    use forms_contact::operators::multipliers::conditions;

    #[includes(forms_contact::operators::penalty::Data, forms_contact::operators::multipliers::Data)]
    pub struct Data {
        pub young: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    fn stress(u: Vector) -> Tensor {
        // ν = 0.3.
        young / 1.3 * (0.3 / 0.4 * div(u) * I + eps(u))
    }
    fn augmented(u: Vector) -> Scalar {
        dot(this(stress(u) * n), toward) + gamma0 / this(h) * gap
    }
    fn stored(u: Vector, v: Vector) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
    pub fn at_points(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        stored(u, v) + integral(Touch(u), neg_part(augmented(u)) * dot(toward, jump(v)))
    }
    pub fn of_facets(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        stored(u, v) + means(Touch(u), 0, neg_part(mean(augmented(u))) * mean(dot(toward, jump(v))))
    }
    pub fn by_multipliers(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        g: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        r: Test<Scalar>,
    ) -> Form {
        stored(u, v)
            + integral(Touch(u), this(p) * dot(toward, jump(v)) + gap * this(r - q))
            + conditions(p, g, q, r, gamma0 / h)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Law {
    Points,
    Segments,
    MeansAtPoints,
    MeansOnSegments,
    Multipliers,
}

/// The size of the slab's cells.
const CELL: f64 = 0.25;
/// The way down of the body's top.
const DOWN: f64 = 0.08;
/// Steps in which it is pressed.
const PRESSING: usize = 4;
/// The body's bottom.
const OWN: &str = "body bottom";

/// A slab of 8 × 6 × 2 cells and a body of 4 × 4 × 2 whose bottom is a paraboloid of the radius 2.
fn mesh() -> Mesh<3> {
    let slab = cuboid([0.0; 3], [2.0, 1.5, 0.5], [8, 6, 2], CellShape::Hexahedron, 1).unwrap();
    let body = structured([4, 4, 2], CellShape::Hexahedron, 1, |[s, t, r]| {
        let (x, y) = (1.0 + 1.1 * (s - 0.5), 0.75 + 1.1 * (t - 0.5));
        let bottom = 0.5 + ((x - 1.0).powi(2) + (y - 0.75).powi(2)) / 4.0;
        [x, y, bottom + r * (1.1 - bottom)]
    });
    Mesh::of_bodies(&[("slab", &slab), ("body", &body.unwrap())]).unwrap()
}

/// Half of the range of F_x/F_z while the body moves by one cell of the slab, and of F_z as a part of its mean. None where Newton's method
/// failed, as with many conditions at points.
fn wobble(law: Law, gamma0: f64, positions: usize) -> Option<[f64; 2]> {
    let mesh = mesh();
    let space = Space::vector(&mesh, 1).unwrap();
    let traces = Space::on_facets(&mesh, OWN, 1).unwrap();
    let moduli = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let moduli = Field::interpolate(&moduli, |x: &[f64; 3]| if x[2] > 0.5 { 3.0 } else { 1.0 }).unwrap();
    let places = match law {
        Law::Points | Law::MeansAtPoints => PairQuadrature::WholeFacets,
        _ => PairQuadrature::Pieces,
    };
    let touch = Pairing::onto(OWN, "slab top").within_reach(0.5).at(places);
    let data = elastic::data().gamma0(gamma0).young(&moduli);
    let model = elastic::Model { data, regions: elastic::Regions::default().touch(touch).own(OWN) };
    let mut u = Field::zero(&space);
    let [mut p, mut g] = [Field::zero(&traces), Field::zero(&traces)];
    let options = NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
    let (mut ratios, mut across) = (vec![], vec![]);
    let pressing = (1..PRESSING).map(|step| (0.0, DOWN * step as f64 / PRESSING as f64));
    let drawing = (0..positions).map(|position| (CELL * position as f64 / positions as f64, DOWN));
    for (aside, down) in pressing.chain(drawing) {
        let mut held = Constraints::new(&space);
        held.fix("slab bottom", |_| [0.0; 3]).unwrap();
        held.fix("body top", |_| [aside, 0.0, -down]).unwrap();
        held.periodic("slab left", "slab right", &RigidMap::translation([2.0, 0.0, 0.0])).unwrap();
        let force = if law == Law::Multipliers {
            let form = model.by_multipliers();
            let problem = Problem::new(&form, [&space, &traces, &traces]).constrained(&held);
            let solved = problem.start([&u, &p, &g]).solve().ok()?;
            let force = solved.reaction_of(0, "body top").unwrap();
            [u, p, g] = solved.fields;
            force
        } else {
            let is_mean = matches!(law, Law::MeansAtPoints | Law::MeansOnSegments);
            let form = if is_mean { model.of_facets() } else { model.at_points() };
            let problem = Problem::new(&form, &space).constrained(&held).options(options.clone());
            let solved = problem.start(&u).solve().ok()?;
            let force = solved.reaction("body top").unwrap();
            u = solved.into_field();
            force
        };
        if down == DOWN {
            ratios.push(force[0] / force[2]);
            across.push(force[2]);
        }
    }
    let half = |values: &[f64]| {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        0.5 * (most - least)
    };
    let mean = across.iter().sum::<f64>() / across.len() as f64;
    Some([half(&ratios), half(&across) / mean.abs()])
}

#[test]
fn a_round_body_is_drawn_along_a_slab() {
    println!("| law | γ₀ | F_x/F_z | F_z |");
    let positions = if std::env::var_os("FORMS_SWEEPS").is_some() { 16 } else { 4 };
    for gamma0 in [9.0, 60.0] {
        let laws = [Law::Points, Law::Segments, Law::MeansAtPoints, Law::MeansOnSegments, Law::Multipliers];
        let found = laws.map(|law| {
            let found = wobble(law, gamma0, positions);
            match found {
                Some([along, across]) => println!("| {law:?} | {gamma0} | {along:.1e} | {across:.1e} |"),
                None => println!("| {law:?} | {gamma0} | no solution | |"),
            }
            found.map(|[along, _]| along)
        });
        let [points, means, multipliers] = [0, 3, 4].map(|law| found[law].expect("solved"));
        assert!(means < 0.5 * points && multipliers < 0.5 * points, "{gamma0}: {found:?}");
    }
}
