//! The report: Markdown, charts, and the numbers as JSON.

use std::fmt::Write;
use std::io::Write as _;
use std::path::Path;

use forms_fem::output::picture::{BarChart, Picture};
use forms_fem::output::write_whole;
use serde::Serialize;

use super::bodies_tables;
use super::plain_names::plain_name;
use super::rows::{AssemblyRow, BodiesRow, ContactRow, KernelRow};
use super::{ComparisonError, Machine};
use crate::assembly::Measured;

/// Everything that was measured.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// The machine.
    pub machine: Machine,
    /// Few samples, and small meshes.
    pub quick: bool,
    /// Element kernels.
    pub kernels: Vec<KernelRow>,
    /// Whole assembly.
    pub assembly: Vec<AssemblyRow>,
    /// Updates of a contact tangent.
    pub contact: Vec<ContactRow>,
    /// Contact of two bodies.
    pub bodies: Vec<BodiesRow>,
    /// Peers that are not installed, and how to install them.
    pub missing: Vec<(String, String)>,
    /// Peers that failed.
    pub failures: Vec<String>,
}

/// The middle value; NaN of none.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

impl Report {
    /// The geometric mean of the kernels' ratios, NaN without any.
    pub fn geometric_mean(&self) -> f64 {
        let ratios: Vec<f64> = self.kernels.iter().filter_map(KernelRow::ratio).collect();
        (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64).exp()
    }

    /// The least ratio of a kernel with its name.
    pub fn slowest(&self) -> Option<(&str, f64)> {
        let ratios = self.kernels.iter().filter_map(|row| Some((row.form.as_str(), row.ratio()?)));
        ratios.min_by(|(_, a), (_, b)| a.total_cmp(b))
    }

    /// The tables as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = String::from("# Kernels and assembly compared with other programs\n\n");
        self.write_machine(&mut text);
        if !self.kernels.is_empty() {
            self.write_kernels(&mut text);
        }
        for row in &self.assembly {
            write_assembly(&mut text, row);
        }
        if !self.contact.is_empty() {
            self.write_contact(&mut text);
        }
        if !self.bodies.is_empty() {
            bodies_tables::write(&self.bodies, &mut text);
        }
        text
    }

    fn write_machine(&self, text: &mut String) {
        let Machine { processor, cores, instruction_set, architecture, versions } = &self.machine;
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{processor}, {cores} cores; the kernels of this library run with {instruction_set}, those of the others are compiled for {architecture}.\n"
        );
        for (name, version) in versions {
            let _ = writeln!(text, "- {name}: {version}");
        }
        if self.quick {
            text.push_str("- A quick run: few samples, small meshes\n");
        }
        for (name, install) in &self.missing {
            let _ = writeln!(text, "- {name} is not installed: {install}");
        }
        for failure in &self.failures {
            let _ = writeln!(text, "- failed: {}", failure.replace('\n', " "));
        }
        text.push('\n');
    }

    fn write_kernels(&self, text: &mut String) {
        text.push_str(
            "## Element kernels\n\nNanoseconds per element matrix, least of the samples, one thread. Variants of FFCx: \
             `old` is 0.5.0, `n` the instructions named above, `fm` -ffast-math, `sumfact` elements with sum factorisation. \
             Each form has one row, against FFCx's fastest variant. The error is the largest difference from FFCx \
             (gcc -O2) over the largest entry.\n\n\
             | form | here | FFCx, fastest variant | variant | ratio | FFCx -O2 | ratio | error |\n\
             |---|--:|--:|---|--:|--:|--:|--:|\n",
        );
        for row in &self.kernels {
            let (variant, best) = &row.best;
            let default = row.variants.get("gcc_O2").map_or(f64::NAN, |timing| timing.ns);
            let (ours, error) = row.ours.as_ref().map_or((f64::NAN, f64::NAN), |ours| (ours.ns, ours.relerr));
            let _ = writeln!(
                text,
                "| {} | {} | {} | {variant} | {:.1} | {} | {:.1} | {error:.0e} |",
                plain_name(&row.form),
                figures(ours),
                figures(best.ns),
                best.ns / ours,
                figures(default),
                default / ours,
            );
        }
        let _ = write!(
            text,
            "\nGeometric mean of the ratios to FFCx's fastest variant: **{:.2}**",
            self.geometric_mean()
        );
        if let Some((form, ratio)) = self.slowest() {
            let _ = write!(text, "; the least is {ratio:.2} ({})", plain_name(form));
        }
        text.push_str(".\n\n");
    }

    fn write_contact(&self, text: &mut String) {
        text.push_str(
            "## Update of a contact tangent\n\nThe annulus with n_r cells across, its whole outer circle in contact: the \
             matrix of the next Newton iterate, where only the contact integrals change.\n\n\
             | n_r | contact facets | unknowns | update (ms) | per facet (µs) | everything again (ms) |\n\
             |--:|--:|--:|--:|--:|--:|\n",
        );
        for row in &self.contact {
            let (update, all) = (median(&row.update), median(&row.reassembly));
            let _ = writeln!(
                text,
                "| {} | {} | {} | {:.3} | {:.3} | {:.2} |",
                row.across,
                row.facets,
                row.unknowns,
                1e3 * update,
                1e6 * update / row.facets as f64,
                1e3 * all
            );
        }
        text.push('\n');
    }

    fn chart_of_kernels(&self) -> Option<BarChart> {
        let mean = self.geometric_mean();
        let mut chart = BarChart::new("times as fast as FFCx's fastest variant")
            .title("Element kernels")
            .line(mean, &format!("mean {mean:.1}"));
        let mut any = false;
        for row in &self.kernels {
            if let Some(ratio) = row.ratio() {
                (chart, any) = (chart.bar(&plain_name(&row.form), ratio), true);
            }
        }
        any.then_some(chart)
    }

    fn chart_of_assembly(&self) -> Option<BarChart> {
        let mut chart =
            BarChart::new("times as fast, one thread, pattern known").title("Assembly of elasticity");
        let mut any = false;
        for row in &self.assembly {
            let Some((ours, peers)) = row.programs.split_first() else { continue };
            // Ours on more threads is in the table.
            for peer in peers.iter().filter(|peer| peer.threads.is_none()) {
                let ratio = median(&peer.reassembly) / median(&ours.reassembly);
                if ratio.is_finite() {
                    (chart, any) =
                        (chart.bar(&format!("{}, {}", row.case.name(), peer.program), ratio), true);
                }
            }
        }
        any.then_some(chart)
    }

    /// Writes everything to a directory, which is made if it does not exist.
    ///
    /// # Errors
    /// [`ComparisonError::File`], [`ComparisonError::Picture`].
    pub fn write(&self, directory: &Path) -> Result<(), ComparisonError> {
        let file = |path: &Path, result: std::io::Result<()>| {
            result.map_err(|source| ComparisonError::File { path: path.to_owned(), source })
        };
        file(directory, std::fs::create_dir_all(directory))?;
        let path = directory.join("comparison.md");
        file(&path, write_whole(&path, |file| file.write_all(self.markdown().as_bytes())))?;
        let path = directory.join("comparison.json");
        let numbers = serde_json::to_string_pretty(self).map_err(|error| ComparisonError::Output {
            program: "the report".to_owned(),
            reason: error.to_string(),
        })?;
        file(&path, write_whole(&path, |file| file.write_all(numbers.as_bytes())))?;
        if let Some(chart) = self.chart_of_kernels() {
            chart.write_png(directory.join("kernels.png"))?;
        }
        if let Some(chart) = self.chart_of_assembly() {
            chart.write_png(directory.join("assembly.png"))?;
        }
        Ok(())
    }
}

fn write_assembly(text: &mut String, row: &AssemblyRow) {
    let Some(ours) = row.programs.first() else { return };
    let _ = write!(
        text,
        "## Assembly: {}, {} cells, {} unknowns\n\nSeconds, medians. Programs without re-assembly into a known \
         pattern have the same number twice. Equal norms show that all programs computed the same matrix.\n\n\
         | program | re-assembly | ratio | with pattern and maps | ratio | norm of the matrix |\n\
         |---|--:|--:|--:|--:|--:|\n",
        row.case.name(),
        row.case.cells(row.divisions),
        ours.unknowns
    );
    for program in &row.programs {
        let Measured { program: name, version, reassembly, first, norm, .. } = program;
        let _ = writeln!(
            text,
            "| {name} {version} | {:.4} | {:.1} | {:.4} | {:.1} | {norm:.10} |",
            median(reassembly),
            median(reassembly) / median(&ours.reassembly),
            median(first),
            median(first) / median(&ours.first),
        );
    }
    let _ = writeln!(
        text,
        "\nOther operations here: residual {:.4} s, tangent times a vector without a matrix {:.4} s, matrix times a vector {:.4} s.",
        median(&ours.residual),
        median(&ours.action),
        median(&ours.product)
    );
    if let (Some(peak), Some(matrix)) = (ours.peak_bytes, ours.matrix_bytes) {
        let mega = |bytes: usize| bytes as f64 / 1e6;
        let _ = writeln!(
            text,
            "\nMemory: at most {:.0} MB in the process and {:.0} MB for the matrix, a ratio of {:.2}.",
            mega(peak),
            mega(matrix),
            mega(peak) / mega(matrix)
        );
    }
    text.push('\n');
}

fn figures(nanoseconds: f64) -> String {
    if nanoseconds < 100.0 { format!("{nanoseconds:.1}") } else { format!("{nanoseconds:.0}") }
}
