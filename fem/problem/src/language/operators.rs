//! The names of the language, one item each, so that a search finds them. They are documentation: forms are compiled by
//! [`macro@crate::forms`], which knows more shapes than the signatures show, and no program calls these functions. Editors find
//! here what the bodies of forms name.

#![allow(non_upper_case_globals, reason = "names as forms write them")]
#![allow(unused_variables, reason = "signatures are all that there is")]

/// A scalar expression.
#[derive(Clone, Copy, Debug)]
pub struct Scalar;
/// A vector with as many components as the domain has dimensions.
#[derive(Clone, Copy, Debug)]
pub struct Vector;
/// A tensor of rank 2 or more.
#[derive(Clone, Copy, Debug)]
pub struct Tensor;
/// A region of integration, declared by `#[cells]`, `#[facets]`, `#[interior_facets]` or `#[pairs]`.
#[derive(Clone, Copy, Debug)]
pub struct Region;
/// A form, functional or energy.
#[derive(Clone, Copy, Debug)]
pub struct Form;
/// The shape of the domain.
#[derive(Clone, Copy, Debug)]
pub struct Shape;

/// An expression of any rank.
pub trait Value {
    /// The rank of the gradient.
    type Gradient;
    /// The rank of the second derivatives.
    type Hessian;
    /// The rank of the divergence.
    type Divergence;
    /// The rank of a product over one axis of each.
    type Dot<B>;
    /// The rank of all products.
    type Outer<B>;
}

impl Value for Scalar {
    type Gradient = Vector;
    type Hessian = Tensor;
    type Divergence = ();
    type Dot<B> = B;
    type Outer<B> = B;
}

impl Value for Vector {
    type Gradient = Tensor;
    type Hessian = Tensor;
    type Divergence = Scalar;
    type Dot<B> = Scalar;
    type Outer<B> = Tensor;
}

impl Value for Tensor {
    type Gradient = Tensor;
    type Hessian = Tensor;
    type Divergence = Vector;
    type Dot<B> = B;
    type Outer<B> = Tensor;
}

/// Functions and values by the page that tells more of them.
macro_rules! names {
    ($($page:literal: {
        functions { $(#[doc = $of_function:literal] fn $function:ident
            $(<$($generic:ident $(: $bound:ident)?),+>)? ($($argument:ident: $type:ty),*) -> $result:ty;)* }
        values { $(#[doc = $of_value:literal] const $name:ident: $kind:ty = $value:expr;)* }
    })+) => {
        $($(
            #[doc = $of_function]
            #[doc = concat!("\n\nMore, with an example that runs: [`", $page, "`](super::", $page, ").")]
            #[inline]
            pub fn $function $(<$($generic $(: $bound)?),+>)? ($($argument: $type),*) -> $result {
                unreachable!("names of forms have no meaning outside of `#[forms]`")
            }
        )*
        $(
            #[doc = $of_value]
            #[doc = concat!("\n\nMore, with an example that runs: [`", $page, "`](super::", $page, ").")]
            pub const $name: $kind = $value;
        )*)+
    };
}

names! {
    "products": {
        functions {
            /// Product over the last axis of `a` and the first of `b`: a·b of vectors, A b of a tensor and a vector, A B of two tensors.
            fn dot<A: Value, B>(a: A, b: B) -> A::Dot<B>;
            /// Product over two axes, C : A with a tensor `C` of rank 4 (or more) and a tensor `A`.
            fn ddot<A: Value, B>(a: A, b: B) -> A::Dot<B>;
            /// Sum of the products of all components, A : B of tensors, a·b of vectors.
            fn inner<A: Value>(a: A, b: A) -> Scalar;
            /// Products of all pairs of components, a ⊗ b.
            fn outer<A: Value, B>(a: A, b: B) -> A::Outer<B>;
            /// Vector product a × b; in the plane the scalar a₀b₁ − a₁b₀.
            fn cross(a: Vector, b: Vector) -> Vector;
            /// A vector turned by a right angle in the plane, (−a₁, a₀).
            fn perp(a: Vector) -> Vector;
        }
        values {
        }
    }
    "kinks": {
        functions {
            /// Euclidean norm √(a·a), of a tensor √(A : A).
            fn norm<A: Value>(a: A) -> Scalar;
            /// Unit vector a/|a|.
            fn normalize(a: Vector) -> Vector;
            /// Absolute value |a|.
            fn abs(a: Scalar) -> Scalar;
            /// Sign: −1, 0, 1.
            fn sign(a: Scalar) -> Scalar;
            /// Heaviside's function H(a): 1 above zero, else 0.
            fn heaviside(a: Scalar) -> Scalar;
            /// Positive part \[a\]₊ = max(a, 0).
            fn pos_part(a: Scalar) -> Scalar;
            /// Negative part \[a\]₋ = max(−a, 0).
            fn neg_part(a: Scalar) -> Scalar;
            /// Smaller of two values.
            fn min(a: Scalar, b: Scalar) -> Scalar;
            /// Larger of two values.
            fn max(a: Scalar, b: Scalar) -> Scalar;
        }
        values {
        }
    }
    "tensors": {
        functions {
            /// The diagonal of a tensor as a vector; of a vector the tensor that has it as its diagonal.
            fn diag(a: Tensor) -> Tensor;
            /// Identity of a given size.
            fn identity(size: usize) -> Tensor;
            /// Transposed tensor Aᵀ.
            fn transpose(a: Tensor) -> Tensor;
            /// Trace, the sum of the diagonal.
            fn tr(a: Tensor) -> Scalar;
            /// Symmetric part (A + Aᵀ)/2.
            fn sym(a: Tensor) -> Tensor;
            /// Skew-symmetric part (A − Aᵀ)/2.
            fn skew(a: Tensor) -> Tensor;
            /// Deviator A − (tr A/size) I.
            fn dev(a: Tensor) -> Tensor;
            /// Determinant.
            fn det(a: Tensor) -> Scalar;
            /// Inverse A⁻¹.
            fn inv(a: Tensor) -> Tensor;
            /// Cofactor tensor det(A) A⁻ᵀ, also of singular tensors.
            fn cof(a: Tensor) -> Tensor;
            /// Exponential of a symmetric tensor.
            fn tensor_exp(a: Tensor) -> Tensor;
            /// Logarithm of a symmetric positive definite tensor, Hencky's strain of C/2.
            fn tensor_ln(a: Tensor) -> Tensor;
            /// Square root of a symmetric positive definite tensor, the stretch of C.
            fn tensor_sqrt(a: Tensor) -> Tensor;
        }
        values {
            /// Identity.
            const I: Tensor = Tensor;
            /// Identity of tensors, of rank 4.
            const identity4: Tensor = Tensor;
            /// The tensor of rank 4 that maps each tensor to its symmetric part.
            const sym_identity4: Tensor = Tensor;
        }
    }
    "calculus": {
        functions {
            /// Gradient ∇a; the last axis is the direction, `grad(u)[i][j]` = ∂u_i/∂x_j.
            fn grad<A: Value>(a: A) -> A::Gradient;
            /// Second derivatives ∂_j ∂_k of each component.
            fn hess<A: Value>(a: A) -> A::Hessian;
            /// Divergence: Σ ∂_i a_i of a vector, row by row of a tensor.
            fn div<A: Value>(a: A) -> A::Divergence;
            /// Strain ε(a) = (∇a + ∇aᵀ)/2.
            fn eps(a: Vector) -> Tensor;
            /// Mean over the cell, on its facets too, of what is affine in fields and their gradients.
            fn mean<A: Value>(a: A) -> A;
            /// Rotation ∇ × a; in the plane a scalar of a vector, a vector of a scalar.
            fn curl(a: Vector) -> Vector;
        }
        values {
        }
    }
    "functions": {
        functions {
            /// Square root.
            fn sqrt(a: Scalar) -> Scalar;
            /// Exponential.
            fn exp(a: Scalar) -> Scalar;
            /// Natural logarithm.
            fn ln(a: Scalar) -> Scalar;
            /// Logarithm to the base 10.
            fn log10(a: Scalar) -> Scalar;
            /// Sine of an angle in radians.
            fn sin(a: Scalar) -> Scalar;
            /// Cosine of an angle in radians.
            fn cos(a: Scalar) -> Scalar;
            /// Tangent of an angle in radians.
            fn tan(a: Scalar) -> Scalar;
            /// Inverse of the sine.
            fn asin(a: Scalar) -> Scalar;
            /// Inverse of the cosine.
            fn acos(a: Scalar) -> Scalar;
            /// Inverse of the tangent.
            fn atan(a: Scalar) -> Scalar;
            /// Angle of the point (first, second) with the first axis, in radians.
            fn atan2(second: Scalar, first: Scalar) -> Scalar;
            /// Hyperbolic sine.
            fn sinh(a: Scalar) -> Scalar;
            /// Hyperbolic cosine.
            fn cosh(a: Scalar) -> Scalar;
            /// Hyperbolic tangent.
            fn tanh(a: Scalar) -> Scalar;
            /// Inverse of the hyperbolic sine.
            fn asinh(a: Scalar) -> Scalar;
            /// Inverse of the hyperbolic cosine.
            fn acosh(a: Scalar) -> Scalar;
            /// Inverse of the hyperbolic tangent.
            fn atanh(a: Scalar) -> Scalar;
            /// Error function.
            fn erf(a: Scalar) -> Scalar;
            /// Complement of the error function, 1 − erf a.
            fn erfc(a: Scalar) -> Scalar;
            /// Power.
            fn pow(base: Scalar, exponent: Scalar) -> Scalar;
            /// Square a².
            fn sqr(a: Scalar) -> Scalar;
            /// √(a² + b²).
            fn hypot(a: Scalar, b: Scalar) -> Scalar;
        }
        values {
            /// Number of dimensions, 2 or 3.
            const D: usize = 0;
            /// Number of dimensions, the long form of `D`.
            const dimension: usize = 0;
            /// π.
            const PI: f64 = std::f64::consts::PI;
        }
    }
    "facets": {
        functions {
            /// An expression as the cell at hand sees it, on an interior facet or at a contact pair.
            fn this<A: Value>(a: A) -> A;
            /// An expression as the cell across the facet sees it, or the one at the opposite point of a contact pair.
            fn other<A: Value>(a: A) -> A;
            /// Jump this(a) − other(a); `jump(a, n)` is this(a n) + other(a n).
            fn jump<A: Value>(a: A) -> A;
            /// Average (this(a) + other(a))/2.
            fn avg<A: Value>(a: A) -> A;
        }
        values {
            /// Gap of a contact pair, from the own point to the opposite one along `toward` \[length\].
            const gap: Scalar = Scalar;
            /// Unit normal of a contact pair, toward the opposite side.
            const toward: Vector = Vector;
        }
    }
    "derivatives": {
        functions {
            /// Integral of a density over a region.
            fn integral(region: Region, density: Scalar) -> Form;
            /// Sum Σ D e over own facets of contact pairs, where `mean(a)` is the mean over the facet; degree 0, or 1 for a mean per vertex.
            fn means(region: Region, degree: Scalar, density: Scalar) -> Form;
            /// Gateaux derivative of a form, functional or expression by a field, a parameter or the `shape` of the domain.
            fn derivative<A: Value>(form: Form, field: A, direction: A) -> Form;
            /// Partial derivative of an expression by a name.
            fn diff<A: Value, B: Value>(expression: A, by: B) -> A::Outer<B>;
        }
        values {
            /// The shape of the domain: no value, but [`derivative`] differentiates by it.
            const shape: Shape = Shape;
        }
    }
    "geometry": {
        functions {
        }
        values {
            /// Diameter of the cell \[length\].
            const h: Scalar = Scalar;
            /// Diameter of the cell \[length\], the long form of `h`.
            const diameter: Scalar = Scalar;
            /// Outward unit normal.
            const n: Vector = Vector;
            /// Outward unit normal, the long form of `n`.
            const normal: Vector = Vector;
            /// Position \[length\].
            const x: Vector = Vector;
            /// Position \[length\], the long form of `x`.
            const position: Vector = Vector;
            /// Volume of the cell, in the plane its area.
            const cell_volume: Scalar = Scalar;
            /// Area of the facet, in the plane its length.
            const facet_area: Scalar = Scalar;
            /// Sum of the principal curvatures of a facet, div n \[1/length\].
            const curvature: Scalar = Scalar;
        }
    }
}

#[doc(hidden)]
pub mod editor;
