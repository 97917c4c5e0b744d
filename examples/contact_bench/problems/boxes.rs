//! Two boxes that overhang each other, the upper one pressed down in four steps (sfepy's example of two bodies): contact in space.

use forms_fem::mesh::structured;
use forms_fem::output::Failure;
use forms_fem::prelude::*;

use crate::formulation::Formulation;
use crate::outcome::Refusal;
use crate::posed::Posed;
use crate::problem::Quantity;
use crate::rows::{Answer, Measured};
use crate::two_bodies::{AfterLoad, Load, TwoBodies};

/// The gap at first.
const GAP: f64 = 1e-4;
/// The way of the top in each step.
const WAY: f64 = 0.025;
/// The place of the upper box's edge on the lower one, and of the lower one's on the upper one.
const EDGES: [f64; 2] = [0.5, 0.4];

/// A quarter of the boxes: lower 1 × 1 × ½, upper 1.2 × 0.8 × ½.
pub struct Boxes;

/// A place on \[0, end\] by its part of the cells, which are small on both sides of an edge; `part` of them are before it.
fn toward(edge: f64, end: f64, part: f64, s: f64) -> f64 {
    if s <= part {
        let left = 1.0 - s / part;
        edge * (1.0 - left * left)
    } else {
        let passed = (s - part) / (1.0 - part);
        edge + (end - edge) * passed * passed
    }
}

impl Boxes {
    fn bodies(level: usize, degree: usize) -> Result<TwoBodies<3>, Failure> {
        // Cells before an edge of the other box and behind it; unlike numbers in both boxes.
        let lower = structured(
            [5 << level, 6 << level, 4 << level],
            CellShape::Hexahedron,
            1,
            |[s, t, w]: [f64; 3]| {
                let up = 1.0 - w;
                [toward(EDGES[0], 0.5, 1.0, s), toward(EDGES[1], 0.5, 2.0 / 3.0, t), 0.5 * (1.0 - up * up)]
            },
        )?;
        let upper = structured(
            [6 << level, 5 << level, 4 << level],
            CellShape::Hexahedron,
            1,
            |[s, t, w]: [f64; 3]| {
                [toward(EDGES[0], 0.6, 2.0 / 3.0, s), toward(EDGES[1], 0.4, 1.0, t), 0.5 + GAP + 0.5 * w * w]
            },
        )?;
        let mut mesh = Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)])?;
        mesh.name_facets("covered", "lower top", |x| x[1] < EDGES[1])?;
        let space = Space::vector(&mesh, degree)?;
        let load = |step: usize| -> Result<Load<3>, Failure> {
            let mut supports = Constraints::new(&space);
            for body in ["lower", "upper"] {
                supports.fix_component(&format!("{body} left"), 0, |_| 0.0)?;
                supports.fix_component(&format!("{body} front"), 1, |_| 0.0)?;
            }
            supports.fix("lower bottom", |_| [0.0; 3])?;
            supports.fix("upper top", |_| [0.0, 0.0, -WAY * step as f64])?;
            Ok(Load { supports, friction: 0.0 })
        };
        Ok(TwoBodies {
            loads: (1..=4).map(load).collect::<Result<_, _>>()?,
            space,
            surfaces: ["covered", "upper bottom"].map(str::to_owned),
            young: 1.0,
            lame: super::lame(1.0, 0.3),
            // Both are half as high as the way in parts of E.
            pressure: 4.0 * WAY,
            approach: 4.0 * WAY,
        })
    }
}

fn quantities(bodies: &TwoBodies<3>, path: &[AfterLoad<3>]) -> Result<Vec<Quantity>, Refusal> {
    let top = bodies.space.nodes_on("upper top")?;
    let reaction = |after: &AfterLoad<3>| {
        -4.0 * top.iter().map(|node| after.residual[3 * *node as usize + 2]).sum::<f64>()
    };
    let names = ["reaction 1", "reaction 2", "reaction 3", "reaction 4"];
    let mut all: Vec<Quantity> = names
        .iter()
        .zip(path)
        .map(|(name, after)| Quantity { name, value: reaction(after), exact: None })
        .collect();
    if let Some(last) = path.last() {
        let energy = 4.0 * bodies.energy(&last.u)?;
        all.push(Quantity { name: "energy 4", value: energy, exact: Some(4.81e-3) });
    }
    Ok(all)
}

impl Posed for Boxes {
    fn name(&self) -> String {
        "boxes".to_owned()
    }

    fn statement(&self) -> &'static str {
        "a box of 1.2 × 0.8 × 0.5 pressed by 0.1 onto one of 1 × 1 × 0.5 in four steps, E = 1, in space; energy 4.81e-3 ± 0.2 % (NGSolve)"
    }

    fn answer(
        &self,
        formulation: &dyn Formulation,
        level: usize,
        degree: usize,
    ) -> Result<(usize, Answer), Failure> {
        let bodies = Self::bodies(level, degree)?;
        let measure = |path: Vec<AfterLoad<3>>, seconds| {
            let last = path.last().ok_or("no load")?;
            let worst = bodies.penetration(&last.u).map_err(|why| why.to_string())?;
            Ok(Measured {
                seconds,
                no_gradient: Some("not measured".to_owned()),
                penetration: worst / (4.0 * WAY),
                quantities: quantities(&bodies, &path).map_err(|why| why.to_string())?,
                ..Measured::of_loads(path.iter().map(|after| &after.newton[..]))
            })
        };
        let answer = Answer::timed(|| formulation.stack(&bodies), measure)?;
        Ok((bodies.space.unknowns(), answer))
    }
}
