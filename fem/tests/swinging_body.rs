//! A body that swings: damped, hardening springs in it, clamped at the left, pulled at the right; by density, stiffness of each cell, a load per
//! step, displacement and velocity at the start. What tests of histories of motions share.

use forms_fem::inverse::{
    ControlError, Controls, MotionHistory, Observations, SecondOrderMotion, StepContext, StepSizes,
};
use forms_fem::prelude::*;
use forms_fem::time::Scheme;

#[forms(dimension = 2)]
pub mod swinging {
    use forms_fem::time::operators::vector::{acceleration, displacement, velocity};

    #[includes(forms_fem::time::operators::vector::Data)]
    pub struct Data {
        pub density: Param,
        pub stiffness: Given<Scalar>,
        pub pull: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Right;

    #[controls(density, stiffness, pull, motion(value, rate, second_rate), order = 2)]
    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let w = displacement(u);
        let rate = velocity(u);
        integral(Omega, density * dot(acceleration(u) + (0.3 + dot(rate, rate)) * rate, v))
            + integral(Omega, exp(stiffness) * inner(eps(w), eps(v)) + (0.5 + dot(w, w)) * dot(w, v))
            - integral(Right, pull * v[1])
    }
    /// With a hardening spring and a damper that read the unknown itself, and no control.
    pub fn sprung(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        motion(u, v) + integral(Right, (1 + 9 * dot(u, u)) * dot(2 * u + 0.4 * velocity(u), v))
    }
    pub fn misfit(u: Unknown<Vector>) -> Energy {
        integral(Omega, pow(u[1] - 0.1 * x[0], 4) + sqr(u[0]))
    }
    /// Without the derivatives by what is known before the step, which are tangents then.
    pub fn sensitivities(
        u: State<Vector>,
        p: State<Vector>,
        by_density: Test<Scalar>,
        by_stiffness: Test<Scalar>,
        by_pull: Test<Scalar>,
    ) -> Form {
        let work = motion(u, p);
        derivative(work, density, by_density)
            + derivative(work, stiffness, by_stiffness)
            + derivative(work, pull, by_pull)
    }
}

pub fn swung(
    during: &StepContext<2>,
    states: Option<&SecondOrderMotion<2>>,
) -> Result<swinging::Model<2>, ControlError> {
    let along = states.map(|states| states.along);
    let data = swinging::data_from(during)
        .density(during.number("density")?)
        .stiffness(&during.field("stiffness")?)
        .pull(during.number("pull")?)
        .d_density(along.map_or(Ok(0.0), |along| along.number("density"))?)
        .d_stiffness(match along {
            Some(along) => Given::field(&along.field("stiffness")?),
            None => Given::constant(0.0),
        })
        .d_pull(along.map_or(Ok(0.0), |along| along.number("pull"))?);
    Ok(swinging::Model { data, regions: swinging::Regions::default() })
}

/// The number of steps of all its motions.
pub const STEPS: usize = 6;

pub struct Body {
    pub space: Arc<Space<2>>,
    pub held: Constraints<2>,
    pub controls: Controls<2>,
    criterion: swinging::Model<2>,
}

impl Body {
    pub fn new(cells: [usize; 2]) -> Self {
        let mesh = rectangle([0.0; 2], [1.0, 0.3], cells, CellShape::Quadrilateral, 1).unwrap();
        let space = Space::vector(&mesh, 1).unwrap();
        let mut held = Constraints::new(&space);
        held.fix("left", |_| [0.0; 2]).unwrap();
        let cells = Space::discontinuous_scalar(&mesh, 0).unwrap();
        let stiffness = Field::interpolate(&cells, |x| 1.0 + x[0]).unwrap();
        let start = Field::interpolate(&space, |x| [0.0, 0.3 * x[0] * x[0]]).unwrap();
        let rate = Field::interpolate(&space, |x| [0.05 * x[0], 0.2 * x[0]]).unwrap();
        let pulls: Vec<f64> = (0..STEPS).map(|step| 0.4 + 0.1 * step as f64).collect();
        let controls = Controls::new()
            .number("density", 1.3)
            .field("stiffness", &stiffness)
            .per_step("pull", &pulls)
            .start("start", &start)
            .start_rate("rate", &rate);
        let nothing = || Given::constant(0.0);
        let data = swinging::data_from(forms_fem::time::operators::vector::Data::default())
            .density(0.0)
            .stiffness(nothing())
            .pull(0.0)
            .d_density(0.0)
            .d_stiffness(nothing())
            .d_pull(0.0);
        let criterion = swinging::Model { data, regions: swinging::Regions::default() };
        Body { space, held, controls, criterion }
    }

    /// Its motion, with rates of first and second order, and a criterion over all steps, at a point, and of the controls.
    pub fn history<'a>(
        &'a self,
        sizes: impl Into<StepSizes>,
        scheme: impl Scheme + 'a,
    ) -> MotionHistory<'a, 2> {
        self.free_history(sizes, scheme).constrained(&self.held)
    }

    /// The same, which nothing holds.
    pub fn free_history<'a>(
        &'a self,
        sizes: impl Into<StepSizes>,
        scheme: impl Scheme + 'a,
    ) -> MotionHistory<'a, 2> {
        let observed = Observations::new(&self.space).at_point(&[0.7, 0.2], &[0.0, 0.1], 2.0).unwrap();
        MotionHistory::new(&self.space, sizes, scheme, self.controls.clone())
            .motion(|during| Ok(swung(during, None)?.motion()))
            .sensitivities(|during, u, p| Ok(swung(during, None)?.sensitivities(u, p)))
            .second_sensitivities(|during, states| {
                let [dvalue, drate, dsecond_rate] = states.changes;
                let (u, p, dp) = (states.u, states.p, states.dp);
                Ok(swung(during, Some(states))?.motion_second_sensitivities(
                    u,
                    p,
                    dvalue,
                    drate,
                    dsecond_rate,
                    dp,
                ))
            })
            .criterion(|_| Ok(self.criterion.misfit()))
            .observed(2, observed)
            .with_cost_of_controls(|m| {
                (m[0].powi(4), [vec![4.0 * m[0].powi(3)], vec![0.0; m.len() - 1]].concat())
            })
            .with_curvature_of_controls(|m, d| {
                [vec![12.0 * m[0].powi(2) * d[0]], vec![0.0; m.len() - 1]].concat()
            })
            .options(NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() })
    }

    /// A direction of all controls, except for what is held at the start.
    pub fn direction(&self, phase: f64) -> Vec<f64> {
        let count = self.controls.values().len();
        let mut direction: Vec<f64> = (0..count).map(|k| 0.2 * (phase + 1.7 * k as f64).sin()).collect();
        for start in ["start", "rate"] {
            let from = self.controls.places(start).unwrap().start;
            self.held.prescribed().keys().for_each(|unknown| direction[from + unknown] = 0.0);
        }
        direction
    }
}
