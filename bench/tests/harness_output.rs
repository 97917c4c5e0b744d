//! Parsing of the harness's output.

use forms_bench::comparison::{ComparisonError, plain_name, read_timings};

#[test]
fn the_fastest_variant_is_the_opponent() -> Result<(), ComparisonError> {
    let timing = |ns: f64| format!("{{\"ns\": {ns}, \"ns_med\": {ns}, \"gflops\": 1.0, \"relerr\": 0.0}}");
    let text = format!(
        "{{\"mass\": {{\"flops\": 10, \"a\": {}, \"b\": {}, \"ours\": {}}}, \"new\": {{\"flops\": 1, \"a\": {}}}}}",
        timing(8.0),
        timing(6.0),
        timing(1.5),
        timing(1.0)
    );
    let rows = read_timings(&text)?;
    assert_eq!((rows[0].best.0.as_str(), rows[0].ratio()), ("b", Some(4.0)));
    assert_eq!(rows[1].ratio(), None);
    assert!(read_timings("{\"mass\": {\"flops\": 10}}").is_err());
    Ok(())
}

#[test]
fn a_form_with_sum_factorisation_counts_once() -> Result<(), ComparisonError> {
    let timing = |ns: f64| format!("{{\"ns\": {ns}, \"ns_med\": {ns}, \"gflops\": 1.0, \"relerr\": 0.0}}");
    let form = |name: &str, peer: f64, ours: f64| {
        format!("\"{name}\": {{\"flops\": 10, \"a\": {}, \"ours\": {}}}", timing(peer), timing(ours))
    };
    let text = format!(
        "{{{}, {}, {}}}",
        form("slower", 8.0, 2.0),
        form("slower_sumfact", 9.0, 1.0),
        form("alone_sumfact", 3.0, 1.0)
    );
    let rows = read_timings(&text)?;
    assert_eq!(rows.iter().map(|row| row.form.as_str()).collect::<Vec<_>>(), ["alone_sumfact", "slower"]);
    assert_eq!((rows[1].best.0.as_str(), rows[1].ratio()), ("a", Some(4.0)));
    assert!(rows[1].variants.contains_key("sumfact_a"));
    let text = format!("{{{}, {}}}", form("faster", 8.0, 2.0), form("faster_sumfact", 6.0, 2.0));
    assert_eq!(read_timings(&text)?[0].ratio(), Some(3.0));
    Ok(())
}

/// The table and the chart have words, a different name for each form; docs/speed_kernels.csv has these names.
#[test]
fn each_kernel_has_a_plain_name() {
    // The source in place of the list, which would compile the kernels.
    let kernels = include_str!("../src/basket.rs").lines().filter_map(|line| line.trim().split_once(": "));
    let forms = kernels.filter(|(_, rest)| rest.starts_with("Tangent of") || rest.starts_with("Residual of"));
    let names: Vec<String> =
        forms.map(|(form, _)| form).filter(|form| !form.ends_with("_sumfact")).map(plain_name).collect();
    let recorded: Vec<&str> = include_str!("../../docs/speed_kernels.csv")
        .lines()
        .filter_map(|line| line.strip_prefix('"').and_then(|rest| Some(rest.split_once('"')?.0)))
        .collect();
    assert_eq!(names, recorded);
    assert_eq!(plain_name("elasticity_hex_Q2_g2"), "elasticity, hexahedra of degree 2, curved");
}
