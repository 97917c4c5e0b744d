//! The rows of PETSc's matrices that free unknowns on a part have.

use std::rc::Rc;

use forms_fem::linear_algebra::rigid_motions;
use forms_fem::prelude::*;
use forms_fem::solve::DividedVectors;
use forms_fem::solve::divided::{ConditionsHere, conditions_of_all};
use forms_fem::solve::elimination::Elimination;

use super::divided_unknowns::DividedUnknowns;
use super::divided_vectors::SpacesOnPart;
use crate::error::PetscError;
use crate::node_rows::{FieldRows, NodeRows, orthonormal, product};
use crate::petsc::Index;
use crate::rows::Rows;
use crate::world::World;

/// The rows of the free unknowns, as [`NodeRows`] has them: each process has those of the nodes that it owns, space after space.
pub(super) fn rows<const D: usize>(
    world: &World,
    vectors: &Rc<SpacesOnPart>,
    constraints: &[&Constraints<D>],
) -> Result<NodeRows, PetscError> {
    let free = free_unknowns(world, vectors, constraints)?;
    let mut is_free = vec![false; vectors.count()];
    free.iter().for_each(|unknown| is_free[*unknown] = true);
    // This process's nodes with rows, by their first unknowns among all.
    let mut offset = 0;
    let mut own_nodes: Vec<Vec<usize>> = vec![];
    for one in constraints {
        let (components, end) = (one.space().components(), offset + one.space().unknowns());
        let has_rows =
            |first: &usize| vectors.owns(*first) && is_free[*first..*first + components].contains(&true);
        own_nodes.push((offset..end).step_by(components).filter(has_rows).collect());
        offset = end;
    }
    let mut of_fields: Vec<Rows> = vec![];
    for (nodes, one) in own_nodes.iter().zip(constraints) {
        let counts = world.gather((nodes.len() * one.space().components()) as u64)?;
        let before: u64 = counts[..world.rank()].iter().sum();
        let (start, count) = (before as usize, counts.iter().sum::<u64>() as usize);
        let (block, own) = (one.space().components(), start..start + counts[world.rank()] as usize);
        of_fields.push(Rows { count, block, own });
    }
    let count: usize = of_fields.iter().map(|rows| rows.count).sum();
    if Index::try_from(count).is_err() {
        return Err(PetscError::TooMany { what: "rows", count });
    }
    let start: usize = of_fields.iter().map(|rows| rows.own.start).sum();
    let (mut next, mut rows, mut held, mut fields) = (start, vec![f64::NAN; vectors.count()], vec![], vec![]);
    let mut offset = 0;
    for ((nodes, one), of_field) in own_nodes.iter().zip(constraints).zip(of_fields) {
        let (space, first_row) = (one.space(), next);
        let mut positions = Vec::with_capacity(nodes.len());
        for first in nodes {
            positions.push(space.positions()[(first - offset) / space.components()]);
            for unknown in *first..first + space.components() {
                rows[unknown] = next as f64;
                if !is_free[unknown] {
                    held.push(next);
                }
                next += 1;
            }
        }
        let held: Vec<usize> =
            held.iter().filter(|row| **row >= first_row).map(|row| row - first_row).collect();
        let is_on_facets = space.facet_region().is_some();
        let is_displacement = space.components() == D && D > 1 && !is_on_facets;
        let motions = if is_displacement { motions(world, positions, &held)? } else { vec![] };
        fields.push(FieldRows { rows: of_field, start: first_row, motions, is_on_facets });
        offset += space.unknowns();
    }
    vectors.copy_from_owners(&mut rows)?;
    let places = free.iter().map(|unknown| rows[*unknown] as Index).collect();
    let held = held.into_iter().map(|row| row as Index).collect();
    let block = if let [only] = constraints { only.space().components() } else { 1 };
    let divided = Some(DividedUnknowns { vectors: Rc::clone(vectors), free });
    Ok(NodeRows { rows: Rows { count, block, own: start..next }, places, held, fields, divided })
}

/// The unknowns that no process prescribes or gives by others, ascending.
fn free_unknowns<const D: usize>(
    world: &World,
    vectors: &Rc<SpacesOnPart>,
    constraints: &[&Constraints<D>],
) -> Result<Vec<usize>, PetscError> {
    let failed = |error: &dyn std::error::Error| PetscError::Unfit { message: error.to_string() };
    let own = world.agree(Elimination::of(constraints).map_err(|error| failed(&error)))?;
    let all = conditions_of_all(&**vectors, world.rank(), &own);
    let ConditionsHere { prescribed, relations, .. } = world.agree(all.map_err(|error| failed(&error)))?;
    let is_free = |unknown: &usize| !prescribed.contains_key(unknown) && !relations.contains_key(unknown);
    Ok((0..vectors.count()).filter(is_free).collect())
}

/// This process's rows of an orthonormal basis of the rigid motions of all nodes.
fn motions<const D: usize>(
    world: &World,
    mut positions: Vec<[f64; D]>,
    held: &[usize],
) -> Result<Vec<Vec<f64>>, PetscError> {
    let count = positions.len();
    // The ends of the whole body come last: about its middle all processes turn.
    let picks: [fn(f64, f64) -> f64; 2] = [f64::min, f64::max];
    let mut ends = [[f64::INFINITY; D], [f64::NEG_INFINITY; D]];
    for (end, pick) in ends.iter_mut().zip(picks) {
        *end = positions.iter().fold(*end, |end, at| std::array::from_fn(|k| pick(end[k], at[k])));
    }
    let own: Vec<u64> = ends.iter().flatten().map(|end| end.to_bits()).collect();
    for of_one in world.meetings().gather_lists(&own)? {
        for ((end, pick), found) in ends.iter_mut().zip(picks).zip(of_one.chunks(D)) {
            *end = std::array::from_fn(|k| pick(end[k], f64::from_bits(found[k])));
        }
    }
    positions.extend(ends);
    let mut motions = rigid_motions(&positions);
    motions.iter_mut().for_each(|motion| motion.truncate(count * D));
    let sums = |all: &[&[f64]], b: &[f64]| world.sum(&all.iter().map(|a| product(a, b)).collect::<Vec<_>>());
    orthonormal(motions, held, &sums)
}
