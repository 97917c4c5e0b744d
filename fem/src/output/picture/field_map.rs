//! Fields as colours on a plane body, deformed or not.

use super::axes::number;
use super::body::{Body, Lattice, bounds, field_values};
use super::colour_map::{Colour, ColourMap};
use super::drawing::{Drawing, Point, Rectangle, Segment, Stroke, polyline};
use super::layout::Layout;
use super::legend::{Key, Legend};
use super::shading::Shading;
use super::{Picture, PictureError};
use crate::field::Field;
use crate::mesh::Mesh;

/// Which scalar of a field is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// A component by its number; tensors are numbered row by row.
    Component(usize),
    /// The square root of the sum of the squares of all components.
    Magnitude,
}

/// A value of a cell at a reference point.
type CellFunction<'a> = Box<dyn Fn(usize, &[f64; 2]) -> f64 + 'a>;

enum Values<'a> {
    Field(&'a Field<2>, Shown),
    Function(CellFunction<'a>),
}

/// A picture of a field on a body.
pub struct FieldMap<'a> {
    mesh: &'a Mesh<2>,
    values: Values<'a>,
    label: String,
    displacement: Option<(&'a Field<2>, f64)>,
    title: String,
    unit: Option<String>,
    colours: ColourMap,
    levels: Option<usize>,
    range: Option<[f64; 2]>,
    window: Option<[[f64; 2]; 2]>,
    largest: [f64; 2],
    mesh_lines: bool,
    undeformed: Option<String>,
    lines: Vec<(Vec<[f64; 2]>, String, Stroke)>,
    arrows: Option<(&'a Field<2>, String)>,
}

impl<'a> FieldMap<'a> {
    /// A picture of a field; the label, with the unit, stands at the colour bar.
    pub fn of(field: &'a Field<2>, shown: Shown, label: &str) -> FieldMap<'a> {
        FieldMap::new(&field.space.mesh, Values::Field(field, shown), label)
    }

    /// A picture of a function of the cell's number and the point in its reference cell; it may jump
    /// between cells, as stresses do.
    pub fn cell_by_cell(
        mesh: &'a Mesh<2>,
        value: impl Fn(usize, &[f64; 2]) -> f64 + 'a,
        label: &str,
    ) -> FieldMap<'a> {
        FieldMap::new(mesh, Values::Function(Box::new(value)), label)
    }

    fn new(mesh: &'a Mesh<2>, values: Values<'a>, label: &str) -> FieldMap<'a> {
        FieldMap {
            mesh,
            values,
            label: label.into(),
            displacement: None,
            title: String::new(),
            unit: Some("mm".into()),
            colours: ColourMap::default(),
            levels: None,
            range: None,
            window: None,
            largest: [300.0, 300.0],
            mesh_lines: true,
            undeformed: None,
            lines: Vec::new(),
            arrows: None,
        }
    }

    /// Draws the body displaced by `factor` times a vector field.
    pub fn deformed(mut self, displacement: &'a Field<2>, factor: f64) -> Self {
        self.displacement = Some((displacement, factor));
        self
    }

    /// Writes a title above the picture.
    pub fn title(mut self, title: &str) -> Self {
        self.title = title.into();
        self
    }

    /// The unit of length at the axes; millimetres unless another one is given.
    pub fn length_unit(mut self, unit: &str) -> Self {
        self.unit = Some(unit.into());
        self
    }

    /// Draws no axes.
    pub fn without_axes(mut self) -> Self {
        self.unit = None;
        self
    }

    /// The colour map. With [`ColourMap::Vik`] the range is symmetric about zero unless it is given.
    pub fn colour_map(mut self, map: ColourMap) -> Self {
        self.colours = map;
        self
    }

    /// Draws bands of equal colour instead of a continuous map.
    pub fn levels(mut self, count: usize) -> Self {
        self.levels = Some(count);
        self
    }

    /// The values at the ends of the colour map; otherwise they follow the field.
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some([low, high]);
        self
    }

    /// Shows only a part of the plane.
    pub fn window(mut self, x: [f64; 2], y: [f64; 2]) -> Self {
        self.window = Some([[x[0], y[0]], [x[1], y[1]]]);
        self
    }

    /// Largest width and height of the body on the page \[pt\]; 300 × 300 unless given.
    pub fn size(mut self, width: f64, height: f64) -> Self {
        self.largest = [width, height];
        self
    }

    /// Draws no edges of cells.
    pub fn without_mesh_lines(mut self) -> Self {
        self.mesh_lines = false;
        self
    }

    /// Draws the outline of the body before its deformation, with a name for the legend.
    pub fn undeformed_outline(mut self, name: &str) -> Self {
        self.undeformed = Some(name.into());
        self
    }

    /// Draws a line, as of an obstacle, with a name for the legend.
    pub fn line(mut self, points: &[[f64; 2]], name: &str, colour: Colour) -> Self {
        self.lines.push((points.to_vec(), name.into(), Stroke::solid(colour, 1.4)));
        self
    }

    /// Draws arrows of a vector field; the legend says how long the longest one is. The label has two
    /// parts, the name and the unit.
    pub fn arrows(mut self, field: &'a Field<2>, name: &str, unit: &str) -> Self {
        self.arrows = Some((field, format!("{name}\n{unit}")));
        self
    }

    /// The values at the lattice points of all cells.
    fn sample(&self, lattice: &Lattice) -> Result<Vec<f64>, PictureError> {
        let cells = 0..self.mesh.cell_count();
        let mut samples = Vec::with_capacity(cells.len() * lattice.points.len());
        match &self.values {
            Values::Function(value) => {
                for cell in cells {
                    samples.extend(lattice.points.iter().map(|point| value(cell, point)));
                }
            }
            Values::Field(field, shown) => {
                let components: usize = field.space.shape.iter().product();
                if let Shown::Component(k) = *shown
                    && k >= components
                {
                    return Err(PictureError::Length {
                        name: self.label.clone(),
                        expected: k + 1,
                        found: components,
                    });
                }
                let basis = field.space.element.tabulate::<2>(&lattice.points).value;
                for cell in cells {
                    let values = field_values(field, cell, &basis);
                    samples.extend(values.chunks(components).map(|value| match *shown {
                        Shown::Component(k) => value[k],
                        Shown::Magnitude => value.iter().map(|v| v * v).sum::<f64>().sqrt(),
                    }));
                }
            }
        }
        match samples.iter().position(|value| !value.is_finite()) {
            Some(place) => {
                let index = place / lattice.points.len();
                Err(PictureError::CellNotFinite {
                    name: self.label.clone(),
                    cell: index,
                    value: samples[place],
                })
            }
            None => Ok(samples),
        }
    }

    fn shading(&self, samples: &[f64]) -> Result<Shading, PictureError> {
        let [mut low, mut high] = samples
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &v| [low.min(v), high.max(v)]);
        if self.colours == ColourMap::Vik {
            let largest = low.abs().max(high.abs());
            (low, high) = (-largest, largest);
        }
        // A constant field gets a range about its value.
        let middle = (low + high) / 2.0;
        if high - low <= 1e-9 * middle.abs() || high <= low {
            let half = if middle == 0.0 { 1.0 } else { 0.1 * middle.abs() };
            (low, high) = (middle - half, middle + half);
        }
        let range = self.range.unwrap_or([low, high]);
        if !(range[0].is_finite() && range[1].is_finite() && range[0] < range[1]) {
            return Err(PictureError::Range { name: self.label.clone(), low: range[0], high: range[1] });
        }
        Ok(Shading { map: self.colours, range, levels: self.levels, flat: None })
    }

    /// Fields that move or decorate the body must be vector fields on its mesh with finite values.
    fn check_vector(&self, field: &Field<2>, name: &str) -> Result<(), PictureError> {
        if !super::super::lives_on(field, self.mesh) {
            return Err(PictureError::OtherMesh { name: name.into() });
        }
        let components: usize = field.space.shape.iter().product();
        if components != 2 {
            return Err(PictureError::Length { name: name.into(), expected: 2, found: components });
        }
        match field.values.iter().position(|value| !value.is_finite()) {
            Some(index) => {
                Err(PictureError::NotFinite { name: name.into(), index, value: field.values[index] })
            }
            None => Ok(()),
        }
    }

    fn keys(&self, longest: Option<f64>) -> Vec<Key> {
        let key =
            |text: &str, stroke: &Stroke| Key { text: text.into(), stroke: stroke.clone(), marker: None };
        let mut keys: Vec<Key> = self.lines.iter().map(|(_, name, stroke)| key(name, stroke)).collect();
        if let Some(name) = &self.undeformed {
            keys.push(key(name, &undeformed_stroke()));
        }
        if let (Some((_, label)), Some(longest)) = (&self.arrows, longest) {
            let (name, unit) = label.split_once('\n').unwrap_or((label, ""));
            let decimals = (2.0 - longest.log10().floor()).clamp(0.0, 9.0) as usize;
            let text = format!("{name}, up to {} {unit}", number(longest, decimals));
            keys.push(key(&text, &arrow_stroke()));
        }
        keys.retain(|key| !key.text.is_empty());
        keys
    }
}

fn undeformed_stroke() -> Stroke {
    Stroke::dashed(Colour::grey(90), 0.8, &[3.0, 2.0])
}

fn arrow_stroke() -> Stroke {
    Stroke::solid(Colour::grey(20), 0.8)
}

impl Picture for FieldMap<'_> {
    fn draw(&self) -> Result<Drawing, PictureError> {
        if self.mesh.cell_count() == 0 {
            return Err(PictureError::Empty { picture: format!("the map of \"{}\"", self.label) });
        }
        if let Some((field, factor)) = self.displacement {
            self.check_vector(field, "displacement")?;
            if !factor.is_finite() {
                let name = "factor of the displacement".into();
                return Err(PictureError::NotFinite { name, index: 0, value: factor });
            }
        }
        for (points, name, _) in &self.lines {
            if let Some(index) = points.iter().position(|point| !point.iter().all(|x| x.is_finite())) {
                let value = points[index].iter().copied().find(|x| !x.is_finite()).unwrap_or(f64::NAN);
                return Err(PictureError::NotFinite { name: name.clone(), index, value });
            }
        }
        let body = Body { mesh: self.mesh, displacement: self.displacement };
        let still = Body { mesh: self.mesh, displacement: None };
        let lattice = Lattice::of(self.mesh);
        let samples = self.sample(&lattice)?;
        let shading = self.shading(&samples)?;
        let outline = body.facets(self.mesh.boundary_facets());
        let before = self.undeformed.as_ref().map(|_| still.facets(self.mesh.boundary_facets()));
        let lines = self.lines.iter().map(|(points, ..)| points);
        let shown = bounds(outline.iter().chain(before.iter().flatten()).chain(lines));
        let window = self.window.unwrap_or_else(|| with_margin(shown, 0.04));
        let arrows = match &self.arrows {
            Some((field, label)) => {
                self.check_vector(field, label.split('\n').next().unwrap_or_default())?;
                Some(arrow_samples(&body, field))
            }
            None => None,
        };
        let longest =
            arrows.as_ref().map(|arrows| arrows.iter().map(|(_, u)| u[0].hypot(u[1])).fold(0.0, f64::max));
        let layout = Layout {
            title: &self.title,
            unit: self.unit.as_deref(),
            largest: self.largest,
            window,
            bar: Some((shading, self.label.clone())),
            legend: Legend::new(self.keys(longest)),
        };
        let (mut drawing, frame) = layout.begin()?;
        let place = |x: [f64; 2]| frame.place(x);
        let clip = Some(frame.area);
        let values = samples.iter().map(|&value| value as f32).collect();
        let cells = 0..self.mesh.cell_count();
        drawing.surface(body.surface(&lattice, cells, values, shading, place), clip);
        if self.mesh_lines {
            draw_mesh_lines(&mut drawing, &body, place, clip);
        }
        draw_polylines(&mut drawing, &outline, place, Stroke::solid(Colour::BLACK, 0.7), clip);
        if let Some(before) = before {
            draw_polylines(&mut drawing, &before, place, undeformed_stroke(), clip);
        }
        for (points, _, stroke) in &self.lines {
            let points: Vec<Point> = points.iter().map(|&x| place(x)).collect();
            drawing.polyline(&points, stroke.clone(), clip);
        }
        if let (Some(arrows), Some(longest)) = (arrows, longest) {
            draw_arrows(&mut drawing, &arrows, longest, place, frame.area);
        }
        layout.finish(&mut drawing, &frame);
        Ok(drawing)
    }
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
    let edges: Vec<Vec<Point>> =
        body.edges().iter().map(|edge| edge.iter().map(|&x| place(x)).collect()).collect();
    let length = |edge: &Vec<Point>| {
        edge.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum::<f64>()
    };
    let mut lengths: Vec<f64> = edges.iter().map(length).collect();
    lengths.sort_by(f64::total_cmp);
    let short = lengths.get(lengths.len() / 4).copied().unwrap_or(0.0);
    let colour = Colour::BLACK.with_opacity((0.12 * short).clamp(0.2, 0.6) as f32);
    let stroke = Stroke::solid(colour, (0.08 * short).clamp(0.12, 0.4));
    let segments = edges.iter().flat_map(|edge| polyline(edge)).collect();
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
    let segments: Vec<Segment> = super::body::joined(polylines)
        .iter()
        .flat_map(|line| polyline(&line.iter().map(|&x| place(x)).collect::<Vec<Point>>()))
        .collect();
    drawing.clipped_path(segments, None, Some(stroke), clip);
}

/// Positions and values of a vector field at the centres of the cells.
fn arrow_samples(body: &Body<'_>, field: &Field<2>) -> Vec<([f64; 2], [f64; 2])> {
    let centre = [body.mesh.shape().centre::<2>()];
    let basis = field.space.element.tabulate::<2>(&centre).value;
    let cells = 0..body.mesh.cell_count();
    let positions = body.positions(&centre, cells.clone());
    let value = |cell| {
        let u = field_values(field, cell, &basis);
        [u[0], u[1]]
    };
    positions.into_iter().zip(cells.map(value)).collect()
}

/// Draws at most one arrow in each square of a grid on the page.
fn draw_arrows(
    drawing: &mut Drawing,
    arrows: &[([f64; 2], [f64; 2])],
    longest: f64,
    place: impl Fn([f64; 2]) -> Point,
    area: Rectangle,
) {
    const SPACING: f64 = 18.0;
    let mut taken = std::collections::BTreeSet::new();
    for (position, u) in arrows {
        let at = place(*position);
        let square = ((at[0] / SPACING).floor() as i64, (at[1] / SPACING).floor() as i64);
        let length = SPACING * 1.1 * u[0].hypot(u[1]) / longest;
        if !area.contains(at) || !taken.insert(square) || length.is_nan() || length < 1.0 {
            continue;
        }
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
