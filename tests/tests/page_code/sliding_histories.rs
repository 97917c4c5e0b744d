//! `docs/sliding_histories.md`.

use forms_contact::laws::friction_with_memory as law;
use forms_contact::laws::friction_with_memory::friction_with_memory_adjoint as adjoint;
use forms_fem::history::WithoutPartner;
use forms_fem::prelude::*;

pub fn step(
    space: Arc<Space<2>>,
    assembler: Assembler<2>,
    before: Field<2>,
    held: Constraints<2>,
) -> Result<Field<2>, Failure> {
    let touch = Pairing::between("slab top", "block bottom");
    let remembered = assembler.history_on_sliding_pairs(&touch, 4, [0.0; 2])?;     // 4 is the degree of the rule
    let data = law::data().lambda(15.0).mu(10.0).gamma0(300.0).stick_stiffness(500.0).elastic_slip(remembered);
    let law = law::Model {
        data: data.friction(0.3).displacement_before(Given::field(&before)),
        regions: law::Regions::default().touch(touch.clone()).gamma_n("block top"),
    };
    let u = Problem::new(&law.direct(), &space).constrained(&held).start(&before).assembler(&assembler).solve()?.into_field();

    let (after, remembered) = (law.slip_after_step(&u), &law.data.elastic_slip);
    assembler.update_sliding_history(&after, remembered, &touch, &u, WithoutPartner::Restart)?;
    remembered.commit();
    Ok(u)
}

pub struct Step {
    data: law::Data<2>,
    u: Field<2>,
    weight: History<[f64; 2], 2>,
    weight_before: History<[f64; 2], 2>,
}

pub fn back(
    (space, assembler): (Arc<Space<2>>, Assembler<2>),
    Step { data, u, weight, weight_before }: Step,
    carried: Form<2>,
    held: Constraints<2>,
    touch: Pairing,
) -> Result<(f64, Form<2>), Failure> {
    let regions = adjoint::Regions::default().touch(touch.clone()).gamma_n("block top");
    let step = adjoint::Model { data: adjoint::data_from(data).slip_weight(weight), regions };
    let p = Problem::new(&(&step.adjoint(&u) + &carried), &space).constrained(&held.homogeneous()).assembler(&assembler).solve()?.into_field();
    let part = assembler.functional(&step.by_friction(&u, &p))?;                 // its sum over the steps is dJ/dκ
    let carried = step.carried(&u, &p);                                          // loads the step before
    assembler.update_sliding_history(&step.weight_before(&u, &p), &weight_before, &touch, &u, WithoutPartner::Restart)?;
    Ok((part, carried))
}
