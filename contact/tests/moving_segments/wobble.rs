//! Forces of a block that is drawn along a slab by one of its cells: how much they oscillate on points and on segments, and what happens where the
//! block's end leaves a facet.

use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod drawn {
    pub struct Data {
        young: Given<Scalar>,
        gamma0: Param,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    fn stress(u: Vector) -> Tensor {
        young / 1.3 * (eps(u) + 0.75 * div(u) * I)
    }
    fn contact_pressure(u: Vector) -> Scalar {
        neg_part(dot(this(stress(u) * n), toward) + gamma0 / this(h) * gap)
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
            + integral(Touch(u), contact_pressure(u) * dot(toward, jump(v)))
    }
}

/// A slab of 24 cells, periodic sideways, and a block of 7 cells on it with a bottom that is an arc, or flat.
struct Drawn {
    space: Arc<Space<2>>,
    young: Field<2>,
}

impl Drawn {
    fn new(degree: usize, rise: f64) -> Self {
        let slab = rectangle([0.0, -1.0], [3.0, 0.0], [24, 8], CellShape::Quadrilateral, 1).unwrap();
        let bottom = |s: f64| rise * (2.0 * s - 1.0) * (2.0 * s - 1.0);
        let shape = |[s, t]: [f64; 2]| [0.8 + 1.2 * s, bottom(s) + t * (0.8 - bottom(s))];
        let block = structured([7, 5], CellShape::Quadrilateral, 1, shape).unwrap();
        let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap();
        let cells = Space::discontinuous_scalar(&mesh, 0).unwrap();
        let mut values = vec![1.0; cells.unknowns()];
        for cell in mesh.cell_region("block").unwrap() {
            values[cells.cell_nodes(*cell as usize)[0] as usize] = 3.0;
        }
        Drawn {
            space: Space::vector(&mesh, degree).unwrap(),
            young: Field::from_values(&cells, values).unwrap(),
        }
    }

    /// The forces of the slab on the block, held at its top and moved along by so much, from a displacement, which is moved on; none where
    /// Newton's method fails.
    fn forces(
        &self,
        law: &drawn::Model<2>,
        rule: usize,
        along: f64,
        u: &mut Field<2>,
    ) -> Option<(Vec<f64>, usize)> {
        let mut held = Constraints::new(&self.space);
        held.fix("slab bottom", |_| [0.0; 2]).unwrap();
        let map = forms_fem::constraints::RigidMap::translation([3.0, 0.0]);
        held.periodic("slab left", "slab right", &map).unwrap();
        held.fix("block top", |_| [along, -0.1]).unwrap();
        let assembler = Assembler::new(self.space.mesh()).with_quadrature(Quadrature::Degree(rule));
        let form = law.balance();
        let options = NewtonOptions {
            line_search: LineSearch::OnResidual,
            max_iterations: 20,
            ..NewtonOptions::default()
        };
        let problem = Problem::new(&form, &self.space).assembler(&assembler).constrained(&held);
        let solved = problem.options(options).start(&*u).solve().ok()?;
        *u = solved.field().clone();
        Some((solved.reaction("block top").unwrap(), solved.iterations()))
    }

    fn law(&self, own: &str, gamma0: f64, quadrature: Option<PairQuadrature>) -> drawn::Model<2> {
        let (slab, block) = ("slab top", "block bottom");
        let touch = if own == "block" { Pairing::onto(block, slab) } else { Pairing::onto(slab, block) };
        let touch = quadrature.into_iter().fold(touch, |touch, quadrature| touch.at(quadrature));
        let data = drawn::data().young(&self.young).gamma0(gamma0);
        drawn::Model { data, regions: drawn::Regions::default().touch(touch) }
    }

    /// Half the amplitude of the forces' quotient over one cell of the slab, and the most steps of Newton's method; infinite where it fails.
    fn wobble(
        &self,
        own: &str,
        gamma0: f64,
        quadrature: Option<PairQuadrature>,
        rule: usize,
    ) -> (f64, usize) {
        let law = self.law(own, gamma0, quadrature);
        let mut u = Field::zero(&self.space);
        let (mut least, mut most, mut steps) = (f64::INFINITY, f64::NEG_INFINITY, 0);
        for place in 0..=24 {
            let along = 0.125 / 24.0 * f64::from(place);
            let Some((force, taken)) = self.forces(&law, rule, along, &mut u) else {
                return (f64::INFINITY, usize::MAX);
            };
            let quotient = force[0] / force[1];
            (least, most) = (quotient.min(least), quotient.max(most));
            steps = if place > 0 { taken.max(steps) } else { 0 };
        }
        (0.5 * (most - least), steps)
    }
}

const PIECES: Option<PairQuadrature> = Some(PairQuadrature::Pieces);

/// The table of docs/points_segments_means.md, all of it with FORMS_SWEEPS=1; segments do not cure the oscillation of pointwise laws.
#[test]
fn forces_of_a_block_on_a_slab() {
    println!("| degree | own | γ₀ | as many points | 4 points | segments | steps |");
    let sweep = std::env::var_os("FORMS_SWEEPS").is_some();
    for degree in if sweep { 1..3 } else { 1..2 } {
        let drawn = Drawn::new(degree, 0.12);
        for own in if sweep { &["block", "slab"][..] } else { &["block"] } {
            for gamma0 in [60.0, 9.0] {
                let all = [(None, 2 * degree + 1), (None, 7), (PIECES, 2 * degree + 1)];
                let all = all.map(|(quadrature, rule)| drawn.wobble(own, gamma0, quadrature, rule));
                let steps = all.map(|(_, steps)| steps);
                let [few, many, segments] = all.map(|(wobble, _)| wobble);
                println!(
                    "| {degree} | {own} | {gamma0} | {few:.1e} | {many:.1e} | {segments:.1e} | {steps:?} |"
                );
                assert!(segments < 1e-2, "{segments}");
            }
        }
    }
}

/// Ways along which both ends of a flat block stay within one facet of the slab each, and along which each passes a node of the slab: the block is 9.6
/// facets wide, and spreads a little.
const WITHIN_FACETS: [f64; 2] = [0.005, 0.07];
const PAST_NODES: [f64; 2] = [0.01, 0.12];

/// The largest second difference of the force, as a part of it, over steps of a flat block over the slab.
fn roughness(
    drawn: &Drawn,
    quadrature: Option<PairQuadrature>,
    rule: usize,
    ([from, to], steps): ([f64; 2], i32),
) -> f64 {
    let law = drawn.law("slab", 9.0, quadrature);
    let mut u = Field::zero(&drawn.space);
    let along = |k: i32| from + (to - from) / f64::from(steps) * f64::from(k);
    let mut at = |k: i32| Some(drawn.forces(&law, rule, along(k), &mut u)?.0[1]);
    let Some(forces) = (0..=steps).map(&mut at).collect::<Option<Vec<f64>>>() else { return f64::INFINITY };
    let second = forces.windows(3).map(|f| (f[0] - 2.0 * f[1] + f[2]).abs());
    second.fold(0.0, f64::max) / forces[0].abs()
}

#[test]
fn forces_are_smoother_on_segments_where_an_end_leaves_a_facet() {
    for degree in [1, 2] {
        let drawn = Drawn::new(degree, 0.0);
        let points = roughness(&drawn, None, 3, (PAST_NODES, 60));
        let segments = roughness(&drawn, PIECES, 2 * degree + 1, (PAST_NODES, 60));
        println!("degree {degree}: points {points:.1e}, segments {segments:.1e}");
        assert!(segments < 5e-4 && segments < 0.1 * points, "{segments:e} {points:e}");
    }
}

/// While no end passes a node, second differences are those of a smooth function: they fall with the square of the step, and a higher rule changes nothing.
#[test]
fn forces_are_smooth_while_ends_are_inside_of_facets() {
    for degree in [1, 2] {
        let drawn = Drawn::new(degree, 0.0);
        let rule = 2 * degree + 1;
        let of = |rule: usize, steps: i32| roughness(&drawn, PIECES, rule, (WITHIN_FACETS, steps));
        let [coarse, fine, higher] = [of(rule, 60), of(rule, 120), of(rule + 4, 60)];
        println!(
            "degree {degree}: {coarse:.2e} in 60 steps, {fine:.2e} in 120, {higher:.2e} by a higher rule"
        );
        assert!(coarse < 1e-5 && fine < 0.27 * coarse, "{coarse:e} {fine:e}");
        assert!((higher / coarse - 1.0).abs() < 0.02, "{higher:e} {coarse:e}");
    }
}

/// A jump has second differences that do not fall with the steps. Where nodes of the two surfaces pass each other the derivative jumps: between
/// the rays of neighbouring facets with different normals a part of the gap's length is seen twice, or not at all.
#[test]
fn forces_are_continuous() {
    let drawn = Drawn::new(1, 0.0);
    let [coarse, fine] = [120, 480].map(|steps| roughness(&drawn, PIECES, 3, (PAST_NODES, steps)));
    println!("second differences: {coarse:.1e} in 120 steps, {fine:.1e} in 480");
    assert!(fine < 0.5 * coarse, "{coarse:e} {fine:e}");
}
