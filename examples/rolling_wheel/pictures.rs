//! Pictures of wheels over their positions, and one that rolls.

use std::f64::consts::TAU;
use std::path::Path;

use forms_contact::hollow_cylinder::{INNER_RADIUS, OBSTACLE_DEPTH, OUTER_RADIUS};
use forms_contact::rolling::Ground;
use forms_examples::level_set::wheel::{HOLES, Wheel};
use forms_fem::output::picture::{
    Animation, Colour, Curve, FieldMap, LinePlot, Panel, Picture, Scale, Shown,
};
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::Failure;

use super::account::Rolled;

/// Work and reaction over the angle less their means, and the holes of the optima over the stress in the first position.
pub fn picture(judge: &Wheel, rolled: &[Rolled]) -> Result<impl Picture, Failure> {
    let mut panel = Panel::new(2);
    for wheel in &rolled[1..] {
        let stress = judge.mises(&wheel.pressed, &wheel.pressed.positions[0])?;
        let pieces = wheel.body.body()?;
        let shown = pieces.field(&stress)?;
        let map = FieldMap::of(&shown, Shown::Component(0), "stress [MPa]")
            .range(0.0, 20.0)
            .without_lines()
            .levels(8)
            .window([-12.2, 12.2], [-30.4, -18.8])
            .size(200.0, 97.0)
            .length_unit("cm")
            .title(&format!("optimum, {}", wheel.name));
        panel = panel.picture(&map)?;
    }
    for (label, is_work) in [("W − mean [N cm²]", true), ("∫p − mean [MPa cm]", false)] {
        let mut plot = LinePlot::new()
            .x_axis("way [sectors]", Scale::Linear)
            .y_axis(label, Scale::Linear)
            .grid()
            .size(230.0, 160.0);
        for wheel in rolled {
            let values = if is_work { &wheel.work } else { &wheel.reaction };
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            // A sector ends as it begins.
            let places = (0..values.len()).chain([0]);
            let deviations: Vec<f64> = places.map(|place| values[place] - mean).collect();
            let angles: Vec<f64> = wheel.angles.iter().copied().chain([wheel.angles[0] + 1.0]).collect();
            plot = plot.curve(Curve::new(&wheel.name, &angles, &deviations).without_markers());
        }
        panel = panel.picture(&plot)?;
    }
    Ok(panel.draw()?)
}

/// A wheel that rolls by one sector, which is then repeated: in each frame the room is seen from the hub.
pub fn write_animation(judge: &Wheel, rolled: &Rolled, path: &Path) -> Result<(), Failure> {
    let pieces = rolled.body.body()?;
    let width = TAU * OUTER_RADIUS / HOLES as f64;
    let mut animation = Animation::new(0.1);
    for (place, position) in rolled.pressed.positions.iter().enumerate() {
        let turn = rolled.angles[place];
        let back = Ground { angle: -turn * TAU / HOLES as f64, distance: OBSTACLE_DEPTH };
        let u = pieces.field(&position.u)?;
        // Nodes as the room sees them, less where they are drawn from.
        let moved = u.space().positions().iter().zip(u.values().chunks_exact(2)).flat_map(|(x, u)| {
            let [first, second] = back.seen([x[0] + u[0], x[1] + u[1]]);
            [first - x[0], second - x[1]]
        });
        let moved = Field::from_values(u.space(), moved.collect())?;
        let stress = pieces.field(&judge.mises(&rolled.pressed, position)?)?;
        let (left, right) = (-15.5, 15.5);
        let mut map = FieldMap::of(&stress, Shown::Component(0), "stress [MPa]")
            .deformed(&moved, 1.0)
            .range(0.0, 20.0)
            .without_lines()
            .without_axes()
            .levels(8)
            .window([left, right], [-OUTER_RADIUS - 1.2, -INNER_RADIUS + 2.0])
            .size(240.0, 102.0)
            .line(&[[left, -OBSTACLE_DEPTH], [right, -OBSTACLE_DEPTH]], "", Colour::BLACK);
        // Marks of the ground, which goes back below the hub.
        for mark in -2..=3 {
            let x = width * (f64::from(mark) - turn);
            map = map.line(&[[x, -OBSTACLE_DEPTH], [x - 0.6, -OBSTACLE_DEPTH - 0.8]], "", Colour::BLACK);
        }
        animation = animation.frame(&map)?;
    }
    Ok(animation.write_png_at(path, 90.0)?)
}
