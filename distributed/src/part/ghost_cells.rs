//! Surfaces that each process has whole, as contact between bodies needs them: every process gets copies of the cells at them.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use forms_fem::element::CellShape;
use forms_fem::mesh::{Facet, GhostCells, Mesh, MeshError};
use forms_fem::prelude::*;
use forms_fem::solve::communicator::Fingerprint;

use super::MeshPart;
use super::hanging_cells::HangingFacets;
use super::shared_nodes::Vertices;
use super::words::{Words, add, facet_of, word_of};
use crate::error::PetscError;
use crate::world::World;

/// One process's own cells at some surfaces, with numbers of nodes in the whole mesh.
pub(super) struct CellsAtSurfaces<const D: usize> {
    cells: Vec<(CellShape, Vec<u64>)>,
    /// Each node with its position.
    nodes: Vec<(u64, [f64; D])>,
    /// Facets of each surface, by places among the cells.
    surfaces: Vec<Vec<Facet>>,
}

impl<const D: usize> MeshPart<'_, D> {
    /// This part with some surfaces whole on each process, for contact pairs between them, periodic conditions and rigid bodies: a [`Pairing`]
    /// or a relation between unknowns may have these surfaces, and facets that are named within them. Each process has copies of all cells at the surfaces ([`MeshPart::ghost_cells`]) with their unknowns.
    /// All else is of the process's own cells: integrals over cells, facets and own facets of pairs, regions, files. Spaces come afterwards.
    /// Where nodes hang at one of these cells, the cells on both sides are copied. [`MeshPart::with_interior_facets`] may come before or
    /// afterwards, and surfaces may be named in several calls.
    ///
    /// ```no_run
    /// # use forms_distributed::World;
    /// # use forms_fem::prelude::*;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let world = World::start()?;
    /// # let mesh = rectangle([0.0; 2], [1.0; 2], [8; 2], CellShape::Triangle, 1)?;
    /// let part = world.divide(&mesh)?.with_surfaces(&["slab top", "block bottom"])?;
    /// let space = Space::vector(&part, 2)?;
    /// let touch = Pairing::between("slab top", "block bottom");
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`PetscError::Unfit`] of a name that does not exist, of surfaces without facets, or of other names on other processes.
    pub fn with_surfaces(self, names: &[&str]) -> Result<Self, PetscError> {
        let world = self.world;
        let texts = names.iter().fold(Fingerprint::default(), |all, name| all.text(name));
        world.check_same("surfaces", texts.finish())?;
        let hanging = HangingFacets::of(&self.mesh);
        let (mut sent, mut own) = world.agree(self.cells_at(names, hanging.as_ref()))?;
        for (name, facets) in names.iter().zip(&own.surfaces) {
            if world.gather(facets.len() as u64)?.iter().all(|count| *count == 0) {
                return Err(unfit(MeshError::EmptyRegion { name: (*name).to_owned(), entity: "facet" }));
            }
        }
        let shapes = self.shapes_of_all()?;
        let mut merged = Merged::new(&self, names);
        // Cells that all processes have, and their vertices.
        let (mut cells, mut vertices) = (BTreeSet::new(), BTreeSet::new());
        loop {
            let mut new: Vec<u32> =
                sent.iter().flat_map(|cell| self.mesh.cell_vertices(*cell as usize)).copied().collect();
            cells.extend(sent);
            let others = cells_of_others(world, &own)?;
            let joined: Result<(), PetscError> = others.iter().try_for_each(|others| {
                cells.extend(merged.add(others).ok_or_else(lost)?);
                new.extend(others.vertices(&merged.places).ok_or_else(lost)?);
                Ok(())
            });
            world.agree(joined)?;
            new.retain(|vertex| vertices.insert(*vertex));
            // A vertex may hang on cells that only those know who have it in cells of their own.
            let mut larger = BTreeSet::new();
            if let Some(facets) = &hanging {
                larger.extend(new.iter().flat_map(|vertex| facets.larger_cells(*vertex)));
            }
            sent = larger.difference(&cells).copied().collect();
            if world.gather(sent.len() as u64)?.iter().all(|count| *count == 0) {
                break;
            }
            own = self.described(&sent);
        }
        let Merged { nodes, blocks, surfaces, numbers, .. } = merged;
        let (behind_facets, facet_parts) = (None, vec![]);
        let ghosts = GhostCells { nodes, blocks, surfaces, behind_facets, facet_parts, shapes };
        let mesh = world.agree(self.mesh.with_ghost_cells(ghosts).map_err(unfit))?;
        let all: Vec<usize> = (0..world.size()).filter(|rank| *rank != world.rank()).collect();
        let mut sharers = self.vertices.sharers;
        if !all.is_empty() {
            sharers.extend(vertices.into_iter().map(|vertex| (vertex, all.clone())));
        }
        Ok(MeshPart::new(world, mesh, Vertices { numbers, sharers }))
    }

    /// The shapes of the cells of all processes.
    pub(super) fn shapes_of_all(&self) -> Result<Vec<CellShape>, PetscError> {
        let here = |shape: &CellShape| u64::from(self.mesh.shapes().contains(shape));
        let mut shapes = vec![];
        for shape in CellShape::ALL {
            if self.world.gather(here(&shape))?.contains(&1) {
                shapes.push(shape);
            }
        }
        Ok(shapes)
    }

    /// Number of this process's copies of other processes' cells, which it has for contact between surfaces, behind interior facets or where nodes hang. They come after its own, and are
    /// counted by [`Mesh::cell_count`].
    pub fn ghost_cells(&self) -> usize {
        self.mesh.ghost_cells().len()
    }

    /// A field with the values of other processes at the copies of their cells: for data that were made cell by cell, or from regions.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] of a field that is not on this part; [`PetscError::Divided`] of spaces that parts do not have.
    pub fn completed(&self, field: &Field<D>) -> Result<Field<D>, PetscError> {
        let mut values = field.values().to_vec();
        self.vectors(&[field.space()])?.copy_from_owners(&mut values)?;
        Ok(self.world.agree(Field::from_values(field.space(), values).map_err(unfit))?)
    }

    /// The cells at surfaces, as other processes get them. Where nodes hang, there are those on which unknowns at these cells depend, or which
    /// depend on them: with a relation across surfaces an owner of unknowns elsewhere needs the latter.
    fn cells_at(
        &self,
        names: &[&str],
        hanging: Option<&HangingFacets<'_, D>>,
    ) -> Result<(Vec<u32>, CellsAtSurfaces<D>), PetscError> {
        let facets = names.iter().map(|name| self.mesh.facet_region(name).map_err(unfit));
        let facets: Vec<&[Facet]> = facets.collect::<Result<_, _>>()?;
        let own: BTreeSet<u32> = facets.concat().iter().map(|facet| facet.cell).collect();
        let mut near = own.clone();
        if let Some(hanging) = hanging {
            hanging.add_near(&own.into_iter().collect::<Vec<_>>(), &mut near);
        }
        let cells: Vec<u32> = near.into_iter().collect();
        let place = |cell: u32| cells.binary_search(&cell).map_or(0, |place| place as u32);
        let placed = |facet: &Facet| Facet { cell: place(facet.cell), local: facet.local };
        let surfaces = facets.iter().map(|facets| facets.iter().map(placed).collect()).collect();
        let described = CellsAtSurfaces { surfaces, ..self.described(&cells) };
        Ok((cells, described))
    }

    /// Some cells, as other processes get them.
    pub(super) fn described(&self, cells: &[u32]) -> CellsAtSurfaces<D> {
        let mut nodes: BTreeMap<u64, [f64; D]> = BTreeMap::new();
        let mut found = vec![];
        for cell in cells {
            let own = self.mesh.cell(*cell as usize);
            let number = |node: &u32| self.vertices.numbers[*node as usize];
            nodes.extend(own.iter().map(|node| (number(node), self.mesh.nodes()[*node as usize])));
            found.push((self.mesh.cell_shape(*cell as usize), own.iter().map(number).collect()));
        }
        CellsAtSurfaces { cells: found, nodes: nodes.into_iter().collect(), surfaces: vec![] }
    }
}

/// Cells that all other processes have at the surfaces, in the order of their ranks.
fn cells_of_others<const D: usize>(
    world: &World,
    own: &CellsAtSurfaces<D>,
) -> Result<Vec<CellsAtSurfaces<D>>, PetscError> {
    let words = own.to_words();
    let lengths = world.gather(words.len() as u64)?;
    let others: Vec<usize> = (0..world.size()).filter(|rank| *rank != world.rank()).collect();
    let lengths: Vec<usize> = others.iter().map(|rank| lengths[*rank] as usize).collect();
    let number = Fingerprint::default().text("cells at surfaces").finish();
    let lists = others.iter().map(|rank| (*rank, words.clone())).collect();
    let found = world.meetings().exchange(number, lists, &lengths)?;
    let read = |list: &Vec<u64>| CellsAtSurfaces::of_words(list).ok_or_else(lost);
    Ok(world.agree(found.iter().map(read).collect::<Result<_, PetscError>>())?)
}

impl<const D: usize> CellsAtSurfaces<D> {
    /// The places of the cells' vertices here; none of one that is not known.
    fn vertices(&self, places: &HashMap<u64, u32>) -> Option<Vec<u32>> {
        let numbers =
            self.cells.iter().flat_map(|(shape, nodes)| &nodes[..shape.vertices().min(nodes.len())]);
        numbers.map(|number| places.get(number).copied()).collect()
    }

    pub fn to_words(&self) -> Vec<u64> {
        let mut words = vec![self.cells.len() as u64];
        for (shape, nodes) in &self.cells {
            add(&mut words, shape.name().bytes().map(u64::from));
            add(&mut words, nodes.iter().copied());
        }
        add(&mut words, self.nodes.iter().map(|(number, _)| *number));
        add(&mut words, self.nodes.iter().flat_map(|(_, position)| position.map(f64::to_bits)));
        words.push(self.surfaces.len() as u64);
        for facets in &self.surfaces {
            add(&mut words, facets.iter().map(word_of));
        }
        words
    }

    pub fn of_words(words: &[u64]) -> Option<Self> {
        let mut rest = Words(words);
        let mut cells = vec![];
        for _ in 0..rest.number()? {
            let name = rest.text()?;
            let shape = CellShape::ALL.into_iter().find(|shape| shape.name() == name)?;
            cells.push((shape, rest.list(|number| *number)?));
        }
        let (numbers, positions) = (rest.list(|number| *number)?, rest.list(|bits| f64::from_bits(*bits))?);
        let nodes = numbers.into_iter().zip(positions.as_chunks().0.iter().copied()).collect();
        let mut surfaces = vec![];
        for _ in 0..rest.number()? {
            surfaces.push(rest.list(facet_of)?);
        }
        Some(CellsAtSurfaces { cells, nodes, surfaces })
    }
}

/// A part with copies of other processes' cells.
pub(super) struct Merged<'n, const D: usize> {
    names: &'n [&'n str],
    /// The cells here that others may have, too, by the numbers of their nodes in the whole mesh.
    known: HashMap<Vec<u64>, u32>,
    /// Number of cells so far.
    cells: u32,
    /// Nodes of the part here, by their numbers in the whole mesh.
    pub places: HashMap<u64, u32>,
    pub numbers: Vec<u64>,
    pub nodes: Vec<[f64; D]>,
    pub blocks: Vec<(CellShape, Vec<u32>)>,
    surfaces: BTreeMap<String, Vec<Facet>>,
}

impl<'n, const D: usize> Merged<'n, D> {
    pub fn new(part: &MeshPart<'_, D>, names: &'n [&'n str]) -> Self {
        let (mesh, numbers): (&Mesh<D>, _) = (&part.mesh, part.vertices.numbers.clone());
        let places = numbers.iter().zip(0..).map(|(number, node)| (*number, node)).collect();
        let own = |name: &&str| mesh.facet_region(name).unwrap_or_default().to_vec();
        let surfaces = names.iter().map(|name| ((*name).to_owned(), own(name))).collect();
        let is_shared = |cell: &usize| {
            let mut vertices = mesh.cell_vertices(*cell).iter();
            vertices.all(|vertex| part.vertices.sharers.contains_key(vertex))
        };
        let key = |cell: usize| mesh.cell(cell).iter().map(|node| numbers[*node as usize]).collect();
        let shared = (0..mesh.cell_count()).filter(is_shared);
        let known = shared.map(|cell| (key(cell), cell as u32)).collect();
        let (nodes, blocks, cells) = (vec![], vec![], mesh.cell_count() as u32);
        Merged { names, known, cells, places, numbers, nodes, blocks, surfaces }
    }

    /// Adds those of another process's cells that are not here, and gives the places of all; none where they name a node that has no position.
    pub fn add(&mut self, others: &CellsAtSurfaces<D>) -> Option<Vec<u32>> {
        for (number, position) in &others.nodes {
            let next = self.numbers.len() as u32;
            if *self.places.entry(*number).or_insert(next) == next {
                self.numbers.push(*number);
                self.nodes.push(*position);
            }
        }
        let mut found = Vec::with_capacity(others.cells.len());
        for (shape, numbers) in &others.cells {
            let place = *self.known.entry(numbers.clone()).or_insert(self.cells);
            found.push(place);
            if place < self.cells {
                continue;
            }
            self.cells += 1;
            let nodes = numbers.iter().map(|number| self.places.get(number).copied());
            let nodes: Vec<u32> = nodes.collect::<Option<_>>()?;
            match self.blocks.last_mut() {
                Some((last, all)) if last == shape => all.extend(nodes),
                _ => self.blocks.push((*shape, nodes)),
            }
        }
        for (name, facets) in self.names.iter().zip(&others.surfaces) {
            let here = |facet: &Facet| Some(Facet { cell: *found.get(facet.cell as usize)?, ..*facet });
            let here: Vec<Facet> = facets.iter().map(here).collect::<Option<_>>()?;
            self.surfaces.entry((*name).to_owned()).or_default().extend(here);
        }
        Some(found)
    }
}

pub(super) fn unfit(why: impl ToString) -> PetscError {
    PetscError::Unfit { message: why.to_string() }
}

pub(super) fn lost() -> PetscError {
    unfit("copies of cells were not received")
}
