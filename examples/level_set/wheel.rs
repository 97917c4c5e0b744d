//! The paper's cylinder with holes {φ > 0}, cut from a ring of triangles: the rim, which touches the ground, and the hub are fitted, the
//! holes are cut. Law, load and criterion are those of `shape_optimisation`.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use forms_contact::hollow_cylinder::{
    CONTACT, CONTACT_CELLS, IMPOSED_DISPLACEMENT, INNER_RADIUS, OUTER_RADIUS, Settings, hollow_cylinder_on,
};
use forms_contact::{Adjoint, forms};
use forms_fem::cut::Cut;
use forms_fem::mesh::annulus;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::level_set::{
    LevelSetProblem, LevelSetVolume, SmoothPerimeter, interface_measure, means_at_nodes,
};
use forms_fem::shape_optimisation::{Derivatives, Failure, Rotations, Values};

/// Holes around the ring.
pub const HOLES: usize = 24;
/// Radius of the round holes of the start \[cm\].
pub const HOLE_RADIUS: f64 = 2.0;
/// Thickness that stays between holes and the circles, and between holes \[cm\].
pub const WALL: f64 = 0.2;
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

/// Rings of `cells` pairs of triangles in the width of a sector, and as large ones along radii. There are nodes at the wall of the hub.
struct Grid {
    cells: usize,
    wall: usize,
    layers: usize,
}

impl Grid {
    fn new(cells: usize) -> Self {
        let size = Self::size(cells);
        let wall = (WALL / size).ceil() as usize;
        Grid { cells, wall, layers: wall + ((OUTER_RADIUS - INNER_RADIUS - WALL) / size).round() as usize }
    }

    /// The width of cells half-way between the circles \[cm\].
    fn size(cells: usize) -> f64 {
        0.5 * (INNER_RADIUS + OUTER_RADIUS) * TAU / (HOLES * cells) as f64
    }

    /// Whether a node stays inside: up to the first one beyond the walls.
    fn is_held(&self, x: &[f64; 2]) -> bool {
        let turn = TAU / (HOLES * self.cells) as f64;
        let layer = (OUTER_RADIUS - INNER_RADIUS - WALL) / (self.layers - self.wall) as f64;
        let ([angle, radius], rounding) = (in_sector(x), 1e-9);
        radius < INNER_RADIUS + WALL + rounding
            || OUTER_RADIUS - radius - layer < WALL - rounding
            || radius * (angle - turn) < 0.5 * WALL - rounding
    }

    fn mesh(&self) -> Result<Mesh<2>, Failure> {
        let Grid { cells, wall, layers } = *self;
        let even = annulus(INNER_RADIUS, OUTER_RADIUS, layers, HOLES * cells, CellShape::Triangle, 1)?;
        let share = |part: usize, whole: usize| part as f64 / whole as f64;
        let graded = |x: &[f64; 2]| {
            let radius = x[0].hypot(x[1]);
            let layer =
                ((radius - INNER_RADIUS) / (OUTER_RADIUS - INNER_RADIUS) * layers as f64).round() as usize;
            let here = match layer <= wall {
                true => INNER_RADIUS + WALL * share(layer, wall),
                false => {
                    let from = INNER_RADIUS + WALL;
                    from + (OUTER_RADIUS - from) * share(layer - wall, layers - wall)
                }
            };
            x.map(|x| x * here / radius)
        };
        let mut mesh = even.with_nodes(even.nodes().iter().map(graded).collect())?;
        mesh.name_facets(CONTACT, "outer", |centre| centre[1] < 0.0)?;
        mesh.name_cells_of_facets(CONTACT_CELLS, CONTACT)?;
        Ok(mesh)
    }
}

/// The place in the sector: the angle from its nearer side, and the radius.
fn in_sector(x: &[f64; 2]) -> [f64; 2] {
    let sector = TAU / HOLES as f64;
    let angle = x[1].atan2(x[0]).rem_euclid(sector);
    [angle.min(sector - angle), x[0].hypot(x[1])]
}

/// φ of round holes in the middle of sectors.
pub fn round_holes(x: &[f64; 2]) -> f64 {
    let [angle, radius] = in_sector(x);
    let from_middle = 0.5 * TAU / HOLES as f64 - angle;
    let middle = 0.5 * (INNER_RADIUS + OUTER_RADIUS);
    HOLE_RADIUS - (radius * from_middle.cos() - middle).hypot(radius * from_middle.sin())
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

/// The problem on one ring: J = ∫ F·u + price of the perimeter, at the volume of the round holes.
pub struct Wheel {
    grid: Grid,
    mesh: Mesh<2>,
    displacements: Arc<Space<2>>,
    /// The space of φ.
    pub scalars: Arc<Space<2>>,
    law: forms::Model<2>,
    inside: inside::Model<2>,
    sectors: Rotations<2>,
    volume: LevelSetVolume,
    perimeter: Option<SmoothPerimeter<2>>,
    price: f64,
    adjoint: Adjoint,
}

/// A wheel that was solved for.
pub struct Pressed {
    body: Assembler<2>,
    /// The displacement.
    pub u: Field<2>,
    held: Constraints<2>,
    solver: CondensedSolver,
    /// ∫ F·u, without the price of the perimeter.
    pub work: f64,
    /// The length of Γ, which is not that of the criterion \[cm\].
    pub length: f64,
    of_perimeter: Vec<f64>,
    of_volume: Vec<f64>,
}

impl Wheel {
    /// The problem on a ring with `cells` pairs of triangles in the width of a sector.
    ///
    /// # Errors
    /// Cells too large for the wall of the rim.
    pub fn new(cells: usize, adjoint: Adjoint) -> Result<Self, Failure> {
        let grid = Grid::new(cells);
        let mesh = grid.mesh()?;
        Self::on(mesh, grid, adjoint)
    }

    fn on(mesh: Mesh<2>, grid: Grid, adjoint: Adjoint) -> Result<Self, Failure> {
        let law = hollow_cylinder_on(&mesh, &Settings::default())?.law;
        let data = inside::data()
            .lambda(law.data.lambda)
            .mu(law.data.mu)
            .criterion_force(law.data.criterion_force.clone());
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
            adjoint,
        })
    }

    /// The same problem on cells of half the size, with the same polygons as circles.
    ///
    /// # Errors
    /// Too many cells.
    pub fn refined(&self) -> Result<Self, Failure> {
        let grid =
            Grid { cells: 2 * self.grid.cells, wall: 2 * self.grid.wall, layers: 2 * self.grid.layers };
        Self::on(self.mesh.refined()?, grid, self.adjoint)
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

    /// J with the price of the length of Γ.
    pub fn priced(&self, pressed: &Pressed) -> f64 {
        pressed.work + self.price * pressed.length
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

    /// Von Mises' stress as means around nodes \[MPa\]; zero outside.
    ///
    /// # Errors
    /// Those of assembly.
    pub fn mises(&self, Pressed { body, u, .. }: &Pressed) -> Result<Field<2>, Failure> {
        Ok(Field::from_values(&self.scalars, means_at_nodes(body, &self.inside.mises(u), &self.scalars)?)?)
    }
}

impl LevelSetProblem<2> for Wheel {
    type State = Pressed;

    fn solve(&self, body: &Arc<Cut<2>>) -> Result<Values<Pressed>, Failure> {
        let mut held = Constraints::new(&self.displacements);
        held.fix("inner", |_| IMPOSED_DISPLACEMENT)?;
        body.hold_outside(&mut held)?;
        let (volume, of_volume) = self.volume.value(body)?;
        let (length, of_length) = interface_measure(body)?;
        let (perimeter, of_perimeter) = match &self.perimeter {
            Some(smooth) => smooth.value(body)?,
            None => (length, of_length),
        };
        let body = Assembler::new(&self.mesh).with_cut(body)?;
        let form = &self.law.direct() + &self.inside.ghost();
        let mut solver = CondensedSolver::default();
        let u = {
            let problem = Problem::new(&form, &self.displacements).assembler(&body);
            problem.constrained(&held).solver(&mut solver).solve()?.into_field()
        };
        let work = body.functional(&self.law.criterion(&u))?;
        let state = Pressed { body, u, held, solver, work, length, of_perimeter, of_volume };
        Ok(Values { criterion: work + self.price * perimeter, constraint: Some(volume), state })
    }

    fn derivatives(&self, _: &Arc<Cut<2>>, pressed: &mut Pressed) -> Result<Derivatives, Failure> {
        let Pressed { body, u, held, solver, of_perimeter, of_volume, .. } = pressed;
        let u: &Field<2> = u;
        let adjoint = match self.adjoint {
            Adjoint::Discrete => self.law.discrete_adjoint(u),
            Adjoint::Consistent => self.law.consistent_adjoint(u),
            Adjoint::Extended => self.law.extended_adjoint(u),
        };
        let form = &adjoint + &self.inside.ghost();
        let p = {
            let problem = Problem::new(&form, &self.displacements).assembler(&*body);
            problem.homogeneous(held).solver(solver).solve()?.into_field()
        };
        let constants = Space::discontinuous_scalar(&self.mesh, 0)?;
        let one = Field::from_values(&constants, vec![1.0; constants.unknowns()])?;
        let own = body.derivative_by_level_set(&self.inside.criterion(u), &[], &[&one])?;
        let by_state = body.derivative_by_level_set(&self.inside.elasticity(), &[u], &[&p])?;
        let parts = own.iter().zip(by_state).zip(of_perimeter.iter());
        let mut criterion: Vec<f64> =
            parts.map(|((own, by_state), of_perimeter)| own + by_state + self.price * of_perimeter).collect();
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
