//! The pictures: errors over unknowns, and a mesh.

use std::path::{Path, PathBuf};

use forms_fem::output::picture::{LinePlot, MeshDrawing, Picture, Scale};

use crate::Outcome;
use crate::study::{Study, curve, fitted};

/// Errors over unknowns of some studies, each adaptive and uniform.
pub fn errors(title: &str, quantity: &str, studies: &[(&str, &Study)], path: &Path) -> Outcome<PathBuf> {
    let mut plot = LinePlot::new()
        .title(title)
        .x_axis("unknowns", Scale::Logarithmic)
        .y_axis(quantity, Scale::Logarithmic)
        .grid()
        .size(360.0, 280.0);
    for (name, study) in studies {
        plot = plot
            .curve(curve(&format!("{name}, adaptive"), &study.adaptive).fitted_order(fitted(&study.adaptive)))
            .curve(
                curve(&format!("{name}, uniform"), &study.uniform)
                    .dashed()
                    .fitted_order(fitted(&study.uniform)),
            );
    }
    plot.write_png(path)?;
    Ok(path.to_owned())
}

/// A mesh of a study.
pub fn mesh(title: &str, study: &Study, path: &Path) -> Outcome<PathBuf> {
    let title = format!("{title}, {} cells", study.mesh.cell_count());
    MeshDrawing::new(&study.mesh).title(&title).write_png(path)?;
    Ok(path.to_owned())
}
