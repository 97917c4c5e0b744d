//! The study at one θ: the reference, the errors of the coarser meshes against it, and the contact zones.

use forms_contact::hollow_cylinder::{INNER_RADIUS, OUTER_RADIUS};
use forms_contact::states::Adjoint;
use forms_fem::norms::{Comparison, Norms, norms};
use forms_fem::prelude::*;

use crate::Outcome;
use crate::contact_zone::ContactZone;
use crate::options::Options;
use crate::progress::Reporter;
use crate::states::Direct;

/// Degree of the rule on the reference mesh: the difference of two Q2 fields, squared, on cells that are nearly affine.
const DEGREE: usize = 5;

/// Everything that was measured at one θ. Lengths in cm.
pub struct Study {
    /// θ.
    pub theta: f64,
    /// n_r of the reference.
    pub reference: usize,
    /// The values of C in (41).
    pub extensions: Vec<f64>,
    /// By mesh, the coarsest first.
    pub errors: Vec<MeshErrors>,
    /// Contact zones by mesh, the coarsest first.
    pub zones: Vec<ZoneErrors>,
    /// The reference's contact zone.
    pub reference_zone: ContactZone,
    /// p_h of (22) on the finest of the meshes.
    pub consistent: Field<2>,
    /// p of (22) on the reference mesh.
    pub reference_consistent: Field<2>,
}

/// Errors on a mesh. u is compared with u, every adjoint state with p of (22) on the reference mesh.
pub struct MeshErrors {
    /// n_r.
    pub radial: usize,
    /// Thickness of a cell.
    pub h: f64,
    /// u_h of (14).
    pub direct: Relative,
    /// p_h of (22).
    pub consistent: Relative,
    /// p̃_h of (21).
    pub discrete: Relative,
    /// p_h of (41), by C.
    pub extended: Vec<Relative>,
}

/// ‖reference − coarse‖ / ‖reference‖, a ratio of norms.
#[derive(Clone, Copy, Debug)]
pub struct Relative {
    /// Full H¹ norm.
    pub h1: f64,
    /// ‖∇·‖.
    pub seminorm: f64,
}

impl Relative {
    fn new(error: Norms, reference: Norms) -> Relative {
        Relative { h1: error.h1 / reference.h1, seminorm: error.seminorm / reference.seminorm }
    }

    /// What Section 5.1 of the paper prints: the ratio of squared norms, with twice the slope.
    pub fn printed(self) -> f64 {
        self.h1 * self.h1
    }
}

/// How far the contact zone of a mesh is off.
pub struct ZoneErrors {
    /// n_r.
    pub radial: usize,
    /// Thickness of a cell.
    pub h: f64,
    /// |Γ^h_C,a ∩ Γ_C,i|: in contact here, not on the reference mesh.
    pub gained: f64,
    /// |Γ_C,a ∩ Γ^h_C,i|: in contact on the reference mesh, not here.
    pub lost: f64,
}

/// Solves on all meshes.
pub fn run(options: &Options, theta: f64) -> Outcome<Study> {
    let meshes = options.meshes();
    let reporter = Reporter::new(1 + options.meshes_of_zones().count());
    reporter.step(&format!("theta = {theta}: reference, n_r = {}", options.reference));
    let mut fine = Direct::solve(&options.settings(options.reference, theta))?;
    let reference_consistent = fine.adjoint(Adjoint::Consistent)?;
    // The factor is large, and no longer needed.
    let Direct { problem, u: reference_u, zone: reference_zone, .. } = fine;
    let assembler = problem.assembler.with_quadrature(Quadrature::Degree(DEGREE));
    let sizes = [norms(&assembler, &reference_u)?, norms(&assembler, &reference_consistent)?];
    let (mut errors, mut zones, mut finest) = (Vec::new(), Vec::new(), None);
    for radial in options.meshes_of_zones() {
        reporter.step(&format!("theta = {theta}: n_r = {radial}"));
        let mut coarse = Direct::solve(&options.settings(radial, theta))?;
        let h = (OUTER_RADIUS - INNER_RADIUS) / radial as f64;
        let (gained, lost) = (coarse.zone.outside(&reference_zone), reference_zone.outside(&coarse.zone));
        zones.push(ZoneErrors { radial, h, gained, lost });
        if !meshes.contains(&radial) {
            continue;
        }
        let comparison = Comparison::new(&assembler, &coarse.problem.space, DEGREE)?;
        let adjoint = |p: &Field<2>| -> Result<Relative, AssemblyError> {
            Ok(Relative::new(comparison.errors(&reference_consistent, p)?, sizes[1]))
        };
        let consistent = coarse.adjoint(Adjoint::Consistent)?;
        let extended = |c: &f64| -> Outcome<Relative> { Ok(adjoint(&coarse.extended(*c)?)?) };
        let extended = options.extension.iter().map(extended).collect::<Outcome<Vec<_>>>()?;
        errors.push(MeshErrors {
            radial,
            h,
            direct: Relative::new(comparison.errors(&reference_u, &coarse.u)?, sizes[0]),
            consistent: adjoint(&consistent)?,
            discrete: adjoint(&coarse.adjoint(Adjoint::Discrete)?)?,
            extended,
        });
        finest = Some(consistent);
    }
    Ok(Study {
        theta,
        reference: options.reference,
        extensions: options.extension.clone(),
        errors,
        zones,
        reference_zone,
        consistent: finest.ok_or("no mesh was compared")?,
        reference_consistent,
    })
}

impl Study {
    /// The quantities whose errors are measured, in the order of the tables, with their names.
    pub fn quantities(&self) -> Vec<(String, Vec<Relative>)> {
        let of = |pick: &dyn Fn(&MeshErrors) -> Relative| self.errors.iter().map(pick).collect::<Vec<_>>();
        let mut all = vec![
            ("u_h (14)".to_owned(), of(&|row| row.direct)),
            ("p_h (22)".to_owned(), of(&|row| row.consistent)),
            ("p̃_h (21)".to_owned(), of(&|row| row.discrete)),
        ];
        for (k, extension) in self.extensions.iter().enumerate() {
            all.push((format!("p_h (41), C = {extension}"), of(&|row| row.extended[k])));
        }
        all
    }

    /// h of the meshes whose errors are measured.
    pub fn widths(&self) -> Vec<f64> {
        self.errors.iter().map(|row| row.h).collect()
    }
}

/// The largest length on this mesh and all finer ones, where it is positive: (h, length), the coarsest first. Bounds a
/// length that is zero or small by chance on many meshes.
pub fn envelope(zones: &[ZoneErrors], length: impl Fn(&ZoneErrors) -> f64) -> Vec<(f64, f64)> {
    let mut largest = 0.0_f64;
    let mut points: Vec<(f64, f64)> = zones
        .iter()
        .rev()
        .map(|zone| {
            largest = largest.max(length(zone));
            (zone.h, largest)
        })
        .filter(|(_, length)| *length > 0.0)
        .collect();
    points.reverse();
    points
}
