//! The part of an energy's tangent by the motion of moving segments' points, in the plane, besides that of its residual at held points.
//!
//! With the energy Π(u, c) of units whose points move with the coordinates c of their feet, the residual is ∂Π/∂u + Σ ∂Π/∂c ∂c/∂u. Its derivative has
//! ∂²Π/∂u² (the kernel at held points), ∂²Π/∂u∂c ⊗ ∂c/∂u (as of other residuals, `segment_tangent.rs`) and here
//!
//! ```text
//! Σ ∂c/∂u ⊗ ∂²Π/∂c∂u + Σ ∂²Π/∂c∂d ∂c/∂u ⊗ ∂d/∂u + Σ ∂Π/∂c ∂²c/∂u²
//! ```

use std::ops::Range;
use std::sync::Arc;

use forms_core::contract::Role;

use super::batch::Cells;
use super::element_loops::moving_points::PointMotion;
use super::element_loops::vectors::ElementVectors;
use super::foot_rates::SeenNodes;
use super::groups::{Group, groups};
use super::scatter::group_nodes::{Reading, seen_places};
use super::segment_columns::{Motion, MovingTerm};
use super::segment_tangent::displacing_unknowns;
use super::{Assembler, AssemblyError, BlockPattern, Parts};
use crate::contract::Function;
use crate::element::lagrange::MAXIMUM_NODES;
use crate::field::FieldView;
use crate::linear_algebra::BlockMatrix;
use crate::mesh::Facet;
use crate::pairs::{Foot, FootCurve, NodeOfFoot, PairError};
use crate::quadrature::Quadrature;
use crate::space::Space;

/// A node's part in a foot, with the derivatives of the foot and of Φ,ₛ by its displacement.
type PartOfFoot<const D: usize> = (NodeOfFoot, [f64; D], [f64; D]);

/// The nodes of a space that move the feet of a unit, with their parts in each of them.
#[derive(Default)]
struct MovingNodes<const D: usize> {
    nodes: Vec<u32>,
    /// Of each node and foot.
    parts: Vec<PartOfFoot<D>>,
    feet: usize,
    seen: SeenNodes,
}

impl<const D: usize> MovingNodes<D> {
    fn take(&mut self, feet: &[Option<Foot<D>>], own: Facet, space: &Space<D>) {
        self.nodes.clear();
        self.parts.clear();
        self.feet = feet.len();
        for (number, foot) in feet.iter().enumerate() {
            let Some((foot, curve)) = foot.as_ref().and_then(|foot| Some((foot, foot.curve.as_ref()?)))
            else {
                continue;
            };
            self.add((number, space), foot.facet, [&foot.node; 2], |value, _| NodeOfFoot {
                apart: value,
                ..NodeOfFoot::default()
            });
            // Along a facet functions of degree two have linear slopes.
            let further = std::array::from_fn(|k| foot.own[k] + curve.along[k]);
            self.add((number, space), own, [&foot.own, &further], |value, gradients| {
                let along =
                    |gradient: &[f64; D]| -> f64 { (0..D).map(|k| gradient[k] * curve.along[k]).sum() };
                let [slope, later] = gradients.map(along);
                NodeOfFoot { apart: -value, slope, bend: later - slope }
            });
        }
        for parts in self.parts.chunks_exact_mut(self.feet.max(1)) {
            for ((part, rate, turn), foot) in parts.iter_mut().zip(feet) {
                if let Some(curve) = foot.as_ref().and_then(|foot| foot.curve.as_ref()) {
                    (*rate, *turn) = (curve.rate(part), curve.turn(part));
                }
            }
        }
    }

    /// The parts of a facet's nodes in a foot, from values at the first of two places and gradients at both.
    fn add(
        &mut self,
        (foot, space): (usize, &Space<D>),
        facet: Facet,
        references: [&[f64; D]; 2],
        of_node: impl Fn(f64, [&[f64; D]; 2]) -> NodeOfFoot,
    ) {
        let (mut values, mut gradients) = ([[0.0; MAXIMUM_NODES]; 2], [[[0.0; D]; MAXIMUM_NODES]; 2]);
        let element = space.traces_of(space.mesh.cell_shape(facet.cell as usize));
        for (k, reference) in references.into_iter().enumerate() {
            element.evaluate(reference, &mut values[k], &mut gradients[k]);
        }
        let MovingNodes { nodes: known, parts, feet, seen } = self;
        let (nodes, places) = seen.of(space, facet);
        for &place in places {
            let number = known.iter().position(|node| *node == nodes[place]).unwrap_or_else(|| {
                known.push(nodes[place]);
                parts.resize(known.len() * *feet, (NodeOfFoot::default(), [0.0; D], [0.0; D]));
                known.len() - 1
            });
            let part = of_node(values[0][place], [&gradients[0][place], &gradients[1][place]]);
            let sum = &mut parts[number * *feet + foot].0;
            sum.apart += part.apart;
            sum.slope += part.slope;
            sum.bend += part.bend;
        }
    }

    fn of(&self, number: usize) -> &[PartOfFoot<D>] {
        &self.parts[number * self.feet..][..self.feet]
    }
}

/// Adds the second derivatives of a unit's energy by the displacements of two nodes, through its feet, to a block: from the derivatives by the feet and
/// the second ones.
fn add_block<const D: usize>(
    feet: &[Option<Foot<D>>],
    (first, second): (&[f64], &[f64]),
    [rows, columns]: [&[PartOfFoot<D>]; 2],
    block: &mut [f64],
) {
    for (one, (part, rate, turn)) in rows.iter().enumerate() {
        for (other, (_, other_rate, _)) in columns.iter().enumerate() {
            let both = second[one * feet.len() + other];
            for a in 0..D {
                for b in 0..D {
                    block[a * D + b] += both * rate[a] * other_rate[b];
                }
            }
        }
        let curve = feet[one].as_ref().and_then(|foot| foot.curve.as_ref());
        let Some(curve): Option<&FootCurve<D>> = curve else { continue };
        let (other, other_rate, other_turn) = &columns[one];
        let bent = first[one] * curve.factor;
        let diagonal = first[one] * curve.of_both([part, other]);
        for a in 0..D {
            block[a * D + a] += diagonal;
            for b in 0..D {
                block[a * D + b] += bent * (turn[a] * other_rate[b] + rate[a] * other_turn[b]);
            }
        }
    }
}

impl<const D: usize> Assembler<D> {
    /// The second derivatives of energies by the feet of their segments, and those of the feet, added to their tangents.
    ///
    /// # Errors
    /// As [`Assembler::add_motion_of_segments`]; [`PairError::NoSecondDerivative`].
    pub(super) fn add_second_motion_of_energies(
        &self,
        form: &Function<D>,
        (unknowns, tests): (&[FieldView<D>], &[&Arc<Space<D>>]),
        parts: Parts,
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
    ) -> Result<(), AssemblyError> {
        for term in form.motion().iter().filter(|term| parts.contain(term.integral.dependence)) {
            let trials = displacing_unknowns(form, term);
            if trials.is_empty() {
                continue;
            }
            let mut binding = self.bind(form, unknowns)?;
            let row = term.integral.test;
            let element = binding.element(tests[row]);
            let degrees = binding.degrees(tests);
            let arguments = [(Role::Test(row), &**tests[row])];
            let (integral, requirements) = (term.integral, term.kernel.constants().requirements);
            for group in groups(&binding, integral, &self.quadrature, &degrees, requirements, &arguments)? {
                let terms = &[MovingTerm { term, element }];
                let motion = Motion { binding: &binding, terms, threads: self.threads };
                let numbers = motion.energies_by_feet(&group)?;
                for trial in &trials {
                    let spaces = [tests[row], unknowns[*trial].space];
                    motion.add_second((&group, &numbers), (*trial, spaces), pattern, matrix)?;
                }
            }
        }
        Ok(())
    }
}

impl<const D: usize> Motion<'_, D> {
    /// Σ ∂c/∂u ⊗ ∂R/∂c, of the residual R of an energy by the unknown with the number of its test function, whose space is given: the rows are
    /// those of what displaces the points.
    ///
    /// # Errors
    /// As [`Assembler::add_motion_of_segments`].
    pub fn add_transposed(
        &self,
        (row, columns, tests): (usize, &Arc<Space<D>>, &[&Arc<Space<D>>]),
        quadrature: &Quadrature<D>,
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
    ) -> Result<(), AssemblyError> {
        let (binding, MovingTerm { term, element }) = (self.binding, self.terms[0]);
        let (integral, constants) = (term.integral, term.kernel.constants());
        let degrees = binding.degrees(tests);
        let arguments = [(Role::Test(integral.test), &**columns)];
        let blocks = pattern.sparsity().pair(row, integral.test);
        let zero_rows = pattern.sparsity().pair_rows(row, integral.test);
        let (width, [reading, _]) = (constants.components, Reading::of_arguments(constants.requirements));
        for group in groups(binding, integral, quadrature, &degrees, constants.requirements, &arguments)? {
            let side = group.side(binding.name, integral.test_side)?;
            let nodes = group.sides[side].elements[element].nodes;
            let seen = seen_places(&group, side, columns, reading).unwrap_or_else(|| (0..nodes).collect());
            let local = group.sides[side].facet.map(|(local, _)| local);
            let (values, zeros) = matrix.values_and_zero_rows();
            let (values, zeros) = (&mut values[blocks.values()], &mut zeros[zero_rows.clone()]);
            let motion = [(side, PointMotion::ByFeet(&seen))];
            self.each_column(&group, &motion, tests[row], &mut |unit, node, column| {
                let at = columns.nodes_at(group.sides[side].cells[unit], local);
                zeros[node as usize] = false;
                for (number, place) in seen.iter().enumerate() {
                    let block = blocks.place(node as usize, at[*place]);
                    let first = block.ok_or_else(|| self.missing(row, integral.test))? * D * width;
                    let block = &mut values[first..][..D * width];
                    for component in 0..width {
                        let rates = column.of(number * width + component);
                        (0..D).for_each(|k| block[k * width + component] += rates[k]);
                    }
                }
                Ok(())
            })?;
        }
        Ok(())
    }

    fn missing(&self, row: usize, column: usize) -> AssemblyError {
        let binding = self.binding;
        AssemblyError::Pattern {
            form: binding.name,
            test: binding.name_of(Role::Test(row)),
            trial: binding.name_of(Role::Unknown(column)),
        }
    }

    /// The first and second derivatives of the energy of each unit by its feet.
    fn energies_by_feet(&self, group: &Group<D>) -> Result<Vec<f64>, AssemblyError> {
        let (binding, threads, MovingTerm { term, element }) = (self.binding, self.threads, self.terms[0]);
        let task = ElementVectors { binding, group, cells: Cells::Mesh(binding.mesh), side: 0, element };
        let count = group.entities();
        let number = threads.count().min(count.div_ceil(64)).max(1);
        let parts = (0..number).map(|part| part * count / number..(part + 1) * count / number).collect();
        let found = threads.run(parts, |units: Range<usize>| {
            let mut numbers: Vec<f64> = Vec::new();
            term.kernel.compute_twice_moving(&task, units, &mut |_, some| {
                numbers.extend_from_slice(some);
                Ok(())
            })?;
            Ok(numbers)
        });
        let parts: Vec<Vec<f64>> = found.into_iter().collect::<Result<_, AssemblyError>>()?;
        let numbers = parts.concat();
        match numbers.iter().all(|value| value.is_finite()) {
            true => Ok(numbers),
            false => Err(self.refused(PairError::NoSecondDerivative { field: self.without_derivatives() })),
        }
    }

    fn add_second(
        &self,
        (group, numbers): (&Group<D>, &[f64]),
        (trial, [rows, columns]): (usize, [&Arc<Space<D>>; 2]),
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
    ) -> Result<(), AssemblyError> {
        let Some(pairs) = group.pairs() else { return Ok(()) };
        let (row, units) = (self.terms[0].term.integral.test, group.entities());
        let blocks = pattern.sparsity().pair(row, trial);
        let (values, zeros) = matrix.values_and_zero_rows();
        let values = &mut values[blocks.values()];
        let zeros = &mut zeros[pattern.sparsity().pair_rows(row, trial)];
        let (mut left, mut right) = (MovingNodes::default(), MovingNodes::default());
        let stride = numbers.len() / units.max(1);
        for (unit, facets) in pairs.group.facets.iter().enumerate() {
            let feet = pairs.group.motion.feet_of(unit, units);
            left.take(feet, facets[0], rows);
            right.take(feet, facets[0], columns);
            let (first, second) = numbers[unit * stride..][..stride].split_at(feet.len());
            for (i, node) in left.nodes.iter().enumerate() {
                zeros[*node as usize] = false;
                for (k, other) in right.nodes.iter().enumerate() {
                    let place = blocks.place(*node as usize, *other);
                    let start = place.ok_or_else(|| self.missing(row, trial))? * D * D;
                    let block = &mut values[start..][..D * D];
                    add_block(feet, (first, second), [left.of(i), right.of(k)], block);
                }
            }
        }
        Ok(())
    }
}
