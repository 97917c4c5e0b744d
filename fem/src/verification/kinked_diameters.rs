//! Cells whose diameter h has a kink along a movement: two distances between vertices are equally long and grow at different
//! rates, as the diagonals of a rectangle do. h is the larger one, and has a derivative on each side only.

use std::fmt;

use crate::field::Field;

/// Cells whose diameter has a kink along a movement.
#[derive(Clone, Debug, PartialEq)]
pub struct KinkedDiameters {
    /// Their number.
    pub count: usize,
    /// The first of them.
    pub cell: usize,
    /// Its centre \[length\].
    pub centre: Vec<f64>,
    /// The lowest and the highest rate at which its longest distances between vertices grow \[length\].
    pub rates: [f64; 2],
}

/// Distances that differ by less than this part are equal, as for [`Field::rate_of_diameter`].
const EQUALLY_LONG: f64 = 1e-12;
/// A difference of rates below this part of the largest rate is rounding.
const ROUNDING: f64 = 1e-9;

impl KinkedDiameters {
    /// The cells with a kink at the start of a movement, or before it has gone so far. None where the movement's field is on
    /// another space than that of the geometry, which [`Field::move_mesh`] reports.
    pub(super) fn along<const D: usize>(movement: &Field<D>, step: f64) -> Option<Self> {
        let mesh = movement.space().mesh();
        let mut found: Option<KinkedDiameters> = None;
        for cell in 0..mesh.cell_count() {
            let (vertices, nodes) = (mesh.cell_vertices(cell), movement.space().cell_nodes(cell));
            if nodes.len() < vertices.len() || movement.space().components() != D {
                return None;
            }
            // Length and rate of each pair of vertices, which come first among a cell's nodes.
            let pairs = (0..vertices.len()).flat_map(|a| (0..a).map(move |b| (a, b))).map(|(a, b)| {
                let place = |vertex: usize| &mesh.nodes()[vertices[vertex] as usize];
                let by = |vertex: usize| movement.at_node(nodes[vertex] as usize);
                let apart: [f64; D] = std::array::from_fn(|k| place(a)[k] - place(b)[k]);
                let length = apart.iter().map(|x| x * x).sum::<f64>().sqrt();
                let rate = (0..D).map(|k| apart[k] * (by(a)[k] - by(b)[k])).sum::<f64>() / length;
                (length, rate)
            });
            let pairs: Vec<(f64, f64)> = pairs.collect();
            let largest = pairs.iter().fold(0.0_f64, |largest, (_, rate)| largest.max(rate.abs()));
            let longest = pairs.iter().copied().max_by(|a, b| a.0.total_cmp(&b.0))?;
            // Those that are as long, or overtake within the step.
            let reaches = |(length, rate): &&(f64, f64)| {
                let behind = longest.0 - length;
                behind <= EQUALLY_LONG * longest.0 || behind < step * (rate - longest.1)
            };
            let rates = pairs.iter().filter(reaches).map(|(_, rate)| *rate);
            let (low, high) =
                rates.fold((longest.1, longest.1), |(low, high), rate| (low.min(rate), high.max(rate)));
            if high - low <= ROUNDING * largest {
                continue;
            }
            match &mut found {
                Some(found) => found.count += 1,
                None => {
                    let (centre, rates) = (mesh.cell_centre(cell).to_vec(), [low, high]);
                    found = Some(KinkedDiameters { count: 1, cell, centre, rates });
                }
            }
        }
        found
    }
}

impl fmt::Display for KinkedDiameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let KinkedDiameters { count, cell, centre, rates: [low, high] } = self;
        let cells = if *count == 1 { "1 cell".into() } else { format!("{count} cells") };
        write!(
            f,
            "the diameter h of {cells} has a kink along this movement (cell {cell} around {centre:?}: distances between \
             vertices that are equally long grow at the rates {low:.3e} and {high:.3e})"
        )
    }
}
