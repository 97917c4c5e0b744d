//! Bodies that are cut from a mesh: areas and normals, hexahedra and functions of degree 2, derivatives, what is refused, solutions on them, descents, adaptive backgrounds, surfaces from files.

mod adaptive;
mod areas;
mod bodies;
mod derivatives;
mod descent;
mod heights;
mod refusals;
mod surfaces;

use forms_fem::prelude::*;

/// A level set function of some degree on a mesh.
fn levels<const D: usize>(mesh: &Mesh<D>, degree: usize, phi: impl Fn(&[f64; D]) -> f64) -> Field<D> {
    Field::interpolate(&Space::scalar(mesh, degree).unwrap(), phi).unwrap()
}

/// A level set function on a mesh.
fn level<const D: usize>(mesh: &Mesh<D>, phi: impl Fn(&[f64; D]) -> f64) -> Field<D> {
    levels(mesh, 1, phi)
}

/// The body inside a level set function of degree 2.
fn cut_curved<const D: usize>(mesh: &Mesh<D>, phi: impl Fn(&[f64; D]) -> f64) -> Assembler<D> {
    Assembler::new(mesh).cut_by(&levels(mesh, 2, phi)).unwrap()
}

/// The body inside a level set function.
fn cut<const D: usize>(mesh: &Mesh<D>, phi: impl Fn(&[f64; D]) -> f64) -> Assembler<D> {
    Assembler::new(mesh).cut_by(&level(mesh, phi)).unwrap()
}

/// The square (−1, 1)².
fn square(cells: usize, shape: CellShape) -> Mesh<2> {
    rectangle([-1.0; 2], [1.0; 2], [cells, cells], shape, 1).unwrap()
}

/// The circle of the tests.
fn circle(x: &[f64; 2]) -> f64 {
    (x[0] - 0.013).hypot(x[1] + 0.021) - 0.7
}
