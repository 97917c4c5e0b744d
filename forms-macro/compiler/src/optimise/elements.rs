//! The elements for which plans are weighed: nodes, degree, and how many points a rule of a degree usually has. No
//! kernel depends on them; they model what a backend will most likely do.

use super::degree::{Degree, Part};
use crate::parse::syntax::Entity;
use crate::tensor::{FieldInfo, FieldRole};

/// A Lagrange element on a cell with straight edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StandardElement {
    pub name: &'static str,
    pub dimension: usize,
    pub degree: usize,
    pub nodes: usize,
    pub simplex: bool,
}

const fn element(
    name: &'static str,
    dimension: usize,
    degree: usize,
    nodes: usize,
    simplex: bool,
) -> StandardElement {
    StandardElement { name, dimension, degree, nodes, simplex }
}

const ELEMENTS: &[StandardElement] = &[
    element("P1 triangle", 2, 1, 3, true),
    element("P2 triangle", 2, 2, 6, true),
    element("Q1 quadrilateral", 2, 1, 4, false),
    element("Q2 quadrilateral", 2, 2, 9, false),
    element("P1 tetrahedron", 3, 1, 4, true),
    element("P2 tetrahedron", 3, 2, 10, true),
    element("Q1 hexahedron", 3, 1, 8, false),
    element("Q2 hexahedron", 3, 2, 27, false),
];

/// Those of a dimension.
pub fn elements(dimension: usize) -> impl Iterator<Item = &'static StandardElement> {
    ELEMENTS.iter().filter(move |element| element.dimension == dimension)
}

impl StandardElement {
    /// Points for an integrand on cells, or on facets of the cell. Unknowns, test functions and states are of the
    /// element's degree, given fields and geometry of degree one.
    pub fn points(&self, degree: &Degree, fields: &[FieldInfo], entity: Entity) -> usize {
        let of_field = |field: usize| match fields[field].role {
            FieldRole::Given | FieldRole::Carried | FieldRole::History => 1,
            FieldRole::Mean(_) | FieldRole::MeanTest(_) | FieldRole::MeanTrial(_) => 0,
            _ => self.degree,
        };
        let sums = degree.0.iter().map(|sum| {
            let parts = sum.parts.iter().map(|(part, count)| {
                let degree = match *part {
                    Part::Field { field, order } => {
                        of_field(field).saturating_sub(order * usize::from(self.simplex))
                    }
                    Part::Position => 1,
                    Part::Normal => 0,
                };
                count * degree
            });
            sum.constant + parts.sum::<usize>()
        });
        let degree = sums.max().unwrap_or(0);
        let dimension = if entity == Entity::Cells { self.dimension } else { self.dimension - 1 };
        points(dimension, degree, self.simplex)
    }
}

/// Products of Gauss rules; on simplices the symmetric rules in common use (Strang and Fix, Dunavant, Keast,
/// Walkington), and products past them.
fn points(dimension: usize, degree: usize, simplex: bool) -> usize {
    match (dimension, simplex, degree) {
        (2 | 3, true, 0 | 1) => 1,
        (2, true, 2) => 3,
        (2, true, 3 | 4) => 6,
        (2, true, 5) => 7,
        (2, true, 6) => 12,
        (3, true, 2) => 4,
        (3, true, 3) => 8,
        (3, true, 4 | 5) => 14,
        _ => (degree / 2 + 1).pow(dimension as u32),
    }
}
