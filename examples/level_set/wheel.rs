//! The paper's cylinder with holes {φ > 0}, cut from a ring of triangles: the rim, which touches the ground, and the hub are fitted, the
//! holes are cut. Law, load and criterion are those of `shape_optimisation`. It is pressed in one position, or in several as it rolls.

mod descent;
mod grid;

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use forms_contact::hollow_cylinder::{
    CRITERION_FORCE, IMPOSED_DISPLACEMENT, INNER_RADIUS, OBSTACLE_DEPTH, OUTER_RADIUS, Settings,
    hollow_cylinder_on,
};
use forms_contact::rolling::{Ground, PositionNumbers, RollingCriterion};
use forms_contact::{Adjoint, forms};
use forms_fem::cut::Cut;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::level_set::{
    LevelSetProblem, LevelSetVolume, SmoothPerimeter, interface_measure, means_at_nodes,
};
use forms_fem::shape_optimisation::{Derivatives, Failure, Rotations, Values};

pub use descent::{Descended, WheelDescent};
use grid::{Grid, in_sector};

/// Holes around the ring.
pub const HOLES: usize = 24;
/// Radius of the round holes of the start \[cm\].
pub const HOLE_RADIUS: f64 = 2.0;
/// Thickness that stays between holes and the circles, and between holes \[cm\].
pub const WALL: f64 = 0.2;
/// Facets of the rim that face the ground in some position, and those that may touch it.
const FACING: &str = "facing the ground";
const SWEPT: &str = "swept by the ground";
/// J of the fitted ring with round holes \[N cm²\]: the price of the perimeter at the start is 0.8 times this.
const FITTED_START: f64 = 1209.140283;

#[forms(dimension = 2, level_set_derivatives)]
pub mod inside {
    use forms_contact::operators::ghost_penalty::vector_ghost_of_slopes;
    use forms_contact::operators::linear_elastic::{stress, von_mises};

    #[includes(
        forms_contact::operators::linear_elastic::Data,
        forms_contact::operators::linear_criterion::Data,
        forms_contact::operators::ghost_penalty::Data
    )]
    pub struct Data {}
    #[cells]
    pub struct Omega;
    #[interior_facets]
    pub struct Ghost;

    pub fn ghost(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Ghost, (2 * mu + lambda) * vector_ghost_of_slopes(u, v))
    }
    /// The terms of the direct problem that move with Γ.
    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
    /// The terms of the criterion that move with Γ.
    pub fn criterion(u: State<Vector>, t: Test<Scalar>) -> Form {
        integral(Omega, dot(criterion_force, u) * t)
    }
    pub fn mises(u: State<Vector>, t: Test<Scalar>) -> Form {
        integral(Omega, von_mises(u) * t)
    }
}

/// φ of round holes in the middle of sectors.
pub fn round_holes(x: &[f64; 2]) -> f64 {
    let [angle, radius] = in_sector(x);
    let from_middle = 0.5 * TAU / HOLES as f64 - angle;
    let middle = 0.5 * (INNER_RADIUS + OUTER_RADIUS);
    HOLE_RADIUS - (radius * from_middle.cos() - middle).hypot(radius * from_middle.sin())
}

/// A wave with the pattern of the sectors, along which gradients are checked.
pub fn sector_wave(x: &[f64; 2]) -> f64 {
    1.0 + (3.0 * x[0].hypot(x[1])).sin() * (HOLES as f64 * x[1].atan2(x[0]) + 0.7).cos()
}

/// The least wall at the points of Γ \[cm\].
pub fn least_wall(body: &Cut<2>) -> f64 {
    let of_point = |x: &[f64; 2]| {
        let [angle, radius] = in_sector(x);
        let between_holes = 2.0 * radius * angle.min(FRAC_PI_2).sin();
        (radius - INNER_RADIUS).min(OUTER_RADIUS - radius).min(between_holes)
    };
    body.interface().iter().flatten().map(of_point).fold(f64::INFINITY, f64::min)
}

/// Positions of a wheel that rolls.
#[derive(Clone, Debug)]
pub struct Rolling {
    /// The ground in each of them.
    pub positions: Vec<Ground>,
    /// J over them, without the price of the perimeter.
    pub criterion: RollingCriterion,
    /// θ of Nitsche's method: with 0 all positions share one factor.
    pub theta: f64,
    /// Degree of the rule on Γ_C; that of each form unless it is given. ∫p is the force of the ground only if all have the same.
    pub contact_degree: Option<usize>,
}

impl Rolling {
    /// A number of positions over one sector with the mean of ∫ F·u, and θ = 0.
    pub fn over_sector(count: usize) -> Self {
        let positions = Ground::in_sector(OBSTACLE_DEPTH, HOLES, count);
        Rolling { positions, criterion: RollingCriterion::default(), theta: 0.0, contact_degree: Some(8) }
    }
}

/// The problem on one ring: J over the positions + price of the perimeter, at the volume of the round holes.
pub struct Wheel {
    grid: Grid,
    mesh: Mesh<2>,
    displacements: Arc<Space<2>>,
    /// The space of φ.
    pub scalars: Arc<Space<2>>,
    law: forms::Model<2>,
    rolling: Rolling,
    inside: inside::Model<2>,
    sectors: Rotations<2>,
    volume: LevelSetVolume,
    perimeter: Option<SmoothPerimeter<2>>,
    price: f64,
    adjoint: Adjoint,
    threads: Threads,
}

/// A wheel in one position.
pub struct Position {
    /// The displacement, as the wheel sees it.
    pub u: Field<2>,
    /// Work, reaction and pressure.
    pub numbers: PositionNumbers,
    held: Constraints<2>,
}

/// A wheel that was solved for.
pub struct Pressed {
    body: Assembler<2>,
    /// At least one.
    pub positions: Vec<Position>,
    /// The solver of all positions.
    pub solver: CondensedSolver,
    /// J without the price of the perimeter: ∫ F·u of a wheel in one position.
    pub unpriced: f64,
    /// The length of Γ, which is not that of the criterion \[cm\].
    pub length: f64,
    of_perimeter: Vec<f64>,
    of_volume: Vec<f64>,
}

impl Wheel {
    /// The problem in one position on a ring with `cells` pairs of triangles in the width of a sector.
    ///
    /// # Errors
    /// Cells too large for the wall of the rim.
    pub fn new(cells: usize, adjoint: Adjoint) -> Result<Self, Failure> {
        let theta = Settings::default().theta;
        let rolling = Rolling { theta, contact_degree: None, ..Rolling::over_sector(1) };
        Self::in_positions(cells, adjoint, rolling)
    }

    /// The problem of a wheel that rolls, with the adjoint (21).
    ///
    /// # Errors
    /// As [`Wheel::new`].
    pub fn rolling(cells: usize, rolling: &Rolling) -> Result<Self, Failure> {
        Self::in_positions(cells, Adjoint::Discrete, rolling.clone())
    }

    fn in_positions(cells: usize, adjoint: Adjoint, rolling: Rolling) -> Result<Self, Failure> {
        let grid = Grid::new(cells);
        let mut mesh = grid.mesh()?;
        let gaps =
            |x: &[f64; 2]| rolling.positions.iter().map(|ground| ground.gap(x)).fold(f64::MAX, f64::min);
        mesh.name_facets(FACING, "outer", |x| gaps(x) < OBSTACLE_DEPTH)?;
        // The rim moves about as far as the hub.
        let depth = IMPOSED_DISPLACEMENT[0].hypot(IMPOSED_DISPLACEMENT[1]);
        mesh.name_facets(SWEPT, "outer", |x| gaps(x) < 1.1 * depth)?;
        Self::on(mesh, grid, adjoint, rolling)
    }

    fn on(mesh: Mesh<2>, grid: Grid, adjoint: Adjoint, rolling: Rolling) -> Result<Self, Failure> {
        let mut law = hollow_cylinder_on(&mesh, &Settings::default())?.law;
        law.data = law.data.theta(rolling.theta);
        law.regions = law.regions.gamma_c(FACING);
        let data = inside::data().lambda(law.data.lambda).mu(law.data.mu);
        let regions = inside::Regions::default().ghost("ghost");
        let scalars = Space::scalar(&mesh, 1)?;
        let round = PI * HOLE_RADIUS * HOLE_RADIUS;
        let ring = PI * (OUTER_RADIUS * OUTER_RADIUS - INNER_RADIUS * INNER_RADIUS);
        let solid = scalars.positions().iter().map(|x| grid.is_held(x)).collect();
        Ok(Wheel {
            perimeter: Some(SmoothPerimeter::new(&scalars, solid)?),
            displacements: Space::vector(&mesh, 1)?,
            sectors: Rotations::new(&scalars, [0.0; 2], HOLES)?,
            volume: LevelSetVolume { target: ring - HOLES as f64 * round },
            price: 0.8 * FITTED_START / (HOLES as f64 * TAU * HOLE_RADIUS),
            inside: inside::Model { data, regions },
            grid,
            mesh,
            scalars,
            law,
            rolling,
            adjoint,
            threads: Threads::all(),
        })
    }

    /// The same problem on cells of half the size, with the same polygons as circles.
    ///
    /// # Errors
    /// Too many cells.
    pub fn refined(&self) -> Result<Self, Failure> {
        let grid =
            Grid { cells: 2 * self.grid.cells, wall: 2 * self.grid.wall, layers: 2 * self.grid.layers };
        Self::on(self.mesh.refined()?, grid, self.adjoint, self.rolling.clone())
    }

    /// The width of cells half-way between the circles \[cm\].
    pub fn size(&self) -> f64 {
        Grid::size(self.grid.cells)
    }

    /// The same problem whose price is that of the length of Γ.
    pub fn with_length(mut self) -> Self {
        self.perimeter = None;
        self
    }

    /// The same problem with a number of threads.
    pub fn with_threads(mut self, threads: Threads) -> Self {
        self.threads = threads;
        self
    }

    /// J with the price of the length of Γ.
    pub fn priced(&self, pressed: &Pressed) -> f64 {
        pressed.unpriced + self.price * pressed.length
    }

    /// The number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.displacements.unknowns()
    }

    /// The largest difference of φ between sectors \[cm\].
    ///
    /// # Errors
    /// A function on another mesh.
    pub fn pattern_error(&self, phi: &Field<2>) -> Result<f64, Failure> {
        let mut means = phi.values().to_vec();
        self.sectors.average_values(&mut means)?;
        Ok(phi.values().iter().zip(&means).map(|(own, mean)| (own - mean).abs()).fold(0.0, f64::max))
    }

    /// Von Mises' stress in a position as means around nodes \[MPa\]; zero outside.
    ///
    /// # Errors
    /// Those of assembly.
    pub fn mises(&self, pressed: &Pressed, position: &Position) -> Result<Field<2>, Failure> {
        let means = means_at_nodes(&pressed.body, &self.inside.mises(&position.u), &self.scalars)?;
        Ok(Field::from_values(&self.scalars, means)?)
    }

    /// The wheel in a position.
    fn pressed_on(
        &self,
        ground: &Ground,
        (cut, body): (&Cut<2>, &Assembler<2>),
        solver: &mut CondensedSolver,
    ) -> Result<Position, Failure> {
        let mut held = Constraints::new(&self.displacements);
        let push = ground.seen(IMPOSED_DISPLACEMENT);
        held.fix("inner", |_| push)?;
        cut.hold_outside(&mut held)?;
        let law = ground.law(&self.law, CRITERION_FORCE);
        let form = &law.direct() + &self.inside.ghost();
        let u = {
            let problem = Problem::new(&form, &self.displacements).assembler(body).constrained(&held);
            // A factor for one position is smaller.
            let problem = match self.rolling.positions.len() {
                1 => problem,
                _ => problem.expecting_changes_at(SWEPT),
            };
            let problem = match self.rolling.contact_degree {
                None => problem,
                Some(_) => problem.assembler_at(|_| Ok(self.on_contact(body))),
            };
            problem.solver(solver).solve()?.into_field()
        };
        Ok(Position { numbers: PositionNumbers::of(&law, &self.on_contact(body), &u)?, u, held })
    }

    /// The assembler of integrals over Γ_C.
    fn on_contact(&self, body: &Assembler<2>) -> Assembler<2> {
        let body = body.clone();
        match self.rolling.contact_degree {
            None => body,
            Some(degree) => body.with_quadrature(Quadrature::Degree(degree)),
        }
    }

    /// The share of a position in the derivative of J by φ, from the derivatives of J by its numbers.
    fn derivative_on(
        &self,
        ground: &Ground,
        (body, solver): (&Assembler<2>, &mut CondensedSolver),
        (Position { u, held, .. }, by): (&Position, &PositionNumbers),
        criterion: &mut [f64],
    ) -> Result<(), Failure> {
        let law = ground.law(&self.law, CRITERION_FORCE);
        let adjoint = match self.adjoint {
            Adjoint::Discrete => by.adjoint(&law, u),
            // Of the mean of one position.
            Adjoint::Consistent => law.consistent_adjoint(u),
            Adjoint::Extended => law.extended_adjoint(u),
        };
        let form = &adjoint + &self.inside.ghost();
        let p = {
            let problem = Problem::new(&form, &self.displacements).assembler(self.on_contact(body));
            problem.homogeneous(held).solver(solver).solve()?.into_field()
        };
        let constants = Space::discontinuous_scalar(&self.mesh, 0)?;
        let weight = Field::from_values(&constants, vec![by.work; constants.unknowns()])?;
        let data = self.inside.data.clone().criterion_force(law.data.criterion_force.clone());
        let inside = inside::Model { data, regions: self.inside.regions.clone() };
        let own = body.derivative_by_level_set(&inside.criterion(u), &[], &[&weight])?;
        let by_state = body.derivative_by_level_set(&inside.elasticity(), &[u], &[&p])?;
        let parts = criterion.iter_mut().zip(own.iter().zip(by_state));
        parts.for_each(|(sum, (own, by_state))| *sum += own + by_state);
        Ok(())
    }
}

impl LevelSetProblem<2> for Wheel {
    type State = Pressed;

    fn solve(&self, cut: &Arc<Cut<2>>) -> Result<Values<Pressed>, Failure> {
        let (volume, of_volume) = self.volume.value(cut)?;
        let (length, of_length) = interface_measure(cut)?;
        let (perimeter, of_perimeter) = match &self.perimeter {
            Some(smooth) => smooth.value(cut)?,
            None => (length, of_length),
        };
        let body = Assembler::new(&self.mesh).with_cut(cut)?.with_threads(self.threads);
        let mut solver = CondensedSolver::new(TangentSolverOptions {
            threads: self.threads,
            ..TangentSolverOptions::default()
        });
        let grounds = self.rolling.positions.iter();
        let positions = grounds.map(|ground| self.pressed_on(ground, (cut, &body), &mut solver));
        let positions = positions.collect::<Result<Vec<_>, _>>()?;
        let numbers: Vec<PositionNumbers> = positions.iter().map(|position| position.numbers).collect();
        let unpriced = self.rolling.criterion.value(&numbers)?;
        let state = Pressed { body, positions, solver, unpriced, length, of_perimeter, of_volume };
        Ok(Values { criterion: unpriced + self.price * perimeter, constraint: Some(volume), state })
    }

    fn derivatives(&self, _: &Arc<Cut<2>>, pressed: &mut Pressed) -> Result<Derivatives, Failure> {
        let Pressed { body, positions, solver, of_perimeter, of_volume, .. } = pressed;
        let numbers: Vec<PositionNumbers> = positions.iter().map(|position| position.numbers).collect();
        let by_numbers = self.rolling.criterion.derivatives(&numbers)?;
        let mut criterion: Vec<f64> = of_perimeter.iter().map(|of| self.price * of).collect();
        for (ground, position) in self.rolling.positions.iter().zip(positions.iter().zip(&by_numbers)) {
            self.derivative_on(ground, (body, &mut *solver), position, &mut criterion)?;
        }
        let mut constraint = of_volume.clone();
        self.sectors.average_values(&mut criterion)?;
        self.sectors.average_values(&mut constraint)?;
        Ok(Derivatives { criterion, constraint: Some(constraint) })
    }

    /// Γ stays off the hub, off the rim, and off the sides of sectors.
    fn hold(&self, changes: &mut Constraints<2>) -> Result<(), Failure> {
        let space = self.scalars.clone();
        for (node, _) in space.positions().iter().enumerate().filter(|(_, x)| self.grid.is_held(x)) {
            changes.fix_node(node, 0, 0.0)?;
        }
        Ok(())
    }
}
