//! A ball, or a half, quarter or eighth of it: a rounded cube inside, and layers from its faces to the sphere.

use super::blocks::{BlockNode, Blocks};
use super::generators::check;
use super::{Mesh, MeshError};
use crate::element::CellShape;

/// Half the edge of the inner cube, of the cube that is mapped to the whole ball: its corners come to 0.76 of the radius.
const CORE: f64 = 0.5;

/// A ball around the origin, or the part of it where each coordinate that `cut` names is not negative: `[false; 3]` the
/// ball, `[false, false, true]` its upper half, `[true; 3]` an eighth. Hexahedra, or tetrahedra (six per hexahedron);
/// second-order cells are curved. All nodes of the surface, mid-side and face nodes too, lie on the sphere.
///
/// `core` is the number of hexahedra along half an edge of the inner cube, `layers` that from its faces to the sphere: the whole ball
/// has 8 `core`³ + 24 `core`² `layers` hexahedra, and 24 `core`² facets on the sphere. The cube takes up about half of the radius.
/// Facet regions: sphere, and the flat faces that `cut` makes as those of a box, left (x = 0), front (y = 0), bottom (z = 0).
///
/// ```
/// # use forms_mesh as forms_fem;
/// use forms_fem::element::CellShape;
/// use forms_fem::mesh::ball;
///
/// // A quarter of a ball of radius 3, where x and z are not negative.
/// let quarter = ball(3.0, [true, false, true], 2, 1, CellShape::Hexahedron, 2)?;
/// assert_eq!(quarter.cell_count(), (8 * 8 + 24 * 4) / 4);
/// assert_eq!(quarter.facet_region("sphere")?.len(), 24 * 4 / 4);
/// assert!(quarter.facet_region("left").is_ok() && quarter.facet_region("bottom").is_ok());
/// // There is no cut at y = 0.
/// assert!(quarter.facet_region("front").is_err());
/// # Ok::<(), forms_fem::mesh::MeshError>(())
/// ```
///
/// # Errors
/// [`MeshError::Parameter`] unless `radius` is positive, `core` ≥ 1 and `layers` ≥ 1; a shape that is not in space, a
/// degree that does not exist; [`MeshError::TooLarge`].
#[inline]
pub fn ball(
    radius: f64,
    cut: [bool; 3],
    core: usize,
    layers: usize,
    shape: CellShape,
    degree: usize,
) -> Result<Mesh<3>, MeshError> {
    check(radius.is_finite() && radius > 0.0, "radius", &radius, "it must be finite and positive")?;
    let most = 1000;
    check((1..=most).contains(&core), "core", &core, "from 1 to 1000 cells along half an edge")?;
    check((1..=most).contains(&layers), "layers", &layers, "from 1 to 1000 layers")?;
    if shape.dimension() != 3 {
        return Err(MeshError::Dimension { shape, dimension: 3 });
    }
    let mut blocks = Blocks::new(CellShape::Hexahedron, degree)?;
    if nodes_at_most(cut, core * degree, layers * degree) > u64::from(u32::MAX) {
        return Err(MeshError::TooLarge { what: "nodes" });
    }
    // Steps of the cube's lattice run from -half to half, or from 0 where it is cut.
    let half = (core * degree) as i64;
    let outer = layers * degree;
    let node = |place: [i64; 3], layer: usize| {
        let u = place.map(|step| step as f64 / half as f64);
        let flat = (0..3).filter(|&k| cut[k] && place[k] == 0).map(|k| 2 << k).sum::<u8>();
        let t = layer as f64 / outer as f64;
        BlockNode {
            key: (place, layer),
            position: position(u, t).map(|x| radius * x),
            surfaces: flat | u8::from(layer == outer),
        }
    };
    let starts = |k: usize| (if cut[k] { 0 } else { -half }..half).step_by(degree);
    for z in starts(2) {
        for y in starts(1) {
            for x in starts(0) {
                blocks.add_cell(|steps| {
                    node([x + steps[0] as i64, y + steps[1] as i64, z + steps[2] as i64], 0)
                });
            }
        }
    }
    for (normal, is_cut) in cut.into_iter().enumerate() {
        for side in [-half, half] {
            if side < 0 && is_cut {
                continue;
            }
            // With the outward direction third, the other two run so that cells are not inverted.
            let mut axes = [(normal + 1) % 3, (normal + 2) % 3];
            if side < 0 {
                axes.reverse();
            }
            for layer in (0..outer).step_by(degree) {
                for b in starts(axes[1]) {
                    for a in starts(axes[0]) {
                        blocks.add_cell(|steps| {
                            let mut place = [side; 3];
                            place[axes[0]] = a + steps[0] as i64;
                            place[axes[1]] = b + steps[1] as i64;
                            node(place, layer + steps[2])
                        });
                    }
                }
            }
        }
    }
    let flat = ["left", "front", "bottom"].into_iter().enumerate().filter(|(k, _)| cut[*k]);
    let surfaces: Vec<(u8, &str)> =
        std::iter::once((1, "sphere")).chain(flat.map(|(k, n)| (2 << k, n))).collect();
    let mesh = blocks.mesh(&surfaces)?;
    if shape == CellShape::Tetrahedron { mesh.simplices() } else { Ok(mesh) }
}

/// Nodes of the inner cube and of the layers on its faces, those where they meet counted twice; half an edge of the cube has
/// `half` steps.
fn nodes_at_most(cut: [bool; 3], half: usize, layers: usize) -> u64 {
    let along = cut.map(|cut| (if cut { half } else { 2 * half }) as u64 + 1);
    let faces = (0..3).map(|k| {
        let sides = if cut[k] { 1 } else { 2 };
        sides * along[(k + 1) % 3] * along[(k + 2) % 3] * layers as u64
    });
    along.iter().product::<u64>() + faces.sum::<u64>()
}

// The place in the unit ball of a point u of the cube [-1, 1]³ (t = 0), or between a point of its surface and the sphere.
fn position(u: [f64; 3], t: f64) -> [f64; 3] {
    let inside = cube_to_ball(u.map(|x| CORE * x));
    if t == 0.0 {
        return inside;
    }
    let outside = cube_to_ball(u);
    // It is 1 except for round-off.
    let length = outside.iter().map(|x| x * x).sum::<f64>().sqrt();
    std::array::from_fn(|k| (1.0 - t) * inside[k] + t * outside[k] / length)
}

// A smooth map that takes the surface of the cube [-1, 1]³ to the unit sphere, and coordinate planes to themselves.
fn cube_to_ball(u: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| {
        let (a, b) = (u[(k + 1) % 3].powi(2), u[(k + 2) % 3].powi(2));
        u[k] * (1.0 - 0.5 * (a + b) + a * b / 3.0).sqrt()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::measures::{close, surface, volume};
    use crate::mesh::{Surface, onto_sphere};

    const PARTS: [[bool; 3]; 4] = [[false; 3], [false, false, true], [true, false, true], [true; 3]];

    /// Counts that are allowed one by one are too many together: the numbers of nodes would begin again at 0.
    #[test]
    fn too_many_nodes_are_refused_before_they_are_made() {
        let too_many = |core, layers| ball(1.0, [false; 3], core, layers, CellShape::Hexahedron, 2).err();
        assert_eq!(too_many(1000, 1), Some(MeshError::TooLarge { what: "nodes" }));
        assert_eq!(too_many(500, 500), Some(MeshError::TooLarge { what: "nodes" }));
        // The estimate is an upper bound.
        for cut in PARTS {
            let mesh = ball(1.0, cut, 2, 3, CellShape::Hexahedron, 2).expect("a small ball");
            assert!(nodes_at_most(cut, 4, 6) >= mesh.node_count() as u64);
        }
    }

    #[test]
    fn parts_of_a_ball() -> Result<(), MeshError> {
        for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
            let per_block = if shape == CellShape::Hexahedron { 1 } else { 6 };
            for (index, cut) in PARTS.into_iter().enumerate() {
                let fraction = 0.5_f64.powi(index as i32);
                let mesh = ball(2.0, cut, 2, 2, shape, 2)?;
                // 8 cubes of 2³ inside; 24 faces of 2² with 2 layers.
                assert_eq!(mesh.cell_count(), (64 + 6 * 16 * 2) / (1 << index) * per_block);
                let exact = fraction * 4.0 / 3.0 * std::f64::consts::PI * 8.0;
                close(volume(&mesh) / exact, 1.0, 1e-3);
                let (area, _) = surface(&mesh, "sphere")?;
                close(area / (fraction * 16.0 * std::f64::consts::PI), 1.0, 2e-3);
                let nodes = |region: &str| -> Result<Vec<[f64; 3]>, MeshError> {
                    let facets = mesh.facet_region(region)?.iter();
                    let nodes = facets.flat_map(|facet| {
                        let nodes = mesh.cell(facet.cell as usize);
                        let local =
                            mesh.cell_element(facet.cell as usize).facet_nodes(usize::from(facet.local));
                        local.into_iter().map(|node| mesh.nodes()[nodes[node] as usize]).collect::<Vec<_>>()
                    });
                    Ok(nodes.collect())
                };
                for x in nodes("sphere")? {
                    assert!((x[0].hypot(x[1]).hypot(x[2]) - 2.0).abs() < 2e-15);
                }
                let mut count = mesh.facet_region("sphere")?.len();
                for (k, name) in ["left", "front", "bottom"].into_iter().enumerate() {
                    assert_eq!(mesh.facet_region(name).is_ok(), cut[k]);
                    if cut[k] {
                        assert!(nodes(name)?.iter().all(|x| x[k] == 0.0));
                        count += mesh.facet_region(name)?.len();
                    }
                }
                assert_eq!(count, mesh.boundary_facets().len());
                let flux = surface(&mesh, "boundary")?.1;
                close(flux, 3.0 * volume(&mesh), 1e-12);
            }
        }
        Ok(())
    }

    #[test]
    fn volumes_converge() -> Result<(), MeshError> {
        let exact = std::f64::consts::PI / 6.0;
        for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
            for (degree, order) in [(1, 2.0), (2, 4.0)] {
                let error = |mesh: &Mesh<3>| (volume(mesh) - exact).abs();
                let finer = error(&ball(1.0, [true; 3], 4, 4, shape, degree)?);
                let rate = (error(&ball(1.0, [true; 3], 2, 2, shape, degree)?) / finer).log2();
                assert!((rate - order).abs() < 0.2, "{shape:?} {degree}: order {rate}");
                // The same by refinement, with the nodes moved onto the sphere.
                let onto = onto_sphere([0.0; 3], 1.0);
                let surfaces: [Surface<3>; 1] = [("sphere", &onto)];
                let once = ball(1.0, [true; 3], 1, 1, shape, degree)?.refined_onto(&surfaces)?;
                let twice = once.refined_onto(&surfaces)?;
                let rate = (error(&once) / error(&twice)).log2();
                assert!((rate - order).abs() < 0.3, "refined {shape:?} {degree}: order {rate}");
                assert_eq!(twice.facet_region("left")?.len(), once.facet_region("left")?.len() * 4);
            }
        }
        Ok(())
    }

    #[test]
    fn cells_are_well_shaped() -> Result<(), MeshError> {
        for n in 1..=4 {
            let quality = ball(1.0, [true; 3], n, n, CellShape::Hexahedron, 2)?.quality();
            assert!(quality.scaled_jacobian()[0] > 0.35, "{n}: {quality}");
            let quality = ball(1.0, [true; 3], n, n, CellShape::Tetrahedron, 2)?.quality();
            assert!(quality.scaled_jacobian()[0] > 0.1, "{n}: {quality}");
        }
        Ok(())
    }

    #[test]
    fn parameters_are_named() {
        let hexahedron = CellShape::Hexahedron;
        let message = |radius, core, layers, shape| {
            ball(radius, [true; 3], core, layers, shape, 1)
                .err()
                .map(|error| error.to_string())
                .unwrap_or_default()
        };
        assert_eq!(
            message(-1.0, 1, 1, hexahedron),
            "radius = -1.0 is not possible: it must be finite and positive"
        );
        assert!(message(1.0, 0, 1, hexahedron).starts_with("core = 0 is not possible"));
        assert!(message(1.0, 1, 0, hexahedron).starts_with("layers = 0 is not possible"));
        assert!(message(1.0, 1, 1, CellShape::Triangle).starts_with("a mesh of triangle cells"));
        assert!(ball(1.0, [true; 3], 1, 1, hexahedron, 3).is_err());
    }
}
