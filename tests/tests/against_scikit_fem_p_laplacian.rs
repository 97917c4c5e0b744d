//! The p-Laplacian for p = 3, 3/2 and 4, stated by its energy alone, against scikit-fem's hand-written derivatives.

use forms_examples::p_laplacian::diffusion;
use forms_fem::prelude::*;
use forms_tests::reference_file::{Family, Reference, ReferenceFile};

fn compare<const D: usize>(file: ReferenceFile) -> f64
where
    Dim: Dimension<D>,
{
    let mut reference = Reference::<D>::new(file);
    let data = diffusion::data()
        .exponent(reference.number("exponent"))
        .regularisation(reference.number("regularisation"))
        .source(|x: &[f64; D]| 1.0 + x[0] * x[1]);
    let form = diffusion::energy(&data, &diffusion::Omega::on("all"));
    let (assembler, space, u) = (reference.assembler.clone(), reference.space.clone(), reference.u());
    reference.compare_number("energy", assembler.energy(&form, &[&u]).unwrap());
    reference.compare_vector("residual", &assembler.residual(&form, &[&u], &[&space]).unwrap());
    reference.compare_matrix("tangent", &assembler.tangent(&form, &[&u], &[&space]).unwrap());
    reference.finish()
}

#[test]
fn energy_residual_and_tangent_agree() {
    let files = Family::PLaplacian.files();
    assert_eq!(files.len(), 3, "triangles, quadrilaterals, tetrahedra");
    let by_dimension = |file: ReferenceFile| match file.dimension() {
        2 => compare::<2>(file),
        _ => compare::<3>(file),
    };
    println!("largest deviation {:.1e}", files.into_iter().map(by_dimension).fold(0.0, f64::max));
}
