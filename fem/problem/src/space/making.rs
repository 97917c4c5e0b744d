//! Making a space of elements and a scope, with the combinations that are refused.

use std::sync::{Arc, OnceLock};

use super::numbering::{self, Sharing};
use super::{Scope, Space, SpaceError};
use crate::element::{Element, Elements, Lagrange, MAXIMUM_DEGREE, PerShape};
use crate::mesh::{CellLists, INTERIOR, Mesh};

impl<const D: usize> Space<D> {
    /// The space of some elements with a scope: who shares a coefficient. Values have any shape: `[]` scalar, `[D]` vector, `[D, D]`
    /// tensor, `[3]` vectors of three components in any dimension, `[2, 3]` matrices (row-major).
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Triangle, 1)?;
    /// let velocities = Space::of(&mesh, Elements::Mini(1), Scope::Nodes, &[2])?;
    /// let pressures = Space::scalar(&mesh, 1)?;
    /// // 25 vertices; the bubbles are those of 32 cells.
    /// assert_eq!((velocities.node_count(), pressures.node_count()), (25 + 32, 25));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SpaceError`]: elements that do not exist on the mesh's cells or with this scope, an unknown region, a shape without
    /// components, too many unknowns.
    #[inline(never)]
    pub fn of(
        mesh: &Mesh<D>,
        elements: Elements,
        scope: Scope,
        shape: &[usize],
    ) -> Result<Arc<Self>, SpaceError> {
        check_shape(shape, 0)?;
        let on_shapes = elements_on_shapes(mesh, &elements, &scope)?;
        check_scope(mesh, &elements, &on_shapes, &scope)?;
        let lists = CellLists::new(mesh.blocks(), |shape| on_shapes[shape].nodes());
        if u32::try_from(lists.length()).is_err() && matches!(scope.sharing(), Scope::Cell | Scope::Point) {
            return Err(SpaceError::TooLarge { unknowns: lists.length() });
        }
        let mut included = vec![true; if scope.regions().is_empty() { 0 } else { mesh.cell_count() }];
        for region in scope.regions() {
            let mut inside = vec![false; mesh.cell_count()];
            mesh.cell_region(region)?.iter().for_each(|cell| inside[*cell as usize] = true);
            included.iter_mut().zip(inside).for_each(|(included, inside)| *included &= inside);
        }
        let included = |cell: u32| included.get(cell as usize).copied().unwrap_or(true);
        let of_cells = |sharing: Sharing| {
            let nodes = numbering::cell_numbers(mesh, &on_shapes, sharing, &lists, &included);
            let positions = numbering::node_positions(mesh, &on_shapes, &lists, &nodes);
            (nodes, vec![], positions)
        };
        let (cell_nodes, facets, positions) = match scope.sharing() {
            Scope::Nodes => of_cells(Sharing::Entities),
            Scope::Cell | Scope::Point | Scope::Within(..) => of_cells(Sharing::Nobody),
            Scope::Body => {
                let (nodes, facets, mut positions) = of_cells(Sharing::Body);
                let cells = mesh.body_cells().filter(|cell| included(*cell as u32));
                let count = cells.clone().count() as f64;
                if let [position] = &mut positions[..] {
                    *position = [0.0; D];
                    for centre in cells.map(|cell| mesh.cell_centre(cell)) {
                        (0..D).for_each(|k| position[k] += centre[k] / count);
                    }
                }
                (nodes, facets, positions)
            }
            Scope::Facets(region) | Scope::EachFacet(region) => {
                let entities = mesh.sides_of(region)?;
                mesh.without_facet_parts_in(region, "a space on facets")?;
                let (found, positions) = numbering::facet_nodes(mesh, &on_shapes, &scope, &lists, &entities);
                (vec![], found, positions)
            }
        };
        if positions.is_empty() && !scope.regions().is_empty() {
            return Err(SpaceError::Empty { scope });
        }
        check_shape(shape, positions.len())?;
        let degree = on_shapes.values().map(Element::degree).max().unwrap_or(0);
        let (mesh, shape, locator) = (mesh.clone(), shape.to_vec(), OnceLock::new());
        let on_shapes = Arc::new(on_shapes);
        let (on_facets, on_some_cells) = (scope.facet_region().is_some(), !scope.regions().is_empty());
        Ok(Arc::new(Space {
            mesh,
            degree,
            elements,
            on_shapes,
            scope,
            on_facets,
            on_some_cells,
            shape,
            cell_nodes: Arc::new(cell_nodes),
            lists: Arc::new(lists),
            facets: Arc::new(facets),
            positions: Arc::new(positions),
            locator,
        }))
    }
}

/// Checks that values have components, and that the unknowns at some nodes can be counted.
pub(super) fn check_shape(shape: &[usize], nodes: usize) -> Result<(), SpaceError> {
    if shape.contains(&0) {
        return Err(SpaceError::Shape { shape: shape.to_vec() });
    }
    let unknowns = shape.iter().fold(nodes, |product, extent| product.saturating_mul(*extent));
    match u32::try_from(unknowns) {
        Ok(_) => Ok(()),
        Err(_) => Err(SpaceError::TooLarge { unknowns }),
    }
}

/// The elements on the shapes of a mesh's cells.
fn elements_on_shapes<const D: usize>(
    mesh: &Mesh<D>,
    elements: &Elements,
    scope: &Scope,
) -> Result<PerShape<Element>, SpaceError> {
    let shapes = mesh.shapes();
    match elements {
        Elements::Lagrange(degree) if *scope.sharing() == Scope::Nodes => {
            shapes.iter().try_for_each(|shape| Lagrange::new(*shape, *degree).map(|_| ()))?
        }
        Elements::Lagrange(degree) if *degree > MAXIMUM_DEGREE => {
            return Err(SpaceError::Degree { scope: scope.clone(), degree: *degree });
        }
        _ => {}
    }
    let on = |shape| elements.on(shape).map(|element| (shape, element));
    Ok(shapes.into_iter().map(on).collect::<Result<Vec<_>, _>>()?.into_iter().collect())
}

/// Checks that elements can have a scope.
fn check_scope<const D: usize>(
    mesh: &Mesh<D>,
    elements: &Elements,
    on_shapes: &PerShape<Element>,
    scope: &Scope,
) -> Result<(), SpaceError> {
    let refused =
        |reason| Err(SpaceError::Scope { elements: elements.clone(), scope: scope.clone(), reason });
    let all = |condition: &dyn Fn(&Element) -> bool| on_shapes.values().all(condition);
    let is_lagrange = all(&|element| element.as_lagrange().is_some());
    if (elements.is_dual() || matches!(elements, Elements::Bernstein(_))) && scope.facet_region().is_none() {
        return refused("dual functions and Bernstein's are those of facets");
    }
    if matches!(elements, Elements::Points(_)) != (*scope.sharing() == Scope::Point) {
        return refused("`Scope::Point` goes with `Elements::Points`");
    }
    let traces: Vec<_> =
        on_shapes.values().map(|element| element.traces().map(|traces| traces.degree)).collect();
    let alike = traces.iter().all(|degree| degree.is_some() && *degree == traces[0]);
    let shared = !matches!(scope.sharing(), Scope::Body | Scope::Cell | Scope::Point);
    if shared && traces.len() > 1 && !(is_lagrange || alike || !elements.is_nodal()) {
        return refused("cells of several shapes share elements with the traces of one Lagrange element");
    }
    match scope.sharing() {
        Scope::Body if !all(&|element| element.nodes() == 1) => {
            refused("the whole body shares elements with one node: those of degree 0")
        }
        Scope::Nodes
            if all(&|element| (0..element.shape().facets()).all(|f| element.facet_nodes(f).is_empty())) =>
        {
            refused("all their nodes are inside the cell, and no other cell can share them")
        }
        Scope::Nodes if matches!(elements, Elements::Own(_)) && !all(&Element::conforms) => {
            refused("cells on both sides of a facet do not have the same functions there")
        }
        Scope::Nodes if !is_lagrange || !scope.regions().is_empty() => {
            // Conditions that join hanging nodes are those of Lagrange elements.
            Ok(mesh.without_facet_parts_in(
                INTERIOR,
                "a space of other elements than Lagrange elements on all cells",
            )?)
        }
        Scope::Facets(_) | Scope::EachFacet(_) => {
            if !scope.regions().is_empty() {
                return refused("a space on facets is limited by its facet region");
            }
            let constant = all(&|element| matches!(element.as_lagrange(), Some(Lagrange { degree: 0, .. })));
            match constant || all(&Element::conforms) {
                true => Ok(()),
                false => refused("the nodes on a facet do not determine the values there"),
            }
        }
        _ => Ok(()),
    }
}
