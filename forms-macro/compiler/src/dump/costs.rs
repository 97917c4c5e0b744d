//! The table of an integral: operations per call and per element, of each plan and of each way to run the one chosen.

use super::ways;
use crate::optimise::elements::{StandardElement, elements};
use crate::optimise::linear::of_component;
use crate::optimise::plan::Operations;
use crate::optimise::scalar::{Argument, Derivative, Graph, Node};
use crate::optimise::straight_line::Code;
use crate::optimise::{BilinearIntegral, LinearIntegral, Optimised, varies_over_cell};
use crate::parse::syntax::{Entity, Module};
use crate::tensor::FieldInfo;

/// An element with its number of points.
type Column = (&'static StandardElement, usize);

const NAMES: [&str; 5] = ["point", "test", "trial", "pair", "finish"];

fn title((element, points): &Column) -> String {
    format!("  {} ({points})", element.name)
}

fn heading(columns: &[Column]) -> String {
    let names: String = NAMES.iter().map(|name| format!("{name:>8}")).collect();
    let titles: String = columns.iter().map(title).collect();
    format!("  operations:       {names}{titles}\n")
}

/// A row; what does not apply is a dash.
fn row(
    name: &str,
    calls: Option<[usize; 5]>,
    columns: &[Column],
    cost: impl Fn(&Column) -> Option<usize>,
) -> String {
    let text = |count: Option<usize>| count.map_or("-".to_string(), |count| count.to_string());
    let mut line = format!("  {name:<18}");
    for index in 0..NAMES.len() {
        line += &format!("{:>8}", text(calls.map(|calls| calls[index])));
    }
    for column in columns {
        let width = title(column).chars().count();
        line += &format!("{:>width$}", text(cost(column)));
    }
    line + "\n"
}

/// Each plan, and what a backend can make of the first.
pub fn of_bilinear(integral: &BilinearIntegral, graph: &Graph, module: &Module) -> String {
    let Some(chosen) = integral.candidates.first() else { return String::new() };
    let columns: Vec<Column> = chosen.costs.iter().map(|(element, points, _)| (*element, *points)).collect();
    let mut text = heading(&columns);
    for candidate in &integral.candidates {
        let Operations { point, test, trial, pair, finish } = candidate.operations;
        let costs = columns.iter().zip(&candidate.costs);
        let costs: Vec<(Column, usize)> = costs.map(|(column, (_, _, cost))| (*column, *cost)).collect();
        text += &row(candidate.name, Some([point, test, trial, pair, finish]), &columns, |wanted| {
            costs.iter().find(|(column, _)| column == wanted).map(|(_, cost)| *cost)
        });
    }
    if module.regions[integral.description.region].entity != Entity::Cells {
        return text;
    }
    let plan = &integral.plan;
    let (Some(tests), Some(trials)) =
        (ways::slots(graph, &plan.tests, Argument::Test), ways::slots(graph, &plan.trials, Argument::Trial))
    else {
        return text;
    };
    let entries = plan.block.iter().filter(|entry| !graph.is_zero(**entry)).count();
    let factors = plan.tests.iter().chain(&plan.trials);
    let constant = factors.into_iter().all(|factor| !graph.depends(*factor, varies_over_cell));
    text += &row("reference tensor", None, &columns, |(element, _)| {
        let applies = element.simplex && constant;
        let slots = [tests.len(), trials.len()];
        applies
            .then(|| ways::reference_tensor(&chosen.operations, slots, entries, element, integral.symmetric))
    });
    text += &row("sum factorisation", None, &columns, |(element, points)| {
        (!element.simplex).then(|| {
            ways::factorised_matrix(&chosen.operations, [&tests, &trials], entries, element, *points)
        })
    });
    text
}

/// Direct loops and sum factorisation.
pub fn of_linear(integral: &LinearIntegral, optimised: &Optimised, module: &Module) -> String {
    let Optimised { graph, fields, .. } = optimised;
    let FieldInfo { shape, .. } = &fields[integral.test.field];
    let components: usize = shape.iter().product();
    let entity = module.regions[integral.description.region].entity;
    let columns: Vec<Column> = elements(optimised.dimension)
        .map(|element| (element, element.points(&integral.description.degree, fields, entity)))
        .collect();
    let roots: Vec<_> = integral.flux.values().copied().collect();
    let mut code = Code::new(graph, &roots);
    for root in &roots {
        code.lower(*root);
    }
    // Each coefficient meets the weight once per point, and its derivative of the basis function once per node.
    let numbers = roots.iter().filter(|root| matches!(graph.node(**root), Node::Number(_))).count();
    let point = code.all_operations() + roots.len() - numbers;
    let test = roots.len();
    let mut text = heading(&columns);
    text += &row("direct loops", Some([point, test, 0, 0, 0]), &columns, |(element, points)| {
        Some(points * (point + element.nodes * test))
    });
    let slots = (0..components)
        .flat_map(|component| {
            of_component(&integral.flux, component).map(|(slot, _)| slot).collect::<Vec<_>>()
        })
        .collect::<crate::sorted::SortedSet<Derivative>>();
    let further = slots.iter().any(|slot| matches!(slot, Derivative::Second(..)) || slot.is_mean());
    if entity != Entity::Cells || further {
        return text;
    }
    text += &row("sum factorisation", None, &columns, |(element, points)| {
        let kinds = slots.len().max(1);
        (!element.simplex)
            .then(|| ways::factorised_vector([point, test / kinds], &slots, components, element, *points))
    });
    text
}
