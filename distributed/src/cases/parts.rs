//! Problems on parts of a mesh, and the numbers by which they are compared with one process.

use std::error::Error;

use forms_fem::constraints::RigidMap;
use forms_fem::mesh::{MeshError, OctreeMesh};
use forms_fem::prelude::*;

use super::hanging_block::HangingBlock;
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

/// A problem with one unknown on the unit cube, or a part of it.
pub struct Case {
    /// The equations.
    pub form: Form<3>,
    /// The space of the unknown.
    pub space: Arc<Space<3>>,
    /// Prescribed values.
    pub held: Constraints<3>,
}

impl Case {
    /// Diffusion with u = x at the top and 0 at the left; `rubber`, a cube that is stretched and sheared by half of its length; `hanging`,
    /// an elastic one under its weight. Relations between unknowns have `periodic`, rubber that is sheared and goes on beyond two sides;
    /// `slides`, rubber whose top and right side slide along oblique planes; and `rigid`, the elastic block with a rigid top. With hanging nodes
    /// there are `trees`, diffusion with another u at the top, `strip trees` with this u on a part of it that ends at hanging nodes, `rubber trees`, `hanging trees`, `rigid trees` and `periodic trees`.
    ///
    /// # Errors
    /// A degree that does not exist, a mesh without these sides.
    pub fn new(name: &str, mesh: &Mesh<3>, degree: usize) -> Result<Self, Box<dyn Error>> {
        let regions = forms::Regions::default().side("right");
        let model = forms::Model { data: forms::data().mu(1.0).lambda(3.0), regions };
        if ["hanging", "rigid", "hanging trees", "rigid trees"].contains(&name) {
            let block = HangingBlock::on(mesh, Given::constant([0.0, 0.0, -1.0]))?;
            let mut held = block.constraints;
            if name.starts_with("rigid") {
                held = Constraints::new(&block.space);
                held.join_hanging_nodes()?;
                held.fix("left", |_| [0.0; 3])?;
                held.rigid_body("top")?;
            }
            if name == "hanging trees" {
                held = Constraints::new(&block.space);
                held.join_hanging_nodes()?;
                held.fix("top", |_| [0.0; 3])?;
            }
            return Ok(Case { form: block.form, space: block.space, held });
        }
        let is_rubber = ["rubber", "periodic", "slides", "rubber trees", "periodic trees"].contains(&name);
        let space = if is_rubber { Space::vector(mesh, degree)? } else { Space::scalar(mesh, degree)? };
        let mut held = Constraints::new(&space);
        if name.ends_with("trees") {
            held.join_hanging_nodes()?;
        }
        match name {
            "rubber" | "rubber trees" => {
                held.fix("left", |_| [0.0; 3])?;
                held.fix("right", |_| [0.5, 0.25, 0.0])?;
            }
            "periodic" | "periodic trees" => {
                held.fix("bottom", |_| [0.0; 3])?;
                held.fix_component("top", 1, |x| 0.2 + 0.1 * (std::f64::consts::TAU * x[0]).sin())?;
                held.periodic("left", "right", &RigidMap::translation([1.0, 0.0, 0.0]))?;
            }
            "slides" => {
                held.fix("bottom", |_| [0.0; 3])?;
                held.slide("top", |_| [0.6, 0.0, 0.8], |_| 0.1)?;
                held.slide("right", |_| [0.8, 0.6, 0.0], |x| 0.1 * x[2])?;
            }
            _ => {}
        }
        if is_rubber {
            return Ok(Case { form: model.rubber().into(), space, held });
        }
        let top = if name == "strip trees" { "strip" } else { "top" };
        // No polynomial of the space: hanging nodes interpolate it.
        held.fix(top, |x| if name.ends_with("trees") { x[0] * (x[0] + x[1].sin()) } else { x[0] })?;
        held.fix("left", |_| 0.0)?;
        Ok(Case { form: model.diffusion(), space, held })
    }

    /// The problem. Its first step takes a body along with the prescribed values.
    pub fn problem(&self) -> Problem<'_, 3> {
        let options =
            NewtonOptions { prescribed_values: PrescribedValues::ByTangent, ..NewtonOptions::default() };
        let problem = Problem::new(&self.form, &self.space).constrained(&self.held).options(options);
        problem.threads(Threads::new(1))
    }

    /// ∫ |∇u|² + |u|².
    pub fn size(u: &Field<3>) -> Functional<3> {
        let model = forms::Model::new(forms::data().mu(1.0).lambda(1.0));
        if u.space().components() == 1 { model.scalar_size(u) } else { model.vector_size(u) }
    }
}

/// The unit cube with cells that are divided near an edge of its top, some of them twice: nodes hang inside of it, on sides and on the edge.
///
/// # Errors
/// Too many cells, or none.
pub fn trees(divisions: usize) -> Result<Mesh<3>, MeshError> {
    let cube = cuboid([0.0; 3], [1.0; 3], [divisions; 3], CellShape::Hexahedron, 1)?;
    let mut mesh = refined(cube, &[0.4, 0.0, 1.0], &[0.6, 0.3])?;
    mesh.name_facets("strip", "top", |x| x[1] < 0.48)?;
    Ok(mesh)
}

/// The unit cube with cells that are divided at the middle of an edge of its top: nodes hang on two sides at the same places.
///
/// # Errors
/// Too many cells, or none.
pub fn even_trees(divisions: usize) -> Result<Mesh<3>, MeshError> {
    refined(cuboid([0.0; 3], [1.0; 3], [divisions; 3], CellShape::Hexahedron, 1)?, &[0.5, 0.0, 1.0], &[0.7])
}

/// A mesh of hexahedra whose cells near a point are divided, once for each distance of their centres.
///
/// # Errors
/// A mesh of other cells.
pub fn refined(mesh: Mesh<3>, point: &[f64; 3], distances: &[f64]) -> Result<Mesh<3>, MeshError> {
    let mut trees = OctreeMesh::new(mesh)?;
    for distance in distances {
        let mesh = trees.mesh();
        let squared = |x: [f64; 3]| x.iter().zip(point).map(|(x, y)| (x - y).powi(2)).sum::<f64>();
        let is_near = |cell: &u32| squared(mesh.cell_centre(*cell as usize)) < distance * distance;
        let marked: Vec<u32> = (0..mesh.cell_count() as u32).filter(is_near).collect();
        trees = trees.refined(&marked)?.0;
    }
    Ok(trees.mesh().clone())
}

/// The values of a field at the vertices of its mesh, which has the given numbers in a larger mesh with `count` nodes; and 1 for each of its
/// vertices.
pub fn at_vertices<const D: usize>(field: &Field<D>, numbers: &[u64], count: usize) -> (Vec<f64>, Vec<f64>) {
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

/// The values of a field at the vertices of the whole mesh, for comparisons: each process has all of them.
///
/// # Errors
/// Those of an exchange.
pub fn whole<const D: usize>(part: &MeshPart<'_, D>, field: &Field<D>) -> Result<Vec<f64>, Box<dyn Error>> {
    let world = part.world();
    let largest = part.node_numbers().iter().max().copied().unwrap_or(0);
    let count = world.gather(largest)?.into_iter().max().unwrap_or(0) as usize + 1;
    let (values, is_there) = at_vertices(field, part.node_numbers(), count);
    let (mut sums, counts) = (world.sum(&values)?, world.sum(&is_there)?);
    sums.chunks_mut(field.space().components()).zip(counts).for_each(|(values, count)| {
        values.iter_mut().for_each(|value| *value /= count.max(1.0));
    });
    Ok(sums)
}
