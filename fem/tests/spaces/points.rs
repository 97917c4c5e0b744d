//! Values at the points of a rule: laws with an unknown at each point.

use forms_fem::prelude::*;
use forms_fem::verification;

use crate::shared::*;

#[forms]
mod law {
    pub struct Data {
        pub f: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;

    /// A flux with a resistance s that solves s + s³ = 1 + |∇u|² at each point.
    pub fn balance(u: Unknown<Scalar>, s: Unknown<Scalar>, v: Test<Scalar>, t: Test<Scalar>) -> Form {
        integral(Omega, s * dot(grad(u), grad(v)) - f * v)
            + integral(Omega, (s + pow(s, 3) - 1 - dot(grad(u), grad(u))) * t)
    }
    pub fn size(s: State<Scalar>) -> Functional {
        integral(Omega, s)
    }
    pub fn slope(s: State<Scalar>) -> Functional {
        integral(Omega, dot(grad(s), grad(s)))
    }
    pub fn outside(s: State<Scalar>) -> Functional {
        integral(Gamma, s)
    }
}

#[test]
fn a_law_holds_at_each_point() -> Outcome {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = distorted(4, shape, 1);
        let space = Space::scalar(&mesh, 2)?;
        let points = Space::of(&mesh, Elements::Points(4), Scope::Point, &[])?;
        let count = points.cell_nodes(0).len();
        assert_eq!(points.node_count(), count * mesh.cell_count());
        assert_eq!(points.local_nodes().len(), mesh.cell_count());
        let data = law::data().f(|x: &[f64; 2]| 3.0 + x[0]);
        let omega = law::Omega::on("all");
        let form = law::balance(&data, &omega);
        let mut walls = Constraints::new(&space);
        walls.fix("boundary", |_: &[f64; 2]| 0.0)?;
        let start = [Field::zero(&space), Field::from_values(&points, vec![0.7; points.unknowns()])?];
        let solved = Problem::new(&form, [&space, &points])
            .start([&start[0], &start[1]])
            .constrained(&walls)
            .solve()?;
        let [u, s] = &solved.fields;
        let places = points.cell_element(0).node_points::<2>();
        for cell in 0..mesh.cell_count() {
            for (node, place) in points.cell_nodes(cell).iter().zip(&places) {
                let (s, slope) = (s.at_node(*node as usize)[0], u.gradient_in(cell, place));
                let defect = s + s.powi(3) - 1.0 - slope[0] * slope[0] - slope[1] * slope[1];
                assert!(defect.abs() < 1e-9, "{defect:e}");
            }
        }
        let assembler = Assembler::new(&mesh);
        let ones = Field::from_values(&points, vec![1.0; points.unknowns()])?;
        assert!((assembler.functional(&law::size(&data, &omega, &ones))? - 1.0).abs() < 1e-13);
        let directions = [
            Field::interpolate(&space, |x| x[0] * x[1])?,
            Field::from_values(&points, noise(points.unknowns()))?,
        ];
        let report =
            verification::tangent(&assembler, &form, &[u, s], &[&directions[0], &directions[1]], 1e-2)?;
        assert!(report.second_order()? > 1.9);
    }
    Ok(())
}

#[test]
fn what_points_do_not_have_is_refused_by_name() -> Outcome {
    let mesh = distorted(2, CellShape::Triangle, 1);
    let points = Space::of(&mesh, Elements::Points(4), Scope::Point, &[])?;
    let s = Field::from_values(&points, vec![1.0; points.unknowns()])?;
    let (data, omega) = (law::data().f(0.0), law::Omega::on("all"));
    let assembler = Assembler::new(&mesh);
    let slope = assembler.functional(&law::slope(&data, &omega, &s)).unwrap_err().to_string();
    assert_eq!(slope, "form `slope` reads a derivative of `s`, which is known at the points of a rule only");
    let outside =
        assembler.functional(&law::outside(&data, &law::Gamma::on("boundary"), &s)).unwrap_err().to_string();
    assert!(outside.contains("needs `s` over the region `Gamma`"), "{outside}");
    let other = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(6));
    let other = other.functional(&law::size(&data, &omega, &s)).unwrap_err().to_string();
    assert!(other.contains("values at the points of the rule of degree 4"), "{other}");
    assert!(s.evaluate(&[0.3, 0.4]).unwrap_err().to_string().contains("points of its rule only"));
    assert!(s.evaluate_in(0, &[0.3, 0.4])[0].is_nan());
    let scope = Space::of(&mesh, Elements::Points(4), Scope::Cell, &[]).unwrap_err().to_string();
    assert!(scope.ends_with("`Scope::Point` goes with `Elements::Points`"), "{scope}");
    assert!(forms_fem::output::VtuFile::new(&mesh).point_data("s", &s).is_err());
    assert!(assembler.projection_is_refused(&points));
    Ok(())
}

trait Refuses {
    fn projection_is_refused(&self, space: &Arc<Space<2>>) -> bool;
}

impl Refuses for Assembler<2> {
    fn projection_is_refused(&self, space: &Arc<Space<2>>) -> bool {
        let field = Field::zero(&Space::scalar(space.mesh(), 1).unwrap());
        field.onto(space).interpolated().is_err()
    }
}
