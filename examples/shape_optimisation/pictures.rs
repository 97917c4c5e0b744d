//! Pictures: the figure, the holes laid over each other, the contact pressure, the way of each run.

use std::f64::consts::TAU;
use std::path::PathBuf;

use forms_contact::forms;
use forms_contact::hollow_cylinder::{CONTACT, INNER_RADIUS, OUTER_RADIUS};
use forms_contact::shape_problem::ContactState;
use forms_fem::output::picture::{Colour, Curve, Drawing, FieldMap, LinePlot, Panel, Picture, Scale, Shown};
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::{history_picture, strip};

use crate::Outcome;
use crate::cantilever;
use crate::options::{Case, Options};
use crate::ring::EVEN_OVER;
use crate::runs::Run;

/// Samples per facet of curves and outlines.
const SAMPLES: usize = 21;

/// Writes all pictures and returns their paths.
pub fn write_all(options: &Options, initial: &Mesh<2>, runs: &[Run]) -> Outcome<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut write = |path: PathBuf, picture: Drawing| -> Outcome<()> {
        picture.write_png(&path)?;
        files.push(path);
        Ok(())
    };
    let window = window(options);
    let (name, label) = (options.case.name(), options.case.label());
    for run in runs {
        let directory = run.logbook.directory();
        write(directory.join("history.png"), history_picture(&run.state, label)?.draw()?)?;
        let shapes = run.logbook.shapes(initial)?;
        write(directory.join("shapes.png"), strip(&shapes, 4, Some(window))?.draw()?)?;
    }
    write(options.out.join(format!("{name}.png")), figure(runs)?)?;
    if options.case != Case::Cantilever {
        write(options.out.join(format!("{name}_holes.png")), holes(initial, runs, window)?)?;
    }
    write(options.out.join(format!("{name}_pressure.png")), pressures(runs)?)?;
    Ok(files)
}

/// The three holes at the bottom; all of the cantilever.
fn window(options: &Options) -> [[f64; 2]; 2] {
    if options.case == Case::Cantilever {
        let [length, height] = cantilever::SIZE;
        return [[-1.0, length + 1.0], [-0.5 * height, 1.5 * height]];
    }
    let half = (1.6 * TAU / options.holes as f64).sin() * OUTER_RADIUS;
    [[-half, half], [-OUTER_RADIUS - 0.5, -0.94 * INNER_RADIUS]]
}

/// The initial and each best shape, with the adjoint states; without them the von Mises stress.
fn figure(runs: &[Run]) -> Outcome<Drawing> {
    let mut panel = Panel::new(runs.len() + 1).letters();
    let Some(first) = runs.first() else { return Err("no run".into()) };
    let all: Vec<&Field<2>> = runs.iter().filter_map(|run| run.adjoints.as_ref()).flatten().collect();
    if all.is_empty() {
        let mut stresses = vec![("initial shape".to_owned(), von_mises(&first.start)?)];
        for run in runs {
            stresses.push((format!("optimal shape with {}", run.number), von_mises(&run.end)?));
        }
        let range = largest(stresses.iter().map(|(_, stress)| stress));
        for (title, stress) in &stresses {
            let map = FieldMap::of(stress, Shown::Magnitude, "von Mises stress [MPa]").range(0.0, range);
            panel = panel.picture(&map.without_mesh_lines().length_unit("cm").title(title))?;
        }
        return Ok(panel.draw()?);
    }
    let range = largest(all.into_iter());
    let map = |field, title: &str| {
        FieldMap::of(field, Shown::Magnitude, "|p_{h}| [N cm^{2}/MPa]")
            .range(0.0, range)
            .without_mesh_lines()
            .length_unit("cm")
            .title(title)
    };
    if let Some([start, _]) = &first.adjoints {
        panel = panel.picture(&map(start, "initial shape"))?;
    }
    for run in runs {
        if let Some([_, end]) = &run.adjoints {
            panel = panel.picture(&map(end, &format!("optimal shape with {}", run.number)))?;
        }
    }
    Ok(panel.draw()?)
}

fn largest<'a>(fields: impl Iterator<Item = &'a Field<2>>) -> f64 {
    let magnitude = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
    let of_field = |field: &Field<2>| {
        field.values().chunks(field.space().components()).map(magnitude).fold(0.0, f64::max)
    };
    fields.map(of_field).fold(0.0, f64::max)
}

fn von_mises(state: &ContactState<2>) -> Outcome<Field<2>> {
    let scalars = Space::scalar(state.problem.space.mesh(), 2)?;
    Ok(state.problem.assembler.project(&forms::von_mises(&state.problem.law.data, &state.u), &scalars)?)
}

/// The holes of all shapes over the body of the last.
fn holes(initial: &Mesh<2>, runs: &[Run], [x, y]: [[f64; 2]; 2]) -> Outcome<Drawing> {
    let Some(last) = runs.last() else { return Err("no run".into()) };
    let stress = von_mises(&last.end)?;
    let mut map = FieldMap::of(&stress, Shown::Magnitude, "von Mises stress [MPa]")
        .without_mesh_lines()
        .window(x, y)
        .size(420.0, 300.0)
        .length_unit("cm");
    let curves = std::iter::once((initial, "initial".to_owned()))
        .chain(runs.iter().map(|run| (&run.mesh, format!("optimal with {}", run.number))));
    for (number, (mesh, name)) in curves.enumerate() {
        for (k, curve) in outlines(mesh)?.into_iter().enumerate() {
            let name = if k == 0 { name.as_str() } else { "" };
            map = map.line(&curve, name, Colour::of_series(number));
        }
    }
    Ok(map.draw()?)
}

/// The closed curve of each hole.
fn outlines(mesh: &Mesh<2>) -> Outcome<Vec<Vec<[f64; 2]>>> {
    let mut curves = Vec::new();
    let names: Vec<String> =
        mesh.facet_region_names().filter(|name| name.starts_with("hole ")).map(str::to_owned).collect();
    for name in names {
        let mut points = Vec::new();
        for facet in mesh.facet_region(&name)? {
            let [a, b] = mesh.cell_shape(facet.cell as usize).edges()[usize::from(facet.local)]
                .map(|vertex| mesh.cell_shape(facet.cell as usize).vertex_points()[vertex]);
            for k in 0..SAMPLES {
                let t = k as f64 / (SAMPLES - 1) as f64;
                let reference = std::array::from_fn(|i| (1.0 - t) * a[i] + t * b[i]);
                points.push(mesh.map(facet.cell as usize, &reference).0);
            }
        }
        // The facets of a hole follow each other, but each may run backwards: by the angle about the middle.
        let count = points.len() as f64;
        let middle: [f64; 2] = std::array::from_fn(|i| points.iter().map(|x| x[i]).sum::<f64>() / count);
        let angle = |x: &[f64; 2]| (x[1] - middle[1]).atan2(x[0] - middle[0]);
        points.sort_by(|x, y| angle(x).total_cmp(&angle(y)));
        points.extend(points.first().copied());
        curves.push(points);
    }
    Ok(curves)
}

/// The contact pressure before and after; where its variation is the criterion, over its mean on the length L, for the force
/// changes too and the criterion does not see it.
fn pressures(runs: &[Run]) -> Outcome<Drawing> {
    let Some(first) = runs.first() else { return Err("no run".into()) };
    let name = |name: &str, state: &ContactState<2>| match state.pressure {
        Some(_) => format!("{name}: J = {:.4}", state.criterion),
        None => name.to_owned(),
    };
    let mut curves = vec![(name("initial shape", &first.start), pressure(&first.start)?)];
    for run in runs {
        curves.push((name(&format!("optimal with {}", run.number), &run.end), pressure(&run.end)?));
    }
    let axis = match first.start.pressure {
        Some(_) => format!("pressure over its mean, p L/∫p, L = {EVEN_OVER} cm"),
        None => "contact pressure [MPa]".to_owned(),
    };
    let touched = || curves.iter().flat_map(|(_, curve)| curve).filter(|[_, p]| *p > 0.0).map(|[x, _]| *x);
    let (first, last) =
        (touched().fold(f64::INFINITY, f64::min), touched().fold(f64::NEG_INFINITY, f64::max));
    let margin = 0.15 * (last - first).max(1.0);
    let [low, high] = [first - margin, last + margin];
    let mut plot = LinePlot::new()
        .x_axis("x [cm]", Scale::Linear)
        .y_axis(&axis, Scale::Linear)
        .x_range(low, high)
        .size(420.0, 260.0)
        .grid();
    for (number, (name, curve)) in curves.iter().enumerate() {
        let (x, y): (Vec<f64>, Vec<f64>) =
            curve.iter().filter(|[x, _]| (low..=high).contains(x)).map(|[x, p]| (*x, *p)).unzip();
        let curve = Curve::new(name, &x, &y).without_markers();
        plot = plot.curve(if number > 1 { curve.dashed() } else { curve });
    }
    Ok(plot.draw()?)
}

fn pressure(state: &ContactState<2>) -> Outcome<Vec<[f64; 2]>> {
    let (problem, u) = (&state.problem, &state.u);
    let unit = state.pressure.map_or(1.0, |[force, _]| force / EVEN_OVER);
    let pressure = forms::contact_pressure(&problem.law.data, u);
    let samples = problem.assembler.along_facets_uniformly(&pressure, CONTACT, SAMPLES)?;
    let mut facets: Vec<Vec<[f64; 2]>> = samples
        .chunks(SAMPLES)
        .map(|facet| facet.iter().map(|sample| [sample.position[0], sample.value[0] / unit]).collect())
        .collect();
    // The curve jumps where two facets meet: only whole facets may change places.
    facets.iter_mut().for_each(|facet| facet.sort_by(|a, b| a[0].total_cmp(&b[0])));
    facets.sort_by(|a, b| a[0][0].total_cmp(&b[0][0]));
    Ok(facets.into_iter().flatten().collect())
}
