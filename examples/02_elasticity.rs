//! Tutorial 2: linear elasticity. A thick-walled pipe under internal pressure, Lamé's problem.
//!
//! Plane strain, inner radius a, outer radius b, pressure p inside. In closed form the radial displacement is
//!
//! ```text
//! u_r(r) = (1+ν)/E · p a²/(b²−a²) · ((1−2ν) r + b²/r)
//! ```
//!
//! and the hoop stress at the inner wall is `p (a²+b²)/(b²−a²)`.
//!
//! Run it with `cargo run --release --bin 02_elasticity`.

use forms_fem::output::picture::{FieldMap, Picture, Shown};
use forms_fem::prelude::*;

#[forms]
mod pipe {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub pressure: Param,
    }

    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Inside;

    // Local functions take arguments of any rank. This one is called below with the unknown and with the
    // known displacement, and being `pub` it can be evaluated by itself as well: a derived field.
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }

    /// The pressure pushes against the outward normal `n`, which exists on facets only.
    pub fn equilibrium(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) + integral(Inside, pressure * dot(n, v))
    }

    /// The stress along the wall: in the plane, the trace less the normal stress.
    pub fn hoop_stress(u: State<Vector>) -> Scalar {
        tr(stress(u)) - dot(stress(u) * n, n)
    }
}

const INNER: f64 = 20.0; // mm
const OUTER: f64 = 30.0; // mm
const YOUNG: f64 = 200e3; // MPa
const POISSON: f64 = 0.3;
const PRESSURE: f64 = 100.0; // MPa

fn main() -> Result<(), Failure> {
    // Curved cells: the nodes of the second-order geometry lie on the circles.
    let mesh = annulus(INNER, OUTER, 4, 48, CellShape::Quadrilateral, 2)?;
    let space = Space::vector(&mesh, 2)?;

    // Only symmetry holds the pipe: no vertical motion where y = 0, no horizontal motion where x = 0.
    let mut constraints = Constraints::new(&space);
    for node in space.nodes_on("inner")? {
        let [x, y] = space.positions()[node as usize];
        if y.abs() < 1e-9 {
            constraints.fix_node(node as usize, 1, 0.0)?;
        } else if x.abs() < 1e-9 {
            constraints.fix_node(node as usize, 0, 0.0)?;
        }
    }

    let data = pipe::data()
        .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
        .mu(YOUNG / (2.0 * (1.0 + POISSON)))
        .pressure(PRESSURE);
    let model = pipe::Model { data, regions: pipe::Regions::default().inside("inner") };
    let problem = Problem::new(&model.equilibrium(), &space).quadrature(Quadrature::Degree(6));
    let solved = problem.constrained(&constraints).solve()?;
    let u = solved.field();

    // A function of the module, evaluated along a facet region: three points on each facet.
    let hoop = solved.assembler().along_facets_uniformly(&model.hoop_stress(u), "inner", 3)?;
    let hoop = hoop.iter().map(|sample| sample.value[0]).fold(f64::NEG_INFINITY, f64::max);
    let (a2, b2) = (INNER * INNER, OUTER * OUTER);
    let exact_hoop = PRESSURE * (a2 + b2) / (b2 - a2);
    let radial =
        |r: f64| (1.0 + POISSON) / YOUNG * PRESSURE * a2 / (b2 - a2) * ((1.0 - 2.0 * POISSON) * r + b2 / r);
    let (opening, exact_opening) = (u.evaluate(&[INNER, 0.0])?[0], radial(INNER));
    println!("u_r inside      {opening:.6} mm    Lamé {exact_opening:.6} mm");
    println!("hoop stress     {hoop:.3} MPa    Lamé {exact_hoop:.3} MPa");

    FieldMap::of(u, Shown::Magnitude, "|u| [mm]")
        .length_unit("mm")
        .deformed(u, 100.0)
        .write_png("out/02_elasticity.png")?;

    assert!((opening - exact_opening).abs() < 1e-4 * exact_opening, "u_r = {opening}");
    assert!((hoop - exact_hoop).abs() < 5e-3 * exact_hoop, "hoop stress {hoop}");
    Ok(())
}
