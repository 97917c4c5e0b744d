//! Functions with C's calling convention over plain arrays. C's side of them is `include/forms.h`, which says what each does.
//!
//! No panic reaches C. Functions that return a number return 0 on success; otherwise [`last_error`] has the message.

#![allow(unsafe_code)]

use std::cell::RefCell;
use std::error::Error;
use std::ffi::{CStr, CString, c_char, c_int};

use forms_fem::inverse::{DifferentiableMap, Part};

use crate::parameters::Parameters;
use crate::problem_thread::{Failure, ProblemThread, caught};

/// The problem behind C's pointer.
pub struct Handle {
    problem: ProblemThread,
    inputs: Vec<CString>,
    outputs: Vec<CString>,
}

thread_local! {
    /// Message of the last failure of a call from this thread.
    static LAST_ERROR: RefCell<CString> = RefCell::default();
}

/// A text for C, which ends at its first zero byte.
fn text(words: &str) -> CString {
    let words = words.split('\0').next().unwrap_or("");
    CString::new(words).unwrap_or_default()
}

/// Runs a call, and keeps the message of a failure.
fn status(call: impl FnOnce() -> Result<(), Failure>) -> c_int {
    let Err(why) = caught(call) else { return 0 };
    LAST_ERROR.with(|last| *last.borrow_mut() = text(&why.to_string()));
    1
}

fn missing(what: &str) -> Failure {
    Failure::Input(format!("the pointer to {what} is null"))
}

/// # Safety
/// A pointer that is not null points to the given number of values, which nothing writes during the call.
unsafe fn array<'a, T>(what: &str, from: *const T, length: usize) -> Result<&'a [T], Failure> {
    match (from.is_null(), length) {
        (_, 0) => Ok(&[]),
        (true, _) => Err(missing(what)),
        // SAFETY: the caller says that there are as many values.
        (false, length) => Ok(unsafe { std::slice::from_raw_parts(from, length) }),
    }
}

/// # Safety
/// A pointer that is not null points to room for the given number of values.
unsafe fn give(what: &str, values: &[f64], to: *mut f64, length: usize) -> Result<(), Failure> {
    if values.len() != length {
        let expected = values.len();
        return Err(Failure::Input(format!(
            "the {what} has {expected} values, and there is room for {length}"
        )));
    }
    if to.is_null() && length > 0 {
        return Err(missing(&format!("the {what}")));
    }
    // SAFETY: the caller guarantees memory for the values. It does not overlap `values`, which this library owns.
    unsafe { std::ptr::copy_nonoverlapping(values.as_ptr(), to, length) };
    Ok(())
}

/// # Safety
/// A pointer that is not null is one to a place for a value.
unsafe fn put<T>(what: &str, value: T, to: *mut T) -> Result<(), Failure> {
    if to.is_null() {
        return Err(missing(what));
    }
    // SAFETY: the caller guarantees memory for a value. Its earlier content is not read.
    unsafe { to.write(value) };
    Ok(())
}

/// # Safety
/// A pointer that is not null is one that [`open`] gave and [`close`] has not taken.
unsafe fn handle<'a>(problem: *const Handle) -> Result<&'a Handle, Failure> {
    // SAFETY: the caller says so.
    unsafe { problem.as_ref() }.ok_or_else(|| missing("the problem"))
}

/// Message of the last failure of a call from this thread; the text lives until the next failure in the thread.
pub fn last_error() -> *const c_char {
    LAST_ERROR.with(|last| last.borrow().as_ptr())
}

/// Makes a problem of named numbers.
///
/// # Safety
/// `names` and `values` are arrays of `count` entries, the names texts that end with a zero; `problem` is a place for a pointer.
pub unsafe fn open<M: DifferentiableMap + 'static>(
    constructor: fn(&mut Parameters) -> Result<M, Box<dyn Error>>,
    (names, values, count): (*const *const c_char, *const f64, usize),
    problem: *mut *mut Handle,
) -> c_int {
    status(|| {
        // SAFETY: the caller guarantees that both pointers lead to `count` values, as `array` requires.
        let (names, values) =
            unsafe { (array("the names", names, count)?, array("the values", values, count)?) };
        let mut given = vec![];
        for (name, value) in names.iter().zip(values) {
            if name.is_null() {
                return Err(missing("a name"));
            }
            // SAFETY: the caller says that names end with a zero.
            let name = unsafe { CStr::from_ptr(*name) };
            given.push((name.to_string_lossy().into_owned(), *value));
        }
        if problem.is_null() {
            return Err(missing("the place for the problem"));
        }
        let parameters = Parameters::new(given).map_err(|why| Failure::Input(why.to_string()))?;
        let opened = ProblemThread::open(constructor, parameters)?;
        let names = |parts: &[Part]| parts.iter().map(|part| text(&part.name)).collect();
        let (inputs, outputs) = (names(opened.inputs()), names(opened.outputs()));
        let handle = Box::into_raw(Box::new(Handle { problem: opened, inputs, outputs }));
        // SAFETY: the caller guarantees memory for a pointer.
        unsafe { put("the place for the problem", handle, problem) }
    })
}

/// Ends a problem.
///
/// # Safety
/// A pointer that is not null is one that [`open`] gave; it is not used any more.
pub unsafe fn close(problem: *mut Handle) {
    status(|| {
        if !problem.is_null() {
            // SAFETY: it was made by `Box::into_raw` in `open`, and the caller gives it up.
            drop(unsafe { Box::from_raw(problem) });
        }
        Ok(())
    });
}

/// Side of a map.
#[derive(Clone, Copy, Debug)]
pub enum Side {
    /// Its controls.
    Inputs,
    /// Its outputs.
    Outputs,
}

/// Number of parts of a side, the inputs or the outputs, and number of their values.
///
/// # Safety
/// The problem is one that [`open`] gave, the others are places for numbers.
pub unsafe fn sizes(problem: *const Handle, side: Side, parts: *mut usize, values: *mut usize) -> c_int {
    status(|| {
        // SAFETY: the caller's promise.
        let (of, _) = unsafe { handle(problem) }?.side(side);
        // SAFETY: as well.
        unsafe {
            put("the place for the number of parts", of.len(), parts)?;
            put("the place for the number of values", of.iter().map(|part| part.length).sum(), values)
        }
    })
}

/// The name of a part of a side, which lives as long as the problem, and the number of its values.
///
/// # Safety
/// As [`sizes`].
pub unsafe fn part(
    problem: *const Handle,
    side: Side,
    index: usize,
    name: *mut *const c_char,
    values: *mut usize,
) -> c_int {
    status(|| {
        // SAFETY: the caller's promise.
        let (of, names) = unsafe { handle(problem) }?.side(side);
        let (Some(part), Some(known)) = (of.get(index), names.get(index)) else {
            let count = of.len();
            return Err(Failure::Input(format!("there is no part {index} of {side:?}, which are {count}")));
        };
        // SAFETY: as well.
        unsafe {
            put("the place for the name", known.as_ptr(), name)?;
            put("the place for the number of values", part.length, values)
        }
    })
}

impl Handle {
    fn side(&self, side: Side) -> (&[Part], &[CString]) {
        match side {
            Side::Inputs => (self.problem.inputs(), &self.inputs),
            Side::Outputs => (self.problem.outputs(), &self.outputs),
        }
    }
}

/// The controls to begin with.
///
/// # Safety
/// The problem is one that [`open`] gave; `m` is room for `length` values.
pub unsafe fn start(problem: *const Handle, m: *mut f64, length: usize) -> c_int {
    // SAFETY: the caller's promise.
    status(|| unsafe { give("start", handle(problem)?.problem.start(), m, length) })
}

/// F(m).
///
/// # Safety
/// The problem is one that [`open`] gave; pointers are to the given numbers of values, the last to room for them.
pub unsafe fn value(
    problem: *const Handle,
    (m, m_length): (*const f64, usize),
    (value, value_length): (*mut f64, usize),
) -> c_int {
    status(|| {
        // SAFETY: the caller's promise.
        let (problem, m) = unsafe { (handle(problem)?, array("the controls", m, m_length)?) };
        let found = problem.problem.value(m.to_vec())?;
        // SAFETY: as well.
        unsafe { give("value", &found, value, value_length) }
    })
}

/// Product of Jacobian and vector.
#[derive(Clone, Copy, Debug)]
pub enum Product {
    /// F′(m)ᵀ w.
    Vjp,
    /// F′(m) δ.
    Jvp,
}

/// A product of F′(m) and a vector.
///
/// # Safety
/// As [`value`].
pub unsafe fn product(
    problem: *const Handle,
    which: Product,
    (m, m_length): (*const f64, usize),
    (vector, vector_length): (*const f64, usize),
    (product, product_length): (*mut f64, usize),
) -> c_int {
    status(|| {
        // SAFETY: the caller's promise.
        let (problem, m) =
            unsafe { (&handle(problem)?.problem, array("the controls", m, m_length)?.to_vec()) };
        // SAFETY: as well.
        let vector = unsafe { array("the vector", vector, vector_length)?.to_vec() };
        let found = match which {
            Product::Vjp => problem.vjp(m, vector)?,
            Product::Jvp => problem.jvp(m, vector)?,
        };
        // SAFETY: as well.
        unsafe { give("product", &found, product, product_length) }
    })
}

/// Exports a problem to C, as the functions that `FORMS_PROBLEM(name)` of `forms.h` declares. The constructor is a
/// `fn(&mut Parameters) -> Result<impl DifferentiableMap, Box<dyn Error>>`.
#[macro_export]
macro_rules! export_c {
    ($name:ident, $constructor:path) => {
        // Each of them hands its arguments on as they come: what C has to promise is said in forms.h and asked for by what is
        // called. Names are exported as the linker sees them, which is unsafe where another item has the same.
        const _: () = {
            use std::ffi::{c_char, c_int};
            use $crate::c_interface::{Handle, Product, Side};

            #[unsafe(export_name = concat!(stringify!($name), "_open"))]
            unsafe extern "C" fn open(
                names: *const *const c_char,
                values: *const f64,
                count: usize,
                problem: *mut *mut Handle,
            ) -> c_int {
                // SAFETY: C's promise.
                unsafe { $crate::c_interface::open($constructor, (names, values, count), problem) }
            }
            #[unsafe(export_name = concat!(stringify!($name), "_close"))]
            unsafe extern "C" fn close(problem: *mut Handle) {
                // SAFETY: C's promise.
                unsafe { $crate::c_interface::close(problem) }
            }
            #[unsafe(export_name = concat!(stringify!($name), "_last_error"))]
            extern "C" fn last_error() -> *const c_char {
                $crate::c_interface::last_error()
            }
            #[unsafe(export_name = concat!(stringify!($name), "_inputs"))]
            unsafe extern "C" fn inputs(
                problem: *const Handle,
                parts: *mut usize,
                values: *mut usize,
            ) -> c_int {
                // SAFETY: C's promise.
                unsafe { $crate::c_interface::sizes(problem, Side::Inputs, parts, values) }
            }
            #[unsafe(export_name = concat!(stringify!($name), "_outputs"))]
            unsafe extern "C" fn outputs(
                problem: *const Handle,
                parts: *mut usize,
                values: *mut usize,
            ) -> c_int {
                // SAFETY: C's promise.
                unsafe { $crate::c_interface::sizes(problem, Side::Outputs, parts, values) }
            }
            #[unsafe(export_name = concat!(stringify!($name), "_input"))]
            unsafe extern "C" fn input(
                problem: *const Handle,
                index: usize,
                name: *mut *const c_char,
                values: *mut usize,
            ) -> c_int {
                // SAFETY: C's promise.
                unsafe { $crate::c_interface::part(problem, Side::Inputs, index, name, values) }
            }
            #[unsafe(export_name = concat!(stringify!($name), "_output"))]
            unsafe extern "C" fn output(
                problem: *const Handle,
                index: usize,
                name: *mut *const c_char,
                values: *mut usize,
            ) -> c_int {
                // SAFETY: C's promise.
                unsafe { $crate::c_interface::part(problem, Side::Outputs, index, name, values) }
            }
            #[unsafe(export_name = concat!(stringify!($name), "_start"))]
            unsafe extern "C" fn start(problem: *const Handle, m: *mut f64, length: usize) -> c_int {
                // SAFETY: C's promise.
                unsafe { $crate::c_interface::start(problem, m, length) }
            }
            #[unsafe(export_name = concat!(stringify!($name), "_value"))]
            unsafe extern "C" fn value(
                problem: *const Handle,
                m: *const f64,
                m_length: usize,
                value: *mut f64,
                value_length: usize,
            ) -> c_int {
                // SAFETY: C's promise.
                unsafe { $crate::c_interface::value(problem, (m, m_length), (value, value_length)) }
            }
            #[unsafe(export_name = concat!(stringify!($name), "_vjp"))]
            unsafe extern "C" fn vjp(
                problem: *const Handle,
                m: *const f64,
                m_length: usize,
                cotangent: *const f64,
                cotangent_length: usize,
                product: *mut f64,
                product_length: usize,
            ) -> c_int {
                let (vector, found) = ((cotangent, cotangent_length), (product, product_length));
                // SAFETY: C's promise.
                unsafe { $crate::c_interface::product(problem, Product::Vjp, (m, m_length), vector, found) }
            }
            #[unsafe(export_name = concat!(stringify!($name), "_jvp"))]
            unsafe extern "C" fn jvp(
                problem: *const Handle,
                m: *const f64,
                m_length: usize,
                direction: *const f64,
                direction_length: usize,
                product: *mut f64,
                product_length: usize,
            ) -> c_int {
                let (vector, found) = ((direction, direction_length), (product, product_length));
                // SAFETY: C's promise.
                unsafe { $crate::c_interface::product(problem, Product::Jvp, (m, m_length), vector, found) }
            }
        };
    };
}
