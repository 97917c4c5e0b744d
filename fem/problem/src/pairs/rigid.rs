//! Facets of rigid surfaces at an iterate: their points follow the one cell that carries them.

use super::PairError;
use super::displacement::{Displacement, DisplacementField};
use super::surface::{SurfaceFacet, dot, minus};
use crate::mesh::{CarriedSurface, Facet, Mesh};
use crate::threads::Threads;

/// Facets that a thread makes at a time.
const CHUNK: usize = 1024;

/// A carrier is bent where a node leaves the affine map by more than this part of the displacements and of the cell: more than the
/// rounding of relations between its unknowns.
const ROUNDING: f64 = 1e-9;

/// A map from reference coordinates, by its value at the origin and along each axis.
struct Affine<const D: usize> {
    start: [f64; D],
    along: [[f64; D]; D],
}

impl<const D: usize> Affine<D> {
    fn at(&self, reference: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|k| {
            self.start[k] + (0..D).map(|axis| reference[axis] * self.along[axis][k]).sum::<f64>()
        })
    }

    /// That of a displacement on the cell that carries a surface.
    fn of(
        mesh: &Mesh<D>,
        carried: &CarriedSurface<D>,
        field: &DisplacementField<D>,
    ) -> Result<Self, PairError> {
        let shape = mesh.cell_shape(carried.cell as usize);
        let places = field.space.element_of(shape).node_points::<D>();
        let nodes = field.space.nodes_at(carried.cell, None);
        let at = |place: &dyn Fn(usize) -> f64| {
            let is_there = |x: &&[f64; D]| (0..D).all(|k| x[k] == place(k));
            let index = places.iter().zip(0..).find(|(x, _)| is_there(x)).map_or(0, |(_, index)| index);
            nodes.get(index).map_or([0.0; D], |node| field.value_at(*node))
        };
        // Degree zero has one node, in the middle: the motion is a translation.
        let start = at(&|_| 0.0);
        let along = std::array::from_fn(|axis| minus(&at(&|k| f64::from(u8::from(k == axis))), &start));
        let map = Affine { start, along };
        let length = |a: &[f64; D]| dot(a, a).sqrt();
        let size =
            length(&start) + along.iter().map(length).sum::<f64>() + mesh.diameter(carried.cell as usize);
        for (place, node) in places.iter().zip(nodes) {
            let away = length(&minus(&field.value_at(*node), &map.at(place)));
            // NaN is reported where it is assembled.
            if away > ROUNDING * size {
                return Err(PairError::Bent { surface: carried.name.clone(), away });
            }
        }
        Ok(map)
    }
}

/// The facets of a rigid surface, displaced.
pub(super) fn facets<'m, const D: usize>(
    mesh: &'m Mesh<D>,
    carried: &CarriedSurface<D>,
    displacement: Option<&Displacement<D>>,
    threads: Threads,
) -> Result<Vec<SurfaceFacet<'m, D>>, PairError> {
    let mut motions = Vec::new();
    for field in displacement.iter().flat_map(|displacement| &displacement.fields) {
        motions.push(Affine::of(mesh, carried, field)?);
    }
    let place = |(x, reference): (&[f64; D], &[f64; D])| {
        let moved = |x: [f64; D], motion: &Affine<D>| {
            let by = motion.at(reference);
            std::array::from_fn(|k| x[k] + by[k])
        };
        motions.iter().fold(*x, moved)
    };
    let positions: Vec<[f64; D]> =
        carried.surface.points().iter().zip(&*carried.references).map(place).collect();
    let count = carried.surface.facets().len();
    let parts = threads.count().min(count.div_ceil(CHUNK)).max(1);
    let parts = (0..parts).map(|part| part * count / parts..(part + 1) * count / parts).collect();
    let made = threads.run(parts, |part: std::ops::Range<usize>| -> Vec<SurfaceFacet<'m, D>> {
        part.map(|index| SurfaceFacet::rigid(mesh, carried, index, &positions)).collect()
    });
    Ok(made.into_iter().flatten().collect())
}

/// The facets of a surface as what couples unknowns: those of a body, or the one that represents a rigid surface.
pub(crate) fn coupled_facets<'m, const D: usize>(
    mesh: &'m Mesh<D>,
    name: &str,
) -> Result<std::borrow::Cow<'m, [Facet]>, PairError> {
    if let Some(carrier) = mesh.carrier(name) {
        return Ok(vec![carrier].into());
    }
    mesh.facets_of_surface(name).map(Into::into).map_err(|source| PairError::Surface { source })
}
