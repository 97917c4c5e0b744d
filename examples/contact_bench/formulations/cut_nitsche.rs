//! Nitsche's method on a body that is cut from a mesh by a level set function, with a ghost penalty, as in `forms_contact::laws::cut_nitsche`.

use contact_bench::outcome::not_defined;
use contact_bench::{Case, Formulation, Membrane, Meshing, Outcome, Refusal};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    use contact_bench::body::{obstacle_distance, obstacle_stress, stiffness, stress, weight};
    use forms_contact::operators::ghost_penalty::vector_ghost;
    #[includes(contact_bench::body::Data, forms_contact::operators::ghost_penalty::Data)]
    pub struct Data {
        theta: Param,
        level: Given<Scalar>,
    }
    #[interface]
    pub struct Inside;
    #[interior_facets]
    pub struct Ghost;
    fn pressed(stress: Scalar, u: Vector) -> Scalar {
        neg_part(stress + 13 * stiffness() * obstacle_distance(u))
    }
    pub fn on_obstacle(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let p = pressed(obstacle_stress(u), u);
        let consistent = theta / (13 * stiffness()) * (obstacle_stress(u) + p) * obstacle_stress(v);
        integral(Inside, weight() * (p * dot(v, obstacle_normal) - consistent))
            + integral(Ghost, avg(weight() * (2 * mu + lambda)) * vector_ghost(u, v))
    }
    pub fn pressure(u: State<Vector>) -> Scalar {
        pressed(dot(stress(u) * normalize(grad(level)), obstacle_normal), u)
    }
}

#[forms(dimension = 2)]
mod volume {
    pub use contact_bench::volume::Omega;
    use contact_bench::volume::height;
    #[includes(contact_bench::volume::Data)]
    pub struct Data {
        theta: Param,
    }
    fn gamma() -> Scalar {
        200 / (h * h)
    }
    fn laplacian(u: Scalar) -> Scalar {
        div(grad(u))
    }
    pub fn force(u: Scalar) -> Scalar {
        neg_part(laplacian(u) + gamma() * height(u))
    }
    pub fn above(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, -force(u) * v - theta / gamma() * (laplacian(u) + force(u)) * laplacian(v))
    }
}

/// Nitsche's method on a cut body with a θ.
pub struct CutNitsche {
    theta: f64,
}

/// θ = −1 and 0: with θ = 1 the parameter has a threshold that thin cells raise.
pub fn all() -> Vec<CutNitsche> {
    [-1.0, 0.0].map(|theta| CutNitsche { theta }).into()
}

impl Formulation for CutNitsche {
    fn name(&self) -> String {
        format!("cut, nitsche θ = {}", self.theta)
    }

    fn meshing(&self) -> Meshing {
        Meshing::Cut
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        let Some(body) = &case.cut else {
            return Err(not_defined("the mesh fits the body"));
        };
        let data = law::data_from(case.data.clone()).theta(self.theta).level(&body.level);
        let form = law::on_obstacle(&data, &law::Inside::on("all"), &law::Ghost::on("ghost"));
        case.newton(&form, |u| law::pressure(&data, u))
    }

    fn cover(&self, membrane: &Membrane) -> Result<Outcome, Refusal> {
        let data = volume::data_from(membrane.data.clone()).theta(self.theta);
        membrane.newton(&volume::above(&data, &membrane.omega()), |u| volume::force(&data, u))
    }
}
