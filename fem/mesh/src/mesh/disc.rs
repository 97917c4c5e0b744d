//! A disc, or a half or quarter of it: a rounded square inside, and layers from its sides to the circle.

use super::blocks::{BlockNode, Blocks};
use super::generators::check;
use super::{Mesh, MeshError};
use crate::element::CellShape;

/// Half the side of the inner square, of the square that is mapped to the whole disc: its corners come to 0.66 of the radius.
const CORE: f64 = 0.5;

/// A disc around the origin, or the part of it where each coordinate that `cut` names is not negative: `[false; 2]` the disc,
/// `[false, true]` its upper half, `[true; 2]` a quarter. Quadrilaterals, or triangles (two per quadrilateral); second-order cells
/// are curved. All nodes of the circle, mid-side nodes too, lie on it.
///
/// `core` is the number of quadrilaterals along half a side of the inner square, `layers` that from its sides to the circle: the
/// whole disc has 4 `core`² + 8 `core` `layers` quadrilaterals, and 8 `core` facets on the circle. Facet regions: circle, and the
/// flat sides as those of a rectangle, left (x = 0), bottom (y = 0). [`half_disc`] is the lower half.
///
/// ```
/// # use forms_mesh as forms_fem;
/// use forms_fem::element::CellShape;
/// use forms_fem::mesh::disc;
///
/// // A quarter of a disc of radius 2: 3² quadrilaterals inside, two layers of 6 around them.
/// let quarter = disc(2.0, [true, true], 3, 2, CellShape::Quadrilateral, 2)?;
/// assert_eq!(quarter.cell_count(), 9 + 2 * 6);
/// assert_eq!(quarter.facet_region("circle")?.len(), 6);
/// assert_eq!(quarter.facet_region("left")?.len(), quarter.facet_region("bottom")?.len());
/// # Ok::<(), forms_fem::mesh::MeshError>(())
/// ```
///
/// # Errors
/// [`MeshError::Parameter`] unless `radius` is finite and positive, `core` and `layers` from 1 to 1000; a shape that is not plane,
/// a degree that does not exist.
pub fn disc(
    radius: f64,
    cut: [bool; 2],
    core: usize,
    layers: usize,
    shape: CellShape,
    degree: usize,
) -> Result<Mesh<2>, MeshError> {
    let [left, bottom] = [(2, "left"), (4, "bottom")];
    let flat = [left, bottom].into_iter().zip(cut).filter(|(_, cut)| *cut).map(|(side, _)| side);
    let surfaces: Vec<(u8, &str)> = std::iter::once((1, "circle")).chain(flat).collect();
    part_of_disc([radius; 2], cut, [core, layers], (shape, degree), &surfaces)
}

/// The lower half of a disc around the origin, y ≤ 0, which is pressed on what lies below. Quadrilaterals, or triangles (two per
/// quadrilateral); second-order cells are curved. All nodes of the circle, mid-side nodes too, lie on it.
///
/// `core` is the number of quadrilaterals along half a side of the inner square, `layers` that from its sides to the circle, as in
/// [`disc`]. Facet regions: circle, top (y = 0). The lowest point, (0, −`radius`), is a node.
///
/// ```
/// # use forms_mesh as forms_fem;
/// use forms_fem::element::CellShape;
/// use forms_fem::mesh::half_disc;
///
/// let punch = half_disc(1.0, 4, 3, CellShape::Triangle, 2)?;
/// assert_eq!(punch.cell_count(), 2 * (2 * 16 + 4 * 4 * 3));
/// assert_eq!(punch.facet_region("circle")?.len(), 16);
/// assert_eq!(punch.facet_region("top")?.len(), 2 * (4 + 3));
/// assert!(punch.nodes().contains(&[0.0, -1.0]));
/// # Ok::<(), forms_fem::mesh::MeshError>(())
/// ```
///
/// # Errors
/// As [`disc`].
pub fn half_disc(
    radius: f64,
    core: usize,
    layers: usize,
    shape: CellShape,
    degree: usize,
) -> Result<Mesh<2>, MeshError> {
    // The upper half, turned by half a turn.
    let surfaces = [(1, "circle"), (4, "top")];
    part_of_disc([radius, -radius], [false, true], [core, layers], (shape, degree), &surfaces)
}

/// A part of the disc of radius `radius`, with coordinates times `factor`, which is the radius or its negative.
fn part_of_disc(
    [radius, factor]: [f64; 2],
    cut: [bool; 2],
    [core, layers]: [usize; 2],
    (shape, degree): (CellShape, usize),
    surfaces: &[(u8, &str)],
) -> Result<Mesh<2>, MeshError> {
    check(radius.is_finite() && radius > 0.0, "radius", &radius, "it must be finite and positive")?;
    let most = 1000;
    check((1..=most).contains(&core), "core", &core, "from 1 to 1000 cells along half a side")?;
    check((1..=most).contains(&layers), "layers", &layers, "from 1 to 1000 layers")?;
    if shape.dimension() != 2 {
        return Err(MeshError::Dimension { shape, dimension: 2 });
    }
    let mut blocks = Blocks::new(CellShape::Quadrilateral, degree)?;
    // Steps of the square's lattice run from -half to half, or from 0 where it is cut.
    let half = (core * degree) as i64;
    let outer = layers * degree;
    let node = |place: [i64; 2], layer: usize| {
        let u = place.map(|step| step as f64 / half as f64);
        let flat = (0..2).filter(|&k| cut[k] && place[k] == 0).map(|k| 2 << k).sum::<u8>();
        let t = layer as f64 / outer as f64;
        BlockNode {
            key: (place, layer),
            // Zeros have no sign.
            position: position(u, t).map(|x| factor * x + 0.0),
            surfaces: flat | u8::from(layer == outer),
        }
    };
    let starts = |k: usize| (if cut[k] { 0 } else { -half }..half).step_by(degree);
    for y in starts(1) {
        for x in starts(0) {
            blocks.add_cell(|steps| node([x + steps[0] as i64, y + steps[1] as i64], 0));
        }
    }
    for (normal, is_cut) in cut.into_iter().enumerate() {
        let along = 1 - normal;
        for side in [-half, half] {
            if side < 0 && is_cut {
                continue;
            }
            // Outward and then counter-clockwise, so that cells are not inverted.
            let counter_clockwise = (side > 0) == (normal == 0);
            for layer in (0..outer).step_by(degree) {
                for start in starts(along) {
                    blocks.add_cell(|[out, step]| {
                        let mut place = [side; 2];
                        let step = if counter_clockwise { step } else { degree - step };
                        place[along] = start + step as i64;
                        node(place, layer + out)
                    });
                }
            }
        }
    }
    let mesh = blocks.mesh(surfaces)?;
    if shape == CellShape::Triangle { mesh.simplices() } else { Ok(mesh) }
}

// The place in the unit disc of a point u of the square [-1, 1]² (t = 0), or between a point of its boundary and the circle.
fn position(u: [f64; 2], t: f64) -> [f64; 2] {
    let inside = square_to_disc(u.map(|x| CORE * x));
    if t == 0.0 {
        return inside;
    }
    let outside = square_to_disc(u);
    // It is 1 but for round-off.
    let length = outside[0].hypot(outside[1]);
    std::array::from_fn(|k| (1.0 - t) * inside[k] + t * outside[k] / length)
}

// A smooth map that takes the boundary of the square [-1, 1]² to the unit circle, and the axes to themselves.
fn square_to_disc([x, y]: [f64; 2]) -> [f64; 2] {
    [x * (1.0 - 0.5 * y * y).sqrt(), y * (1.0 - 0.5 * x * x).sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::measures::{close, surface, volume};

    #[test]
    fn parts_of_a_disc() -> Result<(), MeshError> {
        let parts = [[false; 2], [true, false], [false, true], [true; 2]];
        for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
            let per_block = if shape == CellShape::Triangle { 2 } else { 1 };
            for cut in parts {
                let fraction = 0.5_f64.powi(cut.iter().filter(|cut| **cut).count() as i32);
                let mesh = disc(2.0, cut, 3, 2, shape, 2)?;
                assert_eq!(mesh.cell_count(), ((36 + 48) as f64 * fraction) as usize * per_block);
                let exact = 4.0 * std::f64::consts::PI * fraction;
                close(volume(&mesh) / exact, 1.0, 1e-4);
                close(surface(&mesh, "circle")?.0 / exact, 1.0, 1e-4);
                close(surface(&mesh, "boundary")?.1, 2.0 * volume(&mesh), 1e-12);
                for (k, name) in ["left", "bottom"].into_iter().enumerate() {
                    assert_eq!(mesh.facet_region(name).is_ok(), cut[k]);
                    let facets = mesh.facet_region(name).unwrap_or_default();
                    assert!(facets.iter().all(|facet| mesh.facet_centre(*facet)[k].abs() < 1e-15));
                }
                check_circle(&mesh, 2.0)?;
            }
        }
        Ok(())
    }

    fn check_circle(mesh: &Mesh<2>, radius: f64) -> Result<(), MeshError> {
        for facet in mesh.facet_region("circle")? {
            let nodes = mesh.cell(facet.cell as usize);
            for local in mesh.cell_element(facet.cell as usize).facet_nodes(usize::from(facet.local)) {
                let [x, y] = mesh.nodes()[nodes[local] as usize];
                assert!((x.hypot(y) - radius).abs() < 4e-16 * radius);
            }
        }
        Ok(())
    }

    #[test]
    fn half_discs_lie_below() -> Result<(), MeshError> {
        for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
            for degree in 1..=2 {
                let mesh = half_disc(3.0, 2, 1, shape, degree)?;
                assert!(mesh.nodes().iter().all(|[_, y]| *y <= 0.0));
                assert!(mesh.nodes().contains(&[0.0, -3.0]));
                let (top, flux) = surface(&mesh, "top")?;
                close(top, 6.0, 1e-14);
                close(flux, 0.0, 1e-14);
                check_circle(&mesh, 3.0)?;
                let named = mesh.facet_region("top")?.len() + mesh.facet_region("circle")?.len();
                assert_eq!(named, mesh.boundary_facets().len());
            }
        }
        Ok(())
    }

    #[test]
    fn areas_converge() -> Result<(), MeshError> {
        for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
            for (degree, order) in [(1, 2.0), (2, 4.0)] {
                let error = |n| -> Result<f64, MeshError> {
                    Ok((volume(&disc(1.0, [false; 2], n, n, shape, degree)?) - std::f64::consts::PI).abs())
                };
                let rate = (error(4)? / error(8)?).log2();
                assert!((rate - order).abs() < 0.2, "{shape:?} {degree}: order {rate}");
            }
        }
        Ok(())
    }

    #[test]
    fn cells_are_well_shaped() -> Result<(), MeshError> {
        for n in 1..=4 {
            for (shape, least) in [(CellShape::Quadrilateral, 0.45), (CellShape::Triangle, 0.2)] {
                let quality = disc(1.0, [false; 2], n, n, shape, 2)?.quality();
                assert!(quality.scaled_jacobian()[0] > least, "{n}: {quality}");
            }
        }
        Ok(())
    }

    #[test]
    fn parameters_are_named() {
        let message = |radius, core, layers, shape| {
            half_disc(radius, core, layers, shape, 1).err().map(|error| error.to_string()).unwrap_or_default()
        };
        let quadrilateral = CellShape::Quadrilateral;
        assert_eq!(
            message(f64::NAN, 1, 1, quadrilateral),
            "radius = NaN is not possible: it must be finite and positive"
        );
        assert!(message(1.0, 0, 1, quadrilateral).starts_with("core = 0 is not possible"));
        assert!(message(1.0, 1, 1001, quadrilateral).starts_with("layers = 1001 is not possible"));
        assert!(message(1.0, 1, 1, CellShape::Hexahedron).starts_with("a mesh of hexahedron cells"));
        assert!(disc(1.0, [true; 2], 1, 1, quadrilateral, 3).is_err());
    }
}
