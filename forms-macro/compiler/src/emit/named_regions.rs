//! The regions that a function's text integrates over.

use crate::check::builtins::nearest;
use crate::parse::syntax::*;
use crate::sorted::SortedSet;

/// Indices of the regions that a function's integrals name, and those of the functions that it calls, in the order of
/// their declaration: what its constructor asks for. A region stays whose integral turns out to be zero.
pub fn regions_named(module: &Module, function: &Function) -> Vec<usize> {
    let names = names(module, function);
    (0..module.regions.len())
        .filter(|index| names.contains(&module.regions[*index].name.to_string()))
        .collect()
}

/// Most likely number of regions that a function with a mistake was meant to integrate over: a misspelt name counts as the
/// nearest one, or as one more.
pub fn likely_regions(module: &Module, function: &Function) -> usize {
    names(module, function).len()
}

fn names(module: &Module, function: &Function) -> SortedSet<String> {
    let mut found = SortedSet::new();
    match &function.body {
        _ if matches!(function.output, Output::Value(_)) => {}
        Some(body) => regions_of_block(module, body, &mut SortedSet::new(), &mut found),
        None => found.extend(module.regions.iter().map(|region| region.name.to_string())),
    }
    found
}

fn regions_of_block(
    module: &Module,
    block: &Block,
    seen: &mut SortedSet<String>,
    found: &mut SortedSet<String>,
) {
    let lets = block.lets.iter().map(|(_, expression)| expression);
    for expression in lets.chain([&*block.result]) {
        regions_of(module, expression, seen, found);
    }
}

/// The regions named by the integrals of an expression and of the functions that it calls; a name that is
/// not declared counts as the nearest one, or as itself.
fn regions_of(
    module: &Module,
    expression: &Expression,
    seen: &mut SortedSet<String>,
    found: &mut SortedSet<String>,
) {
    let declared = || module.regions.iter().map(|region| region.name.to_string());
    match &expression.kind {
        ExpressionKind::Call(name, arguments) if name == "integral" || name == "means" => {
            let names: Vec<String> = declared().collect();
            let region = arguments.iter().find_map(|argument| match &argument.kind {
                ExpressionKind::Name(name) | ExpressionKind::Call(name, _)
                    if name.to_string().starts_with(char::is_uppercase) =>
                {
                    let name = name.to_string();
                    let near = nearest(&name, names.iter().map(String::as_str)).map(str::to_string);
                    Some(if names.contains(&name) { name } else { near.unwrap_or(name) })
                }
                _ => None,
            });
            found.extend(region.or_else(|| declared().next()));
        }
        ExpressionKind::Call(name, arguments) => {
            for argument in arguments {
                regions_of(module, argument, seen, found);
            }
            let called = module.functions.iter().find(|function| function.name == *name);
            if let Some(body) = called.and_then(|function| function.body.as_ref())
                && seen.insert(name.to_string())
            {
                regions_of_block(module, body, seen, found);
            }
        }
        ExpressionKind::Negate(a)
        | ExpressionKind::Index(a, _)
        | ExpressionKind::Declared(_, a)
        | ExpressionKind::Repeat(a, ..) => regions_of(module, a, seen, found),
        ExpressionKind::Binary(_, a, b) => {
            regions_of(module, a, seen, found);
            regions_of(module, b, seen, found);
        }
        ExpressionKind::Block(block) => regions_of_block(module, block, seen, found),
        ExpressionKind::If(_, a, b) => {
            regions_of_block(module, a, seen, found);
            regions_of_block(module, b, seen, found);
        }
        ExpressionKind::Array(_)
        | ExpressionKind::Number(_)
        | ExpressionKind::Name(_)
        | ExpressionKind::Mistake => {}
    }
}
