//! Tangents with remembered slip, and gradients of whole load histories through the memory, against differences.

use forms_contact::laws::friction_with_memory as law;
use forms_contact::laws::friction_with_memory::friction_with_memory_adjoint as backwards;
use forms_contact::laws::friction_with_memory::penalty_with_memory as penalty;
use forms_fem::history::WithoutPartner;
use forms_fem::prelude::*;
use forms_fem::verification;

use crate::bodies::{APART, LAMBDA, MU, YOUNG, is_of_block, plane, space, touch};

/// κ and ε.
#[derive(Clone, Copy, Debug)]
struct Friction {
    coefficient: f64,
    stiffness: f64,
}

const FRICTION: Friction = Friction { coefficient: 0.3, stiffness: 150.0 };

fn data<const D: usize>(friction: Friction, pairing: &Pairing, remembered: &Memory<D>) -> law::Data<D> {
    law::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(10.0 * YOUNG)
        .stick_stiffness(friction.stiffness)
        .elastic_slip(remembered.clone())
        .share(if pairing.surfaces.len() == 2 { 0.5 } else { 1.0 })
        .friction(friction.coefficient)
        .criterion_force(|x: &[f64; D]| std::array::from_fn(|k| 0.3 + x[k] - 0.5 * x[0] * x[D - 1]))
}

type Memory<const D: usize> = History<[f64; D], D>;

fn model<const D: usize>(data: law::Data<D>, pairing: &Pairing) -> law::Model<D> {
    law::Model { data, regions: law::Regions::default().touch(pairing.clone()).gamma_n("block right") }
}

/// A smooth displacement that presses the block into the slab, drawn along by a distance.
fn bent<const D: usize>(space: &Arc<Space<D>>, along: f64, phase: f64) -> Field<D> {
    let value = |x: &[f64; D]| -> [f64; D] {
        let block = if is_of_block(x) { 1.0 } else { 0.0 };
        std::array::from_fn(|axis| match axis + 1 == D {
            true => -block * (APART + 0.02) + 0.02 * (3.0 * x[0] + x[D - 1] + phase).sin(),
            false => block * along + 0.02 * (2.0 * x[D - 1] + x[0] + axis as f64 + phase).cos(),
        })
    };
    Field::interpolate(space, value).unwrap()
}

/// The tangents of both laws after a step that has left some springs stretched and let others slide.
fn tangents<const D: usize>(mesh: &Mesh<D>, pairing: &Pairing)
where
    Dim: Dimension<D>,
{
    let space = Space::vector(mesh, 1).unwrap();
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(4));
    let remembered = assembler.history_on_sliding_pairs(pairing, 4, [0.0; D]).unwrap();
    let before = Given::field(bent(&space, 0.2, 0.3));
    let law = model(data(FRICTION, pairing, &remembered).displacement_before(before), pairing);
    let first = bent(&space, 0.205, 0.5);
    let after = law.slip_after_step(&first);
    assembler.update_sliding_history(&after, &remembered, pairing, &first, WithoutPartner::Restart).unwrap();
    remembered.commit();
    let stretched = assembler.history_values(&remembered).unwrap().concat();
    assert!(stretched.iter().any(|value| value.abs() > 1e-3), "{stretched:?}");
    let data = law.data.displacement_before(Given::field(&first));
    let regions = penalty::Regions::default().touch(pairing.clone()).gamma_n("block right");
    let springs = penalty::Model { data: data.clone(), regions };
    let (u, direction) = (bent(&space, 0.21, 0.4), bent(&space, 0.1, 2.3));
    for form in [model(data, pairing).direct(), springs.direct()] {
        let report = verification::tangent(&assembler, &form, &[&u], &[&direction], 1e-4).unwrap();
        let order = report.second_order().unwrap();
        println!("{D}D, {pairing}: order {order:.3}");
        assert!((order - 2.0).abs() < 0.05, "{pairing}: {report}");
    }
}

#[test]
fn tangents_with_stretched_springs() {
    let both = Pairing::between("slab top", "block bottom").within_reach(0.4);
    tangents(&plane(4), &touch());
    tangents(&plane(4), &both);
    tangents(&space(), &both);
}

/// The ways along which the block's top is drawn: all points slide, then some of them stick on the way back.
const WAY: [f64; 6] = [0.25, 0.5, 0.46, 0.43, 0.47, 0.49];

/// A converged step, with what its points remembered before it.
struct Step {
    u: Field<2>,
    before: Field<2>,
    remembered: Memory<2>,
}

/// A block that is pressed on the slab and drawn along it.
struct Drawn {
    space: Arc<Space<2>>,
    assembler: Assembler<2>,
    pairing: Pairing,
}

impl Drawn {
    fn new(pairing: Pairing) -> Self {
        let mesh = plane(4);
        let space = Space::vector(&mesh, 1).unwrap();
        Drawn { assembler: Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4)), space, pairing }
    }

    fn held(&self, step: usize) -> Constraints<2> {
        let mut held = Constraints::new(&self.space);
        held.fix("slab bottom", |_| [0.0; 2]).unwrap();
        held.fix("block top", |_| [WAY[step], -APART - 0.03]).unwrap();
        held
    }

    fn remember(&self) -> Memory<2> {
        self.assembler.history_on_sliding_pairs(&self.pairing, 4, [0.0; 2]).unwrap()
    }

    fn law(&self, friction: Friction, before: &Field<2>, remembered: &Memory<2>) -> law::Model<2> {
        let data = data(friction, &self.pairing, remembered);
        model(data.displacement_before(Given::field(before)), &self.pairing)
    }

    /// All steps, and J.
    fn run(&self, friction: Friction) -> (Vec<Step>, f64) {
        let (mut steps, mut criterion) = (vec![], 0.0);
        let down = |x: &[f64; 2]| if is_of_block(x) { [0.0, -APART - 0.01] } else { [0.0; 2] };
        let mut start = Field::interpolate(&self.space, down).unwrap();
        let mut before = Field::zero(&self.space);
        let mut remembered = self.remember();
        for step in 0..WAY.len() {
            let law = self.law(friction, &before, &remembered);
            let options = NewtonOptions {
                relative_tolerance: 1e-13,
                line_search: LineSearch::OnResidual,
                ..NewtonOptions::default()
            };
            let held = self.held(step);
            let form = law.direct();
            let problem = Problem::new(&form, &self.space).constrained(&held).assembler(&self.assembler);
            let u = problem.start(&start).options(options).solve().unwrap().into_field();
            criterion += self.assembler.functional(&law.criterion(&u)).unwrap();
            let next = self.remember();
            let after = law.slip_after_step(&u);
            self.assembler
                .update_sliding_history(&after, &next, &self.pairing, &u, WithoutPartner::Restart)
                .unwrap();
            next.commit();
            start = u.clone();
            let before = std::mem::replace(&mut before, u.clone());
            steps.push(Step { u, before, remembered: std::mem::replace(&mut remembered, next) });
        }
        (steps, criterion)
    }

    /// dJ/dκ and dJ/dε, backwards through the steps.
    fn gradient(&self, friction: Friction, steps: &[Step]) -> [f64; 2] {
        let (mut weight, mut carried, mut gradient) = (self.remember(), None, [0.0; 2]);
        for (number, step) in steps.iter().enumerate().rev() {
            let data = data(friction, &self.pairing, &step.remembered);
            let data = data.displacement_before(Given::field(&step.before));
            let regions = backwards::Regions::default().touch(self.pairing.clone()).gamma_n("block right");
            let model = backwards::Model { data: backwards::data_from(data).slip_weight(weight), regions };
            let mut equation = model.adjoint(&step.u);
            if let Some(carried) = &carried {
                equation = &equation + carried;
            }
            let held = self.held(number).homogeneous();
            let mut problem =
                Problem::new(&equation, &self.space).constrained(&held).assembler(&self.assembler);
            let p = problem.solve().unwrap().into_field();
            let parts = [model.by_friction(&step.u, &p), model.by_stiffness(&step.u, &p)];
            for (total, part) in gradient.iter_mut().zip(&parts) {
                *total += self.assembler.functional(part).unwrap();
            }
            carried = Some(model.carried(&step.u, &p));
            weight = self.remember();
            let before = model.weight_before(&step.u, &p);
            self.assembler
                .update_sliding_history(&before, &weight, &self.pairing, &step.u, WithoutPartner::Restart)
                .unwrap();
            weight.commit();
        }
        gradient
    }
}

/// Gradients by both numbers of the law through six steps over facets of the slab, against differences of fourth order, and a Taylor test.
#[test]
fn gradients_through_the_memory() {
    for pairing in [touch(), Pairing::between("slab top", "block bottom").within_reach(0.4)] {
        let drawn = Drawn::new(pairing.clone());
        let (steps, at) = drawn.run(FRICTION);
        let stretched = drawn.assembler.history_values(&steps[5].remembered).unwrap().concat();
        assert!(stretched.iter().any(|value| value.abs() > 1e-4), "{stretched:?}");
        let gradient = drawn.gradient(FRICTION, &steps);
        let moved = |along: usize, t: f64| {
            let Friction { coefficient, stiffness } = FRICTION;
            let friction = match along {
                0 => Friction { coefficient: coefficient + t, stiffness },
                _ => Friction { coefficient, stiffness: stiffness + t },
            };
            drawn.run(friction).1
        };
        for (along, step) in [(0, 1e-4), (1, 0.05)] {
            let slope = gradient[along];
            let [a, b, c, d] = [step, -step, 2.0 * step, -2.0 * step].map(|t| moved(along, t));
            let difference = (8.0 * (a - b) - (c - d)) / (12.0 * step);
            let error = (difference - slope).abs() / slope.abs();
            println!("{pairing}, {along}: {slope:.12e}, differences {difference:.12e} ({error:.1e})");
            assert!(error < 1e-7, "{pairing} {along}: {slope} {difference}");
            let rest = [(c, 2.0 * step), (a, step)].map(|(value, t)| (value - at - t * slope).abs());
            let order = (rest[0] / rest[1]).log2();
            assert!((order - 2.0).abs() < 0.05, "{pairing} {along}: order {order}");
        }
    }
}
