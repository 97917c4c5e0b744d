//! The equations of one function: what it is, its derivatives, and the meaning of the names in them.

use super::formula::{Formula, Measure};
use super::names::{MOST_DIFFERENTIATED, MOST_SHOWN, Namer, Names, ellipsis};
use super::outlines::simplify::Simplifier;
use super::outlines::{Outlines, direction_name};
use super::read::{Reader, Varied, symbol};
use crate::check::{CheckedFunction, Content, Term, outline};
use crate::parse::syntax::{Entity, Function, Module};
use crate::tensor::{Arena, FieldInfo, FieldRole, Named, Operator, Tensor, Variable};

/// left = right.
pub struct Equation {
    pub left: Formula,
    pub right: Formula,
}

impl Equation {
    /// Does it replace equations that were left out?
    pub fn is_ellipsis(&self) -> bool {
        self.left == ellipsis()
    }
}

/// A function as mathematics.
pub struct Shown {
    /// The function itself.
    pub content: Equation,
    /// First variation of an energy, tangents, each with what it is.
    pub derivatives: Vec<(String, Equation)>,
    /// Definitions of the names, in the order of their use.
    pub definitions: Vec<Equation>,
    /// Members of the data struct that occur anywhere, by index.
    pub members: Vec<usize>,
    /// Regions of the integrals, by index.
    pub regions: Vec<usize>,
    /// Parts of all equations so far.
    size: usize,
}

impl Shown {
    fn new(content: Equation) -> Self {
        let size = content.right.size();
        Shown { content, derivatives: vec![], definitions: vec![], members: vec![], regions: vec![], size }
    }

    /// Adds the meaning of a name, as long as there is room.
    fn define(&mut self, equation: Equation) {
        if self.definitions.last().is_some_and(Equation::is_ellipsis) {
            return;
        }
        self.size += equation.right.size();
        match self.is_full() {
            true => self.definitions.push(Equation { left: ellipsis(), right: ellipsis() }),
            false => self.definitions.push(equation),
        }
    }

    fn is_full(&self) -> bool {
        self.size > MOST_SHOWN
    }
}

/// A function whose formula is too large to be shown.
pub fn left_out(outlines: &Outlines, function: usize) -> Shown {
    let Function { name, attributes, .. } = &outlines.module.functions[function];
    let left = Formula::Symbol(symbol(name, attributes));
    Shown::new(Equation { left, right: ellipsis() })
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
    /// Too large to be shown: there are no terms.
    pub left_out: bool,
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
        own.push(term.with(density));
    }
    own.retain(|term| !arena.is_zero(term.density));
    let unknowns: Vec<usize> =
        (0..fields.len()).filter(|field| matches!(fields[*field].role, FieldRole::Unknown(_))).collect();
    let mut residual = own.clone();
    let mut derivatives = Vec::new();
    let mut tests = Vec::new();
    let mut large = false;
    if energy && !unknowns.is_empty() {
        residual = Vec::new();
        for &unknown in &unknowns {
            let (part, test) = vary(outlines, &mut arena, &mut fields, &own, unknown, 1)?;
            large |= part.is_none();
            residual.extend(part.unwrap_or_default());
            tests.push(test);
        }
        let name = "first variation".to_string();
        derivatives.push(Variation {
            name,
            order: 1,
            by: None,
            directions: tests.clone(),
            terms: residual.clone(),
            left_out: large,
        });
    }
    for &unknown in unknowns.iter().filter(|_| form) {
        let order = if energy { 2 } else { 1 };
        let (terms, direction) = vary(outlines, &mut arena, &mut fields, &residual, unknown, order)?;
        let by = (unknowns.len() > 1).then_some(unknown);
        let directions = [&tests[..], &[direction]].concat();
        let left_out = large || terms.is_none();
        let terms = terms.unwrap_or_default();
        derivatives.push(Variation { name: "tangent".into(), order, by, directions, terms, left_out });
    }
    Some(Variations { arena, fields, own, derivatives })
}

/// The equations of a function. `None` if it has a mistake.
pub fn show(outlines: &mut Outlines, function: usize) -> Option<Shown> {
    if outlines.gives_value(function) {
        return show_value(outlines, function);
    }
    let Variations { arena, fields, own, derivatives } = variations(outlines, function)?;
    let mut roots: Vec<Tensor> = own.iter().map(|term| term.density).collect();
    roots.extend(derivatives.iter().flat_map(|one| &one.terms).map(|term| term.density));
    let mut namer = Namer::new(outlines.module, &fields, &arena);
    let names = namer.names(&arena, &roots);
    let reader = outlines.reader(&arena, &fields, &names);
    let arguments = outlines.module.functions[function].arguments.len();
    let call = |head: Formula| Formula::call(head, (0..arguments).map(|field| reader.field(field)).collect());
    let content = Equation { left: call(reader.function(function)), right: integrals(&reader, &own) };
    let mut shown = Vec::new();
    for Variation { name, order, by, directions, terms, left_out } in derivatives {
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
        let right = if left_out { ellipsis() } else { integrals(&reader, &terms) };
        shown.push((name, Equation { left, right }));
    }
    let mut regions: Vec<usize> = own.iter().map(|term| term.region).collect();
    regions.sort_unstable();
    regions.dedup();
    let mut whole = Shown { regions, ..Shown::new(content) };
    whole.size += shown.iter().map(|(_, equation)| equation.right.size()).sum::<usize>();
    whole.derivatives = shown;
    list(outlines, &mut namer, (&arena, &fields, &names), &roots, &mut whole, &mut vec![]);
    whole.members.sort_unstable();
    Some(whole)
}

/// A function of position.
fn show_value(outlines: &mut Outlines, function: usize) -> Option<Shown> {
    let CheckedFunction { mut arena, fields, content, .. } =
        outline(outlines.module, function, outlines.dimension)?;
    let Content::Value(value) = content else { return None };
    let value = outlines.carry_out(&mut arena, value, &fields)?;
    let mut namer = Namer::new(outlines.module, &fields, &arena);
    let names = namer.names(&arena, &[value]);
    let reader = outlines.reader(&arena, &fields, &names);
    let arguments = 0..outlines.module.functions[function].arguments.len();
    let left = reader.called(reader.function(function), arguments.map(|field| reader.field(field)).collect());
    let mut whole = Shown::new(Equation { left, right: reader.read(value) });
    list(outlines, &mut namer, (&arena, &fields, &names), &[value], &mut whole, &mut vec![]);
    whole.members.sort_unstable();
    Some(whole)
}

/// The derivative of integrals by an unknown, `None` if they are too large; with the field of its direction.
fn vary(
    outlines: &mut Outlines,
    arena: &mut Arena,
    fields: &mut Vec<FieldInfo>,
    terms: &[Term],
    unknown: usize,
    order: usize,
) -> Option<(Option<Vec<Term>>, usize)> {
    let (name, shape) = (direction_name(&fields[unknown].name, order), fields[unknown].shape.clone());
    let role = FieldRole::State;
    fields.push(FieldInfo { name, role, shape: shape.clone() });
    let field = fields.len() - 1;
    let mut varied = Vec::new();
    for term in terms {
        // A pair that slides moves inside of named functions, too, where their arguments do not show it.
        if term.displacement.is_some() || arena.reachable(&[term.density]).len() > MOST_DIFFERENTIATED {
            return Some((None, field));
        }
        let span = arena.span(term.density);
        let direction = arena.push(Operator::Field { field, order: 0 }, shape.clone(), span);
        let variable = Variable::Field(unknown);
        let operator = Operator::Gateaux { expression: term.density, variable, direction };
        let density = arena.push(operator, vec![], span);
        let density = outlines.carry_out(arena, density, fields)?;
        let density = Simplifier::new(outlines, arena, fields).simplify(density);
        if !arena.is_zero(density) {
            varied.push(term.with(density));
        }
    }
    Some((Some(varied), field))
}

/// ∫ … + ∫ …, with the signs of the densities before the integrals.
fn integrals(reader: &Reader, terms: &[Term]) -> Formula {
    let mut sum: Option<Formula> = None;
    let mut size = 0;
    for term in terms {
        if size > MOST_SHOWN {
            return sum.unwrap_or_else(ellipsis).plus(false, ellipsis());
        }
        let region = &reader.module.regions[term.region];
        let measure = match region.entity {
            Entity::Cells => Measure::Dx,
            Entity::Facets | Entity::Pairs | Entity::Interface => Measure::Ds,
            Entity::InteriorFacets => Measure::InteriorDs,
        };
        let (minus, density) = match reader.read(term.density) {
            Formula::Sum(mut terms) if terms.len() == 1 && terms[0].0 => (true, terms.remove(0).1),
            density => (false, density),
        };
        let region = symbol(&region.name, &region.attributes);
        size += density.size();
        let integral = Formula::Integral { region, density: Box::new(density), measure };
        sum = Some(match (sum, minus) {
            (Some(sum), minus) => sum.plus(minus, integral),
            (None, true) => integral.negative(),
            (None, false) => integral,
        });
    }
    sum.unwrap_or(Formula::Number(0.0))
}

/// Lists the names of some expressions, and of their meanings.
fn list(
    outlines: &mut Outlines,
    namer: &mut Namer,
    (arena, fields, names): (&Arena, &[FieldInfo], &Names),
    roots: &[Tensor],
    shown: &mut Shown,
    listed: &mut Vec<(usize, Varied)>,
) {
    let module: &Module = outlines.module;
    let reader = outlines.reader(arena, fields, names);
    let given = |name: &str| {
        let mut members = module.members();
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
                    shown.define(equation);
                }
                None
            }
            _ => None,
        };
        if let Some(member) = member.filter(|member| !shown.members.contains(member)) {
            shown.members.push(member);
        }
    }
    let mut last = names.last_used(None);
    while let Some(node) = last {
        shown.define(Equation { left: Formula::name(names.name(node)), right: reader.read_node(node) });
        last = names.last_used(Some(node));
    }
    for (function, varied) in reader.calls(roots) {
        if shown.is_full() {
            break;
        }
        // A derivative follows what it is the derivative of.
        for order in 0..=varied.len() {
            let key = (function, varied[..order].to_vec());
            if listed.contains(&key) || (order > 0 && order < varied.len()) {
                continue;
            }
            let Some(definition) = outlines.definition(key.0, &key.1) else { continue };
            listed.push(key);
            let Some(value) = definition.value else { continue };
            let names = namer.names(&definition.arena, &[value]);
            let reader = outlines.reader(&definition.arena, &definition.fields, &names);
            let arguments = module.functions[function].arguments.len();
            let letters = (0..arguments).map(|field| reader.field(field)).collect();
            let head = reader.function(function);
            let left = match order {
                0 => reader.called(head, letters),
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
                    Formula::Directions(Box::new(Formula::call(head, letters)), rows.collect())
                }
            };
            shown.define(Equation { left, right: reader.read(value) });
            let inside = (&definition.arena, &definition.fields[..], &names);
            list(outlines, namer, inside, &[value], shown, listed);
        }
    }
}
