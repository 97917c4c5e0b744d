//! Redistributed mass: a density without inertia at the nodes of a boundary, with the same mass, centre and moments of inertia
//! (Khenous, Laborde & Renard 2008, Mass redistribution method for finite element contact problems in elastodynamics, Eur. J. Mech.
//! A/Solids 27).
//!
//! A node of the boundary that has a mass hits an obstacle by itself, and the pressure swings. Without mass it follows the body
//! statically. There the mass matrix is changed; here the density is, so that inertia stays a form: it is zero in all cells with a
//! vertex on the boundary, and elsewhere the old one times 1 + q with the quadratic q that is smallest in the mean, weighted by
//! the old density.

use std::sync::Arc;

use thiserror::Error;

use crate::assemble::{Assembler, AssemblyError};
use crate::dimension::{Dim, Dimension};
use crate::element::Elements;
use crate::field::{Field, FieldError};
use crate::forms;
use crate::instantiate::instantiate;
use crate::linear_algebra::{CsrMatrix, LinearAlgebraError, LuFactor, Transpose};
use crate::mesh::{Mesh, MeshError};
use crate::space::{Scope, Space, SpaceError};

#[forms(crate = crate)]
mod moments {
    pub struct Data {
        pub constant: Param,
        pub linear: Given<Vector>,
        pub quadratic: Given<Tensor>,
        pub centre: Given<Vector>,
    }
    #[cells]
    pub struct Omega;

    /// ∫ (a + b·r + r·C r) q with r = x − x₀.
    pub fn of_basis(q: Test<Scalar>) -> Form {
        let r = x - centre;
        integral(Omega, (constant + dot(linear, r) + dot(r, dot(quadratic, r))) * q)
    }
}

/// A density that was not redistributed.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum RedistributionError {
    /// A region or mesh that does not fit: hanging nodes carry the mass of cells away from the boundary to its nodes.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Spaces of degree two that the mesh does not have.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// A density that is no scalar per cell.
    #[error("the density is one number per cell, a field of `Space::discontinuous_scalar` of degree 0")]
    NotPerCell,
    /// A density that is no positive number.
    #[error("the density of cell {cell} is {density}, no positive number")]
    Density { cell: usize, density: f64 },
    /// A boundary that all cells touch.
    #[error("all {cells} cells touch \"{region}\": none is left to take their mass")]
    NoCellLeft {
        region: String,
        /// Number of cells.
        cells: usize,
    },
    /// Cells that touch the boundary have more of the mass, or of its moments, than the others can take.
    #[error(
        "without mass in the cells at \"{region}\" the density would fall to {factor:.3} of what it was in cell {cell}: the mesh is too coarse there"
    )]
    NotPositive {
        region: String,
        /// The cell in which the factor is smallest.
        cell: usize,
        /// Its lower bound there.
        factor: f64,
    },
    /// The moments could not be assembled.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The equations of the factor could not be solved.
    #[error(transparent)]
    LinearAlgebra(#[from] LinearAlgebraError),
    /// A density that is not finite.
    #[error(transparent)]
    Field(#[from] FieldError),
}

/// A density \[mass/volume\] of a discontinuous space of degree 2 that is zero in all cells with a vertex on a boundary, so that no
/// node there has inertia in any continuous space, and has the mass, the centre and the second moments of `density`, one number per
/// cell. They are kept to rounding by the assembler's quadrature; with the rule of a form of inertia where that is exact, as on
/// straight simplices, parallelograms and parallelepipeds, or where both have the same rule.
///
/// In spaces of degree 2 and more the nodes inside those cells have no inertia either. The factor is 1 + O(h). Nodes without inertia have no accelerations
/// of their own: schemes are to read none there ([`StepFailure::Massless`](super::StepFailure::Massless) otherwise). Velocities and accelerations of states
/// at such nodes are what the scheme's formulas make of the displacements; no inertia reads them.
///
/// ```
/// use forms_fem::prelude::*;
/// use forms_fem::time::redistributed_mass;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let mesh = rectangle([0.0; 2], [2.0, 1.0], [32, 16], CellShape::Quadrilateral, 1)?;
/// let even = Field::interpolate(&Space::discontinuous_scalar(&mesh, 0)?, |_| 3.0)?;
/// let density = redistributed_mass(&even, "bottom", &Assembler::new(&mesh))?;
/// // In the data of a form of motion:
/// let rho: Given<f64, 2> = Given::field(&density);
/// # let _ = rho;
/// # assert_eq!(density.evaluate(&[1.0, 0.05])?, [0.0]);
/// # assert!((density.evaluate(&[1.0, 0.5])?[0] - 3.0).abs() < 1.0);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`RedistributionError`].
pub fn redistributed_mass<const D: usize>(
    density: &Field<D>,
    region: &str,
    assembler: &Assembler<D>,
) -> Result<Field<D>, RedistributionError>
where
    Dim: Dimension<D>,
{
    let before = Before::new(density, region)?;
    let mut weights = vec![];
    for data in before.powers.data() {
        let model = moments::Model::new(data).of_basis();
        weights.push(assembler.linear_form(&model, &before.space)?);
    }
    before.redistribute(&weights)
}

/// The polynomials 1, r, r r of degree two, r = x − x₀ over the extents of the mesh.
struct Powers<const D: usize> {
    centre: [f64; D],
    extents: [f64; D],
}

/// A density and where it is to vanish.
struct Before<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    region: &'a str,
    /// Of each cell.
    density: Vec<f64>,
    /// Whether a cell touches the boundary.
    touches: Vec<bool>,
    /// That of the new density.
    space: Arc<Space<D>>,
    powers: Powers<D>,
}

impl<const D: usize> Powers<D> {
    fn new(mesh: &Mesh<D>) -> Self {
        let (mut lower, mut upper) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
        for x in mesh.nodes() {
            (lower, upper) = (
                std::array::from_fn(|axis| lower[axis].min(x[axis])),
                std::array::from_fn(|axis| upper[axis].max(x[axis])),
            );
        }
        let half = |sign: f64| std::array::from_fn(|axis| (upper[axis] + sign * lower[axis]) / 2.0);
        Powers { centre: half(1.0), extents: half(-1.0) }
    }

    /// The polar form Q(a, b) of each polynomial q: symmetric, affine in both points, Q(x, x) = q(x).
    fn polar(&self, a: &[f64; D], b: &[f64; D]) -> Vec<f64> {
        let scaled = |x: &[f64; D]| -> [f64; D] {
            std::array::from_fn(|axis| (x[axis] - self.centre[axis]) / self.extents[axis])
        };
        let (a, b) = (scaled(a), scaled(b));
        let linear = (0..D).map(|axis| (a[axis] + b[axis]) / 2.0);
        let quadratic = pairs::<D>().map(|[i, j]| (a[i] * b[j] + a[j] * b[i]) / 2.0);
        std::iter::once(1.0).chain(linear).chain(quadratic).collect()
    }

    /// Their coefficients, in the same order.
    fn data(&self) -> Vec<moments::Data<D>> {
        let unit = |axis: usize| {
            let mut unit = [0.0; D];
            unit[axis] = 1.0 / self.extents[axis];
            unit
        };
        let data = |constant: f64, linear: [f64; D], quadratic: [[f64; D]; D]| {
            moments::data().constant(constant).linear(linear).quadratic(quadratic).centre(self.centre)
        };
        let mut all = vec![data(1.0, [0.0; D], [[0.0; D]; D])];
        all.extend((0..D).map(|axis| data(0.0, unit(axis), [[0.0; D]; D])));
        all.extend(pairs::<D>().map(|[i, j]| {
            let mut quadratic = [[0.0; D]; D];
            quadratic[i] = unit(j).map(|inverse| inverse / self.extents[i]);
            data(0.0, [0.0; D], quadratic)
        }));
        all
    }
}

/// The pairs of axes, each once.
fn pairs<const D: usize>() -> impl Iterator<Item = [usize; 2]> {
    (0..D).flat_map(|i| (i..D).map(move |j| [i, j]))
}

impl<'a, const D: usize> Before<'a, D> {
    #[inline(never)]
    fn new(density: &'a Field<D>, region: &'a str) -> Result<Self, RedistributionError> {
        let space = density.space();
        let mesh = space.mesh();
        if *space.scope() != Scope::Cell
            || *space.elements() != Elements::Lagrange(0)
            || space.components() != 1
        {
            return Err(RedistributionError::NotPerCell);
        }
        let of_cell = |cell| density.values()[space.cell_nodes(cell)[0] as usize];
        let density: Vec<f64> = (0..mesh.cell_count()).map(of_cell).collect();
        let positive = |density: &f64| density.is_finite() && *density > 0.0;
        if let Some(cell) = density.iter().position(|density| !positive(density)) {
            return Err(RedistributionError::Density { cell, density: density[cell] });
        }
        if let Some(hanging) = mesh.conformity().hanging_nodes.first() {
            let (node, position, facet) = (hanging.node as usize, hanging.position.to_vec(), hanging.facet);
            return Err(MeshError::HangingNode { node, position, facet }.into());
        }
        let mut on_boundary = vec![false; mesh.nodes().len()];
        for facet in mesh.facet_region(region)? {
            mesh.facet_vertices(*facet).for_each(|vertex| on_boundary[vertex as usize] = true);
        }
        let touches_it = |cell| mesh.cell_vertices(cell).iter().any(|vertex| on_boundary[*vertex as usize]);
        let touches: Vec<bool> = (0..mesh.cell_count()).map(touches_it).collect();
        if touches.iter().all(|touches| *touches) {
            let (region, cells) = (region.to_owned(), touches.len());
            return Err(RedistributionError::NoCellLeft { region, cells });
        }
        let space = Space::discontinuous_scalar(mesh, 2)?;
        Ok(Before { mesh, region, density, touches, space, powers: Powers::new(mesh) })
    }

    /// The new density, by the moments of the space's basis functions.
    #[inline(never)]
    fn redistribute(&self, weights: &[Vec<f64>]) -> Result<Field<D>, RedistributionError> {
        let (count, positions) = (weights.len(), self.space.positions());
        let mut even = vec![0.0; self.space.unknowns()];
        let mut powers = vec![vec![0.0; self.space.unknowns()]; count];
        for (cell, &touches) in self.touches.iter().enumerate() {
            for &node in self.space.cell_nodes(cell) {
                let (node, density) = (node as usize, self.density[cell]);
                even[node] = density;
                if !touches {
                    let values = self.powers.polar(&positions[node], &positions[node]);
                    powers.iter_mut().zip(values).for_each(|(power, value)| power[node] = density * value);
                }
            }
        }
        let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let sought: Vec<f64> = weights.iter().map(|weights| product(weights, &even)).collect();
        let entries: Vec<_> = (0..count * count)
            .map(|place| (place / count, place % count))
            .map(|(row, column)| (row, column, product(&weights[row], &powers[column])))
            .collect();
        let factor = LuFactor::new(&CsrMatrix::from_triplets(count, count, &entries)?, None)?;
        let (mut coefficients, mut values) = (vec![0.0; count], vec![0.0; even.len()]);
        // Twice: what rounding has left of the moments is distributed, too.
        for _ in 0..2 {
            let left =
                weights.iter().zip(&sought).map(|(weights, sought)| sought - product(weights, &values));
            let mut step: Vec<f64> = left.collect();
            factor.solve_in_place(&mut step, Transpose::No)?;
            for ((coefficient, step), power) in coefficients.iter_mut().zip(&step).zip(&powers) {
                *coefficient += step;
                values.iter_mut().zip(power).for_each(|(value, power)| *value += step * power);
            }
        }
        let (smallest, cell) = self.smallest_factor(&coefficients);
        if smallest.is_nan() || smallest <= 0.0 {
            let (region, factor) = (self.region.to_owned(), smallest);
            return Err(RedistributionError::NotPositive { region, cell, factor });
        }
        Ok(Field::from_values(&self.space, values)?)
    }

    /// A lower bound of the factor in the cells that have mass, and the cell that has it. A point of a straight cell is Σ λ_i v_i with
    /// its vertices v and λ ≥ 0 of sum 1, and the polynomial there Σ λ_i λ_j Q(v_i, v_j).
    fn smallest_factor(&self, coefficients: &[f64]) -> (f64, usize) {
        let mut smallest = (f64::INFINITY, 0);
        for (cell, _) in self.touches.iter().enumerate().filter(|(_, touches)| !**touches) {
            let nodes = self.mesh.cell(cell);
            for (first, a) in nodes.iter().enumerate() {
                for b in &nodes[first..] {
                    let [a, b] = [a, b].map(|node| &self.mesh.nodes()[*node as usize]);
                    let terms = self.powers.polar(a, b).into_iter().zip(coefficients);
                    let factor: f64 = terms.map(|(power, coefficient)| power * coefficient).sum();
                    // A factor that is no number is no positive one.
                    if factor.is_nan() || factor < smallest.0 {
                        smallest = (factor, cell);
                    }
                }
            }
        }
        smallest
    }
}

instantiate!(redistributed_mass: Before::<D>::new, Before::<D>::redistribute);
