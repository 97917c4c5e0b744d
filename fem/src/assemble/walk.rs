//! The order in which a region is walked: groups of entities that share tables, in batches of lanes.
//! Facets group by their local number, because their points lie elsewhere in the reference cell.

use std::collections::BTreeMap;

use forms_core::contract::{Integral, Requirements};

use super::AssemblyError;
use super::binding::{Binding, Entities};
use crate::element::{Lagrange, Tables};
use crate::mesh::Mesh;
use crate::quadrature::{FacetRule, Quadrature, cell_rule, facet_rule};

/// Entities with the same points in the reference cell.
pub(super) struct Group<const D: usize> {
    /// Cells, or the cells that own the facets.
    pub cells: Vec<u32>,
    /// Local facet number and reference tangents; `None` inside cells.
    pub facet: Option<(u8, [[f64; D]; 2])>,
    pub weights: Vec<f64>,
    /// The geometry map's basis.
    pub geometry: Tables<D>,
    /// One table per element of the binding.
    pub elements: Vec<Tables<D>>,
    /// Second derivatives of the geometry map's basis along the facet's tangents, for the curvature:
    /// [t₀t₀, t₀t₁, t₁t₁] at `q * nodes + i`.
    pub bending: Vec<[f64; 3]>,
    /// For |T| and |F|: a rule that is exact for the measure of every cell of the mesh.
    pub measure: Measure<D>,
}

/// Tables that integrate 1 over a cell and a facet.
pub(super) struct Measure<const D: usize> {
    pub cell: Tables<D>,
    pub cell_weights: Vec<f64>,
    pub facet: Option<(Tables<D>, Vec<f64>)>,
}

impl<const D: usize> Group<D> {
    fn inside_cells(
        binding: &Binding<D>,
        cells: Vec<u32>,
        quadrature: &Quadrature<D>,
        degree: usize,
    ) -> Result<Self, AssemblyError> {
        let mesh = binding.mesh;
        let form = binding.name;
        let rule = quadrature
            .cell_rule(mesh.shape(), degree)
            .map_err(|source| AssemblyError::Quadrature { form, source })?;
        Group::new(mesh, &binding.elements, cells, &rule.points, rule.weights, None)
            .map_err(|source| AssemblyError::Quadrature { form, source })
    }

    fn on_facets(
        binding: &Binding<D>,
        local: u8,
        cells: Vec<u32>,
        quadrature: &Quadrature<D>,
        degree: usize,
    ) -> Result<Self, AssemblyError> {
        let mesh = binding.mesh;
        let form = binding.name;
        let rule = quadrature
            .facet_rule(mesh.shape(), usize::from(local), degree)
            .map_err(|source| AssemblyError::Quadrature { form, source })?;
        let FacetRule { points, weights, tangents } = rule;
        Group::new(mesh, &binding.elements, cells, &points, weights, Some((local, tangents)))
            .map_err(|source| AssemblyError::Quadrature { form, source })
    }

    /// A group at given reference points; weights may be of any kind.
    pub fn new(
        mesh: &Mesh<D>,
        elements: &[Lagrange],
        cells: Vec<u32>,
        points: &[[f64; D]],
        weights: Vec<f64>,
        facet: Option<(u8, [[f64; D]; 2])>,
    ) -> Result<Self, crate::quadrature::QuadratureError> {
        let geometry = mesh.element();
        // The Jacobian's determinant has at most this degree in each direction.
        let exact = D * mesh.degree();
        let rule = cell_rule::<D>(mesh.shape(), exact)?;
        let facet_measure = match facet {
            Some((local, _)) => {
                let rule = facet_rule::<D>(mesh.shape(), usize::from(local), exact + 6)?;
                Some((geometry.tabulate(&rule.points), rule.weights))
            }
            None => None,
        };
        let bending = match facet {
            Some((_, tangents)) if mesh.degree() > 1 => bending(&geometry, points, &tangents),
            _ => vec![],
        };
        Ok(Group {
            cells,
            facet,
            weights,
            geometry: geometry.tabulate(points),
            elements: elements.iter().map(|element| element.tabulate(points)).collect(),
            bending,
            measure: Measure {
                cell: geometry.tabulate(&rule.points),
                cell_weights: rule.weights,
                facet: facet_measure,
            },
        })
    }

    pub fn points(&self) -> usize {
        self.weights.len()
    }
}

/// The groups of an integral's region; where the compiler's estimate of the quadrature degree is wanted,
/// it is made from the degrees of the form's fields. A kernel that reads a history takes the history's degree.
pub(super) fn groups<const D: usize>(
    binding: &Binding<D>,
    integral: &Integral,
    quadrature: &Quadrature<D>,
    degrees: &[usize],
    requirements: &Requirements,
) -> Result<Vec<Group<D>>, AssemblyError> {
    let mesh = binding.mesh;
    let degree = match binding.history_degree(requirements, quadrature)? {
        Some((_, degree)) => degree,
        None => (integral.degree)(degrees, mesh.degree(), mesh.shape().is_simplex()),
    };
    match binding.entities(integral.region)? {
        Entities::Cells(cells) => Ok(vec![Group::inside_cells(binding, cells.to_vec(), quadrature, degree)?]),
        Entities::Facets(facets) => {
            let mut by_local: BTreeMap<u8, Vec<u32>> = BTreeMap::new();
            for facet in facets {
                by_local.entry(facet.local).or_default().push(facet.cell);
            }
            by_local
                .into_iter()
                .map(|(local, cells)| Group::on_facets(binding, local, cells, quadrature, degree))
                .collect()
        }
    }
}

/// Second derivatives along the tangents by central differences of the gradient: along a facet a basis
/// function of degree two is at most quadratic in each facet coordinate, so they are exact.
fn bending<const D: usize>(
    element: &Lagrange,
    points: &[[f64; D]],
    tangents: &[[f64; D]; 2],
) -> Vec<[f64; 3]> {
    const STEP: f64 = 0.25;
    let shifted = |tangent: &[f64; D], sign: f64| {
        let move_point = |point: &[f64; D]| std::array::from_fn(|k| point[k] + sign * STEP * tangent[k]);
        element.tabulate::<D>(&points.iter().map(move_point).collect::<Vec<_>>())
    };
    let along = |gradient: &[f64; D], tangent: &[f64; D]| -> f64 {
        gradient.iter().zip(tangent).map(|(g, t)| g * t).sum()
    };
    let tables = [0, 1].map(|axis| [shifted(&tangents[axis], 1.0), shifted(&tangents[axis], -1.0)]);
    let second = |entry: usize, first: usize, axis: usize| {
        let [plus, minus] = &tables[axis];
        (along(&plus.gradient[entry], &tangents[first]) - along(&minus.gradient[entry], &tangents[first]))
            / (2.0 * STEP)
    };
    (0..points.len() * element.nodes())
        .map(|entry| [second(entry, 0, 0), second(entry, 0, 1), second(entry, 1, 1)])
        .collect()
}
