//! The ring with displacements only, for comparison.

use forms_fem::forms;

/// It locks where degree or mesh are not fine enough.
#[forms(dimension = 2)]
pub mod displacement {
    use forms_contact::laws::frictional_nitsche::{augmented, law};
    pub use forms_contact::laws::mixed_nitsche::{Data, GammaC, Omega};
    use forms_contact::operators::rubber::{energy_density, first_piola};

    /// The direct problem.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, derivative(energy_density(u), u, v))
            - integral(GammaC, dot(law(augmented(first_piola(u) * n, u)), v))
    }
}
