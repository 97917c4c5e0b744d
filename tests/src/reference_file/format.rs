//! The format of a reference file.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;
use serde_json::Value;

/// A file as it is.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceFile {
    #[serde(skip)]
    pub(super) name: String,
    #[serde(rename = "made_by")]
    _made_by: String,
    pub(super) dimension: usize,
    pub(super) shape: String,
    pub(super) geometry_degree: usize,
    pub(super) nodes: Vec<Vec<f64>>,
    pub(super) cells: Vec<Vec<u32>>,
    pub(super) space_degree: usize,
    pub(super) components: usize,
    pub(super) space_nodes: Vec<Vec<f64>>,
    pub(super) space_cells: Option<Vec<usize>>,
    pub(super) second_space: Option<SecondSpace>,
    pub(super) cell_quadrature: CellRule,
    pub(super) facet_quadrature: Option<FacetRule>,
    #[serde(default)]
    pub(super) contact_facets: Vec<(u32, u8)>,
    #[serde(default)]
    pub(super) contact_diameters: Vec<f64>,
    #[serde(default)]
    pub(super) criterion_facets: Vec<(u32, u8)>,
    pub(super) data: BTreeMap<String, Value>,
    pub(super) u: Option<Vec<f64>>,
    pub(super) matrices: BTreeMap<String, Triplets>,
    #[serde(default)]
    pub(super) vectors: BTreeMap<String, Vec<f64>>,
    #[serde(default)]
    pub(super) numbers: BTreeMap<String, f64>,
}

/// The space of a second unknown, whose numbers follow those of the first, and its state.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SecondSpace {
    pub(super) space_degree: usize,
    pub(super) components: usize,
    pub(super) space_nodes: Vec<Vec<f64>>,
    pub(super) u: Vec<f64>,
}

#[derive(Debug, Deserialize)]
pub(super) struct CellRule {
    pub(super) points: Vec<Vec<f64>>,
    pub(super) weights: Vec<f64>,
}

#[derive(Debug, Deserialize)]
pub(super) struct FacetRule {
    pub(super) points: FacetPoints,
    pub(super) weights: Vec<f64>,
}

/// On a segment, or on a triangle.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum FacetPoints {
    Segment(Vec<f64>),
    Triangle(Vec<[f64; 2]>),
}

#[derive(Debug, Deserialize)]
pub(super) struct Triplets {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) row: Vec<usize>,
    pub(super) column: Vec<usize>,
    pub(super) value: Vec<f64>,
}

impl ReferenceFile {
    pub(super) fn read(name: &str) -> Self {
        let text = std::fs::read_to_string(folder().join(name).with_extension("json"));
        let text = text.unwrap_or_else(|error| panic!("{name}: {error}"));
        let file = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
        ReferenceFile { name: name.to_owned(), ..file }
    }

    /// 2 or 3.
    pub fn dimension(&self) -> usize {
        self.dimension
    }
}

pub(super) fn folder() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "scikit_fem"].iter().collect()
}
