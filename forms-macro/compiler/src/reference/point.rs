//! Everything that a form can read at one point.

/// A field at a point: entry `m` holds the derivatives of order m, row-major with the component first
/// (`components × Dᵐ` numbers).
pub type Jet = Vec<Vec<f64>>;

/// Data at a point, chosen freely: nothing needs to come from a mesh.
#[derive(Clone, Debug)]
pub struct Point {
    /// Per field of the form.
    pub fields: Vec<Jet>,
    /// Per member of the data struct; empty for members that are fields.
    pub parameters: Vec<Vec<f64>>,
    pub position: Vec<f64>,
    pub normal: Vec<f64>,
    pub curvature: f64,
    pub diameter: f64,
    pub cell_volume: f64,
    pub facet_area: f64,
}
