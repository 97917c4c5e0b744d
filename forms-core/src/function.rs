//! Compiled functions as values: forms, energies, functionals and expressions, with the kernels that a backend made of theirs.
//!
//! `#[forms]` emits a constructor for each function of a module. It returns one of the types here: a name, fields, data, and
//! lists of integrals, each with its description and its kernel. Values are cheap to clone. A [`Backend`] says in which form it
//! keeps kernels: the compiler hands over typed kernels once, when a value is made, and nothing after that knows their types.
//! Sums and multiples of values are values of the same types ([`CombinationError`] says which have none).

mod combination;

use std::any::TypeId;
use std::borrow::Cow;
use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

use self::combination::Addend;
pub use self::combination::CombinationError;
use crate::form::{Dependence, FieldDescription, Formula, Inputs, Integral, Role};
use crate::integrals::{Backend, Integrals, Term};

/// A compiled function: its description, its data, and the terms of its residual, tangent, switches and densities. What a
/// function does not have is an empty list.
pub struct Function<const D: usize, B: Backend<D>> {
    name: &'static str,
    /// Compiled functions whose sum it is, with their factors: itself, unless it was combined from others.
    addends: Vec<Addend>,
    /// The reason for which what it was combined from has no sum.
    fault: Option<CombinationError>,
    fields: Cow<'static, [FieldDescription]>,
    shape: &'static [usize],
    inputs: Inputs<D>,
    residual: Vec<Term<B::Linear>>,
    joined_residual: Vec<Term<B::Linear>>,
    tangent: Vec<Term<B::Bilinear>>,
    switches: Vec<Term<B::Expression>>,
    density: Vec<Term<B::Expression>>,
    action: Vec<Term<B::Linear>>,
    motion: Vec<Term<B::Linear>>,
    means: Vec<Term<B::Linear>>,
    means_by_unknowns: Vec<Term<B::Bilinear>>,
    residual_by_means: Vec<Term<B::Bilinear>>,
    /// The type that has the integrals.
    integrals: TypeId,
}

impl<const D: usize, B: Backend<D>> Function<D, B> {
    fn new<I: Integrals<D>>(name: &'static str, formula: &'static Formula, inputs: Inputs<D>) -> Self {
        let constants = inputs.constants();
        Function {
            name,
            addends: vec![Addend { factor: 1.0, name, formula }],
            fault: None,
            fields: Cow::Borrowed(I::fields()),
            shape: I::shape(),
            residual: I::residual::<B>(constants),
            joined_residual: I::joined_residual::<B>(constants),
            tangent: I::tangent::<B>(constants),
            switches: I::switches::<B>(constants),
            density: I::density::<B>(constants),
            action: I::action::<B>(constants),
            motion: I::motion::<B>(constants),
            means: I::means::<B>(constants),
            means_by_unknowns: I::means_by_unknowns::<B>(constants),
            residual_by_means: I::residual_by_means::<B>(constants),
            integrals: TypeId::of::<I>(),
            inputs,
        }
    }

    fn function(&self) -> &Self {
        self
    }

    /// The name in its module; of a sum those of its addends.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// An error if it is a sum of functions that do not fit each other. Arithmetic on values gives no errors itself: who binds
    /// a function asks here first.
    ///
    /// # Errors
    /// [`CombinationError`] with the names of the functions and their fields.
    pub fn check(&self) -> Result<(), CombinationError> {
        self.fault.clone().map_or(Ok(()), Err)
    }

    /// The fields, by index.
    pub fn fields(&self) -> &[FieldDescription] {
        &self.fields
    }

    /// The name of the field with a role; empty if there is none.
    pub fn name_of(&self, role: Role) -> &'static str {
        self.fields.iter().find(|field| field.role == role).map_or("", |field| field.name)
    }

    /// The factors of the compiled functions whose sum it is; one factor, 1, unless it was added or scaled.
    pub fn factors(&self) -> impl Iterator<Item = f64> {
        self.addends.iter().map(|addend| addend.factor)
    }

    /// Data, regions, parameters.
    pub fn inputs(&self) -> &Inputs<D> {
        &self.inputs
    }

    /// The function as mathematics. A sum has the names with their factors, then the formula of each.
    pub fn formula(&self) -> Formula {
        match &self.addends[..] {
            [Addend { factor: 1.0, formula, .. }] => **formula,
            addends => combination::formula_of(addends),
        }
    }

    /// The terms of the residual, one per region and [`Dependence`].
    pub fn residual(&self) -> &[Term<B::Linear>] {
        &self.residual
    }

    /// The terms of the same residual with one term for all that dependence keeps apart on a region where several
    /// integrals depend on the unknowns: each facet is visited once. Their degree is that of the highest.
    pub fn joined_residual(&self) -> impl Iterator<Item = &Term<B::Linear>> {
        let is_joined = |term: &&Term<B::Linear>| {
            self.joined_residual.iter().any(|joined| is_on_same_points(joined.integral, term.integral))
        };
        self.joined_residual.iter().chain(self.residual.iter().filter(move |term| !is_joined(term)))
    }

    /// The terms of the tangent; integrals of [`Dependence::Constant`] have none.
    pub fn tangent(&self) -> &[Term<B::Bilinear>] {
        &self.tangent
    }

    /// The switches of each integral that has kinks: a vector that is positive, entry by entry,
    /// where `pos_part`, `neg_part`, `heaviside`, `max`, `min`, `abs`, `sign` or a comparison is "on".
    pub fn switches(&self) -> &[Term<B::Expression>] {
        &self.switches
    }

    /// The densities of a functional, or the value of an expression.
    pub fn densities(&self) -> &[Term<B::Expression>] {
        &self.density
    }

    /// The terms of the tangent applied to a direction, ∂R/∂u (u; v) w, in modules of `#[forms(matrix_free)]`: kernels read the
    /// direction as a field, and the unknowns only where the tangent depends on them.
    pub fn action(&self) -> &[Term<B::Linear>] {
        &self.action
    }

    /// The motion of points in derivatives by the shape, or by a state that displaces contact pairs, in the direction of a test function T, and in
    /// first variations of energies by the unknown that does: the terms are ∫ e T·e₁ with the integrand e that was differentiated. Where points depend on the displacement, the residual has Σ e ∂w/∂T
    /// and the motion of the points in e besides its other terms, which hold them.
    pub fn motion(&self) -> &[Term<B::Linear>] {
        &self.motion
    }

    /// The means over own facets that the integrals read, by [`Means::number`](crate::form::Means::number): terms that are linear in the
    /// functions with [`Role::MeanTest`]. The last component of each is ∫ ψ.
    pub fn means(&self) -> &[Term<B::Linear>] {
        &self.means
    }

    /// The derivatives of [`Function::means`] by the unknowns.
    pub fn means_by_unknowns(&self) -> &[Term<B::Bilinear>] {
        &self.means_by_unknowns
    }

    /// The derivatives of the residual by the means that it reads; what is in [`Function::tangent`] holds these fixed.
    pub fn residual_by_means(&self) -> &[Term<B::Bilinear>] {
        &self.residual_by_means
    }

    /// Whether no integral is nonlinear in the unknowns.
    pub fn is_affine(&self) -> bool {
        self.residual.iter().all(|term| term.integral.dependence != Dependence::Nonlinear)
    }

    /// Whether there are pairs of surfaces that an unknown displaces.
    pub fn slides(&self) -> bool {
        let is_unknown = |field: &usize| matches!(self.fields[*field].role, Role::Unknown(_));
        let terms = self.residual.iter().chain(&self.motion);
        terms.filter_map(|term| term.integral.displacement).flatten().any(is_unknown)
    }

    /// Whether there are pairs of surfaces that any field displaces.
    pub fn is_on_displaced_surfaces(&self) -> bool {
        self.residual.iter().chain(&self.motion).any(|term| term.integral.displacement.is_some())
    }

    /// Whether these are its integrals. Those of a sum or multiple are of no type.
    pub fn has_integrals<I: Integrals<D>>(&self) -> bool {
        self.integrals == TypeId::of::<I>()
    }

    /// Shape of the value of an expression: `[]` for a scalar.
    pub fn shape(&self) -> &'static [usize] {
        self.shape
    }
}

/// Whether two integrals are over the same points, with the same weights.
#[must_use]
pub fn is_on_same_points(one: &Integral, other: &Integral) -> bool {
    (one.region, one.displacement, one.means) == (other.region, other.displacement, other.means)
}

impl<const D: usize, B: Backend<D>> fmt::Debug for Function<D, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Function").field("name", &self.name).field("inputs", &self.inputs).finish()
    }
}

/// A value that shares a compiled function.
macro_rules! value {
    ($(#[$documentation:meta])* $name:ident) => {
        $(#[$documentation])*
        pub struct $name<const D: usize, B: Backend<D>>(Arc<Function<D, B>>);

        impl<const D: usize, B: Backend<D>> $name<D, B> {
            /// Value with the kernels of a compiled function; emitted constructors call it.
            #[doc(hidden)]
            pub fn of<I: Integrals<D>>(
                name: &'static str,
                formula: &'static Formula,
                inputs: Inputs<D>,
            ) -> Self {
                $name(Arc::new(Function::new::<I>(name, formula, inputs)))
            }
        }

        impl<const D: usize, B: Backend<D>> Deref for $name<D, B> {
            type Target = Function<D, B>;

            fn deref(&self) -> &Function<D, B> {
                &self.0
            }
        }

        impl<const D: usize, B: Backend<D>> Clone for $name<D, B> {
            fn clone(&self) -> Self {
                $name(Arc::clone(&self.0))
            }
        }

        impl<const D: usize, B: Backend<D>> fmt::Debug for $name<D, B> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Debug::fmt(&*self.0, f)
            }
        }
    };
}

value! {
    /// A residual R(u; v), linear in its test functions, and its tangent ∂R/∂u by the compiler.
    Form
}
value! {
    /// A number: the integral of a density without test function.
    Functional
}
value! {
    /// A derived field: a function of the module, evaluated where the user asks.
    Expression
}

/// An energy W(u): a number, and the form of its first variation. It can be used in place of a form.
pub struct Energy<const D: usize, B: Backend<D>>(Form<D, B>);

impl<const D: usize, B: Backend<D>> Energy<D, B> {
    /// Value with the kernels of a compiled energy; emitted constructors call it.
    #[doc(hidden)]
    pub fn of<I: Integrals<D>>(name: &'static str, formula: &'static Formula, inputs: Inputs<D>) -> Self {
        Energy(Form::of::<I>(name, formula, inputs))
    }
}

impl<const D: usize, B: Backend<D>> Deref for Energy<D, B> {
    type Target = Form<D, B>;

    fn deref(&self) -> &Form<D, B> {
        &self.0
    }
}

impl<const D: usize, B: Backend<D>> Clone for Energy<D, B> {
    fn clone(&self) -> Self {
        Energy(self.0.clone())
    }
}

impl<const D: usize, B: Backend<D>> fmt::Debug for Energy<D, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.0, f)
    }
}

impl<const D: usize, B: Backend<D>> From<Energy<D, B>> for Form<D, B> {
    fn from(energy: Energy<D, B>) -> Self {
        energy.0
    }
}

impl<const D: usize, B: Backend<D>> From<&Energy<D, B>> for Form<D, B> {
    fn from(energy: &Energy<D, B>) -> Self {
        energy.0.clone()
    }
}

impl<const D: usize, B: Backend<D>> From<&Energy<D, B>> for Functional<D, B> {
    fn from(energy: &Energy<D, B>) -> Self {
        Functional(Arc::clone(&energy.0.0))
    }
}

impl<const D: usize, B: Backend<D>> From<&Functional<D, B>> for Functional<D, B> {
    fn from(functional: &Functional<D, B>) -> Self {
        functional.clone()
    }
}

impl<const D: usize, B: Backend<D>> From<&Form<D, B>> for Form<D, B> {
    fn from(form: &Form<D, B>) -> Self {
        form.clone()
    }
}
