//! Shares of assemblers that own a part of the cells each add up to the whole.

use forms_fem::linear_algebra::CsrMatrix;
use forms_fem::mesh::MeshError;
use forms_fem::prelude::*;
use forms_fem::solve::NonlinearProblem;

use crate::several_shapes::patchwork;

#[forms(matrix_free)]
mod terms {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;
    #[interior_facets]
    pub struct Inside;

    pub fn body(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(sym(grad(u)), grad(v)) - dot(u, u) * div(v))
            + integral(Wall, neg_part(dot(u, n)) * dot(v, n))
    }
    pub fn contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(sym(grad(u)), grad(v)) - div(v))
            + integral(Wall, neg_part(dot(u, n) - 0.1) * dot(v, n))
    }
    pub fn across(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Inside, jump(u) * jump(v) / avg(h) - dot(avg(grad(u)), n) * jump(v))
    }
    pub fn square(w: State<Vector>) -> Scalar {
        dot(w, w)
    }
    pub fn energy(u: State<Vector>) -> Functional {
        integral(Omega, exp(dot(u, u))) + integral(Wall, dot(u, n))
    }
}

fn mesh() -> Mesh<2> {
    rectangle([0.0; 2], [2.0, 1.0], [6, 3], CellShape::Quadrilateral, 1).unwrap()
}

/// One of quadrilaterals, and one of quadrilaterals and triangles; each share has some of both.
fn meshes() -> [Mesh<2>; 2] {
    let mixed = patchwork(4, 1);
    for cells in [&mixed.cell_order().cells()[..5], &mixed.cell_order().cells()[5..]] {
        let shapes = [CellShape::Triangle, CellShape::Quadrilateral];
        let has = |shape| cells.iter().any(|cell| mixed.cell_shape(*cell as usize) == shape);
        assert!(shapes.into_iter().all(has));
    }
    [mesh(), mixed]
}

/// Three assemblers on parts of unequal size; one owns no cell.
fn shares(mesh: &Mesh<2>) -> Vec<Assembler<2>> {
    let (first, last) = mesh.cell_order().cells().split_at(5);
    let share = |cells: &&[u32]| Assembler::new(mesh).on_owned_cells(cells).unwrap();
    [first, last, &[]].iter().map(share).collect()
}

fn wave(space: &Arc<Space<2>>) -> Field<2> {
    Field::interpolate(space, |x: &[f64; 2]| [(3.0 * x[0]).sin(), x[0] * x[1] - 0.4]).unwrap()
}

fn add(sum: &mut Vec<f64>, share: &[f64]) {
    sum.resize(share.len(), 0.0);
    sum.iter_mut().zip(share).for_each(|(sum, share)| *sum += share);
}

fn assert_close(sum: &[f64], whole: &[f64]) {
    assert_eq!(sum.len(), whole.len());
    assert!(sum.iter().zip(whole).all(|(a, b)| (a - b).abs() < 1e-13), "{sum:?} {whole:?}");
}

/// The products with one vector: the patterns of shares are smaller than that of the whole.
fn products(matrix: &CsrMatrix) -> Vec<f64> {
    let x: Vec<f64> = (0..matrix.columns()).map(|k| (k as f64).cos()).collect();
    matrix.multiply(&x).unwrap()
}

#[test]
fn shares_of_cells_and_boundary_facets_add_up() {
    for mesh in meshes() {
        let space = Space::vector(&mesh, 2).unwrap();
        let u = wave(&space);
        let (omega, wall) = (terms::Omega::on("all"), terms::Wall::on("boundary"));
        let form = terms::body(&omega, &wall);
        let energy = terms::energy(&omega, &wall, &u);
        let whole = Assembler::new(&mesh);
        let (mut residual, mut product, mut action, mut integral, mut active) =
            (vec![], vec![], vec![], 0.0, 0);
        let mut entries = 0;
        let count = |bits: Option<Vec<u32>>| bits.unwrap().iter().filter(|bits| **bits != 0).count();
        for share in shares(&mesh) {
            add(&mut residual, &share.residual(&form, &[&u], &[&space]).unwrap());
            let tangent = share.tangent(&form, &[&u], &[&space]).unwrap();
            add(&mut product, &products(&tangent));
            entries = entries.max(tangent.values().len());
            add(&mut action, &share.action(&form, &[&u], &[&u], &[&space]).unwrap());
            integral += share.functional(&energy).unwrap();
            active += count(share.active_set(&form, &[&u]).unwrap());
        }
        let tangent = whole.tangent(&form, &[&u], &[&space]).unwrap();
        assert_close(&residual, &whole.residual(&form, &[&u], &[&space]).unwrap());
        assert_close(&product, &products(&tangent));
        assert_close(&action, &whole.action(&form, &[&u], &[&u], &[&space]).unwrap());
        assert_close(&[integral], &[whole.functional(&energy).unwrap()]);
        assert_eq!(active, count(whole.active_set(&form, &[&u]).unwrap()));
        assert!(active > 0 && entries < tangent.values().len());
    }
}

#[test]
fn each_interior_facet_has_one_owner() {
    for mesh in meshes() {
        let space = Space::discontinuous_scalar(&mesh, 1).unwrap();
        let u = Field::interpolate(&space, |x: &[f64; 2]| x[0].exp() + x[1]).unwrap();
        let form = terms::across(&terms::Inside::on("interior"));
        let (mut residual, mut product) = (vec![], vec![]);
        for share in shares(&mesh) {
            add(&mut residual, &share.residual(&form, &[&u], &[&space]).unwrap());
            add(&mut product, &products(&share.tangent(&form, &[&u], &[&space]).unwrap()));
        }
        let whole = Assembler::new(&mesh);
        assert_close(&residual, &whole.residual(&form, &[&u], &[&space]).unwrap());
        assert_close(&product, &products(&whole.tangent(&form, &[&u], &[&space]).unwrap()));
    }
}

/// The linear integrals once, the nonlinear ones at each iterate: both on the positions of the share.
#[test]
fn problems_of_shares_add_up_at_each_iterate() {
    for mesh in meshes() {
        let space = Space::vector(&mesh, 2).unwrap();
        let form = terms::contact(&terms::Omega::on("all"), &terms::Wall::on("boundary"));
        let (shares, whole) = (shares(&mesh), Assembler::new(&mesh));
        let mut problems: Vec<_> =
            shares.iter().map(|share| Problem::new(&form, &space).assembler(share)).collect();
        let mut problem = Problem::new(&form, &space).assembler(&whole);
        let field = wave(&space);
        for factor in [1.0, -2.0] {
            let u: Vec<f64> = field.values().iter().map(|value| factor * value).collect();
            let (mut residual, mut product) = (vec![], vec![]);
            for share in &mut problems {
                add(&mut residual, &share.residual(&u).unwrap());
                add(&mut product, &products(&share.tangent(&u).unwrap().matrix.to_csr()));
            }
            assert_close(&residual, &problem.residual(&u).unwrap());
            assert_close(&product, &products(&problem.tangent(&u).unwrap().matrix.to_csr()));
        }
    }
}

#[test]
fn projections_are_those_of_the_whole() {
    for mesh in meshes() {
        let space = Space::scalar(&mesh, 1).unwrap();
        let u = wave(&Space::vector(&mesh, 2).unwrap());
        let square = terms::square(&u);
        let whole = Assembler::new(&mesh).project(&square, &space).unwrap();
        let share = shares(&mesh)[0].project(&square, &space).unwrap();
        assert_eq!(whole.values(), share.values());
    }
}

#[test]
fn a_cell_that_the_mesh_does_not_have_is_refused() {
    let error = Assembler::new(&mesh()).on_owned_cells(&[3, 18]).unwrap_err();
    assert!(matches!(error, MeshError::NoCell { cell: 18, count: 18, .. }), "{error}");
}
