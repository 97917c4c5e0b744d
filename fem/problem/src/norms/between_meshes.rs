//! Errors between two meshes of one body, integrated on the finer one: its quadrature points are located in the other
//! mesh once, and every field of that mesh is read there.

use std::sync::Arc;

use super::{Norms, errors_against};
use crate::assemble::{Assembler, AssemblyError, degree_on_all_cells};
use crate::dimension::{Dim, Dimension};
use crate::element::PerShape;
use crate::field::Field;
use crate::field::places::{in_parts, place, usual_reach};
use crate::mesh::EVERYWHERE;
use crate::space::Space;

/// Its name in messages.
const NAME: &str = "errors between meshes";

/// Places in a coarse mesh of a reference mesh's quadrature points.
#[derive(Clone, Debug)]
pub struct Comparison<const D: usize> {
    assembler: Assembler<D>,
    degree: usize,
    coarse: Arc<Space<D>>,
    /// Cell of the coarse mesh and reference coordinates there, cell by cell of the reference mesh.
    places: Vec<(u32, [f64; D])>,
}

impl<const D: usize> Comparison<D> {
    /// The quadrature points of the assembler's mesh, the reference, located in the mesh of a space. Where the
    /// assembler takes the compiler's estimate, the rule has `degree`. Where the coarse mesh's curved boundary deviates
    /// from the reference's, coarse fields are extrapolated from their nearest cell.
    ///
    /// # Errors
    /// A point of the reference further from the coarse mesh than a tenth of its largest cell, or a rule that does not
    /// exist.
    pub fn new(
        assembler: &Assembler<D>,
        coarse: &Arc<Space<D>>,
        degree: usize,
    ) -> Result<Self, AssemblyError> {
        let (mesh, locator) = (assembler.mesh(), coarse.locator());
        let reach = usual_reach(locator.mesh());
        let of_shape = |shape| {
            let rule = assembler.quadrature().rule_on_cells(&mesh.shapes(), shape, degree);
            Ok((shape, rule.map_err(|source| AssemblyError::Quadrature { form: NAME, source })?.points))
        };
        let points: PerShape<Vec<[f64; D]>> =
            mesh.shapes().into_iter().map(of_shape).collect::<Result<_, AssemblyError>>()?;
        let cells = mesh.cell_region(EVERYWHERE).map_err(|source| AssemblyError::Region {
            form: NAME,
            symbol: "of them",
            source,
        })?;
        let locate = |cell: u32, point: &[f64; D]| {
            let (position, _) = mesh.map(cell as usize, point);
            let outside = || AssemblyError::Outside { form: NAME, position: position.to_vec() };
            place(locator, &position, reach).ok_or_else(outside)
        };
        let located = in_parts(assembler.threads(), cells.len(), |range| {
            let points = cells[range].iter().flat_map(|&cell| {
                points[mesh.cell_shape(cell as usize)].iter().map(move |point| (cell, point))
            });
            points.map(|(cell, point)| locate(cell, point)).collect::<Result<Vec<_>, AssemblyError>>()
        });
        let places = located.into_iter().collect::<Result<Vec<_>, _>>()?.concat();
        Ok(Comparison { assembler: assembler.clone(), degree, coarse: coarse.clone(), places })
    }

    /// The norms of reference − coarse, integrated over the reference's mesh.
    ///
    /// # Errors
    /// A coarse field on another mesh, a reference on another one, fields of different rank, a value that is not finite.
    pub fn errors(&self, reference: &Field<D>, coarse: &Field<D>) -> Result<Norms, AssemblyError>
    where
        Dim: Dimension<D>,
    {
        if !coarse.space().mesh().is_same(self.coarse.mesh()) {
            return Err(AssemblyError::OtherMesh { form: NAME, field: "the coarse one" });
        }
        let components = coarse.space().components();
        let value = self.read(components, |cell, point| coarse.evaluate_in(cell, point))?;
        let slope = self.read(components * D, |cell, point| coarse.gradient_in(cell, point))?;
        errors_against(&self.assembler, reference, value, slope)
    }

    /// Values of the coarse mesh at the points of the reference's rule.
    fn read(
        &self,
        components: usize,
        evaluate: impl Fn(usize, &[f64; D]) -> Vec<f64> + Send + Sync,
    ) -> Result<forms_core::contract::Source<D>, AssemblyError> {
        let parts = in_parts(self.assembler.threads(), self.places.len(), |range| {
            let mut values = Vec::with_capacity(range.len() * components);
            for (cell, point) in &self.places[range] {
                values.extend(evaluate(*cell as usize, point));
            }
            values
        });
        self.assembler.known_at_points(self.degree, components, parts.concat())
    }
}

/// The norms of reference − coarse, integrated on the reference's mesh; [`Comparison`] is for several fields of two
/// meshes. Where the coarse mesh's curved boundary deviates from the reference's, the coarse field is extrapolated
/// from its nearest cell.
///
/// # Errors
/// A reference point too far from the coarse mesh, fields of different rank, a value that is not finite.
pub fn errors_between<const D: usize>(
    assembler: &Assembler<D>,
    reference: &Field<D>,
    coarse: &Field<D>,
) -> Result<Norms, AssemblyError>
where
    Dim: Dimension<D>,
{
    // Exact for the square of the reference on affine cells.
    let degree = degree_on_all_cells(assembler.mesh(), 2 * reference.space().degree());
    Comparison::new(assembler, coarse.space(), degree)?.errors(reference, coarse)
}
