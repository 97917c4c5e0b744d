//! `derivative(.., shape, Θ)` against central differences of what is assembled on meshes that have moved.

use forms_fem::movement::{MovementError, diameters_to_movements};
use forms_fem::prelude::*;

#[forms]
mod moving {
    pub struct Data {
        mu: Param,
        source: Given<Scalar>,
        pull: Given<Vector>,
        stiffness: Carried<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;
    #[interior_facets]
    pub struct Skeleton;

    /// Values, gradients, positions, data of both kinds, a kink, h.
    pub fn in_cells(u: State<Vector>) -> Functional {
        let F = I + grad(u);
        integral(
            Omega,
            stiffness * mu * inner(F, F) * det(F)
                + source * dot(pull, u)
                + norm(x) * exp(u[0])
                + h * div(u)
                + pos_part(u[1] + 2) * u[0],
        )
    }
    /// Second derivatives.
    pub fn bending(u: State<Vector>) -> Functional {
        integral(Omega, inner(hess(u), hess(u)) + dot(div(grad(u)), x))
    }
    pub fn on_walls(u: State<Vector>) -> Functional {
        integral(Wall, dot(grad(u) * n, n) * dot(u, x) + source * dot(pull, n) + dot(x, n) / h)
    }
    /// Both sides, and what has none.
    pub fn on_skeleton(u: State<Vector>, k: State<Scalar>) -> Functional {
        integral(
            Skeleton,
            dot(avg(k * grad(u)) * n, jump(grad(u)) * n)
                + avg(h) * dot(jump(k, n), x)
                + norm(x)
                + jump(source * dot(u, x), n)[0] * jump(k),
        )
    }
    /// A form at a known test function.
    fn tested(u: Vector, v: Vector) -> Form {
        integral(Omega, mu * inner(eps(u), eps(v)) * dot(u, u) - dot(pull, v))
            + integral(Wall, dot(u, n) * dot(v, x))
    }
    pub fn residual(u: State<Vector>, v: State<Vector>) -> Functional {
        tested(u, v)
    }

    pub fn in_cells_along(u: State<Vector>, T: State<Vector>, rate: State<Scalar>) -> Functional {
        derivative(in_cells(u), shape, T) + derivative(in_cells(u), h, rate)
    }
    pub fn bending_along(u: State<Vector>, T: State<Vector>) -> Functional {
        derivative(bending(u), shape, T)
    }
    pub fn on_walls_along(u: State<Vector>, T: State<Vector>, rate: State<Scalar>) -> Functional {
        derivative(on_walls(u), shape, T) + derivative(on_walls(u), h, rate)
    }
    pub fn on_skeleton_along(
        u: State<Vector>,
        k: State<Scalar>,
        T: State<Vector>,
        rate: State<Scalar>,
    ) -> Functional {
        derivative(on_skeleton(u, k), shape, T) + derivative(on_skeleton(u, k), h, rate)
    }
    pub fn residual_along(u: State<Vector>, v: State<Vector>, T: State<Vector>) -> Functional {
        derivative(tested(u, v), shape, T)
    }
    /// Along S, then along T.
    pub fn residual_twice(
        u: State<Vector>,
        v: State<Vector>,
        S: State<Vector>,
        T: State<Vector>,
    ) -> Functional {
        derivative(derivative(tested(u, v), shape, S), shape, T)
    }
    /// The gradient by nodes.
    pub fn gradient(u: State<Vector>, k: State<Scalar>, T: Test<Vector>) -> Form {
        derivative(in_cells(u) + on_walls(u) + on_skeleton(u, k), shape, T)
    }
    pub fn gradient_by_diameters(u: State<Vector>, k: State<Scalar>, r: Test<Scalar>) -> Form {
        derivative(in_cells(u) + on_walls(u) + on_skeleton(u, k), h, r)
    }
    /// A linear form at a known movement.
    pub fn moving_residual(u: State<Vector>, v: Test<Vector>, T: State<Vector>) -> Form {
        derivative(tested(u, v), shape, T)
    }
    /// A derived field: ∇u as the points move.
    pub fn moving_gradient(u: Vector, T: Vector) -> Tensor {
        derivative(grad(u), shape, T)
    }
    /// Sizes are frozen.
    pub fn sizes_along(T: State<Vector>) -> Functional {
        derivative(integral(Omega, cell_volume), shape, T) + derivative(integral(Wall, facet_area), shape, T)
    }
    pub fn sizes_frozen(T: State<Vector>) -> Functional {
        integral(Omega, cell_volume * div(T)) + integral(Wall, facet_area * (div(T) - dot(grad(T) * n, n)))
    }
}

/// Some smooth vector, different for each seed.
fn wave<const D: usize>(x: &[f64; D], seed: f64) -> [f64; D] {
    std::array::from_fn(|k| 0.3 * (seed + k as f64 + 1.7 * x[k] + 0.9 * x[(k + 1) % D]).sin())
}

/// The mesh with its nodes moved by a smooth map: cells are irregular, those of degree 2 curved.
fn bent<const D: usize>(mesh: Mesh<D>) -> Mesh<D> {
    let nodes = mesh.nodes().iter().map(|x| {
        let by = wave(x, 0.4);
        std::array::from_fn(|k| x[k] + 0.3 * by[k])
    });
    mesh.with_nodes(nodes.collect()).unwrap()
}

/// A mesh with fields that keep their nodal values wherever it moves.
struct Body<const D: usize> {
    assembler: Assembler<D>,
    u: Field<D>,
    v: Field<D>,
    k: Field<D>,
}

impl<const D: usize> Body<D> {
    fn new(mesh: &Mesh<D>) -> Self {
        let space = Space::vector(mesh, mesh.degree()).unwrap();
        let broken = Space::discontinuous_scalar(mesh, 1).unwrap();
        let values = (0..broken.unknowns()).map(|index| 1.0 + ((index * 37) % 11) as f64 / 11.0).collect();
        // The same points on all meshes.
        let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(4));
        Body {
            assembler,
            u: Field::interpolate(&space, |x| wave(x, 1.0)).unwrap(),
            v: Field::interpolate(&space, |x| wave(x, 2.0)).unwrap(),
            k: Field::from_values(&broken, values).unwrap(),
        }
    }

    fn moved(&self, along: &Field<D>, step: f64) -> Self {
        let mesh = along.move_mesh(step).unwrap();
        let space = Space::vector(&mesh, mesh.degree()).unwrap();
        Body {
            assembler: Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4)),
            u: self.u.carried_to(&space).unwrap(),
            v: self.v.carried_to(&space).unwrap(),
            k: self.k.carried_to(&Space::discontinuous_scalar(&mesh, 1).unwrap()).unwrap(),
        }
    }

    fn movement(&self, seed: f64) -> Field<D> {
        let space = Space::of_geometry(self.assembler.mesh()).unwrap();
        Field::interpolate(&space, |x| wave(x, seed)).unwrap()
    }

    /// Central differences along a movement, extrapolated from two steps: fourth order.
    fn difference(&self, along: &Field<D>, value: impl Fn(&Body<D>) -> f64) -> f64 {
        let central = |step: f64| {
            let [forth, back] = [step, -step].map(|step| value(&self.moved(along, step)));
            (forth - back) / (2.0 * step)
        };
        (4.0 * central(1e-3) - central(2e-3)) / 3.0
    }
}

/// Differences of fourth order: h⁴ f⁗ and rounding.
fn close(label: &str, found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{label}: {found} against {expected}");
    assert!(found.abs() > 1e-4, "{label}: {found} says nothing");
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

macro_rules! agree {
    ($test:ident, $dimension:literal, $shapes:expr, $make:expr) => {
        #[test]
        fn $test() {
            for (shape, degree) in $shapes.into_iter().flat_map(|shape| [(shape, 1), (shape, 2)]) {
                let mesh: Mesh<$dimension> = $make(shape, degree).unwrap();
                let body = Body::new(&bent(mesh));
                let data = moving::data::<$dimension>()
                    .mu(1.3)
                    .source(Given::function_with_gradient(
                        |x| x[0] * x[1] + 1.0,
                        |x| std::array::from_fn(|k| if k < 2 { x[1 - k] } else { 0.0 }),
                    ))
                    .pull(Given::function_with_gradient(
                        |x| x.map(|x| x * x),
                        |x| {
                            let entry = |i: usize, j: usize| if i == j { 2.0 * x[i] } else { 0.0 };
                            std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
                        },
                    ))
                    .stiffness(0.7);
                let (omega, wall) = (moving::Omega::on("all"), moving::Wall::on("boundary"));
                let skeleton = moving::Skeleton::on("interior");
                let (along, other) = (body.movement(5.0), body.movement(6.0));
                let rate = along.rate_of_diameter().unwrap();
                let Body { assembler, u, v, k } = &body;
                macro_rules! check {
                    ($what:literal, $found:expr, |$at:ident| $value:expr) => {
                        let expected =
                            body.difference(&along, |$at| $at.assembler.functional(&$value).unwrap());
                        let found = assembler.functional(&$found).unwrap();
                        close(&format!("{shape:?} of degree {degree}, {}", $what), found, expected);
                    };
                }
                check!("cells", moving::in_cells_along(&data, &omega, u, &along, &rate), |at| {
                    moving::in_cells(&data, &omega, &at.u)
                });
                check!("walls", moving::on_walls_along(&data, &wall, u, &along, &rate), |at| {
                    moving::on_walls(&data, &wall, &at.u)
                });
                check!("skeleton", moving::on_skeleton_along(&data, &skeleton, u, k, &along, &rate), |at| {
                    moving::on_skeleton(&data, &skeleton, &at.u, &at.k)
                });
                check!("a residual", moving::residual_along(&data, &omega, &wall, u, v, &along), |at| {
                    moving::residual(&data, &omega, &wall, &at.u, &at.v)
                });
                // Second derivatives of degree 1 vanish on simplices.
                if degree == 2 {
                    check!("bending", moving::bending_along(&data, &omega, u, &along), |at| {
                        moving::bending(&data, &omega, &at.u)
                    });
                }
                // The first derivative along one movement, differentiated along another: given data need second derivatives.
                let plain = data.clone().source(1.1).pull([0.4; $dimension]);
                let twice = moving::residual_twice(&plain, &omega, &wall, u, v, &other, &along);
                check!("twice", twice, |at| {
                    let carried =
                        other.carried_to(&Space::of_geometry(at.assembler.mesh()).unwrap()).unwrap();
                    moving::residual_along(&plain, &omega, &wall, &at.u, &at.v, &carried)
                });

                // As a linear form it is the same, whatever the movement.
                let space = along.space();
                let mut gradient = assembler
                    .linear_form(&moving::gradient(&data, &omega, &wall, &skeleton, u, k), space)
                    .unwrap();
                let cells = rate.space();
                let by_diameters = assembler
                    .linear_form(&moving::gradient_by_diameters(&data, &omega, &wall, &skeleton, u, k), cells)
                    .unwrap();
                let share = diameters_to_movements(space, &by_diameters).unwrap();
                close("diameters", dot(&share, along.values()), dot(&by_diameters, rate.values()));
                gradient.iter_mut().zip(share).for_each(|(entry, share)| *entry += share);
                let whole = assembler
                    .functional(&moving::in_cells_along(&data, &omega, u, &along, &rate))
                    .unwrap()
                    + assembler.functional(&moving::on_walls_along(&data, &wall, u, &along, &rate)).unwrap()
                    + assembler
                        .functional(&moving::on_skeleton_along(&data, &skeleton, u, k, &along, &rate))
                        .unwrap();
                close("by nodes", dot(&gradient, along.values()), whole);

                // With a test function in the form: R′(u; v) is the number above.
                let moving_form = moving::moving_residual(&data, &omega, &wall, u, &along);
                let vector = assembler.linear_form(&moving_form, v.space()).unwrap();
                let number = moving::residual_along(&data, &omega, &wall, u, v, &along);
                close("tested", dot(&vector, v.values()), assembler.functional(&number).unwrap());

                // Frozen sizes, and a derived field: ∇u moves by −∇u ∇Θ.
                let sizes = assembler.functional(&moving::sizes_along(&data, &omega, &wall, &along)).unwrap();
                let frozen =
                    assembler.functional(&moving::sizes_frozen(&data, &omega, &wall, &along)).unwrap();
                close("sizes", sizes, frozen);
                let point = assembler.mesh().cell_centre(0);
                let found = assembler.at_point(&moving::moving_gradient(&data, u, &along), point).unwrap();
                let (first, second) = (u.gradient(&point).unwrap(), along.gradient(&point).unwrap());
                for (entry, found) in found.iter().enumerate() {
                    let (i, j) = (entry / $dimension, entry % $dimension);
                    let product = |k: usize| first[i * $dimension + k] * second[k * $dimension + j];
                    let exact = -(0..$dimension).map(product).sum::<f64>();
                    assert!((found - exact).abs() < 1e-12, "{shape:?}: {found} against {exact}");
                }
            }
        }
    };
}

agree!(
    in_the_plane_derivatives_are_those_of_moved_meshes,
    2,
    [CellShape::Triangle, CellShape::Quadrilateral],
    |shape, degree| rectangle([0.5, 0.2], [1.5, 1.4], [3, 2], shape, degree)
);
agree!(
    in_space_derivatives_are_those_of_moved_meshes,
    3,
    [CellShape::Tetrahedron, CellShape::Hexahedron],
    |shape, degree| cuboid([0.5, 0.2, 0.1], [1.5, 1.4, 1.0], [2, 1, 1], shape, degree)
);

#[test]
fn a_missing_gradient_is_named() {
    let mesh = rectangle([0.5, 0.2], [1.5, 1.4], [2, 2], CellShape::Triangle, 1).unwrap();
    let body = Body::new(&mesh);
    let along = body.movement(5.0);
    let data = moving::data::<2>()
        .mu(1.0)
        .source(1.0)
        .pull(Given::function(|x| *x))
        .stiffness(Given::function(|x| x[0]));
    let (omega, wall) = (moving::Omega::on("all"), moving::Wall::on("boundary"));
    let form = moving::residual_along(&data, &omega, &wall, &body.u, &body.v, &along);
    let message = body.assembler.functional(&form).unwrap_err().to_string();
    assert_eq!(
        message,
        "form `residual_along` reads the gradient of `pull`, which is given as a function of position alone; \
         give it with its gradient (`Given::function_with_gradient`) or as a field on a space"
    );
}

#[test]
fn movements_that_are_none_are_told() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1).unwrap();
    let inwards = Field::interpolate(&Space::of_geometry(&mesh).unwrap(), |x| [-x[0], 0.0]).unwrap();
    assert!(inwards.move_mesh(0.9).is_ok());
    let message = inwards.move_mesh(1.5).unwrap_err().to_string();
    assert!(message.starts_with("after a movement with step 1.5e0: cell 0 is inverted"), "{message}");
    let quadratic = Field::zero(&Space::vector(&mesh, 2).unwrap());
    let message = quadratic.move_mesh(0.1).unwrap_err().to_string();
    assert_eq!(
        message,
        "a mesh moves along a field on the space of its geometry, `Space::of_geometry`: continuous vectors of degree 1; \
         this one has Lagrange elements of degree 2 with continuous values and 2 components"
    );
    assert!(matches!(quadratic.carried_to(inwards.space()), Err(MovementError::OtherNodes)));
    let lengths = diameters_to_movements(inwards.space(), &[1.0]);
    assert_eq!(lengths, Err(MovementError::Length { cells: 4, found: 1 }));
    let moved = inwards.move_mesh(0.3).unwrap();
    assert_eq!(moved.facet_region("right").unwrap(), mesh.facet_region("right").unwrap());
    let short = mesh.with_nodes(vec![[0.0; 2]; 3]).unwrap_err().to_string();
    assert_eq!(short, "3 positions were given, but the mesh has 9 nodes");
}

/// Two diagonals are equally long: the rate is their mean.
#[test]
fn the_diameter_grows_with_the_distance_of_its_vertices() {
    let mesh = rectangle([0.0; 2], [3.0, 4.0], [1, 1], CellShape::Quadrilateral, 1).unwrap();
    let stretch = Field::interpolate(&Space::of_geometry(&mesh).unwrap(), |x| [x[0], 0.0]).unwrap();
    assert!((stretch.rate_of_diameter().unwrap().values()[0] - 9.0 / 5.0).abs() < 1e-14);
    let shear = Field::interpolate(&Space::of_geometry(&mesh).unwrap(), |x| [x[1], 0.0]).unwrap();
    assert!(shear.rate_of_diameter().unwrap().values()[0].abs() < 1e-14);
}
