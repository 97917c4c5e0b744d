//! γ₀ for materials that are nearly incompressible: two punches and press fits for ν from 0.3 to 0.49999, with γ₀ = 10 (λ + 2μ) and with
//! γ₀ = 10 E. A force is right to 1 %, or a note or the error names the threshold.

use std::f64::consts::PI;

use forms_contact::ContactProblem;
use forms_contact::law::ContactLaw;
use forms_contact::laws::finite_nitsche;
use forms_contact::laws::frictional_nitsche;
use forms_contact::laws::sliding_bodies;
use forms_contact::laws::two_bodies;
use forms_contact::nitsche;
use forms_contact::threshold::usual_gamma0;
use forms_fem::prelude::*;

const RATIOS: [f64; 6] = [0.3, 0.45, 0.49, 0.4995, 0.49995, 0.49999];
/// Largest error of a force without a warning.
const OFF: f64 = 0.01;

/// A material with E = 1, and γ₀.
#[derive(Clone, Copy)]
struct Material {
    lambda: f64,
    mu: f64,
    gamma0: f64,
}

impl Material {
    /// γ₀ as a rule.
    fn usual(poisson: f64) -> Self {
        let (lambda, mu) = (poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), 0.5 / (1.0 + poisson));
        Material { lambda, mu, gamma0: usual_gamma0(lambda, mu) }
    }

    fn with_gamma0(self, gamma0: f64) -> Self {
        Material { gamma0, ..self }
    }
}

/// A force with the words of a warning, or of the error.
struct Found {
    force: Option<f64>,
    words: String,
}

impl Found {
    fn of<const D: usize>(solved: Result<Solved<D>, SolveError>, force: impl Fn(&Solved<D>) -> f64) -> Self {
        match solved {
            Ok(solved) => Found { force: Some(force(&solved)), words: solved.notes().concat() },
            Err(error) => Found { force: None, words: error.to_string() },
        }
    }

    fn warns(&self) -> bool {
        self.words.contains("threshold of Nitsche's method")
    }

    /// Right to 1 %, or with a warning.
    fn check(&self, what: &str, expected: f64) -> String {
        let off = self.force.map(|force| (force / expected - 1.0).abs());
        assert!(off.is_some_and(|off| off < OFF) || self.warns(), "{what}: off by {off:?}; {}", self.words);
        let shown = self
            .force
            .map_or_else(|| "–".to_owned(), |force| format!("{:+.2} %", 100.0 * (force / expected - 1.0)));
        format!("{shown}{}", if self.warns() { " **w**" } else { "" })
    }
}

/// A rigid punch on a block of 2 × 1 whose base is pushed up by 0.05.
#[derive(Clone, Copy)]
enum Punch {
    /// A parabola with the radius 1.
    Round,
    /// A flat of width 1.
    Flat,
}

impl Punch {
    fn block(self, cells: usize) -> Mesh<2> {
        let divisions = [2 * cells, cells];
        let mut mesh = rectangle([-1.0, -1.0], [1.0, 0.0], divisions, CellShape::Triangle, 1).unwrap();
        let below = |x: &[f64; 2]| matches!(self, Punch::Round) || x[0].abs() < 0.5;
        mesh.name_facets("below the punch", "top", below).unwrap();
        mesh
    }

    fn data(self, material: Material, theta: f64) -> nitsche::Data<2> {
        let Material { lambda, mu, gamma0 } = material;
        let gap = move |x: &[f64; 2]| if matches!(self, Punch::Round) { x[0] * x[0] / 2.0 } else { 0.0 };
        let obstacle_normal = Given::constant([0.0, 1.0]);
        nitsche::data()
            .lambda(lambda)
            .mu(mu)
            .gamma0(gamma0)
            .obstacle_normal(obstacle_normal)
            .gap(gap)
            .theta(theta)
    }

    /// In `steps` load steps.
    fn solve<L: ContactLaw<2>>(self, law: L, cells: usize, steps: usize) -> Found {
        let mesh = self.block(cells);
        let space = Space::vector(&mesh, 2).unwrap();
        let mut last = None;
        let mut path = LoadSteps::uniform(steps, 0.05);
        path.smallest_increment = 1e-4;
        let reached = path.advance(Field::zero(&space), |step| {
            let mut held = Constraints::new(&space);
            held.fix("bottom", |_| [0.0, step.factor]).unwrap();
            let problem = ContactProblem::new(&space, law.clone(), held);
            let solved = problem.direct().unwrap().increment(step).solve()?;
            let u = solved.field().clone();
            last = Some(solved);
            Ok(u)
        });
        let solved = reached.map_err(|error| error.why).map(|_| last.unwrap());
        Found::of(solved, |solved| solved.reaction("bottom").unwrap()[1])
    }

    fn small(self, material: Material, theta: f64) -> Found {
        let regions = nitsche::Regions::default().gamma_n("left").gamma_c("below the punch");
        self.solve(nitsche::Model { data: self.data(material, theta), regions }, 16, 1)
    }

    fn finite(self, material: Material) -> Found {
        let base = self.data(material, 0.0);
        let regions = finite_nitsche::Regions::default().gamma_n("left").gamma_c("below the punch");
        self.solve(finite_nitsche::Model { data: frictional_nitsche::data_from(base), regions }, 8, 5)
    }
}

/// A row of the table for each ν: the answers' errors with both γ₀.
fn table(name: &str, ratios: &[f64], mut row: impl FnMut(f64) -> [String; 2]) {
    println!("\n{name}\n| ν | 10 (λ + 2μ) | 10 E |\n| --: | --: | --: |");
    for &poisson in ratios {
        let [usual, of_young] = row(poisson);
        println!("| {poisson} | {usual} | {of_young} |");
    }
}

/// Punches at small strains compared with the variant without a threshold, θ = −1, with γ₀ = 3 (λ + 2μ).
fn pressed(name: &str, punch: Punch) {
    table(name, &RATIOS, |poisson| {
        let material = Material::usual(poisson);
        let expected = punch.small(material.with_gamma0(0.3 * material.gamma0), -1.0).force.unwrap();
        let usual = punch.small(material, 0.0);
        assert!(!usual.warns(), "{}", usual.words);
        let of_young = punch.small(material.with_gamma0(10.0), 0.0);
        [usual, of_young].map(|found| found.check(name, expected))
    });
}

#[test]
fn round_punch() {
    pressed("round punch", Punch::Round);
}

#[test]
fn flat_punch() {
    pressed("flat punch", Punch::Flat);
}

/// At finite strain, in load steps, compared with γ₀ = 3 (λ + 2μ). With 10 E and ν from 0.49995 on no step is small enough, and the error names
/// the threshold. FORMS_SWEEPS=1: all ratios.
#[test]
fn round_punch_at_finite_strain() {
    let all = std::env::var_os("FORMS_SWEEPS").is_some();
    let ratios: Vec<f64> = RATIOS.into_iter().filter(|ratio| all || [0.3, 0.49999].contains(ratio)).collect();
    table("round punch, finite strain", &ratios, |poisson| {
        let material = Material::usual(poisson);
        let expected = Punch::Round.finite(material.with_gamma0(0.3 * material.gamma0)).force.unwrap();
        let usual = Punch::Round.finite(material);
        assert!(!usual.warns(), "{}", usual.words);
        let of_young = Punch::Round.finite(material.with_gamma0(10.0));
        assert!(of_young.force.is_some() || of_young.words.contains("lambda + 2 mu"), "{}", of_young.words);
        [usual, of_young].map(|found| found.check("at finite strain", expected))
    });
}

/// p · 2πr of a ring that is pressed together between two radii, u_r = A r + B/r.
struct Ring {
    material: Material,
    /// A and B.
    constants: [f64; 2],
}

impl Ring {
    /// With u_r at the inner and the outer radius.
    fn moved(material: Material, [inner, outer]: [f64; 2], [at_inner, at_outer]: [f64; 2]) -> Self {
        let a = (at_outer * outer - at_inner * inner) / (outer * outer - inner * inner);
        Ring { material, constants: [a, (at_inner - a * inner) * inner] }
    }

    /// Free at the inner radius, moved at the outer one.
    fn free_inside(material: Material, [inner, outer]: [f64; 2], at_outer: f64) -> Self {
        let b_of_a = (material.lambda + material.mu) / material.mu * inner * inner;
        let a = at_outer / (outer + b_of_a / outer);
        Ring { material, constants: [a, a * b_of_a] }
    }

    fn force(&self, r: f64) -> f64 {
        let (Material { lambda, mu, .. }, [a, b]) = (self.material, self.constants);
        (2.0 * mu * b / (r * r) - 2.0 * (lambda + mu) * a) * 2.0 * PI * r
    }
}

/// A rigid shaft of the radius 1.02 in a hub with the bore 1, held at its outer radius 2.
#[test]
fn press_fit_on_a_rigid_shaft() {
    let mut mesh = annulus(1.0, 2.0, 8, 48, CellShape::Triangle, 2).unwrap();
    mesh.name_facets("bore", "inner", |_| true).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let solve = |material: Material| {
        let Material { lambda, mu, gamma0 } = material;
        let inward = |x: &[f64; 2]| x.map(|k| -k / x[0].hypot(x[1]));
        let (obstacle_normal, gap) = (Given::function(inward), Given::constant(-0.02));
        let data = nitsche::data()
            .lambda(lambda)
            .mu(mu)
            .gamma0(gamma0)
            .obstacle_normal(obstacle_normal)
            .gap(gap)
            .theta(0.0);
        let regions = nitsche::Regions::default().gamma_n("outer").gamma_c("bore");
        let mut held = Constraints::new(&space);
        held.fix("outer", |_| [0.0; 2]).unwrap();
        let problem = ContactProblem::new(&space, nitsche::Model { data, regions }, held)
            .quadrature(Quadrature::Degree(8));
        let force =
            |solved: &Solved<2>| solved.functional(&problem.law.contact_force(solved.field())).unwrap();
        Found::of(problem.direct().unwrap().solve(), force)
    };
    table("press fit on a rigid shaft", &RATIOS, |poisson| {
        let material = Material::usual(poisson);
        let expected = Ring::moved(material, [1.0, 2.0], [0.02, 0.0]).force(1.0);
        let usual = solve(material);
        assert!(!usual.warns(), "{}", usual.words);
        [usual, solve(material.with_gamma0(10.0))].map(|found| found.check("rigid shaft", expected))
    });
}

/// Two elastic rings, radii ½, 1 and 2, pressed together by −0.002 at the outer one: both laws between bodies.
#[test]
fn press_fit_of_two_bodies() {
    let [shaft, hub] = [[0.5, 1.0], [1.0, 2.0]]
        .map(|[inner, outer]| annulus(inner, outer, 4, 48, CellShape::Quadrilateral, 2).unwrap());
    let mesh = Mesh::of_bodies(&[("shaft", &shaft), ("hub", &hub)]).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let pushed = 0.002;
    let touch = Pairing::onto("hub inner", "shaft outer").within_reach(0.2);
    let data = |Material { lambda, mu, gamma0 }: Material| {
        two_bodies::data()
            .lambda(lambda)
            .mu(mu)
            .gamma0(gamma0)
            .share(1.0)
            .force_direction(|x: &[f64; 2]| x.map(|k| k / x[0].hypot(x[1])))
    };
    fn solve<L: ContactLaw<2>>(
        space: &Arc<Space<2>>,
        pushed: f64,
        law: L,
        force: impl Fn(&Solved<2>) -> f64,
    ) -> Found {
        let mut held = Constraints::new(space);
        held.fix("hub outer", |x| x.map(|k| -pushed * k / 2.0)).unwrap();
        // The shaft may turn, for nothing rubs on it: one of its nodes does not go aside.
        let on_axis = |x: &[f64; 2]| (x[0] - 0.5).abs() < 1e-12 && x[1].abs() < 1e-12;
        held.fix_node(space.positions().iter().position(on_axis).unwrap(), 1, 0.0).unwrap();
        let problem = ContactProblem::new(space, law, held).quadrature(Quadrature::Degree(8));
        Found::of(problem.direct().unwrap().solve(), force)
    }
    table("press fit of two bodies, small strains", &RATIOS, |poisson| {
        let most = 0.49;
        let material = Material::usual(poisson);
        let of = |material: Material| {
            let regions = two_bodies::Regions::default().touch(touch.clone()).gamma_n("hub outer");
            let law = two_bodies::Model { data: data(material), regions };
            solve(&space, pushed, law.clone(), |solved| {
                solved.functional(&law.contact_force(solved.field())).unwrap()
            })
        };
        // Cells of degree 2 lock as λ/μ grows, whatever γ₀ is: the same mesh is compared with.
        let expected = of(material.with_gamma0(0.3 * material.gamma0)).force.unwrap();
        let exact = Ring::free_inside(material, [0.5, 2.0], -pushed).force(1.0);
        assert!(poisson > most || (expected / exact - 1.0).abs() < OFF, "{expected} is not {exact}");
        let usual = of(material);
        assert!(!usual.warns(), "{}", usual.words);
        [usual, of(material.with_gamma0(10.0))].map(|found| found.check("two bodies", expected))
    });
    table("press fit of two bodies, finite strains", &RATIOS, |poisson| {
        let most = 0.45;
        let material = Material::usual(poisson);
        let of = |material: Material| {
            let regions = sliding_bodies::Regions::default().touch(touch.clone()).gamma_n("hub outer");
            let law = sliding_bodies::Model { data: data(material), regions };
            solve(&space, pushed, law.clone(), |solved| {
                solved.functional(&law.contact_force(solved.field())).unwrap()
            })
        };
        // Cells of degree 2 lock as λ/μ grows, whatever γ₀ is: the same mesh is compared with.
        let expected = of(material.with_gamma0(0.3 * material.gamma0)).force.unwrap();
        let exact = Ring::free_inside(material, [0.5, 2.0], -pushed).force(1.0);
        assert!(poisson > most || (expected / exact - 1.0).abs() < OFF, "{expected} is not {exact}");
        let usual = of(material);
        assert!(!usual.warns(), "{}", usual.words);
        [usual, of(material.with_gamma0(10.0))].map(|found| found.check("sliding bodies", expected))
    });
}
