//! Ties: the facets that join badly cut cells to cells with enough of the body, for ghost penalties.
//!
//! A cell whose middle is in the body has at least (D/(D+1))^D of its volume there (B. Grünbaum, Pacific J. Math. 10 (1960)): it is *well-posed*.
//! Any other one is tied over one facet to a deeper cell, and over this one, or more, to a well-posed cell. The facet has a part of the body, so that
//! ties do not reach across gaps, and the penalty acts inside these aggregates only (S. Badia, E. Neiva, F. Verdugo, Comput. Methods
//! Appl. Mech. Engrg. 388 (2022)): even a large one does not lock.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::{Cut, CutSide};
use crate::mesh::Facet;

/// The order of floating numbers as that of integers.
fn ordered(value: f64) -> u64 {
    let bits = value.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

impl<const D: usize> Cut<D> {
    /// Rank of a cell: how deep in the body its middle is, then its number.
    pub(super) fn rank(&self, cell: u32) -> (u64, Reverse<u32>) {
        (ordered(self.depth(cell)), Reverse(cell))
    }

    /// −φ in the middle of a cell.
    fn depth(&self, cell: u32) -> f64 {
        let nodes = self.level_nodes(cell);
        if self.degree == 2 {
            let middle = self.lattice.len() / 2;
            let own = nodes.iter().zip(&self.lattice).find(|(_, place)| usize::from(**place) == middle);
            return own.map_or(0.0, |(node, _)| -self.values[*node as usize]);
        }
        -nodes.iter().map(|node| self.values[*node as usize]).sum::<f64>() / nodes.len() as f64
    }

    /// The ties of some cells. Where φ may grow by a `margin` a cell is well-posed if its middle stays in the body. Of cells that hold none of the
    /// body, those with a vertex that no other tied or well-posed cell has are tied: what has a vertex in a gap follows one of the gap's sides.
    pub(super) fn ties(&self, active: &[bool], margin: f64) -> Vec<[Facet; 2]> {
        let has_body = |cell: u32| active[cell as usize] && self.sides[cell as usize] != CutSide::Outside;
        let mut reached: Vec<bool> = (0..self.sides.len() as u32)
            .map(|cell| has_body(cell) && (self.depth(cell) >= margin.max(f64::MIN_POSITIVE)))
            .collect();
        let in_body = |sides: &&[Facet; 2]| {
            let cells = sides.map(|facet| facet.cell);
            cells.iter().all(|cell| has_body(*cell))
                && cells.iter().any(|cell| !reached[*cell as usize])
                && self.side_of_facet(sides[0]) != CutSide::Outside
        };
        let links: Vec<[Facet; 2]> = self.mesh.interior_facets().iter().filter(in_body).copied().collect();
        // In thin parts of the body no middle is far inside: their deepest cells count as well-posed.
        let mut tops: Vec<bool> =
            (0..self.sides.len() as u32).map(|cell| has_body(cell) && self.depth(cell) > 0.0).collect();
        for [a, b] in &links {
            let lower = if self.rank(a.cell) < self.rank(b.cell) { a.cell } else { b.cell };
            tops[lower as usize] = false;
        }
        reached.iter_mut().zip(tops).for_each(|(reached, top)| *reached |= top);
        let mut ties = Vec::new();
        self.flood(&links, &mut reached, &mut |_| true, &mut ties);
        let cells: Vec<u32> = (0..self.sides.len() as u32).filter(|cell| has_body(*cell)).collect();
        cells.into_iter().for_each(|cell| reached[cell as usize] = true);
        self.tie_empty(active, &mut reached, &mut ties);
        ties
    }

    /// Ties of those of some cells that are not reached yet, where they have a vertex that no reached or tied cell has. The cells that have none
    /// are returned.
    pub(super) fn tie_empty(
        &self,
        active: &[bool],
        reached: &mut [bool],
        ties: &mut Vec<[Facet; 2]>,
    ) -> Vec<u32> {
        if active.iter().zip(&*reached).all(|(active, reached)| *reached || !active) {
            return vec![];
        }
        let is_link = |sides: &&[Facet; 2]| {
            let cells = sides.map(|facet| facet.cell as usize);
            cells.iter().all(|cell| active[*cell]) && cells.iter().any(|cell| !reached[*cell])
        };
        let links: Vec<[Facet; 2]> = self.mesh.interior_facets().iter().filter(is_link).copied().collect();
        let mut known = vec![false; self.values.len()];
        for cell in (0..reached.len()).filter(|cell| reached[*cell]) {
            self.vertex_nodes(cell as u32).iter().for_each(|node| known[*node as usize] = true);
        }
        let mut untied = Vec::new();
        let mut is_tied = |cell: u32| {
            let own = self.vertex_nodes(cell);
            let is_new = own.iter().any(|node| !known[*node as usize]);
            own.iter().for_each(|node| known[*node as usize] = true);
            if !is_new {
                untied.push(cell);
            }
            is_new
        };
        self.flood(&links, reached, &mut is_tied, ties);
        untied.sort_unstable();
        untied
    }

    /// Reaches cells over facets from those that are, the deepest first, and ties those that are wanted over the facet by which they are reached. Cells that
    /// nothing reaches are a part of their own, which holds on to its deepest one.
    fn flood(
        &self,
        links: &[[Facet; 2]],
        reached: &mut [bool],
        is_tied: &mut dyn FnMut(u32) -> bool,
        ties: &mut Vec<[Facet; 2]>,
    ) {
        let ends = links.iter().enumerate().flat_map(|(link, sides)| sides.map(|facet| (facet.cell, link)));
        let mut at: Vec<(u32, usize)> = ends.collect();
        at.sort_unstable();
        let mut cells: Vec<u32> = at.iter().map(|(cell, _)| *cell).collect();
        cells.dedup();
        let ranked = |wanted: bool, reached: &[bool]| -> Vec<_> {
            let own = cells.iter().filter(|cell| reached[**cell as usize] == wanted);
            own.map(|cell| self.rank(*cell)).collect()
        };
        let mut queue = BinaryHeap::from(ranked(true, reached));
        let mut others = BinaryHeap::from(ranked(false, reached));
        loop {
            while let Some((_, Reverse(cell))) = queue.pop() {
                let first = at.partition_point(|(other, _)| *other < cell);
                for (_, link) in at[first..].iter().take_while(|(other, _)| *other == cell) {
                    let [a, b] = links[*link];
                    let next = if a.cell == cell { b.cell } else { a.cell };
                    if !reached[next as usize] {
                        reached[next as usize] = true;
                        queue.push(self.rank(next));
                        if is_tied(next) {
                            ties.push([a, b]);
                        }
                    }
                }
            }
            match others.pop() {
                None => return,
                Some(rank) if !reached[rank.1.0 as usize] => {
                    reached[rank.1.0 as usize] = true;
                    queue.push(rank);
                }
                Some(_) => {}
            }
        }
    }
}
