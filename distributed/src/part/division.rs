//! Making of parts: of a grid, whose other parts are never built, and of a mesh that all processes have.

use std::collections::BTreeMap;

use forms_fem::element::CellShape;
use forms_fem::mesh::{BOUNDARY, Facet, Mesh, MeshError, RegionNames, straight_map, structured};

use super::MeshPart;
use super::boxes::boxes;
use super::shared_nodes::Vertices;
use crate::error::PetscError;
use crate::world::World;

/// The name of this process's cells, while a mesh is divided.
const OWN: &str = "cells of this process";

impl World {
    /// This process's part of a box \[length\], as [`forms_fem::mesh::cuboid`] makes it: a box of its blocks.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] as [`forms_fem::mesh::cuboid`]; [`PetscError::TooManyProcesses`].
    pub fn cuboid(
        &self,
        lower: [f64; 3],
        upper: [f64; 3],
        divisions: [usize; 3],
        shape: CellShape,
        degree: usize,
    ) -> Result<MeshPart<'_, 3>, PetscError> {
        self.straight(lower, upper, divisions, (shape, degree))
    }

    /// This process's part of a rectangle \[length\], as [`forms_fem::mesh::rectangle`] makes it: a rectangle of its blocks.
    ///
    /// # Errors
    /// As [`World::cuboid`].
    pub fn rectangle(
        &self,
        lower: [f64; 2],
        upper: [f64; 2],
        divisions: [usize; 2],
        shape: CellShape,
        degree: usize,
    ) -> Result<MeshPart<'_, 2>, PetscError> {
        self.straight(lower, upper, divisions, (shape, degree))
    }

    fn straight<const D: usize>(
        &self,
        lower: [f64; D],
        upper: [f64; D],
        divisions: [usize; D],
        (shape, degree): (CellShape, usize),
    ) -> Result<MeshPart<'_, D>, PetscError> {
        let map = self.agree(straight_map(lower, upper).map_err(unfit))?;
        self.structured(divisions, shape, degree, map)
    }

    /// This process's part of a grid that is mapped, as [`forms_fem::mesh::structured`] makes it: a box of its blocks.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] as [`forms_fem::mesh::structured`]; [`PetscError::TooManyProcesses`].
    pub fn structured<const D: usize>(
        &self,
        divisions: [usize; D],
        shape: CellShape,
        degree: usize,
        map: impl Fn([f64; D]) -> [f64; D],
    ) -> Result<MeshPart<'_, D>, PetscError> {
        let too_many =
            || PetscError::TooManyProcesses { processes: self.size(), cells: divisions.iter().product() };
        let all = boxes(divisions, self.size()).ok_or_else(too_many)?;
        let own = &all[self.rank()];
        let counts = divisions.map(|blocks| (blocks * degree + 1) as u64);
        let sizes = own.clone().map(|blocks| blocks.len());
        // Places among the nodes of the whole grid: the map is called with the same numbers as for it.
        let place =
            |k: usize, t: f64| own[k].start * degree + (t * (sizes[k] * degree) as f64).round() as usize;
        let logical = |k: usize, place: usize| place as f64 / (divisions[k] * degree) as f64;
        let mesh =
            structured(sizes, shape, degree, |t| map(std::array::from_fn(|k| logical(k, place(k, t[k])))));
        let mesh = self.agree(mesh.map_err(unfit))?;
        let names = self.agree(side_names::<D>(&mesh).map_err(unfit))?;
        let mut cut: Vec<Facet> = vec![];
        for (k, sides) in names.chunks(2).enumerate() {
            let at_cut = [own[k].start > 0, own[k].end < divisions[k]];
            for (side, _) in sides.iter().zip(at_cut).filter(|(_, at_cut)| *at_cut) {
                cut.extend(mesh.facet_region(side).unwrap_or_default());
            }
        }
        cut.sort_unstable();
        let mesh = mesh.into_piece(&cut, RegionNames { cells: &[], facets: &names });
        let local = sizes.map(|blocks| blocks * degree + 1);
        let mut numbers = Vec::with_capacity(mesh.node_count());
        let mut sharers = BTreeMap::new();
        for node in 0..mesh.node_count() {
            let mut rest = node;
            let at: [usize; D] = std::array::from_fn(|k| {
                let digit = rest % local[k];
                rest /= local[k];
                own[k].start * degree + digit
            });
            numbers.push((0..D).rev().fold(0, |number, k| number * counts[k] + at[k] as u64));
            let is_at_edge = (0..D).any(|k| at[k] == own[k].start * degree || at[k] == own[k].end * degree);
            if is_at_edge && at.iter().all(|place| place.is_multiple_of(degree)) {
                let has = |other: &super::boxes::Box<D>| {
                    (0..D).all(|k| (other[k].start * degree..=other[k].end * degree).contains(&at[k]))
                };
                let others =
                    all.iter().enumerate().filter(|(rank, other)| *rank != self.rank() && has(other));
                let others: Vec<usize> = others.map(|(rank, _)| rank).collect();
                if !others.is_empty() {
                    sharers.insert(node as u32, others);
                }
            }
        }
        Ok(MeshPart::new(self, mesh, Vertices { numbers, sharers }))
    }

    /// This process's part of a mesh that all processes have, and can drop afterwards: a piece of the curve along which the mesh's cells are walked.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] of a mesh with rigid surfaces or hanging nodes; [`PetscError::TooManyProcesses`].
    pub fn divide<const D: usize>(&self, mesh: &Mesh<D>) -> Result<MeshPart<'_, D>, PetscError> {
        let (processes, cells) = (self.size(), mesh.cell_count());
        if cells < processes {
            return Err(PetscError::TooManyProcesses { processes, cells });
        }
        let own = self.own_cells(mesh);
        let mut named = mesh.clone();
        let part = named.name_listed_cells(OWN, own).and_then(|()| named.part(OWN));
        let part = self.agree(part.map_err(unfit))?;
        let is_cut = |facet: &&Facet| {
            let parent = Facet { cell: part.cells[facet.cell as usize], local: facet.local };
            mesh.boundary_facets().binary_search(&parent).is_err()
        };
        let cut: Vec<Facet> = part.mesh.boundary_facets().iter().filter(is_cut).copied().collect();
        let list = |names: &mut dyn Iterator<Item = &str>| names.map(str::to_owned).collect::<Vec<_>>();
        let (cell_names, facet_names) =
            (list(&mut mesh.cell_region_names()), list(&mut mesh.facet_region_names()));
        let names = RegionNames { cells: &cell_names, facets: &facet_names };
        let mut sharers: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for rank in (0..processes).filter(|rank| *rank != self.rank()) {
            for cell in &mesh.cell_order().cells()[self.part_of(rank, cells)] {
                for node in mesh.cell_vertices(*cell as usize) {
                    let Ok(local) = part.nodes.binary_search(node) else { continue };
                    let others = sharers.entry(local as u32).or_default();
                    if others.last() != Some(&rank) {
                        others.push(rank);
                    }
                }
            }
        }
        let numbers = part.nodes.iter().map(|node| u64::from(*node)).collect();
        let mesh = part.mesh.into_piece(&cut, names);
        Ok(MeshPart::new(self, mesh, Vertices { numbers, sharers }))
    }
}

/// Names of the sides of a grid, two for each direction.
fn side_names<const D: usize>(mesh: &Mesh<D>) -> Result<Vec<String>, MeshError> {
    let names: &[&str] = match D {
        2 => &["left", "right", "bottom", "top"],
        _ => &["left", "right", "front", "back", "bottom", "top"],
    };
    names.iter().try_for_each(|name| mesh.facet_region(name).map(|_| ()))?;
    debug_assert!(mesh.facet_region(BOUNDARY).is_ok());
    Ok(names.iter().map(|name| (*name).to_owned()).collect())
}

fn unfit(error: MeshError) -> PetscError {
    PetscError::Unfit { message: error.to_string() }
}
