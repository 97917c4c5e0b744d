//! The mesh of a closure's leaves, with regions carried over.

use super::closure::Closure;
use super::marked_edges::{MarkedEdges, Part, step};
use super::{BisectedMesh, Bisection, Origin, opposite, simplex};
use crate::mesh::nesting::{Nesting, Parts};
use crate::mesh::{Facet, Mesh, MeshError, Surface};

/// The facet inside the coarse cell.
const INSIDE: u8 = u8::MAX;

/// The leaves of a closure, in the order of the coarse cells.
struct Leaves<const D: usize> {
    cells: Vec<u32>,
    marks: Vec<MarkedEdges>,
    origins: Vec<Option<Origin>>,
    bisections: Vec<Bisection>,
    /// For each facet of each leaf the facet of the coarse cell that it lies on.
    facets: Vec<[u8; 4]>,
    parts: Parts<D>,
    /// The steps from the coarse cell to the present one.
    path: Vec<u8>,
}

pub(super) fn from_closure<const D: usize>(
    coarse: &BisectedMesh<D>,
    mut closed: Closure<D>,
    surfaces: &[Surface<'_, D>],
) -> Result<(BisectedMesh<D>, Nesting<D>), MeshError> {
    let old = &coarse.mesh;
    let shape = simplex::<D>();
    let mut leaves = Leaves {
        cells: Vec::new(),
        marks: Vec::new(),
        origins: Vec::new(),
        bisections: coarse.bisections.clone(),
        facets: Vec::new(),
        parts: Parts::new(shape),
        path: Vec::new(),
    };
    for cell in 0..old.cell_count() {
        leaves.parts.next_coarse();
        leaves.visit(&closed, cell, coarse.origins[cell], [0, 1, 2, 3]);
    }
    let Leaves { cells, marks, origins, bisections, facets, parts, .. } = leaves;
    let nesting = parts.nesting();
    let small_facets = |facet: Facet| -> Vec<Facet> {
        let of_leaf = |leaf: usize| {
            let own = facets[leaf].iter().enumerate().take(shape.facets());
            own.filter(|(_, on)| **on == facet.local)
                .map(move |(local, _)| Facet { cell: leaf as u32, local: local as u8 })
        };
        nesting.fine_cells(facet.cell as usize).flat_map(of_leaf).collect()
    };
    let mut nodes = std::mem::take(&mut closed.nodes);
    let element = old.element_of(shape);
    let on_facets: Vec<Vec<usize>> = (0..shape.facets()).map(|local| element.facet_nodes(local)).collect();
    for (region, map) in surfaces {
        let mut moved = std::collections::BTreeSet::new();
        for facet in old.sides_of(region)?.iter().flat_map(|sides| small_facets(sides[0])) {
            let of_cell = &cells[facet.cell as usize * element.nodes()..];
            let on_facet = on_facets[usize::from(facet.local)].iter().map(|node| of_cell[*node] as usize);
            moved.extend(on_facet.filter(|node| *node >= old.node_count()));
        }
        for node in moved {
            nodes[node] = map(&nodes[node]);
        }
    }
    // Cells touch where those of the coarse mesh do.
    let mut mesh = Mesh::of_sound_cells(old.degree, nodes, vec![(shape, cells)])?;
    let children = |cell: u32| {
        let fine = nesting.fine_cells(cell as usize);
        fine.start as u32..fine.end as u32
    };
    mesh.inherit_regions(old, &children, &small_facets)?;
    Ok((BisectedMesh { mesh, marks, origins, bisections }, nesting))
}

impl<const D: usize> Leaves<D> {
    /// Adds the leaves that a cell has become.
    fn visit(&mut self, closed: &Closure<D>, cell: usize, origin: Option<Origin>, facets: [u8; 4]) {
        let marks = closed.marks(cell);
        let Some(first) = closed.parts(cell) else {
            self.cells.extend_from_slice(closed.cell(cell));
            self.marks.push(marks);
            self.origins.push(origin);
            self.facets.push(facets);
            self.parts.add(&self.path);
            return;
        };
        let shape = simplex::<D>();
        let edge = marks.refinement_edge();
        let bisection = self.bisections.len() as u32;
        self.bisections.push(Bisection { marks, origin });
        for (number, part) in (first..).zip(Part::BOTH) {
            let [kept, _] = part.kept_and_new(shape.edges()[edge]);
            let mut of_part = facets;
            of_part[opposite(shape, kept)] = INSIDE;
            self.path.push(step(edge, part));
            self.visit(closed, number, Some(Origin { bisection, part }), of_part);
            self.path.pop();
        }
    }
}
