//! Histories at the own points of pairs that slide: written with both sides, read where the points are, kept or begun anew without an opposite
//! point, and refused elsewhere.

use forms_fem::contract::PairQuadrature;
use forms_fem::history::WithoutPartner;
use forms_fem::pairs::PairError;
use forms_fem::prelude::*;

#[forms]
mod sliding {
    pub struct Data {
        pub worn: History<Scalar>,
        pub rate: Param,
    }
    #[pairs]
    pub struct Touch;
    #[facets]
    pub struct Surface;

    pub fn after() -> Scalar {
        this(worn) + rate * (this(x[0]) + 2 * other(x[0]))
    }
    pub fn of_the_body() -> Scalar {
        worn + rate * x[0]
    }
    pub fn amount(u: State<Vector>) -> Functional {
        integral(Touch(u), this(worn))
    }
    pub fn from_opposite(u: State<Vector>) -> Functional {
        integral(Touch(u), other(worn))
    }
    pub fn fixed() -> Functional {
        integral(Touch, this(worn))
    }
    pub fn on_surface() -> Functional {
        integral(Surface, worn)
    }
    pub fn spring(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(u), this(worn) * dot(jump(u), jump(v)))
    }
}

/// Two bodies one above the other as a mesh, the facets that face each other "below" and "above".
fn together<const D: usize>(lower: &Mesh<D>, upper: &Mesh<D>) -> Mesh<D> {
    let mut mesh = Mesh::of_bodies(&[("lower", lower), ("upper", upper)]).unwrap();
    mesh.name_facets("below", "lower top", |_| true).unwrap();
    mesh.name_facets("above", "upper bottom", |_| true).unwrap();
    mesh
}

/// Squares below y = 1 and above y = 1.1, in unlike cells.
fn bodies() -> Mesh<2> {
    let lower = rectangle([0.0; 2], [1.0; 2], [3, 2], CellShape::Quadrilateral, 1).unwrap();
    let upper = rectangle([0.0, 1.1], [1.0, 2.1], [4, 3], CellShape::Quadrilateral, 1).unwrap();
    together(&lower, &upper)
}

/// Cubes below z = 1 and above z = 1.1.
fn cubes(shape: CellShape) -> Mesh<3> {
    let lower = cuboid([0.0; 3], [1.0; 3], [2, 3, 1], shape, 1).unwrap();
    let upper = cuboid([0.0, 0.0, 1.1], [1.0, 1.0, 2.1], [3, 2, 1], shape, 1).unwrap();
    together(&lower, &upper)
}

/// The upper body moved aside.
fn aside<const D: usize>(mesh: &Mesh<D>, distance: f64) -> Field<D> {
    let moved = |x: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|k| if k == 0 && x[D - 1] > 1.05 { distance } else { 0.0 })
    };
    Field::interpolate(&Space::vector(mesh, 1).unwrap(), moved).unwrap()
}

fn amount<const D: usize>(
    assembler: &Assembler<D>,
    data: &sliding::Data<D>,
    pairing: &Pairing,
    u: &Field<D>,
) -> f64
where
    Dim: Dimension<D>,
{
    let touch = sliding::Touch::on(pairing.clone());
    assembler.functional(&sliding::amount(data, &touch, u)).unwrap()
}

/// ∫ over both surfaces of what two steps have left, the opposite point first `−d`, then `+d` along: values stay at their own points.
#[test]
fn values_stay_at_own_points() {
    fn check<const D: usize>(mesh: &Mesh<D>, degree: usize, quadrature: Quadrature<D>)
    where
        Dim: Dimension<D>,
    {
        let pairing = Pairing::between("below", "above");
        let assembler = Assembler::new(mesh).with_quadrature(quadrature);
        let worn = assembler.history_on_sliding_pairs(&pairing, degree, 0.5).unwrap();
        let data = sliding::data().worn(worn).rate(3.0);
        let none = aside(mesh, 0.0);
        let volume = |u: &Field<D>| amount(&assembler, &data, &pairing, u);
        assert!((volume(&none) - 1.0).abs() < 1e-13);
        for (steps, shift) in [(1.0, 0.0), (2.0, 0.0)] {
            let u = aside(mesh, shift);
            let after = sliding::after(&data);
            assembler.update_sliding_history(&after, &data.worn, &pairing, &u, WithoutPartner::Keep).unwrap();
            assert!((volume(&none) - 1.0 - (steps - 1.0) * 9.0).abs() < 1e-12, "not yet committed");
            data.worn.commit();
            // Each surface: ∫ 3 (x + 2 x) dx = 9/2.
            assert!((volume(&none) - 1.0 - steps * 9.0).abs() < 1e-12, "{}", volume(&none));
        }
        // Of the body below alone, on pairs and on its facets.
        let below = amount(&assembler, &data, &Pairing::onto("below", "above"), &none);
        assert!((below - 9.5).abs() < 1e-12, "{below}");
        let on_surface = sliding::on_surface(&data, &sliding::Surface::on("below"));
        assert!((assembler.functional(&on_surface).unwrap() - 9.5).abs() < 1e-12);
        // Functions of the own body write all points.
        assembler.update_history(&sliding::of_the_body(&data), &data.worn).unwrap();
        data.worn.commit();
        assert!((volume(&none) - 22.0).abs() < 1e-12, "{}", volume(&none));
    }
    for (degree, plane, solid) in
        [(2, Quadrature::Estimated, Quadrature::Estimated), (3, Quadrature::Degree(6), Quadrature::Degree(5))]
    {
        check(&bodies(), degree, plane);
        check(&cubes(CellShape::Hexahedron), degree, solid.clone());
        check(&cubes(CellShape::Tetrahedron), degree, solid);
    }
}

/// A quarter of the surfaces has no opposite points: these keep their values, or begin anew.
#[test]
fn points_without_an_opposite_one() {
    let mesh = bodies();
    let pairing = Pairing::onto("below", "above");
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(2));
    let u = aside(&mesh, 0.5);
    for (choice, kept) in [(WithoutPartner::Keep, 3), (WithoutPartner::Restart, 0)] {
        let worn = assembler.history_on_sliding_pairs(&pairing, 2, 1.0).unwrap();
        let data = sliding::data().worn(worn).rate(2.0);
        assembler.update_history(&sliding::of_the_body(&data), &data.worn).unwrap();
        data.worn.commit();
        let before = assembler.history_values(&data.worn).unwrap().concat();
        assembler.update_sliding_history(&sliding::after(&data), &data.worn, &pairing, &u, choice).unwrap();
        data.worn.commit();
        let after = assembler.history_values(&data.worn).unwrap().concat();
        // Two points on each of three facets; the middle one has one without and one with an opposite point.
        assert_eq!(after.len(), 6);
        let same = before.iter().zip(&after).filter(|(a, b)| a == b).count();
        let anew = after.iter().filter(|value| **value == 1.0).count();
        assert_eq!((same, anew), (kept, 3 - kept), "{before:?} {after:?}");
        let x = before.iter().map(|value| (value - 1.0) / 2.0);
        let written = x.zip(&before).zip(&after).filter(|((x, _), _)| *x > 0.5);
        // The opposite point is ½ behind.
        assert!(
            written.map(|((x, a), b)| (b - a - 2.0 * (x + 2.0 * (x - 0.5))).abs()).fold(0.0, f64::max)
                < 1e-12
        );
    }
}

/// Residual and tangent read each point's value, on one thread and on several, with points that face several facets.
#[test]
fn forms_read_the_values_of_their_points() {
    let mesh = bodies();
    let pairing = Pairing::between("below", "above");
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
    let worn = assembler.history_on_sliding_pairs(&pairing, 4, 0.0).unwrap();
    let data = sliding::data().worn(worn).rate(1.0);
    let u = aside(&mesh, 0.2);
    assembler
        .update_sliding_history(&sliding::after(&data), &data.worn, &pairing, &u, WithoutPartner::Keep)
        .unwrap();
    data.worn.commit();
    let touch = sliding::Touch::on(pairing.clone());
    let space = u.space();
    let form = sliding::spring(&data, &touch);
    let residual = assembler.residual(&form, &[&u], &[space]).unwrap();
    let tested: f64 = residual.iter().zip(u.values()).map(|(r, u)| r * u).sum();
    // ∫ (3 x ∓ 2·0.2) 0.2² over what faces the other body, 0.8 of each surface: [0.2, 1] below, [0, 0.8] above.
    let exact = 0.04 * (1.5 * (1.0 - 0.04) - 0.4 * 0.8 + 1.5 * 0.64 + 0.4 * 0.8);
    let points = assembler.pairs_at(&pairing, 4, &u).unwrap().paired_measure;
    assert!((tested - exact).abs() < 0.05 * exact && points > 1.5, "{tested} {exact}");
    let bend = |x: &[f64; 2]| [(2.0 * x[0] + x[1]).sin(), 0.3 * (3.0 * x[0]).cos()];
    let direction = Field::interpolate(space, bend).unwrap();
    let report = forms_fem::verification::tangent(&assembler, &form, &[&u], &[&direction], 1e-3).unwrap();
    assert!(report.second_order().unwrap() > 1.95, "{report}");
    let one = assembler.clone().with_threads(Threads::ONE);
    let [a, b] = [&one, &assembler].map(|by| by.residual(&form, &[&u], &[space]).unwrap());
    assert_eq!(a, b);
}

#[test]
fn what_cannot_remember_is_named() {
    let mesh = bodies();
    let assembler = Assembler::new(&mesh);
    let pairing = Pairing::onto("below", "above");
    let u = aside(&mesh, 0.0);
    let refused = |pairing: &Pairing| match assembler.history_on_sliding_pairs(pairing, 2, 0.0).unwrap_err() {
        AssemblyError::Pairs { source, .. } => source,
        other => panic!("{other}"),
    };
    let pieces = pairing.clone().at(PairQuadrature::Pieces);
    assert_eq!(refused(&pieces), PairError::HistoryOnSegments);
    assert!(matches!(refused(&Pairing::onto("sky", "above")), PairError::Surface { .. }));
    assert_eq!(refused(&pairing.clone().and(Pairing::onto("lower top", "above"))), PairError::Twice);

    let own = assembler.history_on_sliding_pairs(&pairing, 2, 0.0).unwrap();
    let data = |worn: History<f64, 2>| sliding::data().worn(worn).rate(1.0);
    let message = |found: Result<f64, AssemblyError>| found.unwrap_err().to_string();
    let touch = |pairing: &Pairing| sliding::Touch::on(pairing.clone());
    let read = |worn: &History<f64, 2>, pairing: &Pairing| {
        assembler.functional(&sliding::amount(&data(worn.clone()), &touch(pairing), &u))
    };
    assert!(read(&own, &pairing).is_ok());
    let back = message(read(&own, &Pairing::onto("above", "below")));
    assert!(back.contains("it was made for the facets of \"below\", and facet"), "{back}");
    let opposite = sliding::from_opposite(&data(own.clone()), &touch(&pairing), &u);
    assert!(message(assembler.functional(&opposite)).contains("read from the own side"));
    let segments = message(read(&own, &pieces));
    assert!(segments.contains("points move along the own facets and remember nothing"), "{segments}");
    let fixed = message(assembler.functional(&sliding::fixed(&data(own.clone()), &touch(&pairing))));
    assert!(fixed.contains("`history_on_pairs` makes one for a pairing"), "{fixed}");
    let cells = assembler.history(Entity::Cells, "all", 2, 0.0).unwrap();
    let cells = message(read(&cells, &pairing));
    assert!(cells.contains("`history_on_sliding_pairs` makes one for them"), "{cells}");
    // A history of the facets is one of own points.
    let facets = assembler.history(Entity::Facets, "boundary", 2, 0.5).unwrap();
    assert!((read(&facets, &pairing).unwrap() - 0.5).abs() < 1e-13);

    let write = |worn: &History<f64, 2>, pairing: &Pairing| {
        let data = data(worn.clone());
        let keep = WithoutPartner::Keep;
        assembler.update_sliding_history(&sliding::after(&data), worn, pairing, &u, keep)
    };
    assert!(write(&facets, &Pairing::between("below", "above")).is_ok());
    let fixed = assembler.history_on_pairs(&pairing, 2, 0.0).unwrap();
    let error = write(&fixed, &pairing).unwrap_err().to_string();
    assert!(error.contains("not written by `update_sliding_history`"), "{error}");
    let error = write(&own, &pieces).unwrap_err().to_string();
    assert!(error.contains("have no history"), "{error}");
}
