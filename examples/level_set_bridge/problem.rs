//! Half of a bridge over a ditch: a body {φ < 0} that carries a load and rests on rigid ground. Nitsche's contact is on all of the body's
//! boundary that faces the ground, on clipped facets of the background and on the interface.

use std::sync::Arc;

use forms_examples::level_set::eighteen_holes;
use forms_fem::cut::Cut;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::level_set::{LevelSetProblem, means_at_nodes};
use forms_fem::shape_optimisation::{Derivatives, Failure, Values};

/// Width and height of the background; the plane of symmetry is x = 0.
pub const SIZE: [f64; 2] = [2.0, 1.0];
/// The load is on the top up to this x.
const LOADED: f64 = 0.25;
/// The top of the round support is at this x, at y = 0.
const SUPPORT: f64 = 1.5;
/// The radius of the support.
const RADIUS: f64 = 1.0;
const YOUNG: f64 = 1000.0;
const POISSON: f64 = 0.3;
/// Force per length.
const LOAD: f64 = 10.0;
/// Price of an area.
const PRICE: f64 = 0.12;

#[forms(dimension = 2, level_set_derivatives)]
pub mod bridge {
    use forms_contact::operators::ghost_penalty::vector_ghost_of_slopes;
    use forms_contact::operators::linear_elastic::{stress, von_mises};
    use forms_contact::operators::obstacle::{nitsche_density, nitsche_pressure, normal_component};

    #[includes(
        forms_contact::operators::linear_elastic::Data,
        forms_contact::operators::obstacle::Data,
        forms_contact::operators::ghost_penalty::Data
    )]
    pub struct Data {
        /// Force per length.
        pub load: Given<Vector>,
        /// Price of an area.
        pub price: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Loaded;
    #[facets]
    pub struct Bottom;
    #[interface]
    pub struct Gamma;
    #[interior_facets]
    pub struct Ghost;

    fn contact(u: Vector, v: Vector) -> Scalar {
        nitsche_density(normal_component(stress(u)), u, normal_component(stress(v)), v)
    }
    fn pressure(u: Vector) -> Scalar {
        nitsche_pressure(normal_component(stress(u)), u)
    }

    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) - integral(Loaded, dot(load, v))
            + integral(Ghost, (2 * mu + lambda) * vector_ghost_of_slopes(u, v))
            + integral(Bottom, contact(u, v))
            + integral(Gamma, contact(u, v))
    }
    /// The work of the load, 2 × the energy that the body takes.
    pub fn work(u: State<Vector>) -> Functional {
        integral(Loaded, dot(load, u))
    }
    pub fn adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(balance(u, p), u, q) + derivative(work(u), u, q)
    }
    pub fn cost(t: Test<Scalar>) -> Form {
        integral(Omega, price * t)
    }
    pub fn contact_force(u: State<Vector>) -> Functional {
        integral(Bottom, pressure(u)) + integral(Gamma, pressure(u))
    }
    pub fn contact_length(u: State<Vector>) -> Functional {
        integral(Bottom, heaviside(pressure(u))) + integral(Gamma, heaviside(pressure(u)))
    }
    pub fn mises(u: State<Vector>, t: Test<Scalar>) -> Form {
        integral(Omega, von_mises(u) * t)
    }
}

/// The height of the support at x.
pub fn support(x: f64) -> f64 {
    -(x - SUPPORT).powi(2) / (2.0 * RADIUS)
}

/// The problem on one background mesh: J = work of the load + price of the area.
pub struct Bridge {
    pub mesh: Mesh<2>,
    displacements: Arc<Space<2>>,
    constants: Arc<Space<2>>,
    scalars: Arc<Space<2>>,
    model: bridge::Model<2>,
}

/// A body that was solved for, without the parts that hang on nothing.
pub struct Solved {
    body: Assembler<2>,
    pub u: Field<2>,
    held: Constraints<2>,
}

impl Bridge {
    /// A background of triangles, 2 × (cells along)²/2 of them. The load ends at a node if eight divides their number.
    pub fn new(along: usize) -> Result<Bridge, Failure> {
        let mut mesh = rectangle([0.0; 2], SIZE, [along, along / 2], CellShape::Triangle, 1)?;
        mesh.name_facets("loaded", "top", |x| x[0] < LOADED)?;
        let displacements = Space::vector(&mesh, 1)?;
        let (constants, scalars) = (Space::discontinuous_scalar(&mesh, 0)?, Space::scalar(&mesh, 1)?);
        let (lambda, mu) =
            (YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)), YOUNG / (2.0 * (1.0 + POISSON)));
        let gap = Given::function_with_gradient(
            |x: &[f64; 2]| x[1] - support(x[0]),
            |x| [(x[0] - SUPPORT) / RADIUS, 1.0],
        );
        let data = bridge::data()
            .lambda(lambda)
            .mu(mu)
            .gamma0(10.0 * (2.0 * mu + lambda))
            .obstacle_normal([0.0, -1.0])
            .gap(gap)
            .theta(1.0)
            .load([0.0, -LOAD])
            .price(PRICE);
        let regions = bridge::Regions::default().ghost("ghost").gamma("all");
        Ok(Bridge { mesh, displacements, constants, scalars, model: bridge::Model { data, regions } })
    }

    /// The full rectangle with rows of round holes.
    pub fn start(&self) -> Result<Field<2>, Failure> {
        Ok(Field::interpolate(&self.scalars, eighteen_holes)?)
    }

    /// The cost or another integral with a test function of value one.
    fn measured(&self, body: &Assembler<2>, form: &Form<2>) -> Result<f64, Failure> {
        Ok(body.linear_form(form, &self.constants)?.iter().sum())
    }

    /// The resultant of the contact pressure and the length of the contact zone.
    pub fn contact(&self, Solved { body, u, .. }: &Solved) -> Result<[f64; 2], Failure> {
        let model = &self.model;
        Ok([body.functional(&model.contact_force(u))?, body.functional(&model.contact_length(u))?])
    }

    /// The load, which the ground has to carry.
    pub fn load(&self) -> f64 {
        LOAD * LOADED
    }

    /// Von Mises' stress as means around nodes; zero outside.
    pub fn mises(&self, Solved { body, u, .. }: &Solved) -> Result<Field<2>, Failure> {
        Ok(Field::from_values(&self.scalars, means_at_nodes(body, &self.model.mises(u), &self.scalars)?)?)
    }
}

impl LevelSetProblem<2> for Bridge {
    type State = Solved;

    fn solve(&self, body: &Arc<Cut<2>>) -> Result<Values<Solved>, Failure> {
        // What no load reaches costs and carries nothing.
        let cost = self.measured(&Assembler::new(&self.mesh).with_cut(body)?, &self.model.cost())?;
        let (body, _) = body.without_islands(&["loaded"])?;
        let mut held = Constraints::new(&self.displacements);
        held.fix_component("left", 0, |_| 0.0)?;
        body.hold_outside(&mut held)?;
        let body = Assembler::new(&self.mesh).with_cut(&body)?;
        // Only contact holds the body: it begins deep in the support.
        let start = Field::interpolate(&self.displacements, |_| [0.0, -0.1])?;
        let form = self.model.balance();
        let u = {
            let problem = Problem::new(&form, &self.displacements).assembler(&body);
            problem.constrained(&held).start(&start).solve()?.into_field()
        };
        let criterion = body.functional(&self.model.work(&u))? + cost;
        Ok(Values { criterion, constraint: None, state: Solved { body, u, held } })
    }

    fn derivatives(&self, body: &Arc<Cut<2>>, solved: &mut Solved) -> Result<Derivatives, Failure> {
        let Solved { body: carrying, u, held } = &*solved;
        let form = self.model.adjoint(u);
        let problem = Problem::new(&form, &self.displacements).assembler(carrying);
        let p = problem.homogeneous(held).solve()?.into_field();
        let whole = Assembler::new(&self.mesh).with_cut(body)?;
        let one = Field::from_values(&self.constants, vec![1.0; self.constants.unknowns()])?;
        let of_cost = whole.derivative_by_level_set(&self.model.cost(), &[], &[&one])?;
        let of_work = carrying.derivative_by_level_set(&self.model.balance(), &[u], &[&p])?;
        let criterion = of_cost.iter().zip(of_work).map(|(cost, work)| cost + work).collect();
        Ok(Derivatives { criterion, constraint: None })
    }

    fn hold(&self, changes: &mut Constraints<2>) -> Result<(), Failure> {
        let nodes: Vec<usize> = (0..self.mesh.nodes().len())
            .filter(|node| {
                let x = self.mesh.nodes()[*node];
                x[0] < LOADED + 0.05 && x[1] > SIZE[1] - 0.06
            })
            .collect();
        for node in nodes {
            changes.fix_node(node, 0, 0.0)?;
        }
        Ok(())
    }
}
