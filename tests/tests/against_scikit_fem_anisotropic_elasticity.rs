//! Linear elasticity with a full tensor of rank 4 against scikit-fem.

use forms_examples::anisotropic_elasticity::solid;
use forms_fem::prelude::*;
use forms_tests::reference_file::{Family, Reference, ReferenceFile};

fn compare<const D: usize>(file: ReferenceFile) -> f64
where
    Dim: Dimension<D>,
{
    let mut reference = Reference::<D>::new(file);
    let data = solid::data().constants(reference.tensor4("constants"));
    let form = solid::equilibrium(&data, &solid::Omega::on("all"));
    let (assembler, space, u) = (reference.assembler.clone(), reference.space.clone(), reference.u());
    reference.compare_matrix("tangent", &assembler.tangent(&form, &[&u], &[&space]).unwrap());
    reference.compare_vector("residual", &assembler.residual(&form, &[&u], &[&space]).unwrap());
    reference.finish()
}

#[test]
fn matrix_and_residual_agree() {
    let files = Family::AnisotropicElasticity.files();
    assert_eq!(files.len(), 3, "triangles, quadrilaterals, tetrahedra");
    let by_dimension = |file: ReferenceFile| match file.dimension() {
        2 => compare::<2>(file),
        _ => compare::<3>(file),
    };
    println!("largest deviation {:.1e}", files.into_iter().map(by_dimension).fold(0.0, f64::max));
}
