//! Cost of the contact term of two bodies, per own facet: Nitsche's method over both surfaces, on meshes that do not match.
//!
//! `cargo run --release -p forms-bench --example contact_pairs [-- THREADS]`
//!
//! Fixed pairs are searched for once; sliding ones, with friction, at each iterate, with lists of candidates that are new or kept from
//! the iterate before. Residual and tangent are those of the contact integrals alone, insertion included, without the search.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use forms_fem::assemble::BlockPattern;
use forms_fem::contract::PairQuadrature;
use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::output::{StandardOutput, program};
use forms_fem::pairs::PairError;
use forms_fem::prelude::*;

#[forms]
mod nitsche {
    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
        theta: Param,
    }
    #[pairs]
    pub struct Touch;

    fn normal_stress(w: Vector) -> Scalar {
        let s = lambda * div(w) * I + 2 * mu * eps(w);
        dot(this(s * n), toward)
    }

    fn gamma() -> Scalar {
        gamma0 / this(h)
    }

    pub fn contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let T = -neg_part(normal_stress(u) - gamma() * (dot(jump(u), toward) - gap));
        integral(
            Touch,
            0.5 * (T / gamma() * (theta * normal_stress(v) - gamma() * dot(jump(v), toward))
                - theta / gamma() * normal_stress(u) * normal_stress(v)),
        )
    }
}

#[forms]
mod rubber {
    use forms_contact::operators::friction::{augmented_traction, contact_traction, deformed_normal};
    use forms_contact::operators::neo_hookean::first_piola;

    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
        kappa: Param,
        old: Given<Vector>,
    }
    #[pairs]
    pub struct Touch;

    /// Contact and Coulomb's friction at large sliding (Poulios and Renard 2015).
    pub fn contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let slip = jump(u - old) + gap * (toward - this(deformed_normal(old)));
        let P = augmented_traction(this(first_piola(u) * n), gap, slip, gamma0 / this(h), toward);
        let T = contact_traction(P, kappa * neg_part(dot(P, toward)), toward);
        -integral(Touch(u), dot(T, jump(v)) / 2)
    }
}

/// Least seconds of some runs.
fn best<E>(runs: usize, mut run: impl FnMut() -> Result<(), E>) -> Result<f64, E> {
    let mut best = f64::INFINITY;
    for _ in 0..runs {
        let start = Instant::now();
        run()?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(best)
}

/// Two meshes as one; the top of the first is "below", the bottom of the second "above".
fn stacked<const D: usize>(first: &Mesh<D>, second: &Mesh<D>) -> Result<Mesh<D>, Box<dyn Error>> {
    let mut nodes = first.nodes().to_vec();
    let start = nodes.len() as u32;
    nodes.extend(second.nodes());
    let others = second.cells().iter().map(|node| node + start).collect();
    let shape = first.cell_shape(0);
    let blocks = vec![(shape, first.cells().to_vec()), (shape, others)];
    let mut mesh = Mesh::from_nonconforming_blocks(first.degree(), nodes, blocks)?;
    mesh.name_listed_facets("below", first.facet_region("top")?)?;
    let count = first.cell_count() as u32;
    let moved = second.facet_region("bottom")?.iter();
    let above: Vec<Facet> = moved.map(|facet| Facet { cell: facet.cell + count, ..*facet }).collect();
    mesh.name_listed_facets("above", &above)?;
    Ok(mesh)
}

/// Seconds of a residual, and of a tangent into its pattern.
fn assembly<const D: usize>(
    assembler: &Assembler<D>,
    form: &Form<D>,
    u: &Field<D>,
    space: &Arc<Space<D>>,
) -> Result<[f64; 2], AssemblyError> {
    let pattern = BlockPattern::for_form(form, &[space], &[space])?;
    let mut matrix = BlockMatrix::zero(pattern.sparsity());
    let residual = best(20, || assembler.residual(form, &[u], &[space]).map(|_| ()))?;
    let tangent =
        best(10, || assembler.assemble_tangent(form, &[u], &[space], Parts::ALL, &pattern, &mut matrix))?;
    Ok([residual, tangent])
}

/// One row: search, residual and tangent of the contact term on degree-2 spaces.
fn measure<const D: usize>(
    out: &mut StandardOutput,
    name: &str,
    mesh: &Mesh<D>,
    quadrature: PairQuadrature,
    threads: Threads,
) -> Result<(), Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let pairing = Pairing::between("below", "above").at(quadrature);
    let facets = (mesh.facet_region("below")?.len() + mesh.facet_region("above")?.len()) as f64;
    let space = Space::vector(mesh, 2)?;
    let assembler = Assembler::new(mesh).with_threads(threads);
    let data = nitsche::data().lambda(100.0).mu(80.0).gamma0(2e4).theta(1.0);
    let form = nitsche::contact(&data, &nitsche::Touch::on(pairing.clone()));
    let u = Field::interpolate(&space, |x: &[f64; D]| {
        let mut value = [0.0; D];
        value[D - 1] = 0.01 * (x[0] - 0.5) * x[D - 1];
        value
    })?;
    let start = Instant::now();
    let points = assembler.pairs(&pairing, 4)?.points;
    let search = start.elapsed().as_secs_f64();
    let [residual, tangent] = assembly(&assembler, &form, &u, &space)?;
    let each = |seconds: f64| 1e6 * seconds / facets;
    out.line(format!(
        "| {name} | {facets} | {:.1} | {:.1} | {:.2} | {:.2} |",
        points as f64 / facets,
        each(search),
        each(residual),
        each(tangent)
    ));
    Ok(())
}

/// One row for pairs that slide: a search with new lists of candidates and one with those of an iterate near by, residual and tangent.
fn measure_sliding<const D: usize>(
    out: &mut StandardOutput,
    name: &str,
    mesh: &Mesh<D>,
    threads: Threads,
) -> Result<(), Box<dyn Error>>
where
    Dim: Dimension<D>,
{
    let pairing = Pairing::between("below", "above");
    let facets = (mesh.facet_region("below")?.len() + mesh.facet_region("above")?.len()) as f64;
    let space = Space::vector(mesh, 2)?;
    // The estimated degree of friction is above 20, that of the other rows 4.
    let degree = 4;
    let rule = Quadrature::Degree(degree);
    let assembler = Assembler::new(mesh).with_threads(threads).with_quadrature(rule.clone());
    let data = rubber::data().lambda(100.0).mu(80.0).gamma0(2e4).kappa(0.3).old([0.0; D]);
    let form = rubber::contact(&data, &rubber::Touch::on(pairing.clone()));
    let at = |shift: f64| {
        Field::interpolate(&space, |x: &[f64; D]| {
            let mut value = [shift; D];
            value[D - 1] = 0.01 * (x[0] - 0.5) * x[D - 1];
            value
        })
    };
    let u = at(0.0)?;
    let mut points = 0;
    let new = best(10, || {
        let fresh = Assembler::new(mesh).with_threads(threads).with_quadrature(rule.clone());
        points = fresh.pairs_at(&pairing, degree, &u)?.points;
        Ok::<_, PairError>(())
    })?;
    assembler.pairs_at(&pairing, degree, &u)?;
    let iterates: Vec<Field<D>> = (1..=10).map(|k| at(1e-7 * f64::from(k))).collect::<Result<_, _>>()?;
    let mut next = iterates.iter();
    let kept = best(10, || match next.next() {
        Some(u) => assembler.pairs_at(&pairing, degree, u).map(|_| ()),
        None => Ok(()),
    })?;
    let [residual, tangent] = assembly(&assembler, &form, &u, &space)?;
    let each = |seconds: f64| 1e6 * seconds / facets;
    out.line(format!(
        "| {name} | {facets} | {:.1} | {:.2} | {:.2} | {:.2} | {:.2} |",
        points as f64 / facets,
        each(new),
        each(kept),
        each(residual),
        each(tangent)
    ));
    Ok(())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let threads: Threads = std::env::args().nth(1).map_or(Ok(Threads::ONE), |count| count.parse())?;
    out.line(
        "| elements, points | own facets | points per facet | search, µs | residual, µs | tangent, µs |",
    );
    out.line("| --- | --- | --- | --- | --- | --- |");
    let triangles = |y: f64, count| rectangle([0.0, y], [1.0, y + 0.01], [count, 1], CellShape::Triangle, 1);
    let plane = stacked(&triangles(0.0, 3000)?, &triangles(0.01, 4000)?)?;
    measure(out, "triangles P2, pieces", &plane, PairQuadrature::Pieces, threads)?;
    measure(out, "triangles P2, whole facets", &plane, PairQuadrature::WholeFacets, threads)?;
    let tetrahedra = |z: f64, count| {
        cuboid([0.0, 0.0, z], [1.0, 1.0, z + 0.1], [count, count, 1], CellShape::Tetrahedron, 1)
    };
    let solid = stacked(&tetrahedra(0.0, 30)?, &tetrahedra(0.1, 40)?)?;
    measure(out, "tetrahedra P2, pieces", &solid, PairQuadrature::Pieces, threads)?;
    measure(out, "tetrahedra P2, whole facets", &solid, PairQuadrature::WholeFacets, threads)?;
    out.line("");
    out.line("| sliding | own facets | points per facet | search, new lists, µs | kept lists, µs | residual, µs | tangent, µs |");
    out.line("| --- | --- | --- | --- | --- | --- | --- |");
    measure_sliding(out, "triangles P2", &plane, threads)?;
    measure_sliding(out, "tetrahedra P2", &solid, threads)
}

fn main() -> ExitCode {
    program(run)
}
