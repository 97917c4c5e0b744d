//! Interior facets between parts: of two processes that meet there the one with the lower rank gets copies of the cells behind them, and
//! integrates.

use std::collections::{BTreeMap, BTreeSet, HashMap};

#[cfg(doc)]
use forms_fem::mesh::Mesh;
use forms_fem::mesh::{BOUNDARY, Facet, GhostCells, MeshError};

use super::MeshPart;
use super::ghost_cells::{CellsAtSurfaces, Merged, lost, unfit};
use super::shared_nodes::Vertices;
use super::words::{Words, add, exchanged};
use crate::error::{DistributedError, PetscError};

/// Numbers of a facet's vertices in the whole mesh, ascending.
type FacetKey = Vec<u64>;

/// A list for each of some other processes.
type Lists = Vec<(usize, Vec<u64>)>;

impl<const D: usize> MeshPart<'_, D> {
    /// This part with interior facets: integrals over "interior" count each facet of the whole mesh once, those between parts, too. Each process
    /// has copies of the cells behind its facets to processes of higher rank ([`MeshPart::ghost_cells`]). The first side of a facet between parts is
    /// of the process with the lower rank. Spaces come afterwards.
    ///
    /// ```no_run
    /// # use forms_distributed::World;
    /// # use forms_fem::prelude::*;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let world = World::start()?;
    /// let part = world.cuboid([0.0; 3], [1.0; 3], [8; 3], CellShape::Tetrahedron, 1)?.with_interior_facets()?;
    /// let space = Space::discontinuous_scalar(&part, 1)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// Parts of a mesh with hanging nodes have them from the start. [`MeshPart::with_surfaces`] may come before or afterwards.
    ///
    /// # Errors
    /// A failed exchange.
    pub fn with_interior_facets(self) -> Result<Self, PetscError> {
        let world = self.world();
        if self.mesh.has_facets_between_pieces() {
            return Ok(self);
        }
        let shapes = self.shapes_of_all()?;
        let met = self.facets_met()?;
        let own_rank = world.rank();
        let behind = |rank: usize, cells: &[u32]| if rank < own_rank { cells.to_vec() } else { vec![] };
        let sent: Vec<(usize, Vec<u32>)> =
            met.iter().map(|(rank, cells)| (*rank, behind(*rank, cells))).collect();
        let cells = sent.iter().map(|(rank, cells)| (*rank, self.described(cells).to_words())).collect();
        let found = exchanged(world, "cells behind facets", cells)?;
        let (mut merged, mut behind) = (Merged::new(&self, &[]), vec![]);
        let joined: Result<(), PetscError> =
            found.iter().filter(|(rank, _)| *rank > own_rank).try_for_each(|(_, words)| {
                let cells = CellsAtSurfaces::of_words(words).ok_or_else(lost)?;
                behind.extend(merged.add(&cells).ok_or_else(lost)?);
                Ok(())
            });
        world.agree(joined)?;
        let sharers = self.sharers_with_copies(&sent, &merged.places)?;
        behind.sort_unstable();
        let Merged { nodes, blocks, numbers, .. } = merged;
        let (surfaces, behind_facets) = (BTreeMap::new(), Some(behind));
        let ghosts = GhostCells { nodes, blocks, surfaces, behind_facets, facet_parts: vec![], shapes };
        let mesh = world.agree(self.mesh.with_ghost_cells(ghosts).map_err(unfit))?;
        Ok(MeshPart::new(world, mesh, Vertices { numbers, sharers }))
    }

    /// As [`Mesh::name_interior_facets`], on all processes together: a process may have none of the facets. Regions come before spaces.
    ///
    /// # Errors
    /// Those of [`Mesh::name_interior_facets`], on all processes.
    pub fn name_interior_facets(
        &mut self,
        name: &str,
        within: &str,
        condition: impl Fn(&[f64; D]) -> bool,
    ) -> Result<(), DistributedError<MeshError>> {
        let named = self.mesh.name_interior_facets(name, within, condition);
        let count = self.mesh.interior_facet_region(name).map_or(0, <[_]>::len);
        self.check_named(named, count, name, "interior facet")
    }

    /// The processes whose vertices are here, too, each with the cells of this process at the facets that both have, in an order that both know.
    fn facets_met(&self) -> Result<Vec<(usize, Vec<u32>)>, PetscError> {
        let cut = self.cut_facets();
        let ranks: BTreeSet<usize> = self.vertices.sharers.values().flatten().copied().collect();
        let keys_for = |rank: usize| {
            let mut words = vec![];
            for (key, _) in cut.iter().filter(|(_, (_, others))| others.contains(&rank)) {
                add(&mut words, key.iter().copied());
            }
            (rank, words)
        };
        let found = exchanged(self.world(), "facets", ranks.iter().map(|rank| keys_for(*rank)).collect())?;
        let mut met = vec![];
        for (rank, words) in found {
            let (mut rest, mut cells) = (Words(&words), vec![]);
            while let Some(key) = rest.list(|number| *number) {
                cells.extend(cut.get(&key).map(|(facet, _)| facet.cell));
            }
            cells.sort_unstable();
            cells.dedup();
            met.push((rank, cells));
        }
        Ok(met)
    }

    /// The facets of one cell that are on no boundary, with the processes that have all their vertices.
    fn cut_facets(&self) -> BTreeMap<FacetKey, (Facet, Vec<usize>)> {
        let (mesh, boundary) = (&self.mesh, self.mesh.facet_region(BOUNDARY).unwrap_or_default());
        let mut found: BTreeMap<FacetKey, (Facet, Vec<usize>)> = BTreeMap::new();
        for cell in mesh.body_cells() {
            let corners = mesh.cell_vertices(cell);
            let shape = mesh.cell_shape(cell);
            for local in 0..shape.facets() {
                let vertices = shape.facet_vertices(local).iter().map(|corner| corners[*corner]);
                let shared: Option<Vec<&Vec<usize>>> =
                    vertices.clone().map(|vertex| self.vertices.sharers.get(&vertex)).collect();
                let Some([first, others @ ..]) = shared.as_deref() else { continue };
                let is_everywhere = |rank: &&usize| others.iter().all(|ranks| ranks.contains(rank));
                let ranks: Vec<usize> = first.iter().filter(is_everywhere).copied().collect();
                let facet = Facet { cell: cell as u32, local: local as u8 };
                if ranks.is_empty() || boundary.binary_search(&facet).is_ok() {
                    continue;
                }
                let mut key: FacetKey =
                    vertices.map(|vertex| self.vertices.numbers[vertex as usize]).collect();
                key.sort_unstable();
                // One between two cells that are here is none of the cut.
                if found.remove(&key).is_none() {
                    found.insert(key, (facet, ranks));
                }
            }
        }
        found
    }

    /// The other processes that have each vertex once cells have been sent, of this process's cells and of its copies. Those that have a vertex in
    /// own cells tell each other about copies, and then the processes with copies.
    fn sharers_with_copies(
        &self,
        sent: &[(usize, Vec<u32>)],
        places: &HashMap<u64, u32>,
    ) -> Result<BTreeMap<u32, Vec<usize>>, PetscError> {
        let (world, own_rank) = (self.world(), self.world().rank());
        let before = &self.vertices.sharers;
        let number = |vertex: u32| self.vertices.numbers[vertex as usize];
        let vertices_of = |cells: &[u32]| -> BTreeSet<u32> {
            cells.iter().flat_map(|cell| self.mesh.cell_vertices(*cell as usize)).copied().collect()
        };
        let mut holders: BTreeMap<u32, BTreeSet<usize>> =
            before.iter().map(|(vertex, ranks)| (*vertex, ranks.iter().copied().collect())).collect();
        let mut news: BTreeMap<usize, Vec<u64>> = sent.iter().map(|(rank, _)| (*rank, vec![])).collect();
        for (rank, cells) in sent {
            for vertex in vertices_of(cells) {
                let known = before.get(&vertex).map_or(&[][..], Vec::as_slice);
                if known.contains(rank) {
                    continue;
                }
                holders.entry(vertex).or_default().insert(*rank);
                for other in known {
                    news.entry(*other).or_default().extend([number(vertex), *rank as u64]);
                }
            }
        }
        let place = |number: u64| places.get(&number).copied().ok_or_else(lost);
        let told = exchanged(world, "vertices of copies", news.into_iter().collect())?;
        let mut take = || -> Result<(), PetscError> {
            for pair in told.iter().flat_map(|(_, words)| words.as_chunks::<2>().0) {
                let [number, rank] = pair;
                holders.entry(place(*number)?).or_default().insert(*rank as usize);
            }
            Ok(())
        };
        let taken = take();
        world.agree(taken)?;
        let all_of = |(rank, cells): &(usize, Vec<u32>)| {
            let mut words = vec![];
            for vertex in vertices_of(cells) {
                let others = holders.get(&vertex).into_iter().flatten().filter(|other| *other != rank);
                words.push(number(vertex));
                add(&mut words, others.chain([&own_rank]).map(|other| *other as u64));
            }
            (*rank, words)
        };
        let lists: Lists = sent.iter().map(all_of).collect();
        let told = exchanged(world, "holders of vertices", lists)?;
        let mut take = || -> Result<(), PetscError> {
            for (_, words) in &told {
                let mut rest = Words(words);
                while let Some(number) = rest.number() {
                    let others = rest.list(|rank| *rank as usize).ok_or_else(lost)?;
                    holders.entry(place(number as u64)?).or_default().extend(others);
                }
            }
            Ok(())
        };
        let taken = take();
        world.agree(taken)?;
        Ok(holders.into_iter().map(|(vertex, ranks)| (vertex, ranks.into_iter().collect())).collect())
    }
}
