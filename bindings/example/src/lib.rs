//! A beam, clamped at its left end and loaded from above, on a ground whose heights are the controls: contact by Nitsche's method.

use std::error::Error;

use forms_bindings::Parameters;
use forms_fem::inverse::{
    ControlError, ControlValues, Controls, CriterionMap, DifferentiableMap, LoadHistory, Readings,
    ReadingsMap,
};
use forms_fem::prelude::*;

/// The physics: contact as in the paper's (14), the criterion, and the derivatives by the controls.
#[forms(dimension = 2)]
pub mod beam {
    use forms_contact::operators::linear_elastic::stress;
    use forms_contact::operators::obstacle::{nitsche_density, normal_component};

    #[includes(forms_contact::operators::linear_elastic::Data, forms_contact::operators::obstacle::Data)]
    pub struct Data {
        /// The load on the top \[stress\], downwards.
        pub load: Param,
    }
    #[cells]
    pub struct Beam;
    #[facets]
    pub struct Top;
    #[facets]
    pub struct Bottom;

    fn normal_stress(w: Vector) -> Scalar {
        normal_component(stress(w))
    }

    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Beam, inner(stress(u), eps(v)))
            + integral(Top, load * v[1])
            + integral(Bottom, nitsche_density(normal_stress(u), u, normal_stress(v), v))
    }

    /// Deviation of the top from level: ½ ∫ u_y².
    pub fn unevenness(u: Unknown<Vector>) -> Energy {
        integral(Top, sqr(u[1]) / 2)
    }

    pub fn sensitivities(
        u: State<Vector>,
        p: State<Vector>,
        by_gap: Test<Scalar>,
        by_load: Test<Scalar>,
    ) -> Form {
        derivative(balance(u, p), gap, by_gap) + derivative(balance(u, p), load, by_load)
    }

    /// The sensitivities with the ground as the only control.
    pub fn rates_by_gap(u: State<Vector>, p: State<Vector>, by_gap: Test<Scalar>) -> Form {
        derivative(balance(u, p), gap, by_gap)
    }
}

/// A beam of 2 × 0.25 in cells × cells/8 quadrilaterals, E = 1, ν = 0.3.
struct Setting {
    space: Arc<Space<2>>,
    assembler: Assembler<2>,
    clamped: Constraints<2>,
    /// Distance of the ground from the beam at the nodes of its lower side.
    gap: Field<2>,
}

impl Setting {
    fn new(cells: usize) -> Result<Self, Box<dyn Error>> {
        let divisions = [cells, cells.div_ceil(8)];
        let mesh = rectangle([0.0; 2], [2.0, 0.25], divisions, CellShape::Quadrilateral, 1)?;
        let space = Space::vector(&mesh, 2)?;
        let mut clamped = Constraints::new(&space);
        clamped.fix("left", |_| [0.0; 2])?;
        let ground = Space::on_facets(&mesh, "bottom", 1)?;
        let gap = Field::interpolate(&ground, |_| 0.02)?;
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(6));
        Ok(Setting { space, assembler, clamped, gap })
    }

    /// The problem with its controls, without a criterion.
    fn problem(&self, controls: Controls<2>) -> LoadHistory<'static, 2> {
        LoadHistory::new(&self.space, 1, controls)
            .assembler(&self.assembler)
            .constrained(&self.clamped)
            .options(NewtonOptions { relative_tolerance: 1e-12, ..NewtonOptions::default() })
    }
}

fn model(at: &ControlValues<2>, load: f64) -> Result<beam::Model<2>, ControlError> {
    let (young, poisson) = (1.0, 0.3);
    let data = beam::data()
        .lambda(young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)))
        .mu(young / (2.0 * (1.0 + poisson)))
        .gamma0(20.0 * young)
        .obstacle_normal([0.0, -1.0])
        .gap(&at.field("gap")?)
        .theta(0.0)
        .load(load);
    Ok(beam::Model { data, regions: beam::Regions::default().beam("all").top("top").bottom("bottom") })
}

/// Deviation of the top from level, ½ ∫ u_y², as a function of the ground. Parameters: `cells` along the beam, `load`.
///
/// # Errors
/// Parameters that do not fit.
pub fn level(parameters: &mut Parameters) -> Result<impl DifferentiableMap + use<>, Box<dyn Error>> {
    let (cells, load) = (parameters.count("cells", 16)?, parameters.number("load", 1e-3));
    let setting = Setting::new(cells)?;
    let problem = setting
        .problem(Controls::new().field("gap", &setting.gap))
        .step(move |at| Ok(model(at, load)?.balance()))
        .sensitivities(move |at, u, p| Ok(model(at, load)?.rates_by_gap(u, p)))
        .criterion(move |at| Ok(model(at, load)?.unevenness()));
    Ok(CriterionMap::new(problem))
}

/// The displacement at points along the top, as a function of ground and load. Parameters: `cells` along the beam, `points`.
///
/// # Errors
/// Parameters that do not fit.
pub fn deflection(parameters: &mut Parameters) -> Result<impl DifferentiableMap + use<>, Box<dyn Error>> {
    let (cells, points) = (parameters.count("cells", 16)?, parameters.count("points", 4)?);
    let setting = Setting::new(cells)?;
    let problem = setting
        .problem(Controls::new().field("gap", &setting.gap).number("load", 1e-3))
        .step(|at| Ok(model(at, at.number("load")?)?.balance()))
        .sensitivities(|at, u, p| Ok(model(at, at.number("load")?)?.sensitivities(u, p)));
    let mut readings = Readings::new(&setting.space);
    for k in 1..=points {
        readings = readings.at_point(&[2.0 * k as f64 / points as f64, 0.25])?;
    }
    Ok(ReadingsMap::new(problem)?.output("displacement", 0, readings)?)
}

forms_bindings::export_c!(level, crate::level);
forms_bindings::export_c!(deflection, crate::deflection);
#[cfg(feature = "python")]
forms_bindings::export_python!(beam_on_ground: level, deflection);
