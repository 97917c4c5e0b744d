//! Stage 3: [`CheckedFunction`] → [`Derived`]: the operators of differentiation are carried out, and
//! residuals and tangents are derived. Nothing of a [`Derived`] holds `Gradient`, `Partial` or `Gateaux`.

pub mod rules;
mod sources;

use std::collections::{HashMap, HashSet};

use crate::check::regions::{check_existence, check_sides};
use crate::check::{CheckedFunction, Content, Term};
use crate::diagnostics::Diagnostics;
use crate::parse::syntax::Region;
use crate::tensor::{Arena, FieldInfo, FieldRole, Geometry, Operator, Tensor, Variable};
use rules::{Differentiation, Seed};
pub use sources::Source;

/// A function, free of derivatives still to be taken.
pub struct Derived {
    pub function: usize,
    pub dimension: usize,
    pub arena: Arena,
    /// As checked, then (energies) a test function per unknown, then a trial function per unknown.
    pub fields: Vec<FieldInfo>,
    /// Additive parts of the residual, with their tangents. Empty for functionals and values.
    pub residual: Vec<ResidualPart>,
    /// Densities of an energy or functional.
    pub density: Vec<Term>,
    /// By density, or part of one, that was asked for as a derivative: the integrands that were differentiated.
    pub sources: HashMap<Tensor, Vec<Source>>,
    /// A derived field.
    pub value: Option<Tensor>,
    /// The residual is the first variation of an energy: its tangent is symmetric (Schwarz).
    pub from_energy: bool,
}

/// One additive part of a residual's density on a region.
pub struct ResidualPart {
    pub term: Term,
    /// Its derivative in the direction of each trial function (field index), where not zero.
    pub tangent: Vec<(usize, Tensor)>,
}

/// Carries out all derivatives of a function.
pub fn differentiate(checked: CheckedFunction, regions: &[Region], diagnostics: &mut Diagnostics) -> Derived {
    let CheckedFunction { function, dimension, arena, mut fields, content } = checked;
    let names = arena.varied_nodes();
    let known = HashMap::new();
    let declared = fields.clone();
    let mut lowering =
        Lowering { arena, dimension, fields: declared, known, names, exhausted: false, diagnostics };
    let unknowns: Vec<(usize, usize)> = fields
        .iter()
        .enumerate()
        .filter_map(|(index, field)| match field.role {
            FieldRole::Unknown(number) => Some((index, number)),
            _ => None,
        })
        .collect();
    let mut density = Vec::new();
    let mut value = None;
    let mut from_energy = false;
    let mut terms = Vec::new();
    match content {
        Content::Form(form) => {
            terms = form;
            lowering.check_regions(&terms, &fields, regions);
        }
        Content::Functional(functional) => {
            density = functional;
            lowering.check_regions(&density, &fields, regions);
        }
        Content::Value(tensor) => {
            let lowered = lowering.lower(tensor);
            if lowering.has_sides(lowered) {
                check_sides(&lowering.arena, &fields, lowered, None, lowering.diagnostics);
            }
            value = Some(lowered);
        }
        Content::Energy(energy) => {
            lowering.check_regions(&energy, &fields, regions);
            from_energy = true;
            for &(index, number) in &unknowns {
                let name = format!("δ{}", fields[index].name);
                let shape = fields[index].shape.clone();
                fields.push(FieldInfo { name, role: FieldRole::Test(number), shape });
                let test = fields.len() - 1;
                let varied =
                    energy.iter().map(|term| term.with(lowering.gateaux(term.density, index, test, &fields)));
                terms.extend(varied);
            }
            density = energy;
        }
    }
    let mut trials = Vec::new();
    for (index, number) in unknowns {
        let name = format!("d{}", fields[index].name);
        let shape = fields[index].shape.clone();
        fields.push(FieldInfo { name, role: FieldRole::Trial(number), shape });
        trials.push((index, fields.len() - 1));
    }
    let (mut residual, mut sources) = (Vec::new(), HashMap::<Tensor, Vec<Source>>::new());
    for term in terms {
        let found = if from_energy { vec![] } else { lowering.sources(term.density) };
        let lowered = lowering.lower(term.density);
        for part in lowering.parts(lowered) {
            let mut tangent = Vec::new();
            for &(unknown, trial) in &trials {
                let gateaux = lowering.gateaux(part, unknown, trial, &fields);
                let derivative = lowering.lower(gateaux);
                if !lowering.arena.is_zero(derivative) {
                    tangent.push((trial, derivative));
                }
            }
            if !found.is_empty() {
                sources.entry(part).or_default().extend(found.iter().cloned());
            }
            residual.push(ResidualPart { term: term.with(part), tangent });
        }
    }
    let density = density
        .into_iter()
        .map(|term| {
            let found = lowering.sources(term.density);
            let density = lowering.lower(term.density);
            if !found.is_empty() {
                sources.entry(density).or_default().extend(found);
            }
            term.with(density)
        })
        .collect();
    let arena = lowering.arena;
    Derived { function, dimension, arena, fields, residual, density, sources, value, from_energy }
}

/// Removes the operators of differentiation, innermost first.
struct Lowering<'a> {
    arena: Arena,
    dimension: usize,
    /// As checked.
    fields: Vec<FieldInfo>,
    known: HashMap<Tensor, Tensor>,
    /// The variable of `diff(e, w)`.
    names: HashSet<Tensor>,
    /// Too large to go on, which has been reported.
    exhausted: bool,
    diagnostics: &'a mut Diagnostics,
}

/// More nodes than the derivatives of any form have.
const MOST_NODES: usize = 1_000_000;

impl Lowering<'_> {
    /// Reports what does not exist where it is integrated. Derivatives that were asked for may have brought
    /// it there, so they are carried out first.
    fn check_regions(&mut self, terms: &[Term], fields: &[FieldInfo], regions: &[Region]) {
        for term in terms {
            let (density, region) = (self.lower(term.density), &regions[term.region]);
            let is_test = |field: &&usize| matches!(fields[**field].role, FieldRole::Test(_));
            if let Some(test) = term.displacement.iter().flatten().find(is_test) {
                let message =
                    format!("`{}` is a test function, and displaces no surfaces", fields[*test].name);
                let help = "contact pairs are displaced by unknowns, states or data";
                self.diagnostics.error_with_help(self.arena.span(term.density), message, help);
            }
            check_existence(&self.arena, density, region, self.diagnostics);
            if region.entity.is_two_sided() {
                check_sides(&self.arena, fields, density, Some(region), self.diagnostics);
            }
        }
    }

    /// Does it hold a limit from one side of a facet?
    fn has_sides(&self, tensor: Tensor) -> bool {
        use Operator::{Opposite, Restrict};
        let restricted =
            |node: &Tensor| matches!(self.arena.node(*node).operator, Restrict(..) | Opposite(..));
        self.arena.reachable(&[tensor]).iter().any(restricted)
    }

    /// The node of a derivative in the direction of another field.
    fn gateaux(
        &mut self,
        expression: Tensor,
        field: usize,
        direction: usize,
        fields: &[FieldInfo],
    ) -> Tensor {
        let span = self.arena.span(expression);
        let operator = Operator::Field { field: direction, order: 0 };
        let direction = self.arena.push(operator, fields[direction].shape.clone(), span);
        let shape = self.arena.shape(expression).to_vec();
        let operator = Operator::Gateaux { expression, variable: Variable::Field(field), direction };
        self.arena.push(operator, shape, span)
    }

    /// The same expression without operators of differentiation. A node without any keeps its identity,
    /// on which `diff(e, w)` by a `let` name relies.
    fn lower(&mut self, tensor: Tensor) -> Tensor {
        if let Some(known) = self.known.get(&tensor) {
            return *known;
        }
        let node = self.arena.node(tensor).clone();
        let span = node.span;
        let lowered = match node.operator {
            Operator::Gateaux { expression, variable, direction } => {
                let expression = self.lower(expression);
                let direction = self.lower(direction);
                let variable = self.lower_variable(variable);
                let seed = Seed::Toward { variable, direction, with_gradient: true };
                self.derive(expression, seed)
                    .unwrap_or_else(|| self.arena.push(Operator::Zero, node.shape, span))
            }
            Operator::Gradient(expression) => {
                let expression = self.lower(expression);
                if let Operator::Field { field, order: order @ (0 | 1) } =
                    self.arena.node(expression).operator
                {
                    let operator = Operator::Field { field, order: order + 1 };
                    self.arena.push(operator, node.shape, span)
                } else {
                    let directions: Vec<_> =
                        (0..self.dimension).map(|axis| self.derive(expression, Seed::Along(axis))).collect();
                    self.with_trailing_axes(expression, &directions, &[self.dimension])
                }
            }
            Operator::Partial(expression, variable) => {
                let expression = self.lower(expression);
                let variable = self.lower_variable(variable);
                let shape = node.shape[self.arena.shape(expression).len()..].to_vec();
                let count: usize = shape.iter().product();
                let mut directions = Vec::new();
                for entry in 0..count {
                    let direction = self.unit(&shape, entry, tensor);
                    let seed = Seed::Toward { variable, direction, with_gradient: false };
                    directions.push(self.derive(expression, seed));
                }
                self.with_trailing_axes(expression, &directions, &shape)
            }
            operator => {
                let mut changed = false;
                let mut change = |operand: Tensor| {
                    let new = self.lower(operand);
                    changed |= new != operand;
                    new
                };
                let operator = map_operands(&operator, &mut change);
                if changed { self.arena.push(operator, node.shape, span) } else { tensor }
            }
        };
        let lowered = self.apart(tensor, lowered);
        self.known.insert(tensor, lowered);
        lowered
    }

    /// A derivative may be a node that stands elsewhere, too (`derivative(u, u, v)` is `v`). A name for it that is
    /// differentiated by varies alone: it becomes a node of its own.
    fn apart(&mut self, tensor: Tensor, lowered: Tensor) -> Tensor {
        if lowered == tensor || !self.names.contains(&tensor) {
            return lowered;
        }
        let node = self.arena.node(lowered).clone();
        self.arena.push(node.operator, node.shape, node.span)
    }

    fn lower_variable(&mut self, variable: Variable) -> Variable {
        match variable {
            Variable::Node(node) => Variable::Node(self.lower(node)),
            other => other,
        }
    }

    fn derive(&mut self, expression: Tensor, seed: Seed) -> Option<Tensor> {
        if self.arena.len() > MOST_NODES {
            if !std::mem::replace(&mut self.exhausted, true) {
                let message = "the derivatives of this unfold to more than a million operations";
                let help = "differentiate fewer times, or by tensors of lower rank";
                self.diagnostics.error_with_help(self.arena.span(expression), message, help);
            }
            return None;
        }
        let mut directions = Vec::new();
        if let Seed::Toward { direction, with_gradient, .. } = seed {
            directions.push(direction);
            let highest = if with_gradient { self.highest_order(expression, seed) } else { 0 };
            for order in 1..=highest {
                let last = directions[order - 1];
                let shape = [self.arena.shape(last), &[self.dimension]].concat();
                let span = self.arena.span(last);
                let gradient = self.arena.push(Operator::Gradient(last), shape, span);
                directions.push(self.lower(gradient));
            }
        }
        let (arena, fields) = (&mut self.arena, &self.fields);
        Differentiation::new(arena, self.dimension, seed, directions, fields, self.diagnostics)
            .derive_with_measure(expression)
    }

    /// The highest derivative of the direction that the derivative of the expression reads.
    fn highest_order(&self, expression: Tensor, seed: Seed) -> usize {
        let Seed::Toward { variable, .. } = seed else { return 0 };
        let orders = self.arena.reachable(&[expression]).into_iter().filter_map(|node| {
            match (&self.arena.node(node).operator, variable) {
                (Operator::Field { field, order }, Variable::Field(varied)) if *field == varied => {
                    Some(*order)
                }
                (Operator::Field { field, order }, Variable::Shape(_)) => {
                    let fixed = self.fields.get(*field).is_some_and(|field| field.role == FieldRole::Given);
                    Some(if fixed { 0 } else { *order })
                }
                (Operator::Geometry(Geometry::Normal), Variable::Shape(_)) => Some(1),
                (Operator::Opposite(..) | Operator::Sliding(..), Variable::Field(_) | Variable::Shape(_)) => {
                    Some(1)
                }
                _ => None,
            }
        });
        let of_measure = usize::from(matches!(variable, Variable::Shape(Some(_))));
        orders.max().unwrap_or(0).max(of_measure)
    }

    /// The unit tensor of a shape whose `entry`-th component (row-major) is one.
    fn unit(&mut self, shape: &[usize], entry: usize, origin: Tensor) -> Tensor {
        let span = self.arena.span(origin);
        let Some((first, rest)) = shape.split_first() else {
            return self.arena.share(Operator::Number(1.0), vec![], span);
        };
        let stride: usize = rest.iter().product();
        let mut rows = Vec::new();
        for row in 0..*first {
            rows.push(if entry / stride == row {
                self.unit(rest, entry % stride, origin)
            } else {
                self.arena.share(Operator::Zero, rest.to_vec(), span)
            });
        }
        self.arena.share(Operator::Stack(rows), shape.to_vec(), span)
    }

    /// From one tensor like `model` per index of the trailing axes to one tensor with those axes.
    fn with_trailing_axes(
        &mut self,
        model: Tensor,
        directions: &[Option<Tensor>],
        trailing: &[usize],
    ) -> Tensor {
        let span = self.arena.span(model);
        let shape = self.arena.shape(model).to_vec();
        let mut entries = Vec::new();
        for index in multi_indices(&shape) {
            for direction in directions {
                entries.push(match direction {
                    Some(direction) if index.is_empty() => *direction,
                    Some(direction) => {
                        self.arena.share(Operator::Component(*direction, index.clone()), vec![], span)
                    }
                    None => self.arena.share(Operator::Zero, vec![], span),
                });
            }
        }
        self.nest(entries, &[&shape[..], trailing].concat(), model)
    }

    /// Row-major scalars as nested stacks.
    fn nest(&mut self, entries: Vec<Tensor>, shape: &[usize], origin: Tensor) -> Tensor {
        let Some((first, rest)) = shape.split_first() else { return entries[0] };
        let stride = entries.len() / first;
        let rows = entries.chunks(stride).map(|row| self.nest(row.to_vec(), rest, origin)).collect();
        let span = self.arena.span(origin);
        self.arena.share(Operator::Stack(rows), shape.to_vec(), span)
    }

    /// The additive parts of a density, or the density as one part if they are too many: a sum of shared sums
    /// doubles with each level.
    fn parts(&mut self, density: Tensor) -> Vec<Tensor> {
        const MOST: usize = 1000;
        match self.count_parts(density, &mut HashMap::new()) {
            0..=MOST => self.additive_parts(density),
            _ => vec![density],
        }
    }

    fn count_parts(&self, density: Tensor, known: &mut HashMap<Tensor, usize>) -> usize {
        if let Some(count) = known.get(&density) {
            return *count;
        }
        let count = match self.arena.node(density).operator {
            Operator::Add(a, b) => self.count_parts(a, known).saturating_add(self.count_parts(b, known)),
            Operator::Negate(a) | Operator::Divide(a, _) | Operator::Restrict(_, a) => {
                self.count_parts(a, known)
            }
            Operator::Scale(a, b) => self.count_parts(a, known).max(self.count_parts(b, known)),
            _ => 1,
        };
        known.insert(density, count);
        count
    }

    /// Splits a scalar density at `+`, `-` and factors that are parameters only.
    fn additive_parts(&mut self, density: Tensor) -> Vec<Tensor> {
        let span = self.arena.span(density);
        match self.arena.node(density).operator.clone() {
            Operator::Add(a, b) => {
                let mut parts = self.additive_parts(a);
                parts.extend(self.additive_parts(b));
                parts
            }
            Operator::Negate(a) => {
                let parts = self.additive_parts(a);
                parts.into_iter().map(|part| self.arena.push(Operator::Negate(part), vec![], span)).collect()
            }
            Operator::Scale(a, factor) | Operator::Scale(factor, a) if self.is_parameter(factor) => {
                let parts = self.additive_parts(a);
                parts
                    .into_iter()
                    .map(|part| self.arena.push(Operator::Scale(factor, part), vec![], span))
                    .collect()
            }
            Operator::Divide(a, divisor) if self.is_parameter(divisor) => {
                let parts = self.additive_parts(a);
                parts
                    .into_iter()
                    .map(|part| self.arena.push(Operator::Divide(part, divisor), vec![], span))
                    .collect()
            }
            Operator::Restrict(side, a) => {
                let parts = self.additive_parts(a);
                let operators = parts.into_iter().map(|part| Operator::Restrict(side, part));
                operators.map(|operator| self.arena.push(operator, vec![], span)).collect()
            }
            _ => vec![density],
        }
    }

    fn is_parameter(&self, tensor: Tensor) -> bool {
        let varies = |node: &Tensor| {
            matches!(self.arena.node(*node).operator, Operator::Field { .. } | Operator::Geometry(_))
        };
        !self.arena.reachable(&[tensor]).iter().any(varies)
    }
}

/// All index tuples of a shape, row-major.
pub fn multi_indices(shape: &[usize]) -> Vec<Vec<usize>> {
    shape.iter().fold(vec![vec![]], |indices, extent| {
        indices
            .iter()
            .flat_map(|index| (0..*extent).map(move |last| [&index[..], &[last]].concat()))
            .collect()
    })
}

/// The same operator on other operands.
pub fn map_operands(operator: &Operator, change: &mut impl FnMut(Tensor) -> Tensor) -> Operator {
    use Operator::*;
    match operator {
        Number(_) | Zero | Identity | SymmetricIdentity | Parameter(_) | Field { .. } | Geometry(_) => {
            operator.clone()
        }
        Restrict(side, a) => Restrict(*side, change(*a)),
        Opposite(a, displacement) => Opposite(change(*a), change(*displacement)),
        Sliding(geometry, displacement) => Sliding(*geometry, change(*displacement)),
        Negate(a) => Negate(change(*a)),
        Map(map, a) => Map(*map, change(*a)),
        Determinant(a) => Determinant(change(*a)),
        Inverse(a) => Inverse(change(*a)),
        Cofactor(a) => Cofactor(change(*a)),
        Component(a, index) => Component(change(*a), index.clone()),
        Slice(a, selections) => Slice(change(*a), selections.clone()),
        Norm(a) => Norm(change(*a)),
        Apply(function, a) => Apply(*function, change(*a)),
        Gradient(a) => Gradient(change(*a)),
        Partial(a, variable) => Partial(change(*a), *variable),
        Add(a, b) => Add(change(*a), change(*b)),
        Scale(a, b) => Scale(change(*a), change(*b)),
        Divide(a, b) => Divide(change(*a), change(*b)),
        DivideOrZero(a, b) => DivideOrZero(change(*a), change(*b)),
        Contract(a, b) => Contract(change(*a), change(*b)),
        DoubleContract(a, b) => DoubleContract(change(*a), change(*b)),
        Cross(a, b) => Cross(change(*a), change(*b)),
        MixedCofactor(a, b) => MixedCofactor(change(*a), change(*b)),
        Inner(a, b) => Inner(change(*a), change(*b)),
        Outer(a, b) => Outer(change(*a), change(*b)),
        Power(a, b) => Power(change(*a), change(*b)),
        Atan2(a, b) => Atan2(change(*a), change(*b)),
        Minimum(a, b) => Minimum(change(*a), change(*b)),
        Maximum(a, b) => Maximum(change(*a), change(*b)),
        Stack(entries) => Stack(entries.iter().map(|entry| change(*entry)).collect()),
        External { function, arguments, order } => {
            let arguments = arguments.iter().map(|argument| change(*argument)).collect();
            External { function: *function, arguments, order: *order }
        }
        Select(truth, a, b) => {
            let truth = truth.map(change);
            Select(truth, change(*a), change(*b))
        }
        Gateaux { expression, variable, direction } => {
            Gateaux { expression: change(*expression), variable: *variable, direction: change(*direction) }
        }
        Named(named) => Named(named.map(change)),
    }
}
