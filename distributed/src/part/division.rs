//! Making of parts: of a grid, whose other parts are never built, of a mesh that all processes have, and of one that the first reads.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::Path;

use forms_fem::element::CellShape;
use forms_fem::mesh::{BOUNDARY, Facet, Mesh, MeshError, RegionNames, straight_map, structured};

use super::MeshPart;
use super::boxes::boxes;
use super::graph::owners;
use super::partition::{Partition, Subdomain};
use super::shared_nodes::Vertices;
use crate::error::PetscError;
use crate::world::World;

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

    /// This process's part of a mesh that all processes have, and can drop afterwards. PT-Scotch or ParMETIS divides the graph of the cells, if
    /// PETSc has one of them; else a part is a piece of the curve along which the mesh's cells are walked. Where nodes hang in a mesh of trees, a
    /// part has copies of the cells on both sides ([`MeshPart::ghost_cells`]), and interior facets.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] of a mesh with rigid surfaces; [`PetscError::TooManyProcesses`].
    pub fn divide<const D: usize>(&self, mesh: &Mesh<D>) -> Result<MeshPart<'_, D>, PetscError> {
        self.divide_weighted(mesh, |_| 1)
    }

    /// As [`World::divide`], with a weight of each cell: the work that it brings, as many times that of the lightest. Parts have about the same
    /// weight. Cells at contact surfaces have more work than others.
    ///
    /// ```no_run
    /// # let world = forms_distributed::World::start()?;
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [1.0; 2], [8; 2], CellShape::Triangle, 1)?;
    /// let mut weights = vec![1; mesh.cell_count()];
    /// mesh.facet_region("bottom")?.iter().for_each(|facet| weights[facet.cell as usize] = 4);
    /// let part = world.divide_weighted(&mesh, |cell| weights[cell])?.with_surfaces(&["bottom"])?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`World::divide`].
    pub fn divide_weighted<const D: usize>(
        &self,
        mesh: &Mesh<D>,
        weight: impl Fn(usize) -> u32,
    ) -> Result<MeshPart<'_, D>, PetscError> {
        let owners = if self.rank() == 0 { self.owners(mesh, weight) } else { Ok(None) };
        let owners = self.agree(owners)?;
        let known = self.gather(u64::from(owners.is_some()))?[0] == 1;
        let of_first: Option<Vec<usize>> = if known {
            // Zeros of the others change nothing.
            let own = owners.unwrap_or_else(|| vec![0; mesh.cell_count()]);
            let all = self.sum(&own.into_iter().map(|rank| rank as f64).collect::<Vec<_>>())?;
            Some(all.into_iter().map(|rank| rank as usize).collect())
        } else {
            None
        };
        let partition = Partition::new(self, mesh, of_first.as_deref());
        let own = self.agree(partition.subdomain(self.rank()).map_err(unfit))?;
        Ok(self.agree(own.into_part(self).map_err(unfit))?)
    }

    /// The process of each cell, where a program divides the graph of the cells.
    fn owners<const D: usize>(
        &self,
        mesh: &Mesh<D>,
        weight: impl Fn(usize) -> u32,
    ) -> Result<Option<Vec<usize>>, PetscError> {
        let (processes, cells) = (self.size(), mesh.cell_count());
        if cells < processes {
            return Err(PetscError::TooManyProcesses { processes, cells });
        }
        let weights: Vec<u32> = (0..cells).map(weight).collect();
        owners(mesh, processes, &weights)
    }

    /// This process's part of a mesh in a Gmsh file ([`Mesh::read_gmsh`]), as [`World::scatter`].
    ///
    /// # Errors
    /// As there.
    pub fn read_gmsh<const D: usize>(&self, path: impl AsRef<Path>) -> Result<MeshPart<'_, D>, PetscError> {
        self.scatter(|| Mesh::read_gmsh(path))
    }

    /// This process's part of a mesh in a VTK file ([`Mesh::read_vtk`]), as [`World::scatter`].
    ///
    /// # Errors
    /// As there.
    pub fn read_vtk<const D: usize>(&self, path: impl AsRef<Path>) -> Result<MeshPart<'_, D>, PetscError> {
        self.scatter(|| Mesh::read_vtk(path))
    }

    /// This process's part of a mesh that the first process makes or reads, and sends to the others piece by piece: these never have the whole
    /// mesh. It is divided as by [`World::divide`]. Regions are named in `make`, or on the part.
    ///
    /// ```no_run
    /// # let world = forms_distributed::World::start()?;
    /// use forms_fem::prelude::*;
    ///
    /// let part = world.scatter(|| {
    ///     let mut mesh = Mesh::<3>::read_gmsh("wheel.msh")?;
    ///     mesh.name_facets("hub", "boundary", |x| x[0].hypot(x[1]) < 0.1)?;
    ///     Ok::<_, Box<dyn std::error::Error>>(mesh)
    /// })?;
    /// # Ok::<(), forms_distributed::PetscError>(())
    /// ```
    ///
    /// # Errors
    /// [`PetscError::Unfit`] with the error of `make`, or that of a mesh that cannot be divided, on all processes.
    pub fn scatter<const D: usize, E: Display>(
        &self,
        make: impl FnOnce() -> Result<Mesh<D>, E>,
    ) -> Result<MeshPart<'_, D>, PetscError> {
        self.scatter_weighted(make, |_, _| 1)
    }

    /// As [`World::scatter`], with a weight of each cell of the mesh, as [`World::divide_weighted`] has it.
    ///
    /// # Errors
    /// As [`World::scatter`].
    pub fn scatter_weighted<const D: usize, E: Display>(
        &self,
        make: impl FnOnce() -> Result<Mesh<D>, E>,
        weight: impl Fn(&Mesh<D>, usize) -> u32,
    ) -> Result<MeshPart<'_, D>, PetscError> {
        let is_first = self.rank() == 0;
        let mesh = if is_first { make().map(Some).map_err(|error| error.to_string()) } else { Ok(None) };
        let mesh = self.succeed_on_first(mesh)?.flatten();
        let partition = mesh.as_ref().map(|mesh| {
            let owners = self.owners(mesh, |cell| weight(mesh, cell))?;
            Ok::<_, PetscError>(Partition::new(self, mesh, owners.as_deref()))
        });
        let partition = partition.transpose();
        let partition = self.succeed_on_first(partition.map_err(|error| error.to_string()))?.flatten();
        let mut own = Ok(None);
        // The first process has its own piece, and one other at a time.
        for rank in (0..self.size()).rev() {
            let found = partition.as_ref().map(|partition| partition.subdomain(rank)).transpose();
            let found = self.succeed_on_first(found.map_err(|error| error.to_string()))?.flatten();
            let words = found.as_ref().filter(|_| rank > 0).map_or_else(Vec::new, Subdomain::to_words);
            match self.list_of_first(rank, words)? {
                Some(_) if rank == 0 => own = Ok(found),
                Some(words) => own = Subdomain::of_words(&words),
                None => {}
            }
        }
        let lost = || PetscError::Unfit { message: "a piece of a mesh was not received".to_owned() };
        let own = own.map_err(unfit).and_then(|own| own.ok_or_else(lost));
        Ok(self.agree(self.agree(own)?.into_part(self).map_err(unfit))?)
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
