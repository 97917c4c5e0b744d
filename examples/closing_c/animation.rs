//! The optimisation as an animation, and then the found body as the pad closes the C.

use std::error::Error;

use forms_fem::output::picture::{Animation, FieldMap};
use forms_fem::prelude::*;

use crate::design::{Closing, LOWER, UPPER, WAY};
use crate::pairs::Pressed;

/// Seconds of a frame, and the number of frames for which the last one stays.
const SECONDS: f64 = 0.4;
const LAST: usize = 3;
/// Steps of the pad from frame to frame.
const APART: usize = 2;

/// An iterate.
pub struct Frame {
    pub number: usize,
    /// ρ.
    pub density: Field<2>,
    pub u: Field<2>,
}

/// Densities on the deformed mesh.
pub fn densities<'a>(c: &Closing, density: &'a Field<2>, u: &'a Field<2>) -> FieldMap<'a> {
    let heights: Vec<f64> = (0..c.mesh().cell_count()).map(|cell| c.mesh().cell_centre(cell)[1]).collect();
    let value = move |cell: usize, reference: &[f64; 2]| match heights[cell] {
        y if y < LOWER => density.evaluate_in(cell, reference)[0],
        y => f64::from(y > UPPER),
    };
    FieldMap::cell_by_cell(u.space().mesh(), value, "ρ").deformed(u, 1.0).range(0.0, 1.0).without_mesh_lines()
}

/// A frame of either kind.
fn framed<'a>(map: FieldMap<'a>, title: &str) -> FieldMap<'a> {
    map.levels(4).without_axes().window([-0.04, 1.04], [-0.14, 0.53]).size(230.0, 143.0).title(title)
}

/// Writes iterates, and then the bodies with contact pairs as the pad presses them.
pub fn write(c: &Closing, iterates: &[Frame], pressed: &Pressed) -> Result<(), Box<dyn Error>> {
    let mut animation = Animation::new(SECONDS);
    for Frame { number, density, u } in iterates {
        let map = densities(c, density, u);
        animation = animation.frame(&framed(map, &format!("iteration {number}")))?;
    }
    let last = pressed.states.last().into_iter().cycle().take(LAST);
    for (way, u) in pressed.states.iter().step_by(APART).chain(last) {
        let map = FieldMap::cell_by_cell(u.space().mesh(), |_, _| 1.0, "ρ").deformed(u, 1.0);
        let title = format!("with contact pairs, {:.0} % of the way", 100.0 * way / WAY);
        animation = animation.frame(&framed(map.range(0.0, 1.0).without_mesh_lines(), &title))?;
    }
    Ok(animation.write_png_at("out/closing_c_animation.png", 80.0)?)
}
