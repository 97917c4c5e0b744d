//! A round die of rubber that is pressed into a slab and drawn along it by one cell, without friction: its force should not depend on the place.

use forms_fem::mesh::structured;
use forms_fem::output::Failure;
use forms_fem::prelude::*;

use crate::formulation::Formulation;
use crate::posed::Posed;
use crate::problem::Quantity;
use crate::rows::{Answer, Measured};
use crate::sliding::{self, Slid, Sliding};

const YOUNG: f64 = 100.0;
/// Steps down, and steps along one cell of the slab.
const DOWN: usize = 5;
const ALONG: usize = 10;
const DEPTH: f64 = 0.1;

/// The die over the slab.
pub enum DrawnDie {
    /// The die's surface is integrated over.
    OverDie,
    /// The slab's.
    OverSlab,
}

impl DrawnDie {
    fn bodies(&self, level: usize, degree: usize) -> Result<Sliding, Failure> {
        let n = 4 << level;
        let slab = rectangle([-3.0, 0.0], [5.0, 1.0], [8 * n, n], CellShape::Quadrilateral, 1)?;
        let die = structured([n + 1, n / 2], CellShape::Quadrilateral, 1, |[s, t]: [f64; 2]| {
            let x = s - 0.5;
            let bottom = 2.0 - (1.0 - x * x).sqrt();
            [1.0 + x, bottom + t * (1.5 - bottom)]
        })?;
        let mut mesh = Mesh::of_bodies(&[("slab", &slab), ("die", &die)])?;
        mesh.name_facets("below", "slab top", |x| (x[0] - 1.0).abs() < 1.0)?;
        let space = Space::vector(&mesh, degree)?;
        let down = (1..=DOWN).map(|k| [0.0, -DEPTH * k as f64 / DOWN as f64]);
        let along = (1..=ALONG).map(|k| [k as f64 / (ALONG * n) as f64, -DEPTH]);
        let first = DEPTH / DOWN as f64;
        // The die, whose nodes are above the slab's top but for one.
        let fallen = |x: &[f64; 2]| [0.0, if x[1] > 1.0 + 1e-9 { -first } else { 0.0 }];
        let [lambda, mu] = super::lame(YOUNG, 0.3);
        Ok(Sliding {
            start: Field::interpolate(&space, fallen)?,
            space,
            data: sliding::data().lambda(lambda).mu(mu).young(YOUNG),
            surfaces: match self {
                DrawnDie::OverDie => ["die bottom", "below"],
                DrawnDie::OverSlab => ["below", "die bottom"],
            },
            held: "slab bottom",
            moved: "die top",
            ways: down.chain(along).collect(),
            pressure: 0.1 * YOUNG,
            approach: DEPTH,
        })
    }
}

fn quantities(path: &[Slid]) -> Vec<Quantity> {
    let across: Vec<f64> = path[DOWN - 1..].iter().map(|slid| slid.force[1].abs()).collect();
    let mean = across.iter().sum::<f64>() / across.len() as f64;
    let most = across.iter().copied().fold(0.0, f64::max);
    let least = across.iter().copied().fold(f64::INFINITY, f64::min);
    let side = path[DOWN - 1..].iter().map(|slid| (slid.force[0] / slid.force[1]).abs()).fold(0.0, f64::max);
    vec![
        Quantity { name: "mean F_y", value: mean, exact: None },
        Quantity { name: "(max − min)/mean of F_y", value: (most - least) / mean, exact: Some(0.0) },
        Quantity { name: "largest |F_x|/F_y", value: side, exact: Some(0.0) },
    ]
}

impl Posed for DrawnDie {
    fn name(&self) -> String {
        match self {
            DrawnDie::OverDie => "drawn_die",
            DrawnDie::OverSlab => "drawn_die_slab",
        }
        .to_owned()
    }

    fn statement(&self) -> &'static str {
        match self {
            DrawnDie::OverDie => {
                "a round neo-Hookean die pressed 0.1 into a slab and drawn along one of its cells, E = 100, integrated over the die; GetFEM has the same numbers at the same points"
            }
            DrawnDie::OverSlab => "the same die, integrated over the slab",
        }
    }

    fn answer(
        &self,
        formulation: &dyn Formulation,
        level: usize,
        degree: usize,
    ) -> Result<(usize, Answer), Failure> {
        let bodies = self.bodies(level, degree)?;
        let measure = |path: Vec<Slid>, seconds| {
            Ok(Measured {
                seconds,
                no_gradient: Some("not measured".to_owned()),
                penetration: f64::NAN,
                quantities: quantities(&path),
                ..Measured::of_loads(path.iter().map(|slid| &slid.newton[..]))
            })
        };
        let answer = Answer::timed(|| formulation.slide(&bodies), measure)?;
        Ok((bodies.space.unknowns(), answer))
    }
}
