//! The operators of `forms_contact::operators`, imported into another crate, against closed forms of homogeneous
//! deformations; and the balance of Nitsche's contact terms composed from them for a nonlinear material.

use forms_fem::prelude::*;

const LAMBDA: f64 = 1.3;
const MU: f64 = 0.7;

#[forms]
mod materials {
    use forms_contact::operators::linear_elastic::energy_density as linear;
    use forms_contact::operators::neo_hookean::{cauchy_stress, energy_density as neo_hookean, first_piola};
    use forms_contact::operators::obstacle::{nitsche_density, normal_component, penalty_density};
    use forms_contact::operators::st_venant_kirchhoff::{
        energy_density as st_venant, first_piola as st_venant_piola,
    };

    pub struct Data {
        /// A constant in the library.
        pub lambda: Given<Scalar>,
        pub mu: Param,
        pub obstacle_normal: Given<Vector>,
        pub gap: Given<Scalar>,
        pub gamma0: Param,
        pub theta: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaC;

    pub fn linear_energy(u: State<Vector>) -> Functional {
        integral(Omega, linear(u))
    }
    pub fn st_venant_energy(u: State<Vector>) -> Functional {
        integral(Omega, st_venant(u))
    }
    pub fn neo_hookean_energy(u: State<Vector>) -> Functional {
        integral(Omega, neo_hookean(u))
    }
    /// ∫ P₁₁ and ∫ σ₁₁.
    pub fn piola(u: State<Vector>) -> Functional {
        integral(Omega, first_piola(u)[0][0])
    }
    pub fn cauchy(u: State<Vector>) -> Functional {
        integral(Omega, cauchy_stress(u)[0][0])
    }
    pub fn penalty(u: State<Vector>) -> Functional {
        integral(GammaC, penalty_density(u))
    }
    /// Nitsche's method for a nonlinear material: the normal stress's derivative tests.
    pub fn contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let sigma_n = normal_component(st_venant_piola(u));
        integral(Omega, inner(st_venant_piola(u), grad(v)))
            + integral(GammaC, nitsche_density(sigma_n, u, derivative(sigma_n, u, v), v))
    }
}

fn data(gap: f64) -> materials::Data<2> {
    materials::data().lambda(LAMBDA).mu(MU).obstacle_normal([0.0, -1.0]).gap(gap).gamma0(8.0).theta(1.0)
}

fn body(a: f64, b: f64) -> (Mesh<2>, Field<2>) {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [2, 2], CellShape::Triangle, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let u = Field::interpolate(&space, |x| [a * x[0], b * x[1]]).unwrap();
    (mesh, u)
}

fn assert_close(found: f64, exact: f64) {
    assert!((found - exact).abs() <= 1e-13 * exact.abs().max(1.0), "{found} is not {exact}");
}

#[test]
fn energies_and_stresses_of_a_homogeneous_deformation() {
    let (a, b, area) = (0.3, -0.2, 2.0);
    let (mesh, u) = body(a, b);
    let (assembler, data, omega) = (Assembler::new(&mesh), data(0.1), materials::Omega::on("all"));
    let value = |density: f64| area * density;
    let quadratic = |e: f64, f: f64| MU * (e * e + f * f) + LAMBDA / 2.0 * (e + f) * (e + f);
    let found = assembler.functional(&materials::linear_energy(&data, &omega, &u)).unwrap();
    assert_close(found, value(quadratic(a, b)));
    // E = ((1 + a)² − 1)/2 in each direction.
    let green = |a: f64| a + a * a / 2.0;
    let found = assembler.functional(&materials::st_venant_energy(&data, &omega, &u)).unwrap();
    assert_close(found, value(quadratic(green(a), green(b))));
    let (f1, f2) = (1.0 + a, 1.0 + b);
    let j = (f1 * f2).ln();
    let energy = MU / 2.0 * (f1 * f1 + f2 * f2 - 2.0 - 2.0 * j) + LAMBDA / 2.0 * j * j;
    let found = assembler.functional(&materials::neo_hookean_energy(&data, &omega, &u)).unwrap();
    assert_close(found, value(energy));
    let piola = MU * (f1 - 1.0 / f1) + LAMBDA * j / f1;
    assert_close(assembler.functional(&materials::piola(&data, &omega, &u)).unwrap(), value(piola));
    // σ = P Fᵀ / J.
    let cauchy = assembler.functional(&materials::cauchy(&data, &omega, &u)).unwrap();
    assert_close(cauchy, value(piola * f1 / (f1 * f2)));
}

#[test]
fn the_penalty_energy_is_that_of_the_penetration() {
    // The bottom does not move, the gap is −0.1: γ₀/h/2 · 0.1² over a length of 2, h the diagonal of half a cell.
    let (mesh, u) = body(0.3, -0.2);
    let form = materials::penalty(&data(-0.1), &materials::GammaC::on("bottom"), &u);
    let found = Assembler::new(&mesh).functional(&form).unwrap();
    assert_close(found, 8.0 / (1.0_f64 + 0.25).sqrt() / 2.0 * 0.01 * 2.0);
}

#[test]
fn nitsche_terms_are_consistent_where_the_body_presses_with_its_own_stress() {
    // b < 0 presses: P₂₂ < 0 on the whole body. Where u_n = g, the pressure is −P₂₂, and the terms with the stress's
    // derivative cancel, so that the residual is that of the body with P₂₂ as a traction: zero except on the other sides.
    let (a, b) = (0.0, -0.2);
    let (mesh, u) = body(a, b);
    let form = materials::contact(&data(0.0), &materials::Omega::on("all"), &materials::GammaC::on("bottom"));
    let residual = Assembler::new(&mesh).residual(&form, &[&u], &[u.space()]).unwrap();
    let green = |a: f64| a + a * a / 2.0;
    let (e1, e2) = (green(a), green(b));
    let second = |e: f64| 2.0 * MU * e + LAMBDA * (e1 + e2);
    assert!(second(e2) < 0.0);
    let sum = |weights: fn(&[f64; 2]) -> [f64; 2]| {
        let v = Field::interpolate(u.space(), weights).unwrap();
        residual.iter().zip(v.values()).map(|(residual, v)| residual * v).sum::<f64>()
    };
    // v = (0, y) vanishes at the bottom: ∫ P₂₂ over the area 2. v = (0, 1): the bottom's own force −P₂₂ · 2 upward.
    assert_close(sum(|x| [0.0, x[1]]), 2.0 * (1.0 + b) * second(e2));
    assert_close(sum(|_| [0.0, 1.0]), 2.0 * (1.0 + b) * second(e2));
    // With v = (0, 1 − y), zero at the top, nothing is left: the obstacle carries what the body presses with.
    assert_close(sum(|x| [0.0, 1.0 - x[1]]), 0.0);
}

#[test]
fn one_form_with_an_imported_operator_solves_poissons_equation_of_elasticity() {
    // −div σ(u) = 0 with u = (x, 0) on the boundary: u is that everywhere.
    let mesh = rectangle([0.0; 2], [1.0; 2], [3, 3], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let (lambda, mu) = (LAMBDA, MU);
    let elasticity = form!(
        use forms_contact::operators::linear_elastic::stress;
        |u: Unknown<Vector>, v: Test<Vector>| integral(cells("all"), inner(stress(u), grad(v))),
        lambda: Param,
        mu: Param,
    );
    let mut constraints = Constraints::new(&space);
    constraints.fix("boundary", |x| [x[0], 0.0]).unwrap();
    let problem = Problem::new(&elasticity, &space);
    let u = problem.constrained(&constraints).solve().unwrap().into_field();
    let inside = u.evaluate(&[0.4, 0.7]).unwrap();
    assert!((inside[0] - 0.4).abs() < 1e-13 && inside[1].abs() < 1e-13, "{inside:?}");
}
