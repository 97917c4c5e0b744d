//! Parsing of the harness's output.

use forms_bench::comparison::{ComparisonError, read_timings};

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
