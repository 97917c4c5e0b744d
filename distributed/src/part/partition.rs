//! Partition of a mesh into subdomains, one for each process, and the subdomains as lists of numbers, which go from process to process.

use std::collections::{BTreeMap, HashMap};

use forms_fem::element::CellShape;
use forms_fem::mesh::{BOUNDARY, EVERYWHERE, Facet, GhostCells, Mesh, MeshError, PartOfMesh, RegionNames};

use super::MeshPart;
use super::hanging_cells::{Copies, copies};
use super::shared_nodes::Vertices;
use super::words::{Words, add, facet_of, word_of};
use crate::world::World;

/// A mesh with the processes that its vertices go to.
pub(super) struct Partition<'m, const D: usize> {
    mesh: &'m Mesh<D>,
    /// The cells of each process, ascending.
    cells: Vec<Vec<u32>>,
    /// The copies of each, where nodes hang.
    copies: Option<Vec<Copies>>,
    /// Whether nodes hang on exterior facets.
    hangs_outside: bool,
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
    /// Copies of others' cells, where nodes hang in the whole.
    copies: Option<GhostCells<D>>,
    /// Whether nodes hang on exterior facets of the whole.
    hangs_outside: bool,
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
        let copies = copies(mesh, &cells);
        let mut first = vec![NOBODY; mesh.node_count()];
        let mut sharers: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (rank, cells) in cells.iter().enumerate() {
            for cell in cells.iter().chain(copies.iter().flat_map(|copies| &copies[rank].cells)) {
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
        // Those of trees are interior ones. Bodies that touch may lie on each other in whatever way.
        let of_trees = mesh.facet_parts().count();
        let hangs_outside = !mesh.hanging_facets_of_bodies().is_ok_and(|all| all.len() == of_trees);
        Partition { mesh, cells, copies, hangs_outside, sharers }
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
        let mut numbers: Vec<u64> = part.nodes.iter().map(|node| u64::from(*node)).collect();
        let copies = self.copies.as_ref().map(|copies| self.described(&copies[rank], &part, &mut numbers));
        let others = |(local, node): (usize, &u64)| {
            let all = self.sharers.get(&(*node as u32))?;
            Some((local as u32, all.iter().filter(|other| **other != rank).copied().collect()))
        };
        let sharers = numbers.iter().enumerate().filter_map(others).collect();
        let (vertices, hangs_outside) = (Vertices { numbers, sharers }, self.hangs_outside);
        Ok(Subdomain { mesh: part.mesh, cut, names, vertices, copies, hangs_outside })
    }

    /// The copies of a process with the numbers that their nodes and cells have behind its own ones; numbers of nodes in the whole are added to
    /// the own ones'.
    fn described(&self, copies: &Copies, part: &PartOfMesh<D>, numbers: &mut Vec<u64>) -> GhostCells<D> {
        let mesh = self.mesh;
        let mut places: HashMap<u32, u32> = part.nodes.iter().copied().zip(0..).collect();
        let mut nodes: Vec<[f64; D]> = vec![];
        let mut blocks: Vec<(CellShape, Vec<u32>)> = vec![];
        for cell in &copies.cells {
            let place = |node: &u32| {
                *places.entry(*node).or_insert_with(|| {
                    nodes.push(mesh.nodes()[*node as usize]);
                    numbers.push(u64::from(*node));
                    numbers.len() as u32 - 1
                })
            };
            let own = mesh.cell(*cell as usize).iter().map(place);
            let shape = mesh.cell_shape(*cell as usize);
            match blocks.last_mut() {
                Some((last, all)) if *last == shape => all.extend(own),
                _ => blocks.push((shape, own.collect())),
            }
        }
        let cells: HashMap<u32, u32> = part.cells.iter().chain(&copies.cells).copied().zip(0..).collect();
        let here = |facet: Facet| Some(Facet { cell: *cells.get(&facet.cell)?, ..facet });
        let parts =
            mesh.facet_parts().filter_map(|(small, large, at)| Some((here(small)?, here(large)?, *at)));
        let own = part.cells.len() as u32;
        GhostCells {
            nodes,
            blocks,
            surfaces: BTreeMap::new(),
            behind_facets: Some((own..own + copies.behind as u32).collect()),
            facet_parts: parts.collect(),
            shapes: mesh.shapes(),
        }
    }
}

impl<const D: usize> Subdomain<D> {
    /// The subdomain as this process's part.
    ///
    /// # Errors
    /// Copies that do not fit the cells.
    pub fn into_part(self, world: &World) -> Result<MeshPart<'_, D>, MeshError> {
        let [cells, facets] = &self.names;
        let mesh = self.mesh.into_piece(&self.cut, RegionNames { cells, facets });
        let mesh = mesh.with_hanging_outside(self.hangs_outside);
        let mesh = self.copies.map_or(Ok(mesh.clone()), |copies| mesh.with_ghost_cells(copies))?;
        Ok(MeshPart::new(world, mesh, self.vertices))
    }

    /// The subdomain as a list of numbers.
    pub fn to_words(&self) -> Vec<u64> {
        let mesh = &self.mesh;
        let mut words = vec![mesh.degree() as u64];
        add(&mut words, mesh.nodes().iter().flatten().map(|coordinate| coordinate.to_bits()));
        words.push(mesh.blocks().len() as u64);
        for block in mesh.blocks() {
            let nodes = block.cells.clone().flat_map(|cell| mesh.cell(cell));
            add_block(&mut words, block.shape, nodes);
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
        words.extend([u64::from(self.hangs_outside), u64::from(self.copies.is_some())]);
        if let Some(copies) = &self.copies {
            add_copies(&mut words, copies);
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
        let Some((cut, vertices)) = rest.ends() else { return Ok(None) };
        let (Some(hangs_outside), Some(has_copies)) = (rest.number(), rest.number()) else { return Ok(None) };
        let copies = if has_copies == 1 { rest.copies() } else { None };
        if copies.is_some() != (has_copies == 1) {
            return Ok(None);
        }
        Ok(Some(Subdomain { mesh, cut, names, vertices, copies, hangs_outside: hangs_outside == 1 }))
    }
}

fn add_block<'n>(words: &mut Vec<u64>, shape: CellShape, nodes: impl Iterator<Item = &'n u32>) {
    add(words, shape.name().bytes().map(u64::from));
    add(words, nodes.map(|node| u64::from(*node)));
}

fn add_copies<const D: usize>(words: &mut Vec<u64>, copies: &GhostCells<D>) {
    add(words, copies.nodes.iter().flatten().map(|coordinate| coordinate.to_bits()));
    words.push(copies.blocks.len() as u64);
    copies.blocks.iter().for_each(|(shape, nodes)| add_block(words, *shape, nodes.iter()));
    add(words, copies.behind_facets.iter().flatten().map(|cell| u64::from(*cell)));
    let parts = &copies.facet_parts;
    add(words, parts.iter().flat_map(|(small, large, _)| [word_of(small), word_of(large)]));
    add(words, parts.iter().flat_map(|(.., at)| at.as_flattened()).map(|coordinate| coordinate.to_bits()));
    words.push(copies.shapes.len() as u64);
    copies.shapes.iter().for_each(|shape| add(words, shape.name().bytes().map(u64::from)));
}

/// Degree, nodes and cells by their shapes.
type Cells<const D: usize> = (usize, Vec<[f64; D]>, Vec<(CellShape, Vec<u32>)>);

/// Cells or facets by the names of regions.
type Regions<T> = BTreeMap<String, Vec<T>>;

impl Words<'_> {
    fn cells<const D: usize>(&mut self) -> Option<Cells<D>> {
        let degree = self.number()?;
        let nodes = self.list(|bits| f64::from_bits(*bits))?.as_chunks().0.to_vec();
        Some((degree, nodes, self.blocks()?))
    }

    fn shape(&mut self) -> Option<CellShape> {
        let name = self.text()?;
        CellShape::ALL.into_iter().find(|shape| shape.name() == name)
    }

    fn blocks(&mut self) -> Option<Vec<(CellShape, Vec<u32>)>> {
        let mut blocks = vec![];
        for _ in 0..self.number()? {
            blocks.push((self.shape()?, self.list(|node| *node as u32)?));
        }
        Some(blocks)
    }

    fn copies<const D: usize>(&mut self) -> Option<GhostCells<D>> {
        let nodes = self.list(|bits| f64::from_bits(*bits))?.as_chunks().0.to_vec();
        let (blocks, behind) = (self.blocks()?, self.list(|cell| *cell as u32)?);
        let (facets, at) = (self.list(facet_of)?, self.list(|bits| f64::from_bits(*bits))?);
        let corners = at.as_chunks::<D>().0.as_chunks::<3>().0;
        let pairs = facets.as_chunks::<2>().0.iter().zip(corners);
        let facet_parts = pairs.map(|([small, large], at)| (*small, *large, *at)).collect();
        let mut shapes = vec![];
        for _ in 0..self.number()? {
            shapes.push(self.shape()?);
        }
        let (surfaces, behind_facets) = (BTreeMap::new(), Some(behind));
        Some(GhostCells { nodes, blocks, surfaces, behind_facets, facet_parts, shapes })
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
        let copies = Some(GhostCells {
            nodes: vec![[1.5, 0.5], [1.5, 1.0]],
            blocks: vec![(CellShape::Quadrilateral, vec![5, 9, 10, 8])],
            surfaces: BTreeMap::new(),
            behind_facets: Some(vec![12]),
            facet_parts: vec![(Facet { cell: 4, local: 3 }, mesh.boundary_facets()[1], [[0.5, 1.0]; 3])],
            shapes: mesh.shapes(),
        });
        let subdomain = Subdomain { mesh, cut, names, vertices, copies, hangs_outside: true };
        let words = subdomain.to_words();
        let back = Subdomain::<2>::of_words(&words)?.unwrap();
        assert_eq!(back.to_words(), words);
        assert_eq!((back.mesh.nodes(), back.mesh.cells()), (subdomain.mesh.nodes(), subdomain.mesh.cells()));
        assert_eq!(back.mesh.cell_region("steel")?, subdomain.mesh.cell_region("steel")?);
        assert!(Subdomain::<2>::of_words(&words[..words.len() - 1])?.is_none());
        Ok(())
    }
}
