//! Poisson's equation with discontinuous elements, interior and exterior facets, against scikit-fem.

use forms_examples::interior_penalty::diffusion;
use forms_fem::prelude::*;
use forms_tests::reference_file::{Family, Reference, ReferenceFile};

fn compare<const D: usize>(file: ReferenceFile) -> f64
where
    Dim: Dimension<D>,
{
    let mut reference = Reference::<D>::new(file);
    // The file's f = exp(x) y and g = x + 2 y².
    let data = diffusion::data()
        .penalty(reference.number("penalty"))
        .source(|x: &[f64; D]| x[0].exp() * x[1])
        .boundary_values(|x: &[f64; D]| x[0] + 2.0 * x[1] * x[1]);
    let (omega, inner) = (diffusion::Omega::on("all"), diffusion::Inner::on("interior"));
    let form = diffusion::balance(&data, &omega, &inner, &diffusion::Boundary::on("boundary"));
    let (assembler, space, u) = (reference.assembler.clone(), reference.space.clone(), reference.u());
    reference.compare_matrix("tangent", &assembler.tangent(&form, &[&u], &[&space]).unwrap());
    reference.compare_vector("residual", &assembler.residual(&form, &[&u], &[&space]).unwrap());
    reference.finish()
}

#[test]
fn matrix_and_residual_agree() {
    let files = Family::InteriorPenalty.files();
    assert_eq!(files.len(), 4, "triangles of degree 1 and 2, quadrilaterals, tetrahedra");
    let by_dimension = |file: ReferenceFile| match file.dimension() {
        2 => compare::<2>(file),
        _ => compare::<3>(file),
    };
    println!("largest deviation {:.1e}", files.into_iter().map(by_dimension).fold(0.0, f64::max));
}
