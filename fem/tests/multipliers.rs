//! Multipliers on the facets of a region alone, discontinuous spaces, and values of other shapes.

use forms_fem::prelude::*;

#[forms]
mod held {
    pub struct Data {
        source: Given<Scalar>,
        wanted: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;

    /// Poisson's equation whose boundary value is imposed by a multiplier.
    pub fn saddle(u: Unknown<Scalar>, l: Unknown<Scalar>, v: Test<Scalar>, m: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - source * v) + integral(Gamma, l * v + m * (u - wanted))
    }
}

#[forms]
mod shown {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;

    pub fn length(l: State<Scalar>) -> Functional {
        integral(Gamma, l)
    }
    pub fn inside(l: State<Scalar>) -> Functional {
        integral(Omega, l)
    }
    pub fn slope(l: State<Scalar>) -> Functional {
        integral(Gamma, dot(grad(l), grad(l)))
    }
    pub fn across(l: State<Scalar>) -> Functional {
        integral(Gamma, dot(grad(l), n))
    }
    pub fn value(l: Scalar) -> Scalar {
        l
    }
}

#[forms]
mod glued {
    #[cells]
    pub struct Omega;
    #[interior_facets]
    pub struct Skeleton;

    /// Laplace's equation on cells that nothing but a multiplier holds together.
    pub fn saddle(u: Unknown<Scalar>, l: Unknown<Scalar>, v: Test<Scalar>, m: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v))) + integral(Skeleton, this(l) * jump(v) + this(m) * jump(u))
    }
    pub fn defect(u: State<Scalar>, l: State<Scalar>) -> Functional {
        integral(Skeleton, pow(this(l) + dot(this(grad(u)), n), 2) + pow(jump(u), 2))
    }
}

#[forms(dimension = 2)]
mod open {
    pub struct Data {
        gap: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Bottom;

    /// An elastic body above an obstacle, with the pressure as a multiplier.
    pub fn contact(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let update = pos_part(p - 10 / h * (gap + u[1]));
        integral(Omega, 2 * inner(eps(u), eps(v)) - v[0])
            + integral(Bottom, -p * v[1] - h / 10 * (p - update) * q)
    }
}

/// The pressure below a body that stays open is zero, whatever noise the solver leaves: its equations decouple from the body's, and noise decays
/// along the surface.
#[test]
fn a_multiplier_of_open_contact_is_zero() {
    for (cells, degree) in [(4, 1), (12, 2), (40, 2)] {
        let mesh = rectangle([0.0; 2], [1.0, 0.5], [cells, cells / 2], CellShape::Quadrilateral, 1).unwrap();
        let (space, traces) =
            (Space::vector(&mesh, degree).unwrap(), Space::on_facets(&mesh, "bottom", degree).unwrap());
        let mut held = Constraints::new(&space);
        held.fix("top", |_| [0.0; 2]).unwrap();
        let form = open::Model::new(open::data().gap(|x: &[f64; 2]| 1.0 + x[0] * x[0])).contact();
        for solver in [&mut TangentSolver::default() as &mut dyn LinearSolver, &mut LuSolver::default()] {
            let mut problem = Problem::new(&form, [&space, &traces]).constrained(&held).solver(solver);
            let [u, p] = problem.solve().unwrap().fields;
            assert!(p.values().iter().all(|p| *p == 0.0) && u.values().iter().any(|u| u.abs() > 0.01));
        }
    }
}

fn data(source: Given<f64, 2>, wanted: Given<f64, 2>) -> held::Data<2> {
    held::data().source(source).wanted(wanted)
}

// Nodes of degree k on a line of n facets; constants in degree 0.
#[test]
fn nodes_are_those_of_the_facets() {
    for (shape, geometry) in [(CellShape::Triangle, 1), (CellShape::Quadrilateral, 2)] {
        let mesh = rectangle([0.0; 2], [3.0, 2.0], [3, 2], shape, geometry).unwrap();
        for (degree, count) in [(0, 3), (1, 4), (2, 7), (3, 10), (4, 13)] {
            let space = Space::on_facets(&mesh, "bottom", degree).unwrap();
            assert_eq!(space.node_count(), count);
            assert!(space.positions().iter().all(|x| x[1] == 0.0));
            assert_eq!(space.nodes_on("bottom").unwrap().len(), count);
            assert!(space.cell_nodes(0).is_empty());
            // All edges of the interior, seen from both cells, have nodes of their own cells' numbers.
            let skeleton = Space::vector_on_facets(&mesh, "interior", degree).unwrap();
            assert_eq!(skeleton.nodes_on("interior").unwrap().len(), skeleton.node_count());
        }
    }
    let mesh = cuboid([0.0; 3], [1.0; 3], [2, 2, 2], CellShape::Hexahedron, 2).unwrap();
    for (degree, count) in [(0, 4), (1, 9), (2, 25), (3, 49), (4, 81)] {
        assert_eq!(Space::on_facets(&mesh, "top", degree).unwrap().node_count(), count);
    }
    let error = |region, degree| Space::on_facets(&mesh, region, degree).unwrap_err().to_string();
    assert_eq!(
        error("top", 5),
        "there is no Lagrange element of degree 5 on the facet region \"top\"; the degrees are 0 to 4"
    );
    assert!(error("lid", 1).starts_with("there is no region \"lid\""));
}

// Each facet has nodes of its own, which the two sides of an interior one share, at the same places.
#[test]
fn nodes_of_discontinuous_traces_are_those_of_one_facet() {
    for (shape, geometry) in [(CellShape::Triangle, 1), (CellShape::Quadrilateral, 2)] {
        let mesh = rectangle([0.0; 2], [3.0, 2.0], [3, 2], shape, geometry).unwrap();
        for degree in 0..=4 {
            let space = Space::discontinuous_on_facets(&mesh, "bottom", degree).unwrap();
            assert_eq!((space.node_count(), space.facet_region()), (3 * (degree + 1), Some("bottom")));
            assert_eq!(space.nodes_on("bottom").unwrap().len(), space.node_count());
            let skeleton = Space::discontinuous_vector_on_facets(&mesh, "interior", degree).unwrap();
            assert_eq!(skeleton.node_count(), mesh.interior_facets().len() * (degree + 1));
            let traces = Space::vector_on_facets(&mesh, "interior", degree).unwrap();
            assert!(degree == 0 || traces.node_count() < skeleton.node_count());
        }
    }
    let mesh = cuboid([0.0; 3], [1.0; 3], [2, 2, 2], CellShape::Tetrahedron, 1).unwrap();
    let skeleton = Space::discontinuous_on_facets(&mesh, "interior", 2).unwrap();
    assert_eq!(skeleton.node_count(), 6 * mesh.interior_facets().len());
    let error = Space::discontinuous_on_facets(&mesh, "top", 5).unwrap_err().to_string();
    assert_eq!(
        error,
        "there is no Lagrange element of degree 5 with discontinuous values on the facet region \"top\"; the degrees \
         are 0 to 4"
    );
}

// Pairs that are stable: solutions in the space come out exactly, the multiplier is the flux, jumps included. On
// quadrilaterals constants need degree 2: the bilinear function that is 1 and −1 in turn at the vertices has no mean on any
// edge.
#[test]
fn discontinuous_multipliers_glue_cells() {
    for (shape, degree, of_multiplier) in [
        (CellShape::Triangle, 1, 0),
        (CellShape::Triangle, 3, 1),
        (CellShape::Quadrilateral, 2, 0),
        (CellShape::Quadrilateral, 3, 1),
    ] {
        let mesh = rectangle([0.0; 2], [1.0, 1.2], [3, 4], shape, 1).unwrap();
        let exact = |x: &[f64; 2]| match of_multiplier {
            0 => 1.0 + 2.0 * x[0] - x[1],
            _ => x[0] * x[0] - x[1] * x[1] + 3.0 * x[0],
        };
        let cells = Space::discontinuous_scalar(&mesh, degree).unwrap();
        let facets = Space::discontinuous_on_facets(&mesh, "interior", of_multiplier).unwrap();
        let (omega, skeleton) = (glued::Omega::on("all"), glued::Skeleton::on("interior"));
        let form = glued::saddle(&omega, &skeleton);
        let assembler = Assembler::new(&mesh);
        let mut sides = Constraints::new(&cells);
        sides.fix("boundary", exact).unwrap();
        let free = Constraints::new(&facets);
        let problem = Problem::new(&form, [&cells, &facets]).assembler(&assembler);
        let [u, flux] = problem.constrained(&sides).constrained(&free).solve().unwrap().fields;
        for (value, x) in u.values().iter().zip(cells.positions()) {
            assert!((value - exact(x)).abs() < 1e-11, "{shape:?} {degree}: {value} at {x:?}");
        }
        let defect = assembler.functional(&glued::defect(&skeleton, &u, &flux)).unwrap();
        assert!(defect < 1e-20, "{shape:?} {degree}: {defect}");
    }
}

// A multiplier that jumps is the flux where the flux jumps with it, and is determined at the ends too.
#[test]
fn a_discontinuous_multiplier_is_the_flux() {
    let mut mesh = rectangle([0.0; 2], [1.0; 2], [4, 5], CellShape::Triangle, 1).unwrap();
    mesh.name_facets("held", "boundary", |x| x[1] == 0.0).unwrap();
    let exact = |x: &[f64; 2]| x[0] * x[0] + 3.0 * x[0] * x[1];
    let whole = Space::scalar(&mesh, 3).unwrap();
    let edge = Space::discontinuous_on_facets(&mesh, "held", 1).unwrap();
    let data = data(Given::constant(-2.0), Given::function(exact));
    let form = held::saddle(&data, &held::Omega::on("all"), &held::Gamma::on("held"));
    let mut sides = Constraints::new(&whole);
    for side in ["left", "right", "top"] {
        sides.fix(side, exact).unwrap();
    }
    let free = Constraints::new(&edge);
    let problem = Problem::new(&form, [&whole, &edge]);
    let [u, flux] = problem.constrained(&sides).constrained(&free).solve().unwrap().fields;
    for (value, x) in u.values().iter().zip(whole.positions()) {
        assert!((value - exact(x)).abs() < 1e-11);
    }
    assert_eq!(flux.values().len(), 8);
    for (value, x) in flux.values().iter().zip(edge.positions()) {
        assert!((value - 3.0 * x[0]).abs() < 1e-9, "{value} at {x:?}");
    }
}

// The multiplier is the flux −∂u/∂n, and it is exact where the flux is in its space.
#[test]
fn a_multiplier_is_the_flux() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mut mesh = rectangle([0.0; 2], [1.0; 2], [4, 5], shape, 1).unwrap();
        mesh.name_facets("held", "boundary", |x| x[1] == 0.0).unwrap();
        // u = x² + 3xy: −Δu = −2; on y = 0 the flux −∂u/∂n = ∂u/∂y = 3x, elsewhere u is prescribed.
        let exact = |x: &[f64; 2]| x[0] * x[0] + 3.0 * x[0] * x[1];
        let (whole, edge) = (Space::scalar(&mesh, 2).unwrap(), Space::on_facets(&mesh, "held", 2).unwrap());
        let data = data(Given::constant(-2.0), Given::function(exact));
        let form = held::saddle(&data, &held::Omega::on("all"), &held::Gamma::on("held"));
        let assembler = Assembler::new(&mesh);
        let mut sides = Constraints::new(&whole);
        for side in ["left", "right", "top"] {
            sides.fix(side, exact).unwrap();
        }
        let mut ends = Constraints::new(&edge);
        // At the corners u is prescribed already: the multiplier there is not determined.
        ends.fix_nearest(&[0.0, 0.0], 0.0).unwrap();
        ends.fix_nearest(&[1.0, 0.0], 3.0).unwrap();
        let problem = Problem::new(&form, [&whole, &edge]).assembler(&assembler);
        // Only nodes at the region's facets are coupled with the multiplier.
        let pattern = problem.pattern().unwrap().clone();
        let offset = pattern.column_offset(1) as u32;
        for node in 0..whole.node_count() {
            let coupled = pattern.pattern().row(node).iter().any(|&column| column >= offset);
            let near = whole.positions()[node][1] <= 1.0 / 5.0 + 1e-12;
            assert!(near || !coupled);
        }
        let mut solver = TangentSolver::default();
        let [u, flux] =
            problem.constrained(&sides).constrained(&ends).solver(&mut solver).solve().unwrap().fields;
        for (value, x) in u.values().iter().zip(whole.positions()) {
            assert!((value - exact(x)).abs() < 1e-11);
        }
        for (value, x) in flux.values().iter().zip(edge.positions()) {
            assert!((value - 3.0 * x[0]).abs() < 1e-10, "{value} at {x:?}");
        }
        let samples = assembler.along_facets_uniformly(&shown::value(&flux), "held", 5).unwrap();
        assert!(samples.iter().all(|sample| (sample.value[0] - 3.0 * sample.position[0]).abs() < 1e-10));
    }
}

// The gradient of a trace is the gradient along the facet: of the arc length's function s on a circle it is 1.
#[test]
fn the_gradient_on_facets_is_tangential() {
    let mesh = annulus(1.0, 2.0, 1, 24, CellShape::Quadrilateral, 2).unwrap();
    let space = Space::on_facets(&mesh, "outer", 2).unwrap();
    // x restricted to the circle: ∫ |∇_Γ x|² = ∫ sin² φ · 2 dφ = 2π; the geometry's error is of fourth order.
    let field = Field::interpolate(&space, |x| x[0]).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8));
    let gamma = shown::Gamma::on("outer");
    let square = assembler.functional(&shown::slope(&gamma, &field)).unwrap();
    assert!((square - std::f64::consts::TAU).abs() < 1e-4, "{square}");
    assert!(assembler.functional(&shown::across(&gamma, &field)).unwrap().abs() < 1e-13);
    let constant = Field::interpolate(&Space::on_facets(&mesh, "outer", 0).unwrap(), |_| 1.0).unwrap();
    let length = assembler.functional(&shown::length(&gamma, &constant)).unwrap();
    assert!((length - 2.0 * std::f64::consts::TAU).abs() < 1e-4);
}

#[test]
fn a_multiplier_off_its_facets_is_an_error() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1).unwrap();
    let field = Field::zero(&Space::on_facets(&mesh, "bottom", 1).unwrap());
    let assembler = Assembler::new(&mesh);
    let message = |result: Result<f64, AssemblyError>| result.unwrap_err().to_string();
    assert_eq!(
        message(assembler.functional(&shown::length(&shown::Gamma::on("boundary"), &field))),
        "form `length` needs `l` over the region `Gamma` (\"boundary\"), but its space lives on the facets of \
         \"bottom\" alone"
    );
    assert_eq!(
        message(assembler.functional(&shown::inside(&shown::Omega::on("all"), &field))),
        "form `inside` needs `l` over the region `Omega` (\"all\"), but its space lives on the facets of \
         \"bottom\" alone"
    );
    assert_eq!(
        field.evaluate(&[0.5, 0.0]).unwrap_err().to_string(),
        "the field lives on the facets of \"bottom\" alone: evaluate it along that region with a function"
    );
    assert!(norms::l2_norm(&assembler, &field).unwrap_err().to_string().contains("\"bottom\" alone"));
}

#[test]
fn discontinuous_fields_are_interpolated_projected_and_measured() {
    for (shape, degree) in [
        (CellShape::Triangle, 0),
        (CellShape::Triangle, 1),
        (CellShape::Quadrilateral, 2),
        (CellShape::Quadrilateral, 0),
    ] {
        let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], shape, 1).unwrap();
        let space = Space::discontinuous_scalar(&mesh, degree).unwrap();
        assert_eq!(space.node_count(), mesh.cell_count() * space.cell_element(0).nodes());
        let assembler = Assembler::new(&mesh);
        // A jump along x = 1, between cells.
        let step = |x: &[f64; 2]| if x[0] < 1.0 { 1.0 } else { 3.0 };
        let values = (0..mesh.cell_count()).flat_map(|cell| {
            let centre = mesh.cell_centre(cell);
            vec![step(&centre); space.cell_element(0).nodes()]
        });
        let field = Field::from_values(&space, values.collect()).unwrap();
        assert_eq!(field.evaluate(&[0.3, 0.4]).unwrap(), [1.0]);
        assert_eq!(field.evaluate(&[1.2, 0.4]).unwrap(), [3.0]);
        assert!((norms::l2_norm(&assembler, &field).unwrap() - 10.0_f64.sqrt()).abs() < 1e-13);
        assert!((norms::mean(&assembler, &field).unwrap()[0] - 2.0).abs() < 1e-13);
        let projected = assembler.project(&shown::value(&field), &space).unwrap();
        for (a, b) in projected.values().iter().zip(field.values()) {
            assert!((a - b).abs() < 1e-12);
        }
        let mut constraints = Constraints::new(&space);
        if degree == 0 {
            assert_eq!(
                constraints.fix("left", |_| 0.0).unwrap_err().to_string(),
                "region \"left\" has no nodes of the space, which has Lagrange elements of degree 0 with \
                 discontinuous values"
            );
        } else {
            constraints.fix("left", |_| 0.0).unwrap();
            assert_eq!(constraints.prescribed().len(), 2 * (degree + 1));
        }
    }
}

#[test]
fn values_of_any_shape() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [2, 1], CellShape::Triangle, 1).unwrap();
    let space = Space::of(&mesh, Elements::Lagrange(1), Scope::Nodes, &[3]).unwrap();
    let field = Field::interpolate(&space, |x| [x[0], 1.0, 2.0]).unwrap();
    assert_eq!(field.evaluate(&[0.5, 0.5]).unwrap(), [0.5, 1.0, 2.0]);
    let assembler = Assembler::new(&mesh);
    // ∫ x² + 1 + 4 over 2 × 1.
    assert!((norms::l2_norm(&assembler, &field).unwrap() - (8.0_f64 / 3.0 + 10.0).sqrt()).abs() < 1e-13);
    let matrix = Space::of(&mesh, Elements::Lagrange(0), Scope::Cell, &[2, 3]).unwrap();
    assert_eq!(matrix.unknowns(), 6 * mesh.cell_count());
    assert_eq!(
        Space::of(&mesh, Elements::Lagrange(1), Scope::Nodes, &[0]).unwrap_err().to_string(),
        "a value of shape [0] has no components"
    );
}
