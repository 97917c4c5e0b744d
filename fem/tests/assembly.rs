//! Assembly against closed forms: measures, geometry that forms may name, projections, norms, errors.

use std::f64::consts::PI;

use forms_fem::prelude::*;

#[forms]
mod measured {
    pub struct Data {
        factor: Param,
        weight: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;

    pub fn volume() -> Functional {
        integral(Omega, 1)
    }
    pub fn by_cell_volume() -> Functional {
        integral(Omega, cell_volume)
    }
    pub fn area() -> Functional {
        integral(Gamma, 1)
    }
    pub fn by_facet_area() -> Functional {
        integral(Gamma, facet_area)
    }
    pub fn by_diameter() -> Functional {
        integral(Gamma, h)
    }
    pub fn total_curvature() -> Functional {
        integral(Gamma, curvature)
    }
    /// ∫ x·n = dimension × volume.
    pub fn divergence_theorem() -> Functional {
        integral(Gamma, dot(x, n))
    }
    pub fn weighted() -> Functional {
        integral(Omega, factor * weight)
    }
    pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, factor * u * v - weight * v)
    }
    pub fn kinked(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, neg_part(u) * v)
    }
    pub fn speed(w: Vector) -> Scalar {
        sqrt(dot(w, w))
    }
    pub fn square(w: Scalar) -> Scalar {
        w * w
    }
    pub fn slope(w: Scalar) -> Vector {
        grad(w)
    }
    pub fn normal_component(w: Vector) -> Scalar {
        dot(w, n)
    }
    pub fn logarithm(w: Scalar) -> Scalar {
        ln(w)
    }
    pub fn behind_kinks(w: Scalar) -> Scalar {
        neg_part(ln(w)) + pos_part(ln(w))
    }
}

use measured::{Gamma, Omega};

fn data<const D: usize>() -> measured::Data<D> {
    measured::data().factor(2.0).weight(1.0)
}

fn close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance * expected.abs().max(1.0), "{value} against {expected}");
}

fn ring(radial: usize) -> Mesh<2> {
    annulus(1.0, 2.0, radial, 16 * radial, CellShape::Quadrilateral, 2).unwrap()
}

#[test]
fn measures_of_straight_bodies_are_exact_on_every_shape() {
    for (shape, degree) in [(CellShape::Triangle, 1), (CellShape::Triangle, 2), (CellShape::Quadrilateral, 2)]
    {
        let mesh = rectangle([0.0, 0.0], [2.0, 3.0], [3, 2], shape, degree).unwrap();
        let assembler = Assembler::new(&mesh);
        let (omega, gamma) = (Omega::on("all"), Gamma::on("boundary"));
        close(assembler.functional(&measured::volume(&data(), &omega)).unwrap(), 6.0, 1e-14);
        close(assembler.functional(&measured::area(&data(), &gamma)).unwrap(), 10.0, 1e-14);
        let through = assembler.functional(&measured::divergence_theorem(&data(), &gamma)).unwrap();
        close(through, 12.0, 1e-13);
        close(assembler.functional(&measured::total_curvature(&data(), &gamma)).unwrap(), 0.0, 1e-13);
        let cells = mesh.cell_count() as f64;
        let sum = assembler.functional(&measured::by_cell_volume(&data(), &omega)).unwrap();
        close(sum, 36.0 / cells, 1e-13);
        // Facets of length 2/3 and 3/2.
        let sum = assembler.functional(&measured::by_facet_area(&data(), &gamma)).unwrap();
        close(sum, 6.0 * 4.0 / 9.0 + 4.0 * 9.0 / 4.0, 1e-13);
    }
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        let mesh = cuboid([0.0; 3], [1.0, 2.0, 3.0], [2, 2, 3], shape, 2).unwrap();
        let assembler = Assembler::new(&mesh);
        let gamma = Gamma::on("boundary");
        close(assembler.functional(&measured::volume(&data(), &Omega::on("all"))).unwrap(), 6.0, 1e-13);
        close(assembler.functional(&measured::area(&data(), &gamma)).unwrap(), 22.0, 1e-13);
        let through = assembler.functional(&measured::divergence_theorem(&data(), &gamma)).unwrap();
        close(through, 18.0, 1e-13);
        close(assembler.functional(&measured::total_curvature(&data(), &gamma)).unwrap(), 0.0, 1e-12);
        let largest = assembler.functional(&measured::by_diameter(&data(), &gamma)).unwrap();
        close(largest, 22.0 * (0.25_f64 + 1.0 + 1.0).sqrt(), 1e-13);
    }
}

#[test]
fn curvature_of_circles_is_signed_and_converges() {
    // ∫ κ over a closed curve is 2π; outside κ = 1/R, inside n points to the centre and κ = −1/R.
    let mut errors = Vec::new();
    for radial in [1, 2, 4] {
        let mesh = ring(radial);
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(12));
        let total = |region: &str| {
            assembler.functional(&measured::total_curvature(&data(), &Gamma::on(region))).unwrap()
        };
        errors.push((total("outer") - 2.0 * PI).abs());
        close(total("inner"), -2.0 * PI, 1e-2 / (radial as f64).powi(2));
    }
    for pair in errors.windows(2) {
        assert!(pair[0] / pair[1] > 3.5, "{errors:?}");
    }
}

#[test]
fn a_sphere_octant_has_twice_the_curvature_of_its_circles() {
    // A shell between the radii 1 and 2, mapped from a cube by two angles away from the poles.
    let map = |p: [f64; 3]| {
        let (r, b, a) = (1.0 + p[0], 0.25 * PI * (1.0 + p[1]), 0.25 * PI * p[2]);
        [r * b.sin() * a.cos(), r * b.sin() * a.sin(), r * b.cos()]
    };
    let mut mesh = forms_fem::mesh::structured([1, 8, 8], CellShape::Hexahedron, 2, map).unwrap();
    mesh.name_facets("sphere", "boundary", |c| (c.iter().map(|x| x * x).sum::<f64>() - 4.0).abs() < 1e-2)
        .unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8));
    let sphere = Gamma::on("sphere");
    let area = assembler.functional(&measured::area(&data(), &sphere)).unwrap();
    let exact = 4.0 * 0.25 * PI * ((0.25 * PI).cos() - (0.5 * PI).cos());
    close(area, exact, 1e-4);
    // κ = 2/R = 1, outward.
    let total = assembler.functional(&measured::total_curvature(&data(), &sphere)).unwrap();
    close(total.abs(), exact, 1e-2);
    let through = assembler.functional(&measured::divergence_theorem(&data(), &sphere)).unwrap();
    assert_eq!(total > 0.0, through > 0.0);
}

#[test]
fn fields_of_other_degrees_and_functions_serve_as_data() {
    let mesh = ring(2);
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8));
    let linear = |x: &[f64; 2]| 3.0 + x[0] - 2.0 * x[1];
    let of = |weight: Given<f64, 2>| {
        let data = measured::data().factor(1.0).weight(weight);
        assembler.functional(&measured::weighted(&data, &Omega::on("all"))).unwrap()
    };
    let by_function = of(Given::function(linear));
    let space = Space::scalar(&mesh, 2).unwrap();
    let field = Field::interpolate(&space, linear).unwrap();
    close(of(Given::field(&field)), by_function, 1e-12);
    // The mean of x vanishes on the ring.
    close(by_function, 3.0 * of(Given::constant(1.0)), 1e-12);
}

#[test]
fn projections_reproduce_what_the_space_holds_and_converge_elsewhere() {
    let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [4, 3], CellShape::Triangle, 1).unwrap();
    let assembler = Assembler::new(&mesh);
    let (first, second) = (Space::scalar(&mesh, 1).unwrap(), Space::scalar(&mesh, 2).unwrap());
    let linear = Field::interpolate(&first, |x| 1.0 + x[0] - 3.0 * x[1]).unwrap();
    let square = assembler.project(&measured::square(&data(), &linear), &second).unwrap();
    for (position, value) in second.positions().iter().zip(square.values()) {
        close(*value, (1.0 + position[0] - 3.0 * position[1]).powi(2), 1e-12);
    }
    let slope =
        assembler.project(&measured::slope(&data(), &linear), &Space::vector(&mesh, 1).unwrap()).unwrap();
    for value in slope.values().chunks(2) {
        close(value[0], 1.0, 1e-12);
        close(value[1], -3.0, 1e-12);
    }
    // On facets: the normal component of a constant vector, averaged at corners.
    let constant = Field::interpolate(&Space::vector(&mesh, 1).unwrap(), |_| [0.0, 2.0]).unwrap();
    let trace =
        assembler.at_facet_nodes(&measured::normal_component(&data(), &constant), "top", &second).unwrap();
    for (position, value) in second.positions().iter().zip(trace.values()) {
        close(*value, if position[1] == 1.0 { 2.0 } else { 0.0 }, 1e-14);
    }
    let along =
        assembler.along_facets_uniformly(&measured::normal_component(&data(), &constant), "left", 3).unwrap();
    assert_eq!(along.len(), 9);
    assert!(along.iter().all(|sample| sample.position[0] == 0.0 && sample.value[0].abs() < 1e-14));
}

/// Facets with several local numbers in one region: values are in the region's order, each with its own
/// normal. On the boundary of the unit square the normal component of 2x − (1, 1) is 1.
#[test]
fn derived_fields_on_facets_keep_the_order_of_the_region() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [3, 2], shape, 1).unwrap();
        let assembler = Assembler::new(&mesh);
        let space = Space::vector(&mesh, 1).unwrap();
        let field = Field::interpolate(&space, |x| [2.0 * x[0] - 1.0, 2.0 * x[1] - 1.0]).unwrap();
        let expression = measured::normal_component(&data(), &field);
        let samples = assembler.along_facets_uniformly(&expression, "boundary", 3).unwrap();
        let facets = mesh.boundary_facets();
        let locals: std::collections::BTreeSet<u8> = facets.iter().map(|facet| facet.local).collect();
        assert!(locals.len() > 1);
        assert_eq!(samples.len(), 3 * facets.len());
        for (samples, facet) in samples.chunks(3).zip(facets) {
            // The sample in the middle is the middle of the facet that it names.
            assert!(samples.iter().all(|sample| sample.facet == *facet));
            let ends = mesh.cell_shape(0).edges()[usize::from(facet.local)]
                .map(|vertex| mesh.nodes()[mesh.cell(facet.cell as usize)[vertex] as usize]);
            for (k, position) in samples[1].position.iter().enumerate() {
                close(*position, (ends[0][k] + ends[1][k]) / 2.0, 1e-15);
            }
            samples.iter().for_each(|sample| close(sample.value[0], 1.0, 1e-14));
        }
        let points = assembler.at_quadrature_points(&expression, Entity::Facets, "boundary", 2).unwrap();
        close(points.weights.iter().sum(), 4.0, 1e-14);
        points.values.iter().for_each(|value| close(value[0], 1.0, 1e-14));
    }
}

#[test]
fn norms_and_errors_of_polynomials() {
    let mesh = rectangle([0.0, 0.0], [2.0, 1.0], [3, 2], CellShape::Quadrilateral, 1).unwrap();
    let assembler = Assembler::new(&mesh);
    let space = Space::vector(&mesh, 2).unwrap();
    let field = Field::interpolate(&space, |x| [x[0] * x[0], x[0] * x[1]]).unwrap();
    let found = norms::norms(&assembler, &field).unwrap();
    // ∫ x⁴ + x²y² = 32/5 + 8/9; ∫ 4x² + y² + x² = 40/3 + 2/3.
    close(found.l2.powi(2), 32.0 / 5.0 + 8.0 / 9.0, 1e-13);
    close(found.seminorm.powi(2), 14.0, 1e-13);
    close(found.h1.powi(2), 32.0 / 5.0 + 8.0 / 9.0 + 14.0, 1e-13);
    let exact = |x: &[f64; 2], out: &mut [f64]| out.copy_from_slice(&[x[0] * x[0], x[0] * x[1] + 3.0]);
    let slope = |x: &[f64; 2], out: &mut [f64]| out.copy_from_slice(&[2.0 * x[0], 0.0, x[1], x[0]]);
    let error = norms::errors(&assembler, &field, exact, slope).unwrap();
    close(error.l2, 18.0_f64.sqrt(), 1e-13);
    assert!(error.seminorm < 1e-12);
}

#[test]
fn errors_between_nested_curved_meshes_show_the_interpolation_order() {
    let reference_mesh = ring(8);
    let assembler = Assembler::new(&reference_mesh).with_quadrature(Quadrature::Degree(6));
    let smooth = |x: &[f64; 2]| [(x[0] + 0.5 * x[1]).sin(), x[0] * x[1]];
    let reference = Field::interpolate(&Space::vector(&reference_mesh, 2).unwrap(), smooth).unwrap();
    let mut errors = Vec::new();
    for radial in [1, 2, 4] {
        let mesh = ring(radial);
        let coarse = Field::interpolate(&Space::vector(&mesh, 2).unwrap(), smooth).unwrap();
        errors.push(norms::errors_between(&assembler, &reference, &coarse).unwrap());
    }
    for pair in errors.windows(2) {
        let order = |a: f64, b: f64| (a / b).log2();
        assert!(order(pair[0].l2, pair[1].l2) > 2.8, "L² {errors:?}");
        assert!(order(pair[0].seminorm, pair[1].seminorm) > 1.8, "H¹ {errors:?}");
    }
    let same = norms::errors_between(&assembler, &reference, &reference).unwrap();
    assert!(same.h1 < 1e-11, "{same:?}");
}

#[test]
fn an_affine_form_is_solved_in_one_step_and_the_active_set_counts_its_kinks() {
    let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], CellShape::Quadrilateral, 1).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(2));
    let space = Space::scalar(&mesh, 1).unwrap();
    let form = measured::mass(&data(), &Omega::on("all"));
    let mut problem = Problem::new(&form, &space).assembler(&assembler);
    let u = problem.solve().unwrap().into_field();
    assert!(u.values().iter().all(|value| (value - 0.5).abs() < 1e-13));
    // u = x − 1/2 is negative at the points of the left cells: 2 cells × 4 points.
    let field = Field::interpolate(&space, |x| x[0] - 0.5).unwrap();
    let active =
        assembler.active_set(&measured::kinked(&data(), &Omega::on("all")), &[&field]).unwrap().unwrap();
    assert_eq!(active.len(), 16);
    assert_eq!(active.iter().filter(|bits| **bits != 0).count(), 8);
    assert_eq!(assembler.active_set(&form, &[&field]).unwrap(), None);
}

#[test]
fn mistakes_name_the_form_and_the_thing() {
    let mesh = ring(1);
    let assembler = Assembler::new(&mesh);
    let omega = Omega::on("all");
    let space = Space::scalar(&mesh, 1).unwrap();
    let field = Field::zero(&space);
    let says = |result: Result<f64, AssemblyError>, words: &[&str]| {
        let message = result.unwrap_err().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    };
    let bad = measured::data().factor(f64::NAN).weight(1.0);
    says(assembler.functional(&measured::weighted(&bad, &omega)), &["weighted", "factor", "NaN"]);
    let bad = measured::data().factor(1.0).weight(|x: &[f64; 2]| 1.0 / (x[0] - x[0]));
    says(assembler.functional(&measured::weighted(&bad, &omega)), &["weight", "not finite", "x = ["]);
    says(assembler.functional(&measured::volume(&data(), &Omega::on("body"))), &["Omega", "body", "all"]);
    says(assembler.functional(&measured::area(&data(), &Gamma::on("rim"))), &["Gamma", "rim", "outer"]);
    let other = Field::zero(&Space::scalar(&ring(1), 1).unwrap());
    let foreign = measured::data().factor(1.0).weight(&other);
    says(assembler.functional(&measured::weighted(&foreign, &omega)), &["weight", "another mesh"]);
    let form = measured::mass(&data(), &omega);
    let message = assembler.linear_form(&form, &space).unwrap_err().to_string();
    assert!(message.contains("mass") && message.contains("unknowns"), "{message}");
    let vector = Space::vector(&mesh, 1).unwrap();
    let message = assembler.residual(&form, &[&field], &[&vector]).unwrap_err().to_string();
    assert!(message.contains('v') && message.contains("components"), "{message}");
    let message =
        assembler.at_points(&measured::speed(&data(), &field), &[[1.5, 0.0]]).unwrap_err().to_string();
    assert!(message.contains("speed") && message.contains("`w`"), "{message}");
    let message =
        assembler.at_points(&measured::square(&data(), &field), &[[9.0, 0.0]]).unwrap_err().to_string();
    assert!(message.contains("outside"), "{message}");
    let message =
        assembler.at_points(&measured::logarithm(&data(), &field), &[[1.5, 0.0]]).unwrap_err().to_string();
    assert!(message.contains("logarithm") && message.contains("not finite"), "{message}");
    let lines = Field::zero(&vector);
    let message = assembler
        .at_points(&measured::normal_component(&data(), &lines), &[[1.5, 0.0]])
        .unwrap_err()
        .to_string();
    assert!(message.contains("facet"), "{message}");
    let message = assembler
        .at_points(
            &measured::slope(&data(), Given::<f64, 2>::function(|x| x[0]).source().clone()),
            &[[1.5, 0.0]],
        )
        .unwrap_err()
        .to_string();
    assert!(message.contains("gradient") && message.contains("`w`"), "{message}");
    // A kink does not hide a NaN.
    let below = Field::interpolate(&space, |_| -1.0).unwrap();
    let message =
        assembler.at_points(&measured::behind_kinks(&data(), &below), &[[1.5, 0.0]]).unwrap_err().to_string();
    assert!(message.contains("behind_kinks") && message.contains("not finite"), "{message}");
}
