//! The class `Problem` of a Python module: NumPy arrays in and out by the buffer protocol, and Python's lock released while a problem is
//! solved.

use std::error::Error;
use std::ffi::{CStr, CString};

use forms_fem::inverse::{DifferentiableMap, Part};
use pyo3::buffer::PyBuffer;
use pyo3::exceptions::{PyOverflowError, PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBool, PyCFunction, PyComplex, PyDict, PyTuple};

use crate::parameters::Parameters;
use crate::problem_thread::{Failure, ProblemThread};

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Input(why) => PyValueError::new_err(why),
            failure => PyRuntimeError::new_err(failure.to_string()),
        }
    }
}

/// A map F from controls m to outputs, with products of its Jacobian and vectors. Vectors are contiguous NumPy arrays of float64.
#[pyclass(frozen, module = "forms_bindings")]
pub struct Problem {
    problem: ProblemThread,
}

#[pymethods]
impl Problem {
    /// The controls by name, each with its number of values, in their order in m.
    #[getter]
    fn inputs(&self) -> Vec<(String, usize)> {
        named(self.problem.inputs())
    }

    /// The outputs by name, each with its number of values, in their order in F(m).
    #[getter]
    fn outputs(&self) -> Vec<(String, usize)> {
        named(self.problem.outputs())
    }

    /// The controls to begin with.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let start = self.problem.start();
        array(py, start, (start.len(),))
    }

    /// F(m).
    fn value<'py>(&self, py: Python<'py>, m: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let m = vector("vector of controls", m)?;
        let found = py.detach(|| self.problem.value(m))?;
        array(py, &found, (found.len(),))
    }

    /// The number F(m) and its gradient, of a problem with one output: what scipy.optimize.minimize takes with jac=True.
    fn value_and_gradient<'py>(
        &self,
        py: Python<'py>,
        m: &Bound<'py, PyAny>,
    ) -> PyResult<(f64, Bound<'py, PyAny>)> {
        let m = vector("vector of controls", m)?;
        if outputs(&self.problem) != 1 {
            let why = format!("the problem has {} outputs, and a gradient is of one", outputs(&self.problem));
            return Err(PyTypeError::new_err(why));
        }
        let found = py.detach(|| self.problem.value_and_gradient(m))?;
        Ok((found[0], array(py, &found[1..], (found.len() - 1,))?))
    }

    /// F'(m)^T w of a cotangent w, a number per output: one adjoint.
    fn vjp<'py>(
        &self,
        py: Python<'py>,
        m: &Bound<'py, PyAny>,
        cotangent: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (m, cotangent) = (vector("vector of controls", m)?, vector("cotangent", cotangent)?);
        let found = py.detach(|| self.problem.vjp(m, cotangent))?;
        array(py, &found, (found.len(),))
    }

    /// F'(m) d of a direction d of the controls: an adjoint per output.
    fn jvp<'py>(
        &self,
        py: Python<'py>,
        m: &Bound<'py, PyAny>,
        direction: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (m, direction) = (vector("vector of controls", m)?, vector("direction", direction)?);
        let found = py.detach(|| self.problem.jvp(m, direction))?;
        array(py, &found, (found.len(),))
    }

    /// F'(m), a row per output. Each row costs an adjoint solution.
    fn jacobian<'py>(&self, py: Python<'py>, m: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let m = vector("vector of controls", m)?;
        let columns = m.len();
        let found = py.detach(|| self.problem.jacobian(m))?;
        array(py, &found, (outputs(&self.problem), columns))
    }

    fn __repr__(&self) -> String {
        let parts = |parts: &[Part]| {
            let named: Vec<_> = parts.iter().map(|part| format!("{} ({})", part.name, part.length)).collect();
            named.join(", ")
        };
        format!("<Problem: {} -> {}>", parts(self.problem.inputs()), parts(self.problem.outputs()))
    }
}

fn named(parts: &[Part]) -> Vec<(String, usize)> {
    parts.iter().map(|part| (part.name.clone(), part.length)).collect()
}

fn outputs(problem: &ProblemThread) -> usize {
    problem.outputs().iter().map(|part| part.length).sum()
}

/// The values of a contiguous row of float64. How many they are, and whether they are finite, the problem checks.
fn vector(what: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    if has_masked_values(object)? {
        return Err(PyValueError::new_err(format!(
            "the {what} has masked values, which are no numbers: .filled(..)"
        )));
    }
    let Ok(buffer) = PyBuffer::<f64>::get(object) else { return Err(no_buffer(what, object)) };
    // The type of the buffer says nothing of the order of its bytes.
    if !is_in_native_order(buffer.format()) {
        let why = format!(
            "the bytes of the {what} are not in this machine's order: numpy.asarray(.., dtype=float)"
        );
        return Err(PyTypeError::new_err(why));
    }
    if buffer.dimensions() != 1 {
        let shape = buffer.shape();
        return Err(PyValueError::new_err(format!(
            "the {what} has the shape {shape:?} and is no row: .ravel()"
        )));
    }
    if !buffer.is_c_contiguous() {
        let why = format!("the {what} is not contiguous: numpy.ascontiguousarray(..)");
        return Err(PyValueError::new_err(why));
    }
    buffer.to_vec(object.py())
}

/// The error for an object that has no buffer of float64.
fn no_buffer(what: &str, object: &Bound<'_, PyAny>) -> PyErr {
    if object.getattr("ndim").is_ok_and(|count| count.extract::<usize>().is_ok_and(|count| count == 0)) {
        return PyValueError::new_err(format!(
            "the {what} is a single number and no row: numpy.atleast_1d(..)"
        ));
    }
    let aligned = object.getattr("flags").and_then(|flags| flags.getattr("aligned"));
    if aligned.is_ok_and(|aligned| aligned.extract::<bool>().is_ok_and(|aligned| !aligned)) {
        return PyValueError::new_err(format!("the {what} is not aligned in memory: .copy()"));
    }
    let kind = object.get_type().name().map_or_else(|_| "object".to_owned(), |name| name.to_string());
    let of = object.getattr("dtype").map_or_else(|_| String::new(), |dtype| format!(" of {dtype}"));
    PyTypeError::new_err(format!(
        "the {what} is no array of float64 but a {kind}{of}: numpy.asarray(.., dtype=float)"
    ))
}

/// True if a format of Python's module `struct` is that of this machine's doubles.
fn is_in_native_order(format: &CStr) -> bool {
    match format.to_bytes() {
        b"d" | b"@d" | b"=d" => true,
        b"<d" => cfg!(target_endian = "little"),
        b">d" | b"!d" => cfg!(target_endian = "big"),
        _ => false,
    }
}

/// True if a masked array has masked values, for which the buffer has arbitrary numbers.
fn has_masked_values(object: &Bound<'_, PyAny>) -> PyResult<bool> {
    static MASKED: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    static IS_MASKED: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let py = object.py();
    if !object.is_instance(MASKED.import(py, "numpy.ma", "MaskedArray")?)? {
        return Ok(false);
    }
    IS_MASKED.import(py, "numpy.ma", "is_masked")?.call1((object,))?.extract()
}

/// The real number that a parameter is given: a float, an integer, or what Python turns into a float, but for truth values and complex
/// numbers.
fn number(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let refused = || {
        let kind = value.get_type().name().map_or_else(|_| "object".to_owned(), |name| name.to_string());
        PyTypeError::new_err(format!("the parameter `{name}` is no number but a {kind}: {value}"))
    };
    // Python takes `True` for 1, and NumPy drops imaginary parts.
    if value.is_instance_of::<PyBool>() || value.is_instance_of::<PyComplex>() {
        return Err(refused());
    }
    // NumPy's numbers and arrays have a kind: 'i', 'u' and 'f' are integers and floats.
    if let Ok(dtype) = value.getattr("dtype") {
        let kind = dtype.getattr("kind").and_then(|kind| kind.extract::<String>());
        let dimensions = value.getattr("ndim").and_then(|count| count.extract::<usize>());
        let is_real = kind.is_ok_and(|kind| ["i", "u", "f"].contains(&kind.as_str()));
        if !is_real || !dimensions.is_ok_and(|count| count == 0) {
            return Err(refused());
        }
    }
    value.extract().map_err(|why: PyErr| {
        if why.is_instance_of::<PyOverflowError>(value.py()) {
            PyValueError::new_err(format!("the parameter `{name}` is beyond the range of float64"))
        } else {
            refused()
        }
    })
}

/// A NumPy array of a shape.
fn array<'py>(py: Python<'py>, values: &[f64], shape: impl IntoPyObject<'py>) -> PyResult<Bound<'py, PyAny>> {
    static EMPTY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let array = EMPTY.import(py, "numpy", "empty")?.call1((shape,))?;
    PyBuffer::<f64>::get(&array)?.copy_from_slice(py, values)?;
    Ok(array)
}

/// Adds to a module a function that makes a problem from numbers given by keyword; for [`export_python!`](crate::export_python).
#[doc(hidden)]
pub fn add_problem<M: DifferentiableMap + 'static>(
    module: &Bound<'_, PyModule>,
    name: &'static str,
    constructor: fn(&mut Parameters) -> Result<M, Box<dyn Error>>,
) -> PyResult<()> {
    let open = move |unnamed: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>| -> PyResult<Problem> {
        if !unnamed.is_empty() {
            return Err(PyTypeError::new_err(format!("{name} takes numbers by name: {name}(cells=8)")));
        }
        let mut given = vec![];
        for (key, value) in named.into_iter().flatten() {
            let key: String = key.extract()?;
            let value = number(&key, &value)?;
            given.push((key, value));
        }
        let parameters = Parameters::new(given).map_err(|why| PyValueError::new_err(why.to_string()))?;
        let problem = unnamed.py().detach(|| ProblemThread::open(constructor, parameters))?;
        Ok(Problem { problem })
    };
    // Python keeps the name for as long as the function, which is as long as the program.
    let kept: &'static CString = Box::leak(Box::new(CString::new(name)?));
    module.add_class::<Problem>()?;
    module.add(name, PyCFunction::new_closure(module.py(), Some(kept.as_c_str()), None, open)?)
}

/// Exports problems to Python, as a module with a function for each, which takes the parameters by name. The constructors are
/// `fn(&mut Parameters) -> Result<impl DifferentiableMap, Box<dyn Error>>` with the names that Python sees.
#[macro_export]
macro_rules! export_python {
    ($module:ident: $($constructor:ident),+ $(,)?) => {
        #[$crate::pyo3::pymodule]
        #[pyo3(crate = "forms_bindings::pyo3")]
        fn $module(
            module: &$crate::pyo3::Bound<'_, $crate::pyo3::types::PyModule>,
        ) -> $crate::pyo3::PyResult<()> {
            $($crate::python::add_problem(module, stringify!($constructor), $constructor)?;)+
            Ok(())
        }
    };
}
