//! Solutions on cut bodies, their parts, and their pieces as a mesh.

use std::sync::Arc;

use forms_fem::cut::{Cut, CutError, CutSide};
use forms_fem::output::VtuFile;
use forms_fem::prelude::*;

use crate::{circle, cut, level, square};

#[forms]
mod membrane {
    pub struct Data {
        pub theta: Param,
        pub gamma0: Param,
        pub weight: Param,
        pub load: Given<Scalar>,
        pub prescribed: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[interface]
    pub struct Gamma;
    #[interior_facets]
    pub struct Ghost;

    pub fn poisson(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let miss = u - prescribed;
        integral(Omega, dot(grad(u), grad(v)) - load * v)
            + integral(Gamma, gamma0 / h * miss * v - dot(grad(u), n) * v - theta * dot(grad(v), n) * miss)
            + integral(Ghost, weight * avg(h) * dot(jump(grad(u)), n) * dot(jump(grad(v)), n))
    }
    pub fn error(u: State<Scalar>) -> Functional {
        integral(Omega, sqr(u - prescribed))
    }
}

/// The error of a solution whose Dirichlet values are given on the interface of a circle.
fn error(
    mesh: &Mesh<2>,
    theta: f64,
    degree: usize,
    exact: fn(&[f64; 2]) -> f64,
    load: fn(&[f64; 2]) -> f64,
) -> f64 {
    error_on(&Cut::by(&level(mesh, circle)).unwrap(), theta, degree, exact, load)
}

/// The same on any body.
fn error_on<const D: usize>(
    cut: &Arc<Cut<D>>,
    theta: f64,
    degree: usize,
    exact: fn(&[f64; D]) -> f64,
    load: fn(&[f64; D]) -> f64,
) -> f64
where
    Dim: Dimension<D>,
{
    let space = Space::scalar(cut.mesh(), degree).unwrap();
    let body = Assembler::new(cut.mesh()).with_cut(cut).unwrap();
    let mut held = Constraints::new(&space);
    cut.hold_outside(&mut held).unwrap();
    let data = membrane::data()
        .theta(theta)
        .gamma0(10.0 * (degree * degree) as f64)
        .weight(0.1)
        .load(Given::function(load))
        .prescribed(Given::function(exact));
    let regions = membrane::Regions::default().ghost("ghost");
    let model = membrane::Model { data, regions };
    let solved = Problem::new(&model.poisson(), &space).assembler(&body).constrained(&held).solve().unwrap();
    body.functional(&model.error(solved.field())).unwrap().sqrt()
}

#[test]
fn linear_functions_are_reproduced() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        for theta in [-1.0, 0.0, 1.0] {
            let found = error(&square(8, shape), theta, 1, |x| 1.0 + 2.0 * x[0] - 3.0 * x[1], |_| 0.0);
            assert!(found < 1e-11, "{shape:?}: {found:e}");
        }
    }
}

#[test]
fn errors_fall_with_order_2() {
    let exact = |x: &[f64; 2]| (2.0 * x[0]).sin() * x[1].exp();
    let load = |x: &[f64; 2]| 3.0 * (2.0 * x[0]).sin() * x[1].exp();
    let found = [8, 16, 32].map(|cells| error(&square(cells, CellShape::Triangle), 1.0, 1, exact, load));
    let order = (found[0] / found[2]).log2() / 2.0;
    assert!((order - 2.0).abs() < 0.2, "order {order} of {found:?}");
}

#[test]
fn aggregates_reproduce_polynomials_without_a_ghost_penalty() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = square(9, shape);
        let plain = Cut::by(&level(&mesh, circle)).unwrap();
        let cut = plain.aggregated().unwrap();
        assert!(cut.ghost_facets().is_empty() && !plain.ghost_facets().is_empty());
        for theta in [-1.0, 0.0, 1.0] {
            let linear = error_on(&cut, theta, 1, |x| 1.0 + 2.0 * x[0] - 3.0 * x[1], |_| 0.0);
            assert!(linear < 1e-11, "{shape:?}: {linear:e}");
            let quadratic = error_on(&cut, theta, 2, |x| x[0] * x[0] - 2.0 * x[0] * x[1] + x[1], |_| -2.0);
            assert!(quadratic < 1e-10, "{shape:?}: {quadratic:e}");
        }
        let within = Cut::within(&level(&mesh, circle), &plain.band(0.05)).unwrap();
        assert_eq!(within.aggregated().unwrap_err(), CutError::Band);
    }
    let mesh = cuboid([-1.0; 3], [1.0; 3], [5; 3], CellShape::Tetrahedron, 1).unwrap();
    let ball = level(&mesh, |x| x.iter().map(|x| (x - 0.03) * (x - 0.03)).sum::<f64>().sqrt() - 0.7);
    let cut = Cut::by(&ball).unwrap().aggregated().unwrap();
    let linear = error_on(&cut, 1.0, 1, |x| 1.0 + 2.0 * x[0] - 3.0 * x[1] + x[2], |_| 0.0);
    assert!(linear < 1e-11, "{linear:e}");
}

#[test]
fn errors_with_aggregates_fall_with_order_3() {
    let exact = |x: &[f64; 2]| (2.0 * x[0]).sin() * x[1].exp();
    let load = |x: &[f64; 2]| 3.0 * (2.0 * x[0]).sin() * x[1].exp();
    let found = [8, 16, 32].map(|cells| {
        let cut = Cut::by(&level(&square(cells, CellShape::Triangle), circle)).unwrap();
        error_on(&cut.aggregated().unwrap(), 1.0, 2, exact, load)
    });
    let order = (found[0] / found[2]).log2() / 2.0;
    assert!((order - 3.0).abs() < 0.3, "order {order} of {found:?}");
}

#[test]
fn unknowns_outside_are_held_and_no_others() {
    let mesh = square(10, CellShape::Triangle);
    let body = cut(&mesh, circle);
    let cut = body.cut().unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.5, 0.0]).unwrap();
    let before = held.prescribed().len();
    cut.hold_outside(&mut held).unwrap();
    assert!(held.prescribed().len() > before);
    let mut active = vec![false; space.node_count()];
    for cell in (0..mesh.cell_count() as u32).filter(|cell| cut.side_of_cell(*cell) != CutSide::Outside) {
        space.cell_nodes(cell as usize).iter().for_each(|node| active[*node as usize] = true);
    }
    for (node, (active, x)) in active.iter().zip(space.positions()).enumerate() {
        assert_eq!(held.is_prescribed(2 * node), !active || x[0] == -1.0);
    }
    // What was prescribed stays.
    let left = space.nodes_on("left").unwrap()[0] as usize;
    assert_eq!(held.prescribed()[&(2 * left)], 0.5);
}

/// φ in the middle of a cell.
fn middle(phi: &Field<2>, cell: u32) -> f64 {
    let nodes = phi.space().cell_nodes(cell as usize);
    nodes.iter().map(|node| phi.values()[*node as usize]).sum::<f64>() / nodes.len() as f64
}

/// Cells that ghost facets connect with one, itself among them.
fn tied_to(cut: &Cut<2>, cell: u32) -> Vec<u32> {
    let mut found = vec![cell];
    let mut next = 0;
    while next < found.len() {
        for [a, b] in cut.ghost_facets() {
            for (from, to) in [(a, b), (b, a)] {
                if from.cell == found[next] && !found.contains(&to.cell) {
                    found.push(to.cell);
                }
            }
        }
        next += 1;
    }
    found
}

#[test]
fn ghost_facets_tie_badly_cut_cells_to_firm_ones() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = square(10, shape);
        let phi = level(&mesh, circle);
        let cut = Cut::by(&phi).unwrap();
        let (bad, firm): (Vec<u32>, Vec<u32>) = (0..mesh.cell_count() as u32)
            .filter(|cell| cut.side_of_cell(*cell) != CutSide::Outside)
            .partition(|cell| middle(&phi, *cell) > 0.0);
        // Each badly cut cell has one facet of its own, and a firm cell at the end of its way.
        assert!(!bad.is_empty() && cut.ghost_facets().len() == bad.len());
        for cell in bad {
            assert_eq!(tied_to(&cut, cell).iter().filter(|other| firm.contains(other)).count(), 1);
        }
        assert!(cut.ghost_facets().iter().all(|sides| cut.side_of_facet(sides[0]) != CutSide::Outside));
    }
    let mesh = square(10, CellShape::Triangle);
    let body = cut(&mesh, circle);
    let count = form!(|| -> Functional { integral(interior_facets("ghost"), 1 / facet_area) });
    let expected = body.cut().unwrap().ghost_facets().len();
    assert!((body.functional(&count).unwrap() - expected as f64).abs() < 1e-9);
    let cells = form!(|| -> Functional {
        integral(cells("cut"), 1) + integral(cells("inside"), 1) - integral(cells("all"), 1)
    });
    assert!(body.functional(&cells).unwrap().abs() < 1e-14);
}

#[test]
fn islands_are_found_and_removed() {
    let mesh = square(20, CellShape::Triangle);
    // A bar at the left side and a disc that hangs on nothing.
    let phi = level(&mesh, |x| (x[0] + 0.311).min((x[0] - 0.51).hypot(x[1]) - 0.243));
    let body = Assembler::new(&mesh).cut_by(&phi).unwrap();
    let parts = body.cut().unwrap().parts();
    assert_eq!(parts.len(), 2);
    assert!((parts[0].volume - 2.0 * 0.689).abs() < 1e-12, "{}", parts[0].volume);
    assert!((parts[1].place[0] - 0.5).abs() < 0.3 && parts[1].place[1].abs() < 0.3);
    let (bar, islands) = body.cut().unwrap().without_islands(&["left"]).unwrap();
    assert_eq!(islands, parts[1..]);
    let area = form!(|| -> Functional { integral(cells("all"), 1) });
    let length = form!(|| -> Functional { integral(interface("all"), 1) });
    let bar = Assembler::new(&mesh).with_cut(&bar).unwrap();
    assert!((bar.functional(&area).unwrap() - 2.0 * 0.689).abs() < 1e-12);
    assert!((bar.functional(&length).unwrap() - 2.0).abs() < 1e-12);
    let whole = body.functional(&area).unwrap();
    assert!((whole - 2.0 * 0.689 - parts[1].volume).abs() < 1e-13);
    let error = body.cut().unwrap().without_islands(&["right"]).unwrap_err().to_string();
    assert_eq!(error, "no part of the body touches \"right\"");
}

#[test]
fn pieces_are_a_mesh_to_be_drawn() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = square(9, shape);
        let body = cut(&mesh, circle);
        let pieces = body.cut().unwrap().body().unwrap();
        let area = form!(|| -> Functional { integral(cells("all"), 1) });
        let [drawn, known] =
            [&Assembler::new(pieces.mesh()), &body].map(|assembler| assembler.functional(&area).unwrap());
        assert!((drawn - known).abs() < 1e-8, "{drawn} {known}");
        // A field keeps its values.
        let u = Field::interpolate(&Space::vector(&mesh, 1).unwrap(), |x| [x[0] - 2.0 * x[1], x[1]]).unwrap();
        let shown = pieces.field(&u).unwrap();
        for (node, x) in shown.space().positions().iter().enumerate() {
            let value = shown.at_node(node);
            assert!((value[0] - x[0] + 2.0 * x[1]).abs() < 1e-13 && (value[1] - x[1]).abs() < 1e-13);
        }
        let file = VtuFile::new(pieces.mesh()).point_data("u", &shown).unwrap();
        let folder = tempfile::tempdir().unwrap();
        file.write(folder.path().join("body.vtu")).unwrap();
    }
}

/// Points that are kept, and made on several threads.
#[test]
fn points_are_kept_and_do_not_depend_on_threads() {
    let mesh = square(40, CellShape::Triangle);
    let phi = level(&mesh, circle);
    let volumes = form!(|v: Test<Scalar>| integral(cells("all"), v) + integral(interface("all"), v));
    let space = Space::scalar(&mesh, 2).unwrap();
    let on = |threads: usize| {
        // A new cut each time: it keeps the points of the first integral.
        let body = Assembler::new(&mesh).cut_by(&phi).unwrap().with_threads(Threads::new(threads));
        let [first, again] = [0, 1].map(|_| body.linear_form(&volumes, &space).unwrap());
        assert_eq!(first, again);
        first
    };
    let one = on(1);
    assert!(cut(&mesh, circle).cut().unwrap().cut_cells().len() > 128);
    for threads in [2, 3, 7, 16] {
        assert_eq!(on(threads), one);
    }
}

/// Cuts of functions within a band have the same unknowns.
#[test]
fn bands_keep_active_cells_and_ghost_facets() {
    let mesh = square(16, CellShape::Triangle);
    let space = Space::scalar(&mesh, 1).unwrap();
    let body = |radius: f64| level(&mesh, |x| (x[0] - 0.013).hypot(x[1] + 0.021) - radius);
    let cut = Cut::by(&body(0.6)).unwrap();
    let band = cut.band(0.06);
    let held = |cut: &Cut<2>| {
        let mut held = Constraints::new(&space);
        cut.hold_outside(&mut held).unwrap();
        held.prescribed().keys().copied().collect::<Vec<usize>>()
    };
    let (smaller, larger) =
        (Cut::within(&body(0.65), &band).unwrap(), Cut::within(&body(0.55), &band).unwrap());
    assert!(smaller.cut_cells() != larger.cut_cells());
    assert_eq!(smaller.ghost_facets(), larger.ghost_facets());
    assert_eq!(held(&smaller), held(&larger));
    assert!(held(&smaller).len() < held(&cut).len());
    // The matrix of the band is regular, and its solution that of the body: linear functions are reproduced.
    for own in [&smaller, &larger] {
        let mut constraints = Constraints::new(&space);
        own.hold_outside(&mut constraints).unwrap();
        let exact = |x: &[f64; 2]| 1.0 + 2.0 * x[0] - 3.0 * x[1];
        let data =
            membrane::data().theta(1.0).gamma0(10.0).weight(0.1).load(0.0).prescribed(Given::function(exact));
        let regions = membrane::Regions::default().ghost("ghost");
        let model = membrane::Model { data, regions };
        let assembler = Assembler::new(&mesh).with_cut(own).unwrap();
        let problem = Problem::new(&model.poisson(), &space).assembler(&assembler);
        let solved = problem.constrained(&constraints).solve().unwrap();
        let error = assembler.functional(&model.error(solved.field())).unwrap().sqrt();
        assert!(error < 1e-11, "{error:e}");
    }
    let error = Cut::within(&body(0.8), &band).unwrap_err().to_string();
    assert!(error.contains("the level set function has changed by more than the band's width"), "{error}");
    // Islands that were removed stay removed.
    let island = level(&mesh, |x| (x[0] + 0.311).min((x[0] - 0.51).hypot(x[1]) - 0.243));
    let (bar, islands) = Cut::by(&island).unwrap().without_islands(&["left"]).unwrap();
    assert_eq!(islands.len(), 1);
    let again = Cut::within(&island, &bar.band(0.05)).unwrap();
    assert_eq!(again.cut_cells(), bar.cut_cells());
    assert_eq!(again.parts().len(), 1);
    // So do those that come off within a band.
    let shifted = |by: f64| level(&mesh, move |x| (x[0] + 0.44).min((x[0] - 0.1).hypot(x[1]) - 0.29) - by);
    let (apart, joined) = (shifted(0.0), shifted(0.15));
    let within = Cut::within(&apart, &Cut::by(&joined).unwrap().band(0.2)).unwrap();
    assert_eq!(within.parts().len(), 2);
    let islands = within.without_islands(&["left"]).unwrap().1;
    assert_eq!(islands, within.parts()[1..]);
}

/// A load on one side of a gap is not felt on the other one, in a band neither; and there the solution is that without a band.
#[test]
fn bands_do_not_close_gaps() {
    let mut mesh = square(24, CellShape::Triangle);
    mesh.name_cells("beyond", |x| x[0] < 0.3 * x[1]).unwrap();
    let poisson =
        form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v)
            + integral(
                interior_facets("ghost"),
                0.1 * avg(h) * dot(jump(grad(u)), n) * dot(jump(grad(v)), n)
                    + 0.01 * pow(avg(h), 3) * dot(jump(hess(u)) * n, n) * dot(jump(hess(v)) * n, n)
            ));
    for degree in [1, 2] {
        let space = Space::scalar(&mesh, degree).unwrap();
        // The gap is a little wider than two cells, and all of its cells are in the band.
        let phi = level(&mesh, |x| 0.1 - (x[0] - 0.3 * x[1] - 0.011).abs());
        let solve = |cut: &Arc<Cut<2>>, right: f64| {
            let mut held = Constraints::new(&space);
            held.fix("left", |_| 0.0).unwrap();
            held.fix("right", |x| right * (1.0 + x[1] * x[1])).unwrap();
            cut.hold_outside(&mut held).unwrap();
            let assembler = Assembler::new(&mesh).with_cut(cut).unwrap();
            let problem = Problem::new(&poisson, &space).assembler(&assembler);
            let solved = problem.constrained(&held).solve().unwrap();
            let beyond = form!(|u: State<Scalar>| -> Functional { integral(cells("beyond"), u) });
            assembler.functional(&beyond(solved.field())).unwrap()
        };
        let cut = Cut::by(&phi).unwrap();
        let within = Cut::within(&phi, &cut.band(1.0 / 12.0)).unwrap();
        let found = [&cut, &within].map(|cut| [solve(cut, 0.0), solve(cut, 1.0)]);
        println!("P{degree}: {found:?}");
        assert!(found.iter().all(|[free, loaded]| (loaded / free - 1.0).abs() < 1e-9), "{found:?}");
        assert!((found[1][0] / found[0][0] - 1.0).abs() < 2e-3, "{found:?}");
    }
}
