//! A round block that is drawn without friction along a periodic slab by one cell of the slab: the force along, which should be zero, as a part of
//! the force across.

use forms_fem::constraints::RigidMap;
use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

/// Small strains, ν = 0.3, with the multipliers of the library.
#[forms(dimension = 2)]
pub mod elastic {
    pub use forms_contact::operators::multipliers::Own;
    use forms_contact::operators::multipliers::conditions;

    #[includes(forms_contact::operators::penalty::Data, forms_contact::operators::multipliers::Data)]
    pub struct Data {
        pub young: Given<Scalar>,
        #[default(0)]
        pub inner_pressure: Param,
        /// Springs that hold what nothing else holds \[stress per length\].
        #[default(0)]
        pub soft: Param,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;
    #[facets]
    pub struct Inside;

    fn stress(u: Vector) -> Tensor {
        young / 1.3 * (0.3 / 0.4 * div(u) * I + eps(u))
    }
    pub fn balance(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        g: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        r: Test<Scalar>,
    ) -> Form {
        integral(Omega, inner(stress(u), eps(v)) + soft * dot(u, v))
            + integral(Inside, inner_pressure * dot(n, v))
            + integral(Touch(u), this(p) * dot(toward, jump(v)) + gap * this(r - q))
            + conditions(p, g, q, r, gamma0 / h)
    }
    pub fn force(u: State<Vector>, p: State<Scalar>) -> Functional {
        integral(Touch(u), this(p))
    }
    pub fn torque(u: State<Vector>, p: State<Scalar>) -> Functional {
        integral(Touch(u), this(p) * across(this(x + u), toward))
    }
    pub fn length(u: State<Vector>) -> Functional {
        integral(Touch(u), 1)
    }
    fn across(a: Vector, b: Vector) -> Scalar {
        a[0] * b[1] - a[1] * b[0]
    }
}

/// A slab of 24 cells of the size ¼, and a block of 7 cells with a round lower side.
fn mesh() -> Mesh<2> {
    let slab = rectangle([0.0, 0.0], [6.0, 1.0], [24, 4], CellShape::Quadrilateral, 1).unwrap();
    let block = structured([7, 4], CellShape::Quadrilateral, 1, |[s, t]| {
        let x = 3.0 + 1.75 * (s - 0.5);
        let bottom = 1.0 + (x - 3.0).powi(2) / 4.0;
        [x, bottom + t * (2.0 - bottom)]
    });
    Mesh::of_bodies(&[("slab", &slab), ("block", &block.unwrap())]).unwrap()
}

/// Half of the range of F_x/F_y, and of F_y as a part of its mean, while the block moves by one cell of the slab.
fn wobble(
    (degree, of_multipliers): (usize, &Elements),
    own: &str,
    gamma0: f64,
    positions: usize,
) -> Option<[f64; 2]> {
    let mesh = mesh();
    let space = Space::vector(&mesh, degree).unwrap();
    let traces = Space::of(&mesh, of_multipliers.clone(), Scope::Facets(own.to_owned()), &[]).unwrap();
    let moduli = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let moduli = Field::interpolate(&moduli, |x: &[f64; 2]| if x[1] > 1.0 { 3.0 } else { 1.0 }).unwrap();
    let opposite = if own == "slab top" { "block bottom" } else { "slab top" };
    let pairing = Pairing::onto(own, opposite).within_reach(0.5).at(PairQuadrature::Pieces);
    let data = elastic::data().gamma0(gamma0).young(&moduli);
    let regions = elastic::Regions::default().touch(pairing).own(own).inside("slab bottom");
    let form = elastic::Model { data, regions }.balance();
    let (mut ratios, mut across) = (vec![], vec![]);
    let down = |x: &[f64; 2]| [0.0, if x[1] > 1.0 + 1e-9 { -0.1 } else { 0.0 }];
    let mut u = Field::interpolate(&space, down).unwrap();
    let [mut p, mut g] = [Field::zero(&traces), Field::zero(&traces)];
    for position in 0..positions {
        let aside = 0.25 * position as f64 / positions as f64;
        let mut held = Constraints::new(&space);
        held.fix("slab bottom", |_| [0.0; 2]).unwrap();
        held.fix("block top", |_| [aside, -0.1]).unwrap();
        held.periodic("slab left", "slab right", &RigidMap::translation([6.0, 0.0])).unwrap();
        let problem = Problem::new(&form, [&space, &traces, &traces]).constrained(&held);
        let solved = problem.start([&u, &p, &g]).solve().ok()?;
        let force = solved.reaction_of(0, "block top").unwrap();
        ratios.push(force[0] / force[1]);
        across.push(force[1]);
        [u, p, g] = solved.fields;
    }
    let half = |values: &[f64]| {
        let (least, most) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
        0.5 * (most - least)
    };
    let mean = across.iter().sum::<f64>() / across.len() as f64;
    Some([half(&ratios), half(&across) / mean.abs()])
}

/// With γ₀ of the bodies' stiffness. Multipliers of the displacements' degree are more, and oscillate more.
#[test]
fn multipliers_take_the_wobble_away() {
    println!("| degrees | own surface | F_x/F_y | F_y |");
    for (degrees, own, most) in [
        ((1, Elements::Bernstein(1)), "block bottom", 3e-5),
        ((1, Elements::Bernstein(1)), "slab top", 2e-4),
        ((2, Elements::Bernstein(1)), "block bottom", 3e-5),
        ((2, Elements::Bernstein(2)), "block bottom", 1e-3),
        ((2, Elements::Bernstein(1)), "slab top", 1e-3),
        ((2, Elements::Bernstein(2)), "slab top", 1e-3),
        ((1, Elements::Dual), "block bottom", 5e-4),
        ((1, Elements::Dual), "slab top", 5e-4),
        ((2, Elements::Dual), "block bottom", 5e-4),
        ((2, Elements::Dual), "slab top", 5e-4),
        ((2, Elements::DualOfBernstein), "block bottom", 4e-3),
        ((2, Elements::DualOfBernstein), "slab top", 4e-3),
    ] {
        let [along, across] = wobble((degrees.0, &degrees.1), own, 9.0, 16).expect("solved");
        println!("| {degrees:?} | {own} | {along:.1e} | {across:.1e} |");
        assert!(along < most, "{degrees:?} {own}: {along:e}");
    }
}
