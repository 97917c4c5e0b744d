//! Which cell contains a point, and where: a grid of bounding boxes and Newton's method on the geometry map.

mod affine;
mod boxes;
mod pieces;
mod project;

#[doc(hidden)]
pub use self::affine::AffineInverse;

#[doc(hidden)]
pub use self::boxes::{BoxGrid, Corners, box_around};
#[doc(hidden)]
pub use self::pieces::{PieceTree, long_normal};
#[doc(hidden)]
pub use self::project::nearest_on_facet;

use crate::instantiate;
use crate::mesh::Mesh;
use crate::mesh::small_matrices::inverse;

/// Points this far outside a cell, in reference coordinates, still belong to it.
pub const INSIDE: f64 = 1e-10;

/// The first box in which a nearest cell is looked for is this factor smaller than the tolerance, and each further one larger by the
/// factor [`GROWTH`].
const FIRST_REACH: f64 = 4096.0;
const GROWTH: f64 = 8.0;

/// A search for cells by position.
#[derive(Clone, Debug)]
pub struct Locator<const D: usize> {
    mesh: Mesh<D>,
    /// A box around each cell.
    grid: BoxGrid<D>,
}

/// The cell nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest<const D: usize> {
    /// Cell index.
    pub cell: usize,
    /// The point's reference coordinates in that cell; outside the reference cell when the point is outside
    /// the mesh. Use these to extrapolate.
    pub reference: [f64; D],
    /// The point of the reference cell whose image is nearest; `reference` itself where that lies inside.
    pub clamped: [f64; D],
    /// Distance from the point to the image of `clamped` \[length\].
    pub distance: f64,
}

impl<const D: usize> Locator<D> {
    /// A locator for a mesh; linear in the number of cells.
    #[inline(never)]
    pub fn new(mesh: &Mesh<D>) -> Self {
        let grid = BoxGrid::new(mesh.body_cells().map(|cell| cell_box(mesh, cell)).collect());
        Locator { mesh: mesh.clone(), grid }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh<D> {
        &self.mesh
    }

    /// The cell that contains a point, and the point's reference coordinates; the cell with the lowest index
    /// where several do. A point is inside up to [`INSIDE`] in reference coordinates. `None` outside the
    /// mesh, and for NaN.
    #[inline(never)]
    pub fn find(&self, point: &[f64; D]) -> Option<(usize, [f64; D])> {
        let shape = |cell| self.mesh.cell_shape(cell);
        let search = |invert: &dyn Fn(usize) -> Option<[f64; D]>| {
            self.grid.around(point).find_map(|cell| {
                invert(cell)
                    .filter(|reference| shape(cell).contains(reference, INSIDE))
                    .map(|reference| (cell, reference))
            })
        };
        // The start from the centre nearly always suffices, and the others cost much.
        search(&|cell| self.newton(cell, point, shape(cell).centre())).or_else(|| {
            let more = !self.mesh.is_affine();
            if more { search(&|cell| self.invert(cell, point)) } else { None }
        })
    }

    /// The cells that contain a point at least `margin` away from their boundaries, in reference coordinates.
    #[doc(hidden)]
    pub fn cells_around(&self, point: &[f64; D], margin: f64) -> Vec<usize> {
        let within = |cell: &usize| {
            self.invert(*cell, point)
                .is_some_and(|reference| self.mesh.cell_shape(*cell).contains(&reference, -margin))
        };
        self.grid.around(point).filter(within).collect()
    }

    /// The cell nearest to a point, among those within `tolerance` \[length\]: for points slightly outside,
    /// as between nested meshes of a curved body. `None` when every cell is further away.
    #[inline(never)]
    pub fn find_nearest(&self, point: &[f64; D], tolerance: f64) -> Option<Nearest<D>> {
        if let Some((cell, reference)) = self.find(point) {
            let clamped = self.mesh.cell_shape(cell).clamp(&reference);
            let distance = distance(point, &self.mesh.map(cell, &clamped).0);
            return Some(Nearest { cell, reference, clamped, distance });
        }
        if point.iter().any(|x| !x.is_finite()) || tolerance.is_nan() {
            return None;
        }
        // Where cells are of different sizes the tolerance may reach over thousands of small ones, and the nearest is close by: a first
        // one is looked for in boxes that grow, and then whatever is as near.
        let mut reach = tolerance / FIRST_REACH;
        loop {
            match self.nearest_within(point, reach) {
                Some(found) if found.distance <= reach => return Some(found),
                Some(found) => {
                    let nearest = self.nearest_within(point, found.distance.min(tolerance));
                    return nearest.filter(|nearest| nearest.distance <= tolerance);
                }
                None if reach < tolerance => reach = (GROWTH * reach).min(tolerance),
                None => return None,
            }
        }
    }

    /// The nearest of the cells whose boxes come within a distance, the one with the lowest index where several are.
    fn nearest_within(&self, point: &[f64; D], reach: f64) -> Option<Nearest<D>> {
        let mut best: Option<(usize, [f64; D], f64)> = None;
        for cell in self.grid.meeting(&(point.map(|x| x - reach), point.map(|x| x + reach))) {
            let (clamped, distance) = project::project(&self.mesh, cell, point);
            if best.is_none_or(|best| distance < best.2) {
                best = Some((cell, clamped, distance));
            }
        }
        best.map(|(cell, clamped, distance)| {
            // Where the map has no inverse at the point, there is nothing to extrapolate to.
            let reference = self.invert(cell, point).unwrap_or(clamped);
            Nearest { cell, reference, clamped, distance }
        })
    }

    /// The reference coordinates of a point in a given cell, outside the reference cell where the point is outside the cell;
    /// `None` where the cell's map cannot be inverted there.
    #[doc(hidden)]
    #[inline(never)]
    pub fn reference_in(&self, cell: usize, point: &[f64; D]) -> Option<[f64; D]> {
        self.invert(cell, point)
    }

    /// The inverse of a cell's map where that is affine: for many points of one cell. Its places have the bits of
    /// [`Locator::reference_in`]'s.
    #[doc(hidden)]
    pub fn affine_inverse(&self, cell: usize) -> Option<AffineInverse<D>> {
        AffineInverse::of(&self.mesh, cell)
    }

    // Newton's method with a step bound; the geometry map of a valid cell is close to affine, so it takes
    // few steps. Other starts than the centre serve strongly curved cells.
    fn invert(&self, cell: usize, point: &[f64; D]) -> Option<[f64; D]> {
        let shape = self.mesh.cell_shape(cell);
        let vertices = shape.vertex_points().iter().map(|vertex| std::array::from_fn(|k| vertex[k]));
        let converged = |start| self.newton(cell, point, start);
        let mut outside = None;
        for start in std::iter::once(shape.centre()).chain(vertices) {
            match converged(start) {
                Some(reference) if shape.contains(&reference, INSIDE) => return Some(reference),
                // A quadratic map can take a point outside the cell there too: look on for one inside.
                Some(reference) => outside = outside.or(Some(reference)),
                None => {}
            }
            if self.mesh.is_affine_on(shape) {
                break;
            }
        }
        outside
    }

    fn newton(&self, cell: usize, point: &[f64; D], start: [f64; D]) -> Option<[f64; D]> {
        if self.mesh.is_affine_on(self.mesh.cell_shape(cell)) {
            return self.affine_inverse(cell)?.place(point);
        }
        let mut reference: [f64; D] = start;
        let mut previous = f64::INFINITY;
        for _ in 0..40 {
            let (x, jacobian) = self.mesh.map(cell, &reference);
            let inverse = inverse(&jacobian)?;
            let step: [f64; D] =
                std::array::from_fn(|i| (0..D).map(|j| inverse[i][j] * (point[j] - x[j])).sum());
            let length = step.iter().fold(0.0_f64, |length, s| length.max(s.abs()));
            let factor = 1.0 / length.max(1.0);
            for (coordinate, step) in reference.iter_mut().zip(step) {
                *coordinate += factor * step;
            }
            // Far from the origin, round-off in x keeps the steps from falling below 1e-12.
            if length < 1e-12 || (length < 1e-8 && length >= 0.5 * previous) {
                return Some(reference);
            }
            previous = length;
        }
        None
    }
}

fn cell_box<const D: usize>(mesh: &Mesh<D>, cell: usize) -> Corners<D> {
    let (shape, own) = (mesh.cell_shape(cell), mesh.cell(cell));
    let place = |node: u32| &mesh.nodes()[node as usize];
    if mesh.degree() == 1 || !shape.is_simplex() {
        return box_around(own.iter().map(|&node| place(node)), if mesh.degree() == 2 { 0.5 } else { 0.0 });
    }
    // x = Σ λ_i v_i + Σ 4 λ_i λ_j d_ij with the vertices v and the ways d of the edges' nodes from the middles: in a box around the vertices
    // that is wider by 3/2 of the largest d (4/3 in the plane). Nearly all cells are straight, and theirs are small.
    let vertices = shape.vertices();
    let (mut lower, mut upper) = box_around(own[..vertices].iter().map(|&node| place(node)), 0.0);
    let mut bulge = [0.0_f64; D];
    for (&[a, b], &middle) in shape.edges().iter().zip(&own[vertices..]) {
        let [a, b, middle] = [own[a], own[b], middle].map(place);
        for k in 0..D {
            bulge[k] = bulge[k].max((middle[k] - (a[k] + b[k]) / 2.0).abs());
        }
    }
    for k in 0..D {
        lower[k] -= 1.5 * bulge[k];
        upper[k] += 1.5 * bulge[k];
    }
    (lower, upper)
}

fn distance<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

instantiate!(locate: Locator::<D>::new, Locator::<D>::find, Locator::<D>::find_nearest, Locator::<D>::reference_in);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::{MeshError, annulus, cuboid, structured};
    use crate::quadrature::cell_rule;

    // Every point of every cell is found, at its own place.
    fn check_all<const D: usize>(mesh: Mesh<D>) {
        let locator = Locator::new(&mesh);
        let mut points = cell_rule::<D>(mesh.cell_shape(0), 6).expect("degree 6 exists").points;
        let interior = points.len();
        points.extend(mesh.cell_element(0).node_points::<D>());
        for cell in 0..mesh.cell_count() {
            for (index, point) in points.iter().enumerate() {
                let (x, _) = mesh.map(cell, point);
                let (found, reference) = locator.find(&x).expect("the point is in the mesh");
                assert!(
                    distance(&mesh.map(found, &reference).0, &x) < 1e-13 * (1.0 + distance(&x, &[0.0; D]))
                );
                if index < interior {
                    assert_eq!(found, cell);
                    assert!(distance(&reference, point) < 1e-11);
                }
            }
        }
    }

    #[test]
    fn points_of_all_cells_are_found() -> Result<(), MeshError> {
        for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
            check_all(annulus(20.0, 25.0, 2, 10, shape, 1)?);
            check_all(annulus(20.0, 25.0, 2, 10, shape, 2)?);
            // Strongly curved, and with a hole that the boxes cover.
            check_all(annulus(0.2, 1.0, 3, 4, shape, 2)?);
            let wavy = |[s, t]: [f64; 2]| [10.0 * s, 0.01 * t + 0.3 * (6.0 * s).sin()];
            check_all(structured([12, 2], shape, 2, wavy)?);
        }
        for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
            check_all(cuboid([0.0; 3], [1.0, 2.0, 30.0], [2, 3, 2], shape, 1)?);
            let twist = |[r, s, t]: [f64; 3]| {
                let (sine, cosine) = (0.5 * t).sin_cos();
                [cosine * r - sine * s, sine * r + cosine * s, t + 0.1 * r * s]
            };
            check_all(structured([2, 2, 3], shape, 2, twist)?);
        }
        Ok(())
    }

    // The size of a cell is 1; the coordinates' round-off is about 1e-10 of it.
    #[test]
    fn far_from_the_origin() -> Result<(), MeshError> {
        let shift = 1e6;
        let mesh = structured([3, 3], CellShape::Quadrilateral, 2, |[s, t]| {
            [shift + 3.0 * s + 0.1 * t * t, shift + 3.0 * t]
        })?;
        let locator = Locator::new(&mesh);
        assert_eq!(locator.find(&[shift + 1.4, shift + 1.6]).map(|(cell, _)| cell), Some(4));
        Ok(())
    }

    #[test]
    fn the_boundary_belongs_to_the_mesh() -> Result<(), MeshError> {
        let mesh = annulus(20.0, 25.0, 2, 16, CellShape::Quadrilateral, 2)?;
        let locator = Locator::new(&mesh);
        assert!(locator.find(&[25.0, 0.0]).is_some());
        // The radial size of a cell is 2.5.
        assert!(locator.find(&[25.0 + 2e-10, 0.0]).is_some());
        assert!(locator.find(&[25.0 + 1e-9, 0.0]).is_none());
        assert!(locator.find(&[19.9, 0.0]).is_none());
        assert!(locator.find(&[0.0, 0.0]).is_none());
        assert!(locator.find(&[1e9, 0.0]).is_none());
        assert!(locator.find(&[f64::NAN, 0.0]).is_none());
        Ok(())
    }

    // Between the parabola through three points of the circle and the circle itself.
    #[test]
    fn nested_curved_meshes_find_each_other() -> Result<(), MeshError> {
        let coarse = annulus(20.0, 25.0, 2, 16, CellShape::Quadrilateral, 2)?;
        let fine = annulus(20.0, 25.0, 8, 64, CellShape::Quadrilateral, 2)?;
        let locator = Locator::new(&coarse);
        let mut outside = 0;
        for node in fine.nodes() {
            let nearest = locator.find_nearest(node, 0.01).expect("the meshes differ by less");
            let (x, _) = coarse.map(nearest.cell, &nearest.reference);
            assert!(distance(&x, node) < 1e-12);
            let (inside, _) = coarse.map(nearest.cell, &nearest.clamped);
            assert!((distance(&inside, node) - nearest.distance).abs() < 1e-15);
            assert!(coarse.cell_shape(nearest.cell).contains(&nearest.clamped, 0.0));
            outside += usize::from(nearest.distance > 1e-6);
        }
        assert!(outside > 0);
        assert_eq!(locator.find_nearest(&[26.0, 0.0], 0.99), None);
        let near = locator.find_nearest(&[26.0, 0.0], 1.01).expect("it is 1 away");
        assert!((near.distance - 1.0).abs() < 1e-12);
        assert!((near.clamped[0] - 1.0).abs() < 1e-15 && (near.reference[0] - 1.4).abs() < 1e-12);
        assert_eq!(locator.find_nearest(&[f64::NAN, 0.0], 1.0), None);
        Ok(())
    }

    // Cells of the sizes 1 and 10⁻³ together, and points at all distances from them.
    #[test]
    fn the_nearest_cell_is_the_nearest_of_all() -> Result<(), MeshError> {
        let graded = |[s, t]: [f64; 2]| {
            let (radius, angle) = (1.0 + 0.05 * s + s.powi(6), 0.01 * t + t.powi(5));
            [radius * angle.cos(), radius * angle.sin()]
        };
        let mesh = structured([6, 24], CellShape::Triangle, 2, graded)?;
        let locator = Locator::new(&mesh);
        let (mut near, mut far) = (0, 0);
        for step in 0..400 {
            let angle = -0.2 + 1.4 * f64::from(step % 40) / 40.0;
            let radius = 1.0 - 2e-5 * 1.3_f64.powi(step / 10);
            let (point, tolerance) = ([radius * angle.cos(), radius * angle.sin()], 0.3);
            let all = (0..mesh.cell_count()).map(|cell| project::project(&mesh, cell, &point).1);
            let least = all.fold(f64::INFINITY, f64::min);
            match locator.find_nearest(&point, tolerance) {
                Some(found) => {
                    near += 1;
                    assert!(found.distance == least || locator.find(&point).is_some(), "{point:?}");
                }
                None => {
                    far += 1;
                    assert!(least > tolerance, "{point:?}: {least}");
                }
            }
        }
        assert!(near > 200 && far > 20, "{near} {far}");
        Ok(())
    }

    #[test]
    fn distances_are_those_to_the_cell() -> Result<(), MeshError> {
        for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
            let mesh = cuboid([0.0; 3], [1.0, 2.0, 30.0], [2, 3, 2], shape, 1)?;
            let locator = Locator::new(&mesh);
            for (point, distance) in
                [([1.5, 1.0, 7.0], 0.5), ([0.3, 2.25, 30.0], 0.25), ([-0.3, -0.4, 3.0], 0.5)]
            {
                let nearest = locator.find_nearest(&point, 0.6).expect("all are within 0.6");
                assert!((nearest.distance - distance).abs() < 1e-14, "{shape:?} {nearest:?}");
                assert_eq!(locator.find_nearest(&point, 0.2), None);
            }
        }
        Ok(())
    }
}
