//! A problem with a linear part, iterated on the few unknowns that its nonlinearity touches.

use super::*;
use crate::linear_algebra::{BlockMatrix, Transpose};
use crate::solve::{CondensedSolver, LinearSolution, LuSolver};

const N: usize = 64;
const H: f64 = 1.0 / N as f64;
/// Nodes above the bed.
const BED: std::ops::Range<usize> = 28..37;

/// −u'' = −8 on (0, 1) with an elastic bed of stiffness k below −1/4 at some nodes: R = K u + N(u) + R₀.
struct OnBed {
    linear: BlockMatrix,
    nonlinear: BlockMatrix,
    nodes: Vec<usize>,
}

impl OnBed {
    const STIFFNESS: f64 = 2000.0;

    fn new() -> Self {
        let mut triplets = vec![];
        for i in 0..=N {
            triplets.push((i, i, 2.0 / H));
            triplets.extend((i > 0).then_some((i, i.wrapping_sub(1), -1.0 / H)));
            triplets.extend((i < N).then_some((i, i + 1, -1.0 / H)));
        }
        let linear = CsrMatrix::from_triplets(N + 1, N + 1, &triplets).unwrap().into();
        OnBed { linear, nonlinear: Self::bed(&[0.0; N + 1]), nodes: BED.collect() }
    }

    fn overlap(u: &[f64], i: usize) -> f64 {
        (-0.25 - u[i]).max(0.0)
    }

    /// The derivative of N.
    fn bed(u: &[f64]) -> BlockMatrix {
        let slope = |i| if Self::overlap(u, i) > 0.0 { H * Self::STIFFNESS } else { 0.0 };
        let triplets: Vec<_> = BED.map(|i| (i, i, slope(i))).collect();
        CsrMatrix::from_triplets(N + 1, N + 1, &triplets).unwrap().into()
    }
}

impl NonlinearProblem for OnBed {
    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let mut residual = self.linear.multiply(u).map_err(AssemblyError::other)?;
        let nonlinear = self.nonlinear_residual(u)?;
        residual.iter_mut().zip(nonlinear).for_each(|(residual, own)| *residual += own + 8.0 * H);
        Ok(residual)
    }

    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        let bed = Self::bed(u).to_csr();
        let additions: Vec<_> = BED
            .map(|i| crate::linear_algebra::Entry { row: i as u32, column: i as u32, value: bed.get(i, i) })
            .collect();
        Ok(self.linear.to_csr().plus(&additions).map_err(AssemblyError::other)?.into())
    }

    fn partly_linear(&mut self) -> Option<&mut dyn PartlyLinear> {
        Some(self)
    }
}

impl PartlyLinear for OnBed {
    fn linear_part(&mut self) -> Result<Option<LinearPart<'_>>, AssemblyError> {
        Ok(Some(LinearPart { matrix: &self.linear, is_symmetric: false }))
    }

    fn nonlinear_residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let force = |i| if BED.contains(&i) { -H * Self::STIFFNESS * Self::overlap(u, i) } else { 0.0 };
        Ok((0..=N).map(force).collect())
    }

    fn nonlinear_tangent(&mut self, u: &[f64]) -> Result<Option<NonlinearTangent<'_>>, AssemblyError> {
        self.nonlinear = Self::bed(u);
        Ok(Some(NonlinearTangent { matrix: &self.nonlinear, rows: &self.nodes, reads: &self.nodes }))
    }
}

/// Delegates to a condensed solver, and says so or not.
struct Wrapped {
    solver: CondensedSolver,
    is_known: bool,
}

impl LinearSolver for Wrapped {
    fn set_matrix(&mut self, matrix: CsrMatrix) -> Result<(), SolverError> {
        self.solver.set_matrix(matrix)
    }

    fn solve_with(
        &mut self,
        b: &[f64],
        tolerance: f64,
        transpose: Transpose,
    ) -> Result<LinearSolution, SolverError> {
        self.solver.solve_with(b, tolerance, transpose)
    }

    fn as_condensed(&mut self) -> Option<&mut CondensedSolver> {
        self.is_known.then_some(&mut self.solver)
    }
}

/// Steps on few unknowns are those on all of them, and the history says on how many unknowns they were found. The condensed problem
/// grows as the bed is reached.
#[test]
fn few_unknowns_lead_the_same_way_as_all() {
    let run = |solver: &mut dyn LinearSolver| {
        let options = NewtonOptions::default();
        newton(&mut OnBed::new(), &ends(N), vec![0.0; N + 1], solver, &options, &mut |_| ()).unwrap()
    };
    let all = run(&mut LuSolver::default());
    assert!(all.u[32] < -0.25 && all.iterations() >= 2, "{:?}", all.history);
    let wrapped = |is_known| Wrapped { solver: CondensedSolver::default(), is_known };
    for (mut solver, is_condensed) in [(wrapped(true), true), (wrapped(false), false)] {
        let few = run(&mut solver);
        assert_eq!(few.iterations(), all.iterations());
        assert!(few.u.iter().zip(&all.u).all(|(a, b)| (a - b).abs() < 1e-12));
        for (few, all) in few.history.iter().zip(&all.history).skip(1) {
            // A residual below rounding of the forces is no number to compare.
            assert!((few.residual - all.residual).abs() <= 1e-10 * all.residual + 1e-11, "{few}\n{all}");
        }
        let sizes: Vec<_> = few.history.iter().map(|step| step.condensed_unknowns).collect();
        match is_condensed {
            true => assert_eq!(sizes[1..3], [Some(0), Some(BED.len())]),
            false => assert!(sizes.iter().all(|size| size.is_none())),
        }
    }
}
