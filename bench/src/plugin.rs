//! The C side of a kernel: pointers to slices.

use forms_fem::contract::{Form, Role};

use crate::basix::node_count;
use crate::element_batch::{Coefficients, Output, Setting, run};

/// Number of constants that the harness passes.
pub const CONSTANTS: usize = 3;

/// Components of a form's unknown.
pub fn components<const D: usize>(form: &impl Form<D>) -> usize {
    let unknown = form.fields().iter().find(|field| matches!(field.role, Role::Unknown(_)));
    unknown.map_or(1, |field| field.components())
}

/// Turns the arguments of a plugin symbol to slices and runs the kernel; says on standard error what failed.
///
/// # Safety
/// As the plugin interface has it: A holds n element matrices, w and x the coefficients and coordinates of n cells,
/// c three constants, entity the local facet (unless null).
#[allow(clippy::too_many_arguments)]
pub unsafe fn call<const D: usize, const GEOMETRY_NODES: usize, const NODES: usize, F: Form<D>>(
    setting: &Setting,
    form: impl Fn(&[f64], &Coefficients<D>) -> F,
    n: i32,
    a: *mut f64,
    w: *const f64,
    c: *const f64,
    x: *const f64,
    entity: *const i32,
) {
    let count = n as usize;
    // SAFETY: the caller's contract.
    let c = unsafe { std::slice::from_raw_parts(c, CONSTANTS) };
    let probe = form(c, &Coefficients::none());
    let components = components(&probe);
    let rows = NODES * components;
    let size = if setting.output == Output::Tangent { rows * rows } else { rows };
    let width: usize = setting
        .coefficients
        .iter()
        .enumerate()
        .map(|(index, degree)| node_count(setting.shape, *degree) * if index == 0 { components } else { 1 })
        .sum();
    // SAFETY: the caller's contract.
    let (a, w, x, facet) = unsafe {
        (
            std::slice::from_raw_parts_mut(a, count * size),
            if width == 0 { &[] } else { std::slice::from_raw_parts(w, count * width) },
            std::slice::from_raw_parts(x, count * GEOMETRY_NODES * 3),
            if entity.is_null() { 0 } else { *entity as usize },
        )
    };
    let bound = |w: &Coefficients<D>| form(c, w);
    if let Err(error) = run::<D, GEOMETRY_NODES, NODES, F>(setting, bound, count, a, w, x, facet) {
        eprintln!("{error}");
        a.fill(f64::NAN);
    }
}
