//! A neo-Hookean solid stated by its energy alone, against scikit-fem's hand-written residual and tangent;
//! and a Taylor test of the same.

use forms_examples::neo_hookean::solid;
use forms_fem::prelude::*;
use forms_tests::dense::{assert_close, dense};
use forms_tests::reference_file::{Family, Reference, ReferenceFile};
use forms_tests::taylor::assert_second_order;

fn form(reference: &Reference<2>) -> solid::energy::Form<2> {
    let data = solid::Data::<2> { lambda: reference.number("lambda"), mu: reference.number("mu") };
    solid::energy(&data, &solid::Omega::on("all"))
}

fn compare(file: ReferenceFile) -> f64 {
    let mut reference = Reference::<2>::new(file);
    let form = form(&reference);
    let (assembler, space, u) = (reference.assembler.clone(), reference.space.clone(), reference.u());
    reference.compare_number("energy", assembler.functional(&form, &[&u]).unwrap());
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
        let moved = |step: f64| {
            let values = u.values().iter().zip(&direction).map(|(u, d)| u + step * d).collect();
            Field::from_values(&space, values).unwrap()
        };
        let energy = |step: f64| vec![assembler.functional(&form, &[&moved(step)]).unwrap()];
        let residual = |step: f64| assembler.residual(&form, &[&moved(step)], &[&space]).unwrap();
        let slope: f64 = residual(0.0).iter().zip(&direction).map(|(r, d)| r * d).sum();
        assert_second_order("energy", 1.0, energy, &[slope]);
        let tangent = assembler.tangent(&form, &[&u], &[&space]).unwrap();
        assert_second_order("residual", 1.0, residual, &tangent.multiply(&direction).unwrap());
        let matrix = dense(&tangent);
        assert_close("symmetry", matrix.transpose().as_slice(), matrix.as_slice(), 1e-14);
    }
}
