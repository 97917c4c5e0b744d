//! Entries of a matrix that the tangents of some integrals touch, and unknowns that they read.

use std::ops::Range;
use std::sync::Arc;

use forms_core::contract::{Entity, Role, Side};

use super::BlockPattern;
use crate::assemble::AssemblyError;
use crate::assemble::binding::entities::Entities;
use crate::assemble::binding::outline::{Coupling, Outline};
use crate::assemble::binding::owned_cells::OwnedCells;
use crate::instantiate::instantiate;
use crate::mesh::Facet;
use crate::space::Space;

/// The entries of a matrix that some integrals touch.
pub(crate) struct TouchedEntries {
    /// Places among the values, as ascending ranges of whole blocks.
    pub places: Vec<Range<usize>>,
    /// Of each trial space, the unknowns that belong to the columns.
    pub unknowns: Vec<Vec<Range<usize>>>,
}

/// The runs of true entries, each entry standing for `width` numbers from `first` on.
fn runs(marks: &[bool], first: usize, width: usize, runs: &mut Vec<Range<usize>>) {
    for (number, _) in marks.iter().enumerate().filter(|(_, marked)| **marked) {
        let (start, end) = (first + number * width, first + (number + 1) * width);
        match runs.last_mut() {
            Some(last) if last.end == start => last.end = end,
            _ => runs.push(start..end),
        }
    }
}

impl<const D: usize> BlockPattern<D> {
    /// Whether integrals of an outline have tangents over cells.
    pub(crate) fn couples_cells(form: &Outline<D>) -> bool {
        let entity = |coupling: &Coupling| form.inputs().regions[coupling.region].entity;
        form.couplings.iter().any(|coupling| entity(coupling) == Entity::Cells)
    }

    /// The unknowns that the integrals of an outline read, ascending: those of all that the tangents couple, and at the facets of
    /// surfaces that may be displaced, whose pairs follow from them.
    #[inline(never)]
    pub(crate) fn read_unknowns(&self, form: &Outline<D>) -> Result<Vec<usize>, AssemblyError> {
        let mut read = Vec::new();
        for (number, unknowns) in self.touched(form)?.unknowns.into_iter().enumerate() {
            let offset = self.column_offset(number);
            read.extend(unknowns.into_iter().flatten().map(|unknown| offset + unknown));
        }
        let sliding = |coupling: &&Coupling| coupling.displacement.is_some();
        for coupling in form.couplings.iter().filter(sliding) {
            let facets = self.search.surfaces(form, &self.trials[0].mesh, coupling)?;
            for (number, space) in self.trials.iter().enumerate() {
                let offset = self.column_offset(number);
                for facet in &facets {
                    for node in space.nodes_at(facet.cell, Some(facet.local)) {
                        let first = offset + *node as usize * space.components();
                        read.extend(first..first + space.components());
                    }
                }
            }
        }
        read.sort_unstable();
        read.dedup();
        Ok(read)
    }

    /// The entries that the integrals of an outline touch in a matrix with this pattern: at least all that their tangents
    /// change, and whole pairs of spaces for integrals over all cells.
    #[inline(never)]
    pub(crate) fn touched(&self, form: &Outline<D>) -> Result<TouchedEntries, AssemblyError> {
        let tests: Vec<&Arc<Space<D>>> = self.tests.iter().collect();
        let trials: Vec<&Arc<Space<D>>> = self.trials.iter().collect();
        let mut marks: Vec<Vec<bool>> = vec![vec![]; self.tests.len() * self.trials.len()];
        let mut columns: Vec<Vec<bool>> = vec![vec![]; self.trials.len()];
        for &coupling in &form.couplings {
            let Coupling { test, trial, sides: [test_side, trial_side], .. } = coupling;
            let pair = self.sparsity.pair(test, trial);
            let (rows, columns_of) = (&self.tests[test], &self.trials[trial]);
            let marks = &mut marks[test * self.trials.len() + trial];
            marks.resize(pair.blocks(), false);
            let columns = &mut columns[trial];
            columns.resize(columns_of.node_count(), false);
            let entities = self.search.entities(form, &tests, &trials, &coupling)?;
            if let Entities::Cells(cells) = &entities
                && cells.len() == rows.mesh.cell_count()
            {
                marks.fill(true);
                columns.fill(true);
                continue;
            }
            let entities = OwnedCells::among(self.owned.as_deref(), entities);
            let seen = coupling.seen_on_pairs(form, &tests, &trials, &entities);
            let mut mark = |row_nodes: &[u32], column_nodes: &[u32]| {
                for &row in row_nodes {
                    for &column in column_nodes {
                        let place = pair.place(row as usize, column).ok_or_else(|| {
                            let name = |role| form.name_of(role);
                            let (test, trial) = (name(Role::Test(test)), name(Role::Unknown(trial)));
                            AssemblyError::Pattern { form: form.name(), test, trial }
                        })?;
                        marks[place] = true;
                        columns[column as usize] = true;
                    }
                }
                Ok(())
            };
            for index in 0..entities.count() {
                let at = |side: Side| match (&entities, side) {
                    (Entities::Cells(cells), _) => (cells[index], None),
                    (_, Side::This) => seen_from(entities.sides(index).first()),
                    (_, Side::Other) => seen_from(entities.sides(index).last()),
                };
                let ((row_cell, row_facet), (column_cell, column_facet)) = (at(test_side), at(trial_side));
                let (row_nodes, column_nodes) = match &seen {
                    Some([rows, columns]) => (rows.at(index), columns.at(index)),
                    None => {
                        (rows.nodes_at(row_cell, row_facet), columns_of.nodes_at(column_cell, column_facet))
                    }
                };
                mark(row_nodes, column_nodes)?;
            }
            for [rows, columns] in coupling.across_opposite_facets(&tests, &trials, &entities, seen.as_ref())
            {
                mark(&rows, &columns)?;
            }
        }
        let mut touched = TouchedEntries { places: vec![], unknowns: vec![] };
        for (number, marks) in marks.iter().enumerate() {
            let (test, trial) = (number / self.trials.len(), number % self.trials.len());
            let block = self.tests[test].components() * self.trials[trial].components();
            let first = self.sparsity.pair(test, trial).values().start;
            runs(marks, first, block, &mut touched.places);
        }
        for (space, marks) in self.trials.iter().zip(&columns) {
            let mut unknowns = Vec::new();
            runs(marks, 0, space.components(), &mut unknowns);
            touched.unknowns.push(unknowns);
        }
        Ok(touched)
    }
}

/// The cell and the local number of a facet.
fn seen_from(facet: Option<&Facet>) -> (u32, Option<u8>) {
    facet.map_or((0, None), |facet| (facet.cell, Some(facet.local)))
}

instantiate!(touched: BlockPattern::<D>::touched, BlockPattern::<D>::read_unknowns);
