//! Spectral functions of tensors: against energies, differences and identities.

use forms_core::forms;
use toy_backend::contract::{Dim, Dimension, Entity};

use crate::{LAMBDA, MU, State, close};
use toy_backend::{Nodal, expression};

#[forms(crate = toy_backend)]
pub mod hencky {
    pub struct Data {
        mu: Param,
        lambda: Param,
    }
    #[cells]
    pub struct Omega;

    fn strain(F: Tensor) -> Tensor {
        tensor_ln(transpose(F) * F) / 2
    }
    pub fn energy(u: Unknown<Vector>) -> Energy {
        let E = strain(I + grad(u));
        integral(Omega, mu * inner(E, E) + lambda / 2 * pow(tr(E), 2))
    }
    pub fn small(u: Unknown<Vector>) -> Energy {
        integral(Omega, mu * inner(eps(u), eps(u)) + lambda / 2 * pow(div(u), 2))
    }
    /// tr ln C = ln det C.
    pub fn volume(u: Vector) -> Scalar {
        let F = I + grad(u);
        tr(strain(F)) - ln(det(F))
    }
    /// F = R U: RᵀR − I, and U U − FᵀF.
    pub fn rotation_error(u: Vector) -> Tensor {
        let F = I + grad(u);
        let R = F * inv(tensor_sqrt(transpose(F) * F));
        transpose(R) * R - I
    }
    pub fn stretch_error(u: Vector) -> Tensor {
        let F = I + grad(u);
        let U = tensor_sqrt(transpose(F) * F);
        U * U - transpose(F) * F
    }
    pub fn inverse_error(u: Vector) -> Tensor {
        let F = I + grad(u);
        tensor_exp(tensor_ln(transpose(F) * F)) - transpose(F) * F
    }
}

fn spectral<const D: usize>(seed: u64)
where
    Dim: Dimension<D>,
{
    let state = State::<D>::new(seed);
    let data = hencky::data::<D>().mu(MU).lambda(LAMBDA);
    let omega = hencky::Omega::on("all");
    let energy = hencky::energy(&data, &omega);
    state.of_energy(&energy, &state.u);
    state.differences(&energy, &state.u);
    state.lanes(&energy, &state.u);
    // At u = 0 all eigenvalues are equal, and the tangent is that of linear elasticity.
    let zero = [Nodal { components: D, values: vec![0.0; state.u[0].values.len()] }];
    state.agree(&energy, &hencky::small(&data, &omega), &zero);

    let all = (Entity::Cells, "all");
    let source = || state.u[0].source::<D>();
    let vanish = |values: Vec<Vec<f64>>| {
        let values = values.concat();
        close(&values, &vec![0.0; values.len()], 1e-13, "identity");
    };
    vanish(expression(&state.mesh, &hencky::volume(&data, source()), all));
    vanish(expression(&state.mesh, &hencky::rotation_error(&data, source()), all));
    vanish(expression(&state.mesh, &hencky::stretch_error(&data, source()), all));
    vanish(expression(&state.mesh, &hencky::inverse_error(&data, source()), all));
}

#[test]
fn spectral_functions_have_exact_derivatives() {
    spectral::<2>(7);
    spectral::<3>(8);
}
