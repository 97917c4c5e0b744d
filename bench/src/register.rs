//! The macro that makes a kernel of the basket, with its symbol for the harness, from one line.

#![allow(unsafe_code)]

use crate::element_batch::Setting;
use crate::plugin::Lengths;
use crate::random_cells::{BATCH, RandomCells};

/// A kernel of the basket.
#[derive(Clone, Copy)]
pub struct Entry {
    /// The form's name in `peers/basket.py`.
    pub name: &'static str,
    /// Its elements and rule.
    pub setting: Setting,
    /// Numbers per cell in the arrays of a call.
    pub lengths: fn() -> Lengths,
    /// The symbol `batch_<name>`.
    pub batch: Batch,
}

/// A kernel with input and room for its results: a call for one batch of the harness's cells, which are in the cache.
pub struct PreparedCall {
    entry: Entry,
    cells: RandomCells,
    results: Vec<f64>,
}

impl Entry {
    /// A call for [`BATCH`] of the harness's cells.
    pub fn prepare(&self) -> PreparedCall {
        let lengths = (self.lengths)();
        let cells = RandomCells::new(&self.setting, lengths.width);
        PreparedCall { entry: *self, cells, results: vec![0.0; BATCH * lengths.size] }
    }
}

impl PreparedCall {
    /// Element matrices or vectors, cell after cell.
    pub fn run(&mut self) -> &mut [f64] {
        // SAFETY: the arrays are as long as the plugin interface has them for this form.
        unsafe {
            (self.entry.batch)(
                BATCH as i32,
                self.results.as_mut_ptr(),
                self.cells.coefficients.as_ptr(),
                self.cells.constants.as_ptr(),
                self.cells.coordinates.as_ptr(),
                &0,
            );
        }
        &mut self.results
    }
}

/// `batch_<form>(n, A, w, c, x, entity)` of the plugin interface in `peers/README.md`.
pub type Batch = unsafe extern "C" fn(i32, *mut f64, *const f64, *const f64, *const f64, *const i32);

/// Registers kernels, one line each; `c` in `form` is the list of constants.
///
/// ```text
/// name: Tangent|Residual of Cells|Facets, shape, degree d, geometry d, rule d, [("field", degree), ..], Entities|TensorProduct, form;
/// ```
#[macro_export]
macro_rules! register {
    (|$c:ident| $(
        $name:ident: $output:ident of $entities:ident, $shape:ident, degree $degree:literal, geometry $geometry:literal,
        rule $rule:literal, $fields:expr, $order:ident, $form:expr;
    )*) => {
        /// All kernels of the basket.
        pub const BASKET: &[$crate::register::Entry] = &[$({
            use $crate::basix::{NodeOrder, dimension, node_count};
            use $crate::basix::Entities;
            use $crate::element_batch::{Batch, BatchError, Output, Setting, prepare, test_components};
            use $crate::plugin::{CONSTANTS, Kept, Lengths, call};
            const SETTING: Setting = Setting {
                output: Output::$output,
                entities: Entities::$entities,
                shape: forms_fem::element::CellShape::$shape,
                degree: $degree,
                geometry: $geometry,
                rule: $rule,
                fields: &$fields,
                order: NodeOrder::$order,
            };
            const D: usize = dimension(SETTING.shape);
            // Loops have constant lengths where speed matters; where it does not, kernels of a form share their code.
            #[cfg(not(debug_assertions))]
            type Sizes = forms_fem::assemble::Fixed<
                { node_count(SETTING.shape, $degree) },
                { $crate::basix::point_count(SETTING.shape, $rule, SETTING.entities) },
                { node_count(SETTING.shape, $geometry) },
            >;
            #[cfg(debug_assertions)]
            type Sizes = forms_fem::assemble::Counted;
            #[allow(unused_variables)]
            fn form($c: &[f64; CONSTANTS]) -> impl $crate::forms::given::WithIntegrals<D> + use<> {
                $form
            }
            fn lengths() -> Lengths {
                let typed = form(&[1.0; CONSTANTS]);
                let form = $crate::forms::given::WithIntegrals::form(&typed);
                let rows = node_count(SETTING.shape, $degree) * test_components(form);
                Lengths {
                    size: if SETTING.output == Output::Tangent { rows * rows } else { rows },
                    width: SETTING.coefficients(form).1,
                    coordinates: 3 * node_count(SETTING.shape, $geometry),
                    facets: $crate::basix::our_facets(SETTING.shape),
                }
            }
            fn ready(constants: &[f64; CONSTANTS]) -> Result<(Lengths, Box<dyn Batch>), BatchError> {
                Ok((lengths(), prepare::<_, Sizes, D>(&SETTING, &form(constants))?))
            }
            // SAFETY: the symbol is this kernel's alone, for the names in a basket differ.
            #[allow(unsafe_code)]
            #[unsafe(export_name = concat!("batch_", stringify!($name)))]
            unsafe extern "C" fn batch(
                n: i32, a: *mut f64, w: *const f64, c: *const f64, x: *const f64, entity: *const i32,
            ) {
                thread_local! {
                    static KEPT: Kept = const { Kept::new(None) };
                }
                // Called outside of the closure, which the compiler does not inline and which takes its arguments from memory.
                let kept = KEPT.with(std::ptr::from_ref);
                // SAFETY: a thread's value lives as long as the thread; the rest is the plugin interface, which is this
                // function's contract.
                unsafe { call(&*kept, ready, n, a, w, c, x, entity) };
            }
            $crate::register::Entry { name: stringify!($name), setting: SETTING, lengths, batch }
        },)*];
    };
}
