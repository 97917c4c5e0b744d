//! A level set function on a quadrilateral or hexahedron as a polynomial of degree 2 in each direction: the points of rules on its parts, on
//! those of facets, and the sides of both.

use super::bernstein::{Line, Zeros, bounds, from_nodes, from_vertices};
use super::{Walk, Wanted, points};
use crate::cut::number::Number;
use crate::cut::pieces::points_on_pieces;
use crate::cut::{Cut, CutSide};
use crate::element::CellShape;
use crate::mesh::Facet;
use crate::quadrature::{Piece, Quadrature, QuadratureError, QuadratureRule, facet_reference_rule};

/// One point, enough to tell what there is.
const MIDDLE: [(f64, f64); 1] = [(0.5, 1.0)];

/// Rules on lines along the axes of a square or cube that is cut along heights.
#[derive(Clone)]
pub(crate) struct LineRules([Vec<(f64, f64)>; 3]);

impl LineRules {
    /// Rules for polynomials of a degree in each direction, exact where zeros are flat: a line along the height has the polynomial's degree, and integrals along
    /// one axis add to the degree along the next one. On lines across heights there are more points than the level set function's degree, so that errors of
    /// the rule are of a higher order than those of the body.
    ///
    /// # Errors
    /// A degree that is too high.
    pub fn new(degree: usize, dimension: usize, degree_of_function: usize) -> Result<Self, QuadratureError> {
        let mut rules = LineRules([vec![], vec![], vec![]]);
        for (axis, list) in rules.0.iter_mut().enumerate().take(dimension) {
            let least = if axis == 0 { 0 } else { 2 * degree_of_function };
            *list = line_rule(((axis + 1) * degree).max(least))?;
        }
        Ok(rules)
    }

    fn walk(&self) -> Walk<'_> {
        Walk::new(self.0.each_ref().map(|rule| &rule[..]))
    }
}

/// Gauss's rule on the unit segment that is exact for polynomials of a degree.
pub(super) fn line_rule(degree: usize) -> Result<Vec<(f64, f64)>, QuadratureError> {
    let rule = facet_reference_rule(CellShape::Quadrilateral, degree)?;
    Ok(rule.points.iter().map(|[s, _]| *s).zip(rule.weights).collect())
}

/// The polynomial on a cell.
#[derive(Clone, Copy)]
pub(crate) struct CellPolynomial<R> {
    shape: CellShape,
    coefficients: [R; 27],
}

impl<R: Number> CellPolynomial<R> {
    /// The polynomial on a cell.
    pub fn new<const D: usize>(cut: &Cut<D>, cell: u32) -> Self {
        Self::varied_from(cut, cell, 0)
    }

    /// The polynomial on a cell, for derivatives by its values from the node of this number on.
    pub fn varied_from<const D: usize>(cut: &Cut<D>, cell: u32, first: usize) -> Self {
        let mut coefficients = [R::zero(); 27];
        for (k, (node, place)) in cut.level_nodes(cell).iter().zip(&cut.lattice).enumerate() {
            let number = k.checked_sub(first).unwrap_or(usize::MAX);
            coefficients[usize::from(*place)] = R::of_node(cut.values[*node as usize], number);
        }
        let own = &mut coefficients[..3_usize.pow(D as u32)];
        if cut.degree == 2 {
            from_nodes(own)
        } else {
            from_vertices(own)
        }
        CellPolynomial { shape: cut.mesh().cell_shape(cell as usize), coefficients }
    }

    fn visit(&self, wanted: Wanted, walk: &Walk, visit: &mut dyn FnMut([R; 3], R, [R; 3])) {
        match self.shape {
            CellShape::Quadrilateral => {
                points::<R, 9>(&std::array::from_fn(|k| self.coefficients[k]), wanted, walk, visit);
            }
            _ => points(&self.coefficients, wanted, walk, visit),
        }
    }

    /// The points of a rule inside, in reference coordinates with their weights there.
    pub fn points_inside<const D: usize>(&self, rules: &LineRules, points: &mut Vec<R>) {
        self.visit(Wanted::Inside, &rules.walk(), &mut |place, weight, _| {
            points.extend_from_slice(&place[..D]);
            points.push(weight);
        });
    }

    /// The points of a rule on the interface, in reference coordinates, with their weights and the unit normal there.
    pub fn points_of_interface<const D: usize>(&self, rules: &LineRules, points: &mut Vec<R>) {
        self.visit(Wanted::Interface, &rules.walk(), &mut |place, weight, normal| {
            points.extend_from_slice(&place[..D]);
            points.push(weight);
            points.extend_from_slice(&normal[..D]);
        });
    }

    /// The polynomial on a facet in its own coordinates: of an edge the first three coefficients.
    fn on_facet(&self, local: u8) -> [R; 9] {
        let numbers = self.shape.facet_vertices(usize::from(local));
        let ends = [numbers[0], numbers[1], numbers[numbers.len() - 1]];
        let [origin, first, last] = ends.map(|vertex| self.shape.vertex_points()[vertex]);
        std::array::from_fn(|index| {
            let [a, b] = [index % 3, index / 3].map(|place| 0.5 * place as f64);
            // In the plane there is one direction.
            let place = |k: usize| origin[k] + a * (first[k] - origin[k]) + b * (last[k] - origin[k]);
            match self.shape.dimension() == 2 && index > 2 {
                true => R::zero(),
                false => {
                    let steps: usize =
                        [1, 3, 9].iter().enumerate().map(|(k, step)| (2.0 * place(k)) as usize * step).sum();
                    self.coefficients[steps]
                }
            }
        })
    }

    /// The intervals of an edge that are inside.
    pub fn pieces_of_edge(&self, local: u8) -> Vec<[[R; 2]; 3]> {
        let [first, middle, last, ..] = self.on_facet(local);
        let (zeros, mut pieces, mut start) = (Zeros::of(&[[first, middle, last]]), vec![], R::zero());
        for number in 0..=zeros.list().len() {
            let end = zeros.list().get(number).copied().unwrap_or(R::one());
            if (first.value() < 0.0) == (number % 2 == 0) && end.value() > start.value() {
                pieces.push([[start, R::zero()], [end, R::zero()], [R::zero(); 2]]);
            }
            start = end;
        }
        pieces
    }

    /// The points of a rule on the part of a face inside, in reference coordinates of the cell with their weights on the face's own.
    pub fn points_on_face<const D: usize>(&self, local: u8, rules: &LineRules, list: &mut Vec<R>) {
        let numbers = self.shape.facet_vertices(usize::from(local));
        let ends = [numbers[0], numbers[1], numbers[numbers.len() - 1]];
        let [origin, first, last] = ends.map(|vertex| self.shape.vertex_points()[vertex]);
        points(&self.on_facet(local), Wanted::Inside, &rules.walk(), &mut |[s, t, _], weight, _| {
            let edges = |k: usize| s * (first[k] - origin[k]) + t * (last[k] - origin[k]);
            list.extend((0..D).map(|k| edges(k) + origin[k]));
            list.push(weight);
        });
    }

    /// The points of a rule on the part of an edge inside, as [`points_on_pieces`] lists them.
    pub fn points_on_edge<const D: usize>(&self, local: u8, rule: &QuadratureRule<2>, points: &mut Vec<R>) {
        points_on_pieces::<R, D>((self.shape, local), &self.pieces_of_edge(local), rule, points);
    }
}

/// The side of a square or cube with some coefficients, which all but need to be looked at closely where a zero is inside and no vertex shows it.
fn side_of<const N: usize>(coefficients: &[f64; N], vertices: impl Iterator<Item = f64>) -> CutSide {
    let [least, most] = bounds(coefficients);
    if most <= 0.0 && least < 0.0 {
        return CutSide::Inside;
    }
    if least >= 0.0 {
        return CutSide::Outside;
    }
    let (mut inner, mut outer) = (false, false);
    for value in vertices {
        inner |= value < 0.0;
        outer |= value >= 0.0;
    }
    let walk = Walk::new([&MIDDLE; 3]);
    inner = inner || {
        let mut found = false;
        points(coefficients, Wanted::Inside, &walk, &mut |_, _, _| found = true);
        found
    };
    outer = outer || {
        let mut found = false;
        points(coefficients, Wanted::Outside, &walk, &mut |_, _, _| found = true);
        found
    };
    match (inner, outer) {
        (true, true) => CutSide::Cut,
        (true, false) => CutSide::Inside,
        _ => CutSide::Outside,
    }
}

impl CellPolynomial<f64> {
    /// Bounds of the function on the cell.
    pub fn bounds(&self) -> [f64; 2] {
        bounds(&self.coefficients[..3_usize.pow(self.shape.dimension() as u32)])
    }

    /// Location of the cell.
    pub fn side(&self) -> CutSide {
        let c = &self.coefficients;
        match self.shape {
            CellShape::Quadrilateral => {
                let vertices = [0, 2, 6, 8].map(|k| c[k]);
                side_of::<9>(&std::array::from_fn(|k| c[k]), vertices.into_iter())
            }
            _ => side_of(c, [0, 2, 6, 8, 18, 20, 24, 26].into_iter().map(|k| c[k])),
        }
    }

    /// Location of a facet.
    pub fn side_of_facet(&self, local: u8) -> CutSide {
        let c = self.on_facet(local);
        if self.shape != CellShape::Quadrilateral {
            return side_of(&c, [0, 2, 6, 8].into_iter().map(|k| c[k]));
        }
        let own: Line<f64> = [c[0], c[1], c[2]];
        match (Zeros::of(&[own]).list(), own[0] < 0.0) {
            ([], true) => CutSide::Inside,
            ([], false) => CutSide::Outside,
            _ => CutSide::Cut,
        }
    }

    /// Numbers that tell how the cell and a facet are cut.
    pub fn structure(&self) -> u32 {
        let walk = Walk::new([&MIDDLE; 3]);
        self.visit(Wanted::Inside, &walk, &mut |_, _, _| {});
        walk.structure()
    }

    /// A number that tells how a face is cut.
    pub fn structure_of_face(&self, local: u8) -> u32 {
        let walk = Walk::new([&MIDDLE; 3]);
        points(&self.on_facet(local), Wanted::Inside, &walk, &mut |_, _, _| {});
        walk.structure()
    }
}

/// The part of a facet that is inside, on the facet's own reference cell.
#[derive(Clone, Debug)]
pub(crate) enum FacetPart {
    /// Simplices.
    Pieces(Vec<Piece>),
    /// The part of a square in which a polynomial is negative, by its coefficients, and the degree of the level set function.
    Square { coefficients: [f64; 9], degree: usize },
}

impl FacetPart {
    /// The rule on it.
    ///
    /// # Errors
    /// A degree that is too high, and explicit points.
    pub fn rule<const D: usize>(
        &self,
        quadrature: &Quadrature<D>,
        shape: CellShape,
        estimated: usize,
    ) -> Result<QuadratureRule<2>, QuadratureError> {
        match self {
            FacetPart::Pieces(pieces) => quadrature.rule_on_pieces(shape, estimated, pieces),
            FacetPart::Square { coefficients, degree } => {
                let own = quadrature.degree(estimated).ok_or(QuadratureError::Pieces)?;
                let rules = LineRules::new(own, 2, *degree)?;
                let mut rule = QuadratureRule { points: vec![], weights: vec![] };
                points(coefficients, Wanted::Inside, &rules.walk(), &mut |[s, t, _], weight, _| {
                    rule.points.push([s, t]);
                    rule.weights.push(weight);
                });
                Ok(rule)
            }
        }
    }
}

impl<const D: usize> Cut<D> {
    /// The part of a facet inside; `None` for a whole one.
    pub(crate) fn part_of_facet(&self, facet: Facet) -> Option<FacetPart> {
        match self.side_of_facet(facet) {
            CutSide::Inside => None,
            CutSide::Cut if D == 3 && self.cuts_by_heights(facet.cell) => {
                let coefficients = CellPolynomial::<f64>::new(self, facet.cell).on_facet(facet.local);
                Some(FacetPart::Square { coefficients, degree: self.degree })
            }
            CutSide::Cut if self.cuts_by_heights(facet.cell) => {
                let own = CellPolynomial::<f64>::new(self, facet.cell);
                Some(FacetPart::Pieces(own.pieces_of_edge(facet.local)))
            }
            _ => self.pieces_of_facet(facet).map(FacetPart::Pieces),
        }
    }

    /// Numbers of the cells cut along heights, and of the faces on their boundary: where one changes, other lines are cut.
    pub(in crate::cut) fn structures(&self) -> Vec<u32> {
        let polynomial = |cell: u32| CellPolynomial::<f64>::new(self, cell);
        let mut numbers: Vec<u32> = self
            .cut_cells()
            .iter()
            .filter(|cell| self.cuts_by_heights(**cell))
            .map(|cell| polynomial(*cell).structure())
            .collect();
        if D == 3 && !numbers.is_empty() {
            let facets = self.mesh().facet_region(crate::mesh::BOUNDARY).unwrap_or_default();
            let crossed = facets.iter().filter(|facet| self.side_of_facet(**facet) == CutSide::Cut);
            numbers.extend(crossed.map(|facet| polynomial(facet.cell).structure_of_face(facet.local)));
        }
        numbers
    }
}
