//! Outlines that are known: areas and lengths stay, names too, cells are good.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::*;
use crate::mesh::measures::{close, surface, volume};
use crate::mesh::{PerforatedAnnulus, annulus, onto_sphere, rectangle};

const RING: PerforatedAnnulus = PerforatedAnnulus {
    inner_radius: 20.0,
    outer_radius: 30.0,
    rows: 1,
    holes_around: 24,
    hole_radius: 2.0,
    cells_per_side: 4,
    layers: 4,
    shape: CellShape::Quadrilateral,
    degree: 2,
};

fn least_quality(mesh: &Mesh<2>) -> f64 {
    mesh.quality().scaled_jacobian()[0]
}

#[test]
fn a_rectangle_keeps_its_corners_and_names() {
    for degree in [1, 2] {
        let mut old = rectangle([0.0; 2], [6.0, 2.0], [6, 2], CellShape::Quadrilateral, degree).unwrap();
        old.name_facets("support", "bottom", |x| x[0] > 3.0 && x[0] < 5.0).unwrap();
        old.name_cells("steel", |_| true).unwrap();
        let new = Remeshing::new(Sizes::between(0.1, 0.3)).remesh(&old).unwrap();
        close(volume(&new), 12.0, 1e-13);
        for (region, length) in [("left", 2.0), ("bottom", 6.0), ("support", 2.0), ("boundary", 16.0)] {
            close(surface(&new, region).unwrap().0, length, 1e-13);
        }
        assert_eq!(new.cell_region("steel").unwrap().len(), new.cell_count());
        assert!(least_quality(&new) > 0.5, "{}", least_quality(&new));
        // About as many as equilateral triangles of that size.
        let equilateral = 12.0 / (0.3_f64.powi(2) * 0.433);
        assert!((new.cell_count() as f64 / equilateral - 1.0).abs() < 0.5, "{}", new.cell_count());
    }
}

/// Turns of 27.7° and 12°: a polygon keeps its area and perimeter. One of 9° approximates a circle.
#[test]
fn a_polygon_keeps_its_corners() {
    for around in [13, 30] {
        let old = annulus(1.0, 2.0, 2, around, CellShape::Triangle, 1).unwrap();
        let new = Remeshing::new(Sizes::between(0.05, 0.5)).remesh(&old).unwrap();
        close(volume(&new), volume(&old), 1e-12);
        for region in ["inner", "outer"] {
            close(surface(&new, region).unwrap().0, surface(&old, region).unwrap().0, 1e-12);
        }
    }
    let old = annulus(1.0, 2.0, 2, 40, CellShape::Triangle, 1).unwrap();
    let new = Remeshing::new(Sizes::between(0.05, 0.5)).remesh(&old).unwrap();
    close(volume(&new) / (3.0 * PI), 1.0, 0.02);
}

#[test]
fn a_ring_in_sectors_has_the_pattern() {
    let mut old = RING.mesh().unwrap();
    old.name_facets("contact", "outer", |x| x[1] < 0.0).unwrap();
    old.name_cells_of_facets("contact cells", "contact").unwrap();
    let (inner, outer) = (onto_sphere([0.0; 2], 20.0), onto_sphere([0.0; 2], 30.0));
    let surfaces: [Surface<2>; 2] = [("inner", &inner), ("outer", &outer)];
    let remeshing = Remeshing::new(Sizes::between(0.2, 1.2))
        .in_sectors([0.0; 2], 24, 0.0)
        .onto(&surfaces)
        .with_cells_of_facets(&[("contact cells", "contact")]);
    let new = remeshing.remesh(&old).unwrap();
    assert_eq!(new.cell_count() % 24, 0);
    assert!(least_quality(&new) > 0.45, "{}", least_quality(&new));
    close(volume(&new) / volume(&old), 1.0, 2e-5);
    close(surface(&new, "contact").unwrap().0, PI * 30.0, 1e-4);
    close(surface(&new, "hole 7").unwrap().0, TAU * 2.0, 1e-3);
    close(surface(&new, "inner").unwrap().0, TAU * 20.0, 1e-4);
    // Turned by a sector, nodes fall on nodes: the sum over all of a function that is not constant shows it.
    let (sine, cosine) = (TAU / 24.0).sin_cos();
    for x in new.nodes() {
        let turned = [cosine * x[0] - sine * x[1], sine * x[0] + cosine * x[1]];
        let near = |y: &&[f64; 2]| (y[0] - turned[0]).hypot(y[1] - turned[1]) < 1e-10;
        assert!(new.nodes().iter().any(|y| near(&y)), "{x:?}");
    }
    // The same once more, bit for bit.
    assert!(remeshing.remesh(&old).unwrap().nodes() == new.nodes());
    // And from triangles.
    close(volume(&remeshing.remesh(&new).unwrap()) / volume(&old), 1.0, 4e-5);
}

#[test]
fn curved_boundaries_come_nearer_with_their_curves() {
    let old = annulus(1.0, 2.0, 2, 16, CellShape::Quadrilateral, 2).unwrap();
    let (inner, outer) = (onto_sphere([0.0; 2], 1.0), onto_sphere([0.0; 2], 2.0));
    let surfaces: [Surface<2>; 2] = [("inner", &inner), ("outer", &outer)];
    let sizes = Sizes::between(0.05, 0.1);
    let new = Remeshing::new(sizes).onto(&surfaces).remesh(&old).unwrap();
    close(volume(&new), 3.0 * PI, 1e-4);
    let plain = Remeshing::new(sizes).remesh(&old).unwrap();
    close(volume(&plain), volume(&old), 1e-4);
}

#[test]
fn cells_are_small_where_the_body_is_thin() {
    // A hole that nearly touches the inner circle.
    let old = PerforatedAnnulus { hole_radius: 2.2, ..RING }.mesh().unwrap();
    let nodes = old.nodes().iter().map(|x| {
        let (radius, angle) = (x[0].hypot(x[1]), x[1].atan2(x[0]));
        let moved = radius - 2.8 * (PI * (radius - 20.0) / 10.0).sin();
        [moved * angle.cos(), moved * angle.sin()]
    });
    let old = old.with_nodes(nodes.collect()).unwrap();
    let remeshing = Remeshing::new(Sizes::between(0.1, 1.5)).in_sectors([0.0; 2], 24, 0.0);
    let new = remeshing.remesh(&old).unwrap();
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for cell in 0..new.cell_count() {
        let (size, radius) = (new.diameter(cell), new.cell_centre(cell)[0].hypot(new.cell_centre(cell)[1]));
        if radius < 20.2 {
            least = least.min(size);
        }
        most = most.max(size);
    }
    assert!(least < 0.6 && most > 1.2, "{least} {most}");
    assert!(least_quality(&new) > 0.4, "{}", least_quality(&new));
}

#[test]
fn what_goes_wrong_is_told() {
    let old = rectangle([0.0; 2], [2.0, 1.0], [2, 1], CellShape::Quadrilateral, 1).unwrap();
    let message = |remeshing: Remeshing, mesh: &Mesh<2>| remeshing.remesh(mesh).unwrap_err().to_string();
    let good = Sizes::between(0.1, 0.3);
    let text = message(Remeshing::new(Sizes::between(0.0, 1.0)), &old);
    assert_eq!(text, "the smallest size = 0 is not possible: it must be positive");
    assert!(message(Remeshing::new(Sizes::between(1.0, 0.5)), &old).starts_with("the largest size = 0.5"));
    assert!(message(Remeshing::new(good.growing(f64::NAN)), &old).starts_with("the growth = NaN"));
    let mut half = old.clone();
    half.name_cells("half", |x| x[0] < 1.0).unwrap();
    assert!(message(Remeshing::new(good), &half).starts_with("the region \"half\" cannot be carried"));
    let mut cut = old.clone();
    cut.name_interior_facets("seam", "interior", |_| true).unwrap();
    assert!(message(Remeshing::new(good), &cut).starts_with("the region \"seam\" cannot be carried"));
    let ring = RING.mesh().unwrap();
    let turned = Remeshing::new(Sizes::between(0.2, 1.0)).in_sectors([0.0; 2], 24, FRAC_PI_2 / 12.0);
    assert!(message(turned, &ring).contains("crosses the sides of its sector"));
    let text = message(Remeshing::new(good).in_sectors([0.0; 2], 24, 0.0), &old);
    assert!(text.contains("boundar"), "{text}");
}
