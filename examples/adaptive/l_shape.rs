//! −Δu = 1 on (−1, 1)² without a quadrant, u = 0 on the boundary: ∇u is infinite in the corner. The goal is J = ∫u.

use forms_fem::adaptivity::{AdaptiveSolution, ErrorEstimate};
use forms_fem::prelude::*;

use crate::Outcome;
use crate::membrane::poisson;
use crate::study::Study;

/// ∫u, by degree 3 on adaptive meshes with the estimate added: the test `the_goal_by_a_higher_degree` of forms-fem.
const GOAL: f64 = 0.214_075_80;
/// Squares along each unit of length of the coarse mesh.
const DIVISIONS: usize = 2;

/// (−1, 1)² without x > 0, y < 0, in right triangles.
fn mesh() -> Outcome<Mesh<2>> {
    let across = 2 * DIVISIONS + 1;
    let place = |k: usize| k as f64 / DIVISIONS as f64 - 1.0;
    let mut numbers = vec![None; across * across];
    let (mut nodes, mut cells) = (vec![], vec![]);
    for (i, j) in (0..across - 1).flat_map(|j| (0..across - 1).map(move |i| (i, j))) {
        if i >= DIVISIONS && j < DIVISIONS {
            continue;
        }
        let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| {
            *numbers[j * across + i].get_or_insert_with(|| {
                nodes.push([place(i), place(j)]);
                nodes.len() as u32 - 1
            })
        });
        cells.extend([0, 1, 2, 0, 2, 3].map(|corner: usize| corners[corner]));
    }
    Ok(Mesh::from_parts(CellShape::Triangle, 1, nodes, cells)?)
}

fn held(space: &Arc<Space<2>>) -> Outcome<Constraints<2>> {
    let mut constraints = Constraints::new(space);
    constraints.fix("boundary", |_| 0.0)?;
    Ok(constraints)
}

/// J by degree 1, its error by an adjoint state of degree 2.
pub fn goal(unknowns: usize) -> Outcome<Study> {
    let model = poisson::Model::new(poisson::data().source(1.0));
    Study::new("L-shape, goal", &mesh()?, unknowns, |mesh, _| {
        let (space, higher) = (Space::scalar(mesh, 1)?, Space::scalar(mesh, 2)?);
        let direct = model.direct();
        let solved = Problem::new(&direct, &space).constrained(&held(&space)?).solve()?;
        let u = solved.field();
        let adjoint = model.adjoint(u);
        let p = Problem::new(&adjoint, &higher).homogeneous(&held(&higher)?).solve()?.into_field();
        let localised = |z: &Field<2>| model.localised(u, z);
        let estimate = ErrorEstimate::dual_weighted(&Assembler::new(mesh), &p, &space, localised)?;
        let goal = solved.functional(&model.goal(u))?;
        Ok((AdaptiveSolution::new(u.clone(), estimate).with_goal(goal), GOAL - goal))
    })
}
