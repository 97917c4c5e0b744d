//! The table of results that the program prints.

use std::fmt::Write;

use forms_fem::prelude::*;

use crate::measurements::Measurements;

/// Width of the column of names.
const NAMES: usize = 46;

/// The whole table.
pub fn of(measured: &Measurements) -> String {
    let mut table = Table::default();
    let settings = &measured.settings;
    table.heading("Hollow cylinder (lengths in cm, stresses in MPa, forces in MPa·cm)");
    table.row("cells", &format!("{} x {}, {} in all", settings.radial, settings.around, measured.cells));
    let prescribed = measured.prescribed_unknowns;
    table.row("unknowns", &format!("{}, {prescribed} of them prescribed", measured.unknowns));
    table.row("theta", &settings.theta.to_string());
    table.row("gamma0", &format!("{} E = {} MPa", settings.gamma0_over_young, settings.gamma0));
    let required = match measured.required_gamma0 {
        0.0 => "none at theta = -1".to_owned(),
        required => format!("{:.4} E", required / settings.young),
    };
    table.row("gamma0 required", &required);
    table.row("Young's modulus, Poisson's ratio", &format!("{} MPa, {}", settings.young, settings.poisson));
    table.row("quadrature degree", &settings.degree.to_string());
    table.row("C of (41)", &settings.xi.to_string());
    if let Some(bound) = settings.tresca {
        table.row("Tresca's bound", &format!("{bound} MPa"));
    }
    if let Some(coefficient) = settings.coulomb {
        table.row("Coulomb's coefficient", &coefficient.to_string());
    }
    table.row("threads", &settings.threads.to_string());
    table.heading("Newton's method");
    table.text.push_str(&newton_history(&measured.newton_history));
    if let Some(path) = &measured.solver.path {
        let condensed = measured.solver.condensed_unknowns;
        let unknowns = condensed.map_or(String::new(), |count| format!(": {count} of {}", measured.unknowns));
        table.row("linear systems", &format!("{path}{unknowns}"));
    }
    table.heading("Results");
    table.number("J", measured.criterion);
    table.norms("u of (14)", measured.u_l2, measured.u_h1);
    table.norms("p of (21), discrete", measured.p_discrete_l2, measured.p_discrete_h1);
    table.norms("p of (22), consistent", measured.p_consistent_l2, measured.p_consistent_h1);
    table.norms("p of (41), extended Neumann", measured.p_extended_l2, measured.p_extended_h1);
    table.number("contact force [MPa cm]", measured.contact_force);
    table.number("contact length [cm]", measured.contact_length);
    if let Some(force) = measured.tangential_force {
        table.number("tangential force on the body [MPa cm]", force);
    }
    if let (Some(stick), Some(slip)) = (measured.stick_length, measured.slip_length) {
        table.row("length that sticks, that slips [cm]", &format!("{stick:.12e}, {slip:.12e}"));
    }
    table.number("largest penetration [cm]", measured.max_penetration);
    for point in &measured.points {
        let [x, y] = point.x;
        table.row(&format!("u at ({x}, {y})"), &vector(&point.u));
        table.row(&format!("p of (22) at ({x}, {y})"), &vector(&point.p));
    }
    if measured.load_steps.len() > 1 {
        table.heading("Load steps");
        for (number, step) in measured.load_steps.iter().enumerate() {
            let tangential =
                step.tangential_force.map_or(String::new(), |force| format!(", tangential {force:+.9e}"));
            let [x, y] = step.push;
            table.row(
                &format!("{}: inner circle moved by ({x}, {y})", number + 1),
                &format!("contact force {:.9e}{tangential}", step.contact_force),
            );
        }
    }
    table.heading("Seconds");
    let seconds = &measured.seconds;
    table.seconds("mesh, space, matrix pattern", seconds.setup);
    table.seconds("direct problem", seconds.newton_total);
    table.seconds("  assembly", seconds.assembly);
    table.seconds("  analysis and factorisation", seconds.factorisation);
    table.seconds("three adjoint states", seconds.adjoint);
    table.seconds("norms", seconds.norms);
    table.seconds("stresses and other derived fields", seconds.derived_fields);
    table.seconds(".vtu file", seconds.vtu);
    table.seconds("pictures", seconds.pictures);
    table.seconds("total", seconds.total);
    let speed_ups = &measured.speed_ups;
    table.heading("Largest speed-up by 2, 4, 8, 16, 64 threads, from counted work");
    for (name, found) in [
        ("factorisation", speed_ups.factorisation),
        ("triangular solve", speed_ups.triangular_solve),
        ("assembly", Some(speed_ups.assembly)),
        ("norms, derived fields at points", Some(speed_ups.evaluation)),
        ("projections", Some(speed_ups.projection)),
    ] {
        let found = found.map(|found| found.map(|ratio| format!("{ratio:.1}")).join(", "));
        table.row(name, found.as_deref().unwrap_or("not counted"));
    }
    table.heading("Memory");
    let memory = measured.peak_rss_mb.map_or("unknown".into(), |megabytes| format!("{megabytes:.0} MB"));
    table.row("peak memory", &memory);
    table.text.push('\n');
    table.text
}

/// The history of Newton's method.
pub fn newton_history(history: &[NewtonStep]) -> String {
    let mut text = String::new();
    let mut line = |cells: [&str; 6]| {
        let [iteration, residual, relative, active, step, linear] = cells;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {iteration:>9}  {residual:>10}  {relative:>10}  {active:>8}  {step:>10}  {linear:>8}"
        );
    };
    line(["iteration", "residual", "relative", "active", "step", "linear"]);
    for iterate in history {
        let optional = |value: Option<usize>| value.map_or("-".into(), |value| value.to_string());
        line([
            &iterate.iteration.to_string(),
            &format!("{:.3e}", iterate.residual),
            &format!("{:.3e}", iterate.relative_residual),
            &optional(iterate.active_points),
            &iterate.step.map_or("-".into(), |step| format!("{step:.3e}")),
            &optional(iterate.linear_iterations),
        ]);
    }
    text
}

fn vector(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|value| format!("{value:+.9e}")).collect();
    format!("({})", values.join(", "))
}

#[derive(Default)]
struct Table {
    text: String,
}

impl Table {
    fn heading(&mut self, name: &str) {
        let gap = if self.text.is_empty() { "" } else { "\n" };
        let _ = writeln!(self.text, "{gap}{name}");
    }

    fn row(&mut self, name: &str, value: &str) {
        let _ = writeln!(self.text, "  {name:<NAMES$}{value}");
    }

    fn number(&mut self, name: &str, value: f64) {
        self.row(name, &format!("{value:.12e}"));
    }

    fn norms(&mut self, name: &str, l2: f64, h1: f64) {
        self.row(&format!("{name}: L2, H1 norm"), &format!("{l2:.12e}, {h1:.12e}"));
    }

    fn seconds(&mut self, name: &str, seconds: f64) {
        self.row(name, &format!("{seconds:.3}"));
    }
}
