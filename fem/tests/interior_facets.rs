//! Interior facets: both sides meet whatever the cells' numbering, and the interior penalty method converges.

use forms_fem::assemble::BlockPattern;
use forms_fem::contract::Side;
use forms_fem::prelude::*;

#[forms]
pub(crate) mod skeleton {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;
    #[interior_facets]
    pub struct Skeleton;

    pub fn area() -> Functional {
        integral(Skeleton, 1)
    }
    /// h and |T| of both cells, weighted with what tells the sides apart.
    pub fn sizes() -> Functional {
        integral(Skeleton, this(h) + 10 * other(h) + 100 * this(cell_volume) + 1000 * other(cell_volume))
    }
    pub fn jump_squared(u: State<Scalar>) -> Functional {
        integral(Skeleton, jump(u) * jump(u))
    }
    pub fn kinks(u: State<Scalar>) -> Functional {
        integral(Skeleton, dot(jump(grad(u)), jump(grad(u))))
    }
    /// Zero for every broken field, by the divergence theorem on each cell.
    pub fn balance(w: State<Vector>) -> Functional {
        integral(Omega, div(w)) - integral(Wall, dot(w, n)) - integral(Skeleton, dot(jump(w), n))
    }
    pub fn difference(u: Scalar) -> Scalar {
        jump(u)
    }
    /// Nonlinear in the jump, with a kink.
    pub fn adhesion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Skeleton, (pow(jump(u), 3) + pos_part(jump(u))) * jump(v) + avg(u) * this(v))
    }
}

#[forms]
pub(crate) mod penalty {
    pub struct Data {
        source: Given<Scalar>,
        wanted: Given<Scalar>,
        gamma: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;
    #[interior_facets]
    pub struct Skeleton;

    pub fn poisson(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - source * v)
            + integral(
                Skeleton,
                gamma / avg(h) * jump(u) * jump(v)
                    - dot(avg(grad(u)), n) * jump(v)
                    - dot(avg(grad(v)), n) * jump(u),
            )
            + integral(
                Wall,
                gamma / h * (u - wanted) * v - dot(grad(u), n) * v - dot(grad(v), n) * (u - wanted),
            )
    }
}

/// A mesh with the same cells whose vertices are numbered from another corner, turned about an axis.
pub(crate) fn turned<const D: usize>(mesh: &Mesh<D>) -> Mesh<D> {
    let shape = mesh.cell_shape(0);
    let turn: Vec<usize> = match shape {
        CellShape::Triangle => vec![1, 2, 0],
        CellShape::Quadrilateral => vec![1, 2, 3, 0],
        CellShape::Tetrahedron => vec![1, 2, 0, 3],
        CellShape::Hexahedron => vec![1, 2, 3, 0, 5, 6, 7, 4],
    };
    // About another axis in three dimensions.
    let tip: Vec<usize> = match shape {
        CellShape::Tetrahedron => vec![0, 2, 3, 1],
        CellShape::Hexahedron => vec![4, 5, 1, 0, 7, 6, 2, 3],
        _ => turn.clone(),
    };
    let mut cells = Vec::new();
    for cell in 0..mesh.cell_count() {
        let mut nodes = mesh.cell(cell).to_vec();
        for _ in 0..cell % 5 {
            nodes = turn.iter().map(|&k| nodes[k]).collect();
        }
        for _ in 0..cell % 3 {
            nodes = tip.iter().map(|&k| nodes[k]).collect();
        }
        cells.extend(nodes);
    }
    Mesh::from_parts(shape, 1, mesh.nodes().to_vec(), cells).unwrap()
}

fn square(shape: CellShape, cells: usize) -> Mesh<2> {
    turned(&rectangle([0.0; 2], [1.0; 2], [cells, cells], shape, 1).unwrap())
}

fn cube(shape: CellShape, cells: usize) -> Mesh<3> {
    turned(&cuboid([0.0; 3], [1.0; 3], [cells, cells, cells], shape, 1).unwrap())
}

/// Coefficients without structure.
pub(crate) fn broken<const D: usize>(space: &Arc<Space<D>>) -> Field<D> {
    let value = |index: usize| ((index * 7919 + 13) % 1009) as f64 / 1009.0 - 0.5;
    Field::from_values(space, (0..space.unknowns()).map(value).collect()).unwrap()
}

macro_rules! sides_meet {
    ($mesh:expr, $tolerance:expr) => {
        let mesh = $mesh;
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8));
        let (omega, wall, inside) =
            (skeleton::Omega::on("all"), skeleton::Wall::on("boundary"), skeleton::Skeleton::on("interior"));
        for degree in 0..=2 {
            let field = broken(&Space::discontinuous_vector(&mesh, degree).unwrap());
            let rest = assembler.functional(&skeleton::balance(&omega, &wall, &inside, &field)).unwrap();
            assert!(rest.abs() < $tolerance, "{:?} degree {degree}: {rest:e}", mesh.cell_shape(0));
        }
        // A continuous field seen as a broken one does not jump, nor does the gradient of a quadratic.
        let smooth = |x: &[f64; _]| x[0] * x[0] - 2.0 * x[0] * x[1] + 0.5 * x[1];
        let field = Field::interpolate(&Space::discontinuous_scalar(&mesh, 2).unwrap(), smooth).unwrap();
        let jumps = assembler.functional(&skeleton::jump_squared(&inside, &field)).unwrap();
        assert!(jumps.abs() < $tolerance, "{:?}: {jumps:e}", mesh.cell_shape(0));
        if mesh.degree() == 1 {
            let kinks = assembler.functional(&skeleton::kinks(&inside, &field)).unwrap();
            assert!(kinks.abs() < $tolerance, "{:?}: {kinks:e}", mesh.cell_shape(0));
        }
    };
}

#[test]
fn both_sides_meet_on_every_shape_and_numbering() {
    sides_meet!(square(CellShape::Triangle, 3), 1e-13);
    sides_meet!(square(CellShape::Quadrilateral, 3), 1e-13);
    sides_meet!(cube(CellShape::Tetrahedron, 2), 1e-13);
    sides_meet!(cube(CellShape::Hexahedron, 2), 1e-13);
}

// On curved cells the rule is not exact, but the two sides are the same points.
#[test]
fn both_sides_meet_on_curved_cells() {
    sides_meet!(annulus(1.0, 2.0, 2, 10, CellShape::Quadrilateral, 2).unwrap(), 1e-9);
    sides_meet!(annulus(1.0, 2.0, 2, 10, CellShape::Triangle, 2).unwrap(), 1e-9);
}

#[test]
fn sizes_are_those_of_each_side() {
    // Two cells of widths 1 and 2 and height 1.
    let nodes = vec![[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [0.0, 1.0], [1.0, 1.0], [3.0, 1.0]];
    let cells = vec![0, 1, 4, 3, 1, 2, 5, 4];
    let mut mesh = Mesh::from_parts(CellShape::Quadrilateral, 1, nodes, cells).unwrap();
    mesh.name_listed_interior_facets("from the right", &[Facet { cell: 1, local: 3 }]).unwrap();
    let assembler = Assembler::new(&mesh);
    let sizes =
        |region: &str| assembler.functional(&skeleton::sizes(&skeleton::Skeleton::on(region))).unwrap();
    let (narrow, wide) = (2.0_f64.sqrt(), 5.0_f64.sqrt());
    assert!((sizes("interior") - (narrow + 10.0 * wide + 100.0 + 2000.0)).abs() < 1e-11);
    assert!((sizes("from the right") - (wide + 10.0 * narrow + 200.0 + 1000.0)).abs() < 1e-11);
    let area = assembler.functional(&skeleton::area(&skeleton::Skeleton::on("interior"))).unwrap();
    assert!((area - 1.0).abs() < 1e-14);
    // Cell-wise constants jump by their difference, along the whole facet.
    let space = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let field = Field::from_values(&space, vec![2.0, 5.0]).unwrap();
    for (region, jump) in [("interior", -3.0), ("from the right", 3.0)] {
        let samples = assembler.along_facets_uniformly(&skeleton::difference(&field), region, 3).unwrap();
        assert_eq!(samples.iter().map(|sample| sample.value[0]).collect::<Vec<_>>(), [jump; 3]);
        let entity = Entity::InteriorFacets;
        let points =
            assembler.at_quadrature_points(&skeleton::difference(&field), entity, region, 2).unwrap();
        assert!(points.values.iter().all(|value| value[0] == jump));
        assert!((points.weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }
}

fn penalty_data(
    source: impl Fn(&[f64; 2]) -> f64 + Send + Sync + 'static,
    wanted: fn(&[f64; 2]) -> f64,
) -> penalty::Data<2> {
    penalty::data().source(source).wanted(wanted).gamma(20.0)
}

fn solve(mesh: &Mesh<2>, degree: usize, data: &penalty::Data<2>) -> Field<2> {
    let space = Space::discontinuous_scalar(mesh, degree).unwrap();
    let form = penalty::poisson(
        data,
        &penalty::Omega::on("all"),
        &penalty::Wall::on("boundary"),
        &penalty::Skeleton::on("interior"),
    );
    let problem = Problem::new(&form, &space).quadrature(Quadrature::Degree(6));
    let mut solver = TangentSolver::default();
    let u = problem.solver(&mut solver).solve().unwrap().into_field();
    assert_eq!(solver.is_positive_definite(), Some(true));
    u
}

#[test]
fn interior_penalty_holds_polynomials_exactly() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = square(shape, 4);
        let linear = |x: &[f64; 2]| 1.0 + 2.0 * x[0] - 3.0 * x[1];
        let quadratic = |x: &[f64; 2]| x[0] * x[0] - 2.0 * x[0] * x[1] + 0.5 * x[1];
        for (degree, exact, source) in
            [(1, linear as fn(&[f64; 2]) -> f64, 0.0), (2, quadratic as fn(&[f64; 2]) -> f64, -2.0)]
        {
            let u = solve(&mesh, degree, &penalty_data(move |_| source, exact));
            for (value, x) in u.values().iter().zip(u.space().positions()) {
                assert!((value - exact(x)).abs() < 1e-11, "{shape:?} degree {degree}");
            }
        }
    }
}

#[test]
fn interior_penalty_converges_with_the_full_order() {
    const PI: f64 = std::f64::consts::PI;
    let exact = |x: &[f64; 2]| (PI * x[0]).sin() * (PI * x[1]).cos();
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        for degree in [1, 2] {
            let error = |cells| {
                let mesh = square(shape, cells);
                let u = solve(&mesh, degree, &penalty_data(move |x| 2.0 * PI * PI * exact(x), exact));
                let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8));
                let value = move |x: &[f64; 2], out: &mut [f64]| out[0] = exact(x);
                norms::errors(&assembler, &u, value, |_, slope| slope.fill(0.0)).unwrap().l2
            };
            let order = (error(8) / error(16)).log2();
            assert!(order > degree as f64 + 0.8, "{shape:?} degree {degree}: order {order}");
        }
    }
}

// The matrix is the derivative of the residual, block by block of the sides, and its pattern that of the two cells.
#[test]
fn tangents_on_interior_facets_are_derivatives() {
    let mesh = square(CellShape::Triangle, 3);
    let space = Space::discontinuous_scalar(&mesh, 1).unwrap();
    let form = skeleton::adhesion(&skeleton::Skeleton::on("interior"));
    let assembler = Assembler::new(&mesh);
    let u = broken(&space);
    let spaces = [&space];
    let matrix = assembler.tangent(&form, &[&u], &spaces).unwrap();
    let pattern = BlockPattern::for_form(&form, &spaces, &spaces).unwrap();
    assert_eq!(**matrix.pattern(), **pattern.pattern());
    // Each unknown meets those of its cell and of the cells across its facets, and no more.
    let neighbours = |cell: u32| {
        mesh.interior_facets().iter().filter(|sides| sides.iter().any(|side| side.cell == cell)).count()
    };
    for cell in 0..mesh.cell_count() {
        for &node in space.cell_nodes(cell) {
            assert_eq!(pattern.pattern().row(node as usize).len(), 3 * (1 + neighbours(cell as u32)));
        }
    }
    let step = 1e-6;
    for unknown in (0..space.unknowns()).step_by(5) {
        let residual = |sign: f64| {
            let mut values = u.values().to_vec();
            values[unknown] += sign * step;
            let moved = Field::from_values(&space, values).unwrap();
            assembler.residual(&form, &[&moved], &spaces).unwrap()
        };
        for (row, (a, b)) in residual(1.0).iter().zip(residual(-1.0)).enumerate() {
            assert!(((a - b) / (2.0 * step) - matrix.get(row, unknown)).abs() < 1e-8);
        }
    }
    let active = assembler.active_set(&form, &[&u]).unwrap().unwrap();
    assert!(active.contains(&0) && active.iter().any(|bits| *bits != 0));
    // Every facet has one element matrix per pair of sides and integral; their sum is the matrix.
    let mut sum = vec![vec![0.0; space.unknowns()]; space.unknowns()];
    for element in assembler.element_matrices(&form, &[&u], &spaces).unwrap() {
        let cells = [element.cell, element.opposite.unwrap().cell];
        let of = |side: Side| space.cell_nodes(cells[usize::from(side == Side::Other)] as usize);
        for (i, row) in of(element.sides[0]).iter().enumerate() {
            for (j, column) in of(element.sides[1]).iter().enumerate() {
                sum[*row as usize][*column as usize] += element.values[i * element.columns + j];
            }
        }
    }
    for (row, sums) in sum.iter().enumerate() {
        for (column, value) in sums.iter().enumerate() {
            assert!((value - matrix.get(row, column)).abs() < 1e-13);
        }
    }
}

#[test]
fn regions_of_the_wrong_kind_are_reported() {
    let mesh = square(CellShape::Triangle, 2);
    let assembler = Assembler::new(&mesh);
    let error = assembler.functional(&skeleton::area(&skeleton::Skeleton::on("boundary"))).unwrap_err();
    assert_eq!(
        error.to_string(),
        "form `area`, region `Skeleton`: there is no region \"boundary\" of interior facets; the mesh has \
         \"interior\" (\"boundary\" consists of exterior facets, which have one side only)"
    );
    let field = broken(&Space::discontinuous_scalar(&mesh, 1).unwrap());
    let error = assembler.along_facets_uniformly(&skeleton::difference(&field), "boundary", 2).unwrap_err();
    assert_eq!(
        error.to_string(),
        "`difference` reads the other side of a facet, but the region \"boundary\" has no facets with two sides"
    );
}

// A mesh whose curved facet lies elsewhere on its other side.
#[test]
fn sides_that_do_not_meet_are_an_error() {
    let mut nodes = Vec::new();
    for y in [0.0, 0.5, 1.0] {
        nodes.extend((0..5).map(|i| [f64::from(i) * 0.5, y]));
    }
    // The right cell has a midpoint of its own on the common facet.
    nodes.push([1.1, 0.5]);
    let cells = vec![0, 2, 12, 10, 1, 7, 11, 5, 6, 2, 4, 14, 12, 3, 9, 13, 15, 8];
    let error = Mesh::from_parts(CellShape::Quadrilateral, 2, nodes, cells).unwrap_err().to_string();
    assert_eq!(
        error,
        "cells 0 and 1 name different nodes, 7 and 15, between the vertices [2, 12] that they share"
    );
}
