//! Partition of a mesh into subdomains, one for each process, and the subdomains as lists of numbers, which go from process to process.

use std::collections::BTreeMap;

use forms_fem::element::CellShape;
use forms_fem::mesh::{BOUNDARY, EVERYWHERE, Facet, Mesh, MeshError, RegionNames};

use super::MeshPart;
use super::shared_nodes::Vertices;
use super::words::{Words, add, facet_of, word_of};
use crate::world::World;

/// A mesh with the processes that its vertices go to.
pub(super) struct Partition<'m, const D: usize> {
    mesh: &'m Mesh<D>,
    /// The cells of each process, ascending.
    cells: Vec<Vec<u32>>,
    /// The processes of each vertex that several have, ascending.
    sharers: BTreeMap<u32, Vec<usize>>,
}

/// The cells of one process, and what it has of the whole.
pub(super) struct Subdomain<const D: usize> {
    mesh: Mesh<D>,
    /// Facets to cells of other processes, ascending.
    cut: Vec<Facet>,
    /// Names of the regions of cells and of facets of the whole.
    names: [Vec<String>; 2],
    vertices: Vertices,
}

/// No process yet.
const NOBODY: usize = usize::MAX;

impl<'m, const D: usize> Partition<'m, D> {
    /// The partition with a process for each cell, or without these one along the curve on which the cells are walked.
    pub fn new(world: &World, mesh: &'m Mesh<D>, owners: Option<&[usize]>) -> Self {
        let processes = world.size();
        let mut cells = vec![vec![]; processes];
        match owners {
            Some(owners) => owners.iter().zip(0..).for_each(|(owner, cell)| cells[*owner].push(cell)),
            None => {
                for (rank, cells) in cells.iter_mut().enumerate() {
                    cells.extend(&mesh.cell_order().cells()[world.part_of(rank, mesh.cell_count())]);
                    cells.sort_unstable();
                }
            }
        }
        let mut first = vec![NOBODY; mesh.node_count()];
        let mut sharers: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (rank, cells) in cells.iter().enumerate() {
            for cell in cells {
                for vertex in mesh.cell_vertices(*cell as usize) {
                    let known = &mut first[*vertex as usize];
                    if *known == NOBODY {
                        *known = rank;
                    } else if *known != rank {
                        let all = sharers.entry(*vertex).or_insert_with(|| vec![*known]);
                        if all.last() != Some(&rank) {
                            all.push(rank);
                        }
                    }
                }
            }
        }
        Partition { mesh, cells, sharers }
    }

    /// The cells of a process.
    pub fn subdomain(&self, rank: usize) -> Result<Subdomain<D>, MeshError> {
        let mesh = self.mesh;
        let part = mesh.part_of_cells(self.cells[rank].clone())?;
        let is_cut = |facet: &&Facet| {
            let parent = Facet { cell: part.cells[facet.cell as usize], local: facet.local };
            mesh.boundary_facets().binary_search(&parent).is_err()
        };
        let cut = part.mesh.boundary_facets().iter().filter(is_cut).copied().collect();
        let list = |names: &mut dyn Iterator<Item = &str>| names.map(str::to_owned).collect::<Vec<_>>();
        let names = [list(&mut mesh.cell_region_names()), list(&mut mesh.facet_region_names())];
        let others = |(local, node): (usize, &u32)| {
            let all = self.sharers.get(node)?;
            Some((local as u32, all.iter().filter(|other| **other != rank).copied().collect()))
        };
        let sharers = part.nodes.iter().enumerate().filter_map(others).collect();
        let numbers = part.nodes.iter().map(|node| u64::from(*node)).collect();
        Ok(Subdomain { mesh: part.mesh, cut, names, vertices: Vertices { numbers, sharers } })
    }
}

impl<const D: usize> Subdomain<D> {
    /// The subdomain as this process's part.
    pub fn into_part(self, world: &World) -> MeshPart<'_, D> {
        let [cells, facets] = &self.names;
        let mesh = self.mesh.into_piece(&self.cut, RegionNames { cells, facets });
        MeshPart::new(world, mesh, self.vertices)
    }

    /// The subdomain as a list of numbers.
    pub fn to_words(&self) -> Vec<u64> {
        let mesh = &self.mesh;
        let mut words = vec![mesh.degree() as u64];
        add(&mut words, mesh.nodes().iter().flatten().map(|coordinate| coordinate.to_bits()));
        words.push(mesh.blocks().len() as u64);
        for block in mesh.blocks() {
            add(&mut words, block.shape.name().bytes().map(u64::from));
            add(
                &mut words,
                block.cells.clone().flat_map(|cell| mesh.cell(cell)).map(|node| u64::from(*node)),
            );
        }
        let [cells, facets] = &self.names;
        words.push(cells.len() as u64);
        for name in cells {
            add(&mut words, name.bytes().map(u64::from));
            let region = mesh.cell_region(name).unwrap_or_default();
            add(&mut words, region.iter().map(|cell| u64::from(*cell)));
        }
        words.push(facets.len() as u64);
        for name in facets {
            add(&mut words, name.bytes().map(u64::from));
            add(&mut words, mesh.facet_region(name).unwrap_or_default().iter().map(word_of));
        }
        add(&mut words, self.cut.iter().map(word_of));
        add(&mut words, self.vertices.numbers.iter().copied());
        words.push(self.vertices.sharers.len() as u64);
        for (vertex, others) in &self.vertices.sharers {
            words.push(u64::from(*vertex));
            add(&mut words, others.iter().map(|rank| *rank as u64));
        }
        words
    }

    /// The subdomain that a list describes; none of a list that breaks off.
    pub fn of_words(words: &[u64]) -> Result<Option<Self>, MeshError> {
        let mut rest = Words(words);
        let Some((degree, nodes, blocks)) = rest.cells::<D>() else { return Ok(None) };
        // The mesh was checked where it was read, and may have hanging nodes there.
        let mut mesh = Mesh::from_nonconforming_blocks(degree, nodes, blocks)?;
        let Some((cells, facets)) = rest.regions() else { return Ok(None) };
        // Those that every mesh has are there already.
        let known = |name: &str| [EVERYWHERE, BOUNDARY].contains(&name);
        for (name, cells) in cells.iter().filter(|(name, cells)| !known(name) && !cells.is_empty()) {
            mesh.name_listed_cells(name, cells)?;
        }
        for (name, facets) in facets.iter().filter(|(name, facets)| !known(name) && !facets.is_empty()) {
            mesh.name_listed_facets(name, facets)?;
        }
        let names = [cells.into_keys().collect(), facets.into_keys().collect()];
        Ok(rest.ends().map(|(cut, vertices)| Subdomain { mesh, cut, names, vertices }))
    }
}

/// Degree, nodes and cells by their shapes.
type Cells<const D: usize> = (usize, Vec<[f64; D]>, Vec<(CellShape, Vec<u32>)>);

/// Cells or facets by the names of regions.
type Regions<T> = BTreeMap<String, Vec<T>>;

impl Words<'_> {
    fn cells<const D: usize>(&mut self) -> Option<Cells<D>> {
        let degree = self.number()?;
        let nodes = self.list(|bits| f64::from_bits(*bits))?.as_chunks().0.to_vec();
        let mut blocks = vec![];
        for _ in 0..self.number()? {
            let name = self.text()?;
            let shape = CellShape::ALL.into_iter().find(|shape| shape.name() == name)?;
            blocks.push((shape, self.list(|node| *node as u32)?));
        }
        Some((degree, nodes, blocks))
    }

    fn regions(&mut self) -> Option<(Regions<u32>, Regions<Facet>)> {
        let mut cells = BTreeMap::new();
        for _ in 0..self.number()? {
            cells.insert(self.text()?, self.list(|cell| *cell as u32)?);
        }
        let mut facets = BTreeMap::new();
        for _ in 0..self.number()? {
            facets.insert(self.text()?, self.list(facet_of)?);
        }
        Some((cells, facets))
    }

    fn ends(&mut self) -> Option<(Vec<Facet>, Vertices)> {
        let (cut, numbers) = (self.list(facet_of)?, self.list(|number| *number)?);
        let mut sharers = BTreeMap::new();
        for _ in 0..self.number()? {
            sharers.insert(self.number()? as u32, self.list(|rank| *rank as usize)?);
        }
        Some((cut, Vertices { numbers, sharers }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use forms_fem::mesh::rectangle;

    #[test]
    fn a_subdomain_comes_back_from_its_list() -> Result<(), MeshError> {
        let mut mesh = rectangle([0.0; 2], [1.0; 2], [3, 2], CellShape::Triangle, 2)?;
        mesh.name_cells("steel", |x| x[0] < 0.5)?;
        let (vertices, cut) = (
            Vertices {
                numbers: (7..7 + mesh.node_count() as u64).collect(),
                sharers: BTreeMap::from([(3, vec![0, 2])]),
            },
            vec![mesh.boundary_facets()[1]],
        );
        let names =
            [vec!["all".to_owned(), "steel".to_owned()], vec!["boundary".to_owned(), "left".to_owned()]];
        let subdomain = Subdomain { mesh, cut, names, vertices };
        let words = subdomain.to_words();
        let back = Subdomain::<2>::of_words(&words)?.unwrap();
        assert_eq!(back.to_words(), words);
        assert_eq!((back.mesh.nodes(), back.mesh.cells()), (subdomain.mesh.nodes(), subdomain.mesh.cells()));
        assert_eq!(back.mesh.cell_region("steel")?, subdomain.mesh.cell_region("steel")?);
        assert!(Subdomain::<2>::of_words(&words[..words.len() - 1])?.is_none());
        Ok(())
    }
}
