//! Our element matrices against FFCx's on the harness's random cells (`data/ffcx_matrices.json`, written by
//! `peers/write_reference.py`), through the symbols that the harness calls.

#![allow(unsafe_code)]

use std::collections::BTreeMap;

use forms_bench::basket::BASKET;
use forms_bench::element_batch::Output;
use forms_bench::random_cells::{BATCH, RandomCells};
use serde::Deserialize;

const TOLERANCE: f64 = 1e-12;

#[derive(Deserialize)]
struct Written {
    forms: BTreeMap<String, Reference>,
}

#[derive(Deserialize)]
struct Reference {
    /// Largest entry by absolute value.
    largest: f64,
    /// One row per cell; the whole vector of a residual.
    rows: Vec<Vec<f64>>,
}

#[test]
fn every_form_agrees_with_ffcx() {
    let text = include_str!("../data/ffcx_matrices.json");
    let written: Written = serde_json::from_str(text).expect("the reference is JSON");
    for entry in BASKET {
        let Some(reference) = written.forms.get(entry.name) else {
            panic!("{} has no reference: run peers/write_reference.py", entry.name);
        };
        let setting = &entry.setting;
        let columns = reference.rows[0].len();
        let rows = if setting.output == Output::Tangent { columns } else { 1 };
        let lengths = (entry.lengths)();
        assert_eq!(lengths.size, rows * columns, "{}", entry.name);
        let width = lengths.width;
        let cells = RandomCells::new(setting, width);
        let stride = lengths.coordinates;
        let mut matrices = vec![f64::NAN; BATCH * rows * columns];
        for (facet, expected) in reference.rows.chunks(BATCH).enumerate() {
            let first = facet * BATCH;
            let entity = facet as i32;
            // SAFETY: the arrays are as long as the plugin interface has them for this form.
            unsafe {
                (entry.batch)(
                    BATCH as i32,
                    matrices.as_mut_ptr(),
                    cells.coefficients[first * width..].as_ptr(),
                    cells.constants.as_ptr(),
                    cells.coordinates[first * stride..].as_ptr(),
                    &entity,
                );
            }
            for (cell, expected) in expected.iter().enumerate() {
                let row = (7 * (first + cell) + 3) % rows;
                let ours = &matrices[(cell * rows + row) * columns..][..columns];
                for (column, (ours, theirs)) in ours.iter().zip(expected).enumerate() {
                    let difference = (ours - theirs).abs() / reference.largest;
                    assert!(
                        difference < TOLERANCE,
                        "{}, facet {facet}, cell {cell}, row {row}, column {column}: {ours} is not {theirs}",
                        entry.name
                    );
                }
            }
        }
    }
}
