//! Forces of a die that is pressed into a slab and then drawn along: their balance, their table and their picture.

use std::path::Path;

use forms_fem::output::picture::{Curve, LinePlot, Picture, PictureError, Scale};

/// The heading of the table of [`DieForces::row`].
pub const HEADING: &str = "| way [mm] | down [N] | along [N] | along / down | unbalanced | Newton steps |\n\
                           | --: | --: | --: | --: | --: | --: |";

/// Forces of the die on the whole slab at a place on its way \[N\].
#[derive(Clone, Copy, Debug, Default)]
pub struct DieForces {
    /// The way of the die, down and then along \[mm\].
    pub way: f64,
    /// The force that presses the slab.
    pub down: f64,
    /// The force that drags the slab.
    pub along: f64,
}

impl DieForces {
    /// A row of the table, with the part of the forces that is [`unbalanced`] and the number of Newton steps.
    pub fn row(&self, unbalanced: f64, newton_steps: usize) -> String {
        let DieForces { way, down, along } = self;
        format!(
            "| {way:.3} | {down:.5} | {along:.5} | {:.4} | {unbalanced:.0e} | {newton_steps} |",
            along / down
        )
    }
}

/// The part of the forces on a die by which they are not those on its slab, along and down; three components each.
///
/// # Errors
/// One line if it is more than 1e-9.
pub fn unbalanced(die: &[f64], slab: &[f64]) -> Result<f64, String> {
    let part = [0, 2].map(|axis| (die[axis] + slab[axis]).abs() / slab[2].abs());
    let part = part[0].max(part[1]);
    if part > 1e-9 {
        return Err(format!("the forces on die and slab differ by {part:.1e} of them"));
    }
    Ok(part)
}

/// The ways of the load steps \[mm\]: a number of them down to a depth, then a number along.
pub fn ways((depth, pressing): (f64, usize), (length, sliding): (f64, usize)) -> impl Iterator<Item = f64> {
    let down = (1..=pressing).map(move |step| depth * step as f64 / pressing as f64);
    down.chain((1..=sliding).map(move |step| depth + length * step as f64 / sliding as f64))
}

/// Draws the forces over the way, which has a label.
///
/// # Errors
/// If the file cannot be written.
pub fn draw(forces: &[DieForces], way: &str, path: impl AsRef<Path>) -> Result<(), PictureError> {
    let column = |value: fn(&DieForces) -> f64| forces.iter().map(value).collect::<Vec<_>>();
    let ways = column(|forces| forces.way);
    LinePlot::new()
        .x_axis(way, Scale::Linear)
        .y_axis("force [N]", Scale::Linear)
        .curve(Curve::new("down", &ways, &column(|forces| forces.down)).without_markers())
        .curve(Curve::new("along", &ways, &column(|forces| forces.along)).without_markers().dashed())
        .write_png(path)
}
