//! Sliding contact on whole facets and on moving segments: microseconds per own facet of a residual and a tangent, at a new iterate each.
//!
//! `cargo run --release -p forms-bench --example moving_segments [-- CELLS]`
//!
//! A block on a longer slab, Nitsche's method with Coulomb's friction over both surfaces, one thread. The search for pairs is included.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_fem::assemble::Parts;
use forms_fem::contract::PairQuadrature;
use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;
use forms_fem::threads::Threads;

#[forms(dimension = 2)]
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

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let count: usize = std::env::args().nth(1).map_or(Ok(1000), |count| count.parse())?;
    out.line("| elements | rule | points | residual | tangent |");
    for (shape, degree) in
        [(CellShape::Quadrilateral, 1), (CellShape::Quadrilateral, 2), (CellShape::Triangle, 2)]
    {
        let slab = rectangle([0.0, 0.0], [2.0, 0.01], [count, 2], shape, 1)?;
        let block = rectangle([0.3, 0.0101], [1.7, 0.02], [(0.9 * count as f64) as usize, 2], shape, 1)?;
        let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)])?;
        let space = Space::vector(&mesh, degree)?;
        let none = Field::zero(&space);
        let states: Vec<Field<2>> = (0..12)
            .map(|k| {
                let phase = 1e-4 * f64::from(k);
                Field::interpolate(&space, |x| {
                    [0.0, if x[1] > 0.01005 { -3e-4 + 5e-5 * (20.0 * x[0] + phase).sin() } else { 0.0 }]
                })
            })
            .collect::<Result<_, _>>()?;
        for quadrature in [PairQuadrature::WholeFacets, PairQuadrature::Pieces] {
            let pairing = Pairing::between("slab top", "block bottom").at(quadrature);
            let facets = mesh.facet_region("slab top")?.len() + mesh.facet_region("block bottom")?.len();
            let data = elastic::data().lambda(115.4).mu(76.9).gamma0(4e3).kappa(0.3).old(&none);
            let form = elastic::balance(&data, &elastic::Touch::on(pairing.clone()));
            let assembler = Assembler::new(&mesh)
                .with_threads(Threads::ONE)
                .with_quadrature(Quadrature::Degree(2 * degree + 1));
            let tests = [&space];
            let pattern = assembler.pattern(&form, &tests, &tests)?;
            let mut matrix = BlockMatrix::zero(pattern.sparsity());
            let residual = least(states.len(), |k| {
                assembler.residual(&form, &[&states[k]], &tests)?;
                Ok(())
            })?;
            let tangent = least(states.len(), |k| {
                assembler.assemble_tangent(
                    &form,
                    &[&states[k]],
                    &tests,
                    Parts::ALL,
                    &pattern,
                    &mut matrix,
                )?;
                Ok(())
            })?;
            let points = assembler.pairs_at(&pairing, 2 * degree + 1, &states[0])?.points;
            let micro = |seconds: f64| 1e6 * seconds / facets as f64;
            out.line(format!(
                "| {shape:?} {degree} | {quadrature:?} | {:.2} | {:.2} | {:.2} |",
                points as f64 / facets as f64,
                micro(residual),
                micro(tangent)
            ));
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
