//! Sliding contact on whole facets and on moving segments: microseconds per own facet of a residual and a tangent, at a new iterate each.
//!
//! `cargo run --release -p forms-bench --example moving_segments [-- CELLS]`
//!
//! A block on a longer slab, in space of tetrahedra, Nitsche's method with Coulomb's friction over both surfaces, one thread. The search for pairs is included.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_fem::assemble::Parts;
use forms_fem::contract::PairQuadrature;
use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use forms_fem::threads::Threads;

#[forms]
mod elastic {
    use forms_contact::operators::friction::{augmented_traction, contact_traction};
    use forms_contact::operators::linear_elastic::stress;

    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
        kappa: Param,
        old: Given<Vector>,
    }
    #[pairs]
    pub struct Touch;

    fn contact(u: Vector) -> Vector {
        let P = augmented_traction(this(stress(u) * n), gap, jump(u - old), gamma0 / this(h), toward);
        contact_traction(P, kappa * neg_part(dot(P, toward)), toward)
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        -integral(Touch(u), dot(contact(u), jump(v)) / 2)
    }
}

/// The least of some times, each of a run at another iterate.
fn least(
    runs: usize,
    mut run: impl FnMut(usize) -> Result<(), Box<dyn Error>>,
) -> Result<f64, Box<dyn Error>> {
    let mut least = f64::INFINITY;
    for number in 0..runs {
        let start = Instant::now();
        run(number)?;
        least = least.min(start.elapsed().as_secs_f64());
    }
    Ok(least)
}

/// The lines of two bodies, whose surfaces touch where the upper one is moved.
fn lines<const D: usize>(
    out: &mut StandardOutput,
    [slab, block]: [&Mesh<D>; 2],
    (degree, quadrature): (usize, Quadrature<D>),
    form: impl Fn(Pairing, &Field<D>) -> Form<D>,
) -> Result<(), Box<dyn Error>> {
    let mesh = Mesh::of_bodies(&[("slab", slab), ("block", block)])?;
    let space = Space::vector(&mesh, degree)?;
    let states: Vec<Field<D>> = (0..12)
        .map(|k| {
            let phase = 1e-4 * f64::from(k);
            Field::interpolate(&space, |x| {
                let mut u = [0.0; D];
                if x[D - 1] > 0.01005 {
                    u[D - 1] = -3e-4 + 5e-5 * (20.0 * x[0] + phase).sin();
                }
                u
            })
        })
        .collect::<Result<_, _>>()?;
    for places in [PairQuadrature::WholeFacets, PairQuadrature::Pieces] {
        let pairing = Pairing::between("slab top", "block bottom").at(places);
        let facets = mesh.facet_region("slab top")?.len() + mesh.facet_region("block bottom")?.len();
        let form = form(pairing.clone(), &Field::zero(&space));
        let assembler = Assembler::new(&mesh).with_threads(Threads::ONE).with_quadrature(quadrature.clone());
        let tests = [&space];
        let pattern = assembler.pattern(&form, &tests, &tests)?;
        let mut matrix = BlockMatrix::zero(pattern.sparsity());
        let search = least(states.len(), |k| {
            assembler.pairs_at(&pairing, 0, &states[k])?;
            Ok(())
        })?;
        let residual = least(states.len(), |k| {
            assembler.residual(&form, &[&states[k]], &tests)?;
            Ok(())
        })?;
        let tangent = least(states.len(), |k| {
            Ok(assembler.assemble_tangent(&form, &[&states[k]], &tests, Parts::ALL, &pattern, &mut matrix)?)
        })?;
        let report = assembler.pairs_at(&pairing, 0, &states[0])?;
        let micro = |seconds: f64| 1e6 * seconds / facets as f64;
        out.line(format!(
            "| {:?} {degree} | {places:?} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} |",
            mesh.cell_shape(0),
            report.segments as f64 / facets as f64,
            report.points as f64 / facets as f64,
            micro(search),
            micro(residual),
            micro(tangent)
        ));
    }
    Ok(())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let count: usize = std::env::args().nth(1).map_or(Ok(1000), |count| count.parse())?;
    out.line("| elements | rule | segments | points | search | residual | tangent |");
    for (shape, degree) in
        [(CellShape::Quadrilateral, 1), (CellShape::Quadrilateral, 2), (CellShape::Triangle, 2)]
    {
        let slab = rectangle([0.0, 0.0], [2.0, 0.01], [count, 2], shape, 1)?;
        let block = rectangle([0.3, 0.0101], [1.7, 0.02], [(0.9 * count as f64) as usize, 2], shape, 1)?;
        lines(out, [&slab, &block], (degree, Quadrature::Degree(2 * degree + 1)), |pairing, none| {
            let data = elastic::data().lambda(115.4).mu(76.9).gamma0(4e3).kappa(0.3).old(none);
            elastic::balance(&data, &elastic::Touch::on(pairing))
        })?;
    }
    let shape = CellShape::Tetrahedron;
    for degree in [1, 2] {
        let cells = (count / (25 * degree)).max(4);
        let fewer = cells * 6 / 10;
        let slab = cuboid([0.0; 3], [2.0, 2.0, 0.01], [cells, cells, 1], shape, 1)?;
        let block = cuboid([0.3, 0.3, 0.0101], [1.7, 1.7, 0.02], [fewer, fewer, 1], shape, 1)?;
        lines(out, [&slab, &block], (degree, Quadrature::Degree(2 * degree)), |pairing, none| {
            let data = elastic::data().lambda(115.4).mu(76.9).gamma0(4e3).kappa(0.3).old(none);
            elastic::balance(&data, &elastic::Touch::on(pairing))
        })?;
    }
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
