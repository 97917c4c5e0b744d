//! Tables of a group, before any cell: basis functions at the points, as arrays.

use std::sync::Arc;

use forms_core::contract::{Order, Requirements, Side};

use crate::assemble::binding::Values;
use crate::assemble::element_kernel::ElementLayout;
use crate::assemble::element_kernel::sizes::{Array, Sizes};
use crate::assemble::groups::{Group, Measure};
use crate::element::Tables;

/// Components of a field, at most.
pub(super) const MOST_COMPONENTS: usize = 3;

/// Numbers that a kernel reads of fields at a point, at most: three fields with values and gradients, in space, and some.
pub(super) const MOST_NUMBERS: usize = 48;

/// Corners of a cell, at most.
pub(super) const MOST_CORNERS: usize = 8;

/// The place of a corner of a quadrilateral or hexahedron, whose bits are its coordinates along the axes.
#[inline(always)]
pub(super) const fn corner(node: usize) -> usize {
    [0, 1, 3, 2][node % 4] + node / 4 * 4
}

/// Whether a kernel reads only what the loops of fixed lengths give.
pub(in crate::assemble) const fn fits(requirements: &Requirements) -> bool {
    if requirements.reads_further()
        || requirements.curvature
        || requirements.opposite_diameter
        || requirements.opposite_volume
        || requirements.field_length > MOST_NUMBERS
    {
        return false;
    }
    let mut k = 0;
    while k < requirements.fields.len() {
        let slot = &requirements.fields[k];
        if matches!(slot.side, Side::Other)
            || matches!(slot.order, Order::Hessian)
            || slot.order.is_mean()
            || slot.components > MOST_COMPONENTS
        {
            return false;
        }
        k += 1;
    }
    true
}

/// Values and derivatives of a basis at the points of a rule.
#[derive(Clone, Copy)]
pub(super) struct BasisTables<V, G> {
    pub values: V,
    pub slopes: G,
}

/// The basis of the test (and trial) functions.
pub(super) type ArgumentTables<S, const D: usize> = BasisTables<
    <S as Sizes>::Points<<S as Sizes>::Nodes<f64>>,
    <S as Sizes>::Points<<S as Sizes>::Nodes<[f64; D]>>,
>;

/// The basis of the geometry map.
pub(super) type GeometryTables<S, const D: usize> = BasisTables<
    <S as Sizes>::Points<<S as Sizes>::GeometryNodes<f64>>,
    <S as Sizes>::Points<<S as Sizes>::GeometryNodes<[f64; D]>>,
>;

/// A field whose coefficients the caller lists.
pub(super) struct FieldTables<const D: usize> {
    pub offsets: Arc<[usize]>,
    pub basis: FieldBasis,
    pub tables: Tables<D>,
}

/// The basis functions of a field: some are in arrays already.
#[derive(Clone, Copy)]
pub(super) enum FieldBasis {
    /// Those of the test function.
    Arguments,
    /// Those of the geometry map.
    Geometry,
    /// Others, in the field's own tables.
    Own,
}

/// A group's tables.
pub(in crate::assemble) struct FixedTables<S: Sizes, const D: usize> {
    pub(super) weights: S::Points<f64>,
    pub(super) geometry: GeometryTables<S, D>,
    /// Of multilinear maps, products of the coordinates of a point, whose axes are the bits of their numbers.
    pub(super) monomials: S::Points<[f64; MOST_CORNERS]>,
    pub(super) arguments: ArgumentTables<S, D>,
    /// By the form's index; `None` where there are no coefficients.
    pub(super) fields: Vec<Option<FieldTables<D>>>,
    /// Places of the coordinates of a cell's geometry nodes, and from one cell's to the next's; see [`ElementLayout`].
    pub(super) coordinate_offsets: S::GeometryNodes<usize>,
    pub(super) coordinate_stride: usize,
    pub(super) coefficient_stride: usize,
    /// Reference tangents of the facet; `None` inside cells.
    pub(super) tangents: Option<[[f64; D]; 2]>,
    /// For |T| and |F|.
    pub(super) measure: Measure<D>,
    /// Sums of the weights of `measure`, inside the cell and on the facet: |T| and |F| of the reference cell.
    pub(super) reference_measure: [f64; 2],
    /// Of the cell.
    pub(super) vertices: usize,
    /// Number of points, for loops that are to stay loops.
    pub(super) points: usize,
}

impl<S: Sizes, const D: usize> FixedTables<S, D> {
    /// The map is affine, one Jacobian serves all points: only simplices with straight edges have as many geometry nodes.
    pub(super) const AFFINE: bool = <S::GeometryNodes<f64> as Array<f64>>::LENGTH == D + 1;

    /// The map is that of a quadrilateral or hexahedron with straight edges.
    pub(super) const MULTILINEAR: bool =
        !Self::AFFINE && <S::GeometryNodes<f64> as Array<f64>>::LENGTH == 1 << D;

    /// The basis functions of the unknown are the barycentric coordinates of a straight simplex: no other cell has D + 1 nodes.
    pub(super) const LINEAR: bool = Self::AFFINE && <S::Nodes<f64> as Array<f64>>::LENGTH == D + 1;

    /// Copies of a group's tables; their lengths are those of the arrays.
    pub fn new(group: &Group<D>, values: &[Values<D>], layout: &ElementLayout) -> Self {
        let side = &group.sides[0];
        let mut weights = S::Points::filled(0.0);
        weights.entries_mut().copy_from_slice(&group.weights);
        let mut coordinate_offsets = S::GeometryNodes::filled(0);
        coordinate_offsets.entries_mut().copy_from_slice(&layout.coordinate_offsets);
        let fields = values.iter().map(|values| match values {
            Values::Given { element, offsets } => Some(FieldTables {
                offsets: offsets.clone(),
                basis: match &side.elements[*element] {
                    _ if *element == 0 => FieldBasis::Arguments,
                    own if own.value == side.geometry.value => FieldBasis::Geometry,
                    _ => FieldBasis::Own,
                },
                tables: side.elements[*element].clone(),
            }),
            _ => None,
        });
        let (places, map) = (
            rows::<S::Points<S::GeometryNodes<f64>>, _, _>(&side.geometry.value),
            rows::<S::Points<S::GeometryNodes<[f64; D]>>, _, _>(&side.geometry.gradient),
        );
        let (values, slopes) = (
            rows::<S::Points<S::Nodes<f64>>, _, _>(&side.elements[0].value),
            rows::<S::Points<S::Nodes<[f64; D]>>, _, _>(&side.elements[0].gradient),
        );
        let mut monomials = S::Points::filled([1.0; MOST_CORNERS]);
        if Self::MULTILINEAR {
            for (values, monomials) in side.geometry.value.chunks(1 << D).zip(monomials.entries_mut()) {
                for axis in 0..D {
                    let at_one = |node: usize| corner(node) >> axis & 1 == 1;
                    let coordinate: f64 =
                        (0..1 << D).filter(|node| at_one(*node)).map(|node| values[node]).sum();
                    for (product, monomial) in monomials.iter_mut().enumerate() {
                        *monomial *= if product >> axis & 1 == 1 { coordinate } else { 1.0 };
                    }
                }
            }
        }
        FixedTables {
            weights,
            monomials,
            geometry: BasisTables { values: places, slopes: map },
            arguments: BasisTables { values, slopes },
            fields: fields.collect(),
            coordinate_offsets,
            coordinate_stride: layout.coordinate_stride,
            coefficient_stride: layout.coefficient_stride,
            tangents: side.facet.map(|(_, tangents)| tangents),
            measure: side.measure.clone(),
            reference_measure: [
                side.measure.cell_weights.iter().sum(),
                side.measure.facet.as_ref().map_or(0.0, |(_, weights)| weights.iter().sum()),
            ],
            vertices: side.shape.vertices(),
            points: group.points(),
        }
    }
}

/// A list as rows of equal lengths.
fn rows<A: Array<R>, R: Array<T>, T: Copy + Send + 'static>(list: &[T]) -> A {
    let mut rows = A::filled(R::filled(list[0]));
    for (row, entries) in rows.entries_mut().iter_mut().zip(list.chunks_exact(R::LENGTH)) {
        row.entries_mut().copy_from_slice(entries);
    }
    rows
}
