//! Errors of the states on adaptive and on uniform meshes, compared with a reference on a finer mesh of the same first one.

use forms_fem::mesh::{AdaptiveMesh, doerfler};
use forms_fem::norms::{Comparison, Norms, norms};
use forms_fem::output::tell;
use forms_fem::prelude::*;

use crate::states::{Direct, FIRST, States, mesh, refined};
use crate::{Options, Outcome};

/// Degree of the rule on the reference mesh.
const DEGREE: usize = 5;

/// Kind of refinement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meshes {
    /// All cells are divided.
    Uniform,
    /// Cells are marked by the estimated error of u.
    ForDisplacement,
    /// Cells are marked by the estimated error of p of (22).
    ForAdjoint,
    /// Cells are marked by both, each relative to its sum.
    ForBoth,
}

/// Relative errors in H¹ on a mesh: of u, and of p of (22), (21) and (41) relative to p of (22).
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Unknowns.
    pub unknowns: usize,
    /// The errors.
    pub errors: [f64; 4],
}

/// Solves on a series of meshes up to a number of unknowns, and hands over the states on each.
pub fn series(
    meshes: Meshes,
    options: &Options,
    unknowns: usize,
    mut each: impl FnMut(States) -> Outcome<()>,
) -> Outcome<Mesh<2>> {
    let mut adaptive = AdaptiveMesh::new(mesh(FIRST)?)?;
    let (mut radial, mut before) = (FIRST, None);
    loop {
        let current = match meshes {
            Meshes::Uniform => mesh(radial)?,
            _ => adaptive.mesh().clone(),
        };
        let mut direct = Direct::solve(&current, &options.variant(), before.as_ref())?;
        let count = direct.u.space().unknowns();
        tell(format!("{meshes:?}, theta = {}: {count} unknowns", options.theta));
        let estimate = match meshes {
            Meshes::Uniform => None,
            Meshes::ForDisplacement => Some(direct.error()?),
            Meshes::ForAdjoint => Some(direct.adjoint_error()?),
            Meshes::ForBoth => Some(direct.error()?.marking_also_by(&direct.adjoint_error()?)?),
        };
        let states = direct.states()?;
        before = Some(states.fields[0].clone());
        each(states)?;
        if count >= unknowns {
            return Ok(current);
        }
        match estimate {
            None => radial *= 2,
            Some(estimate) => adaptive = refined(&adaptive, &doerfler(estimate.indicators(), 0.5)?)?,
        }
    }
}

/// u and p of (22) on a fine mesh.
pub struct Reference {
    assembler: Assembler<2>,
    u: Field<2>,
    p: Field<2>,
    norms: [Norms; 2],
}

impl Reference {
    /// The reference from the states on its mesh.
    pub fn new(states: States) -> Outcome<Reference> {
        let [u, p, ..] = states.fields;
        let assembler = Assembler::new(u.space().mesh()).with_quadrature(Quadrature::Degree(DEGREE));
        let norms = [norms(&assembler, &u)?, norms(&assembler, &p)?];
        Ok(Reference { assembler, u, p, norms })
    }

    /// The errors of the states on another mesh.
    pub fn errors(&self, states: &States) -> Outcome<Row> {
        let [u, adjoints @ ..] = &states.fields;
        let comparison = Comparison::new(&self.assembler, u.space(), DEGREE)?;
        let mut errors = [comparison.errors(&self.u, u)?.h1 / self.norms[0].h1, 0.0, 0.0, 0.0];
        for (error, p) in errors[1..].iter_mut().zip(adjoints) {
            *error = comparison.errors(&self.p, p)?.h1 / self.norms[1].h1;
        }
        Ok(Row { unknowns: u.space().unknowns(), errors })
    }

    /// Unknowns.
    pub fn unknowns(&self) -> usize {
        self.u.space().unknowns()
    }
}
