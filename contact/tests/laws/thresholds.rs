//! Thresholds of γ₀ as the laws give them, compared with figures of an independent computation; the law's own forms compared with the
//! material.

use forms_contact::ContactProblem;
use forms_contact::hollow_cylinder::{CONTACT, CONTACT_CELLS, Settings, hollow_cylinder};
use forms_contact::law::ContactLaw;
use forms_contact::laws::finite_nitsche;
use forms_contact::laws::frictional_nitsche;
use forms_contact::laws::frictional_penalty;
use forms_contact::laws::two_bodies;
use forms_contact::threshold::required_gamma0;
use forms_fem::prelude::*;

use crate::setting::{LAMBDA, MU, YOUNG, close};

/// The paper's cylinder: the figures of `tests/tests/threshold.rs`, from the bare matrices of every contact cell.
#[test]
fn the_cylinder_by_its_law_and_by_its_material() {
    for (radial, figure) in [(1, 9.083243389147466), (4, 9.425185180562158)] {
        let settings = Settings { theta: 1.0, radial, ..Settings::default() };
        let problem = hollow_cylinder(&settings).unwrap();
        let threshold = problem.threshold().unwrap().unwrap();
        close("by the law", threshold.required / settings.young, figure, 1e-10);
        assert_eq!(required_gamma0(&problem, CONTACT_CELLS).unwrap(), threshold.required);
        // γ₀ = 10 E is above it, and 9 E is not.
        assert_eq!(threshold.warning(), None);
        let mut below = problem.clone();
        below.law.data.gamma0 = 9.0 * settings.young;
        assert!(below.threshold().unwrap().unwrap().warning().unwrap().contains("asks for more than"));

        // With friction the whole traction counts, in the law's forms and in the material's.
        let base = problem.law.data.clone();
        let data = frictional_nitsche::data_from(base);
        let regions = frictional_nitsche::Regions::default().gamma_n("outer").gamma_c(CONTACT);
        let law = frictional_nitsche::Model { data: data.clone(), regions };
        let own = law.threshold(&problem.assembler, &problem.space).unwrap().unwrap();
        let regions = finite_nitsche::Regions::default().gamma_n("outer").gamma_c(CONTACT);
        let finite = finite_nitsche::Model { data: data.clone(), regions };
        let of_material = finite.threshold(&problem.assembler, &problem.space).unwrap().unwrap();
        // θ = 0 at finite strain, θ = 1 with friction.
        close("by the material", 4.0 * of_material.required, own.required, 1e-10);
        close("its γ₀", of_material.gamma0, own.gamma0, 1e-10);
        let regions = frictional_penalty::Regions::default().gamma_n("outer").gamma_c(CONTACT);
        let penalty = frictional_penalty::Model { data, regions };
        assert_eq!(penalty.threshold(&problem.assembler, &problem.space).unwrap(), None);
    }
}

/// Two bodies, the upper one a hundred times stiffer: each has its own threshold, and half of it where both surfaces are integrated over.
#[test]
fn bodies_of_different_stiffness() {
    let mesh = crate::two_bodies::layers::<2>(CellShape::Triangle, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let cells = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let field = |lower: f64, upper: f64| {
        let value = move |x: &[f64; 2]| if x[1] < 0.5 { lower } else { upper };
        Given::field(Field::interpolate(&cells, value).unwrap())
    };
    let of = |pairing: Pairing, share: f64, gamma0: [f64; 2]| {
        let required = two_bodies::data()
            .lambda(field(LAMBDA, 100.0 * LAMBDA))
            .mu(field(MU, 100.0 * MU))
            .gamma0(field(gamma0[0], gamma0[1]));
        let data = required.share(share);
        let regions = two_bodies::Regions::default().touch(pairing).gamma_n("upper top");
        let held = Constraints::new(&space);
        let law = two_bodies::Model { data, regions };
        let problem = ContactProblem::new(&space, law, held);
        problem.threshold().unwrap().unwrap()
    };
    let soft = of(Pairing::onto("lower top", "upper bottom"), 1.0, [YOUNG; 2]);
    // One triangle of degree 1 with the facet below it: ¼ (λ + 2μ) |F|/|T| h.
    let height: f64 = 0.25;
    close("lower", soft.required, 0.25 * (LAMBDA + 2.0 * MU) * 2.0 / height * 0.5_f64.hypot(height), 1e-10);
    let both = of(Pairing::between("lower top", "upper bottom"), 0.5, [YOUNG, YOUNG]);
    // The upper one is the worst.
    let stiff = of(Pairing::onto("upper bottom", "lower top"), 1.0, [YOUNG; 2]);
    close("upper", both.required, 0.5 * stiff.required, 1e-10);
    assert!(both.worst.as_ref().unwrap()[1] > 0.5 && both.warning().is_some());
    // Of moduli in proportion the lower one is, on its longer facets.
    let scaled = of(Pairing::between("lower top", "upper bottom"), 0.5, [YOUNG, 100.0 * YOUNG]);
    close("both", scaled.gamma0 / scaled.required, YOUNG / (0.5 * soft.required), 1e-10);
}
