//! The C side of a kernel: pointers to slices, and the kernel that each thread has prepared.

#![allow(unsafe_code)]

use std::cell::RefCell;

use forms_fem::assemble::{AssemblyError, ElementCells};

use crate::element_batch::{Batch, BatchError};

/// Number of constants that the harness passes.
pub const CONSTANTS: usize = 3;

/// Numbers per cell in a batch's arrays, and the numbers of facets.
#[derive(Clone, Copy, Debug)]
pub struct Lengths {
    /// Of A.
    pub size: usize,
    /// Of w.
    pub width: usize,
    /// Of x.
    pub coordinates: usize,
    /// Our numbers of basix's facets; zero of those that the shape does not have.
    pub facets: [usize; 6],
}

/// A kernel for certain constants, which it holds.
pub struct Ready {
    constants: [f64; CONSTANTS],
    lengths: Lengths,
    batch: Box<dyn Batch>,
}

/// State of a thread between the calls of one symbol.
pub type Kept = RefCell<Option<Ready>>;

/// Prepares a kernel for constants.
pub type Prepare = fn(&[f64; CONSTANTS]) -> Result<(Lengths, Box<dyn Batch>), BatchError>;

/// Runs the kernel of a symbol; says on standard error what failed, and fills A with NaN.
///
/// # Safety
/// As the plugin interface has it: A holds n element matrices, w and x the coefficients and coordinates of n cells,
/// c three constants, entity the local facet (unless null).
#[allow(clippy::too_many_arguments)]
#[inline(always)]
pub unsafe fn call(
    kept: &Kept,
    prepare: Prepare,
    n: i32,
    a: *mut f64,
    w: *const f64,
    c: *const f64,
    x: *const f64,
    entity: *const i32,
) {
    // SAFETY: the caller's contract.
    let constants = unsafe { *c.cast::<[f64; CONSTANTS]>() };
    let mut kept = kept.borrow_mut();
    let ready = match &mut *kept {
        Some(ready) if same(&ready.constants, &constants) => ready,
        kept => match make_ready(prepare, constants) {
            Some(ready) => kept.insert(ready),
            None => return,
        },
    };
    let count = n as usize;
    let Lengths { size, width, coordinates, facets } = &ready.lengths;
    let (size, width, coordinates) = (*size, *width, *coordinates);
    // SAFETY: the caller's contract; `width` is zero where w may be null.
    let (results, cells) = unsafe {
        let coefficients = if width == 0 { &[] } else { std::slice::from_raw_parts(w, count * width) };
        let cells = ElementCells {
            count,
            coordinates: std::slice::from_raw_parts(x, count * coordinates),
            coefficients,
            // The kernel itself refuses a facet that there is not.
            facet: if entity.is_null() {
                0
            } else {
                facets.get(*entity as usize).copied().unwrap_or(usize::MAX)
            },
        };
        (std::slice::from_raw_parts_mut(a, count * size), cells)
    };
    if let Err(error) = ready.batch.run(&cells, results) {
        failed(&error, results);
    }
}

/// Whether constants are the same to the last bit, decided once for all.
#[inline(always)]
fn same(a: &[f64; CONSTANTS], b: &[f64; CONSTANTS]) -> bool {
    let mut different = 0;
    for k in 0..CONSTANTS {
        different |= a[k].to_bits() ^ b[k].to_bits();
    }
    different == 0
}

#[cold]
#[inline(never)]
fn make_ready(prepare: Prepare, constants: [f64; CONSTANTS]) -> Option<Ready> {
    match prepare(&constants) {
        Ok((lengths, batch)) => Some(Ready { constants, lengths, batch }),
        Err(error) => {
            forms_fem::output::tell(error);
            None
        }
    }
}

#[cold]
#[inline(never)]
fn failed(error: &AssemblyError, results: &mut [f64]) {
    forms_fem::output::tell(error);
    results.fill(f64::NAN);
}
