//! Tutorial 7: discontinuous elements. Poisson's equation by the symmetric interior penalty method.
//!
//! Neighbouring cells share no unknowns. Integrals over the facets between cells couple them. The exact solution
//! `u = cos(πx) eʸ` is known, so the program can measure the order at which the error falls: the degree plus one.
//!
//! Run it with `cargo run --release --bin 07_interior_penalty`.

use std::f64::consts::PI;

use forms_fem::output::picture::{Curve, LinePlot, Picture, Scale};
use forms_fem::prelude::*;

#[forms]
mod diffusion {
    pub struct Data {
        /// Large enough to hold the jumps down: about 10 times the square of the degree.
        pub penalty: Param,
        pub source: Given<Scalar>,
        pub exact: Given<Scalar>,
    }

    #[cells]
    pub struct Omega;
    // A region of facets between two cells. Here `jump(u)` is u of this side less u of the other, `avg(u)`
    // their mean, and the normal `n` points from this side to the other.
    #[interior_facets]
    pub struct Inner;
    #[facets]
    pub struct Boundary;

    fn mean_slope(w: Scalar) -> Scalar {
        dot(avg(grad(w)), n)
    }

    /// The three terms inside make it consistent, symmetric and stable, in this order; those on the boundary
    /// do the same for the boundary values, so that no unknown is prescribed.
    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let rest = u - exact;
        integral(Omega, dot(grad(u), grad(v)) - source * v)
            - integral(Inner, mean_slope(u) * jump(v))
            - integral(Inner, mean_slope(v) * jump(u))
            + integral(Inner, penalty / avg(h) * jump(u) * jump(v))
            + integral(Boundary, penalty / h * rest * v - dot(grad(u), n) * v - dot(grad(v), n) * rest)
    }
}

fn solution(x: &[f64; 2]) -> f64 {
    (PI * x[0]).cos() * x[1].exp()
}

/// ‖u_h − u‖ in L² on n × n squares, each cut into two triangles.
fn error(n: usize, degree: usize) -> Result<f64, Failure> {
    let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [n, n], CellShape::Triangle, 1)?;
    let space = Space::discontinuous_scalar(&mesh, degree)?;
    let data = diffusion::data()
        .penalty(10.0 * (degree * degree) as f64)
        .source(|x: &[f64; 2]| (PI * PI - 1.0) * solution(x))
        .exact(solution);
    // Every mesh knows "interior", the facets between cells, and "boundary": what the regions are called by default.
    let form = diffusion::Model::new(data).balance();
    let solved = Problem::new(&form, &space).quadrature(Quadrature::Degree(6)).solve()?;

    let slope = |x: &[f64; 2], out: &mut [f64]| {
        out[0] = -PI * (PI * x[0]).sin() * x[1].exp();
        out[1] = solution(x);
    };
    Ok(norms::errors(solved.assembler(), solved.field(), |x, out| out[0] = solution(x), slope)?.l2)
}

fn main() -> Result<(), Failure> {
    let divisions = [4, 8, 16, 32];
    let mut plot = LinePlot::new()
        .x_axis("cells per side", Scale::Logarithmic)
        .y_axis("error in L²", Scale::Logarithmic);
    println!("degree  cells per side     error  order");
    for degree in [1, 2] {
        let mut errors = Vec::new();
        let mut order = f64::NAN;
        for n in divisions {
            let found = error(n, degree)?;
            order = errors.last().map_or(f64::NAN, |last: &f64| (last / found).log2());
            let shown = if order.is_nan() { String::new() } else { format!("{order:.2}") };
            println!("{degree:6} {n:15} {found:9.2e} {shown:>6}");
            errors.push(found);
        }
        let expected = (degree + 1) as f64;
        assert!((order - expected).abs() < 0.1, "degree {degree}: order {order}, expected {expected}");
        let x: Vec<f64> = divisions.iter().map(|n| *n as f64).collect();
        plot = plot.curve(Curve::new(&format!("degree {degree}"), &x, &errors).slope_triangle(-expected));
    }

    plot.write_png("out/07_interior_penalty.png")?;
    Ok(())
}
