//! Newton's criterion: each field by its own residual, and an answer that does not depend on how bad the start was.

use forms_fem::prelude::*;
use forms_fem::solve::{LuSolver, NonlinearProblem, Terms};

#[forms(dimension = 2)]
mod fields {
    pub struct Data {
        stiffness: Param,
        conductivity: Param,
        expansion: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Top;

    /// A loaded body and a substance that diffuses and reacts; expansion makes the substance drive the body.
    pub fn beside(u: Unknown<Vector>, c: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, stiffness * (inner(eps(u), eps(v)) - expansion * c * div(v)))
            + integral(Omega, conductivity * (dot(grad(c), grad(q)) + (pow(c, 3) + c - 1) * q))
            - integral(Top, stiffness * (1 - expansion) * v[1])
    }

    pub fn cubic(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (pow(u, 3) - 1) * v)
    }

    fn strain(u: Scalar) -> Vector {
        grad(u) + stiffness * [1, 0.3]
    }
    /// Stresses of a stretch that stays, whatever u is.
    pub fn prestressed(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (1 + dot(strain(u), strain(u))) * dot(strain(u), grad(v)))
    }
    pub fn loaded(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        prestressed(u, v) - integral(Omega, 1e-6 * stiffness * v)
    }

    pub fn stretched(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (1 + pow(u, 2)) * dot([1, 0], grad(v)))
    }
    pub fn on_top(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Top, (1 + pow(u, 2)) * v)
    }

    pub fn reaction(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) + (u - 1) * v)
    }
}

fn solvers() -> [(&'static str, Box<dyn LinearSolver>); 3] {
    [
        ("TangentSolver", Box::new(TangentSolver::default())),
        ("LuSolver", Box::new(LuSolver::default())),
        ("CondensedSolver", Box::new(CondensedSolver::default())),
    ]
}

/// The substance's value, the body's largest displacement and Newton's history.
fn solve_beside(
    stiffness: f64,
    conductivity: f64,
    expansion: f64,
    solver: &mut dyn LinearSolver,
) -> (Vec<f64>, f64, Vec<NewtonStep>) {
    let mesh = rectangle([0.0; 2], [1.0; 2], [3, 3], CellShape::Quadrilateral, 1).unwrap();
    let (bodies, substances) = (Space::vector(&mesh, 1).unwrap(), Space::scalar(&mesh, 1).unwrap());
    let mut held = Constraints::new(&bodies);
    held.fix("bottom", |_| [0.0; 2]).unwrap();
    let mut given = Constraints::new(&substances);
    given.fix("left", |_| 0.5).unwrap();
    let data = fields::data().stiffness(stiffness).conductivity(conductivity).expansion(expansion);
    let form = fields::beside(&data, &fields::Omega::on("all"), &fields::Top::on("top"));
    let assembler = Assembler::new(&mesh);
    let problem = Problem::new(&form, [&bodies, &substances]).assembler(&assembler);
    let solved = problem.constrained(&held).constrained(&given).solver(solver).solve().unwrap();
    let [u, c] = solved.fields;
    let largest = u.values().iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    (c.values().to_vec(), largest, solved.history)
}

/// A soft field next to a stiff one takes as many steps as by itself, and has the same values.
#[test]
fn a_field_is_not_hidden_by_a_stiffer_one() {
    for expansion in [0.0, 1.0] {
        let (expected, moved, history) = solve_beside(1.0, 1.0, expansion, &mut LuSolver::default());
        for (name, mut solver) in solvers() {
            let (found, by, scaled) = solve_beside(1e6, 1e-6, expansion, &mut *solver);
            let off = found.iter().zip(&expected).fold(0.0_f64, |off, (a, b)| off.max((a - b).abs()));
            assert!(off < 1e-10, "{name}, expansion {expansion}: off by {off:e}");
            assert!((by - moved).abs() < 1e-10 * moved, "{name}, expansion {expansion}: {by} for {moved}");
            assert!(scaled.len() <= history.len() + 2, "{name}: {} iterates", scaled.len());
        }
    }
}

/// A first residual of 10³⁰ says nothing about what is small in the end.
#[test]
fn a_bad_start_does_not_inflate_the_tolerance() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1).unwrap();
    let space = Space::scalar(&mesh, 1).unwrap();
    let (assembler, omega) = (Assembler::new(&mesh), fields::Omega::on("all"));
    let none = Constraints::new(&space);
    let options = NewtonOptions { max_iterations: 100, ..NewtonOptions::default() };
    let data = fields::data().stiffness(1.0).conductivity(1.0).expansion(0.0);
    let (cubic, reaction) = (fields::cubic(&data, &omega), fields::reaction(&data, &omega));
    for start in [1.5, 1e3, 1e6, 1e10, 1e14] {
        let first = Field::interpolate(&space, |_| start).unwrap();
        for (name, mut solver) in solvers() {
            let problem = Problem::new(&cubic, &space).assembler(&assembler);
            let solved = problem
                .start(&first)
                .constrained(&none)
                .solver(&mut *solver)
                .options(options.clone())
                .solve()
                .unwrap();
            for value in solved.field().values() {
                assert!((value - 1.0).abs() < 1e-8, "{name} from {start:e}: {value}");
            }
        }
        let problem = Problem::new(&reaction, &space).assembler(&assembler);
        let mut solver = TangentSolver::default();
        let solved = problem
            .start(&first)
            .constrained(&none)
            .solver(&mut solver)
            .options(options.clone())
            .solve()
            .unwrap();
        assert!(solved.field().values().iter().all(|value| (value - 1.0).abs() < 1e-8), "from {start:e}");
    }
}

/// Stresses that balance by themselves, as in a body that was deformed for good: nothing moves, and the first residual is
/// rounding of theirs, which no step makes smaller.
#[test]
fn a_body_under_stresses_of_its_own_stays_at_rest() {
    for prestress in [1.0, 1e6] {
        let mesh = rectangle([0.0; 2], [1.0, 0.7], [5, 4], CellShape::Triangle, 1).unwrap();
        let space = Space::scalar(&mesh, 2).unwrap();
        let mut constraints = Constraints::new(&space);
        for side in ["left", "right", "top", "bottom"] {
            constraints.fix(side, |_| 0.0).unwrap();
        }
        let model = fields::Model::new(fields::data().stiffness(prestress).conductivity(1.0).expansion(0.0));
        let form = model.prestressed();
        let solved = Problem::new(&form, &space).constrained(&constraints).solve().unwrap();
        let largest = solved.field().values().iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        assert!(largest < 1e-13 * prestress, "prestress {prestress:e}: moved by {largest:e}");
        assert!(solved.iterations() <= 4, "prestress {prestress:e}: {} steps", solved.iterations());
        // A load that is small compared with the stresses is none that rounding hides.
        let form = model.loaded();
        let solved = Problem::new(&form, &space).constrained(&constraints).solve().unwrap();
        let linear = 1e-6 / (2.0 * prestress * prestress);
        let moved = solved.field().values().iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        assert!(moved > 1e-3 * linear, "prestress {prestress:e}: moved by {moved:e}");
        assert!(solved.iterations() <= 8);
    }
}

/// The x-entries of an edge along x cancel in its cells, exactly or but for rounding, as it happens. Its row is made of the stresses in
/// them nevertheless; a facet's forces are in the rows of its nodes only.
#[test]
fn entries_that_cancel_are_no_small_terms() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1).unwrap();
    let space = Space::scalar(&mesh, 2).unwrap();
    let data = fields::data().stiffness(1.0).conductivity(1.0).expansion(0.0);
    let model = fields::Model { data, regions: fields::Regions::default().omega("all").top("top") };
    let zero = vec![0.0; space.unknowns()];
    for terms in [Terms::OfCells, Terms::OfCellsByComponent] {
        let stretched = model.stretched();
        let sizes = Problem::new(&stretched, &space).sizes_of_terms(&zero, terms).unwrap().unwrap();
        // 4/3 of a cell's area times |∇λ|.
        assert!(sizes.iter().all(|size| *size > 0.3 && *size < 4.1), "{sizes:?}");
        let on_top = model.on_top();
        let sizes = Problem::new(&on_top, &space).sizes_of_terms(&zero, terms).unwrap().unwrap();
        for (position, size) in space.positions().iter().zip(&sizes) {
            let is_on_top = position[1] == 1.0;
            assert!(if is_on_top { *size > 0.3 } else { *size == 0.0 }, "{position:?}: {size}");
        }
    }
}
