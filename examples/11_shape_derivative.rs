//! Tutorial 11: the derivative of a number with respect to the shape of the domain. A bar is twisted; where must its
//! section grow to become stiffer?
//!
//! With `−Δu = 1` and u = 0 on the outline, `J = ∫ u` is proportional to the torsional rigidity (Prandtl). Scaled by s the
//! section has `s⁴ J`, so the derivative along x is 4 J, also for the discrete problem.
//!
//! Run it with `cargo run --release --bin 11_shape_derivative`.

use forms_fem::output::picture::{FieldMap, Picture, Shown};
use forms_fem::prelude::*;
use forms_fem::verification;

#[forms]
mod bar {
    #[cells]
    pub struct Section;
    #[facets]
    pub struct Outline;

    pub fn twist(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Section, dot(grad(u), grad(v)) - v)
    }
    pub fn rigidity(u: State<Scalar>) -> Functional {
        integral(Section, u)
    }

    /// The adjoint state p, whose form is a derivative.
    pub fn adjoint(u: State<Scalar>, p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
        derivative(rigidity(u) + twist(u, p), u, q)
    }

    /// The derivative of the rigidity along a movement Θ of all points. The outline and everything inside move, and u and p keep
    /// their values at the nodes. The adjoint state p accounts for the change of u.
    pub fn along(u: State<Scalar>, p: State<Scalar>, Theta: State<Vector>) -> Functional {
        derivative(rigidity(u) + twist(u, p), shape, Theta)
    }

    /// The movement that stiffens most, measured by ∫ |∇G|² + ∫_outline |G|²/10: its equation has that derivative as load.
    pub fn steepest(u: State<Scalar>, p: State<Scalar>, G: Unknown<Vector>, Theta: Test<Vector>) -> Form {
        integral(Section, inner(grad(G), grad(Theta))) + integral(Outline, dot(G, Theta)) / 10
            - derivative(rigidity(u) + twist(u, p), shape, Theta)
    }
}

/// J on a mesh, with its state.
fn rigidity(mesh: &Mesh<2>) -> Result<(f64, Field<2>), Failure> {
    let space = Space::scalar(mesh, 2)?;
    let mut held = Constraints::new(&space);
    held.fix("boundary", |_| 0.0)?;
    let model = bar::Model::default();
    let form = model.twist::<2>();
    let solved = Problem::new(&form, &space).constrained(&held).solve()?;
    let value = solved.functional(&model.rigidity(solved.field()))?;
    Ok((value, solved.into_field()))
}

fn main() -> Result<(), Failure> {
    let mesh = rectangle([-1.0, -0.5], [1.0, 0.5], [24, 12], CellShape::Triangle, 1)?;
    let (value, u) = rigidity(&mesh)?;
    let model = bar::Model { regions: bar::Regions::default().outline("boundary") };
    let assembler = Assembler::new(&mesh);
    let mut held = Constraints::new(u.space());
    held.fix("boundary", |_| 0.0)?;
    let adjoint = model.adjoint(&u);
    let p = Problem::new(&adjoint, u.space()).constrained(&held).solve()?.into_field();

    // Points move in the space of the mesh's geometry.
    let movements = Space::of_geometry(&mesh)?;
    let growth = Field::interpolate(&movements, |x| *x)?;
    let derivative = assembler.functional(&model.along(&u, &p, &growth))?;
    println!("J = {value:.9}, derivative along x = {derivative:.9}, 4 J = {:.9}", 4.0 * value);

    // Is it the derivative of what the program computes? A Taylor test along some other movement says so.
    let wave = Field::interpolate(&movements, |x| [(2.0 * x[1]).sin(), x[0] * x[1] + 0.3 * x[0]])?;
    let slope = assembler.functional(&model.along(&u, &p, &wave))?;
    let report = verification::shape(&wave, 0.1, slope, |moved| {
        let (value, _) = rigidity(moved)?;
        Ok::<_, Failure>(value.into())
    })?;
    println!("{}", report);
    report.second_order()?;

    let steepest = model.steepest(&u, &p);
    let steepest = Problem::new(&steepest, &movements).solve()?.into_field();
    FieldMap::of(&u, Shown::Component(0), "u")
        .arrows(&steepest, "where the section must grow", "")
        .write_png("out/11_shape_derivative.png")?;

    assert!((derivative - 4.0 * value).abs() < 1e-11 * value, "{derivative} is not four times {value}");
    let along_steepest = assembler.functional(&model.along(&u, &p, &steepest))?;
    assert!(along_steepest > 0.0, "the rigidity falls along the steepest movement");
    Ok(())
}
