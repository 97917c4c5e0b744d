//! Means over a cell: the mean of what is affine in fields is the same expression of the fields' means, if its
//! coefficients are constant on the cell.

use std::collections::HashMap;

use crate::diagnostics::Diagnostics;
use crate::tensor::{Arena, FieldInfo, FieldRole, Geometry, Operator, Tensor, Variable};

/// Takes means to the fields of expressions that hold no derivatives still to be taken.
pub struct CellMeans<'a> {
    arena: &'a mut Arena,
    /// As checked. Directions come after them.
    fields: &'a [FieldInfo],
    diagnostics: &'a mut Diagnostics,
    constant: HashMap<Tensor, bool>,
    known: HashMap<Tensor, Option<Tensor>>,
}

impl<'a> CellMeans<'a> {
    pub fn new(arena: &'a mut Arena, fields: &'a [FieldInfo], diagnostics: &'a mut Diagnostics) -> Self {
        CellMeans { arena, fields, diagnostics, constant: HashMap::new(), known: HashMap::new() }
    }

    /// The mean of an expression; `None` after a report.
    pub fn of(&mut self, tensor: Tensor) -> Option<Tensor> {
        if let Some(known) = self.known.get(&tensor) {
            return *known;
        }
        let mean = if self.is_constant(tensor) { Some(tensor) } else { self.of_varying(tensor) };
        self.known.insert(tensor, mean);
        mean
    }

    fn of_varying(&mut self, tensor: Tensor) -> Option<Tensor> {
        use Operator::*;
        let operator = self.arena.node(tensor).operator.clone();
        let mean = match operator {
            Field { field, order } => {
                if self.fields.get(field).is_some_and(|field| field.role == FieldRole::History) {
                    return self.refuse(
                        tensor,
                        "a history has no mean over a cell: it is known at quadrature points only",
                        "project it to a space and pass a `Given` field",
                    );
                }
                if order > 1 {
                    return self.refuse(
                        tensor,
                        "the mean of second derivatives over a cell is not available",
                        "means are of fields and of their gradients, `mean(u)`, `mean(grad(u))`",
                    );
                }
                CellMean(tensor)
            }
            // Only in formulas, where means stay as they are written.
            Gradient(_) | Partial(..) | Gateaux { .. } | Named(_) => CellMean(tensor),
            Add(a, b) => Add(self.of(a)?, self.of(b)?),
            Negate(a) => Negate(self.of(a)?),
            Map(map, a) => Map(map, self.of(a)?),
            Component(a, index) => Component(self.of(a)?, index),
            Slice(a, selections) => Slice(self.of(a)?, selections),
            Restrict(side, a) => Restrict(side, self.of(a)?),
            Opposite(a, displacement) => Opposite(self.of(a)?, displacement),
            Stack(entries) => {
                Stack(entries.into_iter().map(|entry| self.of(entry)).collect::<Option<Vec<_>>>()?)
            }
            Scale(a, b) => self.product(tensor, a, b, Scale)?,
            Contract(a, b) => self.product(tensor, a, b, Contract)?,
            DoubleContract(a, b) => self.product(tensor, a, b, DoubleContract)?,
            Cross(a, b) => self.product(tensor, a, b, Cross)?,
            Inner(a, b) => self.product(tensor, a, b, Inner)?,
            Outer(a, b) => self.product(tensor, a, b, Outer)?,
            MixedCofactor(a, b) => self.product(tensor, a, b, MixedCofactor)?,
            Divide(a, b) if self.is_constant(b) => Divide(self.of(a)?, b),
            DivideOrZero(a, b) if self.is_constant(b) => DivideOrZero(self.of(a)?, b),
            Select(truth, a, b) if truth.operands().iter().all(|one| self.is_constant(*one)) => {
                Select(truth, self.of(a)?, self.of(b)?)
            }
            Geometry(geometry) | Sliding(geometry, _) => return self.no_mean_of(tensor, geometry),
            _ => return self.not_affine(tensor, "this is not"),
        };
        let (shape, span) = (self.arena.shape(tensor).to_vec(), self.arena.span(tensor));
        Some(self.arena.share(mean, shape, span))
    }

    fn product(
        &mut self,
        tensor: Tensor,
        a: Tensor,
        b: Tensor,
        make: fn(Tensor, Tensor) -> Operator,
    ) -> Option<Operator> {
        if self.is_constant(a) {
            Some(make(a, self.of(b)?))
        } else if self.is_constant(b) {
            Some(make(self.of(a)?, b))
        } else if let Some(area) = [a, b].into_iter().find(|factor| self.is_facet_area(*factor)) {
            self.no_mean_of(area, Geometry::FacetArea)
        } else {
            self.not_affine(tensor, "this is a product of what varies over the cell")
        }
    }

    fn is_facet_area(&self, tensor: Tensor) -> bool {
        matches!(self.arena.node(tensor).operator, Operator::Geometry(Geometry::FacetArea))
    }

    /// Is it one value on the whole cell, for every mesh and all data?
    fn is_constant(&mut self, tensor: Tensor) -> bool {
        if let Some(known) = self.constant.get(&tensor) {
            return *known;
        }
        let operator = self.arena.node(tensor).operator.clone();
        let constant = match operator {
            Operator::CellMean(_) => true,
            Operator::Field { .. } | Operator::Sliding(..) => false,
            Operator::Geometry(geometry) => matches!(geometry, Geometry::Diameter | Geometry::CellVolume),
            // The displacement says where the cell is.
            Operator::Opposite(a, _) => self.is_constant(a),
            other => other.operands().into_iter().all(|operand| self.is_constant(operand)),
        };
        self.constant.insert(tensor, constant);
        constant
    }

    fn not_affine<T>(&mut self, tensor: Tensor, what: &str) -> Option<T> {
        let message = format!("the mean over a cell is of what is affine in fields, and {what}");
        let of_pairs =
            self.arena.reachable(&[tensor]).into_iter().any(|node| match &self.arena.node(node).operator {
                Operator::Geometry(geometry) | Operator::Sliding(geometry, _) => geometry.is_of_pairs(),
                operator => matches!(operator, Operator::Opposite(..)),
            });
        if of_pairs {
            return self.refuse(
                tensor,
                &message,
                "the mean over the own facet of a contact pair is written in `means(Touch(u), 0, density)`; a function with it that others call is private, or gives a `Form` or `Functional`",
            );
        }
        self.refuse(
            tensor,
            &message,
            "take means of fields first, as in `det(mean(F))`, or give the mean a field of degree 0: for that of det(F) an energy of unknowns `J` and `p`, `W(F, J) + p * (det(F) - J)`",
        )
    }

    fn no_mean_of<T>(&mut self, tensor: Tensor, geometry: Geometry) -> Option<T> {
        if geometry == Geometry::FacetArea {
            return self.refuse(
                tensor,
                "the area of a facet does not belong to the cell whose mean is taken",
                "write it outside of `mean`",
            );
        }
        let what = match geometry {
            Geometry::Position | Geometry::OppositePosition => "the position",
            Geometry::Normal | Geometry::OppositeNormal => "the normal",
            Geometry::Curvature => "the curvature",
            Geometry::Gap => "`gap`",
            _ => "`toward`",
        };
        let message = format!("the mean over a cell is of fields, and {what} is none");
        if geometry.is_of_pairs() {
            return self.refuse(
                tensor,
                &message,
                "the mean over the own facet of a contact pair is written in `means(Touch(u), 0, density)`, where `mean` is of what belongs to pairs",
            );
        }
        self.refuse(
            tensor,
            &message,
            "write it outside of `mean`, or interpolate what depends on the position and pass a `Given` field",
        )
    }

    fn refuse<T>(&mut self, tensor: Tensor, message: &str, help: &str) -> Option<T> {
        self.diagnostics.error_with_help(self.arena.span(tensor), message, help);
        None
    }
}

/// Reports that an expression is differentiated by what is inside of a mean in it: a derivative at a point does not say
/// how the rest of the cell varies. The operators of differentiation are still in it.
pub fn check_variable(arena: &Arena, expression: Tensor, variable: Variable, diagnostics: &mut Diagnostics) {
    let varied = |node: Tensor| match (variable, &arena.node(node).operator) {
        (Variable::Node(varied), _) => node == varied,
        (Variable::Field(varied), Operator::Field { field, .. }) => varied == *field,
        _ => false,
    };
    for node in arena.reachable(&[expression]) {
        let Operator::CellMean(operand) = arena.node(node).operator else { continue };
        if arena.reachable(&[operand]).into_iter().any(varied) {
            diagnostics.error_with_help(
                arena.span(node),
                "`diff` varies a name at one point, and this mean is over a cell on which it varies, too",
                "give the mean a name, `let m = mean(F); diff(W(m), m)`, or differentiate the form, `derivative(form, u, v)`",
            );
        }
    }
}
