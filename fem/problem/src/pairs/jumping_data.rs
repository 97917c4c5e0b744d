//! Data that jump at a surface: functions of position that have another value on it than just inside of its body.
//!
//! A position at which bodies touch is a point of both, and a modulus that is a function of position is that of one of them. Kernels
//! would then have a stress of the surface that is none of its body's, and contact would be that of another problem.

use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::{fmt, ptr};

use forms_core::contract::Side;
use forms_core::source::PositionFunction;

use super::PairError;
use super::newest::keep;
use super::search_key::SearchKey;
use crate::element::CellShape;
use crate::mesh::Mesh;

/// The part of the way from a point of the facet to the cell's centre at which the value inside is taken.
const INSIDE: f64 = 1e-6;

/// A relative difference of values so close to each other that no smooth function has, but near its zeros.
const JUMP: f64 = 1e-3;

/// The change of a function on the first part of the way, as a multiple of that on a second part as long, which only jumps exceed: it
/// is 1 of a smooth function that vanishes on the surface, and 2.4 of a square root.
const AT_ONCE: f64 = 10.0;

/// A function of position that kernels read on pairs.
pub(crate) struct ReadFunction<'a, const D: usize> {
    pub name: &'static str,
    pub side: Side,
    pub components: usize,
    pub function: &'a PositionFunction<D>,
}

/// A function that does not jump on a side of a pairing's surfaces. It is not kept alive, but its address is not given to another one.
struct Smooth<const D: usize> {
    key: SearchKey<D>,
    side: Side,
    function: Weak<Function<D>>,
}

/// See [`PositionFunction`].
type Function<const D: usize> = dyn Fn(&[f64; D], &mut [f64]) + Send + Sync;

/// The points of the rule on a local facet of a shape, in the cell's reference coordinates.
type FacetPoints<const D: usize> = ((CellShape, u8), Vec<[f64; D]>);

/// Functions that were looked at, so that each is looked at once.
pub(super) struct SmoothFunctions<const D: usize>(Mutex<Vec<Smooth<D>>>);

/// Functions that are remembered; the oldest go.
const REMEMBERED: usize = 64;

impl<const D: usize> Default for SmoothFunctions<D> {
    fn default() -> Self {
        SmoothFunctions(Mutex::default())
    }
}

impl<const D: usize> fmt::Debug for SmoothFunctions<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SmoothFunctions")
    }
}

impl<const D: usize> SmoothFunctions<D> {
    /// Check of a function on the surfaces of one side of a pairing, at the points of the rule for whole facets.
    ///
    /// # Errors
    /// [`PairError::Jump`](super::PairError::Jump), or those of the search.
    pub fn check(
        &self,
        mesh: &Mesh<D>,
        key: &SearchKey<D>,
        read: &ReadFunction<'_, D>,
    ) -> Result<(), PairError> {
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_this = |known: &Smooth<D>| {
            known.side == read.side
                && ptr::addr_eq(known.function.as_ptr(), Arc::as_ptr(read.function))
                && known.key == *key
        };
        if lock().iter().any(is_this) {
            return Ok(());
        }
        for facing in &key.pairing.surfaces {
            let surface = match read.side {
                Side::This => &facing.own,
                Side::Other => &facing.opposite,
            };
            check_surface(mesh, surface, key, read)?;
        }
        let function = Arc::downgrade(read.function);
        keep(&mut lock(), Smooth { key: key.clone(), side: read.side, function }, REMEMBERED, |_| true);
        Ok(())
    }
}

fn check_surface<const D: usize>(
    mesh: &Mesh<D>,
    surface: &str,
    SearchKey { quadrature, degree, .. }: &SearchKey<D>,
    read: &ReadFunction<'_, D>,
) -> Result<(), PairError> {
    // A surface that does not exist, or is rigid, is named where pairs are searched for.
    let Ok(facets) = mesh.facets_of_surface(surface) else { return Ok(()) };
    let mut rules: Vec<FacetPoints<D>> = Vec::new();
    let [mut on, mut inside, mut further] = [(); 3].map(|()| vec![0.0; read.components]);
    for facet in facets {
        let cell = facet.cell as usize;
        let key = (mesh.cell_shape(cell), facet.local);
        let place = match rules.iter().position(|(known, _)| *known == key) {
            Some(place) => place,
            None => {
                let rule = quadrature.facet_rule(key.0, usize::from(key.1), *degree);
                let rule = rule.map_err(|source| PairError::Quadrature { source })?;
                rules.push((key, rule.points));
                rules.len() - 1
            }
        };
        let centre = mesh.cell_centre(cell);
        for point in &rules[place].1 {
            let x = mesh.map(cell, point).0;
            let on_the_way = |part: f64| std::array::from_fn(|k| x[k] + part * (centre[k] - x[k]));
            (read.function)(&x, &mut on);
            (read.function)(&on_the_way(INSIDE), &mut inside);
            (read.function)(&on_the_way(2.0 * INSIDE), &mut further);
            let size = on.iter().chain(&inside).fold(0.0_f64, |size, value| size.max(value.abs()));
            let jumps = |k: &usize| {
                let change = (on[*k] - inside[*k]).abs();
                change > JUMP * size && change > AT_ONCE * (inside[*k] - further[*k]).abs()
            };
            if let Some(component) = (0..read.components).find(jumps) {
                return Err(PairError::Jump {
                    field: read.name,
                    surface: surface.to_owned(),
                    position: x.to_vec(),
                    values: [on[component], inside[component]],
                });
            }
        }
    }
    Ok(())
}
