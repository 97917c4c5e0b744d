//! Matrices, vectors and numbers do not depend on the number of threads, to the last bit.

use forms_fem::assemble::BlockPattern;
use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::prelude::*;

#[forms]
mod terms {
    pub struct Data {
        mu: Param,
        pressure: Param,
    }
    #[cells]
    pub struct Omega;
    #[cells]
    pub struct Core;
    #[facets]
    pub struct Wall;
    #[interior_facets]
    pub struct Inside;

    /// Cells, a part of the cells and facets; linear and not.
    pub fn body(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, mu * inner(sym(grad(u)), grad(v)) + (1 + dot(u, u)) * div(u) * div(v))
            + integral(Core, dot(u, v))
            + integral(Wall, neg_part(dot(u, n)) * dot(v, n) - pressure * dot(v, n))
    }
    pub fn mixed(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, inner(grad(u), grad(v)) - p * div(v) - q * div(u))
    }
    pub fn across(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Inside, jump(u) * jump(v) / avg(h) - dot(avg(grad(u)), n) * jump(v))
    }
    pub fn tied(u: Unknown<Scalar>, m: Unknown<Scalar>, v: Test<Scalar>, w: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v))) + integral(Wall, m * v + u * w)
    }
    pub fn energy(u: Unknown<Vector>) -> Functional {
        integral(Omega, exp(dot(u, u))) + integral(Wall, dot(u, n))
    }
}

const THREADS: [usize; 3] = [2, 3, 5];

fn data<const D: usize>() -> terms::Data<D> {
    terms::data().mu(1.3).pressure(0.7)
}

/// The mesh with its cells and nodes numbered at random, and a cell region "core".
fn shuffled<const D: usize>(mesh: Mesh<D>) -> Mesh<D> {
    let permutation = |count: usize| {
        let mut numbers: Vec<usize> = (0..count).collect();
        let mut state = 12_345_u64;
        for last in (1..count).rev() {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            numbers.swap(last, (state >> 33) as usize % (last + 1));
        }
        numbers
    };
    let (cells, nodes) = (permutation(mesh.cell_count()), permutation(mesh.node_count()));
    let mut places = mesh.nodes().to_vec();
    for (old, new) in nodes.iter().enumerate() {
        places[*new] = mesh.nodes()[old];
    }
    let numbers = cells.iter().flat_map(|&cell| mesh.cell(cell)).map(|&node| nodes[node as usize] as u32);
    let mut mesh = Mesh::from_parts(mesh.cell_shape(0), mesh.degree(), places, numbers.collect()).unwrap();
    mesh.name_cells("core", |centre| centre.iter().all(|x| (x - 0.5).abs() < 0.3)).unwrap();
    mesh
}

fn structured<const D: usize>(mut mesh: Mesh<D>) -> Mesh<D> {
    mesh.name_cells("core", |centre| centre.iter().all(|x| (x - 0.5).abs() < 0.3)).unwrap();
    mesh
}

fn wave<const D: usize>(space: &Arc<Space<D>>) -> Field<D> {
    let values = (0..space.unknowns()).map(|k| (k as f64 * 0.37).sin()).collect();
    Field::from_values(space, values).unwrap()
}

/// Tangent and residual of a form for each number of threads.
fn same<const D: usize>(form: &Form<D>, mesh: &Mesh<D>, spaces: &[&Arc<Space<D>>]) {
    let fields: Vec<Field<D>> = spaces.iter().map(|space| wave(space)).collect();
    let fields: Vec<&Field<D>> = fields.iter().collect();
    let pattern = BlockPattern::for_form(form, spaces, spaces).unwrap();
    let assemble = |threads: usize| {
        let assembler = Assembler::new(mesh).with_threads(Threads::new(threads));
        // Made on as many threads; the places of the blocks show in the values.
        let found = assembler.pattern(form, spaces, spaces).unwrap();
        assert!(found.sparsity() == pattern.sparsity(), "pattern on {threads} threads");
        assert!(found.sparsity().cells() == pattern.sparsity().cells(), "cells on {threads} threads");
        let pattern = found;
        let mut matrix = BlockMatrix::zero(pattern.sparsity());
        // What was in the matrix must not matter.
        matrix.values_mut().fill(f64::NAN);
        assembler.assemble_tangent(form, &fields, spaces, Parts::ALL, &pattern, &mut matrix).unwrap();
        let again = matrix.clone();
        assembler.add_tangent(form, &fields, spaces, Parts::ALL, &pattern, &mut matrix).unwrap();
        (again, matrix, assembler.residual(form, &fields, spaces).unwrap())
    };
    let alone = assemble(1);
    assert!(alone.0.values().iter().all(|value| value.is_finite()));
    for threads in THREADS {
        assert!(assemble(threads) == alone, "{} on {threads} threads", form.name());
    }
    // Linear and nonlinear integrals one after the other, on threads that need not be the same.
    let assembler = Assembler::new(mesh).with_threads(Threads::new(2));
    let mut sums = BlockMatrix::zero(pattern.sparsity());
    assembler.add_tangent(form, &fields, spaces, Parts::LINEAR_AND_CONSTANT, &pattern, &mut sums).unwrap();
    assembler.add_tangent(form, &fields, spaces, Parts::NONLINEAR, &pattern, &mut sums).unwrap();
    let scale = sums.values().iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    assert!(sums.values().iter().zip(alone.0.values()).all(|(a, b)| (a - b).abs() <= 1e-13 * scale));
    // The matrix, which goes by the map, is the derivative of the vector, which does not.
    let step = 1e-6;
    let moved = |sign: f64| {
        let shifted = |field: &&Field<D>| {
            let direction = direction(field.values().len());
            let values = field.values().iter().zip(direction).map(|(u, d)| u + sign * step * d).collect();
            Field::from_values(field.space(), values).unwrap()
        };
        let fields: Vec<Field<D>> = fields.iter().map(shifted).collect();
        assembler.residual(form, &fields.iter().collect::<Vec<_>>(), spaces).unwrap()
    };
    let direction: Vec<f64> = fields.iter().flat_map(|field| direction(field.values().len())).collect();
    let product = alone.0.multiply(&direction).unwrap();
    let scale = product.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    for ((ahead, behind), product) in moved(1.0).iter().zip(moved(-1.0)).zip(product) {
        let slope = (ahead - behind) / (2.0 * step);
        assert!((slope - product).abs() <= 1e-6 * scale, "{}: {slope} against {product}", form.name());
    }
}

fn direction(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(|k| (k as f64 * 0.91).cos())
}

#[test]
fn matrices_and_vectors() {
    let triangles = |degree| rectangle([0.0; 2], [1.0; 2], [24, 24], CellShape::Triangle, degree).unwrap();
    let quadrilaterals = rectangle([0.0; 2], [1.0; 2], [24, 24], CellShape::Quadrilateral, 2).unwrap();
    let meshes = [
        (structured(triangles(1)), 1),
        (shuffled(triangles(1)), 2),
        (shuffled(triangles(2)), 2),
        (shuffled(quadrilaterals), 2),
    ];
    for (mesh, degree) in meshes {
        let (vectors, scalars) = (Space::vector(&mesh, degree).unwrap(), Space::scalar(&mesh, 1).unwrap());
        let (omega, wall) = (terms::Omega::on("all"), terms::Wall::on("boundary"));
        same(&terms::body(&data(), &omega, &terms::Core::on("core"), &wall), &mesh, &[&vectors]);
        same(&terms::mixed(&data(), &omega), &mesh, &[&vectors, &scalars]);
        let discontinuous = Space::discontinuous_scalar(&mesh, degree).unwrap();
        same(&terms::across(&data(), &terms::Inside::on("interior")), &mesh, &[&discontinuous]);
        let traces = Space::on_facets(&mesh, "boundary", 1).unwrap();
        same(&terms::tied(&data(), &omega, &wall), &mesh, &[&scalars, &traces]);
    }
}

#[test]
fn three_dimensions() {
    let tetrahedra = cuboid([0.0; 3], [1.0; 3], [6; 3], CellShape::Tetrahedron, 1).unwrap();
    let mesh = shuffled(tetrahedra);
    let space = Space::vector(&mesh, 2).unwrap();
    let wall = terms::Wall::on("boundary");
    let form = terms::body(&data(), &terms::Omega::on("all"), &terms::Core::on("core"), &wall);
    same(&form, &mesh, &[&space]);
    let discontinuous = Space::discontinuous_scalar(&mesh, 1).unwrap();
    same(&terms::across(&data(), &terms::Inside::on("interior")), &mesh, &[&discontinuous]);
}

#[test]
fn numbers_and_active_points() {
    let mesh = shuffled(rectangle([0.0; 2], [1.0; 2], [40, 40], CellShape::Triangle, 1).unwrap());
    let space = Space::vector(&mesh, 2).unwrap();
    let u = wave(&space);
    let (omega, wall) = (terms::Omega::on("all"), terms::Wall::on("boundary"));
    let energy = terms::energy(&data(), &omega, &wall);
    let form = terms::body(&data(), &omega, &terms::Core::on("core"), &wall);
    let of = |threads| {
        let assembler = Assembler::new(&mesh).with_threads(Threads::new(threads));
        let active = assembler.active_set(&form, &[&u]).unwrap();
        (assembler.energy(&energy, &[&u]).unwrap().to_bits(), active)
    };
    let alone = of(1);
    assert!(alone.1.as_ref().is_some_and(|bits| bits.contains(&1)));
    for threads in THREADS {
        assert_eq!(of(threads), alone);
    }
}

/// The error is that of the first cell of the walk, whichever thread is first.
#[test]
fn the_first_error_counts() {
    let mesh = shuffled(rectangle([0.0; 2], [1.0; 2], [40, 40], CellShape::Triangle, 1).unwrap());
    let space = Space::scalar(&mesh, 1).unwrap();
    let form = form!(
        |u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), w * u * v),
        w: Given<Scalar> = |x: &[f64; 2]| if x[0] > 0.3 { f64::NAN } else { 1.0 },
    );
    let error = |threads| {
        let assembler = Assembler::new(&mesh).with_threads(Threads::new(threads));
        assembler.tangent(&form, &[&Field::zero(&space)], &[&space]).unwrap_err()
    };
    let alone = error(1);
    for threads in THREADS {
        assert_eq!(error(threads), alone);
    }
}
