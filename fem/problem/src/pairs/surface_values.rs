//! The values that displace a pairing's surfaces: what pairs depend on, which identify known searches.

use std::sync::{Arc, Mutex, PoisonError};

use forms_core::contract::Pairing;

use super::newest::{KEPT, keep};
use super::surfaces::{names, nodes_on_surfaces};
use super::{Displacement, PairError};
use crate::element::Elements;
use crate::mesh::Mesh;
use crate::space::{Scope, Space};

/// The nodes of spaces on surfaces of one mesh that were looked up.
#[derive(Debug, Default)]
pub(super) struct SurfaceNodes(Mutex<Vec<NodesOfSpace>>);

#[derive(Debug)]
struct NodesOfSpace {
    surfaces: Vec<String>,
    elements: Elements,
    scope: Scope,
    nodes: Arc<[u32]>,
}

impl SurfaceNodes {
    fn of<const D: usize>(
        &self,
        mesh: &Mesh<D>,
        pairing: &Pairing,
        space: &Space<D>,
    ) -> Result<Arc<[u32]>, PairError> {
        let surfaces = names(pairing);
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_this = |known: &&NodesOfSpace| {
            known.elements == space.elements && known.scope == space.scope && known.surfaces == surfaces
        };
        if let Some(known) = known.iter().find(is_this) {
            return Ok(Arc::clone(&known.nodes));
        }
        let nodes: Arc<[u32]> = nodes_on_surfaces(mesh, pairing, space)?.into();
        let surfaces = surfaces.into_iter().map(str::to_owned).collect();
        let (elements, scope) = (space.elements.clone(), space.scope.clone());
        keep(&mut known, NodesOfSpace { surfaces, elements, scope, nodes: Arc::clone(&nodes) }, KEPT, |_| {
            true
        });
        Ok(nodes)
    }

    /// The values of the fields that displace a pairing's surfaces at the nodes there, each with its degree and family as numbers.
    ///
    /// # Errors
    /// A field that is not known on a surface.
    pub fn values<const D: usize>(
        &self,
        mesh: &Mesh<D>,
        pairing: &Pairing,
        displacement: &Displacement<D>,
    ) -> Result<Vec<f64>, PairError> {
        let mut values = Vec::new();
        for field in &displacement.fields {
            let nodes = self.of(mesh, pairing, field.space)?;
            let discontinuous = f64::from(u8::from(field.space.scope == Scope::Cell));
            // At once: a list that grows looks at its room for each number.
            let mut of_field: Vec<[f64; D]> = Vec::with_capacity(nodes.len() + 1);
            of_field.extend(nodes.iter().map(|node| field.value_at(*node)));
            let of_field = of_field.into_flattened();
            if values.is_empty() {
                values = of_field;
            } else {
                values.extend_from_slice(&of_field);
            }
            values.extend([field.space.trace_degree() as f64, discontinuous]);
        }
        Ok(values)
    }
}
