//! Nearly incompressible bodies, ν = 0.4999: elements that lock and elements that do not.

use forms_fem::prelude::*;

use crate::shared::*;

#[forms]
mod elastic {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub f: Given<Vector>,
    }
    #[cells]
    pub struct Omega;

    /// Navier's equations, for displacements that are given on the whole boundary.
    pub fn displaced(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, mu * inner(grad(u), grad(v)) + (lambda + mu) * div(u) * div(v) - dot(f, v))
    }
    /// The same with the pressure −λ div u.
    pub fn mixed(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * mu * inner(eps(u), eps(v)) - p * div(v) - q * div(u) - p * q / lambda - dot(f, v))
    }
}

const PI: f64 = std::f64::consts::PI;

/// A displacement without divergence, so that the load −μ Δu is the same for all λ.
fn exact(x: &[f64; 2]) -> [f64; 2] {
    let (s, d) = (|x: f64| (PI * x).sin() * (PI * x).sin(), |x: f64| PI * (2.0 * PI * x).sin());
    [s(x[0]) * d(x[1]), -d(x[0]) * s(x[1])]
}

fn load(x: &[f64; 2]) -> [f64; 2] {
    let (s, d) = (|x: f64| (PI * x).sin() * (PI * x).sin(), |x: f64| PI * (2.0 * PI * x).sin());
    let (dd, ddd) =
        (|x: f64| 2.0 * PI * PI * (2.0 * PI * x).cos(), |x: f64| -4.0 * PI * PI * PI * (2.0 * PI * x).sin());
    let [a, b] = *x;
    [-(dd(a) * d(b) + s(a) * ddd(b)), ddd(a) * s(b) + d(a) * dd(b)]
}

/// The error in L² for Poisson's ratio ν and μ = 1.
fn error(elements: &Elements, poissons_ratio: f64) -> f64 {
    let mesh = distorted(16, CellShape::Triangle, 1);
    let lambda = 2.0 * poissons_ratio / (1.0 - 2.0 * poissons_ratio);
    let data = elastic::data().lambda(lambda).mu(1.0).f(load);
    let omega = elastic::Omega::on("all");
    let space = Space::of(&mesh, elements.clone(), Scope::Nodes, &[2]).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(6));
    let mut walls = Constraints::new(&space);
    walls.fix("boundary", exact).unwrap();
    let u = match elements {
        Elements::Mini(_) => {
            let pressures = Space::scalar(&mesh, 1).unwrap();
            let form = elastic::mixed(&data, &omega);
            let problem = Problem::new(&form, [&space, &pressures]).assembler(&assembler);
            problem.constrained(&walls).solve().unwrap().fields[0].clone()
        }
        _ => {
            let form = elastic::displaced(&data, &omega);
            let problem = Problem::new(&form, &space).assembler(&assembler);
            problem.constrained(&walls).solve().unwrap().into_field()
        }
    };
    let value = |x: &[f64; 2], value: &mut [f64]| value.copy_from_slice(&exact(x));
    norms::errors(&assembler, &u, value, |_, slope| slope.fill(0.0)).unwrap().l2
}

#[test]
fn crouzeix_raviart_and_mini_do_not_lock() {
    let growth = |elements: Elements| {
        let [soft, stiff] = [0.3, 0.4999].map(|ratio| error(&elements, ratio));
        println!("{elements}: error {soft:.3e} at ν = 0.3, {stiff:.3e} at ν = 0.4999");
        stiff / soft
    };
    assert!(growth(Elements::CrouzeixRaviart) < 1.6);
    assert!(growth(Elements::Mini(1)) < 1.6);
    // The Lagrange element of degree 1 does.
    assert!(growth(Elements::Lagrange(1)) > 8.0);
}
