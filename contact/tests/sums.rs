//! A contact problem whose form is a sum: elasticity and Nitsche's contact of two modules, and loads that a program adds.

use forms_contact::ContactProblem;
use forms_contact::forms::nitsche;
use forms_contact::law::ContactLaw;
use forms_contact::parameter_ranges::ParameterRanges;
use forms_fem::prelude::*;

/// Nitsche's terms on Γ_C, without a body.
#[forms(dimension = 2)]
mod facing {
    use forms_contact::operators::linear_elastic::stress;
    use forms_contact::operators::obstacle::{nitsche_density, normal_component};

    #[includes(forms_contact::operators::linear_elastic::Data, forms_contact::operators::obstacle::Data)]
    pub struct Data {}
    #[facets]
    pub struct GammaC;

    pub fn contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(GammaC, nitsche_density(normal_component(stress(u)), u, normal_component(stress(v)), v))
    }
}

/// The paper's law with its form put together at run time.
#[derive(Clone)]
struct Assembled {
    body: Form<2>,
    contacts: Vec<Form<2>>,
    loads: Vec<(f64, Form<2>)>,
}

impl ParameterRanges for Assembled {
    fn check(&self, _: &'static str) -> Result<(), AssemblyError> {
        Ok(())
    }
}

impl ContactLaw<2> for Assembled {
    fn direct(&self) -> Form<2> {
        let loads = self.loads.iter().map(|(factor, load)| *factor * load);
        &self.body + self.contacts.iter().sum::<Form<2>>() - loads.sum::<Form<2>>()
    }

    fn contact_region(&self) -> &str {
        "bottom"
    }
}

const MATERIAL: [f64; 2] = [1.2, 0.8];

fn gap(x: &[f64; 2]) -> f64 {
    0.01 + 0.03 * x[0] * x[0]
}

fn contact(side: &str, normal: [f64; 2], gap: fn(&[f64; 2]) -> f64) -> Form<2> {
    let [lambda, mu] = MATERIAL;
    let data = facing::data().lambda(lambda).mu(mu).gamma0(100.0).obstacle_normal(normal);
    let data = data.gap(move |x: &[f64; 2]| gap(x)).theta(1.0);
    facing::contact(&data, &facing::GammaC::on(side))
}

#[test]
fn contact_drivers_take_sums() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = rectangle([-1.0, 0.0], [1.0, 1.0], [12, 6], CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&mesh, 2)?;
    let mut held = Constraints::new(&space);
    held.fix_component("left", 0, |_| 0.0)?;
    held.fix_component("top", 1, |_| -0.02)?;
    let [lambda, mu] = MATERIAL;
    let data = nitsche::data()
        .lambda(lambda)
        .mu(mu)
        .gamma0(100.0)
        .obstacle_normal([0.0, -1.0])
        .gap(gap)
        .theta(1.0)
        .body_force([0.02, -0.03])
        .traction([0.0; 2]);
    let regions = nitsche::Regions::default().gamma_c("bottom").gamma_n("right");
    let model = nitsche::Model { data, regions };
    let weight = form!(
        |v: Test<Vector>| -> Form { integral(cells("all"), dot(weight, v)) },
        weight: Given<Vector> = [0.02, -0.03],
    );
    let law = Assembled {
        body: model.elasticity(),
        contacts: vec![contact("bottom", [0.0, -1.0], gap)],
        loads: vec![(0.25, weight.clone()), (0.75, weight)],
    };
    let whole = ContactProblem::new(&space, model, held.clone()).direct()?.solve()?;
    let sum = ContactProblem::new(&space, law.clone(), held.clone());
    let found = sum.direct()?.solve()?;
    let difference = |one: &Field<2>, other: &Field<2>| {
        one.values().iter().zip(other.values()).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
    };
    assert!(whole.history.len() > 2 && found.history.len() == whole.history.len());
    assert!(difference(&found.fields[0], &whole.fields[0]) < 1e-13);

    // A second obstacle on another side, with its own normal and gap.
    let contacts = vec![law.contacts[0].clone(), contact("right", [1.0, 0.0], |_| 0.001)];
    let both = ContactProblem::new(&space, Assembled { contacts, ..law }, held);
    let between = both.direct()?.solve()?.into_field();
    let ends = form!(|u: State<Vector>| -> Functional { integral(facets("right"), u[0]) });
    let free = sum.assembler.functional(&ends(&found.fields[0]))?;
    let stopped = both.assembler.functional(&ends(&between))?;
    println!("the right side moves by {free} without, {stopped} with an obstacle");
    assert!(free > 0.004 && (0.0..0.0015).contains(&stopped));
    Ok(())
}
