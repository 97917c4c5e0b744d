//! Readings: numbers read off a state, its components at points or nodes.

use std::sync::Arc;

use super::error::HistoryFailure;
use crate::assemble::AssemblyError;
use crate::element::MAXIMUM_NODES;
use crate::field::FieldError;
use crate::instantiate::instantiate;
use crate::solve::Processes;
use crate::space::Space;

/// Components u_c(x) of a state at points x or at nodes, in the order of the requests.
#[derive(Clone, Debug)]
pub struct Readings<const D: usize> {
    space: Arc<Space<D>>,
    /// Of each reading the unknowns, each with its part in it.
    rows: Vec<Vec<(usize, f64)>>,
    points: Vec<Point<D>>,
}

/// A point at which all components are read.
#[derive(Clone, Debug)]
struct Point<const D: usize> {
    /// The number of its first reading.
    first: usize,
    position: [f64; D],
    /// Whether this process's mesh has it; on a part of a mesh another may.
    is_here: bool,
}

impl<const D: usize> Readings<D> {
    /// Empty readings of states on a space.
    pub fn new(space: &Arc<Space<D>>) -> Self {
        Readings { space: Arc::clone(space), rows: vec![], points: vec![] }
    }

    /// All components at a point. On a part of a mesh, which need not have the point, one process of those that have it reads.
    ///
    /// # Errors
    /// [`FieldError::Outside`] of a whole mesh, [`FieldError::OnFacets`], [`FieldError::AtPoints`].
    pub fn at_point(mut self, point: &[f64; D]) -> Result<Self, FieldError> {
        if let Some(region) = self.space.facet_region() {
            return Err(FieldError::OnFacets { region: region.to_owned() });
        }
        let found = self.space.locator().find(point);
        let found = found.filter(|(cell, _)| !self.space.cell_nodes(*cell).is_empty());
        let (first, components) = (self.rows.len(), self.space.components());
        self.points.push(Point { first, position: *point, is_here: found.is_some() });
        if found.is_none() && self.space.mesh().is_piece() {
            self.rows.resize(first + components, vec![]);
            return Ok(self);
        }
        let (cell, reference) = found.ok_or_else(|| FieldError::Outside { point: point.to_vec() })?;
        if self.space.cell_element(cell).is_at_points() {
            return Err(FieldError::AtPoints);
        }
        let mut values = [0.0; MAXIMUM_NODES];
        self.space.basis_in(cell, &reference, &mut values);
        for component in 0..components {
            let nodes = self.space.cell_nodes(cell).iter().zip(values);
            let row = nodes.map(|(node, part)| (*node as usize * components + component, part)).collect();
            self.rows.push(row);
        }
        Ok(self)
    }

    /// All components at all nodes, as the coefficients of a field.
    pub fn at_nodes(mut self) -> Self {
        self.rows.extend((0..self.space.unknowns()).map(|unknown| vec![(unknown, 1.0)]));
        self
    }

    /// The number of readings.
    pub fn count(&self) -> usize {
        self.rows.len()
    }

    /// Whether this process counts a reading, of each. Where processes have parts of a mesh the first that has a point reads there, and the owner
    /// of a node.
    ///
    /// # Errors
    /// [`FieldError::Outside`] for a point on no part; a failed exchange.
    pub(super) fn counted(&self, processes: &Processes<'_>) -> Result<Vec<bool>, HistoryFailure> {
        let (Some(vectors), Some(all)) = (processes.divided(), processes.communicator()) else {
            return Ok(vec![true; self.rows.len()]);
        };
        let is_owned =
            |row: &Vec<(usize, f64)>| row.first().is_some_and(|(unknown, _)| vectors.owns(*unknown));
        let mut counted: Vec<bool> = self.rows.iter().map(is_owned).collect();
        if self.points.is_empty() {
            return Ok(counted);
        }
        let here: Vec<u64> = self.points.iter().map(|point| u64::from(point.is_here)).collect();
        let failed = |source| AssemblyError::Communication { form: "observations", source };
        let all_here = all.gather_lists(&here).map_err(failed)?;
        for (place, Point { first, position, .. }) in self.points.iter().enumerate() {
            let reader = all_here.iter().position(|of_one| of_one[place] == 1);
            let outside = || FieldError::Outside { point: position.to_vec() };
            let is_reader = reader.ok_or_else(outside)? == all.rank();
            counted[*first..*first + self.space.components()].fill(is_reader);
        }
        Ok(counted)
    }

    /// Whether they can be read from states on a space.
    pub(super) fn fit(&self, space: &Arc<Space<D>>) -> bool {
        self.space.numbers_as(space)
    }

    /// The space of the states.
    pub(super) fn space(&self) -> &Arc<Space<D>> {
        &self.space
    }

    /// The readings of a state, given by its coefficients.
    #[inline(never)]
    pub(super) fn of(&self, state: &[f64]) -> Vec<f64> {
        let read = |row: &Vec<(usize, f64)>| row.iter().map(|(unknown, part)| part * state[*unknown]).sum();
        self.rows.iter().map(read).collect()
    }

    /// Adds the slope by the state of the readings' sum, each with a weight.
    #[inline(never)]
    pub(super) fn add_slope(&self, weights: &[f64], slope: &mut [f64]) {
        for (row, weight) in self.rows.iter().zip(weights) {
            row.iter().for_each(|(unknown, part)| slope[*unknown] += weight * part);
        }
    }
}

instantiate!(readings: Readings::<D>::of, Readings::<D>::add_slope);
