//! A trefoil knot of round wire: its surface as an STL file, and a mesh that is swept along it.

use std::f64::consts::PI;
use std::path::Path;

use forms_fem::element::Lagrange;
use forms_fem::mesh::disc;
use forms_fem::output::{Failure, write_whole};
use forms_fem::prelude::*;

/// The radius of the wire; the knot winds around a ring of radius 2, at a distance of 1 from its middle.
pub const WIRE: f64 = 0.55;
/// The height of the knot's upper side above its middle.
pub const TOP: f64 = 1.0 + WIRE;
/// Half the extent of a box around the knot.
pub const EXTENT: [f64; 3] = [3.6, 3.6, 1.6];

/// A point of the wire's middle, once around at t = 2π.
pub fn middle(t: f64) -> [f64; 3] {
    let radius = 2.0 + (3.0 * t).cos();
    [radius * (2.0 * t).cos(), radius * (2.0 * t).sin(), (3.0 * t).sin()]
}

/// A point of the section at t, by its coordinates there: across in the horizontal plane, and up.
fn point(t: f64, [across, up]: [f64; 2]) -> [f64; 3] {
    let (radius, slope) = (2.0 + (3.0 * t).cos(), -3.0 * (3.0 * t).sin());
    let (sine, cosine) = (2.0 * t).sin_cos();
    // The way along the wire is nowhere vertical.
    let [x, y, z] =
        [slope * cosine - 2.0 * radius * sine, slope * sine + 2.0 * radius * cosine, 3.0 * (3.0 * t).cos()];
    let flat = x.hypot(y);
    let whole = flat.hypot(z);
    let first = [-y / flat, x / flat, 0.0];
    let second = [-z * x / (flat * whole), -z * y / (flat * whole), flat / whole];
    let middle = middle(t);
    [0, 1, 2].map(|k| middle[k] + across * first[k] + up * second[k])
}

/// The surface as a binary STL file of 2 · along · around triangles.
///
/// # Errors
/// A file that cannot be written.
pub fn write_stl(path: &Path, along: usize, around: usize) -> Result<(), Failure> {
    let corner = |i: usize, j: usize| {
        let [t, angle] = [(i, along), (j, around)].map(|(k, n)| 2.0 * PI * (k % n) as f64 / n as f64);
        point(t, [WIRE * angle.cos(), WIRE * angle.sin()]).map(|x| x as f32)
    };
    let mut file = vec![b' '; 80];
    file.extend((2 * along as u32 * around as u32).to_le_bytes());
    for (i, j) in (0..along).flat_map(|i| (0..around).map(move |j| (i, j))) {
        let square = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
        for triangle in [[0, 1, 2], [0, 2, 3]] {
            // No normal: the order of the corners says which side is outside.
            file.extend([0; 12]);
            file.extend(triangle.iter().flat_map(|k| square[*k]).flat_map(f32::to_le_bytes));
            file.extend([0, 0]);
        }
    }
    Ok(write_whole(path, |out| std::io::Write::write_all(out, &file))?)
}

/// The knot as hexahedra of degree 2: a disc of quadrilaterals, swept along the wire.
///
/// # Errors
/// Those of [`disc`] and of the mesh.
pub fn swept(along: usize, cells: usize) -> Result<Mesh<3>, Failure> {
    let section = disc(WIRE, [false; 2], cells, cells, CellShape::Quadrilateral, 2)?;
    let (layers, per_layer) = (2 * along, section.node_count());
    let nodes = (0..layers).flat_map(|layer| {
        let t = 2.0 * PI * layer as f64 / layers as f64;
        section.nodes().iter().map(move |x| point(t, *x))
    });
    let quadrilateral = Lagrange::geometry(CellShape::Quadrilateral, 2)?.node_points::<2>();
    let places: Vec<(usize, usize)> = Lagrange::geometry(CellShape::Hexahedron, 2)?
        .node_points::<3>()
        .iter()
        .filter_map(|x| Some((quadrilateral.iter().position(|y| y[..] == x[..2])?, (2.0 * x[2]) as usize)))
        .collect();
    let mut cells = Vec::new();
    for layer in 0..along {
        for cell in 0..section.cell_count() {
            let nodes = section.cell(cell);
            let number = |(node, step): &(usize, usize)| {
                ((2 * layer + step) % layers * per_layer) as u32 + nodes[*node]
            };
            cells.extend(places.iter().map(number));
        }
    }
    Ok(Mesh::from_parts(CellShape::Hexahedron, 2, nodes.collect(), cells)?)
}
