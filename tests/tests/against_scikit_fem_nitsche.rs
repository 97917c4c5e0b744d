//! The direct contact problem, its three adjoints, the criterion and the contact measures at a given state,
//! for θ ∈ {−1, 0, 1} and with N = 0 as well as N ≠ 0, against scikit-fem.

use forms_contact::forms;
use forms_fem::prelude::*;
use forms_tests::dense::{assert_close, dense};
use forms_tests::reference_file::{CONTACT, CRITERION, Family, Reference, ReferenceFile, TOLERANCE};

#[forms]
mod shifted {
    #[facets]
    pub struct GammaC;
    /// ∫ H(β − ξ), both given.
    pub fn length(indicator: State<Scalar>, extension: State<Scalar>) -> Functional {
        integral(GammaC, heaviside(indicator - extension * sqrt(h)))
    }
}

fn data(reference: &Reference<2>) -> forms::Data<2> {
    let (point, normal) = (reference.vector("obstacle_point"), reference.vector("obstacle_normal"));
    forms::data()
        .lambda(reference.number("lambda"))
        .mu(reference.number("mu"))
        .gamma0(reference.number("gamma0"))
        .obstacle_normal(normal)
        .gap(move |x: &[f64; 2]| (0..2).map(|k| normal[k] * (point[k] - x[k])).sum::<f64>())
        .theta(reference.number("theta"))
        .extension(reference.number("xi_constant"))
        .body_force(reference.vector("body_force"))
        .traction([0.0; 2])
        .criterion_force(reference.vector("criterion_force"))
        .criterion_weight(reference.number("criterion_boundary"))
}

fn negative(values: Vec<f64>) -> Vec<f64> {
    values.into_iter().map(|value| -value).collect()
}

fn compare(file: ReferenceFile) -> f64 {
    let mut reference = Reference::<2>::new(file);
    let data = data(&reference);
    // Without N on the boundary, and without M inside.
    let interior = data.clone().criterion_weight(0.0);
    let boundary_only = data.clone().criterion_force([0.0; 2]);
    let (assembler, space, u) = (reference.assembler.clone(), reference.space.clone(), reference.u());
    let omega = forms::Omega::on("all");
    let (gamma_n, gamma_c) = (forms::GammaN::on(CRITERION), forms::GammaC::on(CONTACT));
    let boundary = forms::Boundary::on(CRITERION);
    for (facet, diameter) in reference.contact_diameters.clone() {
        let ours = assembler.mesh().diameter(facet.cell as usize);
        assert_close("h_T", &[ours], &[diameter], 1e-14);
    }

    // The direct problem.
    let direct = forms::direct(&data, &omega, &gamma_n, &gamma_c);
    reference.compare_vector("residual", &assembler.residual(&direct, &[&u], &[&space]).unwrap());
    let loads = Parts { constant: true, linear: false, nonlinear: false };
    let load = assembler.residual_parts(&direct, &[&u], &[&space], loads).unwrap();
    reference.compare_vector("load", &negative(load));
    let tangent = assembler.tangent(&direct, &[&u], &[&space]).unwrap();
    reference.compare_matrix("tangent", &tangent);

    // The adjoints: affine in p, so that minus the residual at p = 0 is the right side.
    let zero = Field::zero(&space);
    let (unknowns, tests) = ([&zero], [&space]);
    let discrete = forms::discrete_adjoint(&data, &omega, &gamma_n, &gamma_c, &boundary, &u);
    let consistent = forms::consistent_adjoint(&data, &omega, &gamma_c, &boundary, &u);
    let extended = forms::extended_adjoint(&data, &omega, &gamma_c, &boundary, &u);
    let matrix = assembler.tangent(&discrete, &unknowns, &tests).unwrap();
    reference.compare_matrix("discrete_adjoint", &matrix);
    let matrix = assembler.tangent(&extended, &unknowns, &tests).unwrap();
    reference.compare_matrix("extended_adjoint", &matrix);
    // (22) has the tangent's matrix, with N and without.
    for data in [&data, &interior] {
        let form = forms::consistent_adjoint(data, &omega, &gamma_c, &boundary, &u);
        let matrix = assembler.tangent(&form, &unknowns, &tests).unwrap();
        let label = format!("{}: (22) is the tangent", reference.name);
        assert_close(&label, dense(&matrix).as_slice(), dense(&tangent).as_slice(), TOLERANCE);
    }
    let right_side = negative(assembler.residual(&discrete, &unknowns, &tests).unwrap());
    reference.compare_vector("discrete_adjoint_right_hand_side", &right_side);
    let right_side = negative(assembler.residual(&consistent, &unknowns, &tests).unwrap());
    reference.compare_vector("consistent_adjoint_right_hand_side", &right_side);
    let right_side = negative(assembler.residual(&extended, &unknowns, &tests).unwrap());
    reference.compare_vector("extended_adjoint_right_hand_side", &right_side);
    // Without N all three have the same right-hand side.
    let sides = [
        assembler.residual(
            &forms::discrete_adjoint(&interior, &omega, &gamma_n, &gamma_c, &boundary, &u),
            &unknowns,
            &tests,
        ),
        assembler.residual(
            &forms::consistent_adjoint(&interior, &omega, &gamma_c, &boundary, &u),
            &unknowns,
            &tests,
        ),
        assembler.residual(
            &forms::extended_adjoint(&interior, &omega, &gamma_c, &boundary, &u),
            &unknowns,
            &tests,
        ),
    ]
    .map(|side| negative(side.unwrap()));
    reference.compare_vector("adjoint_right_hand_side", &sides[0]);
    for side in &sides[1..] {
        assert_close(&reference.name, side, &sides[0], TOLERANCE);
    }

    // The criterion and the contact measures.
    let criterion = |data| assembler.functional(&forms::criterion(data, &omega, &boundary, &u)).unwrap();
    reference.compare_number("criterion_interior", criterion(&interior));
    reference.compare_number("criterion_boundary", criterion(&boundary_only));
    let sum = criterion(&interior) + criterion(&boundary_only);
    assert_close("M + N", &[criterion(&data)], &[sum], 1e-14);
    let force = assembler.functional(&forms::contact_force(&data, &gamma_c, &u)).unwrap();
    reference.compare_number("contact_force", force);
    let length = assembler.functional(&forms::contact_length(&data, &gamma_c, &u)).unwrap();
    reference.compare_number("contact_length", length);

    // Active points, twice: by the form's own switches, and by β at the points.
    let switches = assembler.active_set(&direct, &[&u]).unwrap().unwrap();
    let active = switches.iter().filter(|bits| **bits != 0).count();
    reference.compare_number("active_points", active as f64);
    let indicator = forms::contact_indicator(&data, &u);
    let samples = assembler.along_facets(&indicator, CONTACT, &reference.facet_points.clone()).unwrap();
    assert_eq!(samples.len(), switches.len());
    let above = |shift: &dyn Fn(Facet) -> f64| {
        samples.iter().filter(|sample| sample.value[0] > shift(sample.facet)).count()
    };
    assert_eq!(above(&|_| 0.0), active, "{}", reference.name);
    let mesh = assembler.mesh().clone();
    let xi = |facet: Facet| data.extension * mesh.diameter(facet.cell as usize).sqrt();
    reference.compare_number("extended_active_points", above(&xi) as f64);
    let (beta, constant) = (samples.clone(), Given::constant(data.extension));
    // β is known at the quadrature points only: look it up by position.
    let lookup = Given::function(move |x: &[f64; 2]| {
        let distance = |sample: &&forms_fem::assemble::FacetSample<2>| {
            (sample.position[0] - x[0]).hypot(sample.position[1] - x[1])
        };
        let nearest = beta.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map_or(f64::NAN, |sample| sample.value[0])
    });
    let region = shifted::GammaC::on(CONTACT);
    let constant: &Given<f64, 2> = &constant;
    let length = shifted::length(&region, lookup.source().clone(), constant.source().clone());
    let length = assembler.functional(&length).unwrap();
    reference.compare_number("extended_contact_length", length);
    reference.finish()
}

#[test]
fn direct_problem_adjoints_and_measures_agree() {
    let files = Family::Nitsche.files();
    assert_eq!(files.len(), 9, "triangles, quadrilaterals, the curved annulus; three values of theta each");
    let largest = files.into_iter().map(compare).fold(0.0, f64::max);
    println!("largest deviation {largest:.1e}");
}
