//! A cantilever: a body {φ < 0} that is held at its left end and loaded at the other.

use std::sync::Arc;

use forms_fem::cut::Cut;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::level_set::{LevelSetProblem, means_at_nodes};
use forms_fem::shape_optimisation::{Derivatives, Failure, Values};

/// Length and height of the plate.
pub const SIZE: [f64; 2] = [2.0, 1.0];
/// The load acts up to this distance from the middle of the right end.
const LOADED: f64 = 0.125;
const YOUNG: f64 = 1000.0;
const POISSON: f64 = 0.3;
/// Force per length.
const LOAD: f64 = 10.0;
/// Price of an area.
const PRICE: f64 = 0.35;
/// A small weight of the ghost penalty: with a large one it carries load across gaps of a cell, and struts become rows of islands.
const GHOST: f64 = 0.003;

#[forms(dimension = 2, level_set_derivatives)]
pub mod cantilever {
    use forms_contact::operators::ghost_penalty::vector_ghost_of_slopes;
    use forms_contact::operators::linear_elastic::{stress, von_mises};
    use forms_contact::operators::topological_derivative::of_hole;

    #[includes(forms_contact::operators::linear_elastic::Data, forms_contact::operators::ghost_penalty::Data)]
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
    #[interior_facets]
    pub struct Ghost;

    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) - integral(Loaded, dot(load, v))
            + integral(Ghost, (2 * mu + lambda) * vector_ghost_of_slopes(u, v))
    }
    pub fn work(u: State<Vector>) -> Functional {
        integral(Loaded, dot(load, u))
    }
    pub fn cost(t: Test<Scalar>) -> Form {
        integral(Omega, price * t)
    }
    pub fn by_hole(u: State<Vector>, p: State<Vector>, t: Test<Scalar>) -> Form {
        integral(Omega, of_hole(price, u, p) * t)
    }
    pub fn mises(u: State<Vector>, t: Test<Scalar>) -> Form {
        integral(Omega, von_mises(u) * t)
    }
}

/// The problem on one background: J = work of the load + price of the area.
pub struct Cantilever {
    mesh: Mesh<2>,
    displacements: Arc<Space<2>>,
    constants: Arc<Space<2>>,
    pub scalars: Arc<Space<2>>,
    model: cantilever::Model<2>,
}

/// A body that was solved for, without the parts that carry no load.
pub struct Solved {
    body: Assembler<2>,
    u: Field<2>,
}

impl Cantilever {
    /// A background of triangles, 2 × (cells along)²/2 of them. The load ends at nodes if sixteen divides their number.
    pub fn new(along: usize) -> Result<Cantilever, Failure> {
        let mut mesh = rectangle([0.0; 2], SIZE, [along, along / 2], CellShape::Triangle, 1)?;
        mesh.name_facets("loaded", "right", |x| (x[1] - 0.5 * SIZE[1]).abs() < LOADED)?;
        let displacements = Space::vector(&mesh, 1)?;
        let (constants, scalars) = (Space::discontinuous_scalar(&mesh, 0)?, Space::scalar(&mesh, 1)?);
        let data = cantilever::data()
            .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
            .mu(YOUNG / (2.0 * (1.0 + POISSON)))
            .load([0.0, -LOAD])
            .price(PRICE)
            .ghost_slopes(GHOST);
        let regions = cantilever::Regions::default().ghost("ghost");
        Ok(Cantilever { mesh, displacements, constants, scalars, model: cantilever::Model { data, regions } })
    }

    /// Von Mises' stress as means around nodes; zero outside.
    pub fn mises(&self, Solved { body, u }: &Solved) -> Result<Field<2>, Failure> {
        Ok(Field::from_values(&self.scalars, means_at_nodes(body, &self.model.mises(u), &self.scalars)?)?)
    }
}

/// The adjoint state of the work of the load: −u.
fn adjoint(u: &Field<2>) -> Result<Field<2>, Failure> {
    Ok(Field::from_values(u.space(), u.values().iter().map(|value| -value).collect())?)
}

impl LevelSetProblem<2> for Cantilever {
    type State = Solved;

    fn solve(&self, body: &Arc<Cut<2>>) -> Result<Values<Solved>, Failure> {
        // What no load reaches costs and carries nothing.
        let whole = Assembler::new(&self.mesh).with_cut(body)?;
        let cost: f64 = whole.linear_form(&self.model.cost(), &self.constants)?.iter().sum();
        let (body, _) = body.without_islands(&["loaded"])?;
        let mut held = Constraints::new(&self.displacements);
        held.fix("left", |_| [0.0; 2])?;
        body.hold_outside(&mut held)?;
        let body = Assembler::new(&self.mesh).with_cut(&body)?;
        let form = self.model.balance();
        let problem = Problem::new(&form, &self.displacements).assembler(&body);
        let u = problem.constrained(&held).solve()?.into_field();
        let criterion = body.functional(&self.model.work(&u))? + cost;
        Ok(Values { criterion, constraint: None, state: Solved { body, u } })
    }

    fn derivatives(
        &self,
        body: &Arc<Cut<2>>,
        Solved { body: carrying, u }: &mut Solved,
    ) -> Result<Derivatives, Failure> {
        let whole = Assembler::new(&self.mesh).with_cut(body)?;
        let one = Field::from_values(&self.constants, vec![1.0; self.constants.unknowns()])?;
        let of_cost = whole.derivative_by_level_set(&self.model.cost(), &[], &[&one])?;
        let of_work = carrying.derivative_by_level_set(&self.model.balance(), &[u], &[&adjoint(u)?])?;
        let criterion = of_cost.iter().zip(of_work).map(|(cost, work)| cost + work).collect();
        Ok(Derivatives { criterion, constraint: None })
    }

    fn topological_derivatives(&self, _: &Arc<Cut<2>>, solved: &mut Solved) -> Result<Derivatives, Failure> {
        let Solved { body, u } = &*solved;
        let form = self.model.by_hole(u, &adjoint(u)?);
        Ok(Derivatives { criterion: means_at_nodes(body, &form, &self.scalars)?, constraint: None })
    }

    fn hold(&self, changes: &mut Constraints<2>) -> Result<(), Failure> {
        let is_loaded = |x: &[f64; 2]| x[0] > SIZE[0] - 0.06 && (x[1] - 0.5 * SIZE[1]).abs() < LOADED + 0.01;
        let nodes = self.scalars.positions().iter().enumerate();
        nodes.filter(|(_, x)| is_loaded(x)).try_for_each(|(node, _)| changes.fix_node(node, 0, 0.0))?;
        Ok(())
    }
}
