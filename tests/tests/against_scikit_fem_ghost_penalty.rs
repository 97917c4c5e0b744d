//! Jumps of first and second normal derivatives over interior facets against scikit-fem.

use forms_examples::ghost_penalty::stabilisation;
use forms_fem::prelude::*;
use forms_tests::reference_file::{Family, Reference, ReferenceFile};

fn compare<const D: usize>(file: ReferenceFile) -> f64
where
    Dim: Dimension<D>,
{
    let mut reference = Reference::<D>::new(file);
    let data = stabilisation::data().g1(reference.number("g1")).g2(reference.number("g2"));
    let form = stabilisation::penalty(&data, &stabilisation::Inner::on("interior"));
    let (assembler, space, u) = (reference.assembler.clone(), reference.space.clone(), reference.u());
    reference.compare_matrix("tangent", &assembler.tangent(&form, &[&u], &[&space]).unwrap());
    reference.compare_vector("residual", &assembler.residual(&form, &[&u], &[&space]).unwrap());
    reference.finish()
}

#[test]
fn matrix_and_residual_agree() {
    let files = Family::GhostPenalty.files();
    assert_eq!(files.len(), 4, "triangles of degree 1 and 2, quadrilaterals, tetrahedra");
    let by_dimension = |file: ReferenceFile| match file.dimension() {
        2 => compare::<2>(file),
        _ => compare::<3>(file),
    };
    println!("largest deviation {:.1e}", files.into_iter().map(by_dimension).fold(0.0, f64::max));
}
