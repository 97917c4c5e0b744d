//! The macro that makes an entry of the basket, with its symbol for the harness, from one line.

use crate::basix::node_count;
use crate::element_batch::{Output, Setting};

/// A kernel of the basket.
#[derive(Clone, Copy)]
pub struct Entry {
    /// The form's name in `peers/basket.py`.
    pub name: &'static str,
    /// Its element and rule.
    pub setting: Setting,
    /// Components of the unknown.
    pub components: fn() -> usize,
    /// The symbol `batch_<name>`.
    pub batch: Batch,
}

impl Entry {
    /// Number of coefficients w per cell.
    pub fn width(&self) -> usize {
        let Setting { shape, coefficients, .. } = self.setting;
        let components = (self.components)();
        let each = coefficients.iter().enumerate();
        each.map(|(index, degree)| node_count(shape, *degree) * if index == 0 { components } else { 1 }).sum()
    }

    /// Number of entries of an element vector or matrix.
    pub fn size(&self) -> usize {
        let rows = node_count(self.setting.shape, self.setting.degree) * (self.components)();
        if self.setting.output == Output::Tangent { rows * rows } else { rows }
    }
}

/// `batch_<form>(n, A, w, c, x, entity)` of the plugin interface in `peers/README.md`.
pub type Batch = unsafe extern "C" fn(i32, *mut f64, *const f64, *const f64, *const f64, *const i32);

/// Registers kernels, one line each:
///
/// ```text
/// name: tangent or residual, shape, degree, geometry degree, rule degree, [degrees of coefficients], node order, form;
/// ```
///
/// `form` is an expression that may use the constants `c[0]`, `c[1]`, … and the coefficients `w.scalar(1)`, …
#[macro_export]
macro_rules! register {
    (|$c:ident, $w:ident| $(
        $name:ident: $output:ident, $shape:ident, $degree:literal, $geometry:literal, $rule:literal, $coefficients:expr,
        $order:ident, $form:expr;
    )*) => {
        /// All kernels of the basket.
        pub const BASKET: &[$crate::register::Entry] = &[$({
            use $crate::element_batch::{Coefficients, Setting};
            const SETTING: Setting = Setting {
                output: $crate::element_batch::Output::$output,
                shape: forms_fem::element::CellShape::$shape,
                degree: $degree,
                geometry: $geometry,
                rule: $rule,
                coefficients: &$coefficients,
                order: $crate::basix::NodeOrder::$order,
            };
            const D: usize = $crate::basix::dimension(SETTING.shape);
            const GEOMETRY_NODES: usize = $crate::basix::node_count(SETTING.shape, $geometry);
            const NODES: usize = $crate::basix::node_count(SETTING.shape, $degree);
            #[allow(unused_variables)]
            fn form($c: &[f64], $w: &Coefficients<D>) -> impl forms_fem::contract::Form<D> + use<> {
                $form
            }
            // SAFETY: the symbol is this kernel's alone, for the names in a basket differ.
            #[unsafe(export_name = concat!("batch_", stringify!($name)))]
            unsafe extern "C" fn batch(
                n: i32, a: *mut f64, w: *const f64, c: *const f64, x: *const f64, entity: *const i32,
            ) {
                // SAFETY: the plugin interface, which is this function's contract.
                unsafe {
                    $crate::plugin::call::<D, GEOMETRY_NODES, NODES, _>(&SETTING, form, n, a, w, c, x, entity);
                }
            }
            fn components() -> usize {
                $crate::plugin::components(&form(&[0.0; $crate::plugin::CONSTANTS], &Coefficients::none()))
            }
            $crate::register::Entry { name: stringify!($name), setting: SETTING, components, batch }
        },)*];
    };
}
