//! Tutorial 6: two unknowns. A viscous fluid flows through a bend, driven by a difference of pressure.
//!
//! The bend is half a ring, a < r < b. Far from the ends of a long pipe, and here by the boundary conditions
//! everywhere, the flow goes along circles and the pressure falls linearly with the angle. With `G = Δp/π`
//!
//! ```text
//! u(r) = G/(2μ) (A r + B/r − r ln r)
//! ```
//!
//! where A and B are such that u(a) = u(b) = 0. The flux is the integral of u over a < r < b.
//!
//! Run it with `cargo run --release --bin 06_stokes`.

use std::f64::consts::PI;

use forms_fem::mesh::structured;
use forms_fem::output::picture::{FieldMap, Picture, Shown};
use forms_fem::prelude::*;

// This module is about a plane flow: checked and compiled for two dimensions only.
#[forms(dimension = 2)]
mod fluid {
    pub struct Data {
        pub viscosity: Param,
        /// Pressure at the inlet; that at the outlet is zero.
        pub pressure: Param,
    }

    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Inlet;
    #[facets]
    pub struct Outlet;

    fn stress(u: Vector, p: Scalar) -> Tensor {
        2 * viscosity * eps(u) - p * I
    }

    /// Two unknowns and two test functions, in this order. The sign of the term with `q` makes the system
    /// symmetric. At the outlet nothing is said: the traction is zero there.
    pub fn equilibrium(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, inner(stress(u, p), eps(v)) - q * div(u)) + integral(Inlet, pressure * dot(n, v))
    }

    pub fn flux(u: State<Vector>) -> Functional {
        integral(Outlet, dot(u, n))
    }
}

const INNER: f64 = 10.0; // mm
const OUTER: f64 = 20.0; // mm
const VISCOSITY: f64 = 0.5; // Pa s
const PRESSURE: f64 = 30.0; // Pa

/// Velocity of the closed form at a radius, and its integral from there on.
fn exact(r: f64) -> [f64; 2] {
    let (a2, b2) = (INNER * INNER, OUTER * OUTER);
    let linear = (b2 * OUTER.ln() - a2 * INNER.ln()) / (b2 - a2);
    let inverse = a2 * b2 * (INNER / OUTER).ln() / (b2 - a2);
    let factor = PRESSURE / PI / (2.0 * VISCOSITY);
    [
        factor * (linear * r + inverse / r - r * r.ln()),
        factor * (linear * r * r / 2.0 + inverse * r.ln() - r * r / 2.0 * r.ln() + r * r / 4.0),
    ]
}

fn main() -> Result<(), Failure> {
    // A square that is bent to half a ring; its sides keep their names: left is the inlet, right the outlet.
    let bend = |[s, t]: [f64; 2]| {
        let (radius, angle) = (INNER + (OUTER - INNER) * t, PI * (1.0 - s));
        [radius * angle.cos(), radius * angle.sin()]
    };
    let mesh = structured([24, 6], CellShape::Quadrilateral, 2, bend)?;

    // Taylor and Hood's pair: the velocity one degree above the pressure. Equal degrees give a singular or
    // an oscillating pressure.
    let (velocities, pressures) = (Space::vector(&mesh, 2)?, Space::scalar(&mesh, 1)?);
    let mut walls = Constraints::new(&velocities);
    walls.fix("bottom", |_| [0.0, 0.0])?;
    walls.fix("top", |_| [0.0, 0.0])?;
    // At both ends the fluid passes straight through: no velocity along the line y = 0.
    walls.fix_component("left", 0, |_| 0.0)?;
    walls.fix_component("right", 0, |_| 0.0)?;
    // The outlet fixes the level of the pressure. Without it one value would be prescribed, by constraints of its own.

    let data = fluid::data().viscosity(VISCOSITY).pressure(PRESSURE);
    let model = fluid::Model { data, regions: fluid::Regions::default().inlet("left").outlet("right") };
    let form = model.equilibrium();
    let solved = Problem::new(&form, [&velocities, &pressures]).constrained(&walls).solve()?;
    let [u, p] = &solved.fields;

    let flux = solved.functional(&model.flux(u))?;
    let exact_flux = exact(OUTER)[1] - exact(INNER)[1];
    let middle = p.evaluate(&[0.0, 15.0])?[0];
    println!("unknowns               {} + {}", velocities.unknowns(), pressures.unknowns());
    println!("flux                   {flux:.5} mm²/s, closed form {exact_flux:.5}");
    println!("pressure at the top    {middle:.5} Pa, closed form {:.5}", PRESSURE / 2.0);

    FieldMap::of(u, Shown::Magnitude, "speed [mm/s]")
        .length_unit("mm")
        .arrows(u, "velocity", "mm/s")
        .write_png("out/06_stokes.png")?;

    assert!((flux - exact_flux).abs() < 1e-3 * exact_flux, "flux {flux}, closed form {exact_flux}");
    assert!((middle - PRESSURE / 2.0).abs() < 1e-3 * PRESSURE, "pressure {middle}");
    let fastest = u.evaluate(&[0.0, 14.5])?[0];
    assert!((fastest - exact(14.5)[0]).abs() < 1e-3 * fastest, "speed {fastest}");
    Ok(())
}
