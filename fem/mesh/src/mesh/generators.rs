//! Ready meshes: rectangle, box, annulus, hollow cylinder.

use super::{Grid, Mesh, MeshError, structured};
use crate::element::CellShape;

/// A rectangle \[length\] of quadrilaterals, or of triangles (each block split along its rising diagonal).
/// Facet regions: left, right, bottom, top.
///
/// ```
/// # use forms_mesh as forms_fem;
/// # use forms_fem::element::CellShape;
/// # use forms_fem::mesh::rectangle;
/// // 4 × 2 blocks of two triangles each, on [0, 2] × [0, 1].
/// let mesh = rectangle([0.0, 0.0], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
/// assert_eq!((mesh.cell_count(), mesh.facet_region("left")?.len()), (16, 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`MeshError::Parameter`] unless `lower` < `upper` and all divisions are at least 1; a shape that is not
/// plane, a degree that does not exist.
pub fn rectangle(
    lower: [f64; 2],
    upper: [f64; 2],
    divisions: [usize; 2],
    shape: CellShape,
    degree: usize,
) -> Result<Mesh<2>, MeshError> {
    straight(lower, upper, divisions, shape, degree)
}

/// A box \[length\] of hexahedra, or of tetrahedra (six per block). Facet regions: left, right (x), front,
/// back (y), bottom, top (z).
///
/// ```
/// # use forms_mesh as forms_fem;
/// # use forms_fem::element::CellShape;
/// # use forms_fem::mesh::cuboid;
/// let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2], CellShape::Hexahedron, 1)?;
/// assert_eq!(mesh.cell_count(), 16);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`rectangle`], with a shape in space.
#[inline]
pub fn cuboid(
    lower: [f64; 3],
    upper: [f64; 3],
    divisions: [usize; 3],
    shape: CellShape,
    degree: usize,
) -> Result<Mesh<3>, MeshError> {
    straight(lower, upper, divisions, shape, degree)
}

fn straight<const D: usize>(
    lower: [f64; D],
    upper: [f64; D],
    divisions: [usize; D],
    shape: CellShape,
    degree: usize,
) -> Result<Mesh<D>, MeshError> {
    structured(divisions, shape, degree, straight_map(lower, upper)?)
}

/// The map from the unit square or cube to a rectangle or box.
///
/// # Errors
/// [`MeshError::Parameter`] unless `lower` < `upper`.
#[doc(hidden)]
pub fn straight_map<const D: usize>(
    lower: [f64; D],
    upper: [f64; D],
) -> Result<impl Fn([f64; D]) -> [f64; D], MeshError> {
    check(lower.iter().all(|x| x.is_finite()), "lower", &lower, "the corner must be finite")?;
    let above = upper.iter().zip(&lower).all(|(u, l)| u.is_finite() && u > l);
    check(above, "upper", &upper, "each coordinate must be finite and above that of the lower corner")?;
    Ok(move |t: [f64; D]| std::array::from_fn(|k| between(lower[k], upper[k], t[k])))
}

/// An annulus around the origin: a polar grid of `radial` × `around` blocks, quadrilaterals or triangles.
/// All nodes, mid-side and centre nodes too, are uniform in radius and angle, the first at angle 0; those of
/// the boundary lie on the circles. Facet regions: inner, outer.
///
/// # Errors
/// [`MeshError::Parameter`] unless 0 < `inner_radius` < `outer_radius`, `radial` ≥ 1 and `around` ≥ 3; a
/// shape that is not plane, a degree that does not exist.
pub fn annulus(
    inner_radius: f64,
    outer_radius: f64,
    radial: usize,
    around: usize,
    shape: CellShape,
    degree: usize,
) -> Result<Mesh<2>, MeshError> {
    check_wall(inner_radius, outer_radius, radial, around)?;
    let grid = Grid {
        divisions: [radial, around],
        periodic: [false, true],
        sides: [["inner", "outer"], ["", ""]],
        shape,
        degree,
    };
    grid.mesh(|[across, turn]| {
        let radius = between(inner_radius, outer_radius, across);
        direction(turn).map(|component| radius * component)
    })
}

/// A hollow cylinder around the z axis, between z = 0 and z = `height`: the blocks of an [`annulus`], `axial` times above each
/// other, hexahedra or tetrahedra (six per block). All nodes are uniform in radius, angle and height; those of the curved
/// surfaces lie on them. Facet regions: inner, outer, bottom, top.
///
/// # Errors
/// [`MeshError::Parameter`] unless 0 < `inner_radius` < `outer_radius`, 0 < `height`, `radial` ≥ 1, `around` ≥ 3 and `axial` ≥ 1;
/// a shape that is not in space, a degree that does not exist.
#[inline]
pub fn hollow_cylinder(
    inner_radius: f64,
    outer_radius: f64,
    height: f64,
    [radial, around, axial]: [usize; 3],
    shape: CellShape,
    degree: usize,
) -> Result<Mesh<3>, MeshError> {
    check_wall(inner_radius, outer_radius, radial, around)?;
    check(height.is_finite() && height > 0.0, "height", &height, "it must be finite and positive")?;
    check(axial >= 1, "axial", &axial, "at least one cell along the axis")?;
    let grid = Grid {
        divisions: [radial, around, axial],
        periodic: [false, true, false],
        sides: [["inner", "outer"], ["", ""], ["bottom", "top"]],
        shape,
        degree,
    };
    grid.mesh(|[across, turn, along]| {
        let radius = between(inner_radius, outer_radius, across);
        let [x, y] = direction(turn);
        [radius * x, radius * y, between(0.0, height, along)]
    })
}

fn check_wall(inner_radius: f64, outer_radius: f64, radial: usize, around: usize) -> Result<(), MeshError> {
    let inner_is_good = inner_radius.is_finite() && inner_radius > 0.0;
    check(inner_is_good, "inner_radius", &inner_radius, "it must be finite and positive")?;
    let outer_is_good = outer_radius.is_finite() && outer_radius > inner_radius;
    check(outer_is_good, "outer_radius", &outer_radius, "it must be finite and above the inner radius")?;
    check(radial >= 1, "radial", &radial, "at least one cell across the wall")?;
    check(around >= 3, "around", &around, "at least three cells around")
}

// Exact at both ends, which lower + t (upper - lower) is not.
pub(super) fn between(lower: f64, upper: f64, t: f64) -> f64 {
    (1.0 - t) * lower + t * upper
}

// (cos, sin) of 2π · turn for turn in [0, 1), exact at quarter turns.
pub(super) fn direction(turn: f64) -> [f64; 2] {
    let quarters = (4.0 * turn).floor();
    let (sine, cosine) = (std::f64::consts::FRAC_PI_2 * (4.0 * turn - quarters)).sin_cos();
    match quarters as i64 {
        0 => [cosine, sine],
        1 => [-sine, cosine],
        2 => [-cosine, -sine],
        _ => [sine, -cosine],
    }
}

pub(super) fn check(
    good: bool,
    parameter: &'static str,
    value: &impl std::fmt::Debug,
    requirement: &'static str,
) -> Result<(), MeshError> {
    if good {
        return Ok(());
    }
    Err(MeshError::Parameter { parameter, value: format!("{value:?}"), requirement })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::measures::{close, surface, volume};

    #[test]
    fn rectangles() -> Result<(), MeshError> {
        for (shape, factor) in [(CellShape::Quadrilateral, 1), (CellShape::Triangle, 2)] {
            for degree in 1..=2 {
                let mesh = rectangle([1.0, -1.0], [4.0, 1.0], [3, 4], shape, degree)?;
                assert_eq!(mesh.cell_count(), 12 * factor);
                assert_eq!(mesh.node_count(), (3 * degree + 1) * (4 * degree + 1));
                close(volume(&mesh), 6.0, 1e-14);
                let flux =
                    [("left", 2.0, -2.0), ("right", 2.0, 8.0), ("bottom", 3.0, 3.0), ("top", 3.0, 3.0)];
                for (region, length, expected) in flux {
                    let (area, flux) = surface(&mesh, region)?;
                    close(area, length, 1e-14);
                    close(flux, expected, 1e-14);
                }
                close(surface(&mesh, "boundary")?.1, 12.0, 1e-14);
            }
        }
        Ok(())
    }

    #[test]
    fn boxes() -> Result<(), MeshError> {
        for (shape, factor) in [(CellShape::Hexahedron, 1), (CellShape::Tetrahedron, 6)] {
            for degree in 1..=2 {
                let mesh = cuboid([0.0; 3], [1.0, 2.0, 3.0], [1, 2, 3], shape, degree)?;
                assert_eq!(mesh.cell_count(), 6 * factor);
                assert_eq!(mesh.node_count(), (degree + 1) * (2 * degree + 1) * (3 * degree + 1));
                close(volume(&mesh), 6.0, 1e-14);
                let flux = [
                    ("left", 6.0, 0.0),
                    ("right", 6.0, 6.0),
                    ("front", 3.0, 0.0),
                    ("back", 3.0, 6.0),
                    ("bottom", 2.0, 0.0),
                    ("top", 2.0, 6.0),
                ];
                for (region, expected_area, expected) in flux {
                    let (area, flux) = surface(&mesh, region)?;
                    close(area, expected_area, 1e-14);
                    close(flux, expected, 1e-14);
                }
                close(surface(&mesh, "boundary")?.1, 18.0, 1e-14);
            }
        }
        Ok(())
    }

    #[test]
    fn annuli_lie_on_their_circles() -> Result<(), MeshError> {
        for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
            for degree in 1..=2 {
                let mesh = annulus(20.0, 25.0, 2, 12, shape, degree)?;
                assert_eq!(mesh.node_count(), (2 * degree + 1) * 12 * degree);
                let (across, around) = (2 * degree + 1, 12 * degree);
                for (index, node) in mesh.nodes().iter().enumerate() {
                    let radius = 20.0 + 5.0 * (index % across) as f64 / (across - 1) as f64;
                    let angle = std::f64::consts::TAU * (index / across) as f64 / around as f64;
                    // Two units in the last place; the angle here is rounded twice near 2π.
                    assert!((node[0].hypot(node[1]) - radius).abs() < 8e-15);
                    assert!((node[0] - radius * angle.cos()).abs() < 5e-14);
                    assert!((node[1] - radius * angle.sin()).abs() < 5e-14);
                }
                for point in [[25.0, 0.0], [0.0, 25.0], [0.0, -25.0], [-20.0, 0.0]] {
                    assert!(mesh.nodes().contains(&point));
                }
                assert_eq!(mesh.facet_region("inner")?.len(), 12);
                assert_eq!(mesh.facet_region("outer")?.len(), 12);
                assert_eq!(mesh.boundary_facets().len(), 24);
                close(surface(&mesh, "boundary")?.1, 2.0 * volume(&mesh), 1e-12);
            }
        }
        Ok(())
    }

    // Chords: order 2. Parabolas through three points of the circle: order 4.
    #[test]
    fn annulus_geometry_converges() -> Result<(), MeshError> {
        let area = std::f64::consts::PI * (25.0_f64 * 25.0 - 20.0 * 20.0);
        for (degree, order) in [(1, 2.0), (2, 4.0)] {
            let error = |around| -> Result<f64, MeshError> {
                let mesh = annulus(20.0, 25.0, 1, around, CellShape::Quadrilateral, degree)?;
                Ok((volume(&mesh) - area).abs())
            };
            let rate = (error(16)? / error(32)?).log2();
            assert!((rate - order).abs() < 0.1, "degree {degree}: order {rate}");
        }
        Ok(())
    }

    #[test]
    fn hollow_cylinders() -> Result<(), MeshError> {
        let pi = std::f64::consts::PI;
        for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
            for (degree, order) in [(1, 2.0), (2, 4.0)] {
                let mut errors = vec![];
                for around in [8, 16] {
                    let mesh = hollow_cylinder(1.0, 2.0, 3.0, [1, around, 2], shape, degree)?;
                    let per_block = if shape == CellShape::Tetrahedron { 6 } else { 1 };
                    assert_eq!(mesh.cell_count(), 2 * around * per_block);
                    errors.push((volume(&mesh) - 9.0 * pi).abs());
                    close(surface(&mesh, "boundary")?.1, 3.0 * volume(&mesh), 1e-12);
                    let ([bottom, _], [top, flux]) = (
                        <[f64; 2]>::from(surface(&mesh, "bottom")?),
                        <[f64; 2]>::from(surface(&mesh, "top")?),
                    );
                    close(bottom, top, 1e-13);
                    close(flux, 3.0 * top, 1e-13);
                    for (region, radius) in [("inner", 1.0_f64), ("outer", 2.0)] {
                        let area = surface(&mesh, region)?.0;
                        assert!((area / (6.0 * pi * radius) - 1.0).abs() < 0.03, "{region} {area}");
                        for facet in mesh.facet_region(region)? {
                            for node in mesh.cell_element(facet.cell as usize).facet_nodes(facet.local.into())
                            {
                                let x = mesh.nodes()[mesh.cell(facet.cell as usize)[node] as usize];
                                assert!((x[0].hypot(x[1]) - radius).abs() < 1e-15);
                            }
                        }
                    }
                    let named = ["inner", "outer", "bottom", "top"]
                        .map(|name| mesh.facet_region(name).map(<[_]>::len));
                    let count = named.into_iter().sum::<Result<usize, _>>()?;
                    assert_eq!(count, mesh.boundary_facets().len());
                }
                let rate = (errors[0] / errors[1]).log2();
                assert!((rate - order).abs() < 0.15, "{shape:?} {degree}: order {rate}");
            }
        }
        let message = |height, divisions| {
            let mesh = hollow_cylinder(1.0, 2.0, height, divisions, CellShape::Hexahedron, 1);
            mesh.err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert!(message(0.0, [1, 8, 1]).starts_with("height = 0.0 is not possible"));
        assert!(message(1.0, [1, 2, 1]).starts_with("around = 2 is not possible"));
        assert!(message(1.0, [1, 8, 0]).starts_with("axial = 0 is not possible"));
        Ok(())
    }

    #[test]
    fn parameters_are_named() {
        let quadrilateral = CellShape::Quadrilateral;
        let polar = |inner, outer, radial, around| {
            annulus(inner, outer, radial, around, quadrilateral, 2).err().map(|error| error.to_string())
        };
        assert_eq!(polar(20.0, 25.0, 1, 3), None);
        let starts = |message: Option<String>, start: &str| {
            assert!(message.as_ref().is_some_and(|m| m.starts_with(start)), "{message:?}");
        };
        starts(polar(0.0, 25.0, 1, 3), "inner_radius = 0.0 is not possible");
        starts(polar(f64::NAN, 25.0, 1, 3), "inner_radius = NaN is not possible");
        starts(polar(20.0, 20.0, 1, 3), "outer_radius = 20.0 is not possible");
        starts(polar(20.0, 25.0, 0, 3), "radial = 0 is not possible");
        starts(polar(20.0, 25.0, 1, 2), "around = 2 is not possible");
        let plane = |lower, upper, divisions, shape| {
            rectangle(lower, upper, divisions, shape, 1).err().map(|error| error.to_string())
        };
        starts(plane([0.0; 2], [1.0, 0.0], [1, 1], quadrilateral), "upper = [1.0, 0.0] is not possible");
        starts(plane([f64::NAN, 0.0], [1.0; 2], [1, 1], quadrilateral), "lower = [NaN, 0.0] is not possible");
        starts(plane([0.0; 2], [1.0; 2], [1, 0], quadrilateral), "divisions = [1, 0] is not possible");
        starts(plane([0.0; 2], [1.0; 2], [1, 1], CellShape::Hexahedron), "a mesh of hexahedron cells");
        starts(plane([0.0; 2], [1.0; 2], [usize::MAX, 9], quadrilateral), "the mesh has more nodes");
    }

    #[test]
    fn a_user_maps_a_grid() -> Result<(), MeshError> {
        // A quarter of a disc's ring, exactly quadratic in neither coordinate; its area is 3π/4.
        let map = |[s, t]: [f64; 2]| {
            let angle = std::f64::consts::FRAC_PI_2 * t;
            [(1.0 + s) * angle.cos(), (1.0 + s) * angle.sin()]
        };
        let mesh = structured([2, 16], CellShape::Quadrilateral, 2, map)?;
        close(volume(&mesh), 0.75 * std::f64::consts::PI, 2e-7);
        // Swapped coordinates turn the cells inside out.
        let turned = structured([2, 2], CellShape::Triangle, 1, |[s, t]| [t, s]);
        assert!(matches!(turned, Err(MeshError::Inverted { cell: 0, .. })));
        Ok(())
    }
}
