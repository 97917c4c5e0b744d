//! The equations of one function: what it is, its derivatives, and what the names in them stand for.

use super::formula::{Formula, Measure};
use super::outlines::{Outlines, Varied, direction_name};
use super::read::{Reader, symbol};
use super::simplify::Simplifier;
use crate::check::{CheckedFunction, Content, Term, outline};
use crate::parse::syntax::{Entity, Module};
use crate::tensor::{Arena, FieldInfo, FieldRole, Named, Operator, Tensor, Variable};

/// left = right.
pub struct Equation {
    pub left: Formula,
    pub right: Formula,
}

/// A function as mathematics.
pub struct Shown {
    /// The function itself.
    pub content: Equation,
    /// First variation of an energy, tangents, each with what it is.
    pub derivatives: Vec<(String, Equation)>,
    /// What the names stand for, in the order of their use.
    pub definitions: Vec<Equation>,
    /// Members of the data struct that stand anywhere, by index.
    pub members: Vec<usize>,
    /// Regions of the integrals, by index.
    pub regions: Vec<usize>,
}

/// A function's integrals and their derivatives.
pub struct Variations {
    pub arena: Arena,
    /// As outlined, then directions in the order of their use.
    pub fields: Vec<FieldInfo>,
    pub own: Vec<Term>,
    pub derivatives: Vec<Variation>,
}

/// A derivative of integrals.
pub struct Variation {
    pub name: String,
    pub order: usize,
    /// The unknown that varied last, if there are several.
    pub by: Option<usize>,
    /// Fields.
    pub directions: Vec<usize>,
    pub terms: Vec<Term>,
}

/// The first variation of an energy, and the tangents by each unknown. `None` for a value, or after a mistake.
pub fn variations(outlines: &mut Outlines, function: usize) -> Option<Variations> {
    let CheckedFunction { mut arena, mut fields, content, .. } =
        outline(outlines.module, function, outlines.dimension)?;
    let (terms, energy, form) = match content {
        Content::Form(terms) => (terms, false, true),
        Content::Functional(terms) => (terms, false, false),
        Content::Energy(terms) => (terms, true, true),
        Content::Value(_) => return None,
    };
    let mut own = Vec::new();
    for term in terms {
        let density = outlines.carry_out(&mut arena, term.density, &fields)?;
        own.push(Term { region: term.region, density });
    }
    own.retain(|term| !arena.is_zero(term.density));
    let unknowns: Vec<usize> =
        (0..fields.len()).filter(|field| matches!(fields[*field].role, FieldRole::Unknown(_))).collect();
    let mut residual = own.clone();
    let mut derivatives = Vec::new();
    let mut tests = Vec::new();
    if energy && !unknowns.is_empty() {
        residual = Vec::new();
        for &unknown in &unknowns {
            let (part, test) = vary(outlines, &mut arena, &mut fields, &own, unknown, 1)?;
            residual.extend(part);
            tests.push(test);
        }
        let name = "first variation".to_string();
        derivatives.push(Variation {
            name,
            order: 1,
            by: None,
            directions: tests.clone(),
            terms: residual.clone(),
        });
    }
    for &unknown in unknowns.iter().filter(|_| form) {
        let order = if energy { 2 } else { 1 };
        let (terms, direction) = vary(outlines, &mut arena, &mut fields, &residual, unknown, order)?;
        let by = (unknowns.len() > 1).then_some(unknown);
        let directions = [&tests[..], &[direction]].concat();
        derivatives.push(Variation { name: "tangent".into(), order, by, directions, terms });
    }
    Some(Variations { arena, fields, own, derivatives })
}

/// The equations of a function. `None` if it has a mistake.
pub fn show(outlines: &mut Outlines, function: usize) -> Option<Shown> {
    if outlines.gives_value(function) {
        return show_value(outlines, function);
    }
    let Variations { arena, fields, own, derivatives } = variations(outlines, function)?;
    let reader =
        Reader { module: outlines.module, arena: &arena, fields: &fields, dimension: outlines.dimension };
    let arguments = outlines.module.functions[function].arguments.len();
    let call = |head: Formula| Formula::call(head, (0..arguments).map(|field| reader.field(field)).collect());
    let mut roots: Vec<Tensor> = own.iter().map(|term| term.density).collect();
    let content = Equation { left: call(reader.function(function)), right: integrals(&reader, &own) };
    let mut shown = Vec::new();
    for Variation { name, order, by, directions, terms } in derivatives {
        let by = by.map(|unknown| Box::new(reader.field(unknown)));
        let head = call(Formula::Derivative { order, by, of: Box::new(reader.function(function)) });
        // All unknowns vary together at first, one of them after that.
        let mut directions: Vec<_> = directions.into_iter().map(|field| reader.field(field)).collect();
        let first = directions.len() + 1 - order;
        if first > 1 {
            let together = directions.drain(..first).collect();
            directions.insert(0, Formula::Tuple(together));
        }
        let left = Formula::Directions(Box::new(head), directions);
        shown.push((name, Equation { left, right: integrals(&reader, &terms) }));
        roots.extend(terms.iter().map(|term| term.density));
    }
    let mut regions: Vec<usize> = own.iter().map(|term| term.region).collect();
    regions.sort_unstable();
    regions.dedup();
    let shown = complete(outlines, content, shown, &arena, &fields, &roots);
    Some(Shown { regions, ..shown })
}

/// A function of position.
fn show_value(outlines: &mut Outlines, function: usize) -> Option<Shown> {
    let CheckedFunction { mut arena, fields, content, .. } =
        outline(outlines.module, function, outlines.dimension)?;
    let Content::Value(value) = content else { return None };
    let value = outlines.carry_out(&mut arena, value, &fields)?;
    let reader =
        Reader { module: outlines.module, arena: &arena, fields: &fields, dimension: outlines.dimension };
    let arguments = 0..outlines.module.functions[function].arguments.len();
    let left = reader.called(reader.function(function), arguments.map(|field| reader.field(field)).collect());
    let content = Equation { left, right: reader.read(value) };
    Some(complete(outlines, content, vec![], &arena, &fields, &[value]))
}

/// The derivative of integrals by an unknown; with the field of its direction.
fn vary(
    outlines: &mut Outlines,
    arena: &mut Arena,
    fields: &mut Vec<FieldInfo>,
    terms: &[Term],
    unknown: usize,
    order: usize,
) -> Option<(Vec<Term>, usize)> {
    let (name, shape) = (direction_name(&fields[unknown].name, order), fields[unknown].shape.clone());
    let role = FieldRole::State;
    fields.push(FieldInfo { name, role, shape: shape.clone() });
    let field = fields.len() - 1;
    let mut varied = Vec::new();
    for term in terms {
        let place = arena.place(term.density);
        let direction = arena.push(Operator::Field { field, order: 0 }, shape.clone(), place);
        let variable = Variable::Field(unknown);
        let operator = Operator::Gateaux { expression: term.density, variable, direction };
        let density = arena.push(operator, vec![], place);
        let density = outlines.carry_out(arena, density, fields)?;
        let density = Simplifier::new(outlines, arena, fields).simplify(density);
        if !arena.is_zero(density) {
            varied.push(Term { region: term.region, density });
        }
    }
    Some((varied, field))
}

/// ∫ … + ∫ …, with the signs of the densities before the integrals.
fn integrals(reader: &Reader, terms: &[Term]) -> Formula {
    let mut sum: Option<Formula> = None;
    for term in terms {
        let region = &reader.module.regions[term.region];
        let measure = match region.entity {
            Entity::Cells => Measure::Dx,
            Entity::Facets => Measure::Ds,
            Entity::InteriorFacets => Measure::InteriorDs,
        };
        let (minus, density) = match reader.read(term.density) {
            Formula::Sum(mut terms) if terms.len() == 1 && terms[0].0 => (true, terms.remove(0).1),
            density => (false, density),
        };
        let region = symbol(&region.name, &region.attributes);
        let integral = Formula::Integral { region, density: Box::new(density), measure };
        sum = Some(match (sum, minus) {
            (Some(sum), minus) => sum.plus(minus, integral),
            (None, true) => integral.negative(),
            (None, false) => integral,
        });
    }
    sum.unwrap_or(Formula::Number(0.0))
}

/// Adds what the names stand for.
fn complete(
    outlines: &mut Outlines,
    content: Equation,
    derivatives: Vec<(String, Equation)>,
    arena: &Arena,
    fields: &[FieldInfo],
    roots: &[Tensor],
) -> Shown {
    let mut shown = Shown { content, derivatives, definitions: vec![], members: vec![], regions: vec![] };
    let mut listed: Vec<(usize, Varied)> = Vec::new();
    list(outlines, arena, fields, roots, &mut shown, &mut listed);
    shown.members.sort_unstable();
    shown
}

/// Lists the names of some expressions, and of what these stand for.
fn list(
    outlines: &mut Outlines,
    arena: &Arena,
    fields: &[FieldInfo],
    roots: &[Tensor],
    shown: &mut Shown,
    listed: &mut Vec<(usize, Varied)>,
) {
    let module: &Module = outlines.module;
    let reader = Reader { module, arena, fields, dimension: outlines.dimension };
    let given = |name: &str| {
        let mut members = module.data.iter().flat_map(|data| &data.members);
        members.position(|member| member.name == name)
    };
    for node in arena.reachable(roots) {
        let member = match &arena.node(node).operator {
            Operator::Parameter(index) => Some(*index),
            Operator::Field { field, .. } if fields[*field].role.is_data() => given(&fields[*field].name),
            Operator::Named(Named::Value { name, value }) if name != "D" && name != "PI" => {
                let equation = Equation { left: reader.read(node), right: reader.read(*value) };
                if !shown
                    .definitions
                    .iter()
                    .any(|other| other.left == equation.left && other.right == equation.right)
                {
                    shown.definitions.push(equation);
                }
                None
            }
            _ => None,
        };
        if let Some(member) = member.filter(|member| !shown.members.contains(member)) {
            shown.members.push(member);
        }
    }
    for (function, varied) in reader.calls(roots) {
        // A derivative is told after what it is the derivative of.
        for order in 0..=varied.len() {
            let key = (function, varied[..order].to_vec());
            if listed.contains(&key) || (order > 0 && order < varied.len()) {
                continue;
            }
            let Some(definition) = outlines.definition(key.0, &key.1) else { continue };
            listed.push(key);
            let Some(value) = definition.value else { continue };
            let reader = Reader {
                module,
                arena: &definition.arena,
                fields: &definition.fields,
                dimension: outlines.dimension,
            };
            let arguments = module.functions[function].arguments.len();
            let names = (0..arguments).map(|field| reader.field(field)).collect();
            let head = reader.function(function);
            let left = match order {
                0 => reader.called(head, names),
                _ => {
                    let head = Formula::Derivative { order, by: None, of: Box::new(head) };
                    let rows = definition.directions.iter().map(|row| {
                        let entry = |field: &Option<usize>| match field {
                            Some(field) => reader.field(*field),
                            None => Formula::Number(0.0),
                        };
                        let mut row: Vec<_> = row.iter().map(entry).collect();
                        if row.len() == 1 { row.remove(0) } else { Formula::Tuple(row) }
                    });
                    Formula::Directions(Box::new(Formula::call(head, names)), rows.collect())
                }
            };
            shown.definitions.push(Equation { left, right: reader.read(value) });
            list(outlines, &definition.arena, &definition.fields, &[value], shown, listed);
        }
    }
}
