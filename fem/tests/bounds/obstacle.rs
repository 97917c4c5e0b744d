//! An obstacle in a membrane on the unit disc, with its closed form, and derivatives with respect to the obstacle.
//!
//! −Δu ≥ 0, u ≥ φ, u = 0 on the circle; φ = √(¼ − r²) for r ≤ 0.45, and its tangent cone beyond. Outside of the contact radius a, u = A ln r with
//! φ(a) = A ln a and φ′(a) = A/a.

use forms_fem::prelude::*;
use forms_fem::solve::Solved;

use crate::Outcome;

#[forms(dimension = 2)]
mod membrane {
    #[cells]
    pub struct Omega;

    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
    }
    pub fn energy(u: State<Scalar>) -> Functional {
        integral(Omega, dot(grad(u), grad(u)) / 2)
    }
    /// The same of functions of the radius x₀ only.
    pub fn radial_balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, x[0] * dot(grad(u), grad(v)))
    }
    pub fn radial_energy(u: State<Scalar>) -> Functional {
        integral(Omega, x[0] * dot(grad(u), grad(u)) / 2)
    }
    pub fn criterion(u: State<Scalar>) -> Functional {
        integral(Omega, u * u / 2 + u * u * u / 3)
    }
    pub fn adjoint(u: State<Scalar>, p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(p), grad(q))) + derivative(criterion(u), u, q)
    }
}

const RADIUS: f64 = 0.348_982_574_111_686;
const SLOPE: f64 = -0.340_129_705_945_858;
const ENERGY: f64 = 0.453_542_954_841;
const FORCE: f64 = 2.137_097_970_934;

fn obstacle(x: &[f64; 2]) -> f64 {
    let (r, kink) = (x[0].hypot(x[1]), 0.45_f64);
    let top = |r: f64| (0.25 - r * r).sqrt();
    if r <= kink { top(r) } else { top(kink) - kink / top(kink) * (r - kink) }
}

fn exact(x: &[f64; 2]) -> f64 {
    let r = x[0].hypot(x[1]);
    if r <= RADIUS { obstacle(x) } else { SLOPE * r.ln() }
}

fn slope(x: &[f64; 2]) -> [f64; 2] {
    let r = x[0].hypot(x[1]);
    let radial = if r <= RADIUS { -1.0 / (0.25 - r * r).sqrt() } else { SLOPE / (r * r) };
    [radial * x[0], radial * x[1]]
}

struct Membrane {
    space: Arc<Space<2>>,
    held: Constraints<2>,
}

impl Membrane {
    fn new(core: usize, shape: CellShape, degree: usize) -> Outcome<Membrane> {
        let mesh = disc(1.0, [true; 2], core, core, shape, degree.min(2))?;
        let space = Space::scalar(&mesh, degree)?;
        let mut held = Constraints::new(&space);
        held.fix("circle", |_| 0.0)?;
        Ok(Membrane { space, held })
    }

    fn over(&self, values: &Field<2>) -> Outcome<Solved<2>> {
        let mut bounds = Bounds::new(&self.space);
        bounds.at_least_field(values)?;
        let form = membrane::Model::default().balance();
        Ok(Problem::new(&form, &self.space).constrained(&self.held).bounded(&bounds).solve()?)
    }

    fn obstacle(&self) -> Outcome<Field<2>> {
        // On the circle the membrane is held above the obstacle, which is below zero there.
        Ok(Field::interpolate(&self.space, obstacle)?)
    }
}

/// Errors of the gradient, the energy of the whole disc and the force on it.
fn errors(core: usize, shape: CellShape, degree: usize) -> Outcome<[f64; 3]> {
    let membrane = Membrane::new(core, shape, degree)?;
    let below = membrane.obstacle()?;
    let solved = membrane.over(&below)?;
    // Karush-Kuhn-Tucker: no force off the obstacle, no draw on it, no place below it.
    let force = 4.0 * solved.held().iter().map(|one| one.reaction).sum::<f64>();
    let is_held = |unknown: usize| solved.held().iter().any(|one| one.unknown == unknown);
    for (unknown, (u, low)) in solved.field().values().iter().zip(below.values()).enumerate() {
        assert!(u >= low, "{unknown}: {u} below {low}");
        let residual = solved.residual[unknown];
        if !membrane.held.is_prescribed(unknown) && !is_held(unknown) {
            assert!(residual.abs() < 1e-12 * force, "{unknown}: {residual:e}");
        }
    }
    assert!(solved.held().iter().all(|one| one.reaction > 0.0 && !one.is_weak));
    let assembler = Assembler::new(membrane.space.mesh()).with_quadrature(Quadrature::Degree(8));
    let norms = norms::errors(
        &assembler,
        solved.field(),
        |x, value| value[0] = exact(x),
        |x, value| value.copy_from_slice(&slope(x)),
    )?;
    let energy = 4.0 * assembler.functional(&membrane::Model::default().energy(solved.field()))?;
    println!(
        "{shape:?} {degree} core {core}: {} unknowns, {} steps, gradient {:.4e}, energy {energy:.9}, force {force:.9}",
        membrane.space.unknowns(),
        solved.iterations(),
        2.0 * norms.seminorm
    );
    Ok([2.0 * norms.seminorm, (energy - ENERGY).abs(), (force - FORCE).abs()])
}

#[test]
fn linear_elements_converge_to_the_closed_form() -> Outcome {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let found = [4, 8, 16].map(|core| errors(core, shape, 1)).into_iter().collect::<Outcome<Vec<_>>>()?;
        for pair in found.windows(2) {
            let order = |k: usize| (pair[0][k] / pair[1][k]).log2();
            assert!((0.9..1.2).contains(&order(0)), "{shape:?}: gradient of order {}", order(0));
            // The energy and the force converge with the square, up to where nodes meet the contact's edge.
            assert!(order(1) > 1.5 && order(2) > 1.0, "{shape:?}: {} {}", order(1), order(2));
        }
        assert!(found[2][0] < 0.05 && found[2][1] < 2e-3 && found[2][2] < 1e-2, "{found:?}");
    }
    Ok(())
}

#[test]
fn quadratic_elements_gain_half_an_order() -> Outcome {
    // u has third derivatives that jump at the contact's edge: its gradient is in H^(3/2 − ε).
    let found =
        [4, 8].map(|core| errors(core, CellShape::Triangle, 2)).into_iter().collect::<Outcome<Vec<_>>>()?;
    let order = (found[0][0] / found[1][0]).log2();
    assert!((1.2..1.9).contains(&order), "{order}");
    Ok(())
}

#[test]
fn a_set_that_shrinks_by_thousands_of_layers_is_found_in_few_steps() -> Outcome {
    // Along a radius: the first set reaches to where the obstacle is zero, 0.2 of the radius beyond the contact.
    let mut steps = vec![];
    for count in [500, 5000] {
        let width = 1.0 / f64::from(count);
        let mesh = rectangle([0.0; 2], [1.0, width], [count as usize, 1], CellShape::Quadrilateral, 1)?;
        let space = Space::scalar(&mesh, 1)?;
        let mut held = Constraints::new(&space);
        held.fix("right", |_| 0.0)?;
        let mut bounds = Bounds::new(&space);
        bounds.at_least("all", |x| obstacle(&[x[0], 0.0]))?;
        let form = membrane::Model::default().radial_balance();
        let solved = Problem::new(&form, &space).constrained(&held).bounded(&bounds).solve()?;
        let whole = 2.0 * std::f64::consts::PI / width;
        let force = whole * solved.held().iter().map(|one| one.reaction).sum::<f64>();
        let energy = whole * solved.functional(&membrane::Model::default().radial_energy(solved.field()))?;
        println!("{count}: {} steps, energy {energy:.12}, force {force:.12}", solved.iterations());
        assert!((energy - ENERGY).abs() < 0.5 * width * width, "{energy}");
        assert!((force - FORCE).abs() < 10.0 * width * width, "{force}");
        // The edge of the contact is between the nodes held and the next ones.
        let edge = solved.held().iter().map(|one| space.positions()[one.unknown][0]).fold(0.0, f64::max);
        assert!((edge - RADIUS).abs() < 1.5 * width, "{edge}");
        steps.push(solved.iterations());
    }
    assert!(steps.iter().all(|steps| *steps < 40), "{steps:?}");
    Ok(())
}

#[test]
fn an_adjoint_gives_the_gradient_with_respect_to_the_obstacle() -> Outcome {
    let membrane = Membrane::new(8, CellShape::Triangle, 1)?;
    let (below, model) = (membrane.obstacle()?, membrane::Model::default());
    let solved = membrane.over(&below)?;
    let assembler = solved.assembler();
    let adjoint = model.adjoint(solved.field());
    let held = solved.held_at_bounds()?;
    let state = Problem::new(&adjoint, &membrane.space).homogeneous(&held).assembler(assembler).solve()?;
    let moved = Field::interpolate(&membrane.space, |x| (3.0 * x[0] + x[1]).cos())?;
    let slope: f64 =
        solved.held().iter().map(|one| state.residual[one.unknown] * moved.values()[one.unknown]).sum();
    let value = |size: f64| -> Outcome<f64> {
        let values = below.values().iter().zip(moved.values()).map(|(low, moved)| low + size * moved);
        let solved = membrane.over(&Field::from_values(&membrane.space, values.collect())?)?;
        Ok(assembler.functional(&model.criterion(solved.field()))?)
    };
    let size = 1e-4;
    let difference = (value(size)? - value(-size)?) / (2.0 * size);
    println!("by the adjoint {slope:.12}, by differences {difference:.12}");
    assert!((slope - difference).abs() < 1e-7 * slope.abs(), "{slope} {difference}");
    // An obstacle that is not touched does not matter.
    assert!(slope.abs() > 1e-2);
    Ok(())
}
