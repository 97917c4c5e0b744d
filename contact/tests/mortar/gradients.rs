//! Gradients of a history in which a block is pressed on a slab and drawn along it, with friction by multipliers, compared with differences.

use forms_contact::laws::mortar_bodies::data;
use forms_fem::contract::PairQuadrature;
use forms_fem::inverse::{ControlError, ControlValues, Controls, LoadHistory, ReducedProblem, taylor_test};
use forms_fem::prelude::*;

use crate::exact::{dual, multipliers};

/// The law with a criterion of the displacement, and the rates of a step.
#[forms]
mod drawn {
    pub use forms_contact::laws::mortar_bodies::mortar_bodies_with_friction::{
        Data, GammaN, Omega, Own, Touch, direct,
    };

    pub fn criterion(u: Unknown<Vector>) -> Energy {
        integral(Omega, dot(u, u) / 2 + dot(criterion_force, u))
    }

    pub fn sensitivities(
        u: State<Vector>,
        m: State<Vector>,
        d: State<Vector>,
        z: State<Vector>,
        y: State<Vector>,
        w: State<Vector>,
        by_before_u: Test<Vector>,
        by_friction: Test<Scalar>,
        by_shear_modulus: Test<Scalar>,
    ) -> Form {
        let work = direct(u, m, d, z, y, w);
        derivative(work, displacement_before, by_before_u)
            + derivative(work, friction, by_friction)
            + derivative(work, mu, by_shear_modulus)
    }
}

/// The block on the slab, and its history.
struct Bodies<const D: usize> {
    surfaces: [&'static str; 2],
    space: Arc<Space<D>>,
    traces: Arc<Space<D>>,
    materials: Arc<Space<D>>,
    assembler: Assembler<D>,
    /// The way of the block in each step after the first.
    way: [f64; D],
}

const STEPS: usize = 4;

fn in_the_plane(degrees: [usize; 2]) -> Bodies<2> {
    let slab = rectangle([0.0; 2], [3.0, 0.6], [13, 2], CellShape::Quadrilateral, 1).unwrap();
    let block = rectangle([0.3, 0.6], [1.3, 1.2], [4, 2], CellShape::Quadrilateral, 1).unwrap();
    Bodies::new(&[("slab", &slab), ("block", &block)], degrees, [0.13, 0.0])
}

fn of_space(shape: CellShape, degree: usize) -> Bodies<3> {
    let slab = cuboid([0.0; 3], [2.0, 1.6, 0.5], [5, 4, 1], shape, 1).unwrap();
    let block = cuboid([0.31, 0.27, 0.5], [1.11, 0.97, 0.9], [2, 2, 1], shape, 1).unwrap();
    Bodies::new(&[("slab", &slab), ("block", &block)], [degree, degree], [0.11, 0.06, 0.0])
}

impl<const D: usize> Bodies<D>
where
    Dim: Dimension<D>,
{
    fn new(bodies: &[(&str, &Mesh<D>)], [degree, of_multipliers]: [usize; 2], way: [f64; D]) -> Self {
        let mesh = Mesh::of_bodies(bodies).unwrap();
        Bodies {
            surfaces: ["block bottom", "slab top"],
            space: Space::vector(&mesh, degree).unwrap(),
            traces: multipliers(&mesh, "block bottom", of_multipliers, &[D]),
            materials: Space::discontinuous_scalar(&mesh, 0).unwrap(),
            assembler: Assembler::new(&mesh).with_quadrature(Quadrature::Degree(2 * degree + 1)),
            way,
        }
    }

    /// With dual multipliers; facets of the slab are covered in part.
    fn with_dual_multipliers(self, surfaces: [&'static str; 2]) -> Self {
        Bodies { surfaces, traces: dual(self.space.mesh(), surfaces[0], &[D]), ..self }
    }

    fn held(&self, step: usize) -> Constraints<D> {
        let mut held = Constraints::new(&self.space);
        let mut moved = self.way.map(|way| step as f64 * way);
        moved[D - 1] = -0.03;
        held.fix("slab bottom", |_| [0.0; D]).unwrap();
        held.fix("block top", |_| moved).unwrap();
        held
    }

    fn model(
        &self,
        at: &ControlValues<D>,
        before: Given<[f64; D], D>,
    ) -> Result<drawn::Model<D>, ControlError> {
        let data = data().lambda(15.0).mu(at.field("shear_modulus")?).gamma0(300.0);
        let data = data.friction(at.number("friction")?);
        let force = |x: &[f64; D]| std::array::from_fn(|k| if k == 0 { 0.3 + x[0] } else { 0.5 * x[k] });
        let data = data.displacement_before(before).criterion_force(force);
        let [own, opposite] = self.surfaces;
        let touch = Pairing::onto(own, opposite).at(PairQuadrature::Pieces);
        let regions = drawn::Regions::default().touch(touch).own(own).gamma_n("block right");
        Ok(drawn::Model { data, regions })
    }

    fn controls(&self) -> Controls<D> {
        let modulus = |x: &[f64; D]| 10.0 + 2.0 * x[0].sin() * x[1];
        let modulus = Field::interpolate(&self.materials, modulus).unwrap();
        Controls::new().number("friction", 0.3).field("shear_modulus", &modulus)
    }

    fn history(&self) -> LoadHistory<'_, D> {
        let options = NewtonOptions {
            relative_tolerance: 1e-12,
            line_search: LineSearch::OnResidual,
            ..NewtonOptions::default()
        };
        LoadHistory::new([&self.space, &self.traces, &self.traces], STEPS, self.controls())
            .step(|at| Ok(self.model(at, Given::field(at.before()?))?.direct()))
            .coupled_sensitivities(|at, states, adjoints| {
                let ([u, m, d], [z, y, w]) = (states, adjoints) else { unreachable!("three unknowns") };
                Ok(self.model(at, Given::field(at.before()?))?.sensitivities(u, m, d, z, y, w))
            })
            .criterion(|at| Ok(self.model(at, Given::constant([0.0; D]))?.criterion()))
            .assembler(&self.assembler)
            .constrained_at(|step| Ok(self.held(step)))
            .options(options)
    }
}

/// Order two, and differences of fourth order; no node changes its state and no segment its facet on the way.
fn check<const D: usize>(bodies: &Bodies<D>, name: &str)
where
    Dim: Dimension<D>,
{
    let mut history = bodies.history();
    let m = history.start();
    let found = history.gradient(&m).unwrap();
    let direction: Vec<f64> = (0..m.len()).map(|k| 0.1 * (1.0 + 1.7 * k as f64).sin()).collect();
    let slope: f64 = found.gradient.iter().zip(&direction).map(|(g, along)| g * along).sum();
    let report = taylor_test(&mut history, &m, &direction, 0.1).unwrap();
    let order = report.second_order().unwrap();
    assert!((order - 2.0).abs() < 0.02, "{name}: {report}");
    let step = 1e-3;
    let mut at = |t: f64| {
        let moved: Vec<f64> = m.iter().zip(&direction).map(|(m, along)| m + t * along).collect();
        history.value(&moved).unwrap()
    };
    let [above, below, far_above, far_below] = [step, -step, 2.0 * step, -2.0 * step].map(&mut at);
    let difference = (8.0 * (above - below) - (far_above - far_below)) / (12.0 * step);
    let error = (difference / slope - 1.0).abs();
    println!("{name}: {slope:.12e} and {difference:.12e} by differences: {error:.1e}");
    assert!(error < 1e-7, "{name}: {error:e}");
}

#[test]
fn adjoints_of_sliding_with_friction() {
    for degrees in [[1, 1], [2, 1], [2, 2]] {
        check(&in_the_plane(degrees), &format!("degrees {degrees:?}"));
    }
}

/// As covers move, the functions do.
#[test]
fn adjoints_with_dual_multipliers() {
    check(&in_the_plane([1, 1]).with_dual_multipliers(["slab top", "block bottom"]), "dual, on the slab");
    check(&in_the_plane([2, 1]).with_dual_multipliers(["block bottom", "slab top"]), "dual, degree 2");
    let in_space = of_space(CellShape::Tetrahedron, 1);
    check(&in_space.with_dual_multipliers(["block bottom", "slab top"]), "dual, tetrahedra");
}

#[test]
fn adjoints_of_sliding_in_space() {
    for (shape, degree) in
        [(CellShape::Tetrahedron, 1), (CellShape::Hexahedron, 1), (CellShape::Tetrahedron, 2)]
    {
        check(&of_space(shape, degree), &format!("{shape:?}, degree {degree}"));
    }
}
