//! The bound of code that is generic over the dimension: kernels of all forms, for two and for three dimensions.

pub use forms_core::contract::Dim;
use forms_core::contract::Dimension as Compiled;

/// A dimension of space: `Dim: Dimension<D>` holds for D = 2 and D = 3. Code that is generic over D writes this one
/// bound, however many forms it uses:
///
/// ```
/// use forms_fem::prelude::*;
///
/// #[forms]
/// mod heat {
///     #[cells]
///     pub struct Omega;
///     pub fn content(u: State<Scalar>) -> Functional { integral(Omega, u) }
/// }
///
/// /// The integral of a field, and its L² norm.
/// fn content_and_norm<const D: usize>(assembler: &Assembler<D>, u: &Field<D>) -> Result<[f64; 2], AssemblyError>
/// where
///     Dim: Dimension<D>,
/// {
///     let content = assembler.functional(&heat::content(&heat::Omega::on("all"), u))?;
///     Ok([content, norms::l2_norm(assembler, u)?])
/// }
/// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [2, 1], CellShape::Triangle, 1).unwrap();
/// # let space = Space::scalar(&mesh, 1).unwrap();
/// # let one = Field::from_values(&space, vec![1.0; 6]).unwrap();
/// # let found = content_and_norm(&Assembler::new(space.mesh()), &one).unwrap();
/// # assert!((found[0] - 2.0).abs() < 1e-14 && (found[1] - 2.0_f64.sqrt()).abs() < 1e-14);
/// ```
pub trait Dimension<const D: usize>: Compiled<D> {}

impl Dimension<2> for Dim {}
impl Dimension<3> for Dim {}
