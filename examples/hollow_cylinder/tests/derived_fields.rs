//! Projections of several derived fields at once, compared with those of each field by itself.

use forms_contact_problem::forms;
use forms_contact_problem::hollow_cylinder::{Settings, hollow_cylinder};
use forms_fem::prelude::*;

#[test]
fn fields_that_are_projected_together_are_those_of_each_by_itself() {
    let problem = hollow_cylinder(&Settings { radial: 4, ..Settings::default() }).expect("a problem");
    let (assembler, data, mesh) = (&problem.assembler, &problem.law.data, problem.space.mesh());
    let u = Field::interpolate(&problem.space, |x| [0.01 * x[0] * x[1], (0.1 * x[0]).sin() - 0.02 * x[1]])
        .expect("a displacement");
    let tensors = Space::tensor(mesh, 2).expect("a space");
    let scalars = Space::scalar(mesh, 2).expect("a space");
    // Others have nodes of their own.
    let linear = Space::scalar(mesh, 1).expect("a space");
    let discontinuous = Space::discontinuous_scalar(mesh, 2).expect("a space");
    let (stress, von_mises) = (forms::stress(data, &u), forms::von_mises(data, &u));
    let gap = forms::current_gap(data, &u);
    let fields = [
        (&von_mises, &linear),
        (&stress, &tensors),
        (&gap, &discontinuous),
        (&von_mises, &scalars),
        (&gap, &scalars),
        (&gap, &linear),
    ];
    let together = assembler.project_together(fields).expect("fields");
    for (found, (expression, space)) in together.iter().zip(fields) {
        let alone = assembler.project(expression, space).expect("a field");
        assert_eq!(found.values().len(), space.unknowns());
        let largest = alone.values().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        for (found, alone) in found.values().iter().zip(alone.values()) {
            assert!((found - alone).abs() <= 1e-12 * largest, "{}: {found}, {alone}", expression.name());
        }
    }
    // A space that does not fit is named by the field.
    let refused =
        assembler.project_together([(&gap, &scalars), (&stress, &scalars)]).expect_err("a scalar space");
    assert!(refused.to_string().contains("stress"), "{refused}");
}
