//! Lines on a body: edges of cells, outlines, arrows.

use std::collections::BTreeMap;

use super::Colour;
use super::body::{Body, field_values, joined};
use super::drawing::{Drawing, Stroke, polyline};
use super::path::{Point, Rectangle, Segment};
use crate::field::Field;

/// The line of an arrow.
pub(super) fn arrow_stroke() -> Stroke {
    Stroke::solid(Colour::grey(20), 0.8)
}

/// A window with a margin about two corners, as a part of the larger side.
pub(super) fn with_margin([low, high]: [[f64; 2]; 2], part: f64) -> [[f64; 2]; 2] {
    let margin = part * (high[0] - low[0]).max(high[1] - low[1]);
    [low.map(|x| x - margin), high.map(|x| x + margin)]
}

/// Draws the edges of all cells, thinner and fainter the smaller the cells are.
pub(super) fn draw_mesh_lines(
    drawing: &mut Drawing,
    body: &Body<'_>,
    place: impl Fn([f64; 2]) -> Point,
    clip: Option<Rectangle>,
) {
    let points: Vec<Point> = body.edges().into_iter().map(place).collect();
    let edges = points.chunks_exact(body.points_of_edge());
    let length = |edge: &[Point]| {
        edge.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum::<f64>()
    };
    let mut lengths: Vec<f64> = edges.clone().map(length).collect();
    lengths.sort_by(f64::total_cmp);
    let short = lengths.get(lengths.len() / 4).copied().unwrap_or(0.0);
    let colour = Colour::BLACK.with_opacity((0.12 * short).clamp(0.2, 0.6) as f32);
    let stroke = Stroke::solid(colour, (0.08 * short).clamp(0.12, 0.4));
    let mut segments = Vec::with_capacity(points.len());
    edges.for_each(|edge| segments.extend(polyline(edge)));
    drawing.clipped_path(segments, None, Some(stroke), clip);
}

/// Draws polylines that follow each other as one line where their ends meet.
pub(super) fn draw_polylines(
    drawing: &mut Drawing,
    polylines: &[Vec<[f64; 2]>],
    place: impl Fn([f64; 2]) -> Point,
    stroke: Stroke,
    clip: Option<Rectangle>,
) {
    let segments: Vec<Segment> = joined(polylines)
        .iter()
        .flat_map(|line| polyline(&line.iter().map(|&x| place(x)).collect::<Vec<Point>>()))
        .collect();
    drawing.clipped_path(segments, None, Some(stroke), clip);
}

/// Positions and values of a vector field at the centres of the cells.
pub(super) fn arrow_samples(body: &Body<'_>, field: &Field<2>) -> Vec<([f64; 2], [f64; 2])> {
    let mut samples = Vec::with_capacity(body.mesh.cell_count());
    for block in body.mesh.body_blocks() {
        let centre = [block.shape.centre::<2>()];
        let basis = field.space().element_of(block.shape).tabulate::<2>(&centre).value;
        let positions = body.positions(block.shape, &centre, block.cells.clone());
        let value = |cell| {
            let u = field_values(field, cell, &basis);
            [u[0], u[1]]
        };
        samples.extend(positions.into_iter().zip(block.cells.clone().map(value)));
    }
    samples
}

/// Draws at most one arrow in each square of a grid on the page: that of the sample next to its centre,
/// and none too close to another one.
pub(super) fn draw_arrows(
    drawing: &mut Drawing,
    arrows: &[([f64; 2], [f64; 2])],
    longest: f64,
    place: impl Fn([f64; 2]) -> Point,
    area: Rectangle,
) {
    const SPACING: f64 = 18.0;
    let middle = [area.left + area.width / 2.0, area.top + area.height / 2.0];
    let mut nearest: BTreeMap<[i64; 2], (f64, Point, [f64; 2])> = BTreeMap::new();
    for (position, u) in arrows {
        let at = place(*position);
        let square = [0, 1].map(|k| ((at[k] - middle[k]) / SPACING).round());
        let [dx, dy] = [0, 1].map(|k| at[k] - middle[k] - square[k] * SPACING);
        let candidate = (dx.hypot(dy), at, *u);
        let chosen = nearest.entry(square.map(|x| x as i64)).or_insert(candidate);
        if candidate.0 < chosen.0 {
            *chosen = candidate;
        }
    }
    // A square at the rim may have no sample near its centre: it gives way to its neighbours.
    let mut candidates: Vec<_> = nearest.into_values().collect();
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut drawn: Vec<Point> = Vec::new();
    for (_, at, u) in candidates {
        let length = SPACING * 1.1 * u[0].hypot(u[1]) / longest;
        let too_close = |other: &Point| (other[0] - at[0]).hypot(other[1] - at[1]) < 0.75 * SPACING;
        if !area.contains(at) || length.is_nan() || length < 1.0 || drawn.iter().any(too_close) {
            continue;
        }
        drawn.push(at);
        let size = u[0].hypot(u[1]);
        let direction = [u[0] / size, -u[1] / size];
        let along = |t: f64, side: f64| {
            [at[0] + t * direction[0] - side * direction[1], at[1] + t * direction[1] + side * direction[0]]
        };
        let (start, end) = (-length / 2.0, length / 2.0);
        let head = (0.35 * length).min(4.0);
        drawing.polyline(&[along(start, 0.0), along(end - head / 2.0, 0.0)], arrow_stroke(), Some(area));
        let mut segments =
            polyline(&[along(end, 0.0), along(end - head, head * 0.4), along(end - head, -head * 0.4)]);
        segments.push(Segment::Close);
        drawing.clipped_path(segments, Some(arrow_stroke().colour), None, Some(area));
    }
}
