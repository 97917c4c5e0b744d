//! Meshes of trees with hanging nodes: continuous and broken spaces, jumps on parts of facets, transfer, estimators.

use forms_fem::adaptivity::ErrorEstimate;
use forms_fem::mesh::OctreeMesh;
use forms_fem::prelude::*;

use crate::interior_facets::{broken, penalty, skeleton, turned};

#[forms]
mod model {
    pub struct Data {
        f: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn poisson(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - f * v)
    }
}

#[forms]
mod across {
    #[interior_facets]
    pub struct Inside;

    pub fn jumps(u: State<Scalar>, q: Test<Scalar>) -> Form {
        integral(Inside, avg(h) * sqr(dot(jump(grad(u)), n)) / 2 * avg(q))
    }
    pub fn areas() -> Functional {
        integral(Inside, facet_area)
    }
    /// A normal that points out of the first side.
    pub fn flux(w: State<Vector>) -> Functional {
        integral(Inside, dot(this(w), n))
    }
}

/// Some markings of cells at random, beginning with the first mesh.
fn at_random<const D: usize>(first: Mesh<D>, markings: usize) -> Mesh<D> {
    let mut mesh = OctreeMesh::new(first).unwrap();
    let mut state = 12_345_u64;
    for _ in 0..markings {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let cell = (state >> 33) as usize % mesh.mesh().cell_count();
        mesh = mesh.refined(&[cell as u32]).unwrap().0;
    }
    assert!(!mesh.mesh().hanging_facets().unwrap().is_empty());
    mesh.mesh().clone()
}

/// Cells turned in all ways, so that parts of facets are met in all ways.
fn squares(markings: usize) -> Mesh<2> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [3, 3], CellShape::Quadrilateral, 1).unwrap();
    at_random(turned(&mesh), markings)
}

fn cubes(cells: [usize; 3], markings: usize) -> Mesh<3> {
    let mesh = cuboid([0.0; 3], [1.0; 3], cells, CellShape::Hexahedron, 1).unwrap();
    at_random(turned(&mesh), markings)
}

fn all_cases() -> bool {
    std::env::var_os("FORMS_SWEEPS").is_some()
}

fn polynomial<const D: usize>(x: &[f64; D], degree: usize) -> f64 {
    let along: f64 = x.iter().zip([1.0, -0.5, 0.75]).map(|(x, a)| a * x).sum();
    (0.5 + along).powi(degree as i32)
}

/// −Δ of the polynomial.
fn source<const D: usize>(degree: usize) -> Given<f64, D> {
    let gradient: f64 = [1.0, -0.5, 0.75][..D].iter().map(|a| a * a).sum();
    Given::function(move |x: &[f64; D]| match degree {
        0 | 1 => 0.0,
        _ => -(degree as f64) * (degree as f64 - 1.0) * gradient * polynomial(x, degree - 2),
    })
}

fn error_at_nodes<const D: usize>(u: &Field<D>, degree: usize) -> f64 {
    let space = u.space();
    let error = |node: usize| (u.at_node(node)[0] - polynomial(&space.positions()[node], degree)).abs();
    (0..space.node_count()).map(error).fold(0.0, f64::max)
}

/// Continuous elements solve polynomials of their degree exactly, and these come through to another such mesh.
fn reproduces<const D: usize>(mesh: &Mesh<D>, other: &Mesh<D>, degrees: std::ops::RangeInclusive<usize>)
where
    Dim: Dimension<D>,
{
    for degree in degrees {
        let space = Space::scalar(mesh, degree).unwrap();
        let mut constraints = Constraints::new(&space);
        constraints.join_hanging_nodes().unwrap();
        for (&unknown, relation) in constraints.relations() {
            let value = |unknown: usize| polynomial(&space.positions()[unknown], degree);
            let sum: f64 = relation.terms.iter().map(|(free, a)| a * value(*free)).sum();
            assert!((sum + relation.value - value(unknown)).abs() < 1e-12, "degree {degree}");
        }
        // Facets between large and small cells are interior ones: the boundary is the outer one.
        constraints.fix("boundary", |x| polynomial(x, degree)).unwrap();
        let form = model::poisson(&model::data().f(source(degree)), &model::Omega::on("all"));
        let u = Problem::new(&form, &space).constrained(&constraints).solve().unwrap().into_field();
        assert!(error_at_nodes(&u, degree) < 1e-11, "degree {degree}: {:e}", error_at_nodes(&u, degree));

        let exact = Field::interpolate(&space, |x| polynomial(x, degree)).unwrap();
        let carried = exact.onto(&Space::scalar(other, degree).unwrap()).interpolated().unwrap();
        assert!(
            error_at_nodes(&carried, degree) < 1e-12,
            "degree {degree}: {:e}",
            error_at_nodes(&carried, degree)
        );
    }
}

#[test]
fn polynomials_on_octrees_of_the_plane_and_space() {
    reproduces(&squares(12), &squares(7), 1..=4);
    if all_cases() {
        reproduces(&cubes([2, 2, 2], 6), &cubes([2, 2, 2], 3), 1..=4);
    } else {
        reproduces(&cubes([2, 1, 1], 1), &cubes([1, 2, 1], 2), 1..=4);
    }
}

/// The projection of a field to a continuous space is continuous where nodes hang, and what is left is orthogonal to that space.
fn projects<const D: usize>(mesh: &Mesh<D>, other: &Mesh<D>, degree: usize)
where
    Dim: Dimension<D>,
{
    let source = Space::vector(other, degree).unwrap();
    let wave = |x: &[f64; D]| std::array::from_fn::<f64, D, _>(|k| (3.0 * x[0] + k as f64).sin() + x[1]);
    let field = Field::interpolate(&source, wave).unwrap();
    let space = Space::vector(mesh, degree).unwrap();
    let mut joined = Constraints::new(&space);
    joined.join_hanging_nodes().unwrap();
    let (projected, conserved) =
        (field.onto(&space).projected().unwrap(), field.onto(&space).conserved().unwrap());
    for found in [&projected, &conserved] {
        let mut values = found.values().to_vec();
        joined.apply(&mut values);
        let off = values.iter().zip(found.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12, "degree {degree}: {off:e}");
    }
    // Projected to a discontinuous space first, nothing is lost on the way.
    let broken = Space::discontinuous_vector(mesh, degree).unwrap();
    let by_way = field.onto(&broken).projected().unwrap().onto(&space).projected().unwrap();
    let off = by_way.values().iter().zip(projected.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-11, "degree {degree}: {off:e}");
}

#[test]
fn projections_are_continuous_where_nodes_hang() {
    for degree in 1..=3 {
        projects(&squares(12), &squares(7), degree);
    }
    projects(&cubes([2, 1, 1], 1), &cubes([1, 2, 1], 2), 2);
}

/// The interior penalty method solves polynomials of its degree exactly, where a cell has several neighbours on one side.
fn penalised<const D: usize>(mesh: &Mesh<D>, degrees: std::ops::RangeInclusive<usize>)
where
    Dim: Dimension<D>,
{
    for degree in degrees {
        let space = Space::discontinuous_scalar(mesh, degree).unwrap();
        let data = penalty::data()
            .source(source(degree))
            .wanted(move |x: &[f64; D]| polynomial(x, degree))
            .gamma(10.0 * (degree * degree) as f64);
        let form = penalty::poisson(
            &data,
            &penalty::Omega::on("all"),
            &penalty::Wall::on("boundary"),
            &penalty::Skeleton::on("interior"),
        );
        let u = Problem::new(&form, &space).solve().unwrap().into_field();
        assert!(error_at_nodes(&u, degree) < 1e-10, "degree {degree}: {:e}", error_at_nodes(&u, degree));
    }
}

#[test]
fn interior_penalty_solves_polynomials_across_hanging_nodes() {
    penalised(&squares(9), 1..=3);
    penalised(&cubes([2, 1, 1], 1), 1..=2);
    if all_cases() {
        penalised(&cubes([2, 2, 1], 5), 1..=3);
    }
}

/// ∫ div w of broken fields is that of w·n over all facets: jumps meet the right points, normals and weights, on straight and curved cells.
fn balanced<const D: usize>(mesh: &Mesh<D>)
where
    Dim: Dimension<D>,
{
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(10));
    let (omega, wall, inside) =
        (skeleton::Omega::on("all"), skeleton::Wall::on("boundary"), skeleton::Skeleton::on("interior"));
    for degree in 0..=2 {
        let field = broken(&Space::discontinuous_vector(mesh, degree).unwrap());
        let rest = assembler.functional(&skeleton::balance(&omega, &wall, &inside, &field)).unwrap();
        assert!(rest.abs() < 1e-11, "degree {degree}: {rest:e}");
    }
    let smooth = |x: &[f64; D]| x[0] * x[0] - 2.0 * x[0] * x[1] + 0.5 * x[1];
    if mesh.degree() == 1 {
        let field = Field::interpolate(&Space::discontinuous_scalar(mesh, 2).unwrap(), smooth).unwrap();
        let jumps = assembler.functional(&skeleton::jump_squared(&inside, &field)).unwrap();
        let kinks = assembler.functional(&skeleton::kinks(&inside, &field)).unwrap();
        assert!(jumps.abs() < 1e-24 && kinks.abs() < 1e-22, "{jumps:e} {kinks:e}");
    }
}

#[test]
fn the_sides_of_large_and_small_cells_meet() {
    balanced(&squares(12));
    balanced(&cubes([2, 2, 1], 3));
    // Curved cells, of degree 2 and 1.
    for degree in 1..=2 {
        balanced(&at_random(annulus(1.0, 2.0, 2, 7, CellShape::Quadrilateral, degree).unwrap(), 8));
        let bent = |x: &[f64; 3]| [x[0] + 0.2 * x[1] * x[2], x[1] + 0.1 * x[0] * x[0], x[2]];
        let cube = cuboid([0.0; 3], [1.0; 3], [2, 2, 1], CellShape::Hexahedron, degree).unwrap();
        let cube = cube.with_nodes(cube.nodes().iter().map(bent).collect()).unwrap();
        balanced(&at_random(cube, 2));
    }
}

/// Two unit squares, the second one in four: the line between them in two parts, seen from either side.
#[test]
fn one_large_facet_and_two_small_ones() {
    for first in [0, 1] {
        let mut mesh = rectangle([0.0; 2], [2.0, 1.0], [2, 1], CellShape::Quadrilateral, 1).unwrap();
        mesh.name_cells("west", |x| x[0] < 1.0).unwrap();
        mesh.name_cells("east", |x| x[0] > 1.0).unwrap();
        // The normal points out of the first one.
        let [from, to] = if first == 0 { ["west", "east"] } else { ["east", "west"] };
        mesh.name_interface("seam", from, to).unwrap();
        let mesh = OctreeMesh::new(mesh).unwrap().refined(&[1]).unwrap().0.mesh().clone();
        let assembler = Assembler::new(&mesh);
        let seam = across::Inside::on("seam");
        assert_eq!(mesh.interior_facet_region("seam").unwrap().len(), 2);
        // Of each facet its own area: 2·½·½, and 4·½·½ inside the second square.
        let areas = |inside: &across::Inside| assembler.functional(&across::areas(inside)).unwrap();
        assert!((areas(&seam) - 0.5).abs() < 1e-15, "{}", areas(&seam));
        assert!((areas(&across::Inside::on("interior")) - 1.5).abs() < 1e-14);
        // w = (1 + y, 0) from the left: ∫(1 + y) = 3/2 with the sign of the normal.
        let along = |x: &[f64; 2]| [1.0 + x[1], 0.0];
        let w = Field::interpolate(&Space::discontinuous_vector(&mesh, 1).unwrap(), along).unwrap();
        let flux = assembler.functional(&across::flux(&seam, &w)).unwrap();
        assert!((flux - if first == 0 { 1.5 } else { -1.5 }).abs() < 1e-14, "{flux}");
        // u = 0 on the left and y(1 − y)(x − 1) on the right, in degree 3: ∂u/∂x jumps by y(1 − y) on x = 1, nowhere else. With h = √2 and √2/2 the
        // squares are Σ ¾√2 ∫ y²(1 − y)²/2 = ¾√2/60, a half for each side.
        let kinked = |x: &[f64; 2]| x[1] * (1.0 - x[1]) * (x[0] - 1.0).max(0.0);
        let u = Field::interpolate(&Space::scalar(&mesh, 3).unwrap(), kinked).unwrap();
        let form = across::jumps(&across::Inside::on("interior"), &u);
        let estimate = ErrorEstimate::residual(&assembler, &form).unwrap();
        let expected = 0.75 * 2f64.sqrt() / 60.0;
        let shares = estimate.indicators();
        assert!((estimate.value() * estimate.value() - expected).abs() < 1e-14);
        assert!((shares[0] - 0.5 * expected).abs() < 1e-14, "{shares:?}");
    }
}

/// Residual, matrix and solution do not depend on the number of threads, to the last bit.
#[test]
fn octrees_on_any_number_of_threads() {
    let mesh = squares(40);
    let space = Space::discontinuous_scalar(&mesh, 2).unwrap();
    let data = penalty::data().source(source(2)).wanted(|x: &[f64; 2]| polynomial(x, 2)).gamma(40.0);
    let form = penalty::poisson(
        &data,
        &penalty::Omega::on("all"),
        &penalty::Wall::on("boundary"),
        &penalty::Skeleton::on("interior"),
    );
    let tangent = |threads: usize| {
        let assembler = Assembler::new(&mesh).with_threads(Threads::new(threads));
        let found = assembler.tangent(&form, &[&broken(&space)], &[&space]).unwrap();
        (found, assembler.residual(&form, &[&broken(&space)], &[&space]).unwrap())
    };
    let alone = tangent(1);
    for threads in [2, 3, 5] {
        assert!(tangent(threads) == alone);
    }
    let joined = |threads: usize| {
        let space = Space::scalar(&mesh, 3).unwrap();
        let mut constraints = Constraints::new(&space);
        constraints.join_hanging_nodes().unwrap();
        constraints.fix("boundary", |x| polynomial(x, 4)).unwrap();
        let form = model::poisson(&model::data().f(source(4)), &model::Omega::on("all"));
        Problem::new(&form, &space)
            .threads(Threads::new(threads))
            .constrained(&constraints)
            .solve()
            .unwrap()
            .into_field()
    };
    assert_eq!(joined(1).values(), joined(3).values());
}

/// Refusals by everything that knows whole facets only.
#[test]
fn spaces_on_facets_name_parts_of_larger_ones() {
    let mesh = squares(3);
    let error = Space::on_facets(&mesh, "interior", 1).err().map(|error| error.to_string());
    assert!(
        error.as_deref().unwrap_or_default().starts_with("a space on facets is of meshes whose cells share"),
        "{error:?}"
    );
}
