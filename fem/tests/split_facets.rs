//! Facets split at the zeros of a scalar: integrals with kinks and jumps inside a facet against closed forms.

use forms_fem::prelude::*;

#[forms]
mod contact {
    pub struct Data {
        level: Param,
    }
    #[facets]
    pub struct Gamma;

    pub fn above(w: Scalar) -> Scalar {
        w - level
    }
    pub fn measure(w: State<Scalar>) -> Functional {
        integral(Gamma, heaviside(above(w)))
    }
    pub fn excess(w: State<Scalar>) -> Functional {
        integral(Gamma, pow(pos_part(above(w)), 2))
    }
    /// r + [r]₊ = load, node by node for the lowest degree and on the whole in the mean.
    pub fn spring(r: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Gamma, (r + pos_part(r - level) - x[0]) * v)
    }
}

use contact::Gamma;

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() < tolerance, "{found} instead of {expected}");
}

#[test]
fn zeros_inside_a_facet_cost_no_accuracy() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = rectangle([0.0, 0.0], [3.0, 1.0], [3, 1], shape, 1).unwrap();
        let space = Space::scalar(&mesh, 2).unwrap();
        let w = Field::interpolate(&space, |x| (x[0] - 0.3) * (x[0] - 0.55)).unwrap();
        let data = contact::data().level(0.0);
        let gamma = Gamma::on("bottom");
        let whole = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(5));
        let split = whole.split_at_zeros(&contact::above(&data, &w), "bottom", 2).unwrap();
        let measure = contact::measure(&data, &gamma, &w);
        close(split.functional(&measure).unwrap(), 2.75, 1e-14);
        // Three points in the facet cannot give 3/4.
        assert!((whole.functional(&measure).unwrap() - 2.75).abs() > 1e-2);
        // ∫ ((t² − 1/64))² over t = x − 0.425 from 0.125, and from −0.425 to −0.125.
        let primitive = |t: f64| t.powi(5) / 5.0 - t.powi(3) / 96.0 + t / 4096.0;
        let exact = primitive(2.575) - primitive(0.125) + primitive(-0.125) - primitive(-0.425);
        let excess = contact::excess(&data, &gamma, &w);
        close(split.functional(&excess).unwrap(), exact, 1e-13 * exact);
        // Of another region nothing is split, and a state without zeros makes facets whole again.
        let top = contact::measure(&data, &Gamma::on("top"), &w);
        assert_eq!(split.functional(&top).unwrap(), whole.functional(&top).unwrap());
        let far = contact::above(&contact::data().level(-9.0), &w);
        let again = split.split_at_zeros(&far, "bottom", 2).unwrap();
        assert_eq!(again.quadrature(), whole.quadrature());
    }
}

#[test]
fn in_space_affine_scalars_are_split_exactly() {
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [3, 2, 1], shape, 1).unwrap();
        let space = Space::scalar(&mesh, 1).unwrap();
        // Positive below the line from (1.7, 0) to (0, 17/18).
        let w = Field::interpolate(&space, |x| 1.7 - x[0] - 1.8 * x[1] + x[2]).unwrap();
        let data = contact::data().level(0.0);
        let whole = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(3));
        let gamma = Gamma::on("bottom");
        let measure = contact::measure(&data, &gamma, &w);
        let excess = contact::excess(&data, &gamma, &w);
        let area = 1.7_f64.powi(2) / (2.0 * 1.8);
        // ∫∫ (1.7 − x − 1.8 y)² over x from 0 to 1.7 − 1.8 y.
        let squared = 1.7_f64.powi(4) / (3.0 * 4.0 * 1.8);
        for resolution in [1, 3] {
            let split = whole.split_at_zeros(&contact::above(&data, &w), "bottom", resolution).unwrap();
            close(split.functional(&measure).unwrap(), area, 1e-13);
            close(split.functional(&excess).unwrap(), squared, 1e-13);
        }
        assert!((whole.functional(&measure).unwrap() - area).abs() > 1e-3);
    }
}

/// On one facet R(r; v) = ∫ (r + \[r\]₊ − x) v: its solution in a space whose nodes lie inside facets is known from moments
/// that whole rules do not integrate.
#[test]
fn newtons_method_follows_the_split_of_each_iterate() {
    let mesh = rectangle([-1.0, 0.0], [1.0, 1.0], [1, 1], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::on_facets(&mesh, "bottom", 1).unwrap();
    let form = contact::spring(&contact::data().level(0.0), &Gamma::on("bottom"));
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
    let indicator =
        |r: &Field<2>| assembler.split_at_zeros(&contact::above(&contact::data().level(0.0), r), "bottom", 1);
    let solve = |split: bool| {
        let mut problem = Problem::new(&form, &space).assembler(&assembler);
        if split {
            problem = problem.assembler_at(|r| indicator(&r[0]));
        }
        let start = Field::interpolate(&space, |x| x[0]).unwrap();
        let options = NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() };
        let mut solver = TangentSolver::default();
        problem.start(&start).solver(&mut solver).options(options.clone()).solve().unwrap()
    };
    let (split, whole) = (solve(true), solve(false));
    assert!(split.history.iter().all(|step| step.active_points.is_none()));
    let last = split.history.last().unwrap();
    assert!(last.relative_residual < 1e-13 && split.history.len() > 2, "{:?}", split.history);
    // r = a + b x with a zero at z = −a/b: b (1 − z)²/2 is ∫ [r]₊, and the moments with 1 and x vanish.
    let moments = |r: &Field<2>| {
        let mut ends: Vec<[f64; 2]> =
            (0..2).map(|node| [space.positions()[node][0], r.values()[node]]).collect();
        ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let (a, b) = ((ends[0][1] + ends[1][1]) / 2.0, (ends[1][1] - ends[0][1]) / 2.0);
        let z = -a / b;
        let first = 2.0 * a + b * (1.0 - z).powi(2) / 2.0;
        let second = 2.0 / 3.0 * (b - 1.0) + b * ((1.0 - z.powi(3)) / 3.0 - z * (1.0 - z * z) / 2.0);
        first.abs() + second.abs()
    };
    assert!(moments(split.field()) < 1e-12, "{}", moments(split.field()));
    assert!(moments(whole.field()) > 1e-4, "{}", moments(whole.field()));
}

#[test]
fn an_explicit_rule_on_squares_cannot_be_split() {
    let mesh = cuboid([0.0; 3], [1.0; 3], [1, 1, 1], CellShape::Hexahedron, 1).unwrap();
    let w = Field::interpolate(&Space::scalar(&mesh, 1).unwrap(), |x| x[0] - 0.3).unwrap();
    let cell = QuadratureRule { points: vec![[0.5; 3]], weights: vec![1.0] };
    let facet = QuadratureRule { points: vec![[0.5; 2]], weights: vec![1.0] };
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Explicit { cell, facet });
    let data = contact::data().level(0.0);
    let split = assembler.split_at_zeros(&contact::above(&data, &w), "bottom", 1).unwrap();
    let error = split.functional(&contact::measure(&data, &Gamma::on("bottom"), &w)).unwrap_err();
    assert!(error.to_string().contains("triangles of a split facet"), "{error}");
}
