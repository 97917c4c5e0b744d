//! Tutorial 10: two fields that act on each other. A pipe is hot inside and cold outside. Its hot part cannot expand
//! freely, so the pipe is stressed.
//!
//! With the temperature `T = ΔT ln(b/r)/ln(b/a)`, plane strain and free surfaces, the hoop stress is
//! `K (1 − 2b²/(b²−a²) ln(b/a))` inside and `K (1 − 2a²/(b²−a²) ln(b/a))` outside, with `K = E α ΔT / (2 (1−ν) ln(b/a))`.
//!
//! Run it with `cargo run --release --bin 10_thermoelasticity`.

use forms_fem::output::picture::{FieldMap, Picture, Shown};
use forms_fem::prelude::*;

#[forms]
mod pipe {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        /// Thermal expansion per degree.
        pub expansion: Param,
        pub conductivity: Param,
    }

    #[cells]
    pub struct Omega;

    /// The stress of the strain beyond the free thermal expansion α T I.
    fn stress(w: Vector, T: Scalar) -> Tensor {
        2 * mu * eps(w) + (lambda * tr(eps(w)) - (3 * lambda + 2 * mu) * expansion * T) * I
    }

    /// Equilibrium and conduction in one form. The heat does not feel the strain here: the compiler sees that
    /// this block of the tangent vanishes, and nobody computes or stores it.
    pub fn balance(u: Unknown<Vector>, T: Unknown<Scalar>, v: Test<Vector>, s: Test<Scalar>) -> Form {
        integral(Omega, inner(stress(u, T), eps(v)) + conductivity * dot(grad(T), grad(s)))
    }

    /// The stress along the wall: in the plane, the trace less the normal stress.
    pub fn hoop_stress(u: State<Vector>, T: State<Scalar>) -> Scalar {
        tr(stress(u, T)) - dot(stress(u, T) * n, n)
    }
}

const INNER: f64 = 20.0; // mm
const OUTER: f64 = 30.0; // mm
const YOUNG: f64 = 200e3; // MPa
const POISSON: f64 = 0.3;
const EXPANSION: f64 = 1.2e-5; // 1/K
const HOTTER: f64 = 100.0; // K

fn main() -> Result<(), Failure> {
    let mesh = annulus(INNER, OUTER, 8, 64, CellShape::Quadrilateral, 2)?;
    let (displacements, temperatures) = (Space::vector(&mesh, 2)?, Space::scalar(&mesh, 2)?);

    // Each unknown has its own constraints. Only symmetry holds the pipe.
    let mut held = Constraints::new(&displacements);
    for node in displacements.nodes_on("inner")? {
        let [x, y] = displacements.positions()[node as usize];
        if y.abs() < 1e-9 {
            held.fix_node(node as usize, 1, 0.0)?;
        } else if x.abs() < 1e-9 {
            held.fix_node(node as usize, 0, 0.0)?;
        }
    }
    let mut heated = Constraints::new(&temperatures);
    heated.fix("inner", |_| HOTTER)?;
    heated.fix("outer", |_| 0.0)?;

    let data = pipe::data()
        .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
        .mu(YOUNG / (2.0 * (1.0 + POISSON)))
        .expansion(EXPANSION)
        // W/(mm K); without sources its size does not matter
        .conductivity(0.045);
    let model = pipe::Model::new(data);
    let problem = Problem::new(&model.balance(), [&displacements, &temperatures]);
    let problem = problem.quadrature(Quadrature::Degree(6)).constrained(&held);
    let solved = problem.constrained(&heated).solve()?;
    let [u, temperature] = &solved.fields;

    let ratio = (OUTER / INNER).ln();
    let factor = YOUNG * EXPANSION * HOTTER / (2.0 * (1.0 - POISSON) * ratio);
    let closed_form = |radius: f64| {
        let across = OUTER * OUTER - INNER * INNER;
        factor * (1.0 - 2.0 * (INNER * OUTER / radius).powi(2) / across * ratio)
    };
    let mut largest_error = 0.0_f64;
    for (wall, radius) in [("inner", INNER), ("outer", OUTER)] {
        let stress = model.hoop_stress(u, temperature);
        let samples = solved.assembler().along_facets_uniformly(&stress, wall, 3)?;
        let mean = samples.iter().map(|sample| sample.value[0]).sum::<f64>() / samples.len() as f64;
        let exact = closed_form(radius);
        println!("hoop stress, {wall} wall  {mean:9.3} MPa, closed form {exact:9.3}");
        largest_error = largest_error.max((mean - exact).abs() / exact.abs());
    }

    FieldMap::of(temperature, Shown::Component(0), "temperature [K]")
        .deformed(u, 100.0)
        .undeformed_outline("cold")
        .length_unit("mm")
        .write_png("out/10_thermoelasticity.png")?;

    assert!(largest_error < 5e-3, "the hoop stress is off by {largest_error:.1e}");
    Ok(())
}
