//! A Mooney-Rivlin solid given only by its energy, against scikit-fem's hand-written residual and tangent.

use forms_examples::mooney_rivlin::solid;
use forms_fem::prelude::*;
use forms_tests::reference_file::{Family, Reference, ReferenceFile};

fn compare<const D: usize>(file: ReferenceFile) -> f64
where
    Dim: Dimension<D>,
{
    let mut reference = Reference::<D>::new(file);
    let data =
        solid::data().c1(reference.number("c1")).c2(reference.number("c2")).kappa(reference.number("kappa"));
    let form = solid::energy(&data, &solid::Omega::on("all"));
    let (assembler, space, u) = (reference.assembler.clone(), reference.space.clone(), reference.u());
    reference.compare_number("energy", assembler.energy(&form, &[&u]).unwrap());
    reference.compare_vector("residual", &assembler.residual(&form, &[&u], &[&space]).unwrap());
    reference.compare_matrix("tangent", &assembler.tangent(&form, &[&u], &[&space]).unwrap());
    reference.finish()
}

#[test]
fn energy_residual_and_tangent_agree() {
    let files = Family::MooneyRivlin.files();
    assert_eq!(files.len(), 3, "triangles, the curved annulus, tetrahedra");
    let by_dimension = |file: ReferenceFile| match file.dimension() {
        2 => compare::<2>(file),
        _ => compare::<3>(file),
    };
    println!("largest deviation {:.1e}", files.into_iter().map(by_dimension).fold(0.0, f64::max));
}
