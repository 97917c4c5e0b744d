//! Derivatives ∂c/∂u of the coordinates of moving segments' feet by the coefficients of the space that displaces them, and their products with those of
//! element vectors by the feet.
//!
//! The functions of the own facets are evaluated at many feet side by side in lanes. Of the functions of a facet that has an opposite node most vanish at
//! the node, so that they move no foot, or one of a unit's.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use super::batch::basis_in_lanes::{LaneBasis, LaneElement};
use crate::element::{CellShape, Element};
use crate::lanes::{InstructionSet, LaneWork, SimdLane, WIDEST};
use crate::mesh::Facet;
use crate::pairs::{Foot, PairGroup};
use crate::space::Space;

/// The shape of a cell, the local number of its facet, whether it is carried.
type Seen = (CellShape, u8, bool);

/// The nodes of facets among those of their cells.
#[derive(Default)]
pub(super) struct SeenNodes {
    /// Of a shape and local number, and of cells that are carried.
    places: Vec<(Seen, Vec<usize>)>,
}

impl SeenNodes {
    /// The nodes of a facet's cell, and the places of those that the facet sees.
    pub fn of<'a, const D: usize>(&mut self, space: &'a Space<D>, facet: Facet) -> (&'a [u32], &[usize]) {
        let (places, seen) = (&mut self.places, key(space, facet));
        let nodes = space.nodes_at(facet.cell, Some(facet.local));
        let known = places.iter().position(|(known, _)| *known == seen).unwrap_or_else(|| {
            let of_facet = || space.traces_of(seen.0).facet_nodes(usize::from(facet.local));
            places.push((seen, if seen.2 { (0..nodes.len()).collect() } else { of_facet() }));
            places.len() - 1
        });
        (nodes, &places[known].1)
    }
}

fn key<const D: usize>(space: &Space<D>, facet: Facet) -> Seen {
    let mesh = &space.mesh;
    (mesh.cell_shape(facet.cell as usize), facet.local, mesh.carries(facet.cell))
}

/// A facet's node with the places of the functions in the cell that do not vanish there, and their values.
type AtNode<const D: usize> = (Seen, [f64; D], Vec<(usize, f64)>);

/// The functions of a space that do not vanish at opposite nodes.
#[derive(Default)]
struct FunctionsAtNodes<const D: usize> {
    known: Vec<AtNode<D>>,
    /// The one that was found last.
    last: usize,
    seen: SeenNodes,
    /// The same at a node of a rigid surface: a cell has many of them.
    carried: Vec<(usize, f64)>,
}

impl<const D: usize> FunctionsAtNodes<D> {
    fn of(&mut self, foot: &Foot<D>, space: &Space<D>) -> &[(usize, f64)] {
        let key = key(space, foot.facet);
        if key.2 {
            self.carried.clear();
            let found = self.find(foot, space);
            self.carried.extend(found);
            return &self.carried;
        }
        // The nodes of a facet follow each other.
        let fits = |(seen, node, _): &AtNode<D>| *seen == key && *node == foot.node;
        let next = if self.last + 1 < self.known.len() { self.last + 1 } else { 0 };
        self.last = match self.known.get(next) {
            Some(known) if fits(known) => next,
            _ => self.known.iter().position(fits).unwrap_or(self.known.len()),
        };
        if self.last == self.known.len() {
            let found = self.find(foot, space);
            self.known.push((key, foot.node, found));
        }
        &self.known[self.last].2
    }

    fn find(&mut self, foot: &Foot<D>, space: &Space<D>) -> Vec<(usize, f64)> {
        let element = space.traces_of(space.mesh.cell_shape(foot.facet.cell as usize));
        let mut values = vec![0.0; element.nodes()];
        element.evaluate_values(&foot.node, &mut values);
        let (_, places) = self.seen.of(space, foot.facet);
        places.iter().map(|place| (*place, values[*place])).filter(|(_, value)| *value != 0.0).collect()
    }
}

/// The functions of a space at the feet of a group's units, on the own facets.
pub(super) struct FunctionsAtFeet {
    /// Their places in an own cell.
    places: Vec<usize>,
    /// Of each foot and function D numbers: its value, and the derivatives along the directions by which the own normal turns.
    numbers: Vec<f64>,
}

impl FunctionsAtFeet {
    pub fn new<const D: usize>(group: &PairGroup<D>, space: &Space<D>, set: InstructionSet) -> Self {
        let (shape, local) = (group.sides[0].0, usize::from(group.sides[0].1));
        let element = space.traces_of(shape);
        let places = element.facet_nodes(local);
        let functions = &LaneElement::new(&Element::Lagrange(element), Some(local));
        let (count, feet) = (places.len(), &group.motion.feet[..]);
        let numbers = set.checked().run_without_kernel(AtFeet { functions, count, feet });
        FunctionsAtFeet { places, numbers }
    }
}

/// The evaluation of functions at feet.
struct AtFeet<'a, const D: usize> {
    functions: &'a LaneElement,
    count: usize,
    feet: &'a [Option<Foot<D>>],
}

impl<const D: usize> LaneWork for AtFeet<'_, D> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Vec<f64> {
        let AtFeet { functions, count, feet } = self;
        let mut numbers = vec![0.0; feet.len() * count * D];
        let mut basis = LaneBasis::<L, D>::default();
        for first in (0..feet.len()).step_by(L::WIDTH) {
            let filled = L::WIDTH.min(feet.len() - first);
            let (mut own, mut turning) = ([[0.0; WIDEST]; D], [[[0.0; WIDEST]; D]; 2]);
            for lane in 0..filled {
                // At an end of an own facet nothing is read.
                let Some(foot) = &feet[first + lane] else { continue };
                for k in 0..D {
                    own[k][lane] = foot.own[k];
                    turning[0][k][lane] = foot.turning[0][k];
                    turning[1][k][lane] = foot.turning[1][k];
                }
            }
            let mut point = [L::splat(0.0); D];
            for k in 0..D {
                point[k] = L::load(&own[k]);
            }
            functions.evaluate::<L, 1, D>(&point, &mut basis);
            for node in 0..count {
                let mut of_function = [basis.value[node]; D];
                for axis in 0..D - 1 {
                    let mut slope = L::splat(0.0);
                    for k in 0..D {
                        slope = basis.gradient[node][k].multiply_add(L::load(&turning[axis][k]), slope);
                    }
                    of_function[1 + axis] = slope;
                }
                let mut lanes = [0.0; WIDEST];
                for k in 0..D {
                    of_function[k].store(&mut lanes);
                    for lane in 0..filled {
                        numbers[((first + lane) * count + node) * D + k] = lanes[lane];
                    }
                }
            }
        }
        numbers
    }
}

/// A node that moves feet of a unit.
struct Column {
    node: u32,
    /// Of a node of one of the unit's two cells, the side and its place there.
    of_cell: Option<[usize; 2]>,
    /// The feet that it moves are among these.
    feet: Range<usize>,
}

/// The derivatives of the coordinates of a unit's feet by the coefficients of a space.
#[derive(Default)]
pub(super) struct Rates<const D: usize> {
    columns: Vec<Column>,
    /// Of each column and coordinate.
    rates: Vec<[f64; D]>,
    coordinates: usize,
    opposite: FunctionsAtNodes<D>,
    /// Of each column and component the derivatives of an element vector, in whole lanes.
    products: Vec<f64>,
}

impl<const D: usize> Rates<D> {
    pub fn take(&mut self, group: &PairGroup<D>, unit: usize, own: &FunctionsAtFeet, space: &Space<D>) {
        let (feet, [facet, _]) = (group.motion.feet_of(unit, group.facets.len()), group.facets[unit]);
        self.columns.clear();
        self.rates.clear();
        self.coordinates = feet.len() * (D - 1);
        if feet.iter().all(Option::is_none) {
            return;
        }
        let (nodes, count) = (space.nodes_at(facet.cell, Some(facet.local)), own.places.len());
        for (i, place) in own.places.iter().enumerate() {
            let rates = self.column(nodes[*place], Some([0, *place]), 0..feet.len());
            for (k, foot) in feet.iter().enumerate() {
                let Some(foot) = foot else { continue };
                let numbers = &own.numbers[((unit * feet.len() + k) * count + i) * D..][..D];
                for axis in 0..D - 1 {
                    let rate = &mut rates[k * (D - 1) + axis];
                    for c in 0..D {
                        rate[c] += numbers[1 + axis] * foot.normal[c] - numbers[0] * foot.apart[axis][c];
                    }
                }
            }
        }
        let mut opposite = std::mem::take(&mut self.opposite);
        for (k, foot) in feet.iter().enumerate() {
            let Some(foot) = foot else { continue };
            let nodes = space.nodes_at(foot.facet.cell, Some(foot.facet.local));
            let is_seen = foot.facet == group.facets[unit][1];
            for (place, value) in opposite.of(foot, space) {
                let of_cell = is_seen.then_some([1, *place]);
                let rates = &mut self.column(nodes[*place], of_cell, k..k + 1)[k * (D - 1)..];
                for axis in 0..D - 1 {
                    for c in 0..D {
                        rates[axis][c] += value * foot.apart[axis][c];
                    }
                }
            }
        }
        self.opposite = opposite;
    }

    /// The rates of a node that moves some feet, new ones if it has none.
    fn column(&mut self, node: u32, of_cell: Option<[usize; 2]>, feet: Range<usize>) -> &mut [[f64; D]] {
        let Rates { columns, rates, coordinates, .. } = self;
        let known = columns.iter().position(|column| column.node == node);
        let place = known.unwrap_or_else(|| {
            columns.push(Column { node, of_cell, feet: feet.clone() });
            rates.resize(columns.len() * *coordinates, [0.0; D]);
            columns.len() - 1
        });
        let column = &mut columns[place];
        column.feet = column.feet.start.min(feet.start)..column.feet.end.max(feet.end);
        &mut rates[place * *coordinates..][..*coordinates]
    }

    /// Each node with the rates of all coordinates by its displacement.
    pub fn by_node(&self) -> impl Iterator<Item = (u32, &[[f64; D]])> {
        let nodes = self.columns.iter().map(|column| column.node);
        nodes.zip(self.rates.chunks_exact(self.coordinates.max(1)))
    }

    /// Σ over the feet's coordinates c of ∂R/∂c ∂c/∂u, node after node, from ∂R/∂c of an element vector with a number of entries. They begin at a
    /// place of a list, where as many numbers follow the last one as lanes may have. Meanwhile places of some values come from memory.
    fn multiply(
        &mut self,
        (vectors, place, entries): (&[f64], usize, usize),
        wanted: (&[f64], &[[usize; 2]]),
        set: InstructionSet,
    ) {
        let stride = entries.next_multiple_of(WIDEST);
        self.products.resize(self.columns.len() * D * stride, 0.0);
        let Rates { columns, rates, coordinates, products, .. } = self;
        let by_feet = &vectors[place..];
        let (columns, rates, coordinates) = (&columns[..], &rates[..], *coordinates);
        set.checked().run_without_kernel(Products {
            by_feet,
            entries,
            columns,
            rates,
            coordinates,
            products,
            stride,
            wanted,
        });
    }

    /// The derivatives by the displacement of each node.
    fn products(&self, entries: usize) -> impl Iterator<Item = MotionColumn<'_, D>> {
        let stride = entries.next_multiple_of(WIDEST);
        let of_columns = self.products.chunks_exact((D * stride).max(1));
        let of_node = move |(node, entries)| MotionColumn { node, entries, stride };
        self.columns.iter().map(|column| column.node).zip(of_columns).map(of_node)
    }
}

/// The columns of a unit: the nodes that move its feet, with the derivatives of its element vectors by their displacements.
pub(super) struct UnitColumns<'a, const D: usize> {
    pub rates: Rates<D>,
    /// The derivatives of element vectors by feet, where those of the unit begin, and their number of entries.
    pub vectors: &'a [f64],
    pub first: usize,
    pub entries: usize,
    pub instructions: InstructionSet,
}

impl<const D: usize> UnitColumns<'_, D> {
    /// Each node, and if it is one of the unit's two cells, the side and its place there.
    pub fn nodes(&self) -> impl Iterator<Item = (u32, Option<[usize; 2]>)> {
        self.rates.columns.iter().map(|column| (column.node, column.of_cell))
    }

    /// The products, made while blocks of some values, by their places and lengths, come from memory.
    pub fn multiply(&mut self, values: &[f64], blocks: &[[usize; 2]]) {
        let UnitColumns { rates, vectors, first, entries, instructions } = self;
        rates.multiply((vectors, *first, *entries), (values, blocks), *instructions);
    }

    /// The products, in the order of the nodes.
    pub fn products(&self) -> impl Iterator<Item = MotionColumn<'_, D>> {
        self.rates.products(self.entries)
    }
}

/// The derivatives of an element vector by a node's displacement.
pub(super) struct MotionColumn<'a, const D: usize> {
    pub node: u32,
    /// Of each component all entries.
    entries: &'a [f64],
    stride: usize,
}

impl<const D: usize> MotionColumn<'_, D> {
    /// The derivative of one entry.
    pub fn of(&self, entry: usize) -> [f64; D] {
        std::array::from_fn(|k| self.entries[k * self.stride + entry])
    }
}

/// Products of vectors by the feet and of rates, several entries side by side.
struct Products<'a, const D: usize> {
    by_feet: &'a [f64],
    entries: usize,
    columns: &'a [Column],
    rates: &'a [[f64; D]],
    coordinates: usize,
    products: &'a mut [f64],
    stride: usize,
    /// Values that will be added to, and the places and lengths of their blocks.
    wanted: (&'a [f64], &'a [[usize; 2]]),
}

impl<const D: usize> LaneWork for Products<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: SimdLane>(self) {
        let Products { by_feet, entries, columns, rates, coordinates, products, stride, wanted } = self;
        let (values, blocks) = wanted;
        for block in 0..blocks.len() {
            let [first, length] = blocks[block];
            L::prefetch(values, first);
            L::prefetch(values, first + length - 1);
        }
        for number in 0..columns.len() {
            let (start, end) = (columns[number].feet.start, columns[number].feet.end);
            let rates = &rates[number * coordinates..][..coordinates];
            let product = &mut products[number * D * stride..][..D * stride];
            let mut first = 0;
            while first < entries {
                let mut sums = [L::splat(0.0); D];
                for coordinate in start * (D - 1)..end * (D - 1) {
                    let some = L::load(&by_feet[coordinate * entries + first..]);
                    for k in 0..D {
                        sums[k] = some.multiply_add(L::splat(rates[coordinate][k]), sums[k]);
                    }
                }
                for k in 0..D {
                    sums[k].store(&mut product[k * stride + first..]);
                }
                first += L::WIDTH;
            }
        }
    }
}
