//! Problems on parts of a mesh, and the numbers by which they are compared with one process.

use std::error::Error;

use forms_fem::prelude::*;

use crate::part::MeshPart;

/// The forms.
#[forms(dimension = 3)]
pub mod forms {
    /// Constants.
    pub struct Data {
        /// μ \[stress\].
        pub mu: Param,
        /// λ \[stress\].
        pub lambda: Param,
    }
    /// The body.
    #[cells]
    pub struct Omega;
    /// A side with a given flux.
    #[facets]
    pub struct Side;

    /// ∫ ∇u·∇v − (1 + x y) v, with a flux of z through a side.
    pub fn diffusion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - (1 + x[0] * x[1]) * v) - integral(Side, x[2] * v)
    }
    /// The energy of a neo-Hookean body.
    pub fn rubber(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        let J = det(F);
        integral(Omega, mu / 2 * (inner(F, F) - D) - mu * ln(J) + lambda / 2 * pow(ln(J), 2))
    }
    /// ∫ |∇u|² + u², in which all nodes count.
    pub fn scalar_size(u: State<Scalar>) -> Functional {
        integral(Omega, dot(grad(u), grad(u)) + u * u)
    }
    /// The same of vectors.
    pub fn vector_size(u: State<Vector>) -> Functional {
        integral(Omega, inner(grad(u), grad(u)) + dot(u, u))
    }
}

/// A model of the forms: the side with a flux is the right one.
pub fn model() -> forms::Model<3> {
    let regions = forms::Regions::default().side("right");
    forms::Model { data: forms::data().mu(1.0).lambda(3.0), regions }
}

/// A space and conditions on it.
pub type Held = (Arc<Space<3>>, Constraints<3>);

/// Scalars of a degree that are x at the top and 0 at the left.
///
/// # Errors
/// A mesh without these sides.
pub fn scalars(mesh: &Mesh<3>, degree: usize) -> Result<Held, Box<dyn Error>> {
    let space = Space::scalar(mesh, degree)?;
    let mut held = Constraints::new(&space);
    held.fix("top", |x| x[0])?;
    held.fix("left", |_| 0.0)?;
    Ok((space, held))
}

/// Displacements of a degree of a cube that is stretched and sheared by half of its length.
///
/// # Errors
/// A mesh without a left and a right side.
pub fn stretched(mesh: &Mesh<3>, degree: usize) -> Result<Held, Box<dyn Error>> {
    let space = Space::vector(mesh, degree)?;
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0; 3])?;
    held.fix("right", |_| [0.5, 0.25, 0.0])?;
    Ok((space, held))
}

/// Newton's method whose first step takes the body along with the prescribed values.
pub fn by_tangent() -> NewtonOptions {
    NewtonOptions { prescribed_values: PrescribedValues::ByTangent, ..NewtonOptions::default() }
}

/// The values of a field at the vertices of its mesh, which has the given numbers in a larger mesh with `count` nodes; and 1 for each of its vertices.
pub fn at_vertices(field: &Field<3>, numbers: &[u64], count: usize) -> (Vec<f64>, Vec<f64>) {
    let (space, components) = (field.space(), field.space().components());
    let (mut values, mut is_there) = (vec![0.0; count * components], vec![0.0; count]);
    for cell in 0..space.mesh().cell_count() {
        for (vertex, node) in space.mesh().cell_vertices(cell).iter().zip(space.cell_nodes(cell)) {
            let number = numbers[*vertex as usize] as usize;
            is_there[number] = 1.0;
            values[number * components..][..components].copy_from_slice(field.at_node(*node as usize));
        }
    }
    (values, is_there)
}

/// The values of a field at the vertices of the whole mesh, which has `count` nodes.
///
/// # Errors
/// Those of an exchange.
pub fn whole(part: &MeshPart<'_, 3>, field: &Field<3>, count: usize) -> Result<Vec<f64>, Box<dyn Error>> {
    let (values, is_there) = at_vertices(field, part.node_numbers(), count);
    let (mut sums, counts) = (part.world().sum(&values)?, part.world().sum(&is_there)?);
    let components = field.space().components();
    sums.chunks_mut(components).zip(counts).for_each(|(values, count)| {
        values.iter_mut().for_each(|value| *value /= count.max(1.0));
    });
    Ok(sums)
}
