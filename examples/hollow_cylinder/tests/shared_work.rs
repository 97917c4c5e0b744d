//! Counted speed-ups of the cylinder, from patterns and meshes: nothing is factored.

use forms_contact_problem::hollow_cylinder::{Settings, hollow_cylinder};
use forms_fem::linear_algebra::{Analysis, Ordering, SharedWork};
use forms_fem::prelude::*;
use forms_fem::solve::{Elimination, NonlinearProblem};

/// Largest speed-ups of factorisation, solve, assembly, evaluation and projection by 16 threads.
fn on_sixteen(radial: usize) -> [f64; 5] {
    let problem = hollow_cylinder(&Settings { radial, ..Settings::default() }).expect("a problem");
    let (space, assembler) = (&problem.space, &problem.assembler);
    let prescribed = problem.constraints.prescribed();
    let mut elimination = Elimination::new(space.unknowns(), prescribed).expect("free unknowns");
    let mut direct = problem.direct().expect("a problem");
    let tangent = direct.tangent(&vec![0.0; space.unknowns()]).expect("a tangent");
    let matrix = elimination.reduce_matrix(&tangent.matrix).expect("its free part");
    drop(direct);
    let (analysis, _) = Analysis::of_symmetric(&matrix, &Ordering::default()).expect("an order");
    let scalars = Space::scalar(space.mesh(), 2).expect("a space");
    let found = [
        analysis.factorisation_work(),
        analysis.solve_work(),
        assembler.assembly_work(),
        assembler.evaluation_work(),
        assembler.projection_work(&scalars),
    ];
    let names = ["factorisation", "solve", "assembly", "evaluation", "projection"];
    for (work, name) in found.iter().zip(names) {
        let speed_ups = SharedWork::THREADS.map(|threads| work.speed_up(threads).expect("a count"));
        println!("{radial} {name}: {:.3e} {:.3e} {speed_ups:.1?}", work.work, work.critical_path);
    }
    found.map(|work| work.speed_up(16).expect("a count"))
}

#[test]
fn sixteen_threads_share_the_work_on_a_mesh_of_medium_size() {
    let [factorisation, solve, assembly, evaluation, _] = on_sixteen(64);
    assert!(factorisation >= 7.0, "{factorisation}");
    assert!(solve >= 8.0, "{solve}");
    assert!(assembly >= 14.0 && evaluation >= 14.0, "{assembly} {evaluation}");
}

#[test]
fn sixteen_threads_share_the_work_on_a_large_mesh() {
    let [factorisation, solve, others @ ..] = on_sixteen(160);
    assert!(factorisation >= 10.0, "{factorisation}");
    assert!(solve >= 8.0, "{solve}");
    assert!(others.iter().all(|found| *found >= 14.0), "{others:?}");
}
