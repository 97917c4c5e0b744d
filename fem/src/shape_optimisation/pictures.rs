//! Pictures of a descent: how numbers went, and how the shape did.

use super::history::DescentState;
use crate::mesh::Mesh;
use crate::output::picture::{Curve, LinePlot, MeshDrawing, Panel, PictureError, Scale};

/// The least value of a constraint in pictures.
const LEAST_SHOWN: f64 = 1e-12;

/// The criterion, the constraint, the derivative along it and the worst cell over the steps. The label of the criterion
/// is for its axis.
///
/// # Errors
/// A history that is empty has nothing to draw; one without steps has a start alone, and no derivatives.
pub fn history_picture(state: &DescentState, criterion: &str) -> Result<Panel, PictureError> {
    let history = &state.history;
    let steps: Vec<f64> = (0..history.len()).map(|k| k as f64).collect();
    let plot = |label: &str, scale: Scale, x: &[f64], y: &[f64]| {
        LinePlot::new()
            .x_axis("step", Scale::Linear)
            .y_axis(label, scale)
            .curve(Curve::new("", x, y).without_markers())
            .grid()
    };
    let criteria: Vec<f64> = history.iter().map(|row| row.criterion).collect();
    let mut panel = Panel::new(2).picture(&plot(criterion, Scale::Linear, &steps, &criteria))?;
    let constraints: Vec<f64> =
        history.iter().filter_map(|row| row.constraint).map(|c| c.abs().max(LEAST_SHOWN)).collect();
    if constraints.len() == steps.len() {
        panel = panel.picture(&plot("|constraint|", Scale::Logarithmic, &steps, &constraints))?;
    }
    let norms: Vec<f64> =
        history.iter().filter_map(|row| row.step.as_ref()).map(|step| step.gradient_norm).collect();
    if !norms.is_empty() {
        let before: Vec<f64> = (0..norms.len()).map(|k| k as f64).collect();
        panel =
            panel.picture(&plot("derivative along the constraint", Scale::Logarithmic, &before, &norms))?;
    }
    let qualities: Vec<f64> = history.iter().map(|row| row.quality).collect();
    panel.picture(&plot("least scaled Jacobian", Scale::Linear, &steps, &qualities))
}

/// Shapes in a row, each with the number of its step; `window` shows a part of the plane.
///
/// # Errors
/// No shapes.
pub fn strip(
    shapes: &[(usize, Mesh<2>)],
    columns: usize,
    window: Option<[[f64; 2]; 2]>,
) -> Result<Panel, PictureError> {
    let mut panel = Panel::new(columns);
    for (number, mesh) in shapes {
        let mut drawing =
            MeshDrawing::new(mesh).title(&format!("step {number}")).size(220.0, 220.0).without_axes();
        if let Some([x, y]) = window {
            drawing = drawing.window(x, y);
        }
        panel = panel.picture(&drawing)?;
    }
    Ok(panel)
}
