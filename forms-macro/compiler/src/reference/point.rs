//! Everything that a form can read at one point.

/// A field at a point: entry `m` holds the derivatives of order m, row-major with the component first
/// (`components × Dᵐ` numbers) up to [`ORDERS`]. From [`MEAN`] on come the means of value and gradient over the cell.
pub type Jet = Vec<Vec<f64>>;

/// The highest derivative of a field for which there are numbers.
pub const ORDERS: usize = 3;

/// The entry of a [`Jet`] with the mean of the value; that of the gradient is the next one.
pub const MEAN: usize = ORDERS + 1;

/// Data at a point, chosen freely: nothing needs to come from a mesh.
#[derive(Clone, Debug)]
pub struct Point {
    /// Per side of an interior facet and field of the form. Elsewhere the second side is not read.
    pub fields: [Vec<Jet>; 2],
    /// Per member of the data struct; empty for members that are fields.
    pub parameters: Vec<Vec<f64>>,
    pub position: Vec<f64>,
    pub normal: Vec<f64>,
    pub curvature: f64,
    /// Per side.
    pub diameter: [f64; 2],
    /// Per side.
    pub cell_volume: [f64; 2],
    pub facet_area: f64,
}
