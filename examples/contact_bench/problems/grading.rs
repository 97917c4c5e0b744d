//! Spacing of nodes that are dense near a contact.

/// The place on \[0, far\] at a part of the way: half of the cells are equal up to `near`, and the others grow by one factor from cell to cell.
pub fn graded(part: f64, near: f64, far: f64) -> f64 {
    match part <= 0.5 {
        true => 2.0 * part * near,
        false => near * (far / near).powf(2.0 * part - 1.0),
    }
}
