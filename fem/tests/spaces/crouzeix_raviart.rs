//! Crouzeix and Raviart's element: one node per facet, continuous in the mean over each facet.

use forms_fem::prelude::*;

use crate::shared::*;

#[forms]
mod jumps {
    #[interior_facets]
    pub struct Skeleton;

    pub fn mean_jump(u: State<Scalar>, m: Test<Scalar>) -> Form {
        integral(Skeleton, this(m) * jump(u))
    }
    pub fn square(u: State<Scalar>) -> Functional {
        integral(Skeleton, sqr(jump(u)))
    }
}

fn check_jumps<const D: usize>(mesh: &Mesh<D>) -> Outcome
where
    Dim: Dimension<D>,
{
    let space = Space::of(mesh, Elements::CrouzeixRaviart, Scope::Nodes, &[])?;
    assert_eq!(space.node_count(), mesh.interior_facets().len() + mesh.boundary_facets().len());
    assert_eq!(space.nodes_on("boundary")?.len(), mesh.boundary_facets().len());
    assert!(largest_error(&space, |x: &[f64; D]| 3.0 * x[0] - x[1] + 0.5) < 1e-13);
    let u = Field::from_values(&space, noise(space.unknowns()))?;
    let facets = Space::on_facets(mesh, "interior", 0)?;
    let skeleton = jumps::Skeleton::on("interior");
    let assembler = Assembler::new(mesh);
    let means = assembler.residual(&jumps::mean_jump(&skeleton, &u), &[], &[&facets])?;
    assert!(means.iter().all(|mean| mean.abs() < 1e-15));
    // All functions are seen on all facets: the jumps themselves do not vanish.
    assert!(assembler.functional(&jumps::square(&skeleton, &u))? > 0.1);
    Ok(())
}

#[test]
fn jumps_vanish_in_the_mean() -> Outcome {
    check_jumps(&distorted(4, CellShape::Triangle, 1))?;
    check_jumps(&distorted_cube(2, CellShape::Tetrahedron, 1))
}

#[test]
fn poissons_problem_converges() {
    let check = |errors: [[f64; 2]; 2]| {
        for (k, expected) in [2.0, 1.0].into_iter().enumerate() {
            let order = (errors[0][k] / errors[1][k]).log2();
            println!("Crouzeix-Raviart: order {order:.2} of {expected}, error {:.2e}", errors[1][k]);
            assert!(order > expected - 0.2, "{order} instead of {expected}");
        }
    };
    let plane = |n| errors_of_poisson(&distorted(n, CellShape::Triangle, 1), &Elements::CrouzeixRaviart);
    check([8, 16].map(plane));
    let solid =
        |n| errors_of_poisson(&distorted_cube(n, CellShape::Tetrahedron, 1), &Elements::CrouzeixRaviart);
    check([4, 8].map(solid));
}

#[test]
fn stokes_flow_with_constant_pressures_converges() {
    let errors = [8, 16].map(|n| {
        let mesh = distorted(n, CellShape::Triangle, 1);
        errors_of_stokes(
            &mesh,
            (Elements::CrouzeixRaviart, Scope::Nodes),
            (Elements::Lagrange(0), Scope::Cell),
        )
    });
    for (k, expected) in [2.0, 1.0, 1.0].into_iter().enumerate() {
        let order = (errors[0][k] / errors[1][k]).log2();
        assert!(order > expected - 0.25, "{order} instead of {expected}");
    }
}

#[test]
fn tangents_are_symmetric_and_of_second_order() {
    let mesh = distorted(3, CellShape::Triangle, 2);
    check_flow(&mesh, (Elements::CrouzeixRaviart, Scope::Nodes), (Elements::Lagrange(0), Scope::Cell));
}

#[test]
fn traces_are_refused_by_name() -> Outcome {
    let mesh = distorted(2, CellShape::Triangle, 1);
    let on_facets = Space::of(&mesh, Elements::CrouzeixRaviart, Scope::Facets("boundary".into()), &[]);
    assert_eq!(
        on_facets.unwrap_err().to_string(),
        "there is no space of Crouzeix-Raviart elements on the facet region \"boundary\": the nodes on a facet do not \
         determine the values there"
    );
    // A field that jumps has a value per cell in files.
    let space = Space::of(&mesh, Elements::CrouzeixRaviart, Scope::Nodes, &[])?;
    let field = Field::from_values(&space, noise(space.unknowns()))?;
    let file = tempfile::NamedTempFile::new()?;
    forms_fem::output::VtuFile::new(&mesh).point_data("u", &field)?.write(file.path())?;
    let text = std::fs::read_to_string(file.path())?;
    assert!(text.contains(&format!("NumberOfPoints=\"{}\"", 3 * mesh.cell_count())), "{}", &text[..400]);
    Ok(())
}
