//! A brittle beam on two supports, bent by a round rigid tool until it cracks: damage that only grows, by bounds on its unknowns, with
//! contact by Nitsche's method.
//!
//! ```text
//! ∫ (1 − d)² ψ₊(u) + ψ₋(u) + (3 G/8) (d/ℓ + ℓ |∇d|²),   d_before ≤ d ≤ 1
//! ```
//!
//! The damage is of the kind AT1 (Pham, Amor, Marigo and Maurini 2011): there is none below a threshold. Compression of the volume does not drive it (Amor, Marigo
//! and Maurini 2009). Each step minimises alternately by u, in contact with the tool, and by d, under its bounds. By symmetry the right
//! half is computed.
//!
//! Run it with `cargo run --release --bin damage -- [CELLS ALONG] [STEPS]`. Pictures are in `out/damage.png` and `out/damage_force.png`.

use std::error::Error;
use std::process::ExitCode;

use forms_fem::output::picture::{Curve, FieldMap, LinePlot, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod beam {
    pub struct Data {
        /// Bulk and shear modulus \[MPa\].
        pub bulk: Param,
        pub shear: Param,
        /// G \[N/mm\], and the length ℓ over which a crack is smeared \[mm\].
        pub toughness: Param,
        pub length: Param,
        /// Way of the tool \[mm\], and its radius.
        pub way: Param,
        pub radius: Param,
        pub gamma0: Param,
    }

    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Top;

    fn intact(d: Scalar) -> Scalar {
        sqr(1 - d) + 0.000001
    }
    fn stress(u: Vector, d: Scalar) -> Tensor {
        let drawn = bulk * pos_part(div(u)) * I + 2 * shear * (eps(u) - div(u) / 3 * I);
        intact(d) * drawn - bulk * neg_part(div(u)) * I
    }
    /// ψ₊: what damage takes away.
    fn driving(u: Vector) -> Scalar {
        bulk * sqr(pos_part(div(u))) / 2 + shear * (inner(eps(u), eps(u)) - sqr(div(u)) / 3)
    }
    fn cracked(d: Scalar) -> Scalar {
        3 * toughness / 8 * (d / length + length * dot(grad(d), grad(d)))
    }

    /// The tool presses with [σ_n − γ (u_y − g)]₋ downward; g is the height of the tool's round end above the beam.
    pub fn pressure(u: Vector, d: Scalar) -> Scalar {
        let gap = sqr(x[0]) / (2 * radius) - way;
        neg_part((stress(u, d) * n)[1] - gamma0 / h * (u[1] - gap))
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>, d: State<Scalar>) -> Form {
        integral(Omega, inner(stress(u, d), eps(v))) + integral(Top, pressure(u, d) * v[1])
    }
    pub fn damaged(d: Unknown<Scalar>, u: State<Vector>) -> Energy {
        integral(Omega, intact(d) * driving(u) + cracked(d))
    }

    pub fn stored_energy(u: State<Vector>, d: State<Scalar>) -> Functional {
        integral(Omega, intact(d) * driving(u) + bulk * sqr(neg_part(div(u))) / 2)
    }
    pub fn crack_energy(d: State<Scalar>) -> Functional {
        integral(Omega, cracked(d))
    }
    pub fn force(u: State<Vector>, d: State<Scalar>) -> Functional {
        integral(Top, pressure(u, d))
    }
}

const HALF: f64 = 2.0;
const HEIGHT: f64 = 1.0;
const SUPPORT: f64 = 1.75;
/// No damage is looked for beyond: the support is a point.
const WATCHED: f64 = 1.0;
const LENGTH: f64 = 0.1;
const TOUGHNESS: f64 = 0.01;
/// Alternate minimisation ends where d changes by less than this.
const SETTLED: f64 = 1e-5;
const MOST: usize = 2000;

fn model(way: f64) -> beam::Model<2> {
    let (young, poisson) = (100.0, 0.2);
    let data = beam::data()
        .bulk(young / (3.0 * (1.0 - 2.0 * poisson)))
        .shear(young / (2.0 * (1.0 + poisson)))
        .toughness(TOUGHNESS)
        .length(LENGTH)
        .way(way)
        .radius(0.5)
        .gamma0(10.0 * young);
    beam::Model::new(data)
}

/// Numbers of the whole beam after a step.
struct Step {
    way: f64,
    force: f64,
    damage: f64,
    stored: f64,
    dissipated: f64,
    rounds: usize,
}

struct Beam {
    displacements: Arc<Space<2>>,
    damages: Arc<Space<2>>,
    supports: Constraints<2>,
    assembler: Assembler<2>,
}

impl Beam {
    fn new(along: usize) -> Result<Beam, Box<dyn Error>> {
        let mesh = rectangle([0.0; 2], [HALF, HEIGHT], [along, along / 2], CellShape::Quadrilateral, 1)?;
        let (displacements, damages) = (Space::vector(&mesh, 1)?, Space::scalar(&mesh, 1)?);
        let mut supports = Constraints::new(&displacements);
        supports.fix_component("left", 0, |_| 0.0)?;
        let from_support = |x: &[f64; 2]| (x[0] - SUPPORT).hypot(x[1]);
        let nodes = displacements.positions().iter().map(from_support).enumerate();
        let (node, _) = nodes.min_by(|a, b| a.1.total_cmp(&b.1)).ok_or("a mesh without nodes")?;
        supports.fix_node(node, 1, 0.0)?;
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
        Ok(Beam { displacements, damages, supports, assembler })
    }

    /// Minimises alternately, from the state before.
    fn step(&self, way: f64, u: &mut Field<2>, d: &mut Field<2>) -> Result<Step, Box<dyn Error>> {
        let model = model(way);
        let mut bounds = Bounds::new(&self.damages);
        bounds.at_least_field(d)?.at_most("all", |x| if x[0] > WATCHED { 0.0 } else { 1.0 })?;
        let (mut by_u, mut by_d) = (TangentSolver::default(), TangentSolver::default());
        let mut rounds = 0;
        loop {
            rounds += 1;
            let balance = model.balance(&*d);
            let problem = Problem::new(&balance, &self.displacements).constrained(&self.supports);
            let mut problem = problem.assembler(&self.assembler).start(&*u).solver(&mut by_u);
            let moved = problem.solve()?.into_field();
            drop(problem);
            *u = moved;
            let damaged = model.damaged(&*u).into();
            let problem = Problem::new(&damaged, &self.damages).bounded(&bounds).assembler(&self.assembler);
            let next = problem.start(&*d).solver(&mut by_d).solve()?.into_field();
            let changes = next.values().iter().zip(d.values()).map(|(next, d)| (next - d).abs());
            let change = changes.fold(0.0, f64::max);
            *d = next;
            if change < SETTLED {
                break;
            }
            if rounds == MOST {
                return Err(format!(
                    "no rest after {MOST} rounds at {way}; the last changed d by {change:e}"
                )
                .into());
            }
        }
        let value = |functional: &Functional<2>| self.assembler.functional(functional);
        Ok(Step {
            way,
            force: 2.0 * value(&model.force(&*u, &*d))?,
            damage: d.values().iter().fold(0.0, |most: f64, d| most.max(*d)),
            stored: 2.0 * value(&model.stored_energy(&*u, &*d))?,
            dissipated: 2.0 * value(&model.crack_energy(&*d))?,
            rounds,
        })
    }
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let along = counts.first().copied().unwrap_or(80);
    let count = counts.get(1).copied().unwrap_or(30);
    let beam = Beam::new(along)?;
    let (mut u, mut d) = (Field::zero(&beam.displacements), Field::zero(&beam.damages));
    out.line(
        "| way | force | largest d | stored | dissipated | work | rounds |\n| --: | --: | --: | --: | --: | --: | --: |",
    );
    let (mut work, mut steps) = (0.0, Vec::<Step>::new());
    for number in 1..=count {
        let way = 0.09 * number as f64 / count as f64;
        let before = d.values().to_vec();
        let step = beam.step(way, &mut u, &mut d)?;
        if d.values().iter().zip(&before).any(|(now, before)| now < before) {
            return Err("damage healed".into());
        }
        let (last_way, last_force) = steps.last().map_or((0.0, 0.0), |last| (last.way, last.force));
        work += 0.5 * (step.force + last_force) * (way - last_way);
        out.line(format!(
            "| {way:.4} | {:.5} | {:.4} | {:.5e} | {:.5e} | {work:.5e} | {} |",
            step.force, step.damage, step.stored, step.dissipated, step.rounds
        ));
        steps.push(step);
    }
    let last = steps.last().ok_or("no steps")?;
    out.line(format!(
        "the crack costs {:.4e}, a straight one through the beam G H (1 + 3h/8ℓ) = {:.4e} (h: width of a cell)",
        last.dissipated,
        TOUGHNESS * HEIGHT * (1.0 + 3.0 / 8.0 * HALF / along as f64 / LENGTH)
    ));
    FieldMap::of(&d, Shown::Component(0), "d")
        .range(0.0, 1.0)
        .without_mesh_lines()
        .size(420.0, 260.0)
        .length_unit("mm")
        .title("A cracked beam under a round tool (right half)")
        .write_png("out/damage.png")?;
    let (ways, forces): (Vec<f64>, Vec<f64>) = steps.iter().map(|step| (step.way, step.force)).unzip();
    LinePlot::new()
        .title("Force on the tool")
        .x_axis("way of the tool / mm", Scale::Linear)
        .y_axis("force / N per mm", Scale::Linear)
        .grid()
        .curve(Curve::new("force", &ways, &forces))
        .write_png("out/damage_force.png")?;
    out.line("pictures: out/damage.png, out/damage_force.png");
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
