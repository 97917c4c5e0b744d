//! Sources of the values of a form's data: constants, functions of position, fields on a space.

use std::any::Any;
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

/// A field that lives in some backend. The contract carries it; only its backend can read it.
pub trait DiscreteField: Any + Send + Sync {
    /// Number of scalar components.
    fn components(&self) -> usize;
    /// For the backend, which knows the type.
    fn as_any(&self) -> &dyn Any;
}

/// A shared discrete field.
pub type FieldHandle = Arc<dyn DiscreteField>;

/// Values at the quadrature points of a region, which live in some backend: the committed ones, which forms
/// read, and those written since.
pub trait QuadratureValues: Any + Send + Sync {
    /// Number of scalar components.
    fn components(&self) -> usize;
    /// Commits the written values: forms read them from now on. Without any nothing changes.
    fn commit(&self);
    /// Discards values that were written and not committed.
    fn revert(&self);
    /// The number of commits: values read before have changed if this number has.
    fn commits(&self) -> u64;
    /// For the backend, which knows the type.
    fn as_any(&self) -> &dyn Any;
}

/// A shared set of values at quadrature points.
pub type HistoryHandle = Arc<dyn QuadratureValues>;

/// A function of position: writes its components to the slice.
pub type PositionFunction<const D: usize> = Arc<dyn Fn(&[f64; D], &mut [f64]) + Send + Sync>;

/// The source of a field's values.
#[derive(Clone)]
pub enum Source<const D: usize> {
    /// The same components everywhere; the gradient is zero.
    Constant(Vec<f64>),
    /// A function of position.
    Function {
        /// Number of scalar components.
        components: usize,
        /// The function.
        function: PositionFunction<D>,
        /// Its gradient, `components * D` numbers, component before direction. Kernels read none without it.
        gradient: Option<PositionFunction<D>>,
    },
    /// A field on a space of the backend.
    Discrete(FieldHandle),
    /// Values at quadrature points; they have no gradient that a kernel could read.
    History(HistoryHandle),
}

impl<const D: usize> Source<D> {
    /// Number of scalar components.
    pub fn components(&self) -> usize {
        match self {
            Source::Constant(values) => values.len(),
            Source::Function { components, .. } => *components,
            Source::Discrete(field) => field.components(),
            Source::History(history) => history.components(),
        }
    }
}

impl<const D: usize> fmt::Debug for Source<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Source::Constant(values) => f.debug_tuple("Constant").field(values).finish(),
            Source::Function { components, .. } => write!(f, "Function({components} components)"),
            Source::Discrete(field) => write!(f, "Discrete({} components)", field.components()),
            Source::History(history) => write!(f, "History({} components)", history.components()),
        }
    }
}

/// A value of any rank with `f64` components, an array of arrays.
pub trait FieldValue: Copy + Send + Sync + 'static {
    /// Number of scalar components.
    const COMPONENTS: usize;
    /// The value of its gradient in D dimensions: the direction is the last axis.
    type Gradient<const D: usize>: FieldValue;
    /// Writes the components, row-major.
    fn write(&self, components: &mut [f64]);
}

impl FieldValue for f64 {
    const COMPONENTS: usize = 1;
    type Gradient<const D: usize> = [f64; D];
    fn write(&self, components: &mut [f64]) {
        components[0] = *self;
    }
}

impl<V: FieldValue, const N: usize> FieldValue for [V; N] {
    const COMPONENTS: usize = N * V::COMPONENTS;
    type Gradient<const D: usize> = [V::Gradient<D>; N];
    fn write(&self, components: &mut [f64]) {
        for (value, chunk) in self.iter().zip(components.chunks_mut(V::COMPONENTS)) {
            value.write(chunk);
        }
    }
}

/// Data with the same value everywhere.
impl<const D: usize> From<f64> for Source<D> {
    fn from(value: f64) -> Self {
        Given::constant(value).into()
    }
}

/// The same value everywhere; any rank.
impl<V: FieldValue, const N: usize, const D: usize> From<[V; N]> for Source<D> {
    fn from(value: [V; N]) -> Self {
        Given::constant(value).into()
    }
}

/// A known field of a form may come from whatever data may.
impl<V, const D: usize> From<Given<V, D>> for Source<D> {
    fn from(given: Given<V, D>) -> Self {
        given.source
    }
}

/// A coefficient: a member of `Data` declared as `Given<Scalar>`, `Given<Vector>` or `Given<Tensor>`, which is a constant,
/// a function of x, or a field on a space. Declared as `Carried<..>` it is a material (Lagrangian) coefficient, which moves
/// with the body where the shape is varied. `V` is `f64`, `[f64; D]` or `[[f64; D]; D]`.
///
/// ```
/// # use forms_core::contract::Given;
/// let density: Given<f64, 2> = Given::constant(7.8);
/// let gravity: Given<[f64; 2], 2> = Given::constant([0.0, -9.81]);
/// let gap: Given<f64, 2> = Given::function(|x| x[1] + 0.02);
/// ```
#[derive(Clone, Debug)]
pub struct Given<V, const D: usize> {
    source: Source<D>,
    value: PhantomData<V>,
}

impl<V: FieldValue, const D: usize> Given<V, D> {
    /// Data with the same value everywhere.
    pub fn constant(value: V) -> Self {
        let mut components = vec![0.0; V::COMPONENTS];
        value.write(&mut components);
        Given { source: Source::Constant(components), value: PhantomData }
    }

    /// A function of position.
    pub fn function(function: impl Fn(&[f64; D]) -> V + Send + Sync + 'static) -> Self {
        let components = V::COMPONENTS;
        let function: PositionFunction<D> = Arc::new(move |x, out| function(x).write(out));
        Given { source: Source::Function { components, function, gradient: None }, value: PhantomData }
    }

    /// A function of position with its gradient \[value/length\], which forms read as `grad(..)` of the member and
    /// derivatives by the shape of the domain where the member is fixed in space. Of a vector field f the gradient is
    /// `[[∂f_0/∂x_0, ∂f_0/∂x_1], [∂f_1/∂x_0, ∂f_1/∂x_1]]`. Nothing checks that it is the function's.
    pub fn function_with_gradient(
        function: impl Fn(&[f64; D]) -> V + Send + Sync + 'static,
        gradient: impl Fn(&[f64; D]) -> V::Gradient<D> + Send + Sync + 'static,
    ) -> Self {
        let components = V::COMPONENTS;
        let function: PositionFunction<D> = Arc::new(move |x, out| function(x).write(out));
        let gradient: PositionFunction<D> = Arc::new(move |x, out| gradient(x).write(out));
        let source = Source::Function { components, function, gradient: Some(gradient) };
        Given { source, value: PhantomData }
    }

    /// A field on a space of the backend. The backend checks its components when the form is assembled.
    pub fn field(field: impl Into<FieldHandle>) -> Self {
        Given { source: Source::Discrete(field.into()), value: PhantomData }
    }

    /// The source of the values.
    pub fn source(&self) -> &Source<D> {
        &self.source
    }
}

/// A value of a coefficient, as a setter of data takes it: a number or an array, the same everywhere; a function of position,
/// `|x: &[f64; 2]| x[1]`; a field of the backend; a [`Given`].
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no value of this coefficient",
    label = "expected `{V}`, a function of position that returns it, or a field",
    note = "write numbers with a decimal point, and the type of a function's argument: `|x: &[f64; 2]| ..`"
)]
pub trait Datum<V, const D: usize> {
    /// The coefficient.
    fn given(self) -> Given<V, D>;
}

impl<const D: usize> Datum<f64, D> for f64 {
    fn given(self) -> Given<f64, D> {
        Given::constant(self)
    }
}

impl<V: FieldValue, const N: usize, const D: usize> Datum<[V; N], D> for [V; N] {
    fn given(self) -> Given<[V; N], D> {
        Given::constant(self)
    }
}

impl<V: FieldValue, F, const D: usize> Datum<V, D> for F
where
    F: Fn(&[f64; D]) -> V + Send + Sync + 'static,
{
    fn given(self) -> Given<V, D> {
        Given::function(self)
    }
}

impl<V, const D: usize> Datum<V, D> for Given<V, D> {
    fn given(self) -> Given<V, D> {
        self
    }
}

impl<V: FieldValue, const D: usize> Datum<V, D> for FieldHandle {
    fn given(self) -> Given<V, D> {
        Given::field(self)
    }
}
