//! Contact laws: what the drivers ask of a forms module. The steps to one of your own are in docs/new_contact_law.md, and
//! `tests/contact_law` follows it.

use forms_fem::prelude::*;

use crate::parameter_ranges::ParameterRanges;
use crate::threshold::Threshold;

/// A forms module with its data and regions bound, that states a contact problem: [`contact_law!`](crate::contact_law) writes
/// this for a module's `Model`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no contact law in {D} dimensions",
    note = "name what the drivers need of its forms module: `contact_law!(module {{ direct: direct, region: gamma_c }})`"
)]
pub trait ContactLaw<const D: usize>: Clone + ParameterRanges {
    /// The direct problem with the law's data.
    fn direct(&self) -> Form<D>;

    /// Name in the mesh of Γ_C, the potential contact boundary.
    fn contact_region(&self) -> &str;

    /// The line search of Newton's method for the direct problem, unless its builder is given options. Whole steps go back
    /// and forth between stick and slip: laws with friction shorten them by the residual.
    fn line_search(&self) -> LineSearch {
        LineSearch::Off
    }

    /// The threshold of the law's γ₀ for displacements in a space, with the undeformed body's stiffness. None unless the law says
    /// it: penalty methods and multipliers have none.
    ///
    /// # Errors
    /// Data that do not fit.
    fn threshold(
        &self,
        _assembler: &Assembler<D>,
        _space: &Arc<Space<D>>,
    ) -> Result<Option<Threshold>, AssemblyError> {
        Ok(None)
    }
}

/// A contact law with a scalar whose sign shows which points are in contact. Facets can be split at its zeros.
#[diagnostic::on_unimplemented(
    message = "the contact law `{Self}` names no contact indicator, and facets are split at its zeros",
    note = "add `indicator: name` of a scalar of u to its `contact_law!`"
)]
pub trait WithIndicator<const D: usize>: ContactLaw<D> {
    /// The indicator at a displacement.
    fn indicator(&self, u: &Field<D>) -> Expression<D>;
}

/// A coefficient of friction at which whatever presses sticks; contacts of rubber or of dry metals come to a few units.
pub const STICKING: f64 = 1e6;

/// A contact law with a coefficient of friction.
#[diagnostic::on_unimplemented(
    message = "the contact law `{Self}` names no coefficient of friction",
    note = "add `coefficient: name` of a parameter to its `contact_law!`"
)]
pub trait WithFriction<const D: usize>: ContactLaw<D> {
    /// The same law with a coefficient that no load reaches: what presses sticks.
    fn sticking(&self) -> Self;
}

/// A contact law by Nitsche's method with a choice of θ.
#[diagnostic::on_unimplemented(
    message = "the contact law `{Self}` names no θ",
    note = "add `theta: name` of a parameter to its `contact_law!`"
)]
pub trait WithTheta<const D: usize>: ContactLaw<D> {
    /// θ.
    fn theta(&self) -> f64;

    /// The same law with another θ.
    fn with_theta(&self, theta: f64) -> Self;
}

/// A contact law by Nitsche's method at small strains, which is stable where γ₀ is above a threshold.
#[diagnostic::on_unimplemented(
    message = "the contact law `{Self}` does not say what the threshold of its γ₀ rests on",
    note = "add `theta: theta, threshold: product(elasticity, gamma0)` to its `contact_law!`: two forms and two parameters"
)]
pub trait WithThreshold<const D: usize>: WithTheta<D> {
    /// γ₀ \[stress\].
    fn gamma0(&self) -> f64;

    /// The product of stresses.
    fn stress_product(&self) -> Form<D>;

    /// The elastic energy's form on the cells of this name.
    fn energy_on(&self, cells: &str) -> Form<D>;
}

/// A contact law with a criterion J(u) and its adjoint problem.
#[diagnostic::on_unimplemented(
    message = "the contact law `{Self}` names no criterion with an adjoint problem",
    note = "add `criterion: name` and `adjoint: name` to its `contact_law!`"
)]
pub trait WithAdjoint<const D: usize>: ContactLaw<D> {
    /// The criterion at a displacement.
    fn criterion(&self, u: &Field<D>) -> Functional<D>;

    /// The adjoint problem at a displacement.
    fn adjoint(&self, u: &Field<D>) -> Form<D>;
}

/// A contact law with the derivative of its criterion by the shape.
#[diagnostic::on_unimplemented(
    message = "the contact law `{Self}` names no shape gradient",
    note = "add `shape_gradient: name` (and `diameter_gradient: name`) to its `contact_law!`"
)]
pub trait WithShapeGradient<const D: usize>: WithAdjoint<D> {
    /// The volume form of the shape derivative at a displacement and an adjoint state.
    fn shape_gradient(&self, u: &Field<D>, p: &Field<D>) -> Form<D>;

    /// Contribution of the cells' diameters h.
    fn diameter_gradient(&self, u: &Field<D>, p: &Field<D>) -> Form<D>;
}

/// The form of a law's direct problem, which its module may give as an energy.
#[doc(hidden)]
pub fn form_of<const D: usize>(direct: impl Into<Form<D>>) -> Form<D> {
    direct.into()
}

/// Makes a contact law of a forms module's `Model`: says which of its functions are what.
///
/// ```
/// # use forms_fem::prelude::*;
/// use forms_contact::contact_law;
///
/// /// Penalty contact with a flat obstacle.
/// #[forms]
/// pub mod penalty {
///     use forms_contact::operators::linear_elastic::stress;
///     use forms_contact::operators::obstacle::penetration;
///
///     pub struct Data {
///         lambda: Param,
///         mu: Param,
///         stiffness: Param,
///         obstacle_normal: Given<Vector>,
///         gap: Given<Scalar>,
///     }
///     #[cells]
///     pub struct Omega;
///     #[facets]
///     pub struct GammaC;
///
///     pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
///         integral(Omega, inner(stress(u), eps(v)))
///             + integral(GammaC, stiffness * pos_part(penetration(u)) * dot(v, obstacle_normal))
///     }
/// }
/// contact_law!(penalty { direct: direct, region: gamma_c });
/// ```
///
/// Further entries, in this order, each with a function of the module: `indicator: β(u)`; `criterion: J(u), adjoint: form(u)`;
/// `shape_gradient: form(u, p), diameter_gradient: form(u, p)`; `theta: parameter`, for
/// Nitsche's method ([`WithTheta`](crate::law::WithTheta)), and `threshold: product(elasticity, gamma0)` with it
/// ([`WithThreshold`](crate::law::WithThreshold)), or `threshold_by: function` of the model, an assembler and a space for
/// [`ContactLaw::threshold`](crate::law::ContactLaw::threshold); `positive: parameter`, a member of the data
/// that has to be positive, `non_negative: parameter`, `rotation: parameter` and `unit: vector` ([`ParameterRanges`]); `coefficient: parameter`, that of
/// friction; `line_search: OnResidual`, a [`LineSearch`], or `line_search_by: function` of the model. A function that the module does not have is an error at its name here.
#[macro_export]
macro_rules! contact_law {
    ($module:ident {
        direct: $direct:ident,
        region: $region:ident
        $(, indicator: $indicator:ident)?
        $(, criterion: $criterion:ident, adjoint: $adjoint:ident
            $(, shape_gradient: $shape_gradient:ident, diameter_gradient: $diameter_gradient:ident)?)?
        $(, theta: $($theta:ident).+)?
        $(, threshold: $product:ident($elasticity:ident, $($gamma0:ident).+))?
        $(, threshold_by: $threshold_by:ident)?
        $(, positive: $($positive:ident).+)*
        $(, non_negative: $($non_negative:ident).+)*
        $(, rotation: $($rotation:ident).+)*
        $(, unit: $($unit:ident).+)*
        $(, coefficient: $($coefficient:ident).+)?
        $(, line_search: $line_search:ident)?
        $(, line_search_by: $line_search_by:ident)?
        $(,)?
    }) => {
        impl<const D: usize> $crate::law::ContactLaw<D> for $module::Model<D>
        where
            $crate::fem::Dim: $crate::fem::Dimension<D>,
        {
            fn direct(&self) -> $crate::fem::Form<D> {
                $crate::law::form_of($module::Model::$direct(self))
            }

            fn contact_region(&self) -> &str {
                &self.regions.$region.0.name
            }

            $(
                fn line_search(&self) -> $crate::fem::LineSearch {
                    $crate::fem::LineSearch::$line_search
                }
            )?

            $(
                fn line_search(&self) -> $crate::fem::LineSearch {
                    $line_search_by(self)
                }
            )?

            $(
                fn threshold(
                    &self,
                    assembler: &$crate::fem::Assembler<D>,
                    space: &$crate::fem::Arc<$crate::fem::Space<D>>,
                ) -> Result<Option<$crate::threshold::Threshold>, $crate::fem::AssemblyError> {
                    let _ = stringify!($product);
                    $crate::threshold::of_law(self, assembler, space).map(Some)
                }
            )?

            $(
                fn threshold(
                    &self,
                    assembler: &$crate::fem::Assembler<D>,
                    space: &$crate::fem::Arc<$crate::fem::Space<D>>,
                ) -> Result<Option<$crate::threshold::Threshold>, $crate::fem::AssemblyError> {
                    $threshold_by(self, assembler, space).map(Some)
                }
            )?
        }
        $crate::parameter_ranges!($module {
            $(positive: $($positive).+,)*
            $(non_negative: $($non_negative).+,)*
            $(rotation: $($rotation).+,)*
            $(unit: $($unit).+,)*
        });
        $(
            impl<const D: usize> $crate::law::WithFriction<D> for $module::Model<D>
            where
                $crate::fem::Dim: $crate::fem::Dimension<D>,
            {
                fn sticking(&self) -> Self {
                    let mut law = self.clone();
                    law.data.$($coefficient).+ = $crate::law::STICKING;
                    law
                }
            }
        )?
        $(
            impl<const D: usize> $crate::law::WithIndicator<D> for $module::Model<D>
            where
                $crate::fem::Dim: $crate::fem::Dimension<D>,
            {
                fn indicator(&self, u: &$crate::fem::Field<D>) -> $crate::fem::Expression<D> {
                    $module::Model::$indicator(self, u)
                }
            }
        )?
        $(
            impl<const D: usize> $crate::law::WithTheta<D> for $module::Model<D>
            where
                $crate::fem::Dim: $crate::fem::Dimension<D>,
            {
                fn theta(&self) -> f64 {
                    self.data.$($theta).+
                }

                fn with_theta(&self, theta: f64) -> Self {
                    let mut law = self.clone();
                    law.data.$($theta).+ = theta;
                    law
                }
            }
        )?
        $(
            impl<const D: usize> $crate::law::WithThreshold<D> for $module::Model<D>
            where
                $crate::fem::Dim: $crate::fem::Dimension<D>,
            {
                fn gamma0(&self) -> f64 {
                    self.data.$($gamma0).+
                }

                fn stress_product(&self) -> $crate::fem::Form<D> {
                    $module::Model::$product(self)
                }

                fn energy_on(&self, cells: &str) -> $crate::fem::Form<D> {
                    $module::$elasticity(&self.data, &$module::Omega::on(cells))
                }
            }
        )?
        $(
            impl<const D: usize> $crate::law::WithAdjoint<D> for $module::Model<D>
            where
                $crate::fem::Dim: $crate::fem::Dimension<D>,
            {
                fn criterion(&self, u: &$crate::fem::Field<D>) -> $crate::fem::Functional<D> {
                    $module::Model::$criterion(self, u)
                }

                fn adjoint(&self, u: &$crate::fem::Field<D>) -> $crate::fem::Form<D> {
                    $module::Model::$adjoint(self, u)
                }
            }
            $(
                impl<const D: usize> $crate::law::WithShapeGradient<D> for $module::Model<D>
                where
                    $crate::fem::Dim: $crate::fem::Dimension<D>,
                {
                    fn shape_gradient(
                        &self,
                        u: &$crate::fem::Field<D>,
                        p: &$crate::fem::Field<D>,
                    ) -> $crate::fem::Form<D> {
                        $module::Model::$shape_gradient(self, u, p)
                    }

                    fn diameter_gradient(
                        &self,
                        u: &$crate::fem::Field<D>,
                        p: &$crate::fem::Field<D>,
                    ) -> $crate::fem::Form<D> {
                        $module::Model::$diameter_gradient(self, u, p)
                    }
                }
            )?
        )?
    };
}
