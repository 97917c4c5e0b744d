//! Means over own facets become fields: e(mean(a), mean(b)) with b linear in a test function is e(m, b), the term of one weight of
//! the facet, where m is known there. What the backend needs besides is ∫ ψ a, with its derivatives: an integral with a test function of
//! its own in the place of the weight ψ.

use std::collections::{HashMap, HashSet};

use super::ResidualPart;
use super::lowering::Lowering;
use super::map_operands::map_operands;
use crate::check::{Means, Term};
use crate::tensor::{Arena, FieldInfo, FieldRole, Geometry, Operator, Side, Tensor, Variable};

/// The lists of means of a function.
#[derive(Default)]
pub(super) struct FacetMeans {
    lists: Vec<MeansList>,
}

/// The means over the facets of one region, with weights of one degree.
struct MeansList {
    region: usize,
    displacement: Option<Vec<usize>>,
    degree: usize,
    /// Whether they depend on an unknown, or are over points that one moves: what does not has lists of its own.
    varies: bool,
    /// The operands of the means, each with the place of its first component.
    arguments: Vec<(Tensor, usize)>,
    /// Number of components.
    count: usize,
    /// A node of the form, for places.
    origin: Tensor,
    /// The fields of the means and of their test function, and the direction in which a residual is differentiated by the means.
    fields: Option<[usize; 2]>,
    direction: Option<usize>,
}

impl MeansList {
    fn is_of(&self, term: &Term, degree: usize, varies: bool) -> bool {
        self.region == term.region
            && self.displacement == term.displacement
            && (self.degree, self.varies) == (degree, varies)
    }
}

impl FacetMeans {
    /// Notes the means in a density that is lowered.
    pub fn collect(&mut self, lowering: &Lowering, fields: &[FieldInfo], term: &Term, density: Tensor) {
        let Some(Means { degree, .. }) = term.means else { return };
        let arena = &lowering.arena;
        let is_unknown: fn(FieldRole) -> bool = |role| matches!(role, FieldRole::Unknown(_));
        let slides = term.displacement.iter().flatten().any(|field| is_unknown(fields[*field].role));
        for node in arena.reachable(&[density]) {
            let Operator::FacetMean(operand) = arena.node(node).operator else { continue };
            if holds(arena, fields, operand, |role| matches!(role, FieldRole::Test(_))) {
                continue;
            }
            let varies = slides || holds(arena, fields, operand, is_unknown);
            let known = self.lists.iter().position(|list| list.is_of(term, degree, varies));
            let place = known.unwrap_or_else(|| {
                self.lists.push(MeansList {
                    region: term.region,
                    displacement: term.displacement.clone(),
                    degree,
                    varies,
                    arguments: vec![],
                    count: 0,
                    origin: node,
                    fields: None,
                    direction: None,
                });
                self.lists.len() - 1
            });
            let list = &mut self.lists[place];
            if !list.arguments.iter().any(|(known, _)| *known == operand) {
                list.arguments.push((operand, list.count));
                list.count += arena.shape(operand).iter().product::<usize>();
            }
        }
    }

    /// Makes the fields of the means and of their test functions.
    pub fn add_fields(&mut self, fields: &mut Vec<FieldInfo>) {
        for (number, list) in self.lists.iter_mut().enumerate() {
            let (name, shape) = (format!("means {number}"), vec![list.count]);
            fields.push(FieldInfo { name, role: FieldRole::Mean(number), shape });
            let (name, shape) = (format!("test of means {number}"), vec![list.count + 1]);
            fields.push(FieldInfo { name, role: FieldRole::MeanTest(number), shape });
            list.fields = Some([fields.len() - 2, fields.len() - 1]);
        }
    }

    /// Makes the directions in which residuals are differentiated by the means.
    pub fn add_directions(&mut self, fields: &mut Vec<FieldInfo>) {
        for (number, list) in self.lists.iter_mut().enumerate().filter(|(_, list)| list.varies) {
            let (name, shape) = (format!("d means {number}"), vec![list.count]);
            fields.push(FieldInfo { name, role: FieldRole::MeanTrial(number), shape });
            list.direction = Some(fields.len() - 1);
        }
    }

    /// The fields of the means that vary, each with its direction.
    pub fn varying(&self) -> impl Iterator<Item = (usize, usize)> {
        self.lists.iter().filter_map(|list| Some((list.fields?[0], list.direction?)))
    }

    /// The integrals that make the means: Σ a·q + 1 q_last, with the test function q. Their points are those of what reads the means.
    pub fn integrals(
        &self,
        lowering: &mut Lowering,
        fields: &[FieldInfo],
        trials: &[(usize, usize)],
    ) -> Vec<ResidualPart> {
        let mut parts = Vec::new();
        for (number, list) in self.lists.iter().enumerate() {
            let Some([_, test]) = list.fields else { continue };
            let entries = entries_of(&mut lowering.arena, test, list.count + 1, list.origin);
            let span = lowering.arena.span(list.origin);
            // ∫ ψ, the divisor.
            let mut density = entries[list.count];
            for (argument, start) in &list.arguments {
                let shape = lowering.arena.shape(*argument).to_vec();
                let count: usize = shape.iter().product();
                let weight = lowering.nest(entries[*start..start + count].to_vec(), &shape, *argument);
                let product = match shape.is_empty() {
                    true => Operator::Scale(weight, *argument),
                    false => Operator::Inner(weight, *argument),
                };
                let product = lowering.arena.push(product, vec![], span);
                density = lowering.arena.push(Operator::Add(density, product), vec![], span);
            }
            let tangent = lowering.tangent(density, trials, fields);
            let term = Term {
                region: list.region,
                displacement: list.displacement.clone(),
                means: Some(Means { number, degree: list.degree }),
                density,
            };
            parts.push(ResidualPart { term, tangent, moves: false });
        }
        parts
    }

    /// The density e(⟨a⟩) as one at points whose integral has the derivative of D e by what moves points: e + e′ (a − ⟨a⟩) at fixed means.
    pub fn at_points(lowering: &mut Lowering, density: Tensor) -> Tensor {
        let mut sum = density;
        for node in lowering.arena.reachable(&[density]) {
            let Operator::FacetMean(operand) = lowering.arena.node(node).operator else { continue };
            let (shape, span) = (lowering.arena.shape(node).to_vec(), lowering.arena.span(node));
            let less = lowering.arena.push(Operator::Negate(node), shape.clone(), span);
            let direction = lowering.arena.push(Operator::Add(operand, less), shape, span);
            let of_density = lowering.arena.shape(density).to_vec();
            let variable = Variable::Node(node);
            let change = Operator::Gateaux { expression: density, variable, direction };
            let change = lowering.arena.push(change, of_density.clone(), span);
            let change = lowering.lower(change);
            sum = lowering.arena.push(Operator::Add(sum, change), of_density, span);
        }
        sum
    }

    /// The density with fields in the place of means: those without test function are numbers, those with one are integrated.
    pub fn replace(&self, lowering: &mut Lowering, term: &Term, density: Tensor) -> Tensor {
        let Some(Means { degree, .. }) = term.means else { return density };
        let mut known: HashMap<Tensor, Tensor> = HashMap::new();
        for tensor in lowering.arena.reachable(&[density]) {
            let node = lowering.arena.node(tensor).clone();
            let new = match node.operator {
                Operator::FacetMean(operand) => {
                    let found = [false, true].into_iter().find_map(|varies| {
                        let list = self.lists.iter().find(|list| list.is_of(term, degree, varies))?;
                        let place = list.arguments.iter().find(|(known, _)| *known == operand)?;
                        Some((list, place.1))
                    });
                    match found {
                        Some((list, start)) => {
                            let [field, _] = list.fields.unwrap_or_default();
                            let entries = entries_of(&mut lowering.arena, field, list.count, tensor);
                            let count: usize = node.shape.iter().product();
                            lowering.nest(entries[start..start + count].to_vec(), &node.shape, tensor)
                        }
                        // It holds a test function.
                        None => operand,
                    }
                }
                operator => {
                    let mut changed = false;
                    let operator = map_operands(&operator, &mut |operand| {
                        let new = known.get(&operand).copied().unwrap_or(operand);
                        changed |= new != operand;
                        new
                    });
                    match changed {
                        true => lowering.arena.push(operator, node.shape, node.span),
                        false => continue,
                    }
                }
            };
            known.insert(tensor, new);
        }
        known.get(&density).copied().unwrap_or(density)
    }
}

/// The components of a field of numbers.
fn entries_of(arena: &mut Arena, field: usize, count: usize, origin: Tensor) -> Vec<Tensor> {
    let span = arena.span(origin);
    let whole = arena.share(Operator::Field { field, order: 0 }, vec![count], span);
    (0..count).map(|entry| arena.share(Operator::Component(whole, vec![entry]), vec![], span)).collect()
}

/// Whether an expression holds a field of some role.
fn holds(arena: &Arena, fields: &[FieldInfo], tensor: Tensor, is: fn(FieldRole) -> bool) -> bool {
    arena.reachable(&[tensor]).into_iter().any(|node| match arena.node(node).operator {
        Operator::Field { field, .. } => is(fields[field].role),
        _ => false,
    })
}

impl Lowering<'_> {
    /// Reports what is outside of `mean` in the density of `means` and not one number per own facet.
    pub(super) fn check_facet_means(&mut self, fields: &[FieldInfo], density: Tensor) {
        let mut pending = vec![density];
        let mut seen = HashSet::new();
        while let Some(tensor) = pending.pop() {
            if !seen.insert(tensor) {
                continue;
            }
            let what = match &self.arena.node(tensor).operator {
                Operator::FacetMean(operand) => {
                    self.check_histories(fields, *operand);
                    continue;
                }
                Operator::Geometry(Geometry::FacetArea) => continue,
                Operator::Restrict(Side::This, a) if self.is_of_own_cell(*a) => continue,
                Operator::Field { field, .. } => match fields[*field].role {
                    FieldRole::Test(_) => {
                        let name = &fields[*field].name;
                        self.diagnostics.error_with_help(
                            self.arena.span(tensor),
                            format!("the test function `{name}` is outside of `mean`, and `means` has one term per own facet"),
                            "write it inside, as in `mean(dot(toward, jump(v)))`: a product of means, one of them with the test function",
                        );
                        continue;
                    }
                    _ => format!("`{}`", fields[*field].name),
                },
                Operator::Geometry(geometry) | Operator::Sliding(geometry, _) => match geometry {
                    Geometry::Gap => "`gap`".into(),
                    Geometry::Toward => "`toward`".into(),
                    Geometry::Normal | Geometry::OppositeNormal => "the normal".into(),
                    Geometry::Position | Geometry::OppositePosition => "the position".into(),
                    Geometry::Diameter => "the diameter of an opposite cell".into(),
                    Geometry::CellVolume => "the volume of an opposite cell".into(),
                    _ => "this".to_string(),
                },
                // The displacement says where the opposite point is.
                Operator::Opposite(a, _) => {
                    pending.push(*a);
                    continue;
                }
                operator => {
                    pending.extend(operator.operands());
                    continue;
                }
            };
            self.diagnostics.error_with_help(
                self.arena.span(tensor),
                format!("{what} varies along the own facet, and outside of `mean` the density of `means` is one number per facet"),
                "write it inside of `mean(..)`; numbers, parameters, `this(h)`, `this(cell_volume)` and `facet_area` may be outside",
            );
        }
    }

    /// Reports histories in a mean: they have a rule of their own, and means have that of all that reads them.
    fn check_histories(&mut self, fields: &[FieldInfo], operand: Tensor) {
        for node in self.arena.reachable(&[operand]) {
            let Operator::Field { field, .. } = self.arena.node(node).operator else { continue };
            if fields[field].role == FieldRole::History {
                let message =
                    format!("`{}` is a history, which has no mean over an own facet", fields[field].name);
                let help = "integrate what reads it by `integral(Touch, density)`, or pass a `Given` field";
                self.diagnostics.error_with_help(self.arena.span(node), message, help);
            }
        }
    }

    /// Whether it is one number on the own cell: sizes, parameters and numbers.
    fn is_of_own_cell(&self, tensor: Tensor) -> bool {
        self.arena.reachable(&[tensor]).into_iter().all(|node| match self.arena.node(node).operator {
            Operator::Field { .. } | Operator::Sliding(..) => false,
            Operator::Geometry(geometry) => {
                matches!(geometry, Geometry::Diameter | Geometry::CellVolume | Geometry::FacetArea)
            }
            _ => true,
        })
    }

    /// The derivatives of a density in the direction of each trial function, where not zero.
    pub(super) fn tangent(
        &mut self,
        density: Tensor,
        trials: &[(usize, usize)],
        fields: &[FieldInfo],
    ) -> Vec<(usize, Tensor)> {
        let mut tangent = Vec::new();
        for &(varied, trial) in trials {
            let gateaux = self.gateaux(density, varied, trial, fields);
            let derivative = self.lower(gateaux);
            if !self.arena.is_zero(derivative) {
                tangent.push((trial, derivative));
            }
        }
        tangent
    }
}
