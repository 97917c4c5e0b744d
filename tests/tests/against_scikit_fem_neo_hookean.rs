//! A neo-Hookean solid stated by its energy alone, against scikit-fem's hand-written residual and tangent;
//! and a Taylor test of the same.

use forms_examples::neo_hookean::solid;
use forms_fem::prelude::*;
use forms_fem::verification;
use forms_tests::dense::{assert_close, dense};
use forms_tests::reference_file::{Family, Reference, ReferenceFile};

fn form(reference: &Reference<2>) -> Energy<2> {
    let data = solid::data::<2>().lambda(reference.number("lambda")).mu(reference.number("mu"));
    solid::energy(&data, &solid::Omega::on("all"))
}

fn compare(file: ReferenceFile) -> f64 {
    let mut reference = Reference::<2>::new(file);
    let form = form(&reference);
    let (assembler, space, u) = (reference.assembler.clone(), reference.space.clone(), reference.u());
    reference.compare_number("energy", assembler.energy(&form, &[&u]).unwrap());
    reference.compare_vector("residual", &assembler.residual(&form, &[&u], &[&space]).unwrap());
    reference.compare_matrix("tangent", &assembler.tangent(&form, &[&u], &[&space]).unwrap());
    reference.finish()
}

#[test]
fn energy_residual_and_tangent_agree() {
    let files = Family::NeoHookean.files();
    assert_eq!(files.len(), 1);
    let largest = files.into_iter().map(compare).fold(0.0, f64::max);
    println!("largest deviation {largest:.1e}");
}

#[test]
fn remainders_are_of_second_order() {
    for file in Family::NeoHookean.files() {
        let reference = Reference::<2>::new(file);
        let (form, space, u) = (form(&reference), reference.space.clone(), reference.u());
        let assembler = &reference.assembler;
        let direction: Vec<f64> =
            (0..space.unknowns()).map(|k| 0.02 * (1.7 * k as f64 + 0.3).sin()).collect();
        let direction = Field::from_values(&space, direction).unwrap();
        let residual = assembler.residual(&form, &[&u], &[&space]).unwrap();
        let slope: f64 = residual.iter().zip(direction.values()).map(|(r, d)| r * d).sum();
        let report = verification::taylor(1.0, &[slope], |step| {
            let moved = Field::combination(&[(1.0, &u), (step, &direction)]).unwrap();
            assembler.energy(&form, &[&moved]).map(verification::Sample::from)
        });
        report.unwrap().second_order().unwrap();
        let report = verification::tangent(assembler, &form, &[&u], &[&direction], 1.0).unwrap();
        report.second_order().unwrap();
        let matrix = dense(&assembler.tangent(&form, &[&u], &[&space]).unwrap());
        assert_close("symmetry", matrix.transpose().as_slice(), matrix.as_slice(), 1e-14);
    }
}
