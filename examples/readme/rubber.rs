//! A bar of rubber, stretched.
use forms_fem::prelude::*;

#[forms]
mod rubber {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
    }
    #[cells]
    pub struct Omega;
    fn density(F: Tensor) -> Scalar {
        let J = det(F);
        mu / 2 * (inner(F, F) - D) - mu * ln(J) + lambda / 2 * pow(ln(J), 2)
    }
    pub fn energy(u: Unknown<Vector>) -> Energy {
        integral(Omega, density(I + grad(u)))
    }
    pub fn stress(u: State<Vector>) -> Tensor {
        let F = I + grad(u);
        diff(density(F), F)
    }
}

fn main() -> Result<(), Failure> {
    let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [8, 4, 4], CellShape::Hexahedron, 1)?;
    let space = Space::vector(&mesh, 1)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix("left", |_| [0.0; 3])?;
    constraints.fix("right", |_| [0.5, 0.0, 0.0])?;
    let model = rubber::Model::new(rubber::data().lambda(3.0).mu(1.0));
    let solved = Problem::new(&model.energy(), &space).constrained(&constraints).solve()?;
    println!("{:?}", solved.at_points(&model.stress(solved.field()), &[[1.0, 0.5, 0.5]])?.values[0]);
    Ok(())
}
