//! Bisected meshes beside the first one: conforming, the same set and regions, bounded angles and shapes.

use std::collections::{BTreeMap, BTreeSet};

use super::*;
use crate::mesh::measures::{close, surface, volume};
use crate::mesh::{INTERIOR, annulus, ball, cuboid, onto_sphere, rectangle, structured};

/// Random numbers below a bound: SplitMix64 (Steele, Lea, Flood 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) % bound as u64) as usize
    }

    /// Some cells, most of them near each other.
    fn marking(&mut self, count: usize) -> Vec<u32> {
        let (first, number) = (self.below(count), 1 + self.below(4));
        let mut cells: Vec<u32> = (0..number).map(|_| ((first + self.below(6)) % count) as u32).collect();
        cells.extend((self.below(3) == 0).then_some((count - 1 - first) as u32));
        cells
    }
}

/// How many markings: all with FORMS_SWEEPS.
fn markings(in_sweeps: usize, else_: usize) -> usize {
    if std::env::var_os("FORMS_SWEEPS").is_some() { in_sweeps } else { else_ }
}

/// The least angle of the triangle, by its vertices.
fn least_angle(mesh: &Mesh<2>, cell: usize) -> f64 {
    let x: Vec<[f64; 2]> = mesh.cell_vertices(cell).iter().map(|node| mesh.nodes[*node as usize]).collect();
    let angle = |k: usize| {
        let [a, b] = [1, 2].map(|next| {
            let other = x[(k + next) % 3];
            [other[0] - x[k][0], other[1] - x[k][1]]
        });
        (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1])
    };
    (0..3).map(angle).fold(f64::INFINITY, f64::min)
}

/// The shape of a tetrahedron but for its size, place and handedness: squares of its edges, which are exact in meshes whose
/// nodes have coordinates of few binary digits.
fn similarity_class(x: &[[f64; 3]; 4]) -> Vec<u64> {
    let squared = |a: usize, b: usize| -> f64 { (0..3).map(|k| (x[a][k] - x[b][k]).powi(2)).sum() };
    let edges = |order: [usize; 4]| {
        [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]].map(|[a, b]| squared(order[a], order[b]))
    };
    let mut best = [0.0; 6];
    for a in 0..4 {
        for b in (0..4).filter(|b| *b != a) {
            for c in (0..4).filter(|c| *c != a && *c != b) {
                let lengths = edges([a, b, c, 6 - a - b - c]);
                if lengths > best {
                    best = lengths;
                }
            }
        }
    }
    // Squares halve, or stay: relative to a power of two the numbers are whole.
    let whole: Vec<u64> = best.iter().map(|square| (square * (1_u64 << 40) as f64) as u64).collect();
    assert!(best.iter().zip(&whole).all(|(square, whole)| square * (1_u64 << 40) as f64 == *whole as f64));
    let divisor = whole.iter().fold(0, |a, b| greatest_common_divisor(a, *b));
    whole.into_iter().map(|square| square / divisor).collect()
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// Regions of the first mesh with their measures.
fn measures<const D: usize>(mesh: &Mesh<D>) -> Result<BTreeMap<String, [f64; 2]>, MeshError> {
    let mut found = BTreeMap::new();
    for name in mesh.facet_region_names().chain(mesh.interior_facet_region_names()) {
        if name != INTERIOR {
            let (area, flux) = surface(mesh, name)?;
            found.insert(name.to_owned(), [area, flux]);
        }
    }
    for name in mesh.cell_region_names() {
        let cells =
            mesh.cell_region(name)?.iter().flat_map(|cell| mesh.cell(*cell as usize).to_vec()).collect();
        let alone = Mesh::of_sound_cells(mesh.degree, mesh.nodes.clone(), vec![(simplex::<D>(), cells)])?;
        found.insert(name.to_owned(), [volume(&alone), 0.0]);
    }
    Ok(found)
}

/// That a mesh is sound and conforming, and covers what the first one did, with the same regions.
fn check<const D: usize>(mesh: &Mesh<D>, first: &BTreeMap<String, [f64; 2]>) -> Result<(), MeshError> {
    mesh.check_conformity()?;
    // The length of what is curved is no integral of a polynomial; volumes and fluxes are.
    let curved = |name: &str| !mesh.is_affine() && mesh.cell_region(name).is_err();
    let now = measures(mesh)?;
    assert_eq!(now.keys().collect::<Vec<_>>(), first.keys().collect::<Vec<_>>());
    for (name, [area, flux]) in first {
        close(now[name][0], *area, if curved(name) { 1e-5 } else { 1e-12 });
        close(now[name][1], *flux, 1e-12);
    }
    let mut used = vec![false; mesh.node_count()];
    mesh.cells.iter().for_each(|node| used[*node as usize] = true);
    assert!(used.iter().all(|used| *used));
    Ok(())
}

/// That the parts of cells lie where the nesting says.
fn check_nesting<const D: usize>(coarse: &Mesh<D>, fine: &Mesh<D>, nesting: &Nesting<D>) {
    assert_eq!(nesting.coarse_cell_count(), coarse.cell_count());
    assert_eq!(nesting.fine_cell_count(), fine.cell_count());
    for cell in 0..fine.cell_count() {
        let parent = nesting.coarse_cell(cell);
        assert!(nesting.fine_cells(parent).contains(&cell));
        for point in [[0.0; D], [0.25; D], std::array::from_fn(|k| if k == 0 { 0.5 } else { 0.125 })] {
            let here = fine.map(cell, &point).0;
            let there = coarse.map(parent, &nesting.to_coarse(cell, &point)).0;
            here.iter().zip(&there).for_each(|(x, y)| close(*x, *y, 1e-13));
        }
        let volume = 0.5_f64.powi(nesting.bisections(cell) as i32);
        let vertices = nesting.vertices(cell);
        let edges: [[f64; D]; D] =
            std::array::from_fn(|j| std::array::from_fn(|i| vertices[j + 1][i] - vertices[0][i]));
        assert_eq!(crate::mesh::geometry::determinant(&edges), volume);
    }
}

/// Triangles of many shapes: none is alike.
fn crooked(degree: usize) -> Result<Mesh<2>, MeshError> {
    let mut mesh = structured([3, 2], CellShape::Triangle, degree, |[s, t]| {
        [3.0 * s + 0.3 * (4.0 * t).sin(), 0.7 * t + 0.1 * (7.0 * s).cos() + 0.2 * s * t]
    })?;
    mesh.name_cells("part", |x| x[0] < 1.0)?;
    mesh.name_cells("rest", |x| x[0] >= 1.0)?;
    mesh.name_interface("seam", "rest", "part")?;
    mesh.name_facets("shelf", "top", |x| x[0] > 1.0)?;
    Ok(mesh)
}

/// Refines at random until there are so many cells, and from the first mesh anew, as often as there are markings.
fn refine_at_random<const D: usize>(
    first: &Mesh<D>,
    [cells, markings]: [usize; 2],
    mut look: impl FnMut(&BisectedMesh<D>, &[usize]),
) -> Result<(), MeshError> {
    let known = measures(first)?;
    let mut random = Random(first.cell_count() as u64);
    let mut mesh = BisectedMesh::new(first.clone())?;
    let mut ancestors: Vec<usize> = (0..first.cell_count()).collect();
    for marking in 0..markings {
        let marked = random.marking(mesh.mesh.cell_count());
        let (fine, nesting) = mesh.refined(&marked)?;
        for cell in marked {
            assert!(nesting.fine_cells(cell as usize).len() > 1);
        }
        ancestors = (0..fine.mesh.cell_count()).map(|cell| ancestors[nesting.coarse_cell(cell)]).collect();
        check(&fine.mesh, &known)?;
        if marking % 7 == 0 {
            check_nesting(&mesh.mesh, &fine.mesh, &nesting);
        }
        look(&fine, &ancestors);
        mesh = fine;
        if mesh.mesh.cell_count() > cells {
            mesh = BisectedMesh::new(first.clone())?;
            ancestors = (0..first.cell_count()).collect();
        }
    }
    Ok(())
}

#[test]
fn random_markings_of_triangles() -> Result<(), MeshError> {
    for degree in 1..=2 {
        let first = crooked(degree)?;
        let least: Vec<f64> = (0..first.cell_count()).map(|cell| least_angle(&first, cell)).collect();
        refine_at_random(&first, [300, markings(40_000, 100)], |fine, ancestors| {
            // Of straight triangles: curved ones are bisected on their reference cell.
            for (cell, ancestor) in ancestors.iter().enumerate().filter(|_| degree == 1) {
                assert!(least_angle(&fine.mesh, cell) >= 0.5 * least[*ancestor] * (1.0 - 1e-9));
            }
        })?;
    }
    Ok(())
}

/// A box of tetrahedra, most of them of different shapes, on nodes with coordinates of few binary digits.
fn crooked_box(degree: usize) -> Result<Mesh<3>, MeshError> {
    let mut mesh = cuboid([0.0; 3], [64.0, 32.0, 32.0], [2, 1, 1], CellShape::Tetrahedron, degree)?;
    let mut random = Random(11);
    if degree == 1 {
        let shift = |x: &[f64; 3]| x.map(|x| x + random.below(9) as f64 - 4.0);
        mesh = mesh.with_nodes(mesh.nodes().iter().map(shift).collect())?;
    }
    mesh.name_cells("part", |x| x[0] < 32.0)?;
    mesh.name_cells("rest", |x| x[0] >= 32.0)?;
    mesh.name_interface("seam", "part", "rest")?;
    Ok(mesh)
}

#[test]
fn random_markings_of_tetrahedra() -> Result<(), MeshError> {
    for degree in 1..=2 {
        let first = crooked_box(degree)?;
        let mut classes: BTreeSet<(usize, Vec<u64>)> = BTreeSet::new();
        refine_at_random(&first, [400, markings(20_000, 25)], |fine, ancestors| {
            for (cell, ancestor) in ancestors.iter().enumerate().filter(|_| degree == 1) {
                let vertices = fine.mesh.cell_vertices(cell);
                let x = std::array::from_fn(|k| fine.mesh.nodes[vertices[k] as usize]);
                classes.insert((*ancestor, similarity_class(&x)));
            }
        })?;
        for ancestor in 0..first.cell_count() {
            let count = classes.iter().filter(|(of, _)| *of == ancestor).count();
            assert!(count <= 73, "{count} classes of the descendants of cell {ancestor}");
        }
    }
    Ok(())
}

/// All descendants of tetrahedra without symmetry: 36 classes where the first marked edges lie in a plane (J. Maubach,
/// Local bisection refinement for n-simplicial grids, 1995), and otherwise its own and 36 of each half.
#[test]
fn similar_to_one_of_finitely_many() {
    let shape = CellShape::Tetrahedron;
    let mut random = Random(3);
    let (mut planar, count) = (0, markings(200, 12));
    for _ in 0..count {
        let x: [[f64; 3]; 4] =
            std::array::from_fn(|_| std::array::from_fn(|_| 2.0 * random.below(500) as f64));
        let lengths =
            shape.edges().iter().map(|&[a, b]| -> f64 { (0..3).map(|k| (x[a][k] - x[b][k]).powi(2)).sum() });
        let lengths: Vec<f64> = lengths.collect();
        let marks = MarkedEdges::longest(shape, |edge| (lengths[edge], edge));
        let mut generation = vec![(x, marks)];
        let mut classes = BTreeSet::from([similarity_class(&x)]);
        let mut after_nine = 0;
        for number in 1..=11 {
            let mut next = Vec::with_capacity(2 * generation.len());
            for (x, marks) in &generation {
                let [a, b] = shape.edges()[marks.refinement_edge()];
                let middle = std::array::from_fn(|k| 0.5 * (x[a][k] + x[b][k]));
                for part in Part::BOTH {
                    let mut of_part = *x;
                    of_part[part.kept_and_new([a, b])[1]] = middle;
                    classes.insert(similarity_class(&of_part));
                    next.push((of_part, marks.of_part(shape, part)));
                }
            }
            generation = next;
            if number == 9 {
                after_nine = classes.len();
            }
        }
        assert_eq!(classes.len(), after_nine);
        match marks.lie_in_a_plane() {
            true => assert_eq!(classes.len(), 36),
            false => assert!(classes.len() <= 73, "{}", classes.len()),
        }
        planar += usize::from(marks.lie_in_a_plane());
    }
    assert!(planar > 0 && planar < count);
}

/// Kuhn's tetrahedra and right isosceles triangles keep their shapes: 3 classes, and 1.
#[test]
fn grids_keep_their_shapes() -> Result<(), MeshError> {
    let mut cube = BisectedMesh::new(cuboid([0.0; 3], [1.0; 3], [1; 3], CellShape::Tetrahedron, 1)?)?;
    let mut square = BisectedMesh::new(rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?)?;
    let mut classes = BTreeSet::new();
    for generation in 1..=9 {
        let all: Vec<u32> = (0..cube.mesh.cell_count() as u32).collect();
        cube = cube.refined(&all)?.0;
        // Every cell once: nothing else had to be bisected.
        assert_eq!(cube.mesh.cell_count(), 6 << generation);
        for cell in 0..cube.mesh.cell_count() {
            let vertices = cube.mesh.cell_vertices(cell);
            classes.insert(similarity_class(&std::array::from_fn(|k| cube.mesh.nodes[vertices[k] as usize])));
        }
        let all: Vec<u32> = (0..square.mesh.cell_count() as u32).collect();
        square = square.refined(&all)?.0;
        assert_eq!(square.mesh.cell_count(), 8 << generation);
        for cell in 0..square.mesh.cell_count() {
            close(least_angle(&square.mesh, cell), std::f64::consts::FRAC_PI_4, 1e-12);
        }
    }
    assert_eq!(classes.len(), 3);
    Ok(())
}

/// Towards a corner, as adaptive refinement does it: cells as small as 2^-40 of the first, and few of them.
#[test]
fn refinement_towards_a_corner_stays_there() -> Result<(), MeshError> {
    let mut mesh = BisectedMesh::new(crooked(1)?)?;
    let corner = mesh.mesh.nodes[0];
    for _ in 0..80 {
        let at_corner = |cell: &u32| {
            let vertices = mesh.mesh.cell_vertices(*cell as usize);
            vertices.iter().any(|node| mesh.mesh.nodes[*node as usize] == corner)
        };
        let marked: Vec<u32> = (0..mesh.mesh.cell_count() as u32).filter(at_corner).collect();
        mesh = mesh.refined(&marked)?.0;
    }
    let smallest = (0..mesh.mesh.cell_count()).map(|cell| mesh.mesh.diameter(cell)).fold(1.0, f64::min);
    assert!(smallest < 1e-11, "{smallest:e}");
    assert!(mesh.mesh.cell_count() < 1_000, "{}", mesh.mesh.cell_count());
    mesh.mesh.check_conformity()
}

/// New nodes of a ring and a ball stand on circle and sphere, those that were there stay.
#[test]
fn new_nodes_on_the_exact_boundary() -> Result<(), MeshError> {
    for degree in 1..=2 {
        let first = annulus(1.0, 2.0, 1, 7, CellShape::Triangle, degree)?;
        let mut ring = BisectedMesh::new(first.clone())?;
        let (inner, outer) = (onto_sphere([0.0; 2], 1.0), onto_sphere([0.0; 2], 2.0));
        let error = |mesh: &Mesh<2>| (volume(mesh) - 3.0 * std::f64::consts::PI).abs();
        for _ in 0..6 {
            let all: Vec<u32> = (0..ring.mesh.cell_count() as u32).collect();
            ring = ring.refined_onto(&all, &[("inner", &inner), ("outer", &outer)])?.0;
        }
        assert_eq!(ring.mesh.nodes[..first.node_count()], first.nodes);
        // Three halvings of the edges: chords of order 2, parabolas of order 4.
        let gained = error(&first) / error(&ring.mesh);
        assert!(gained > if degree == 1 { 50.0 } else { 3_000.0 }, "{degree}: {gained}");
        for (name, radius) in [("inner", 1.0), ("outer", 2.0)] {
            let element = ring.mesh.element_of(CellShape::Triangle);
            for facet in ring.mesh.facet_region(name)? {
                for node in element.facet_nodes(facet.local.into()) {
                    let [x, y] = ring.mesh.nodes[ring.mesh.cell(facet.cell as usize)[node] as usize];
                    close(x.hypot(y), radius, 1e-14);
                }
            }
        }
        let sphere = ball(1.0, [false; 3], 1, 1, CellShape::Tetrahedron, degree)?;
        let onto = onto_sphere([0.0; 3], 1.0);
        let marked: Vec<u32> = sphere.facet_region("sphere")?.iter().map(|facet| facet.cell).collect();
        let (fine, _) = BisectedMesh::new(sphere)?.refined_onto(&marked, &[("sphere", &onto)])?;
        let element = fine.mesh.element_of(CellShape::Tetrahedron);
        for facet in fine.mesh.facet_region("sphere")? {
            for node in element.facet_nodes(facet.local.into()) {
                let x = fine.mesh.nodes[fine.mesh.cell(facet.cell as usize)[node] as usize];
                close(x.iter().map(|x| x * x).sum::<f64>().sqrt(), 1.0, 1e-12);
            }
        }
        fine.mesh.check_conformity()?;
    }
    Ok(())
}

#[test]
fn markings_of_nothing_and_of_what_is_not_there() -> Result<(), MeshError> {
    let mesh = BisectedMesh::new(crooked(2)?)?;
    let (same, nesting) = mesh.refined(&[])?;
    assert_eq!((same.mesh.nodes(), same.mesh.cells()), (mesh.mesh.nodes(), mesh.mesh.cells()));
    assert_eq!(same.marks, mesh.marks);
    assert!((0..12).all(|cell| nesting.coarse_cell(cell) == cell && nesting.bisections(cell) == 0));
    // In whatever order, and twice.
    let sorted = mesh.refined(&[2, 5, 7])?.0;
    let given = mesh.refined(&[7, 2, 7, 5])?.0;
    assert_eq!((sorted.mesh.nodes(), sorted.mesh.cells()), (given.mesh.nodes(), given.mesh.cells()));
    let message = |error: Option<MeshError>| error.map(|error| error.to_string()).unwrap_or_default();
    assert_eq!(
        message(mesh.refined(&[3, 12]).err()),
        "cell 12 is marked, but the mesh has 12 cells (numbered from 0)"
    );
    let squares = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1)?;
    assert_eq!(
        message(BisectedMesh::new(squares).err()),
        "bisection is of triangles and tetrahedra; this mesh has quadrilaterals (`Mesh::simplices` divides them)"
    );
    let far = onto_sphere([0.0; 2], 1e300);
    let boundary: Vec<u32> = (0..12).collect();
    let (fine, _) = mesh.refined(&boundary)?;
    let at_boundary: Vec<u32> = fine.mesh.boundary_facets().iter().map(|facet| facet.cell).collect();
    let outside = fine.refined_onto(&at_boundary, &[("boundary", &far)]).err();
    assert!(matches!(outside, Some(MeshError::Inverted { .. } | MeshError::NotFinite { .. })), "{outside:?}");
    assert!(matches!(mesh.refined_onto(&[0], &[("lid", &far)]), Err(MeshError::UnknownRegion { .. })));
    Ok(())
}
