//! Spacing of nodes that are dense near a contact.

/// The place on \[0, far\] at a part of the way: half of the cells are equal up to `near`, and the others grow by one factor from cell to cell.
pub fn graded(part: f64, near: f64, far: f64) -> f64 {
    match part <= 0.5 {
        true => 2.0 * part * near,
        false => near * (far / near).powf(2.0 * part - 1.0),
    }
}

/// The height over a surface at a part t of the way up from the depth 1, where the surface is inside of the uppermost row of cells, at another height of each
/// cell.
pub fn crossed(across: f64, t: f64, rows: usize) -> f64 {
    let (cell, depth) = (1.0 / rows as f64, 1.0 - t);
    let near = (-depth / (4.0 * cell)).exp();
    t * cell * (0.5 + 0.4 * near * (29.0 * across).sin()) - depth
}
