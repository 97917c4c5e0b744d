//! Element matrices and vectors of a batch of cells, in the layouts of FFCx: what the plugin's symbols call.

use std::sync::Arc;

use forms_fem::assemble::{Assembler, AssemblyError};
use forms_fem::contract::{Form, Given, Role};
use forms_fem::element::CellShape;
use forms_fem::field::{Field, FieldError};
use forms_fem::mesh::{Facet, Mesh, MeshError};
use forms_fem::space::{Space, SpaceError};
use thiserror::Error;

use crate::basix::{NodeOrder, RuleError, node_count, our_facet, our_numbers, quadrature};

/// The region to which cell integrals of the basket are bound.
pub const CELLS: &str = "all";
/// The region to which facet integrals of the basket are bound.
pub const FACETS: &str = "facets";

/// Whether a kernel is that of a residual or of its tangent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Element vectors.
    Residual,
    /// Element matrices.
    Tangent,
}

/// The element and the rule of a kernel.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Vector or matrix.
    pub output: Output,
    /// The cell.
    pub shape: CellShape,
    /// Degree of the unknown's element.
    pub degree: usize,
    /// Degree of the geometry map.
    pub geometry: usize,
    /// Degree of basix's default quadrature rule.
    pub rule: usize,
    /// Degrees of the elements of the coefficients: the unknown first (if the kernel reads it), then given fields.
    pub coefficients: &'static [usize],
    /// Basix's node order, of geometry and unknown alike.
    pub order: NodeOrder,
}

/// Why a kernel cannot run.
#[derive(Debug, Error)]
pub enum BatchError {
    /// No such rule.
    #[error(transparent)]
    Rule(#[from] RuleError),
    /// Cells that are no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// No such space.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// Coefficients that are no field.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// Anything else.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// Fewer coefficients registered than the form reads.
    #[error("the form has no coefficient number {index}")]
    Coefficient {
        /// The number asked for.
        index: usize,
    },
}

/// The given fields of a form, by their place in the list of coefficients; the unknown has place 0 if the kernel
/// reads it.
pub struct Coefficients<const D: usize> {
    fields: Vec<Option<Field<D>>>,
}

impl<const D: usize> Coefficients<D> {
    /// No coefficients.
    pub fn none() -> Self {
        Coefficients { fields: vec![] }
    }

    /// A scalar field.
    pub fn scalar(&self, index: usize) -> Given<f64, D> {
        match self.fields.get(index) {
            Some(Some(field)) => Given::field(field),
            _ => Given::constant(0.0),
        }
    }
}

/// Runs a form on `count` cells. Arrays are those of the plugin's interface: see `peers/README.md`.
///
/// # Errors
/// A [`BatchError`].
pub fn run<const D: usize, const GEOMETRY_NODES: usize, const NODES: usize, F: Form<D>>(
    setting: &Setting,
    form: impl Fn(&Coefficients<D>) -> F,
    count: usize,
    matrices: &mut [f64],
    coefficients: &[f64],
    coordinates: &[f64],
    facet: usize,
) -> Result<(), BatchError> {
    let shape = setting.shape;
    let geometry_numbers: [usize; GEOMETRY_NODES] = our_numbers(shape, setting.geometry, setting.order);
    let numbers: [usize; NODES] = our_numbers(shape, setting.degree, setting.order);
    let mut nodes = vec![[0.0; D]; count * GEOMETRY_NODES];
    for cell in 0..count {
        for (theirs, ours) in geometry_numbers.iter().enumerate() {
            for axis in 0..D {
                nodes[cell * GEOMETRY_NODES + ours][axis] =
                    coordinates[(cell * GEOMETRY_NODES + theirs) * 3 + axis];
            }
        }
    }
    let cells = (0..(count * GEOMETRY_NODES) as u32).collect();
    let mut mesh = Mesh::<D>::from_parts(shape, setting.geometry, nodes, cells)?;
    let local = our_facet(shape, facet) as u8;
    let facets: Vec<Facet> = (0..count as u32).map(|cell| Facet { cell, local }).collect();
    mesh.name_listed_facets(FACETS, &facets)?;
    let mesh = Arc::new(mesh);
    // Where each coefficient starts in a cell's list, and how long that is.
    let probe = form(&Coefficients::none());
    let unknown = probe.fields().iter().find(|field| matches!(field.role, Role::Unknown(_)));
    let components = unknown.map_or(1, |field| field.components());
    let spaces = |index: usize| match index {
        0 => Space::new(
            &mesh,
            forms_fem::space::Family::Continuous,
            setting.degree,
            unknown.map_or(&[], |u| u.shape),
        ),
        _ => Space::scalar(&mesh, setting.coefficients[index]),
    };
    let sizes: Vec<usize> = setting
        .coefficients
        .iter()
        .enumerate()
        .map(|(index, degree)| node_count(shape, *degree) * if index == 0 { components } else { 1 })
        .collect();
    let stride: usize = sizes.iter().sum();
    let mut fields = Vec::new();
    let mut start = 0;
    for (index, degree) in setting.coefficients.iter().enumerate() {
        let space = spaces(index)?;
        let mut values = vec![0.0; space.unknowns()];
        let own = space.components();
        for cell in 0..count {
            let cell_nodes = space.cell_nodes(cell);
            for theirs in 0..node_count(shape, *degree) {
                let ours = match index {
                    0 => numbers[theirs],
                    _ => theirs,
                };
                for a in 0..own {
                    values[cell_nodes[ours] as usize * own + a] =
                        coefficients[cell * stride + start + theirs * own + a];
                }
            }
        }
        fields.push(Some(Field::from_values(&space, values)?));
        start += sizes[index];
    }
    let space = spaces(0)?;
    let u = match fields.first() {
        Some(Some(field)) => field.clone(),
        _ => Field::zero(&space),
    };
    let form = form(&Coefficients { fields });
    let assembler = Assembler::new(&mesh).with_quadrature(quadrature(shape, setting.rule)?);
    let rows = NODES * components;
    match setting.output {
        Output::Residual => {
            let residual = assembler.residual(&form, &[&u], &[&space])?;
            for cell in 0..count {
                for (theirs, ours) in numbers.iter().enumerate() {
                    for a in 0..components {
                        matrices[cell * rows + theirs * components + a] =
                            residual[space.cell_nodes(cell)[*ours] as usize * components + a];
                    }
                }
            }
        }
        Output::Tangent => {
            matrices[..count * rows * rows].fill(0.0);
            for element in assembler.element_matrices(&form, &[&u], &[&space])? {
                let matrix = &mut matrices[element.cell as usize * rows * rows..][..rows * rows];
                for i in 0..rows {
                    for j in 0..rows {
                        let row = numbers[i / components] * components + i % components;
                        let column = numbers[j / components] * components + j % components;
                        matrix[i * rows + j] += element.values[row * rows + column];
                    }
                }
            }
        }
    }
    Ok(())
}
