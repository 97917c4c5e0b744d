//! Means over own facets, `means(Touch(u), degree, e)`: values by hand, tangents and adjoints, energies, sums, threads, and the pointwise
//! form where a facet has one point.

use forms_fem::prelude::*;
use forms_fem::verification;

#[forms]
mod rubber {
    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
        kappa: Param,
        old: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    fn first_piola(u: Vector) -> Tensor {
        let F = I + grad(u);
        diff(mu / 2 * (inner(F, F) - D - 2 * ln(det(F))) + lambda / 2 * pow(ln(det(F)), 2), F)
    }
    fn ball(q: Vector, s: Scalar) -> Vector {
        if s <= 0 {
            0 * q
        } else if dot(q, q) <= s * s {
            q
        } else {
            s / norm(q) * q
        }
    }
    fn along(q: Vector) -> Vector {
        q - dot(q, toward) * toward
    }
    fn traction(u: Vector) -> Vector {
        this(first_piola(u) * n)
    }
    fn gamma() -> Scalar {
        gamma0 / this(h)
    }
    fn slip(u: Vector) -> Vector {
        jump(u - old)
    }
    fn stored(u: Vector, v: Vector) -> Form {
        integral(Omega, inner(first_piola(u), grad(v)))
    }

    /// Pressure and friction of the means, tested with means.
    fn of_means(u: Vector, v: Vector) -> Scalar {
        let p = neg_part(mean(dot(traction(u), toward) + gamma() * gap));
        let q = ball(mean(along(traction(u) - gamma() * slip(u))), kappa * p);
        p * mean(dot(toward, jump(v))) - dot(q, mean(along(jump(v))))
    }
    pub fn one_per_facet(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        stored(u, v) + means(Touch(u), 0, of_means(u, v))
    }
    pub fn one_per_vertex(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        stored(u, v) + means(Touch(u), 1, of_means(u, v))
    }
    /// The same at points.
    pub fn at_points(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let p = neg_part(dot(traction(u), toward) + gamma() * gap);
        let q = ball(along(traction(u) - gamma() * slip(u)), kappa * p);
        stored(u, v) + integral(Touch(u), p * dot(toward, jump(v)) - dot(q, along(jump(v))))
    }
    pub fn adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(one_per_facet(u, p), u, q)
    }
    pub fn penalty(u: Unknown<Vector>) -> Energy {
        means(Touch(u), 0, gamma0 / 2 * sqr(neg_part(mean(gap))))
    }
    pub fn penalty_per_vertex(u: Unknown<Vector>) -> Energy {
        means(Touch(u), 1, gamma0 / 2 * sqr(neg_part(mean(gap))) + kappa * pow(mean(gap), 4))
    }
}

/// Numbers on pairs of fixed points.
#[forms]
mod fixed {
    #[pairs]
    pub struct Touch;
    pub fn lengths() -> Functional {
        means(Touch, 0, mean(1))
    }
    pub fn squares() -> Functional {
        means(Touch, 0, sqr(mean(x[0])))
    }
    pub fn squares_by_vertices() -> Functional {
        means(Touch, 1, sqr(mean(x[0])))
    }
    pub fn springs(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        means(Touch, 0, dot(mean(jump(u)), mean(jump(v))) / this(h))
    }
    pub fn stored(u: Unknown<Vector>) -> Energy {
        means(Touch, 0, dot(mean(jump(u)), mean(jump(u))) / this(h) / 2)
    }
}

/// Two bodies with 3 and 4 cells along their surfaces, the second one above the first.
fn plane(shape: CellShape, degree: usize) -> Mesh<2> {
    let slab = rectangle([0.0, 0.0], [1.0, 1.0], [3, 3], shape, degree).unwrap();
    let punch = rectangle([0.03, 1.02], [1.03, 2.02], [4, 4], shape, degree).unwrap();
    Mesh::of_bodies(&[("slab", &slab), ("punch", &punch)]).unwrap()
}

fn space_bodies() -> Mesh<3> {
    let slab = cuboid([0.0; 3], [1.0; 3], [2, 2, 2], CellShape::Hexahedron, 1).unwrap();
    let punch = cuboid([0.03, 0.04, 1.02], [1.03, 1.04, 2.02], [3, 3, 2], CellShape::Hexahedron, 1).unwrap();
    Mesh::of_bodies(&[("slab", &slab), ("punch", &punch)]).unwrap()
}

fn pairing() -> Pairing {
    Pairing::between("slab top", "punch bottom")
}

fn touch() -> rubber::Touch {
    rubber::Touch::on(pairing())
}

fn all() -> rubber::Omega {
    rubber::Omega::on("all")
}

fn data<const D: usize>(kappa: f64) -> rubber::Data<D> {
    rubber::data().lambda(1.3).mu(0.7).gamma0(10.0).kappa(kappa).old([0.0; D])
}

/// Smooth displacements that press the bodies together, shear and bend them.
fn bent<const D: usize>(space: &Arc<Space<D>>) -> Field<D> {
    Field::interpolate(space, |x: &[f64; D]| -> [f64; D] {
        let up = if x[D - 1] > 1.01 { 1.0 } else { 0.0 };
        std::array::from_fn(|axis| match axis + 1 == D {
            true => -0.06 * up + 0.02 * (3.0 * x[0] + x[D - 1]).sin(),
            false => 0.11 * up + 0.03 * (2.0 * x[D - 1] + axis as f64).cos(),
        })
    })
    .expect("finite")
}

fn direction<const D: usize>(space: &Arc<Space<D>>) -> Field<D> {
    Field::interpolate(space, |x: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|axis| (1.7 * x[0] - 2.3 * x[D - 1] + axis as f64).sin())
    })
    .expect("finite")
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}

fn apart(one: &[f64], other: &[f64]) -> f64 {
    assert_eq!(one.len(), other.len());
    one.iter().zip(other).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

#[test]
fn numbers_by_hand() {
    // The own facets are thirds of [0, 1]; 0.03 of the first have no opposite point.
    let mesh = plane(CellShape::Quadrilateral, 1);
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(5));
    let onto = || fixed::Touch::on(Pairing::onto("slab top", "punch bottom"));
    let ends = [[0.03, 1.0 / 3.0], [1.0 / 3.0, 2.0 / 3.0], [2.0 / 3.0, 1.0]];
    let of = |functional: &Functional<2>| assembler.functional(functional).unwrap();
    assert!((of(&fixed::lengths(&onto())) - 0.97).abs() < 1e-14);
    let middle = |[a, b]: [f64; 2]| (b - a) * ((a + b) / 2.0).powi(2);
    let exact: f64 = ends.iter().map(|ends| middle(*ends)).sum();
    assert!((of(&fixed::squares(&onto())) - exact).abs() < 1e-14);
    // With hats, ψ_1 = (X − a)/(b − a) on the facet [a, b], whatever part of it is covered.
    let by_hats = |k: usize| {
        let [start, end] = ends[k];
        let (first, length) = (k as f64 / 3.0, 1.0 / 3.0);
        let power = |n: i32| (end.powi(n + 1) - start.powi(n + 1)) / f64::from(n + 1);
        let (d1, s1) = ((power(1) - first * power(0)) / length, (power(2) - first * power(1)) / length);
        let (d0, s0) = (power(0) - d1, power(1) - s1);
        s0 * s0 / d0 + s1 * s1 / d1
    };
    let exact: f64 = (0..3).map(by_hats).sum();
    assert!((of(&fixed::squares_by_vertices(&onto())) - exact).abs() < 1e-14);
}

#[test]
fn an_energy_and_its_form_are_one() {
    let mesh = plane(CellShape::Quadrilateral, 1);
    let space = Space::vector(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh);
    let touch = fixed::Touch::on(pairing());
    let (u, w) = (bent(&space), direction(&space));
    let (form, energy) = (fixed::springs(&touch), fixed::stored(&touch));
    let [one, other]: [Form<2>; 2] = [form.clone(), energy.clone().into()];
    let [r, s] = [&one, &other].map(|form| assembler.residual(form, &[&u], &[&space]).unwrap());
    assert!(largest(&r) > 0.01 && apart(&r, &s) < 1e-15);
    let [k, l] = [&one, &other].map(|form| assembler.tangent(form, &[&u], &[&space]).unwrap());
    let [k, l] = [k, l].map(|matrix| matrix.multiply(w.values()).unwrap());
    assert!(
        largest(&k) > 0.05 && apart(&k, &l) < 1e-14 * largest(&k),
        "{} of {}",
        apart(&k, &l),
        largest(&k)
    );
    // Linear: K u is the residual, and twice the energy is u·K u.
    let product = assembler.tangent(&one, &[&u], &[&space]).unwrap().multiply(u.values()).unwrap();
    assert!(apart(&product, &r) < 1e-15);
    let twice: f64 = product.iter().zip(u.values()).map(|(a, b)| a * b).sum();
    assert!((2.0 * assembler.energy(&energy, &[&u]).unwrap() - twice).abs() < 1e-15);
    assert!(form.is_affine());
}

fn tangents<const D: usize>(mesh: &Mesh<D>, degree: usize, form: &Form<D>)
where
    Dim: Dimension<D>,
{
    let space = Space::vector(mesh, degree).unwrap();
    let (u, direction) = (bent(&space), direction(&space));
    for threads in [1, 3] {
        let assembler = Assembler::new(mesh).with_threads(Threads::new(threads));
        let taylor = verification::tangent(&assembler, form, &[&u], &[&direction], 1e-3).unwrap();
        let order = taylor.second_order().unwrap();
        assert!(order > 1.95, "order {order}: {taylor:?}");
    }
}

#[test]
fn tangents_of_means_over_points_that_slide() {
    let mesh = plane(CellShape::Quadrilateral, 1);
    tangents(&mesh, 1, &rubber::one_per_facet(&data(0.3), &all(), &touch()));
    tangents(&mesh, 2, &rubber::one_per_vertex(&data(0.3), &all(), &touch()));
    let energy: Form<2> = rubber::penalty(&data(0.3), &touch()).into();
    tangents(&mesh, 1, &energy);
    let energy: Form<2> = rubber::penalty_per_vertex(&data(0.3), &touch()).into();
    tangents(&mesh, 2, &energy);
}

#[test]
fn tangents_of_means_in_space() {
    let mesh = space_bodies();
    tangents(&mesh, 1, &rubber::one_per_facet(&data(0.3), &all(), &touch()));
    tangents(&mesh, 1, &rubber::one_per_vertex(&data(0.3), &all(), &touch()));
}

#[test]
fn the_residual_is_the_slope_of_an_energy() {
    let mesh = plane(CellShape::Quadrilateral, 2);
    let space = Space::vector(&mesh, 2).unwrap();
    let (u, direction) = (bent(&space), direction(&space));
    let energy = rubber::penalty_per_vertex(&data(0.3), &touch());
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(7));
    let form: Form<2> = energy.clone().into();
    let residual = assembler.residual(&form, &[&u], &[&space]).unwrap();
    let slope: f64 = residual.iter().zip(direction.values()).map(|(a, b)| a * b).sum();
    let report = verification::taylor(1e-3, &[slope], |step| {
        let values = u.values().iter().zip(direction.values()).map(|(a, b)| a + step * b);
        let moved = Field::from_values(&space, values.collect()).unwrap();
        assembler.energy(&energy, &[&moved]).map(verification::Sample::from)
    });
    let order = report.unwrap().second_order().unwrap();
    assert!(order > 1.95, "{order}");
    let tangent = assembler.tangent(&form, &[&u], &[&space]).unwrap();
    let [there, back] =
        [tangent.multiply(direction.values()), tangent.multiply_transposed(direction.values())]
            .map(Result::unwrap);
    assert!(largest(&there) > 1e-3 && apart(&there, &back) < 1e-13 * largest(&there));
}

#[test]
fn with_one_point_per_facet_means_are_values() {
    for (mesh, degree) in [(plane(CellShape::Quadrilateral, 1), 1), (plane(CellShape::Triangle, 1), 1)] {
        let space = Space::vector(&mesh, degree).unwrap();
        let (u, w) = (bent(&space), direction(&space));
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(1));
        let forms = [
            rubber::one_per_facet(&data(0.3), &all(), &touch()),
            rubber::at_points(&data(0.3), &all(), &touch()),
        ];
        let [r, s] = forms.each_ref().map(|form| assembler.residual(form, &[&u], &[&space]).unwrap());
        assert!(apart(&r, &s) < 1e-14 * largest(&s), "{}", apart(&r, &s));
        let [k, l] = forms.each_ref().map(|form| assembler.tangent(form, &[&u], &[&space]).unwrap());
        let [k, l] = [k, l].map(|matrix| matrix.multiply(w.values()).unwrap());
        assert!(apart(&k, &l) < 1e-13 * largest(&l), "{}", apart(&k, &l));
    }
    // With more points they are not.
    let mesh = plane(CellShape::Quadrilateral, 1);
    let space = Space::vector(&mesh, 1).unwrap();
    let u = bent(&space);
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(3));
    let [r, s] = [
        rubber::one_per_facet(&data(0.3), &all(), &touch()),
        rubber::at_points(&data(0.3), &all(), &touch()),
    ]
    .map(|form| assembler.residual(&form, &[&u], &[&space]).unwrap());
    assert!(apart(&r, &s) > 1e-3 * largest(&s));
}

#[test]
fn the_adjoint_is_the_tangent_transposed() {
    let mesh = plane(CellShape::Quadrilateral, 1);
    let space = Space::vector(&mesh, 1).unwrap();
    let (u, w) = (bent(&space), direction(&space));
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(5));
    let form = rubber::one_per_facet(&data(0.3), &all(), &touch());
    let adjoint = rubber::adjoint(&data(0.3), &all(), &touch(), &u);
    assert!(adjoint.is_affine());
    let tangent = assembler.tangent(&form, &[&u], &[&space]).unwrap();
    let zero = Field::zero(&space);
    let transposed = assembler.tangent(&adjoint, &[&zero], &[&space]).unwrap();
    let one = tangent.multiply_transposed(w.values()).unwrap();
    let other = transposed.multiply(w.values()).unwrap();
    assert!(largest(&one) > 1.0 && apart(&one, &other) < 1e-13 * largest(&one), "{}", apart(&one, &other));
    let as_residual = assembler.residual(&adjoint, &[&w], &[&space]).unwrap();
    assert!(apart(&as_residual, &other) < 1e-13 * largest(&one));
}

#[test]
fn the_derivative_by_the_shape() {
    let mesh = plane(CellShape::Quadrilateral, 1);
    let of_geometry = Space::of_geometry(&mesh).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let (u, v) = (bent(&space), direction(&space));
    let movement = Field::interpolate(&of_geometry, |x: &[f64; 2]| {
        [0.3 * (2.0 * x[1] + x[0]).sin(), 0.2 * (3.0 * x[0] - x[1]).cos()]
    })
    .unwrap();
    let rule = Quadrature::Degree(4);
    let derivative = Assembler::new(&mesh)
        .with_quadrature(rule.clone())
        .functional(&fixed_gamma::by_shape(
            &fixed_gamma::data(),
            &fixed_gamma::Touch::on(pairing()),
            &u,
            &v,
            &movement,
        ))
        .unwrap();
    let report = verification::shape::<Box<dyn std::error::Error>, 2>(&movement, 1e-3, derivative, |mesh| {
        let space = Space::vector(mesh, 1).unwrap();
        let [u, v] = [&u, &v].map(|field| Field::from_values(&space, field.values().to_vec()).unwrap());
        let touch = fixed_gamma::Touch::on(pairing());
        let value = fixed_gamma::value(&fixed_gamma::data(), &touch, &u, &v);
        Ok(Assembler::new(mesh).with_quadrature(rule.clone()).functional(&value)?.into())
    });
    let order = report.unwrap().second_order().unwrap();
    assert!(order > 1.95, "{order}");
}

#[test]
fn sums_and_multiples_keep_their_means() {
    let mesh = plane(CellShape::Quadrilateral, 1);
    let space = Space::vector(&mesh, 1).unwrap();
    let (u, w) = (bent(&space), direction(&space));
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
    let contact = rubber::one_per_facet(&data(0.3), &all(), &touch());
    let energy: Form<2> = rubber::penalty(&data(0.3), &touch()).into();
    let springs = fixed::springs(&fixed::Touch::on(pairing()));
    let sum = &(&springs + 2.0 * &contact) + -3.0 * &energy;
    let parts = [(1.0, &springs), (2.0, &contact), (-3.0, &energy)];
    let mut expected = vec![0.0; u.values().len()];
    let mut product = expected.clone();
    for (factor, form) in parts {
        let residual = assembler.residual(form, &[&u], &[&space]).unwrap();
        let tangent = assembler.tangent(form, &[&u], &[&space]).unwrap().multiply(w.values()).unwrap();
        for k in 0..expected.len() {
            expected[k] += factor * residual[k];
            product[k] += factor * tangent[k];
        }
    }
    let residual = assembler.residual(&sum, &[&u], &[&space]).unwrap();
    assert!(apart(&residual, &expected) < 1e-13 * largest(&expected));
    let tangent = assembler.tangent(&sum, &[&u], &[&space]).unwrap().multiply(w.values()).unwrap();
    assert!(apart(&tangent, &product) < 1e-13 * largest(&product));
}

#[test]
fn the_same_on_any_number_of_threads() {
    let slab = rectangle([0.0, 0.0], [1.0, 1.0], [40, 3], CellShape::Quadrilateral, 1).unwrap();
    let punch = rectangle([0.03, 1.02], [1.03, 2.02], [57, 3], CellShape::Quadrilateral, 1).unwrap();
    let mesh = Mesh::of_bodies(&[("slab", &slab), ("punch", &punch)]).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let u = bent(&space);
    let form = rubber::one_per_vertex(&data(0.3), &all(), &touch());
    let of = |threads: usize| {
        let assembler = Assembler::new(&mesh).with_threads(Threads::new(threads));
        let residual = assembler.residual(&form, &[&u], &[&space]).unwrap();
        let tangent = assembler.tangent(&form, &[&u], &[&space]).unwrap();
        (residual, tangent.values().to_vec())
    };
    let one = of(1);
    assert!([2, 3, 7, 16].into_iter().all(|threads| of(threads) == one));
}

/// Means couple cells: products of the tangent are made of the matrix, and there are no element matrices.
#[test]
fn products_and_element_matrices() {
    let mesh = plane(CellShape::Quadrilateral, 1);
    let space = Space::vector(&mesh, 1).unwrap();
    let (u, w) = (bent(&space), direction(&space));
    let assembler = Assembler::new(&mesh);
    // The tangent of the springs has products of means only.
    let springs = fixed::springs(&fixed::Touch::on(pairing()));
    for form in [springs.clone(), 2.0 * &springs] {
        let action = assembler.action(&form, &[&u], &[&w], &[&space]).unwrap();
        let tangent = assembler.tangent(&form, &[&u], &[&space]).unwrap();
        assert!(largest(&action) > 0.05);
        assert!(apart(&action, &tangent.multiply(w.values()).unwrap()) < 1e-14 * largest(&action));
        let matrices = assembler.element_matrices(&form, &[&u], &[&space]);
        assert!(matches!(matrices, Err(AssemblyError::Means { .. })), "{matrices:?}");
    }
}

#[test]
fn forces_and_moments_balance() {
    let mesh = plane(CellShape::Quadrilateral, 1);
    let space = Space::vector(&mesh, 1).unwrap();
    let u = bent(&space);
    let form = rubber::one_per_vertex(&data(0.0), &all(), &touch());
    let residual = Assembler::new(&mesh).residual(&form, &[&u], &[&space]).unwrap();
    let scale: f64 = residual.iter().map(|entry| entry.abs()).sum();
    let (mut sums, mut moment) = ([0.0; 2], 0.0);
    for (node, force) in residual.chunks_exact(2).enumerate() {
        let x = space.positions()[node];
        let place = [x[0] + u.values()[2 * node], x[1] + u.values()[2 * node + 1]];
        sums = [sums[0] + force[0], sums[1] + force[1]];
        moment += place[0] * force[1] - place[1] * force[0];
    }
    assert!(sums[0].abs() < 1e-13 * scale && sums[1].abs() < 1e-13 * scale, "{sums:?} of {scale}");
    assert!(moment.abs() < 1e-13 * scale, "{moment} of {scale}");
}

/// Contact with a parameter γ that does not follow the mesh.
#[forms(dimension = 2)]
mod fixed_gamma {
    pub struct Data {
        #[default(10)]
        gamma: Param,
    }
    #[pairs]
    pub struct Touch;

    fn pressed(u: Vector, v: Vector) -> Form {
        means(Touch(u), 0, sqr(neg_part(mean(gap + this(x[0] * u[1])))) * mean(gamma * dot(toward, jump(v))))
            + means(Touch(u), 1, gamma * sqr(mean(gap)) * mean(other(v[0])))
    }
    pub fn value(u: State<Vector>, v: State<Vector>) -> Functional {
        pressed(u, v)
    }
    pub fn by_shape(u: State<Vector>, v: State<Vector>, T: State<Vector>) -> Functional {
        derivative(pressed(u, v), shape, T)
    }
}
