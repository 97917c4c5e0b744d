//! The energy of a body of densities in a third medium, and the force on the arm that closes onto it.

use std::error::Error;

use forms_contact::laws::third_medium::medium;
use forms_examples::density_filter::{Filter, Filtered};
use forms_fem::element::Elements;
use forms_fem::inverse::{ControlError, ControlValues, Controls, LoadHistory};
use forms_fem::prelude::*;
use forms_fem::space::Scope;

/// A pad that moves down and presses the arm, so that no step of Newton's method begins with crushed cells.
#[forms(dimension = 2)]
pub mod pad {
    pub struct Data {
        /// Stiffness \[stress per length\].
        pub spring: Param,
        /// Its way down \[length\].
        pub way: Param,
    }
    #[facets]
    pub struct End;

    fn pressure(u: Vector) -> Scalar {
        spring * (way + u[1])
    }
    pub fn pressing(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(End, pressure(u) * v[1])
    }
    pub fn force(u: Unknown<Vector>) -> Energy {
        integral(End, pressure(u))
    }
}

#[forms(dimension = 2)]
pub mod closing {
    pub use super::pad::End;
    use super::pad::{force, pressing};
    pub use forms_contact::laws::third_medium::{Medium, Omega};
    use forms_contact::laws::third_medium::{medium_density, second_gradients, volume_ratio};
    use forms_contact::operators::neo_hookean::energy_density;

    #[includes(forms_contact::laws::third_medium::Data, super::pad::Data)]
    pub struct Data {
        /// ρ̃, smooth densities.
        pub smooth: Given<Scalar>,
        /// β, of the projection.
        pub sharpness: Param,
        /// Of the force in the criterion.
        pub factor: Param,
    }
    /// The cells of the densities.
    #[cells]
    pub struct Design;

    /// ρ of a smooth density, near 0 or 1 (Wang, Lazarov and Sigmund 2011).
    pub fn projected(s: Scalar) -> Scalar {
        0.5 + tanh(sharpness * (s - 0.5)) / (2 * tanh(sharpness / 2))
    }

    fn of_medium(u: Vector) -> Scalar {
        medium_density(u) + curvature_stiffness * second_gradients(u)
    }

    /// ρ³ W_B + (1 − ρ³) W_M: stiffnesses s + (1 − s) ρ³ of the body's, and second gradients in the medium's part.
    fn of_design(u: Vector) -> Scalar {
        let part = pow(projected(smooth), 3);
        part * energy_density(u) + (1 - part) * of_medium(u)
    }

    pub fn stored(u: State<Vector>) -> Functional {
        integral(Omega, energy_density(u)) + integral(Medium, of_medium(u)) + integral(Design, of_design(u))
    }

    #[controls(smooth, criterion = reaction)]
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(stored(u), u, v) + pressing(u, v)
    }

    pub fn reaction(u: Unknown<Vector>) -> Energy {
        factor * force(u)
    }

    pub fn volume(u: Unknown<Vector>) -> Functional {
        let J = volume_ratio(u);
        integral(Omega, J) + integral(Medium, J) + integral(Design, J)
    }

    /// The area of the body in the design.
    pub fn area(s: Unknown<Scalar>) -> Energy {
        integral(Design, projected(s))
    }
}

/// λ and μ of the body, and the medium's part of them.
pub const LAMBDA: f64 = 5.0 / 3.0;
pub const MU: f64 = 5.0 / 14.0;
const SOFTNESS: f64 = 5e-6;
/// The pad's stiffness.
pub const SPRING: f64 = 1.0;
/// The way of the pad, and the heights of the lower and of the upper surface.
pub const WAY: f64 = 0.15;
pub const LOWER: f64 = 0.3125;
pub const UPPER: f64 = 0.375;
/// Steps of the pad, which lead Newton's method to the last one.
const STEPS: usize = 3;
/// Length over which densities are smoothed.
const RADIUS: f64 = 0.02;

/// Whether a place of the boundary is on the part of the top that the pad presses.
pub fn is_end(x: &[f64; 2]) -> bool {
    x[0] > 0.75 && (x[1] - 0.5).abs() < 1e-9
}

/// A C: the arm above a gap of medium is given, and the densities below are wanted.
pub struct Closing {
    /// Cells across.
    pub across: usize,
    pub displacements: Arc<Space<2>>,
    pub smooth: Arc<Space<2>>,
    pub cells: Arc<Space<2>>,
    pub held: Constraints<2>,
    pub assembler: Assembler<2>,
    pub filter: Filter,
    /// β.
    pub sharpness: f64,
    /// Unit of the criterion \[force per thickness\].
    pub unit: f64,
}

impl Closing {
    pub fn new(across: usize) -> Result<Closing, Box<dyn Error>> {
        if across == 0 || !across.is_multiple_of(8) {
            return Err(format!("{across} cells across: it must be a multiple of eight").into());
        }
        let mut mesh = rectangle([0.0; 2], [1.0, 0.5], [2 * across, across], CellShape::Quadrilateral, 1)?;
        mesh.name_cells("arm", |x| x[1] > UPPER)?;
        mesh.name_cells("gap", |x| x[1] > LOWER && x[1] < UPPER)?;
        mesh.name_cells("design", |x| x[1] < LOWER)?;
        mesh.name_facets("end", "boundary", is_end)?;
        let on_design = |degree: usize, scope: Scope| {
            Space::of(&mesh, Elements::Lagrange(degree), scope.within("design"), &[])
        };
        let displacements = Space::vector(&mesh, 2)?;
        let mut held = Constraints::new(&displacements);
        held.fix("left", |_| [0.0; 2])?;
        Ok(Closing {
            across,
            displacements,
            held,
            smooth: on_design(1, Scope::Nodes)?,
            cells: on_design(0, Scope::Cell)?,
            assembler: Assembler::new(&mesh).with_quadrature(Quadrature::Degree(5)),
            filter: Filter { radius: RADIUS, region: "design" },
            sharpness: 2.0,
            unit: 1.0,
        })
    }

    pub fn mesh(&self) -> &Mesh<2> {
        self.displacements.mesh()
    }

    /// ρ of a smooth density, as in the form.
    pub fn projected(&self, smooth: f64) -> f64 {
        0.5 + (self.sharpness * (smooth - 0.5)).tanh() / (2.0 * (self.sharpness / 2.0).tanh())
    }

    /// The forms with smooth densities; the criterion counts by a factor.
    pub fn model(&self, smooth: &Field<2>, way: f64, factor: f64) -> Result<closing::Model<2>, ControlError> {
        let soft = medium(LAMBDA, MU, SOFTNESS, 1.0);
        let data = closing::data()
            .lambda(LAMBDA)
            .mu(MU)
            .medium_lambda(soft.lambda)
            .medium_mu(soft.mu)
            .curvature_stiffness(soft.curvature_stiffness)
            .spring(SPRING)
            .way(way)
            .smooth(smooth)
            .sharpness(self.sharpness)
            .factor(-factor / self.unit);
        let regions = closing::Regions::default().omega("arm").medium("gap").design("design").end("end");
        Ok(closing::Model { data, regions })
    }

    fn model_at(&self, at: &ControlValues<2>) -> Result<closing::Model<2>, ControlError> {
        let step = at.step() + 1;
        let factor = if step == STEPS { 1.0 } else { 0.0 };
        self.model(&at.field("smooth")?, WAY * step as f64 / STEPS as f64, factor)
    }

    /// The steps of the pad, with minus its last force as the criterion.
    pub fn history(&self, smooth: &Field<2>) -> LoadHistory<'_, 2> {
        LoadHistory::new(&self.displacements, STEPS, Controls::new().field("smooth", smooth))
            .step(|at| Ok(self.model_at(at)?.balance()))
            .sensitivities(|at, u, p| Ok(self.model_at(at)?.balance_sensitivities(u, p)))
            .criterion(|at| Ok(self.model_at(at)?.reaction()))
            .keep_positive(|at| Ok(self.model_at(at)?.volume()))
            .assembler(&self.assembler)
            .constrained(&self.held)
            .options(NewtonOptions { relative_tolerance: 1e-12, ..NewtonOptions::default() })
    }

    /// The history behind the filter, from densities.
    pub fn filtered(&self, density: &Field<2>) -> Result<Filtered<'_>, Box<dyn Error>> {
        Filtered::new(
            self.history(&Field::zero(&self.smooth)),
            self.filter,
            &self.smooth,
            density,
            &self.assembler,
        )
    }

    /// The body's area in the design, behind the filter.
    pub fn area(&self, density: &Field<2>) -> LoadHistory<'_, 2> {
        LoadHistory::new(&self.smooth, 1, Controls::new().field("density", density))
            .step(|at| Ok(self.filter.of(Given::field(&at.field("density")?)).smoothing()))
            .sensitivities(|at, s, p| {
                Ok(self.filter.of(Given::field(&at.field("density")?)).smoothing_sensitivities(s, p))
            })
            .criterion(|_| Ok(self.model(&Field::zero(&self.smooth), WAY, 1.0)?.area()))
            .assembler(&self.assembler)
            .constrained(&Constraints::new(&self.smooth))
    }
}
