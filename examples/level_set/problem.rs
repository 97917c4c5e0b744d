//! Bodies {φ < 0} of least work of their load: half a bridge over a ditch that rests on rigid ground, and a cantilever. Nitsche's contact is
//! on all of the bridge's boundary that faces the ground, on clipped facets of the background and on the interface.

use std::sync::Arc;

use forms_fem::cut::Cut;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::level_set::{LevelSetProblem, means_at_nodes};
use forms_fem::shape_optimisation::{Derivatives, Failure, Values};

/// Length and height of the background; the bridge's plane of symmetry is x = 0.
pub const SIZE: [f64; 2] = [2.0, 1.0];
/// The length of the loaded part of the boundary: the left part of the bridge's top, the middle of the cantilever's right end.
const LOADED: f64 = 0.25;
/// The top of the round support is at this x, at y = 0.
const SUPPORT: f64 = 1.5;
/// The radius of the support.
const RADIUS: f64 = 1.0;
const YOUNG: f64 = 1000.0;
const POISSON: f64 = 0.3;
/// Force per length.
const LOAD: f64 = 10.0;

#[forms(dimension = 2, level_set_derivatives)]
pub mod loaded {
    use forms_contact::operators::ghost_penalty::vector_ghost_of_slopes;
    use forms_contact::operators::linear_elastic::{stress, von_mises};
    use forms_contact::operators::obstacle::{nitsche_density, nitsche_pressure, normal_component};
    use forms_contact::operators::topological_derivative::of_hole;

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

    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) - integral(Loaded, dot(load, v))
            + integral(Ghost, (2 * mu + lambda) * vector_ghost_of_slopes(u, v))
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) + integral(Bottom, contact(u, v)) + integral(Gamma, contact(u, v))
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
    pub fn by_hole(u: State<Vector>, p: State<Vector>, t: Test<Scalar>) -> Form {
        integral(Omega, of_hole(price, u, p) * t)
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

/// The two bodies.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Loaded on its top, with a plane of symmetry, on the support.
    Bridge,
    /// Held at its left end, and loaded in the middle of the right one.
    Cantilever,
}

/// The problem on one background mesh: J = work of the load + price of the area.
pub struct LoadedBody {
    kind: Kind,
    mesh: Mesh<2>,
    displacements: Arc<Space<2>>,
    constants: Arc<Space<2>>,
    /// The space of φ.
    pub scalars: Arc<Space<2>>,
    model: loaded::Model<2>,
}

/// A body that was solved for, without the parts that hang on nothing.
pub struct Solved {
    body: Assembler<2>,
    /// The displacement.
    pub u: Field<2>,
    held: Constraints<2>,
}

impl LoadedBody {
    /// Half of a bridge on a round support, with the price 0.12. Its load ends at a node if eight divides the number of cells along it.
    ///
    /// # Errors
    /// No cells.
    pub fn bridge(along: usize) -> Result<Self, Failure> {
        Self::new(along, Kind::Bridge, 0.12)
    }

    /// A cantilever, with the price 0.35. Its load ends at nodes if sixteen divides the number of cells along it.
    ///
    /// # Errors
    /// No cells.
    pub fn cantilever(along: usize) -> Result<Self, Failure> {
        Self::new(along, Kind::Cantilever, 0.35)
    }

    /// A background of triangles, 2 × (cells along)²/2 of them.
    fn new(along: usize, kind: Kind, price: f64) -> Result<Self, Failure> {
        let mut mesh = rectangle([0.0; 2], SIZE, [along, along / 2], CellShape::Triangle, 1)?;
        match kind {
            Kind::Bridge => mesh.name_facets("loaded", "top", |x| x[0] < LOADED)?,
            Kind::Cantilever => {
                mesh.name_facets("loaded", "right", |x| (x[1] - 0.5 * SIZE[1]).abs() < 0.5 * LOADED)?
            }
        };
        let displacements = Space::vector(&mesh, 1)?;
        let (constants, scalars) = (Space::discontinuous_scalar(&mesh, 0)?, Space::scalar(&mesh, 1)?);
        let (lambda, mu) =
            (YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)), YOUNG / (2.0 * (1.0 + POISSON)));
        let gap = Given::function_with_gradient(
            |x: &[f64; 2]| x[1] - support(x[0]),
            |x| [(x[0] - SUPPORT) / RADIUS, 1.0],
        );
        let data = loaded::data()
            .lambda(lambda)
            .mu(mu)
            .gamma0(10.0 * (2.0 * mu + lambda))
            .obstacle_normal([0.0, -1.0])
            .gap(gap)
            .theta(1.0)
            .load([0.0, -LOAD])
            .price(price)
            .ghost_slopes(0.1);
        let regions = loaded::Regions::default().ghost("ghost").gamma("all");
        Ok(LoadedBody {
            kind,
            mesh,
            displacements,
            constants,
            scalars,
            model: loaded::Model { data, regions },
        })
    }

    /// The resultant of the contact pressure and the length of the contact zone.
    ///
    /// # Errors
    /// Those of assembly.
    pub fn contact(&self, Solved { body, u, .. }: &Solved) -> Result<[f64; 2], Failure> {
        let model = &self.model;
        Ok([body.functional(&model.contact_force(u))?, body.functional(&model.contact_length(u))?])
    }

    /// The load, which the ground has to carry.
    pub fn load(&self) -> f64 {
        LOAD * LOADED
    }

    /// Von Mises' stress as means around nodes; zero outside.
    ///
    /// # Errors
    /// Those of assembly.
    pub fn mises(&self, Solved { body, u, .. }: &Solved) -> Result<Field<2>, Failure> {
        Ok(Field::from_values(&self.scalars, means_at_nodes(body, &self.model.mises(u), &self.scalars)?)?)
    }

    fn form(&self) -> Form<2> {
        match self.kind {
            Kind::Bridge => self.model.balance(),
            Kind::Cantilever => self.model.elasticity(),
        }
    }

    /// p of the discrete adjoint problem; −u without contact.
    fn adjoint(&self, Solved { body, u, held }: &Solved) -> Result<Field<2>, Failure> {
        if self.kind == Kind::Cantilever {
            return Ok(Field::from_values(u.space(), u.values().iter().map(|value| -value).collect())?);
        }
        let form = self.model.adjoint(u);
        let problem = Problem::new(&form, &self.displacements).assembler(body);
        Ok(problem.homogeneous(held).solve()?.into_field())
    }
}

impl LevelSetProblem<2> for LoadedBody {
    type State = Solved;

    fn solve(&self, body: &Arc<Cut<2>>) -> Result<Values<Solved>, Failure> {
        // What no load reaches costs and carries nothing.
        let whole = Assembler::new(&self.mesh).with_cut(body)?;
        let cost: f64 = whole.linear_form(&self.model.cost(), &self.constants)?.iter().sum();
        let (body, _) = body.without_islands(&["loaded"])?;
        let mut held = Constraints::new(&self.displacements);
        match self.kind {
            Kind::Bridge => held.fix_component("left", 0, |_| 0.0)?,
            Kind::Cantilever => held.fix("left", |_| [0.0; 2])?,
        };
        body.hold_outside(&mut held)?;
        let body = Assembler::new(&self.mesh).with_cut(&body)?;
        // Only contact holds a bridge: it begins deep in the support.
        let start = Field::interpolate(&self.displacements, |_| [0.0, -0.1])?;
        let form = self.form();
        let u = {
            let problem = Problem::new(&form, &self.displacements).assembler(&body);
            problem.constrained(&held).start(&start).solve()?.into_field()
        };
        let criterion = body.functional(&self.model.work(&u))? + cost;
        Ok(Values { criterion, constraint: None, state: Solved { body, u, held } })
    }

    fn derivatives(&self, body: &Arc<Cut<2>>, solved: &mut Solved) -> Result<Derivatives, Failure> {
        let p = self.adjoint(solved)?;
        let Solved { body: carrying, u, .. } = &*solved;
        let whole = Assembler::new(&self.mesh).with_cut(body)?;
        let one = Field::from_values(&self.constants, vec![1.0; self.constants.unknowns()])?;
        let of_cost = whole.derivative_by_level_set(&self.model.cost(), &[], &[&one])?;
        let of_work = carrying.derivative_by_level_set(&self.form(), &[u], &[&p])?;
        let criterion = of_cost.iter().zip(of_work).map(|(cost, work)| cost + work).collect();
        Ok(Derivatives { criterion, constraint: None })
    }

    fn topological_derivatives(&self, _: &Arc<Cut<2>>, solved: &mut Solved) -> Result<Derivatives, Failure> {
        let form = self.model.by_hole(&solved.u, &self.adjoint(solved)?);
        Ok(Derivatives { criterion: means_at_nodes(&solved.body, &form, &self.scalars)?, constraint: None })
    }

    fn hold(&self, changes: &mut Constraints<2>) -> Result<(), Failure> {
        let is_loaded = |x: &[f64; 2]| match self.kind {
            Kind::Bridge => x[0] < LOADED + 0.05 && x[1] > SIZE[1] - 0.06,
            Kind::Cantilever => x[0] > SIZE[0] - 0.06 && (x[1] - 0.5 * SIZE[1]).abs() < 0.5 * LOADED + 0.01,
        };
        let nodes = self.scalars.positions().iter().enumerate();
        nodes.filter(|(_, x)| is_loaded(x)).try_for_each(|(node, _)| changes.fix_node(node, 0, 0.0))?;
        Ok(())
    }
}
