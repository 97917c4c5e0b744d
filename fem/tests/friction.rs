//! A block that is pressed onto a rough flat and sheared: undamped Newton cycles and says so, a line search on the
//! residual converges.

use forms_fem::prelude::*;
use forms_fem::solve::{LineSearch, LuSolver, NewtonFailure};
use forms_fem::verification::{self, Sample, TaylorFailure, VerificationError};

/// The point of a disk of radius s that is nearest to q. Written in Rust its branches are no switches that an active set
/// would tell of.
fn disk<R: Real, const D: usize>(q: [R; D], s: R) -> [R; D] {
    let zero = R::from(0.0);
    let square = q.iter().fold(zero, |sum, q| sum + *q * *q);
    if s <= zero {
        [zero; D]
    } else if square <= s * s {
        q
    } else {
        let part = s / square.sqrt();
        q.map(|q| part * q)
    }
}

#[forms(dimension = 2)]
mod rough {
    pub struct Data {
        lambda: Param,
        mu: Param,
        theta: Param,
        gamma0: Param,
        /// The coefficient κ of Coulomb's law.
        friction: Param,
        /// The bound of Tresca's law.
        bound: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Contact;

    extern "Rust" {
        fn disk(q: Vector, s: Scalar) -> Vector;
    }

    fn stress(w: Vector) -> Tensor {
        lambda * div(w) * I + 2 * mu * eps(w)
    }

    fn gamma() -> Scalar {
        gamma0 / h
    }

    fn traction(w: Vector) -> Vector {
        stress(w) * n
    }

    /// [σ_n − γ u_n]₋ on a flat that touches the block at the start.
    fn pressure(w: Vector) -> Scalar {
        neg_part(dot(traction(w), n) - gamma() * dot(w, n))
    }

    /// −[P_n]₋ n + Π_s(P_t).
    fn contact(w: Vector, s: Scalar) -> Vector {
        let force = traction(w) - gamma() * w;
        disk(force - dot(force, n) * n, s) - pressure(w) * n
    }

    fn nitsche(u: Vector, v: Vector, s: Scalar) -> Scalar {
        dot(contact(u, s), theta * traction(v) - gamma() * v) / gamma()
            - theta / gamma() * dot(traction(u), traction(v))
    }

    pub fn coulomb(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) + integral(Contact, nitsche(u, v, friction * pressure(u)))
    }

    pub fn tresca(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v))) + integral(Contact, nitsche(u, v, bound))
    }
}

const YOUNG: f64 = 200.0;
const POISSON: f64 = 0.3;

#[derive(Clone, Copy, Debug)]
enum Law {
    Coulomb,
    Tresca,
}

#[derive(Clone, Copy, Debug)]
struct Case {
    law: Law,
    theta: f64,
    friction: f64,
    gamma0_over_young: f64,
    /// By how much the block's top is moved aside; it is pressed down by 0.01.
    shear: f64,
    active: Active,
}

/// Whether Newton's method gets the active set.
#[derive(Clone, Copy, Debug)]
enum Active {
    Told,
    Hidden,
}

type Outcome = Result<Vec<NewtonStep>, NewtonError>;

/// Solves from zero: the block's top is moved down and aside.
fn solve(case: Case, line_search: LineSearch) -> Outcome {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [16, 8], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix("top", |_| [case.shear, -0.01]).unwrap();
    let data = rough::data()
        .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
        .mu(YOUNG / (2.0 * (1.0 + POISSON)))
        .theta(case.theta)
        .gamma0(case.gamma0_over_young * YOUNG)
        .friction(case.friction)
        .bound(case.friction * 0.01 * YOUNG);
    let (omega, contact) = (rough::Omega::on("all"), rough::Contact::on("bottom"));
    let assembler = Assembler::new(&mesh);
    let options = NewtonOptions { line_search, max_iterations: 100, ..NewtonOptions::default() };
    let (start, mut solver) = (Field::zero(&space), LuSolver::default());
    let solved = match case.law {
        Law::Coulomb => {
            let form = rough::coulomb(&data, &omega, &contact);
            let problem = Problem::new(&form, &space).assembler(&assembler);
            let problem = match case.active {
                Active::Told => problem,
                Active::Hidden => problem.assembler_at(|_| Ok(assembler.clone())),
            };
            problem
                .start(&start)
                .constrained(&constraints)
                .solver(&mut solver)
                .options(options.clone())
                .solve()
        }
        Law::Tresca => {
            let form = rough::tresca(&data, &omega, &contact);
            let problem = Problem::new(&form, &space).assembler(&assembler);
            let problem = match case.active {
                Active::Told => problem,
                Active::Hidden => problem.assembler_at(|_| Ok(assembler.clone())),
            };
            problem
                .start(&start)
                .constrained(&constraints)
                .solver(&mut solver)
                .options(options.clone())
                .solve()
        }
    };
    solved.map(|solved| solved.history)
}

/// Solves by whole steps and by shorter ones, which must converge. Whether whole ones cycled; they must, or converge.
fn cycles(case: Case) -> bool {
    let history = solve(case, LineSearch::OnResidual).unwrap_or_else(|error| panic!("{case:?}: {error:?}"));
    assert!(history.len() <= 71, "{case:?}: {} iterates", history.len());
    match solve(case, LineSearch::Off) {
        Ok(_) => false,
        Err(error) => {
            let NewtonFailure::Cycling { first, period } = error.why else { panic!("{case:?}: {error:?}") };
            assert!(period > 1 && first + period + 1 == error.history.len(), "{case:?}: {error:?}");
            // Named when it comes round; one of Tresca's 81 cases begins to repeat itself at iterate 21 only.
            assert!(error.history.len() <= 30, "{case:?}: {error:?}");
            true
        }
    }
}

#[test]
fn whole_steps_that_cycle_are_named_and_shorter_ones_converge() {
    let coulomb = Case {
        law: Law::Coulomb,
        theta: 0.0,
        friction: 0.3,
        gamma0_over_young: 20.0,
        shear: 0.006,
        active: Active::Told,
    };
    assert!(cycles(coulomb));
    assert!(cycles(Case { active: Active::Hidden, ..coulomb }));
    let tresca = Case { law: Law::Tresca, friction: 0.1, shear: 0.004, ..coulomb };
    assert!(cycles(tresca));
    assert!(!cycles(Case { friction: 0.3, ..tresca }));
}

/// Both laws, three ways to shear, and a coefficient, γ₀ and θ of each; FORMS_SWEEPS=1: three of them.
#[test]
fn shorter_steps_converge_in_every_case() {
    let all = std::env::var_os("FORMS_SWEEPS").is_some();
    let choose = |values: [f64; 3], one: usize| if all { values.to_vec() } else { vec![values[one]] };
    for law in [Law::Coulomb, Law::Tresca] {
        let (mut cases, mut cycled) = (0, 0);
        for theta in choose([-1.0, 0.0, 1.0], 1) {
            for friction in choose([0.1, 0.3, 0.6], 0) {
                for gamma0_over_young in choose([10.0, 20.0, 100.0], 1) {
                    // At the edge of sticking whatever the coefficient, and on either side of it.
                    for shear in [0.02 * friction, 0.006, 0.02] {
                        let active = Active::Told;
                        let case = Case { law, theta, friction, gamma0_over_young, shear, active };
                        (cases, cycled) = (cases + 1, cycled + usize::from(cycles(case)));
                    }
                }
            }
        }
        println!("{law:?}: whole steps cycled in {cycled} of {cases} cases, shorter ones in none");
        assert!(cycled > 0);
    }
}

/// A piecewise affine law passes a Taylor test between its kinks, and not with another law's derivative.
#[test]
fn a_piecewise_affine_form_passes_its_taylor_test() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh);
    let data = |theta| rough::data().lambda(115.0).mu(77.0).theta(theta).gamma0(2e3).friction(0.3).bound(1e3);
    let (omega, contact) = (rough::Omega::on("all"), rough::Contact::on("bottom"));
    // Pressed and sticking everywhere, for Tresca's bound is high.
    let u = Field::interpolate(&space, |x| [0.01 * x[1], -0.01 - 0.002 * x[1]]).unwrap();
    let direction = Field::interpolate(&space, |x| [(3.0 * x[0]).sin(), x[0] * x[1]]).unwrap();
    let (law, other) = (data(0.0), data(1.0));
    let form = rough::tresca(&law, &omega, &contact);
    let report = verification::tangent(&assembler, &form, &[&u], &[&direction], 1e-3).unwrap();
    assert!(report.is_affine() && report.second_order() == Ok(f64::INFINITY), "{report}");
    let wrong = rough::tresca(&other, &omega, &contact);
    let wrong = assembler.action(&wrong, &[&u], &[&direction], &[&space]).unwrap();
    let report = verification::taylor(1e-3, &wrong, |step| {
        assembler
            .residual(&form, &[&Field::combination(&[(1.0, &u), (step, &direction)]).unwrap()], &[&space])
            .map(Sample::from)
    });
    let failure = report.unwrap().second_order();
    assert!(matches!(failure, Err(TaylorFailure::Order { .. })), "{failure:?}");
    let none = verification::tangent(&assembler, &form, &[&u], &[&Field::zero(&space)], 1e-3);
    assert!(matches!(none, Err(VerificationError::NoDirection)));
}
