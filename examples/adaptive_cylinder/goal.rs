//! J on meshes that follow its error: to a tolerance, compared with uniform meshes, and how well its error is known.

use std::time::Instant;

use forms_contact::hollow_cylinder::{INNER_RADIUS, OUTER_RADIUS};
use forms_fem::adaptivity::{Adaptation, AdaptiveSolution};
use forms_fem::mesh::{Surface, onto_sphere};
use forms_fem::output::picture::{MeshDrawing, Picture};
use forms_fem::output::{StandardOutput, tell};
use forms_fem::prelude::*;

use crate::states::{Direct, FIRST, Marking, Variant, mesh};
use crate::{Options, Outcome};

/// Unknowns of the last mesh on which η is compared with the error of J, over those of the option.
const SHOWN: usize = 2;
/// Unknowns of the mesh by which that error is known, over those of the option.
const FINER: usize = 5;

/// Unknowns of the finest uniform mesh at most, over those of the option.
const UNIFORM: usize = 16;

/// Prints the meshes for J until |η| is within the tolerance, and uniform ones, with seconds by the clock: from the first mesh on, and
/// of one mesh. Draws the last mesh.
pub fn to_tolerance(options: &Options, out: &mut StandardOutput) -> Outcome<()> {
    out.line("\n| meshes | unknowns | J | η / J | s |\n| --- | --- | --- | --- | --- |");
    let row =
        |out: &mut StandardOutput, name: &str, unknowns: usize, goal: f64, estimate: f64, seconds: f64| {
            out.line(format!("| {name} | {unknowns} | {goal:.8} | {:.2e} | {seconds:.2} |", estimate / goal));
        };
    let solve = |mesh: &Mesh<2>, before: Option<&Field<2>>| -> Outcome<AdaptiveSolution<2>> {
        Direct::solve(mesh, &options.variant(), before)?.goal(Marking::Goal)
    };
    let coarse = solve(&mesh(FIRST)?, None)?;
    let scale = coarse.goal.ok_or("no goal")?.abs();
    let (inner, outer) = (onto_sphere([0.0; 2], INNER_RADIUS), onto_sphere([0.0; 2], OUTER_RADIUS));
    let start = Instant::now();
    let surfaces: [Surface<'_, 2>; 2] = [("inner", &inner), ("outer", &outer)];
    let cycle = Adaptation::to_tolerance(options.tolerance * scale).onto(&surfaces);
    let mut seconds = vec![];
    let mut timed = |mesh: &Mesh<2>, before: Option<&Field<2>>| {
        let solution = solve(mesh, before);
        seconds.push(start.elapsed().as_secs_f64());
        solution
    };
    let adapted = cycle.run(mesh(FIRST)?, &mut timed, |step| tell(step.to_string()))?;
    for (step, seconds) in adapted.steps.iter().zip(&seconds) {
        row(out, "for J", step.unknowns, step.goal.unwrap_or(f64::NAN), step.estimate, *seconds);
    }
    for radial in [1, 2, 4, 8].map(|factor| factor * FIRST) {
        let start = Instant::now();
        let found = solve(&mesh(radial)?, None)?;
        let (unknowns, goal) = (found.field.space().unknowns(), found.goal.unwrap_or(f64::NAN));
        row(out, "uniform", unknowns, goal, found.estimate.value(), start.elapsed().as_secs_f64());
        // The next one has four times as many.
        if 4 * unknowns > UNIFORM * options.unknowns {
            break;
        }
    }
    let drawn = adapted.mesh.mesh();
    let title = format!("For J, {} cells", drawn.cell_count());
    MeshDrawing::new(drawn).title(&title).write_png(options.out.join("adaptive_cylinder_mesh.png"))?;
    Ok(())
}

/// Prints η and the error of J on meshes of one body: its outline stays that of the first mesh, which η does not see. Meshes are
/// marked for J and for p. J is that of a finer mesh of the series, with its η; in addition what J of degree 3 on the same mesh
/// would know of the error.
pub fn effectivity(options: &Options, out: &mut StandardOutput) -> Outcome<()> {
    out.line("\n| θ | unknowns | J − J_h | η / (J − J_h) | (J₃ − J_h) / (J − J_h) |\n| --- | --- | --- | --- | --- |");
    for theta in [-1.0, 0.0, 1.0] {
        let variant = Variant { theta, gamma0_over_young: options.gamma0, facets: options.contact_facets };
        let mut of_degree_3 = vec![];
        let on_mesh = |mesh: &Mesh<2>, before: Option<&Field<2>>| -> Outcome<_> {
            let direct = Direct::solve(mesh, &variant, before)?;
            if direct.u.space().unknowns() <= SHOWN * options.unknowns {
                of_degree_3.push(direct.goal_of_degree_3()?);
            }
            direct.goal(Marking::GoalAndAdjoint)
        };
        let cycle = Adaptation::to_unknowns(FINER * options.unknowns);
        let adapted = cycle.run(mesh(FIRST)?, on_mesh, |step| tell(format!("theta = {theta}, {step}")))?;
        let finest = adapted.steps.last().ok_or("no mesh")?;
        let exact = finest.goal.ok_or("no goal")? + finest.estimate;
        for (step, [richer, _]) in adapted.steps.iter().zip(&of_degree_3) {
            let goal = step.goal.ok_or("no goal")?;
            let error = exact - goal;
            let (quotient, known) = (step.estimate / error, (richer - goal) / error);
            out.line(format!("| {theta} | {} | {error:.3e} | {quotient:.4} | {known:.4} |", step.unknowns));
        }
        let required = of_degree_3.iter().map(|[_, required]| *required).fold(0.0, f64::max);
        out.line(format!(
            "| {theta} | {} | J = {exact:.8} | η / J = {:.1e} | γ₀ > {required:.1} E in degree 3 |",
            finest.unknowns,
            finest.estimate / exact
        ));
    }
    Ok(())
}
