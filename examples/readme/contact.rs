//! Frictionless contact by Nitsche's method, and an adjoint state.

use forms_fem::prelude::*;

#[forms]
mod nitsche {
    use forms_contact::operators::linear_elastic::stress;
    use forms_contact::operators::obstacle::{augmented_stress, gamma, nitsche_test, normal_component};

    /// λ, μ; n_y, g, γ₀, θ.
    #[includes(forms_contact::operators::linear_elastic::Data, forms_contact::operators::obstacle::Data)]
    pub struct Data {}
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Bottom;

    fn normal_stress(w: Vector) -> Scalar {
        normal_component(stress(w))
    }
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let pressure = neg_part(augmented_stress(normal_stress(u), u));
        integral(Omega, inner(stress(u), eps(v)))
            - integral(Bottom, theta / gamma() * normal_stress(u) * normal_stress(v))
            - integral(Bottom, pressure / gamma() * nitsche_test(normal_stress(v), v))
    }
    pub fn energy(u: State<Vector>) -> Functional {
        integral(Omega, inner(stress(u), eps(u)) / 2)
    }
    /// The discrete adjoint (21): nothing typed by hand.
    pub fn adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(energy(u), u, q)
    }
}

fn main() -> Result<(), Failure> {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [32, 16], CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&mesh, 2)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix("top", |_| [0.0, -0.1])?;

    let data = nitsche::data().lambda(1.0).mu(1.0).gamma0(20.0).obstacle_normal([0.0, -1.0]);
    let data = data.gap(|x: &[f64; 2]| x[1] + 0.1 * (x[0] - 1.0).powi(2)).theta(1.0);
    let model = nitsche::Model::new(data);

    // A kink is no polynomial: a higher degree than the polynomials next to it need.
    let problem = Problem::new(&model.direct(), &space).quadrature(Quadrature::Degree(6));
    let solved = problem.constrained(&constraints).solve()?;
    let u = solved.field();
    let problem = Problem::new(&model.adjoint(u), &space).assembler(solved.assembler());
    let p = problem.homogeneous(&constraints).solve()?;
    println!("energy {:.4}, Newton steps {}", solved.functional(&model.energy(u))?, solved.iterations());
    println!("p in the middle of the contact {:?}", p.field().evaluate(&[1.0, 0.0])?);
    Ok(())
}
