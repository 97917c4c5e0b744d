//! The pictures: those of the paper's Figure 2, the contact pressure and the von Mises stress.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use forms_contact_problem::forms;
use forms_contact_problem::hollow_cylinder::{CONTACT, CylinderSolution, OBSTACLE_DEPTH, OUTER_RADIUS};
use forms_fem::output::picture::{
    Colour, Curve, Drawing, FieldMap, LinePlot, MeshDrawing, Panel, Picture, Scale, Shown, draw_all,
    write_all_png,
};
use forms_fem::prelude::*;

use crate::Outcome;
use crate::derived_fields::DerivedFields;

/// Samples per facet of the curves along Γ_C.
const SAMPLES: usize = 101;

/// Writes the pictures into the directory and returns their paths.
pub fn write_all(
    solution: &CylinderSolution,
    derived: &DerivedFields,
    directory: &Path,
) -> Outcome<Vec<PathBuf>> {
    let threads =
        NonZeroUsize::new(solution.problem.assembler.threads().count()).unwrap_or(NonZeroUsize::MIN);
    let (mesh, displacement, adjoint) = (mesh(solution)?, displacement(solution), adjoint_state(solution));
    let (pressure, von_mises) = (contact_pressure(solution)?, von_mises(solution, derived));
    let drawings = draw_all(&[&displacement, &adjoint, &von_mises, &mesh, &pressure], threads)?;
    let [displacement, adjoint, von_mises, mesh, pressure]: [Drawing; 5] =
        drawings.try_into().map_err(|_| "a drawing for each picture")?;
    let figure = Panel::new(3).letters().picture(&mesh)?.picture(&displacement)?.picture(&adjoint)?;
    let pictures = [
        ("mesh.png", mesh),
        ("displacement.png", displacement),
        ("adjoint_state.png", adjoint),
        ("figure_2.png", figure.draw()?),
        ("contact_pressure.png", pressure),
        ("von_mises.png", von_mises),
    ]
    .map(|(name, picture)| (directory.join(name), picture));
    write_all_png(&pictures, threads)?;
    Ok(pictures.into_iter().map(|(path, _)| path).collect())
}

fn mesh(solution: &CylinderSolution) -> Outcome<MeshDrawing<'_>> {
    let mesh = solution.problem.space.mesh();
    let regions = MeshDrawing::new(mesh).named_region("inner", "Γ_{D}")?.named_region(CONTACT, "Γ_{C}")?;
    Ok(regions.title("Mesh").length_unit("cm"))
}

/// The obstacle, a little wider than the body.
fn obstacle() -> [[f64; 2]; 2] {
    [-1.04 * OUTER_RADIUS, 1.04 * OUTER_RADIUS].map(|x| [x, -OBSTACLE_DEPTH])
}

/// A map on the deformed body, above the obstacle.
fn on_deformed_body<'a>(map: FieldMap<'a>, solution: &'a CylinderSolution) -> FieldMap<'a> {
    map.deformed(&solution.u, 1.0)
        .undeformed_outline("undeformed")
        .line(&obstacle(), "obstacle", Colour::of_series(1))
        .without_mesh_lines()
        .length_unit("cm")
}

fn displacement(solution: &CylinderSolution) -> FieldMap<'_> {
    let map = FieldMap::of(&solution.u, Shown::Magnitude, "|u_{h}| [cm]");
    on_deformed_body(map, solution).title("Displacement, true to scale")
}

fn adjoint_state(solution: &CylinderSolution) -> FieldMap<'_> {
    FieldMap::of(&solution.p_consistent, Shown::Magnitude, "|p_{h}| [N cm^{2}/MPa]")
        .without_mesh_lines()
        .arrows(&solution.p_consistent, "p_{h}", "N cm^{2}/MPa")
        .length_unit("cm")
        .title("Adjoint state of (22)")
}

fn von_mises<'a>(solution: &'a CylinderSolution, derived: &'a DerivedFields) -> FieldMap<'a> {
    let map = FieldMap::of(&derived.von_mises, Shown::Magnitude, "von Mises stress [MPa]");
    on_deformed_body(map, solution).title("Von Mises stress")
}

/// Values along Γ_C from left to right, over the undeformed x.
fn along_contact(solution: &CylinderSolution, expression: &Expression<2>) -> Outcome<(Vec<f64>, Vec<f64>)> {
    let samples = solution.problem.assembler.along_facets_uniformly(expression, CONTACT, SAMPLES)?;
    let mut facets: Vec<Vec<[f64; 2]>> = samples
        .chunks(SAMPLES)
        .map(|facet| facet.iter().map(|sample| [sample.position[0], sample.value[0]]).collect())
        .collect();
    // The curve jumps where two facets meet: only whole facets may change places.
    for facet in &mut facets {
        facet.sort_by(|a, b| a[0].total_cmp(&b[0]));
    }
    facets.sort_by(|a, b| a[0][0].total_cmp(&b[0][0]));
    Ok(facets.into_iter().flatten().map(|[x, value]| (x, value)).unzip())
}

fn contact_pressure(solution: &CylinderSolution) -> Outcome<LinePlot> {
    let (data, u) = (&solution.problem.law.data, &solution.u);
    let (x, pressure) = along_contact(solution, &forms::contact_pressure(data, u))?;
    let (_, stress) = along_contact(solution, &forms::normal_stress(data, u))?;
    let (_, indicator) = along_contact(solution, &forms::contact_indicator(data, u))?;
    let reaction: Vec<f64> = stress.iter().map(|stress| -stress).collect();
    let mut plot = LinePlot::new()
        .title("Contact pressure along Γ_{C}")
        .x_axis("x [cm]", Scale::Linear)
        .y_axis("pressure [MPa]", Scale::Linear)
        .grid();
    // Outside the active zone nothing happens: the window is not quite twice as wide.
    let mut shown = vec![true; x.len()];
    if let Some([left, right]) = ends_of_contact(&x, &indicator) {
        let (middle, half) = ((left + right) / 2.0, 0.9 * (right - left));
        let (low, high) = ((middle - half).max(-OUTER_RADIUS), (middle + half).min(OUTER_RADIUS));
        shown = x.iter().map(|x| (low..=high).contains(x)).collect();
        plot = plot.x_range(low, high).vertical_line(left, "").vertical_line(right, "β_{h} = 0");
    }
    let keep = |values: &[f64]| -> Vec<f64> {
        values.iter().zip(&shown).filter(|(_, shown)| **shown).map(|(value, _)| *value).collect()
    };
    let x = keep(&x);
    Ok(plot
        .curve(Curve::new("[σ_{n} − γ(u_{n} − g)]_{−}", &x, &keep(&pressure)).without_markers())
        .curve(Curve::new("−σ_{n}(u_{h})", &x, &keep(&reaction)).without_markers().dashed()))
}

/// The first and the last x where β_h changes its sign; `None` without contact.
fn ends_of_contact(x: &[f64], indicator: &[f64]) -> Option<[f64; 2]> {
    let zero = |k: usize| {
        let [before, after] = [indicator[k], indicator[k + 1]];
        let changes = (before > 0.0) != (after > 0.0);
        changes.then(|| x[k] + (x[k + 1] - x[k]) * before / (before - after))
    };
    let zeros = || (0..x.len().saturating_sub(1)).filter_map(zero);
    let [left, right] = [zeros().next()?, zeros().next_back()?];
    (left < right).then_some([left, right])
}
