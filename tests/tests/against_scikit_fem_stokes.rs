//! Stokes' equations, two unknowns of different degree, against scikit-fem: the whole system at a given state.

use forms_examples::stokes::flow;
use forms_fem::prelude::*;
use forms_tests::reference_file::{Family, Reference, ReferenceFile};

fn compare<const D: usize>(file: ReferenceFile) -> f64
where
    Dim: Dimension<D>,
{
    let mut reference = Reference::<D>::new(file);
    // The file's f = (sin y, x y, 1).
    let force = |x: &[f64; D]| std::array::from_fn(|k| [x[1].sin(), x[0] * x[1], 1.0][k]);
    let data = flow::data().viscosity(reference.number("viscosity")).force(force);
    let form = flow::equilibrium(&data, &flow::Omega::on("all"));
    let (assembler, velocity, u) = (reference.assembler.clone(), reference.space.clone(), reference.u());
    let (pressure, p) = reference.second();
    let (unknowns, tests) = ([&u, &p], [&velocity, &pressure]);
    reference.compare_matrix("tangent", &assembler.tangent(&form, &unknowns, &tests).unwrap());
    reference.compare_vector("residual", &assembler.residual(&form, &unknowns, &tests).unwrap());
    reference.finish()
}

#[test]
fn system_and_residual_agree() {
    let files = Family::Stokes.files();
    assert_eq!(files.len(), 3, "triangles, quadrilaterals, tetrahedra");
    let by_dimension = |file: ReferenceFile| match file.dimension() {
        2 => compare::<2>(file),
        _ => compare::<3>(file),
    };
    println!("largest deviation {:.1e}", files.into_iter().map(by_dimension).fold(0.0, f64::max));
}
