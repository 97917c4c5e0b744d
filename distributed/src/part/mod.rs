//! Parts of a mesh: each process has its own cells, and nothing of the size of the whole.

mod boxes;
mod checkpoint;
mod divided_unknowns;
mod divided_vectors;
mod division;
mod ghost_cells;
mod graph;
mod hanging_cells;
mod interior_facets;
mod on_first;
mod partition;
mod shared_nodes;
mod unknown_rows;
mod words;

use std::any::Any;
use std::cell::RefCell;
use std::ops::{Deref, Range};
use std::rc::Rc;

use forms_fem::element::Elements;
use forms_fem::mesh::MeshError;
use forms_fem::prelude::*;
use forms_fem::solve::divided::check_ghost_values;
use forms_fem::solve::{CommunicationError, Communicator, DividedVectors, Processes, on_part_of_cells};
use forms_fem::space::Scope;

pub use self::checkpoint::{PartCheckpoint, StoredCheckpoint};
pub(crate) use self::divided_unknowns::DividedUnknowns;
use self::divided_vectors::SpacesOnPart;
use self::shared_nodes::{SharedNodes, Vertices};
use crate::error::{DistributedError, PetscError};
use crate::node_rows::NodeRows;
use crate::world::World;

/// This process's part of a mesh: its cells with their nodes, and which nodes other processes have, too. [`World::cuboid`],
/// [`World::rectangle`] and [`World::structured`] build only the part, [`World::read_gmsh`] and [`World::scatter`] send each process the part of a
/// mesh that the first has, and [`World::divide`] divides a mesh that all have.
///
/// It serves as the mesh: spaces, constraints and fields on it are those of this process. Its regions are those of the whole mesh, and facets
/// between parts are on no boundary. A problem `.on(&part)` with a [`PetscSolver::for_part`](crate::PetscSolver::for_part) is solved
/// by all processes together: matrix, vectors and solution are divided, and messages go between processes whose parts meet.
///
/// ```no_run
/// use forms_distributed::{Method, PetscSolver, World};
/// use forms_fem::prelude::*;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let world = World::start()?;
/// let part = world.cuboid([0.0; 3], [1.0; 3], [80; 3], CellShape::Hexahedron, 1)?;
/// let space = Space::scalar(&part, 1)?;
/// let poisson = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v));
/// let mut held = Constraints::new(&space);
/// held.fix("boundary", |_| 0.0)?;
/// let mut solver = PetscSolver::for_part(&part, &[&held], Method::conjugate_gradients())?;
/// let solved = Problem::new(&poisson, &space).on(&part).constrained(&held).solver(&mut solver).solve()?;
/// let total = form!(|u: State<Scalar>| -> Functional { integral(cells("all"), u) });
/// let total = part.functional(solved.assembler(), &total(solved.field()))?;
/// # Ok(())
/// # }
/// ```
///
/// Load steps, motions and histories take `.on(&part)` in the same way, [`VtuFile::on`](forms_fem::output::VtuFile::on) writes all parts, and
/// [`PartCheckpoint`] keeps them. Contact pairs, periodic conditions and rigid bodies need surfaces that each process has whole:
/// [`MeshPart::with_surfaces`]. Integrals over interior facets need [`MeshPart::with_interior_facets`]. A cycle of adaptivity refines on the first
/// process: [`MeshPart::on_first`]. Nodes may hang in a mesh of trees ([`OctreeMesh`](forms_fem::mesh::OctreeMesh)) that is divided: call
/// [`Constraints::join_hanging_nodes`] before conditions that prescribe values. Refused by name: mean values as relations, bounds, projections to
/// continuous spaces.
pub struct MeshPart<'w, const D: usize> {
    world: &'w World,
    mesh: Mesh<D>,
    vertices: Vertices,
    /// The nodes that spaces share with other processes.
    known: RefCell<Vec<(Elements, Scope, Rc<SharedNodes>)>>,
}

impl<const D: usize> Deref for MeshPart<'_, D> {
    type Target = Mesh<D>;

    fn deref(&self) -> &Mesh<D> {
        &self.mesh
    }
}

impl<'w, const D: usize> MeshPart<'w, D> {
    fn new(world: &'w World, mesh: Mesh<D>, vertices: Vertices) -> Self {
        MeshPart { world, mesh, vertices, known: RefCell::default() }
    }

    /// The processes.
    pub fn world(&self) -> &'w World {
        self.world
    }

    /// The number of each node of this part's mesh in the whole mesh.
    pub fn node_numbers(&self) -> &[u64] {
        &self.vertices.numbers
    }

    /// As [`Mesh::name_facets`], on all processes together: a process may have none of the facets. Regions come before spaces.
    ///
    /// # Errors
    /// Those of [`Mesh::name_facets`], on all processes.
    pub fn name_facets(
        &mut self,
        name: &str,
        within: &str,
        condition: impl Fn(&[f64; D]) -> bool,
    ) -> Result<(), DistributedError<MeshError>> {
        let named = self.mesh.name_facets(name, within, condition);
        let count = self.mesh.facet_region(name).map_or(0, <[_]>::len);
        self.check_named(named, count, name, "facet")
    }

    /// As [`Mesh::name_cells`], on all processes together: a process may have none of the cells. Regions come before spaces.
    ///
    /// # Errors
    /// Those of [`Mesh::name_cells`], on all processes.
    pub fn name_cells(
        &mut self,
        name: &str,
        condition: impl Fn(&[f64; D]) -> bool,
    ) -> Result<(), DistributedError<MeshError>> {
        let named = self.mesh.name_cells(name, condition);
        let count = self.mesh.cell_region(name).map_or(0, <[_]>::len);
        self.check_named(named, count, name, "cell")
    }

    fn check_named(
        &self,
        named: Result<(), MeshError>,
        count: usize,
        name: &str,
        entity: &'static str,
    ) -> Result<(), DistributedError<MeshError>> {
        self.world.agree(named)?;
        if self.world.gather(count as u64)?.iter().all(|count| *count == 0) {
            return Err(DistributedError::Here(MeshError::EmptyRegion { name: name.to_owned(), entity }));
        }
        Ok(())
    }

    /// The value of a functional on the whole mesh; the same on all processes.
    ///
    /// # Errors
    /// Data that do not fit, on any process.
    pub fn functional(
        &self,
        assembler: &Assembler<D>,
        functional: &Functional<D>,
    ) -> Result<f64, DistributedError<AssemblyError>> {
        let form = functional.name();
        check_ghost_values(self, functional).map_err(of_all)?;
        let own = self.assembler_here(assembler, form, "functionals on other meshes");
        let own = self.world.agree(own.and_then(|local| local.functional(functional)))?;
        Ok(self.world.sum(&[own])?[0])
    }

    /// The values of a linear form at the functions of a space, over the whole mesh: for indicators of cells, and gradients.
    ///
    /// # Errors
    /// Data that do not fit, on any process.
    pub fn linear_form(
        &self,
        assembler: &Assembler<D>,
        form: &Form<D>,
        space: &Arc<Space<D>>,
    ) -> Result<Vec<f64>, DistributedError<AssemblyError>> {
        let processes = Processes::on(Some(self), &[space], form.name()).map_err(of_all)?;
        processes.check_form(form, self).map_err(of_all)?;
        let own = self.assembler_here(assembler, form.name(), "linear forms on other meshes");
        let own = own.and_then(|own| own.linear_form(form, space));
        processes.added_up(form.name(), own).map_err(of_all)
    }

    /// An assembler of this process's own cells.
    fn assembler_here(
        &self,
        assembler: &Assembler<D>,
        form: &'static str,
        otherwise: &str,
    ) -> Result<Assembler<D>, AssemblyError> {
        if !assembler.mesh().is_same(&self.mesh) {
            let source = CommunicationError::Divided { what: otherwise.to_owned() };
            return Err(AssemblyError::Communication { form, source });
        }
        on_part_of_cells(assembler, &self.mesh, self, form)
    }

    /// The reaction of an unknown, numbered from 0, in a region of the whole mesh, as [`Solved::reaction_of`]; the same on all processes.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] of a region or an unknown that does not exist.
    pub fn reaction<const N: usize>(
        &self,
        solved: &Solved<D, N>,
        unknown: usize,
        region: &str,
    ) -> Result<Vec<f64>, PetscError> {
        let unfit = |message: String| PetscError::Unfit { message };
        let field = solved.fields.get(unknown);
        let field = field.ok_or_else(|| unfit(format!("there is no unknown {unknown}; the problem has {N}")));
        let found = field.and_then(|field| {
            let nodes = field.space().nodes_on(region).map_err(|error| unfit(error.to_string()))?;
            Ok((field.space(), nodes))
        });
        let (space, nodes) = self.world.agree(found)?;
        let components = space.components();
        let mut is_on = vec![0.0; space.unknowns()];
        nodes.iter().for_each(|node| is_on[*node as usize * components] = 1.0);
        let vectors = self.vectors(&[space])?;
        let is_on = vectors.add_up(&is_on).map_err(|error| unfit(error.to_string()))?;
        let offset: usize = solved.fields[..unknown].iter().map(|field| field.values().len()).sum();
        let mut sums = vec![0.0; components];
        for first in (0..is_on.len()).step_by(components) {
            if is_on[first] > 0.0 && vectors.owns(first) {
                let at_node = &solved.residual[offset + first..][..components];
                sums.iter_mut().zip(at_node).for_each(|(sum, value)| *sum += value);
            }
        }
        self.world.sum(&sums)
    }

    /// Prescribed values of all components at the node nearest to a point, as [`Constraints::fix_nearest`]: of all processes' nodes, and of
    /// several at the same distance that of the first process. It pins what is determined only up to a constant, as the solution of Poisson's
    /// equation with given fluxes is.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] as [`Constraints::fix_nearest`], or of constraints that are not on this part.
    pub fn fix_nearest(
        &self,
        constraints: &mut Constraints<D>,
        point: &[f64; D],
        values: &[f64],
    ) -> Result<(), PetscError> {
        let space = constraints.space();
        let unfit = |message: String| PetscError::Unfit { message };
        let fits = match (space.mesh().is_same(&self.mesh), values.len() == space.components()) {
            (false, _) => Err(unfit("the constraints are not on this part of a mesh".to_owned())),
            (_, false) => {
                let (given, components) = (values.len(), space.components());
                Err(unfit(format!("{given} values were given for a space with {components} components")))
            }
            _ => Ok(()),
        };
        self.world.agree(fits)?;
        let node = space.nearest_node(point);
        let distance = |node: usize| {
            let at = &space.positions()[node];
            at.iter().zip(point).map(|(x, y)| (x - y).powi(2)).sum::<f64>()
        };
        let own = node.map_or(f64::INFINITY, distance);
        let all = self.world.gather(own.to_bits())?;
        let all = all.into_iter().map(f64::from_bits).enumerate();
        let nearest = all.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(rank, _)| rank);
        let fixed = match node.filter(|_| nearest == self.world.rank()) {
            Some(node) => values
                .iter()
                .enumerate()
                .try_for_each(|(component, value)| constraints.fix_node(node, component, *value)),
            None => Ok(()),
        };
        Ok(self.world.agree(fixed.map_err(|error| unfit(error.to_string())))?)
    }

    /// The product of two fields' coefficients over the whole mesh; the same on all processes. Nodes that several have count once.
    ///
    /// # Errors
    /// [`PetscError::Unfit`] of fields that are not on this part, or not on one space.
    pub fn dot(&self, a: &Field<D>, b: &Field<D>) -> Result<f64, PetscError> {
        let is_one = a.space().numbers_as(b.space());
        let other = PetscError::Unfit { message: "a product is of two fields on one space".to_owned() };
        self.world.agree(if is_one { Ok(()) } else { Err(other) })?;
        let vectors = self.vectors(&[a.space()])?;
        let own = (0..a.values().len()).filter(|unknown| vectors.owns(*unknown));
        let own = own.map(|unknown| a.values()[unknown] * b.values()[unknown]).sum();
        Ok(self.world.sum(&[own])?[0])
    }

    /// The vectors over the unknowns of spaces on this part.
    fn vectors(&self, spaces: &[&Arc<Space<D>>]) -> Result<Rc<SpacesOnPart>, PetscError> {
        let on_part = spaces.iter().all(|space| space.mesh().is_same(&self.mesh));
        let other = PetscError::Unfit {
            message: "a space is not on this part of a mesh: name regions before making spaces".to_owned(),
        };
        self.world.agree(if on_part { Ok(()) } else { Err(other) })?;
        let mut fields = Vec::with_capacity(spaces.len());
        for space in spaces {
            fields.push((space.components(), self.shared_nodes(space)?));
        }
        let (meetings, replicated) = (Rc::clone(self.world.meetings()), self.mesh.has_copies());
        Ok(Rc::new(SpacesOnPart::new(meetings, fields, replicated)))
    }

    fn shared_nodes(&self, space: &Space<D>) -> Result<Rc<SharedNodes>, PetscError> {
        let is_one = |(elements, scope, _): &&(Elements, Scope, Rc<SharedNodes>)| {
            elements == space.elements() && scope == space.scope()
        };
        if let Some((.., known)) = self.known.borrow().iter().find(is_one) {
            return Ok(Rc::clone(known));
        }
        let found = Rc::new(SharedNodes::new(self.world, space, &self.vertices)?);
        let entry = (space.elements().clone(), space.scope().clone(), Rc::clone(&found));
        self.known.borrow_mut().push(entry);
        Ok(found)
    }

    /// The rows of the free unknowns of spaces on this part.
    pub(crate) fn node_rows(&self, constraints: &[&Constraints<D>]) -> Result<NodeRows, PetscError> {
        let spaces: Vec<&Arc<Space<D>>> = constraints.iter().map(|one| one.space()).collect();
        unknown_rows::rows(self.world, &self.vectors(&spaces)?, constraints)
    }
}

/// An error of a call that all processes made.
fn of_all(error: AssemblyError) -> DistributedError<AssemblyError> {
    match error {
        AssemblyError::Communication { source: CommunicationError::Elsewhere { count }, .. } => {
            DistributedError::Elsewhere { count }
        }
        error => DistributedError::Here(error),
    }
}

impl<const D: usize> Communicator for MeshPart<'_, D> {
    fn rank(&self) -> usize {
        self.world.rank()
    }

    fn size(&self) -> usize {
        self.world.size()
    }

    /// All of them: they are this process's own.
    fn part(&self, count: usize) -> Range<usize> {
        0..count
    }

    /// Refused: no process has whole vectors.
    fn sum(&self, _own: &[f64]) -> Result<Vec<f64>, CommunicationError> {
        Err(CommunicationError::Divided { what: "sums of whole vectors".to_owned() })
    }

    fn gather(&self, own: u64) -> Result<Vec<u64>, CommunicationError> {
        Communicator::gather(self.world, own)
    }

    fn gather_lists(&self, own: &[u64]) -> Result<Vec<Vec<u64>>, CommunicationError> {
        Communicator::gather_lists(self.world, own)
    }

    fn divided(&self, spaces: &[&dyn Any]) -> Result<Option<Rc<dyn DividedVectors>>, CommunicationError> {
        let known: Option<Vec<&Arc<Space<D>>>> = spaces.iter().map(|space| space.downcast_ref()).collect();
        let what = "spaces of another dimension".to_owned();
        let spaces = known.ok_or(CommunicationError::Divided { what })?;
        let vectors =
            self.vectors(&spaces).map_err(|error| CommunicationError::Exchange(error.to_string()))?;
        Ok(Some(vectors))
    }
}
