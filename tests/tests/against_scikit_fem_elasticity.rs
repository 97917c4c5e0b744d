//! The stiffness matrix of linear elasticity against scikit-fem, entry by entry, on every kind of cell, and
//! the promise that no reference file is left unused.

use forms_contact::forms;
use forms_fem::prelude::*;
use forms_tests::reference_file::{Family, Reference, ReferenceFile, names};

fn compare<const D: usize>(file: ReferenceFile) -> f64
where
    Dim: Dimension<D>,
{
    let mut reference = Reference::<D>::new(file);
    // Only λ and μ are read.
    let data = forms::data()
        .lambda(reference.number("lambda"))
        .mu(reference.number("mu"))
        .gamma0(1.0)
        .obstacle_normal([0.0; D])
        .gap(0.0)
        .theta(0.0);
    let form = forms::elasticity(&data, &forms::Omega::on("all"));
    let space = reference.space.clone();
    let matrix = reference.assembler.tangent(&form, &[&Field::zero(&space)], &[&space]).unwrap();
    reference.compare_matrix("stiffness", &matrix);
    reference.finish()
}

#[test]
fn stiffness_agrees_entry_by_entry() {
    let files = Family::Elasticity.files();
    assert_eq!(files.len(), 7, "P1, P2, Q1, Q2, the curved annulus, tetrahedra and hexahedra");
    let mut largest = 0.0_f64;
    for file in files {
        largest = largest.max(if file.dimension() == 2 { compare::<2>(file) } else { compare::<3>(file) });
    }
    println!("largest deviation {largest:.1e}");
}

#[test]
fn every_reference_file_is_consumed() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    for family in Family::ALL {
        let test = folder.join(format!("against_scikit_fem_{}.rs", family.prefix()));
        let source = std::fs::read_to_string(&test).unwrap();
        assert!(source.contains(&format!("Family::{family:?}.files()")), "{test:?} does not read its files");
    }
    let of_family = |name: &String, family: &Family| name.starts_with(&format!("{}_", family.prefix()));
    let names = names();
    assert!(!names.is_empty());
    for name in &names {
        let count = Family::ALL.iter().filter(|family| of_family(name, family)).count();
        assert_eq!(count, 1, "{name} belongs to {count} families: no test reads it, or two do");
    }
}
