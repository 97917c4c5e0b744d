//! Unknowns of a whole body, and scopes on some cells only.

use forms_fem::linear_algebra::CsrMatrix;
use forms_fem::prelude::*;

use crate::shared::*;

#[forms]
mod mean {
    pub struct Data {
        pub f: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    /// Poisson's problem without a fixed value: one multiplier makes the mean zero.
    pub fn free(u: Unknown<Scalar>, l: Unknown<Scalar>, v: Test<Scalar>, m: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - f * v + l * v + m * u)
    }
}

#[forms]
mod cavity {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        /// The wanted displacement over the cavity's wall, times its length.
        pub per_length: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;

    pub fn inflated(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, lambda * div(u) * div(v) + 2 * mu * inner(eps(u), eps(v)))
            + integral(Wall, p * dot(n, v) + q * (dot(n, u) + per_length))
    }
}

#[forms]
mod parts {
    #[cells]
    pub struct Omega;

    pub fn coupled(u: Unknown<Scalar>, l: Unknown<Scalar>, v: Test<Scalar>, m: Test<Scalar>) -> Form {
        integral(Omega, u * v + l * v + m * u + l * m)
    }
    pub fn size(l: State<Scalar>) -> Functional {
        integral(Omega, l)
    }
}

#[test]
fn one_multiplier_makes_a_mean_zero() -> Outcome {
    const PI: f64 = std::f64::consts::PI;
    let exact = |x: &[f64; 2]| (PI * x[0]).cos() * (2.0 * PI * x[1]).cos();
    let errors: Vec<f64> = [8, 16]
        .map(|n| {
            let mesh = distorted(n, CellShape::Quadrilateral, 1);
            let space = Space::scalar(&mesh, 2).unwrap();
            let of_body = Space::of(&mesh, Elements::Lagrange(0), Scope::Body, &[]).unwrap();
            assert_eq!(of_body.unknowns(), 1);
            let f = Given::function(move |x: &[f64; 2]| 5.0 * PI * PI * exact(x) + 0.25);
            let form = mean::free(&mean::data().f(f), &mean::Omega::on("all"));
            let solved = Problem::new(&form, [&space, &of_body]).solve().unwrap();
            let [u, l] = &solved.fields;
            // What has no solution without it: the mean of the load.
            assert!((l.values()[0] - 0.25).abs() < 1e-4, "{}", l.values()[0]);
            let assembler = Assembler::new(&mesh);
            assert!(norms::mean(&assembler, u).unwrap()[0].abs() < 1e-12);
            let value = move |x: &[f64; 2], value: &mut [f64]| value[0] = exact(x);
            norms::errors(&assembler, u, value, |_, slope| slope.fill(0.0)).unwrap().l2
        })
        .into();
    assert!(orders(&errors)[0] > 2.75, "{errors:?}");
    Ok(())
}

// u_r = A r + B/r in a ring whose outer side is free.
#[test]
fn a_closed_cavity_has_one_pressure() -> Outcome {
    let (inner, outer, lambda, mu, wanted) = (1.0_f64, 2.0_f64, 1.5, 0.8, 0.1);
    let mesh = annulus(inner, outer, 8, 64, CellShape::Quadrilateral, 2)?;
    let space = Space::vector(&mesh, 2)?;
    let of_body = Space::of(&mesh, Elements::Lagrange(0), Scope::Body, &[])?;
    let data = cavity::data().lambda(lambda).mu(mu).per_length(wanted);
    let form = cavity::inflated(&data, &cavity::Omega::on("all"), &cavity::Wall::on("inner"));
    let mut held = Constraints::new(&space);
    held.rigid_motions_by_hand(&space)?;
    let solved = Problem::new(&form, [&space, &of_body]).constrained(&held).solve()?;
    // σ_r(outer) = 0: 2 (λ + μ) A = 2 μ B / outer², and A inner + B / inner is the mean displacement.
    let ratio = mu / ((lambda + mu) * outer * outer);
    let b = wanted / (ratio * inner + 1.0 / inner);
    let pressure = 2.0 * mu * b / (inner * inner) - 2.0 * (lambda + mu) * ratio * b;
    let found = solved.fields[1].values()[0];
    assert!((found / pressure - 1.0).abs() < 1e-5, "{found} against {pressure}");
    Ok(())
}

/// Conditions that stop the rigid motions of a ring around the origin.
trait Held {
    fn rigid_motions_by_hand(&mut self, space: &Arc<Space<2>>) -> Outcome;
}

impl Held for Constraints<2> {
    fn rigid_motions_by_hand(&mut self, space: &Arc<Space<2>>) -> Outcome {
        let node = |x: [f64; 2]| space.nearest_node(&x).ok_or("no node");
        for (x, component) in [([2.0, 0.0], 1), ([-2.0, 0.0], 1), ([0.0, 2.0], 0)] {
            self.fix_node(node(x)?, component, 0.0)?;
        }
        Ok(())
    }
}

#[test]
fn rows_and_columns_of_a_body_are_full_and_linear_in_size() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [60, 60], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 1)?;
    let of_body = Space::of(&mesh, Elements::Lagrange(0), Scope::Body, &[])?;
    let form = parts::coupled(&parts::Omega::on("all"));
    let fields = [Field::from_values(&space, noise(space.unknowns()))?, Field::zero(&of_body)];
    let on = |threads: usize| -> Result<CsrMatrix, AssemblyError> {
        let assembler = Assembler::new(&mesh).with_threads(Threads::new(threads));
        assembler.tangent(&form, &[&fields[0], &fields[1]], &[&space, &of_body])
    };
    let matrix = on(1)?;
    let n = space.unknowns();
    assert_eq!(row(&matrix, n).count(), n + 1);
    assert_eq!(row(&matrix, 5).filter(|(column, _)| *column == n).count(), 1);
    assert!((matrix.get(n, n) - 1.0).abs() < 1e-13);
    for threads in [2, 3, 5] {
        assert_eq!(matrix.values(), on(threads)?.values(), "{threads} threads");
    }
    Ok(())
}

#[test]
fn scopes_on_some_cells_have_nothing_elsewhere() -> Outcome {
    let mut mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Quadrilateral, 1)?;
    mesh.name_cells("left half", |x| x[0] < 1.0)?;
    let space = |scope: Scope| Space::of(&mesh, Elements::Lagrange(1), scope, &[]);
    let left = space(Scope::Nodes.within("left half"))?;
    assert_eq!((left.node_count(), left.cell_nodes(3).len()), (9, 0));
    assert!(left.positions().iter().all(|x| x[0] <= 1.0));
    assert_eq!(space(Scope::Cell.within("left half"))?.node_count(), 16);
    let body = Space::of(&mesh, Elements::Lagrange(0), Scope::Body.within("left half"), &[])?;
    assert_eq!(body.positions(), [[0.5, 0.5]]);
    let assembler = Assembler::new(&mesh);
    let one = Field::from_values(&left, vec![1.0; 9])?;
    assert!((assembler.functional(&parts::size(&parts::Omega::on("left half"), &one))? - 1.0).abs() < 1e-14);
    assert_eq!(
        assembler.functional(&parts::size(&parts::Omega::on("all"), &one)).unwrap_err().to_string(),
        "form `size` needs `l` over the region `Omega` (\"all\"), but its space is one with continuous values in the cell \
         region \"left half\""
    );
    // A coupling with another space, on the region: the pattern has its nodes only.
    let whole = Space::scalar(&mesh, 1)?;
    let form = parts::coupled(&parts::Omega::on("left half"));
    let (u, l) = (Field::zero(&whole), Field::zero(&left));
    let matrix = assembler.tangent(&form, &[&u, &l], &[&whole, &left])?;
    assert!(matrix.is_symmetric(1e-15)?);
    let ones = vec![1.0; whole.unknowns() + left.unknowns()];
    assert!((matrix.multiply(&ones)?.iter().sum::<f64>() - 4.0).abs() < 1e-13);
    let refused = |elements, scope| Space::of(&mesh, elements, scope, &[]).unwrap_err().to_string();
    assert_eq!(
        refused(Elements::Lagrange(1), Scope::Body),
        "there is no space of Lagrange elements of degree 1 with the values of the whole body: the whole body shares elements \
         with one node: those of degree 0"
    );
    assert!(refused(Elements::Lagrange(1), Scope::Nodes.within("lid")).contains("no cell region \"lid\""));
    assert!(
        refused(Elements::Lagrange(1), Scope::Facets("top".into()).within("all"))
            .contains("by its facet region")
    );
    assert!(one.evaluate(&[0.3, 0.4])? == [1.0] && one.evaluate(&[1.7, 0.4]).is_err());
    assert!(forms_fem::inverse::Readings::new(&left).at_point(&[1.7, 0.4]).is_err());
    assert!(forms_fem::output::VtuFile::new(&mesh).point_data("l", &one).is_err());
    Ok(())
}

#[forms(dimension = 2)]
mod floating {
    pub struct Data {
        pub load: Given<Vector>,
    }
    #[cells]
    pub struct Omega;

    fn stress(u: Vector) -> Tensor {
        3 * div(u) * I + 2 * eps(u)
    }
    /// x × u.
    fn moment(u: Vector) -> Scalar {
        x[0] * u[1] - x[1] * u[0]
    }
    pub fn held(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)) - dot(load, v))
    }
    /// ∫ u = 0 and ∫ x × u = 0 by a force and a couple of the whole body.
    pub fn summed(
        u: Unknown<Vector>,
        force: Unknown<Vector>,
        couple: Unknown<Scalar>,
        v: Test<Vector>,
        a: Test<Vector>,
        b: Test<Scalar>,
    ) -> Form {
        held(u, v) + integral(Omega, dot(force, v) + dot(u, a) + couple * moment(v) + moment(u) * b)
    }
    pub fn stored(u: State<Vector>) -> Functional {
        integral(Omega, inner(stress(u), eps(u)) / 2)
    }
    pub fn spin(u: State<Vector>) -> Functional {
        integral(Omega, moment(u))
    }
    pub fn part(u: State<Vector>, direction: State<Vector>) -> Functional {
        integral(Omega, dot(u, direction))
    }
}

/// A body that nothing holds, under forces that balance and under others, with its three rigid motions taken out by sums.
#[test]
fn a_floating_body_is_held_by_three_sums() -> Outcome {
    let mesh = rectangle([-1.0; 2], [1.0; 2], [10, 10], CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&mesh, 2)?;
    let forces = Space::of(&mesh, Elements::Lagrange(0), Scope::Body, &[2])?;
    let couples = Space::of(&mesh, Elements::Lagrange(0), Scope::Body, &[])?;
    for offset in [0.0, 0.5] {
        let load = move |x: &[f64; 2]| [x[0].powi(3) + offset, -x[1] + x[0] * x[0] - 1.0 / 3.0];
        let model = floating::Model::new(floating::data().load(load));
        let solved = Problem::new(&model.summed(), [&space, &forces, &couples]).solve()?;
        let [u, force, couple] = &solved.fields;
        // The multipliers are what the load lacks in balance, per area.
        let [force, couple] = [force.values(), couple.values()];
        assert!((force[0] - offset).abs() < 1e-12 && force[1].abs() < 1e-12, "{force:?}");
        assert!(couple[0].abs() < 1e-12, "{couple:?}");
        let size = u.values().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        for axis in 0..2 {
            let unit: [f64; 2] = std::array::from_fn(|k| f64::from(u8::from(k == axis)));
            let direction = Field::interpolate(&space, |_| unit)?;
            assert!(solved.functional(&model.part(u, &direction))?.abs() < 1e-12 * size);
        }
        assert!(solved.functional(&model.spin(u))?.abs() < 1e-12 * size);
        if offset == 0.0 {
            // The same strains as with three unknowns fixed.
            let mut held = Constraints::new(&space);
            for (x, component) in [([0.0, 0.0], 0), ([0.0, 0.0], 1), ([1.0, 0.0], 1)] {
                held.fix_node(space.nearest_node(&x).ok_or("no node")?, component, 0.0)?;
            }
            let fixed = Problem::new(&model.held(), &space).constrained(&held).solve()?;
            let [one, other] =
                [solved.functional(&model.stored(u))?, fixed.functional(&model.stored(fixed.field()))?];
            assert!((one / other - 1.0).abs() < 1e-12, "{one} {other}");
        }
    }
    Ok(())
}
