//! Poisson's stiffness, mass and load, and the norms of a field, against scikit-fem.

use forms_fem::norms::norms;
use forms_fem::prelude::*;
use forms_tests::reference_file::{Family, Reference, ReferenceFile};

#[forms]
mod poisson {
    #[cells]
    pub struct Omega;

    pub fn stiffness(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
    }
    pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, u * v)
    }
    /// The file's f = exp(x) sin(2 y + x).
    pub fn load(v: Test<Scalar>) -> Form {
        integral(Omega, exp(x[0]) * sin(2 * x[1] + x[0]) * v)
    }
    /// The same with f given from outside.
    pub fn given_load(source: State<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, source * v)
    }
}

fn compare(file: ReferenceFile) -> f64 {
    let mut reference = Reference::<2>::new(file);
    let (assembler, space, u) = (reference.assembler.clone(), reference.space.clone(), reference.u());
    let omega = poisson::Omega::on("all");
    let (unknowns, tests) = ([&u], [&space]);
    let stiffness = assembler.tangent(&poisson::stiffness(&omega), &unknowns, &tests).unwrap();
    let mass = assembler.tangent(&poisson::mass(&omega), &unknowns, &tests).unwrap();
    reference.compare_matrix("stiffness", &stiffness);
    reference.compare_matrix("mass", &mass);
    let load = assembler.residual(&poisson::load(&omega), &[], &tests).unwrap();
    reference.compare_vector("load", &load);
    let source = Given::function(|x: &[f64; 2]| x[0].exp() * (2.0 * x[1] + x[0]).sin());
    let given = poisson::given_load(&omega, source.source().clone());
    let given = assembler.residual(&given, &[], &tests).unwrap();
    forms_tests::dense::assert_close("the load from a function of x", &given, &load, 1e-14);
    let found = norms(&assembler, &u).unwrap();
    reference.compare_number("l2", found.l2);
    reference.compare_number("h1", found.h1);
    reference.finish()
}

#[test]
fn matrices_load_and_norms_agree() {
    let files = Family::Poisson.files();
    assert_eq!(files.len(), 4, "P1, P2, Q1, Q2");
    let largest = files.into_iter().map(compare).fold(0.0, f64::max);
    println!("largest deviation {largest:.1e}");
}
