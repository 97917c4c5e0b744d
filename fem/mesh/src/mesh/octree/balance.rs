//! Balance of a refinement: the cells that are divided with the marked ones, so that cells differ by one division at most.

use super::OctreeMesh;

/// The end of a list.
const NONE: u32 = u32::MAX;

/// For each cell whether it is divided, with some marked ones.
///
/// A cell's part at vertex v has halves of the edges at v. When it is divided, no cell may be left with one of these edges undivided. A larger cell
/// across a facet has that facet's edges, so that edges tell of facets, too.
pub(super) fn divided_with<const D: usize>(coarse: &OctreeMesh<D>, marked: &[u32]) -> Vec<bool> {
    let mesh = &coarse.mesh;
    let shape = coarse.shape();
    // For each node the first entry in the list of the cells that have it as a vertex; entries are places of vertices, cell after cell.
    let count = shape.vertices();
    let mut first_at = vec![NONE; mesh.node_count()];
    let mut next_at = vec![NONE; mesh.cell_count() * count];
    for cell in 0..mesh.cell_count() {
        for (place, vertex) in mesh.cell_vertices(cell).iter().enumerate() {
            let entry = cell * count + place;
            next_at[entry] = std::mem::replace(&mut first_at[*vertex as usize], entry as u32);
        }
    }
    let mut divided = vec![false; mesh.cell_count()];
    let mut waiting: Vec<u32> = marked.to_vec();
    while let Some(cell) = waiting.pop() {
        if std::mem::replace(&mut divided[cell as usize], true) {
            continue;
        }
        let Some(origin) = coarse.origins[cell as usize] else { continue };
        let whole = coarse.divided.cell(origin.whole as usize);
        let at_part = |edge: &&[usize; 2]| edge.contains(&usize::from(origin.part));
        for [a, b] in shape.edges().iter().filter(at_part).map(|edge| edge.map(|vertex| whole[vertex])) {
            let mut entry = first_at[a as usize];
            while entry != NONE {
                let (other, place) = (entry as usize / count, entry as usize % count);
                let vertices = mesh.cell_vertices(other);
                let has_edge = |edge: &[usize; 2]| {
                    (edge[0] == place && vertices[edge[1]] == b)
                        || (edge[1] == place && vertices[edge[0]] == b)
                };
                if !divided[other] && shape.edges().iter().any(has_edge) {
                    waiting.push(other as u32);
                }
                entry = next_at[entry as usize];
            }
        }
    }
    divided
}
