//! Identities between the paper's forms, on bodies in the plane and in space.

use forms_contact::forms;
use forms_contact::hollow_cylinder::{Settings, solve};
use forms_fem::prelude::*;
use forms_tests::bodies::{Body, CONTACT, EXTENSION, LOADED, data, plane_bodies, solid_bodies, wave};
use forms_tests::dense::{assert_close, assert_same_matrix, dense, deviation};

/// The paper's formulas typed by hand, to be compared with what the compiler derives.
#[forms]
mod by_hand {
    pub use forms_contact::forms::{Boundary, Data, GammaC, Omega};

    fn sigma(w: Vector) -> Tensor {
        lambda * div(w) * I + mu * (grad(w) + transpose(grad(w)))
    }
    fn sigma_n(w: Vector) -> Scalar {
        dot(sigma(w) * n, obstacle_normal)
    }
    fn gamma() -> Scalar {
        gamma0 / h
    }
    fn normal_part(w: Vector) -> Scalar {
        dot(w, obstacle_normal)
    }
    fn beta(w: Vector) -> Scalar {
        gamma() * (normal_part(w) - gap) - sigma_n(w)
    }

    /// (21): a(p,q) − ∫(θ/γ)σ_n(p)σ_n(q) + ∫(1/γ)H(β)(σ_n(q) − γq_n)(θσ_n(p) − γp_n) + ∫M′q + ∫N′q.
    pub fn discrete_adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        let first = sigma_n(q) - gamma() * normal_part(q);
        let second = theta * sigma_n(p) - gamma() * normal_part(p);
        integral(Omega, inner(sigma(p), grad(q)) + dot(criterion_force, q))
            - integral(GammaC, theta / gamma() * sigma_n(p) * sigma_n(q))
            + integral(GammaC, heaviside(beta(u)) / gamma() * first * second)
            + integral(Boundary, criterion_weight * dot(u, q))
    }

    /// (15) as printed, with PLUS before the integral of the negative part; without loads.
    pub fn as_printed(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(sigma(u), grad(v)))
            - integral(GammaC, theta / gamma() * sigma_n(u) * sigma_n(v))
            + integral(GammaC, neg_part(-beta(u)) / gamma() * (theta * sigma_n(v) - gamma() * normal_part(v)))
    }
}

/// Results of the forms at a body's state: matrix, and the residual at some p.
struct System {
    matrix: nalgebra::DMatrix<f64>,
    residual: Vec<f64>,
}

fn system<const D: usize>(body: &Body<D>, form: &Form<D>) -> System {
    let p = wave(&body.space, 1.0, 0.8);
    let matrix = body.assembler.tangent(form, &[&p], &[&body.space]).unwrap();
    let residual = body.assembler.residual(form, &[&p], &[&body.space]).unwrap();
    System { matrix: dense(&matrix), residual }
}

fn tangent<const D: usize>(body: &Body<D>, form: &Form<D>) -> nalgebra::DMatrix<f64> {
    dense(&body.assembler.tangent(form, &[&body.u], &[&body.space]).unwrap())
}

fn check<const D: usize>(body: &Body<D>)
where
    Dim: Dimension<D>,
{
    let tolerance = 1e-13;
    let (omega, gamma_c) = (by_hand::Omega::on("all"), by_hand::GammaC::on(CONTACT));
    let boundary = by_hand::Boundary::on("boundary");
    for theta in [-1.0, 0.0, 1.0] {
        let label = |what: &str| format!("{}, theta = {theta}: {what}", body.name);
        let data = data(theta);
        let newton = tangent(body, &body.direct(theta));
        let discrete = system(body, &body.discrete_adjoint(&data));
        let consistent = system(body, &body.consistent_adjoint(&data));

        // (21) derived is (21) written out.
        let hand = by_hand::discrete_adjoint(&data, &omega, &gamma_c, &boundary, &body.u);
        let hand = system(body, &hand);
        assert_same_matrix(&label("(21) by hand"), &discrete.matrix, &hand.matrix, tolerance);
        assert_close(&label("(21) by hand"), &discrete.residual, &hand.residual, tolerance);

        // Its matrix is the tangent transposed, that of (22) the tangent itself.
        assert_same_matrix(&label("(21)"), &discrete.matrix, &newton.transpose(), tolerance);
        assert_same_matrix(&label("(22)"), &consistent.matrix, &newton, tolerance);
        if theta != 1.0 {
            for (what, matrix) in [("(21)", &discrete.matrix), ("(22)", &consistent.matrix.transpose())] {
                let found = deviation(matrix.as_slice(), newton.as_slice());
                assert!(found > 1e-3, "{}", label(what));
            }
        }

        // With the printed sign the tangent is another matrix.
        let printed = by_hand::as_printed(&data, &omega, &gamma_c);
        let printed = tangent(body, &printed);
        let found = deviation(printed.as_slice(), consistent.matrix.as_slice());
        assert!(found > 1e-2, "{}: {found:.1e}", label("printed sign"));
        // It differs by twice the contact term, so that the mean of both is the form without contact.
        let apart = data.clone().gap(1e6);
        let (omega, gamma_n) = (forms::Omega::on("all"), forms::GammaN::on(LOADED));
        let apart = forms::direct(&apart, &omega, &gamma_n, &forms::GammaC::on(CONTACT));
        let mean = (&printed + &consistent.matrix) * 0.5;
        assert_same_matrix(&label("printed sign"), &mean, &tangent(body, &apart), 1e-12);

        // N′ = 0 on Γ_C: (22) is (21) for θ = 1, and only there.
        for weight in [Given::constant(0.0), Given::function(without_contact(body))] {
            let data = data.clone().criterion_weight(weight);
            let discrete = system(body, &body.discrete_adjoint(&data));
            let consistent = system(body, &body.consistent_adjoint(&data));
            let matrix = deviation(consistent.matrix.as_slice(), discrete.matrix.as_slice());
            let residual = deviation(&consistent.residual, &discrete.residual);
            let same = matrix < tolerance && residual < tolerance;
            assert_eq!(same, theta == 1.0, "{}: {matrix:.1e} {residual:.1e}", label("(22) and (21)"));
        }
        if theta == 1.0 {
            // With N′ ≠ 0 there, the right sides differ even so.
            let found = deviation(&consistent.residual, &discrete.residual);
            assert!(found > 1e-4, "{}: {found:.1e}", label("N on the contact boundary"));
        }

        // (41) without extension is (22); with one it is not.
        for (extension, same) in [(0.0, true), (EXTENSION, false)] {
            let data = data.clone().extension(extension);
            let extended = system(body, &body.extended_adjoint(&data));
            let matrix = deviation(extended.matrix.as_slice(), consistent.matrix.as_slice());
            let residual = deviation(&extended.residual, &consistent.residual);
            assert_eq!(matrix == 0.0, same, "{}: {matrix:.1e}", label("(41)"));
            assert_eq!(residual == 0.0, same, "{}: {residual:.1e}", label("(41)"));
        }
    }
}

/// A weight that vanishes on Γ_C, but not on the rest of the boundary.
fn without_contact<const D: usize>(body: &Body<D>) -> impl Fn(&[f64; D]) -> f64 + Send + Sync + 'static {
    let level = 0.5 * body.space.mesh().bounds().1[D - 1];
    let weight = move |x: &[f64; D]| (x[D - 1] - level).max(0.0);
    let zero_at = |node: &u32| weight(&body.space.positions()[*node as usize]) == 0.0;
    assert!(body.space.nodes_on(CONTACT).unwrap().iter().all(zero_at), "{}", body.name);
    assert!(!body.space.nodes_on("boundary").unwrap().iter().all(zero_at), "{}", body.name);
    weight
}

#[test]
fn between_the_forms_in_the_plane() {
    plane_bodies().iter().for_each(check);
}

#[test]
fn between_the_forms_in_space() {
    solid_bodies().iter().for_each(check);
}

/// The three variants solve one problem: their J and norms approach each other as the mesh is refined.
#[test]
fn variants_agree_as_the_mesh_is_refined() {
    let measure = |radial: usize| -> Vec<[f64; 4]> {
        [-1.0, 0.0, 1.0]
            .map(|theta| {
                let settings = Settings { radial, theta, ..Settings::default() };
                let solution = solve(&settings).unwrap();
                let h1 = |field| norms::norms(&solution.problem.assembler, field).unwrap().h1;
                [solution.criterion, h1(&solution.u), h1(&solution.p_consistent), solution.contact_force]
            })
            .to_vec()
    };
    // Largest relative difference between two variants of J, ‖u‖, ‖p‖, contact force.
    let spread = |found: &[[f64; 4]]| -> [f64; 4] {
        std::array::from_fn(|k| {
            let values = found.iter().map(|row| row[k]);
            let (low, high) =
                (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max));
            (high - low) / found[0][k].abs()
        })
    };
    let spreads = [2, 4, 8].map(|radial| spread(&measure(radial)));
    println!("J, |u|, |p|, force: {spreads:?}");
    for (k, name) in ["J", "norm of u", "norm of p", "contact force"].into_iter().enumerate() {
        assert!(spreads[2][k] < 0.25 * spreads[0][k], "{name}: {spreads:?}");
        assert!(spreads[2][k] < 1e-3, "{name}: {spreads:?}");
    }
}
