//! Declared shapes: fixed extents besides the dimension, and rank 4, of unknowns, data and results.

use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{expression, residual, tangent};

#[forms(crate = toy_backend)]
pub mod shapes {
    pub struct Data {
        r: Param<Vector<3>>,
        m: Param<Matrix<2, 3>>,
        E: Param<Tensor4>,
        g: Given<Matrix<D, 3>>,
    }
    #[cells]
    pub struct Omega;

    pub fn rows(s: Scalar) -> Vector<2> {
        s * (m * r)
    }
    pub fn given() -> Matrix<D, 3> {
        let twice: Matrix<D, 3> = 2 * g;
        twice
    }
    pub fn stiffness() -> Tensor4 {
        E
    }
    /// A field of three components in any dimension: its gradient is 3 × D.
    pub fn three(w: Unknown<Vector<3>>, q: Test<Vector<3>>, z: State<Vector<D>>) -> Form {
        integral(Omega, inner(grad(w), grad(q)) + dot(w, w) * dot(r, q) + w[2] * z[1] * q[0])
    }
    pub fn gradient(w: Vector<3>) -> Matrix<3, D> {
        grad(w)
    }
}

fn data<const D: usize>() -> shapes::Data<D> {
    shapes::data()
        .r([1.0, -2.0, 0.5])
        .m([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
        .E(std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                std::array::from_fn(|k| std::array::from_fn(|l| (1000 * i + 100 * j + 10 * k + l) as f64))
            })
        }))
        .g(|x: &[f64; D]| std::array::from_fn(|i| [x[i], 1.0, i as f64]))
}

fn check<const D: usize>()
where
    Dim: Dimension<D>,
{
    let mut random = Random(31);
    let mesh = Mesh::<D>::cube(&mut random);
    let cells = (Entity::Cells, "all");
    let data = data::<D>();

    let rows = shapes::rows(&data, Source::Constant(vec![2.0]));
    assert_eq!(rows.shape(), &[2]);
    assert_eq!(expression(&mesh, &rows, cells)[0], [2.0 * (1.0 - 4.0 + 1.5), 2.0 * (4.0 - 10.0 + 3.0)]);

    let given = shapes::given(&data);
    assert_eq!(given.shape(), &[D, 3]);
    let found = expression(&mesh, &given, cells);
    let places = mesh.elements(Entity::Cells, "all");
    for (found, point) in found.iter().zip(places.iter().flat_map(|cell| &cell.points)) {
        let x = point.geometry.position;
        let expected: Vec<f64> = (0..D).flat_map(|i| [2.0 * x[i], 2.0, 2.0 * i as f64]).collect();
        assert_eq!(*found, expected);
    }

    let stiffness = shapes::stiffness(&data);
    assert_eq!(stiffness.shape(), &[D; 4]);
    let entries = &expression(&mesh, &stiffness, cells)[0];
    assert_eq!(entries.len(), D.pow(4));
    assert_eq!(entries[((D + 1) * D) * D + 1], 1101.0);

    let w = random.field(mesh.nodes.len(), 3, 0.0, 0.4);
    let gradient = shapes::gradient(&data, w.source());
    assert_eq!(gradient.shape(), &[3, D]);

    let three = shapes::three(&data, &shapes::Omega::on("all"), Source::Constant(vec![0.3; D]));
    assert_eq!(three.fields()[0].shape, &[3]);
    let matrix = tangent::<f64, D>(&mesh, &three, std::slice::from_ref(&w));
    let step = 1e-5;
    for column in 0..w.values.len() {
        let at = |step: f64| {
            let mut moved = w.clone();
            moved.values[column] += step;
            residual::<f64, D>(&mesh, &three, &[moved])
        };
        let (above, below) = (at(step), at(-step));
        for row in 0..matrix.len() {
            let difference = (above[row] - below[row]) / (2.0 * step);
            assert!((difference - matrix[row][column]).abs() <= 2e-8 * matrix[row][column].abs().max(1.0));
        }
    }
}

#[test]
fn in_2d() {
    check::<2>();
}

#[test]
fn in_3d() {
    check::<3>();
}
