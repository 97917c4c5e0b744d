//! Contact of bodies that are cut from a mesh: conditioning, patch tests, orders, hexahedra and functions of degree 2, adaptive meshes, derivatives by the level set function and by holes.

mod adaptive;
mod block;
mod conditioning;
mod cylinder;
mod derivatives;
mod half_plane;
mod heights;
mod signorini;
mod surface;
mod topological;

use forms_fem::prelude::*;

/// A level set function on a mesh.
fn level<const D: usize>(mesh: &Mesh<D>, phi: impl Fn(&[f64; D]) -> f64) -> Field<D> {
    Field::interpolate(&Space::scalar(mesh, 1).unwrap(), phi).unwrap()
}

/// The body inside a level set function.
fn cut<const D: usize>(mesh: &Mesh<D>, phi: impl Fn(&[f64; D]) -> f64) -> Assembler<D> {
    Assembler::new(mesh).cut_by(&level(mesh, phi)).unwrap()
}

/// The square (−1, 1)² of triangles.
fn square(cells: usize) -> Mesh<2> {
    rectangle([-1.0; 2], [1.0; 2], [cells, cells], CellShape::Triangle, 1).unwrap()
}

/// The nodes of a rectangle, turned about the origin.
fn turned(mesh: &Mesh<2>, angle: f64) -> Mesh<2> {
    let (sine, cosine) = angle.sin_cos();
    let turn = |x: &[f64; 2]| [cosine * x[0] - sine * x[1], sine * x[0] + cosine * x[1]];
    mesh.with_nodes(mesh.nodes().iter().map(turn).collect()).unwrap()
}

/// The slope of the logarithm of errors over three meshes, each twice as fine.
fn order(errors: &[f64]) -> f64 {
    (errors[0] / errors[errors.len() - 1]).log2() / (errors.len() - 1) as f64
}
