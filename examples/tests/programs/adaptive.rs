//! The program `adaptive` as a user runs it, with few unknowns; with FORMS_SWEEPS in the environment up to the numbers of
//! docs/adaptivity.md.

use std::process::Command;

/// The numbers of a row of one of the tables: unknowns, error, estimate / error.
type Row = [f64; 3];

/// The rows of a study on one kind of meshes, and the order in N below them.
fn rows(printed: &str, study: &str, meshes: &str) -> (Vec<Row>, f64) {
    let from = printed.split(&format!("\n{study}\n")).nth(1).unwrap_or_else(|| panic!("{study}: {printed}"));
    let table = from.trim_start().split("\n\n").next().expect("a table");
    let cells = table
        .lines()
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect::<Vec<_>>())
        .filter(|cells| cells[0] == meshes);
    let (mut rows, mut order) = (vec![], f64::NAN);
    for cells in cells {
        let number = |text: &str| text.parse::<f64>().unwrap_or_else(|error| panic!("{text}: {error}"));
        match cells[2].strip_prefix("N^") {
            Some(exponent) => order = number(exponent),
            None => rows.push([number(cells[1]), number(cells[2]), number(cells[3])]),
        }
    }
    (rows, order)
}

#[test]
fn adaptive_meshes_are_optimal_and_goals_known() {
    let sweeps = std::env::var_os("FORMS_SWEEPS").is_some();
    let (unknowns, least) = if sweeps { ("26000", 0.99) } else { ("3000", 0.98) };
    let directory = tempfile::tempdir().expect("a directory");
    let output = Command::new(env!("CARGO_BIN_EXE_adaptive"))
        .args(["--unknowns", unknowns])
        .current_dir(directory.path())
        .output()
        .expect("the program starts");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));

    for study in ["L-shape, goal", "u in H1", "p by (22) in H1"] {
        let (adaptive, order) = rows(&printed, study, "adaptive");
        assert!((-1.1..=-0.9).contains(&order), "{study}: {order}\n{printed}");
        assert!(adaptive.is_sorted_by(|a, b| a[0] < b[0] && a[1] > b[1]), "{study}: {printed}");
    }
    // (21) is not consistent for θ = −1, and errs along all of the zone of contact.
    let (_, order) = rows(&printed, "p by (21) in H1", "adaptive");
    assert!((-0.65..=-0.45).contains(&order), "p by (21): {order}\n{printed}");
    let (corner, _) = rows(&printed, "L-shape, goal", "adaptive");
    assert!((least..1.01).contains(&corner.last().expect("rows")[2]), "{printed}");
    // Uniform meshes: h^{3/2} and h^{1/2}.
    for (study, expected) in [("u in H1", -0.75), ("p by (22) in H1", -0.25)] {
        let (_, order) = rows(&printed, study, "uniform");
        assert!((order - expected).abs() < 0.06, "{study}: {order}");
    }
    // On adaptive meshes the error of this goal passes through zero, where a quotient says nothing: the last mesh of the page is far
    // from that.
    for theta in [-1, 0, 1] {
        let study = format!("contact, goal, theta = {theta}");
        let (uniform, _) = rows(&printed, &study, "uniform");
        let effectivity = uniform.last().expect("rows")[2];
        assert!((0.95..1.05).contains(&effectivity), "{study}: {effectivity}\n{printed}");
        if sweeps {
            let (adaptive, _) = rows(&printed, &study, "adaptive");
            let effectivity = adaptive.last().expect("rows")[2];
            assert!((0.98..1.02).contains(&effectivity), "{study}: {effectivity}\n{printed}");
        }
    }
    for picture in ["l_shape", "l_shape_mesh", "contact", "contact_mesh"] {
        let bytes = std::fs::read(directory.path().join(format!("out/adaptive/adaptive_{picture}.png")))
            .expect("the picture was written");
        assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 5000, "{picture}");
    }
}

/// Runs `adaptive_hertz`; the unknowns from which on a and p0 are within 0.5 % on uniform and on adaptive meshes, or none.
fn hertz(contact: &str, options: &[&str]) -> ([Option<f64>; 2], String) {
    let directory = tempfile::tempdir().expect("a directory");
    let output = Command::new(env!("CARGO_BIN_EXE_adaptive_hertz"))
        .arg(contact)
        .args(options)
        .current_dir(directory.path())
        .output()
        .expect("the program starts");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let unknowns = ["uniform", "adaptive"].map(|meshes| {
        let line = printed.lines().find(|line| line.starts_with(&format!("{meshes}: "))).expect("a line");
        let words: Vec<&str> = line.split(' ').collect();
        let place = words.iter().position(|word| *word == "from")?;
        Some(words[place + 1].parse().expect("a number"))
    });
    (unknowns, printed)
}

/// Fitted, and cut from a rectangle.
#[test]
fn hertz_with_a_tenth_of_the_unknowns() {
    for contact in ["cylinder", "cut-cylinder"] {
        // Half as fine, uniform meshes are not within 0.5 % yet.
        let ([uniform, adaptive], printed) = hertz(contact, &["--unknowns", "3000", "--uniform", "64"]);
        let uniform = uniform.unwrap_or(33_282.0);
        assert!(
            uniform >= 33_282.0 && 10.0 * adaptive.expect("adaptive meshes end within 0.5 %") <= uniform,
            "{printed}"
        );
    }
}

#[test]
fn hertz_in_space_with_a_tenth_of_the_unknowns() {
    let options = ["--near-axis", "--unknowns", "5000", "--uniform", "8", "--linear", "multigrid"];
    let ([uniform, adaptive], printed) = hertz("ball", &options);
    // The uniform mesh of 14,739 unknowns is not within 0.5 %; the next one has 107,811.
    assert_eq!(uniform, None, "{printed}");
    let adaptive = adaptive.expect("adaptive meshes end within 0.5 %");
    assert!(10.0 * adaptive <= 107_811.0, "{printed}");
    // A uniform mesh with cells as small as the smallest would have a hundred times as many.
    let last = printed.lines().rfind(|line| line.starts_with("| adaptive")).expect("rows");
    let evenly = last.trim_end_matches(" |").rsplit("| ").next().expect("a cell of the table");
    assert!(evenly.parse::<f64>().expect("a number") >= 100.0 * adaptive, "{printed}");
}

/// Runs `adaptive_cylinder`; η over the error of J on the last mesh of each θ, which the page has as well known.
#[test]
fn the_error_of_the_cylinders_criterion_is_known() {
    let unknowns = if std::env::var_os("FORMS_SWEEPS").is_some() { "12000" } else { "5000" };
    let directory = tempfile::tempdir().expect("a directory");
    let output = Command::new(env!("CARGO_BIN_EXE_adaptive_cylinder"))
        .args(["--unknowns", unknowns, "--reference", unknowns, "--tolerance", "1e-5"])
        .current_dir(directory.path())
        .output()
        .expect("the program starts");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for theta in ["-1", "0", "1"] {
        let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
        let mut rows = printed.lines().map(cells).filter(|cells| cells.len() > 4 && cells[1] == theta);
        let last = rows.by_ref().take_while(|cells| !cells[3].starts_with("J =")).last().expect("rows");
        let quotient: f64 = last[4].parse().expect("a number");
        assert!((0.98..1.02).contains(&quotient), "θ = {theta}: {quotient}\n{printed}");
    }
}
