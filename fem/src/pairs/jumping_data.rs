//! Data that jump at a surface: functions of position that have another value on it than just inside of its body.
//!
//! A position at which bodies touch is a point of both, and a modulus that is a function of position is that of one of them. Kernels
//! would then have a stress of the surface that is none of its body's, and contact would be that of another problem.

use forms_core::contract::{Inputs, Pairing, Source};

use super::PairError;
use crate::mesh::Mesh;

/// The part of the way from the facet's centre to its cell's at which the value inside is taken.
const INSIDE: f64 = 1e-6;

/// A relative difference of values so close to each other that no smooth function has.
const JUMP: f64 = 1e-3;

/// Looks at the functions of position among a form's data at the facets that a pairing integrates over: those of the fields that are
/// read there, which have a name.
pub(crate) fn check<const D: usize>(
    mesh: &Mesh<D>,
    pairing: &Pairing,
    inputs: &Inputs<D>,
    name_of: impl Fn(usize) -> Option<&'static str>,
) -> Result<(), PairError> {
    for facing in &pairing.surfaces {
        // A surface that does not exist, or is rigid, is named where pairs are searched for.
        let Ok(facets) = mesh.facet_region(&facing.own) else { continue };
        for (field, source) in inputs.sources.iter().enumerate() {
            let Some(Source::Function { components, function, .. }) = source else { continue };
            let Some(name) = name_of(field) else { continue };
            let [mut on, mut inside] = [vec![0.0; *components], vec![0.0; *components]];
            for facet in facets {
                let (centre, cell) = (mesh.facet_centre(*facet), mesh.cell_centre(facet.cell as usize));
                function(&centre, &mut on);
                function(&std::array::from_fn(|k| centre[k] + INSIDE * (cell[k] - centre[k])), &mut inside);
                let size = on.iter().chain(&inside).fold(0.0_f64, |size, value| size.max(value.abs()));
                let jumps = |(on, inside): (&f64, &f64)| (on - inside).abs() > JUMP * size;
                if let Some(component) = on.iter().zip(&inside).position(jumps) {
                    return Err(PairError::Jump {
                        field: name,
                        surface: facing.own.clone(),
                        position: centre.to_vec(),
                        values: [on[component], inside[component]],
                    });
                }
            }
        }
    }
    Ok(())
}
