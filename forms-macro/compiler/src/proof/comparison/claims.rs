//! Claims of the compiler about an integral: constant, linear or symmetric, its cost, its zeros.

use super::{Comparison, Difference, MAGNITUDE, TOLERANCE, Tally};
use crate::proof::assembly::{Basis, Points, bilinear, linear, reads};
use crate::proof::emitted::Integral;

impl Comparison<'_> {
    /// Proved properties of single integrals hold: their sums have been compared already.
    pub(super) fn claims(&self, tally: &mut Tally) -> Result<(), Difference> {
        let [first, second] = &self.nodes;
        let states = |run: &dyn Fn(&Points) -> Vec<f64>| [run(&self.here), run(&self.elsewhere)];
        for integral in self.emitted.residual.iter().filter(|integral| integral.dependence == "Constant") {
            let [here, elsewhere] = states(&|points| linear(&integral.kernel, points, first));
            self.same("a constant residual", &here, &elsewhere, tally)?;
        }
        // A linear integral is affine in the unknowns: half way it is the mean.
        let mut halfway = self.here.clone();
        for ((_, point), (_, other)) in halfway.iter_mut().zip(&self.elsewhere) {
            let numbers = point.fields.iter_mut().flatten().flatten().flatten();
            let others = other.fields.iter().flatten().flatten().flatten();
            numbers.zip(others).for_each(|(number, other)| *number = 0.5 * (*number + other));
        }
        for integral in self.emitted.residual.iter().filter(|integral| integral.dependence == "Linear") {
            let [here, elsewhere] = states(&|points| linear(&integral.kernel, points, first));
            let mean: Vec<f64> = here.iter().zip(&elsewhere).map(|(a, b)| 0.5 * (a + b)).collect();
            self.same("a linear residual", &mean, &linear(&integral.kernel, &halfway, first), tally)?;
        }
        for integral in self.emitted.residual.iter().chain(&self.emitted.action) {
            self.counted(integral, &["point", "test"])?;
        }
        for integral in &self.emitted.tangent {
            self.counted(integral, &["point", "test", "trial", "pair", "finish"])?;
            self.structure(integral, &bilinear(&integral.kernel, &self.here, first, second))?;
            match integral.dependence.as_str() {
                "Constant" => return Err(format!("`{}` has a tangent of a load", self.name)),
                "Linear" => {
                    let [here, elsewhere] =
                        states(&|points| bilinear(&integral.kernel, points, first, second));
                    self.same("a linear integral's tangent", &here, &elsewhere, tally)?;
                }
                _ => {}
            }
            if integral.symmetric != integral.kernel.constants["SYMMETRIC"].truth() {
                return Err(format!("`{}`: kernel and integral differ on symmetry", self.name));
            }
            if integral.symmetric {
                let size = integral.kernel.constants["TEST_COMPONENTS"].index();
                let block = |a: &Basis, b: &Basis| bilinear(&integral.kernel, &self.here, a, b);
                let (here, there) = (block(first, second), block(second, first));
                let transposed: Vec<f64> =
                    (0..size * size).map(|entry| there[entry % size * size + entry / size]).collect();
                self.same("a symmetric tangent", &here, &transposed, tally)?;
            }
        }
        Ok(())
    }

    /// The stated cost of a kernel's functions is the number of operations in them.
    pub(super) fn counted(&self, integral: &Integral, methods: &[&str]) -> Result<(), Difference> {
        for method in methods {
            let claimed = integral.kernel.constants["OPERATIONS"].member(method).index();
            let found = integral.kernel.operations(method);
            if claimed != found {
                return Err(format!("`{method}` of `{}` has {found} operations, not {claimed}", self.name));
            }
        }
        Ok(())
    }

    /// Entries that are proved zero are zero; a kernel with constant coefficients asks for nothing that varies.
    pub(super) fn structure(&self, integral: &Integral, block: &[f64]) -> Result<(), Difference> {
        let constants = &integral.kernel.constants;
        let nonzero = constants["NONZERO"].list();
        let wrong = block.iter().zip(nonzero).any(|(entry, nonzero)| !nonzero.truth() && *entry != 0.0);
        if wrong || nonzero.len() != block.len() {
            return Err(format!("`{}`: the block is {block:?}, but {nonzero:?}", self.name));
        }
        let required = &constants["REQUIREMENTS"];
        let varies = ["position", "normal", "curvature"].iter().any(|name| reads(&integral.kernel, name));
        if constants["CELL_CONSTANT"].truth() && (varies || !required.member("fields").list().is_empty()) {
            return Err(format!("`{}`: coefficients that vary are called constant", self.name));
        }
        Ok(())
    }

    pub(super) fn same(&self, what: &str, a: &[f64], b: &[f64], tally: &mut Tally) -> Result<(), Difference> {
        let scale = a.iter().chain(b).fold(1.0, |largest: f64, entry| largest.max(entry.abs()));
        for (a, b) in a.iter().zip(b) {
            if !a.is_finite() || !b.is_finite() || scale > MAGNITUDE {
                tally.skipped += 1;
                continue;
            }
            tally.compared += 1;
            if (a - b).abs() > TOLERANCE * scale {
                return Err(format!("{what} of `{}`: {a} and {b}", self.name));
            }
        }
        Ok(())
    }
}
