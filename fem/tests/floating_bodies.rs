//! Singular problems told by what floats: one of several bodies with its motions, a rigid tool that no integral of an unknown reaches.

use forms_fem::constraints::RigidMap;
use forms_fem::mesh::RigidSurface;
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod warm {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Loaded;

    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(eps(u), eps(v))) + integral(Loaded, dot(n, v))
    }

    pub fn thermoelasticity(
        u: Unknown<Vector>,
        t: Unknown<Scalar>,
        v: Test<Vector>,
        s: Test<Scalar>,
    ) -> Form {
        integral(Omega, inner(eps(u) - t * I, eps(v)) + dot(grad(t), grad(s)) - s)
    }
}

fn slab() -> Mesh<2> {
    rectangle([0.0, 0.0], [3.0, 1.0], [6, 2], CellShape::Quadrilateral, 1).unwrap()
}

fn loaded_punch() -> warm::Model {
    warm::Model { regions: warm::Regions::default().loaded("punch top") }
}

/// Two blocks, the upper one held by nothing, or guided by its top.
#[test]
fn a_free_body_is_named_with_its_motions() {
    let punch = rectangle([1.0, 1.0], [2.0, 2.0], [2, 2], CellShape::Triangle, 1).unwrap();
    let mesh = Mesh::of_bodies(&[("slab", &slab()), ("punch", &punch)]).unwrap();
    for degree in [1, 2] {
        let space = Space::vector(&mesh, degree).unwrap();
        let told = |hold: &dyn Fn(&mut Constraints<2>)| {
            let mut constraints = Constraints::new(&space);
            constraints.fix("slab bottom", |_| [0.0; 2]).unwrap();
            hold(&mut constraints);
            let form = loaded_punch().elasticity();
            let solved = Problem::new(&form, &space).constrained(&constraints).solve();
            solved.map(|_| ()).unwrap_err().to_string()
        };
        let free = told(&|_| ());
        let motions = "the body \"punch\" can move rigidly: translation along x, translation along y, rotation about (1.5, 1.5). ";
        assert!(free.contains(motions) && free.contains("`Assembler::first_touch`"), "{free}");
        let guided = told(&|constraints| constraints.fix_component("punch top", 0, |_| 0.0).unwrap());
        assert!(
            guided.contains(
                "the body \"punch\" can move rigidly: translation along y, rotation about (1.5, 2). "
            ),
            "{guided}"
        );
    }
    // The lower one is free, too: each is named by itself.
    let space = Space::vector(&mesh, 1).unwrap();
    let form = loaded_punch().elasticity();
    let error = Problem::new(&form, &space).solve().unwrap_err().to_string();
    assert!(error.contains("the body \"punch\"") || error.contains("the body \"slab\""), "{error}");
}

/// A body whose cells have no name of their own.
#[test]
fn a_free_body_without_a_name() {
    let nodes = [0.0, 2.0]
        .into_iter()
        .flat_map(|left| [[left, 0.0], [left + 1.0, 0.0], [left + 1.0, 1.0], [left, 1.0]]);
    let cells = vec![0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7];
    let mut mesh = Mesh::from_parts(CellShape::Triangle, 1, nodes.collect(), cells).unwrap();
    mesh.name_facets("held", "boundary", |x| x[0] < 1e-9).unwrap();
    mesh.name_facets("loaded", "boundary", |x| x[0] > 3.0 - 1e-9).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix("held", |_| [0.0; 2]).unwrap();
    let form = warm::Model::default().elasticity();
    let error = Problem::new(&form, &space).constrained(&constraints).solve().unwrap_err().to_string();
    let motions = "the body there can move rigidly: translation along x, translation along y, rotation about (2.5, 0.5)";
    assert!(error.contains(motions), "{error}");
}

/// An unknown on a mesh with a rigid tool: the tool is named with what to do, and that helps.
#[test]
fn a_tool_is_named_with_what_to_do() {
    let tool = RigidSurface::along(&[[0.5, 1.2], [1.5, 1.1]]).unwrap();
    let mesh = slab().with_rigid_surfaces(&[("tool", &tool)]).unwrap();
    let (displacements, temperatures) = (Space::vector(&mesh, 2).unwrap(), Space::scalar(&mesh, 1).unwrap());
    let form = warm::Model::default().thermoelasticity();
    let solve = |moved: bool, given: bool| {
        let mut held = Constraints::new(&displacements);
        held.fix("bottom", |_| [0.0; 2]).unwrap();
        if moved {
            held.move_rigidly("tool", &RigidMap::translation([0.0, -0.1])).unwrap();
        }
        let mut cooled = Constraints::new(&temperatures);
        cooled.fix("bottom", |_| 0.0).unwrap();
        if given {
            cooled.fix("tool", |_| 0.0).unwrap();
        }
        let mut problem = Problem::new(&form, [&displacements, &temperatures]);
        problem = problem.constrained(&held).constrained(&cooled);
        problem.solve().map(|_| ()).map_err(|error| error.to_string())
    };
    let unread = solve(true, false).unwrap_err();
    assert!(unread.contains("of `t`") || unread.contains("`t` at"), "{unread}");
    assert!(
        unread.contains("the rigid surface \"tool\", where no integral reads this unknown")
            && unread.contains("constraints.fix(\"tool\", |_| 0.0)"),
        "{unread}"
    );
    let unmoved = solve(false, true).unwrap_err();
    assert!(
        unmoved.contains("the rigid surface \"tool\", whose motion is not given")
            && unmoved.contains("move_rigidly"),
        "{unmoved}"
    );
    solve(true, true).unwrap();
}
