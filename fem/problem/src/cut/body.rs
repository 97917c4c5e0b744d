//! A cut body as a mesh of its own: whole cells and pieces, to be drawn and written with the tools for meshes.

use std::sync::Arc;

use super::heights::kuhn;
use super::{Cut, CutError, determinant_of, edges_of};
use crate::element::CellShape;
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::mesh::Mesh;
use crate::space::{Scope, Space};

/// Pieces smaller than this part of their cell are left out: they are not seen, and a mesh does not accept them.
const SMALLEST: f64 = 1e-9;

/// The pieces of a cut body as a mesh whose cells share no nodes, to be drawn and written; not to be computed on.
///
/// ```
/// use forms_fem::cut::Cut;
/// use forms_fem::output::VtuFile;
/// use forms_fem::prelude::*;
///
/// let mesh = rectangle([-1.0; 2], [1.0; 2], [16, 16], CellShape::Triangle, 1)?;
/// let space = Space::scalar(&mesh, 1)?;
/// let body = Cut::by(&Field::interpolate(&space, |x| x[0].hypot(x[1]) - 0.7)?)?.body()?;
/// let u = body.field(&Field::interpolate(&space, |x| x[0])?)?;
/// let file = VtuFile::new(body.mesh()).point_data("u", &u)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct CutBody<const D: usize> {
    background: Mesh<D>,
    mesh: Mesh<D>,
    /// Of each cell, that of the background, and its vertices in that cell's reference coordinates.
    cells: Vec<u32>,
    vertices: Vec<Vec<[f64; D]>>,
}

impl<const D: usize> Cut<D> {
    /// The body as a mesh that can be drawn and written. Its cells are straight, those of hexahedra tetrahedra; a curved interface is between points on lines
    /// that join nodes.
    ///
    /// # Errors
    /// [`CutError::Mesh`], should the mesh not accept the pieces.
    #[inline(never)]
    pub fn body(&self) -> Result<CutBody<D>, CutError> {
        let background = self.mesh();
        let mut nodes: Vec<[f64; D]> = Vec::new();
        let mut blocks: Vec<(CellShape, Vec<u32>)> = Vec::new();
        let (mut cells, mut vertices) = (Vec::new(), Vec::new());
        let simplex = if D == 2 { CellShape::Triangle } else { CellShape::Tetrahedron };
        let mut add = |cell: u32, shape: CellShape, corners: Vec<[f64; D]>| {
            let first = nodes.len() as u32;
            nodes.extend(corners.iter().map(|corner| background.map(cell as usize, corner).0));
            let numbers = first..first + corners.len() as u32;
            match blocks.last_mut() {
                Some((known, list)) if *known == shape => list.extend(numbers),
                _ => blocks.push((shape, numbers.collect())),
            }
            cells.push(cell);
            vertices.push(corners);
        };
        let add_simplex =
            |add: &mut dyn FnMut(u32, CellShape, Vec<[f64; D]>), cell: u32, mut corners: Vec<[f64; D]>| {
                let places = std::array::from_fn(|k| corners.get(k).copied().unwrap_or([0.0; D]));
                let volume = determinant_of(&edges_of(&places));
                if volume < 0.0 {
                    corners.swap(0, 1);
                }
                if volume.abs() > SMALLEST {
                    add(cell, simplex, corners);
                }
            };
        // Simplices come last, so that the pieces continue their block.
        let mut runs = background.by_shape(self.inside_cells().to_vec());
        runs.sort_by_key(|(shape, _)| shape.is_simplex());
        for (shape, run) in runs {
            if shape == CellShape::Hexahedron {
                // A mesh in space has cells of one shape.
                for cell in run {
                    for corners in kuhn::<D>(1) {
                        let places = corners[..=D].iter().map(|corner| corner.map(|number| number as f64));
                        add_simplex(&mut add, cell, places.collect());
                    }
                }
                continue;
            }
            let corners: Vec<[f64; D]> =
                shape.vertex_points().iter().map(|point| std::array::from_fn(|axis| point[axis])).collect();
            run.iter().for_each(|cell| add(*cell, shape, corners.clone()));
        }
        for cell in self.cut_cells() {
            for pieces in self.simplices_of(*cell) {
                for piece in pieces.cut.inside.iter() {
                    add_simplex(&mut add, *cell, pieces.places(piece)[..=D].to_vec());
                }
            }
        }
        let mesh = Mesh::from_nonconforming_blocks(1, nodes, blocks)
            .map_err(|error| CutError::Mesh { text: error.to_string() })?;
        Ok(CutBody { background: background.clone(), mesh, cells, vertices })
    }
}

impl<const D: usize> CutBody<D> {
    /// The mesh of the pieces.
    pub fn mesh(&self) -> &Mesh<D> {
        &self.mesh
    }

    /// A field of the background on the pieces, of degree 2 at most: exact for fields of this degree on affine cells.
    ///
    /// # Errors
    /// [`CutError::OtherMesh`] for a field of another mesh, [`CutError::Refused`] for one that has no values in all cells.
    #[inline(never)]
    pub fn field(&self, field: &Field<D>) -> Result<Field<D>, CutError> {
        let own = field.space();
        if !own.mesh().is_same(&self.background) {
            return Err(CutError::OtherMesh);
        }
        if !own.is_on_all_cells() || own.degree() == 0 {
            return Err(CutError::Refused { what: "drawing a field without values on each cell" });
        }
        let failed = |text: String| CutError::Mesh { text };
        let degree = own.degree().min(2);
        let space = match (own.components(), own.shape().len()) {
            (1, 0) => Space::discontinuous_scalar(&self.mesh, degree),
            (_, 1) => Space::discontinuous_vector(&self.mesh, degree),
            _ => Space::discontinuous_tensor(&self.mesh, degree),
        };
        let space = space.map_err(|error| failed(error.to_string()))?;
        if space.components() != own.components() || *space.scope() != Scope::Cell {
            return Err(CutError::Refused { what: "drawing a field of this shape" });
        }
        let mut values = vec![0.0; space.unknowns()];
        for (number, (cell, corners)) in self.cells.iter().zip(&self.vertices).enumerate() {
            let shape = self.mesh.cell_shape(number);
            let map = self.mesh.element_of(shape);
            let points = space.element_of(shape).node_points::<D>();
            let mut weights = vec![0.0; corners.len()];
            for (point, node) in points.iter().zip(space.cell_nodes(number)) {
                map.evaluate_values(point, &mut weights);
                let place = std::array::from_fn(|k| weights.iter().zip(corners).map(|(w, x)| w * x[k]).sum());
                let value = field.evaluate_in(*cell as usize, &place);
                values[*node as usize * value.len()..][..value.len()].copy_from_slice(&value);
            }
        }
        Field::from_values(&Arc::clone(&space), values).map_err(|error| failed(error.to_string()))
    }
}

instantiate!(cut_body: Cut::<D>::body, CutBody::<D>::field);
