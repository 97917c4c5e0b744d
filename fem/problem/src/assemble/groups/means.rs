//! Tables by which means over whole cells are taken, whatever the points of the integral: the same numbers in cells, on their
//! facets and on contact pairs.

use crate::assemble::AssemblyError;
use crate::assemble::binding::Tabulated;
use crate::element::{CellShape, Tables};
use crate::mesh::Mesh;
use crate::quadrature::{QuadratureError, cell_rule};
use crate::space::Space;

/// Tables of a group beyond values and gradients.
#[derive(Clone, Copy, Default, PartialEq)]
pub(in crate::assemble) struct FurtherTables {
    pub hessians: bool,
    pub means: bool,
    /// The values of fields on facets are their coefficients: points are the nodes.
    pub coefficients: bool,
}

/// A rule on the cell that is exact for what is averaged, and the tables at its points.
#[derive(Clone)]
pub(in crate::assemble) struct MeanTables<const D: usize> {
    pub weights: Vec<f64>,
    /// The geometry map's basis.
    pub geometry: Tables<D>,
    /// One table per element of the binding; of a space on facets, an empty one.
    pub elements: Vec<Tables<D>>,
}

impl<const D: usize> MeanTables<D> {
    pub fn new(mesh: &Mesh<D>, elements: &[Tabulated], shape: CellShape) -> Result<Self, QuadratureError> {
        // det J and its product with J⁻ᵀ have at most this degree in each direction.
        let of_map = if mesh.is_affine_on(shape) { 0 } else { D * mesh.degree() };
        let highest = elements.iter().map(|element| element.degree).max().unwrap_or(0);
        let rule = cell_rule::<D>(shape, of_map + highest)?;
        Ok(MeanTables {
            geometry: mesh.element_of(shape).tabulate(&rule.points),
            elements: elements
                .iter()
                .map(|element| element.tabulate(shape, &rule.points, None, FurtherTables::default()))
                .collect(),
            weights: rule.weights,
        })
    }
}

impl<const D: usize> super::Group<D> {
    /// Check that the functions of a space have means over cells.
    ///
    /// # Errors
    /// [`AssemblyError::MeanOnFacets`] if the space lives on facets; [`AssemblyError::NoMean`] if its functions are not those of a
    /// reference cell.
    pub fn check_mean(
        &self,
        form: &'static str,
        field: &'static str,
        space: &Space<D>,
    ) -> Result<(), AssemblyError> {
        match space.facet_region() {
            Some(region) => Err(AssemblyError::MeanOnFacets { form, field, region: region.to_owned() }),
            None => {
                let mut shapes = self.sides.iter().map(|side| space.element_of(side.shape));
                match shapes.any(|element| element.is_at_points() || element.is_in_space()) {
                    true => Err(AssemblyError::NoMean { form, field, elements: space.elements().clone() }),
                    false => Ok(()),
                }
            }
        }
    }
}
