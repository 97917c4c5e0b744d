//! Second derivatives of fields and of basis functions, on straight and on curved cells.

use forms_fem::prelude::*;

#[forms]
mod curved {
    #[cells]
    pub struct Omega;

    pub fn bending(u: Scalar) -> Tensor {
        hess(u)
    }
    pub fn laplacian(u: State<Scalar>) -> Functional {
        integral(Omega, tr(hess(u)))
    }
    /// The biharmonic form without the terms between cells.
    pub fn plate(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, inner(hess(u), hess(v)) + tr(hess(u)) * v)
    }
}

#[test]
fn quadratics_have_constant_second_derivatives_on_straight_cells() {
    // Straight quadrilaterals and hexahedra that are no parallelograms hold no quadratics: those of a grid do.
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        for geometry in [1, 2] {
            let mesh = rectangle([0.0; 2], [1.0, 2.0], [2, 3], shape, geometry).unwrap();
            let u = |x: &[f64; 2]| 3.0 * x[0] * x[0] - 2.0 * x[0] * x[1] + 0.5 * x[1] * x[1] + x[0];
            let field = Field::interpolate(&Space::scalar(&mesh, 2).unwrap(), u).unwrap();
            let found = Assembler::new(&mesh)
                .at_points(&curved::bending(&field), &[[0.31, 0.47], [0.77, 1.9], [0.05, 1.2]])
                .unwrap();
            for value in found.values {
                for (a, b) in value.iter().zip([6.0, -2.0, -2.0, 1.0]) {
                    assert!((a - b).abs() < 1e-11, "{shape:?} {geometry}: {a} against {b}");
                }
            }
        }
    }
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        let mesh = cuboid([0.0; 3], [1.0, 2.0, 1.5], [2, 2, 1], shape, 1).unwrap();
        let u = |x: &[f64; 3]| x[0] * x[0] - 2.0 * x[0] * x[1] + 4.0 * x[1] * x[2] - 1.5 * x[2] * x[2];
        let field = Field::interpolate(&Space::scalar(&mesh, 2).unwrap(), u).unwrap();
        let found = Assembler::new(&mesh).at_points(&curved::bending(&field), &[[0.31, 0.47, 0.2]]).unwrap();
        let exact = [2.0, -2.0, 0.0, -2.0, 0.0, 4.0, 0.0, 4.0, -3.0];
        for (a, b) in found.values[0].iter().zip(exact) {
            assert!((a - b).abs() < 1e-11, "{shape:?}: {a} against {b}");
        }
    }
}

/// A degree-2 mesh of a unit box whose points are moved by a smooth map.
fn bent<const D: usize>(mesh: &Mesh<D>) -> Mesh<D> {
    let moved = |x: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|k| x[k] + 0.08 * (1.0 + x[(k + 1) % D]) * (1.3 * x[(k + 1) % D] + x[k]).sin())
    };
    let nodes = mesh.nodes().iter().map(moved).collect();
    Mesh::from_parts(mesh.cell_shape(0), 2, nodes, mesh.cells().to_vec()).unwrap()
}

macro_rules! differences_agree {
    ($mesh:expr, $dimension:literal) => {
        let mesh = bent(&$mesh);
        let space = Space::scalar(&mesh, 2).unwrap();
        // Linear fields are held exactly on curved cells: their second derivatives vanish.
        let linear = Field::interpolate(&space, |x: &[f64; $dimension]| 1.0 + x[0] - 2.0 * x[1]).unwrap();
        let values = (0..space.unknowns()).map(|index| ((index * 37 + 5) % 23) as f64 / 23.0).collect();
        let rough = Field::from_values(&space, values).unwrap();
        let assembler = Assembler::new(&mesh);
        for cell in 0..mesh.cell_count() {
            let reference = mesh.cell_shape(0).centre::<$dimension>().map(|x| x * 0.9 + 0.02);
            let point = mesh.map(cell, &reference).0;
            let zero = &assembler.at_points(&curved::bending(&linear), &[point]).unwrap().values[0];
            assert!(zero.iter().all(|value| value.abs() < 1e-10), "{:?}: {zero:?}", mesh.cell_shape(0));
            let second = &assembler.at_points(&curved::bending(&rough), &[point]).unwrap().values[0];
            let step = 1e-5;
            for axis in 0..$dimension {
                let gradient = |sign: f64| {
                    let mut moved = point;
                    moved[axis] += sign * step;
                    rough.gradient(&moved).unwrap()
                };
                for (k, (a, b)) in gradient(1.0).iter().zip(gradient(-1.0)).enumerate() {
                    let difference = (a - b) / (2.0 * step);
                    let found = second[k * $dimension + axis];
                    let scale = second.iter().fold(1.0_f64, |scale, value| scale.max(value.abs()));
                    assert!(
                        (found - difference).abs() < 1e-7 * scale,
                        "{:?}: {found} against {difference}",
                        mesh.cell_shape(0)
                    );
                }
            }
        }
    };
}

#[test]
fn second_derivatives_are_those_of_the_gradient_on_curved_cells() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        differences_agree!(rectangle([0.0; 2], [1.0; 2], [2, 2], shape, 2).unwrap(), 2);
    }
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        differences_agree!(cuboid([0.0; 3], [1.0; 3], [1, 1, 2], shape, 2).unwrap(), 3);
    }
}

// Basis functions: uᵀ K u is the integral of the field's own second derivatives.
#[test]
fn matrices_with_second_derivatives_are_those_of_the_fields() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [3, 2], CellShape::Triangle, 1).unwrap();
    let space = Space::scalar(&mesh, 2).unwrap();
    let u = Field::interpolate(&space, |x| x[0] * x[0] + 3.0 * x[0] * x[1]).unwrap();
    let one = Field::interpolate(&space, |_| 1.0).unwrap();
    let assembler = Assembler::new(&mesh);
    let (omega, spaces) = (curved::Omega::on("all"), [&space]);
    let form = curved::plate(&omega);
    let matrix = assembler.tangent(&form, &[&u], &spaces).unwrap();
    let image = matrix.multiply(u.values()).unwrap();
    let product = |v: &Field<2>| -> f64 { image.iter().zip(v.values()).map(|(a, b)| a * b).sum() };
    // hess u = [2 3; 3 0], so hess u : hess u = 22 and tr hess u = 2, on an area of 2; hess 1 = 0.
    assert!((product(&one) - 4.0).abs() < 1e-11);
    let mean = 2.0 * assembler.functional(&mean_of::of(&mean_of::Omega::on("all"), &u)).unwrap();
    assert!((product(&u) - (44.0 + mean)).abs() < 1e-10);
    let residual = assembler.residual(&form, &[&u], &spaces).unwrap();
    assert!(residual.iter().zip(&image).all(|(a, b)| (a - b).abs() < 1e-11));
    let laplacian = assembler.functional(&curved::laplacian(&omega, &u)).unwrap();
    assert!((laplacian - 4.0).abs() < 1e-12);
}

#[forms]
mod mean_of {
    #[cells]
    pub struct Omega;

    pub fn of(u: State<Scalar>) -> Functional {
        integral(Omega, u)
    }
}
