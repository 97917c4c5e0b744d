//! The study at one θ: the reference, the errors of the coarser meshes against it, and the contact zones.

use forms_contact::Adjoint;
use forms_contact::hollow_cylinder::{INNER_RADIUS, OUTER_RADIUS};
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
    /// With whole contact facets.
    pub whole: Series,
    /// With contact facets split at the zeros of β_h, if that was asked for.
    pub split: Option<Series>,
    /// The reference's contact zone; its facets are whole.
    pub reference_zone: ContactZone,
    /// p of (22) on the reference mesh.
    pub reference_consistent: Field<2>,
}

/// Measurements on the meshes, the coarsest first.
#[derive(Default)]
pub struct Series {
    /// On the meshes whose cells divide into the reference's.
    pub errors: Vec<MeshErrors>,
    /// On all meshes.
    pub zones: Vec<ZoneErrors>,
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
    /// p_h of (22) itself.
    pub adjoint: Field<2>,
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

    /// The ratio of squared norms that Section 5.1 of the paper prints, with twice the slope.
    pub fn printed(self) -> f64 {
        self.h1 * self.h1
    }
}

/// Error of a mesh's contact zone, and its cost.
pub struct ZoneErrors {
    /// n_r.
    pub radial: usize,
    /// Thickness of a cell.
    pub h: f64,
    /// |Γ^h_C,a ∩ Γ_C,i|: in contact here, not on the reference mesh.
    pub gained: f64,
    /// |Γ_C,a ∩ Γ^h_C,i|: in contact on the reference mesh, not here.
    pub lost: f64,
    /// Newton steps.
    pub steps: usize,
}

/// Solves on all meshes.
pub fn run(options: &Options, theta: f64) -> Outcome<Study> {
    let ways = if options.split { vec![false, true] } else { vec![false] };
    let reporter = Reporter::new(1 + ways.len() * options.meshes_of_zones().count());
    reporter.step(&format!("theta = {theta}: reference, n_r = {}", options.reference));
    let reference = Reference::solve(options, theta)?;
    let mut all = [Series::default(), Series::default()];
    for radial in options.meshes_of_zones() {
        for &split in &ways {
            let way = if split { ", split facets" } else { "" };
            reporter.step(&format!("theta = {theta}: n_r = {radial}{way}"));
            let mut coarse = Direct::solve(&options.settings(radial, theta), split)?;
            let series = &mut all[usize::from(split)];
            series.zones.push(reference.zone_errors(radial, &coarse));
            if options.meshes().contains(&radial) {
                series.errors.push(reference.errors(radial, &mut coarse, &options.extension)?);
            }
        }
    }
    let [whole, split] = all;
    Ok(Study {
        theta,
        reference: options.reference,
        extensions: options.extension.clone(),
        whole,
        split: options.split.then_some(split),
        reference_zone: reference.zone,
        reference_consistent: reference.consistent,
    })
}

/// The reference solution.
struct Reference {
    /// Of the reference mesh, with the rule of the comparison.
    assembler: Assembler<2>,
    u: Field<2>,
    consistent: Field<2>,
    zone: ContactZone,
    /// Norms of u and of p.
    norms: [Norms; 2],
}

impl Reference {
    fn solve(options: &Options, theta: f64) -> Outcome<Reference> {
        let mut fine = Direct::solve(&options.settings(options.reference, theta), false)?;
        let consistent = fine.adjoint(Adjoint::Consistent)?;
        // The factor is large, and no longer needed.
        let Direct { problem, u, zone, .. } = fine;
        let assembler = problem.assembler.with_quadrature(Quadrature::Degree(DEGREE));
        let norms = [norms(&assembler, &u)?, norms(&assembler, &consistent)?];
        Ok(Reference { assembler, u, consistent, zone, norms })
    }

    fn zone_errors(&self, radial: usize, coarse: &Direct) -> ZoneErrors {
        let (gained, lost) = (coarse.zone.outside(&self.zone), self.zone.outside(&coarse.zone));
        ZoneErrors { radial, h: width(radial), gained, lost, steps: coarse.steps }
    }

    fn errors(&self, radial: usize, coarse: &mut Direct, extensions: &[f64]) -> Outcome<MeshErrors> {
        let comparison = Comparison::new(&self.assembler, &coarse.problem.space, DEGREE)?;
        let compared = |p: &Field<2>| -> Outcome<Relative> {
            Ok(Relative::new(comparison.errors(&self.consistent, p)?, self.norms[1]))
        };
        let adjoint = coarse.adjoint(Adjoint::Consistent)?;
        let extended = extensions.iter().map(|c| compared(&coarse.extended(*c)?));
        Ok(MeshErrors {
            radial,
            h: width(radial),
            extended: extended.collect::<Outcome<Vec<_>>>()?,
            direct: Relative::new(comparison.errors(&self.u, &coarse.u)?, self.norms[0]),
            consistent: compared(&adjoint)?,
            discrete: compared(&coarse.adjoint(Adjoint::Discrete)?)?,
            adjoint,
        })
    }
}

/// The thickness of a cell.
fn width(radial: usize) -> f64 {
    (OUTER_RADIUS - INNER_RADIUS) / radial as f64
}

impl Study {
    /// The quantities whose errors are measured with whole facets, in the order of the tables, with their names.
    pub fn quantities(&self) -> Vec<(String, Vec<Relative>)> {
        let rows = &self.whole.errors;
        let of = |pick: &dyn Fn(&MeshErrors) -> Relative| rows.iter().map(pick).collect::<Vec<_>>();
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

    /// The finest of the meshes whose errors are measured.
    pub fn finest(&self) -> Outcome<&MeshErrors> {
        Ok(self.whole.errors.last().ok_or("no mesh was compared")?)
    }

    /// |p_h − p_ref| where p_h has a value on a mesh; NaN at a point that is not found in the reference, which pictures
    /// report.
    pub fn adjoint_difference(&self, mesh: &MeshErrors, position: &[f64; 2], p: &[f64]) -> f64 {
        let reference = &self.reference_consistent;
        let found = reference.space().locator().find_nearest(position, mesh.h);
        let there = found.map(|found| reference.evaluate_in(found.cell, &found.reference));
        there.map_or(f64::NAN, |there| (p[0] - there[0]).hypot(p[1] - there[1]))
    }

    /// h of the meshes whose errors are measured.
    pub fn widths(&self) -> Vec<f64> {
        self.whole.errors.iter().map(|row| row.h).collect()
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
