//! The nodes of a space that several processes have. A node is known by the vertices of its edge, face or cell and by its place among
//! them, so that no process needs numbers of all nodes.

use std::collections::BTreeMap;

use forms_fem::element::{CellShape, Element, Lagrange};
use forms_fem::prelude::*;
use forms_fem::space::Scope;

use super::words::exchanged;
use crate::error::PetscError;
use crate::world::World;

/// Numbers of nodes in the whole mesh, and the other processes that have vertices.
pub(super) struct Vertices {
    /// Of each node of the mesh.
    pub numbers: Vec<u64>,
    /// The other processes that have a vertex, ascending.
    pub sharers: BTreeMap<u32, Vec<usize>>,
}

/// Vertices in the whole mesh, each with a weight: the same on all processes, and of one node.
pub(super) type Key = Vec<u64>;

/// Vertices of a cell with weights.
pub(super) type Support = Vec<(usize, u64)>;

/// Parts of one in which weights are counted.
const STEPS: f64 = 1e6;

/// The nodes of a space that this process shares with others.
pub(super) struct SharedNodes {
    /// The number of nodes here.
    pub count: usize,
    /// Each other process whose part meets this one, with the nodes that both have: in the same order on both.
    pub with: Vec<(usize, Vec<u32>)>,
    /// The owner of each node: the lowest rank of those that have the node in cells of their own.
    pub owners: Vec<u32>,
}

impl SharedNodes {
    /// The nodes of a space on a part with these vertices, as all processes find them together.
    pub fn new<const D: usize>(
        world: &World,
        space: &Space<D>,
        vertices: &Vertices,
    ) -> Result<Self, PetscError> {
        let others: Vec<usize> = (0..world.size()).filter(|rank| *rank != world.rank()).collect();
        let candidates = world.agree(candidates(space, vertices, &others))?;
        let mut neighbours: Vec<usize> = vertices.sharers.values().flatten().copied().collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        if *space.scope() == Scope::Body {
            neighbours = others;
        }
        let own_rank = world.rank() as u32;
        // Of all others the numbers of their owners are not known yet.
        let mut owners = vec![u32::MAX; space.node_count()];
        for cell in space.mesh().body_cells() {
            space.cell_nodes(cell).iter().for_each(|node| owners[*node as usize] = own_rank);
        }
        let keys_for = |rank: &usize| {
            let keys = candidates.iter().filter(|(_, (_, ranks))| ranks.contains(rank));
            let list = keys.flat_map(|(key, (node, _))| {
                let has_it = u64::from(owners[*node as usize] == own_rank);
                std::iter::once((key.len() as u64) << 1 | has_it).chain(key.iter().copied())
            });
            (*rank, list.collect::<Vec<u64>>())
        };
        let lists: Vec<(usize, Vec<u64>)> = neighbours.iter().map(keys_for).collect();
        let name = format!("nodes {:?} {:?}", space.elements(), space.scope());
        let mut with = Vec::with_capacity(neighbours.len());
        for (rank, list) in exchanged(world, &name, lists)? {
            // An edge whose ends are there need not be: both have to know the node. The lists are sorted by keys.
            let mut nodes = vec![];
            for (key, has_it) in keys_in(&list) {
                if let Some((node, _)) = candidates.get(key) {
                    nodes.push(*node);
                    let owner = &mut owners[*node as usize];
                    *owner = if has_it { (*owner).min(rank as u32) } else { *owner };
                }
            }
            with.push((rank, nodes));
        }
        Ok(SharedNodes { count: space.node_count(), with, owners })
    }
}

/// The keys of a list, each after twice its length, and one more where a cell of the sender's own has the node.
fn keys_in(mut list: &[u64]) -> impl Iterator<Item = (&[u64], bool)> {
    std::iter::from_fn(move || {
        let (head, rest) = list.split_first()?;
        let (key, rest) = rest.split_at_checked((head >> 1) as usize)?;
        list = rest;
        Some((key, head & 1 == 1))
    })
}

/// The nodes all of whose vertices are on another process, with the ranks of those. The node of a whole body is on all `others`.
fn candidates<const D: usize>(
    space: &Space<D>,
    vertices: &Vertices,
    others: &[usize],
) -> Result<BTreeMap<Key, (u32, Vec<usize>)>, PetscError> {
    let mut found: BTreeMap<Key, (u32, Vec<usize>)> = BTreeMap::new();
    let mesh = space.mesh();
    match space.scope() {
        Scope::Cell | Scope::Point => {
            // Whole cells are on several processes where there are copies only.
            for cell in (0..mesh.cell_count()).filter(|_| mesh.has_copies()) {
                let corners = mesh.cell_vertices(cell);
                let shared = corners.iter().map(|corner| vertices.sharers.get(corner));
                let Some(ranks) = common(&shared.collect::<Vec<_>>()) else { continue };
                for (node, place) in space.cell_nodes(cell).iter().zip(0..) {
                    let numbers = corners.iter().map(|corner| vertices.numbers[*corner as usize]);
                    found.insert(numbers.chain([place]).collect(), (*node, ranks.clone()));
                }
            }
            return Ok(found);
        }
        Scope::Body => {
            found.insert(vec![], (0, others.to_vec()));
            return Ok(found);
        }
        Scope::Nodes => {}
        scope => return Err(PetscError::Divided { what: format!("spaces {scope}") }),
    }
    let mut supports = Supports::default();
    for cell in 0..mesh.cell_count() {
        let corners = mesh.cell_vertices(cell);
        let shared: Vec<Option<&Vec<usize>>> = corners.iter().map(|one| vertices.sharers.get(one)).collect();
        if shared.iter().all(Option::is_none) {
            continue;
        }
        for (node, support) in space.cell_nodes(cell).iter().zip(supports.of(space, cell)) {
            let of_node: Vec<Option<&Vec<usize>>> =
                support.iter().map(|(corner, _)| shared[*corner]).collect();
            let Some(ranks) = common(&of_node) else { continue };
            let (known, _) = found.entry(vertices.key(corners, support)).or_insert((*node, ranks));
            if known != node {
                let what = "elements with several nodes at one place".to_owned();
                return Err(PetscError::Divided { what });
            }
        }
    }
    Ok(found)
}

/// The ranks that are in all of some lists, if there are any.
fn common(lists: &[Option<&Vec<usize>>]) -> Option<Vec<usize>> {
    let (first, others) = lists.split_first()?;
    let is_everywhere =
        |rank: &&usize| others.iter().all(|ranks| ranks.is_some_and(|ranks| ranks.contains(rank)));
    let ranks: Vec<usize> = (*first)?.iter().filter(is_everywhere).copied().collect();
    (!ranks.is_empty()).then_some(ranks)
}

impl Vertices {
    /// The key of a node between some of the corners of a cell.
    pub fn key(&self, corners: &[u32], support: &Support) -> Key {
        let number = |(corner, weight): &(usize, u64)| [self.numbers[corners[*corner] as usize], *weight];
        let mut key: Vec<[u64; 2]> = support.iter().map(number).collect();
        key.sort_unstable();
        key.into_flattened()
    }
}

/// The supports of the nodes of cells, by the shape of these.
#[derive(Default)]
pub(super) struct Supports(Vec<(CellShape, Vec<Support>)>);

impl Supports {
    pub fn of<const D: usize>(&mut self, space: &Space<D>, cell: usize) -> &[Support] {
        let shape = space.mesh().cell_shape(cell);
        if !self.0.iter().any(|(known, _)| *known == shape) {
            self.0.push((shape, supports_of::<D>(space.cell_element(cell))));
        }
        self.0.iter().find(|(known, _)| *known == shape).map_or(&[][..], |(_, own)| own)
    }
}

/// The vertices of the smallest edge, face or cell that has a node, with the values of their linear functions there: for each node of an
/// element.
fn supports_of<const D: usize>(element: &Element) -> Vec<Support> {
    let linear = Lagrange { shape: element.shape(), degree: 1 };
    let support = |point: &[f64; D]| {
        let mut values = vec![0.0; linear.nodes()];
        linear.evaluate_values(point, &mut values);
        let weights = values.iter().map(|value| (value * STEPS).round() as u64).enumerate();
        weights.filter(|(_, weight)| *weight > 0).collect()
    };
    element.node_points::<D>().iter().map(support).collect()
}
