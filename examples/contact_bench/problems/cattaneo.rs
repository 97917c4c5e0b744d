//! A cylinder pressed onto a half-space of its material and drawn along it, there and back (Cattaneo 1938, Mindlin and Deresiewicz 1953).

use std::collections::HashMap;

use forms_contact::half_spaces::{HalfSpaces, SURFACES, StickSlip, cylinders};
use forms_contact::hertz::{Hertz, POISSON, YOUNG};
use forms_fem::output::Failure;
use forms_fem::prelude::*;

use crate::formulation::Formulation;
use crate::outcome::{Pressures, Refusal};
use crate::posed::Posed;
use crate::problem::Quantity;
use crate::rows::{Answer, Measured};
use crate::two_bodies::{AfterLoad, Load, TwoBodies};

const FRICTION: f64 = 0.3;
/// The force that presses, so small that the surfaces are nearly plane where they touch.
const FORCE: f64 = 0.1;
const RADIUS: f64 = 8.0;
/// E* of two bodies of one material.
const MODULUS: f64 = 0.5 * YOUNG / (1.0 - POISSON * POISSON);
/// Q/κP after the second load, and after those that follow.
const PARTS: [f64; 3] = [0.6, 0.0, -0.6];

/// The cylinder on the half-space.
pub struct Cattaneo;

/// A contact with these parts of κP.
fn partly(hertz: Hertz, force: f64, part: f64) -> StickSlip {
    StickSlip::of_line(hertz, force, FRICTION, part * FRICTION * force)
}

/// q(x) at a part of κP after the load was PARTS[0] of it and fell: q* less twice the q of half the fall.
fn traction(hertz: Hertz, force: f64, part: f64, x: f64) -> f64 {
    let most = partly(hertz, force, PARTS[0]).traction(x);
    if part < PARTS[0] {
        most - 2.0 * partly(hertz, force, 0.5 * (PARTS[0] - part)).traction(x)
    } else {
        most
    }
}

impl Cattaneo {
    fn bodies(level: usize, degree: usize) -> Result<TwoBodies<2>, Failure> {
        let cut = cylinders([f64::INFINITY, RADIUS], FORCE, 4 << level)?;
        let pressing = cut.pressed()?.constraints;
        // Displacements of the cut, of degree 2, by unknown.
        let drawn = |part: f64| -> Result<Vec<(usize, f64)>, Failure> {
            let problem = cut.sheared(&partly(cut.hertz, FORCE, part), &Field::zero(&cut.space))?;
            let pressed = pressing.prescribed().values();
            let both = problem.constraints.prescribed().iter().zip(pressed);
            Ok(both.map(|((unknown, drawn), pressed)| (*unknown, drawn - pressed)).collect())
        };
        let space = Space::vector(cut.space.mesh(), degree)?;
        let supports = |more: Vec<(usize, f64)>| -> Result<Constraints<2>, Failure> {
            let mut values: HashMap<usize, f64> =
                pressing.prescribed().iter().map(|(k, u)| (*k, *u)).collect();
            more.iter().for_each(|(k, u)| *values.entry(*k).or_default() += u);
            at_common_nodes(&cut, &space, &values)
        };
        let mut loads = vec![Load { supports: supports(vec![])?, friction: 0.0 }];
        for part in PARTS {
            let mut more = drawn(PARTS[0])?;
            if part < PARTS[0] {
                more.extend(drawn(0.5 * (PARTS[0] - part))?.into_iter().map(|(k, u)| (k, -2.0 * u)));
            }
            loads.push(Load { supports: supports(more)?, friction: FRICTION });
        }
        let hertz = Hertz::of_line_between(FORCE, RADIUS, MODULUS);
        Ok(TwoBodies {
            space,
            surfaces: SURFACES.map(str::to_owned),
            young: YOUNG,
            lame: super::lame(YOUNG, POISSON),
            loads,
            pressure: hertz.pressure(0.0),
            approach: 0.5 * hertz.reach * hertz.reach / RADIUS,
        })
    }
}

/// Values at the nodes of degree 2 as conditions on those of a space that are at the same places.
fn at_common_nodes(
    cut: &HalfSpaces<2>,
    space: &Arc<Space<2>>,
    values: &HashMap<usize, f64>,
) -> Result<Constraints<2>, Failure> {
    // Cell by cell, for both bodies may have a node at one place.
    let mut own = HashMap::new();
    for cell in 0..space.mesh().cell_count() {
        for fine in cut.space.cell_nodes(cell) {
            let place = cut.space.positions()[*fine as usize];
            let is_there = |node: &&u32| space.positions()[**node as usize] == place;
            own.extend(
                space.cell_nodes(cell).iter().find(is_there).map(|node| (*fine as usize, *node as usize)),
            );
        }
    }
    let mut constraints = Constraints::new(space);
    for (unknown, value) in values {
        if let Some(node) = own.get(&(unknown / 2)) {
            constraints.fix_node(*node, unknown % 2, *value)?;
        }
    }
    Ok(constraints)
}

/// ∫ of a function of the place and the traction.
fn integral(after: &AfterLoad<2>, of: impl Fn(f64, [f64; 2]) -> f64) -> f64 {
    let points = after.tractions.positions.iter().zip(&after.tractions.weights).zip(&after.tractions.values);
    points.map(|((x, weight), t)| weight * of(x[0], [t[0], t[1]])).sum()
}

/// Half the width of what sticks: the middle between the innermost point that slips and the next one inside.
fn stick(after: &AfterLoad<2>) -> f64 {
    let points = after.tractions.positions.iter().zip(&after.tractions.values);
    let mut all: Vec<(f64, bool)> =
        points.map(|(x, t)| (x[0].abs(), t[0].abs() > 0.99 * FRICTION * -t[1])).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let first = all.iter().position(|(_, slips)| *slips).unwrap_or(all.len() - 1);
    0.5 * (all[first.saturating_sub(1)].0 + all[first].0)
}

fn quantities(path: &[AfterLoad<2>], hertz: Hertz) -> Vec<Quantity> {
    let force = integral(&path[0], |_, t| -t[1]);
    let found = Hertz::of_line_between(force, RADIUS, MODULUS);
    let error = |after: &AfterLoad<2>, part: f64| {
        let exact = |x: f64| traction(found, force, part, x);
        let square = integral(after, |x, t| (t[0] - exact(x)).powi(2));
        (square / integral(after, |x, _| exact(x).powi(2))).sqrt()
    };
    let shear = |after: &AfterLoad<2>| integral(after, |_, t| t[0]) / (FRICTION * force);
    let all = ["error of τ, Q = 0.6 κP", "error of τ, Q = 0", "error of τ, Q = −0.6 κP"];
    let mut numbers = vec![
        Quantity { name: "P", value: force, exact: Some(FORCE) },
        Quantity { name: "Q/κP", value: shear(&path[1]), exact: Some(PARTS[0]) },
        Quantity { name: "c/a", value: stick(&path[1]) / hertz.reach, exact: Some((1.0 - PARTS[0]).sqrt()) },
    ];
    let errors = all.iter().zip(PARTS).zip(&path[1..]);
    numbers.extend(errors.map(|((name, part), after)| Quantity {
        name,
        value: error(after, part),
        exact: Some(0.0),
    }));
    numbers
}

impl Posed for Cattaneo {
    fn name(&self) -> String {
        "cattaneo".to_owned()
    }

    fn statement(&self) -> &'static str {
        "a cylinder on a half-space, κ = 0.3, pressed by P and drawn by Q = 0.6 κP, 0 and −0.6 κP; c = 0.63246 a (Cattaneo)"
    }

    fn answer(
        &self,
        formulation: &dyn Formulation,
        level: usize,
        degree: usize,
    ) -> Result<(usize, Answer), Failure> {
        let bodies = Self::bodies(level, degree)?;
        let hertz = Hertz::of_line_between(FORCE, RADIUS, MODULUS);
        let measure = |path: Vec<AfterLoad<2>>, seconds| {
            let worst = bodies.penetration(&path[0].u).map_err(|why| why.to_string())?;
            let points = &path[0].tractions;
            let pressures = Pressures {
                positions: points.positions.clone(),
                weights: points.weights.clone(),
                values: points.values.iter().map(|t| -t[1]).collect(),
            };
            let measured = Measured {
                seconds,
                no_gradient: Some("not measured".to_owned()),
                penetration: worst / bodies.approach,
                quantities: quantities(&path, hertz),
                ..Measured::of_loads(path.iter().map(|after| &after.newton[..]))
            };
            Ok(measured.compared(&pressures, |x| x[0], |x| Some(hertz.pressure(x[0]))))
        };
        let solve = || -> Result<Vec<AfterLoad<2>>, Refusal> { formulation.rub(&bodies) };
        let answer = Answer::timed(solve, measure)?;
        Ok((bodies.space.unknowns(), answer))
    }
}
