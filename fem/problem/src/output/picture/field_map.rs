//! Fields as colours on a plane body, deformed or not.

use super::axes::number;
use super::body::{Body, Lattices, bounds, field_values};
use super::body_lines::{
    arrow_samples, arrow_stroke, draw_arrows, draw_mesh_lines, draw_polylines, with_margin,
};
use super::drawing::{Drawing, Stroke};
use super::layout::Layout;
use super::legend::{Key, Legend};
use super::path::Point;
use super::shading::Shading;
use super::{Colour, ColourMap};
use super::{Picture, PictureError};
use crate::field::Field;
use crate::mesh::Mesh;
use crate::output::lives_on;

/// The scalar of a field that is shown.
///
/// ```
/// # use forms_fem::output::picture::Shown;
/// // The displacement along x; `Shown::Magnitude` shows its length.
/// let shown = Shown::Component(0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// A component by its number; tensors are numbered row by row.
    Component(usize),
    /// The square root of the sum of the squares of all components.
    Magnitude,
}

/// A value of a cell at a reference point.
type CellFunction<'a> = Box<dyn Fn(usize, &[f64; 2]) -> f64 + Sync + 'a>;

enum Values<'a> {
    Field(&'a Field<2>, Shown),
    Function(CellFunction<'a>),
}

/// A picture of a field on a body.
///
/// ```no_run
/// # use forms_fem::prelude::*;
/// # use forms_fem::output::picture::{FieldMap, Picture, Shown};
/// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
/// # let space = Space::vector(&mesh, 1)?;
/// let u = Field::interpolate(&space, |x| [0.1 * x[0], 0.0])?;
/// FieldMap::of(&u, Shown::Magnitude, "|u| [mm]")
///     .title("Stretched")
///     .length_unit("mm")
///     .deformed(&u, 10.0)
///     .write_png("stretched.png")?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FieldMap<'a> {
    mesh: &'a Mesh<2>,
    values: Values<'a>,
    label: String,
    displacement: Option<(&'a Field<2>, f64)>,
    title: String,
    unit: Option<String>,
    axes: [String; 2],
    colours: ColourMap,
    levels: Option<usize>,
    range: Option<[f64; 2]>,
    window: Option<[[f64; 2]; 2]>,
    largest: [f64; 2],
    mesh_lines: bool,
    outline: bool,
    undeformed: Option<String>,
    lines: Vec<(Vec<[f64; 2]>, String, Stroke)>,
    arrows: Option<(&'a Field<2>, String, String)>,
}

impl<'a> FieldMap<'a> {
    /// A picture of a field; the label, with the unit, is at the colour bar.
    pub fn of(field: &'a Field<2>, shown: Shown, label: &str) -> FieldMap<'a> {
        FieldMap::new(field.space().mesh(), Values::Field(field, shown), label)
    }

    /// A picture of a function of the cell's number and the point in its reference cell; it may jump
    /// between cells, as stresses do.
    pub fn cell_by_cell(
        mesh: &'a Mesh<2>,
        value: impl Fn(usize, &[f64; 2]) -> f64 + Sync + 'a,
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
            unit: Some(String::new()),
            axes: ["x".into(), "y".into()],
            colours: ColourMap::default(),
            levels: None,
            range: None,
            window: None,
            largest: [300.0, 300.0],
            mesh_lines: true,
            outline: true,
            undeformed: None,
            lines: Vec::new(),
            arrows: None,
        }
    }

    /// The body displaced by `factor` times a vector field.
    pub fn deformed(mut self, displacement: &'a Field<2>, factor: f64) -> Self {
        self.displacement = Some((displacement, factor));
        self
    }

    /// Title above the picture.
    pub fn title(mut self, title: &str) -> Self {
        self.title = title.into();
        self
    }

    /// The unit of length at the axes; none unless one is given.
    pub fn length_unit(mut self, unit: &str) -> Self {
        self.unit = Some(unit.into());
        self
    }

    /// The names of the horizontal and the vertical coordinate, x and y unless given: a section of a body in space has others.
    pub fn axes(mut self, horizontal: &str, vertical: &str) -> Self {
        self.axes = [horizontal.into(), vertical.into()];
        self
    }

    /// The picture without axes.
    pub fn without_axes(mut self) -> Self {
        self.unit = None;
        self
    }

    /// The colour map. With [`ColourMap::Vik`] the range is symmetric about zero unless it is given.
    pub fn colour_map(mut self, map: ColourMap) -> Self {
        self.colours = map;
        self
    }

    /// Bands of equal colour instead of a continuous map.
    pub fn levels(mut self, count: usize) -> Self {
        self.levels = Some(count);
        self
    }

    /// The values at the ends of the colour map; otherwise they follow the field.
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some([low, high]);
        self
    }

    /// Part of the plane that is shown.
    pub fn window(mut self, x: [f64; 2], y: [f64; 2]) -> Self {
        self.window = Some([[x[0], y[0]], [x[1], y[1]]]);
        self
    }

    /// Largest width and height of the body on the page \[pt\]; 300 × 300 unless given.
    pub fn size(mut self, width: f64, height: f64) -> Self {
        self.largest = [width, height];
        self
    }

    /// The picture without edges of cells.
    pub fn without_mesh_lines(mut self) -> Self {
        self.mesh_lines = false;
        self
    }

    /// The picture without edges of cells and without the body's outline: for pieces of a cut body, whose facets are all outer ones.
    pub fn without_lines(mut self) -> Self {
        (self.mesh_lines, self.outline) = (false, false);
        self
    }

    /// Outline of the body before its deformation, with a name for the legend.
    pub fn undeformed_outline(mut self, name: &str) -> Self {
        self.undeformed = Some(name.into());
        self
    }

    /// A line, for example the ground below a body, with a name for the legend.
    pub fn line(mut self, points: &[[f64; 2]], name: &str, colour: Colour) -> Self {
        self.lines.push((points.to_vec(), name.into(), Stroke::solid(colour, 1.4)));
        self
    }

    /// Arrows of a vector field; the legend says how long the longest one is, in the
    /// unit given.
    pub fn arrows(mut self, field: &'a Field<2>, name: &str, unit: &str) -> Self {
        self.arrows = Some((field, name.into(), unit.into()));
        self
    }

    /// The values at the lattice points of all cells.
    fn sample(&self, lattices: &Lattices, cells: &[u32]) -> Result<Vec<f64>, PictureError> {
        let mut samples = Vec::with_capacity(lattices.points_in(self.mesh, cells));
        let runs = || self.mesh.runs_of_shape(cells);
        match &self.values {
            Values::Function(value) => {
                for (shape, run) in runs() {
                    let points = &lattices.of_shape(shape).points;
                    for &cell in run {
                        samples.extend(points.iter().map(|point| value(cell as usize, point)));
                    }
                }
            }
            Values::Field(field, shown) => {
                if let Some(region) = field.space().facet_region() {
                    let (name, region) = (self.label.clone(), region.into());
                    return Err(PictureError::OnFacets { name, region });
                }
                check_scope(field, &self.label)?;
                let components = field.space().components();
                if let Shown::Component(k) = *shown
                    && k >= components
                {
                    return Err(PictureError::Length {
                        name: self.label.clone(),
                        expected: k + 1,
                        found: components,
                    });
                }
                for (shape, run) in runs() {
                    let element = field.space().element_of(shape);
                    let basis = element.tabulate::<2>(&lattices.of_shape(shape).points).value;
                    for &cell in run {
                        let values = field_values(field, cell as usize, &basis);
                        samples.extend(values.chunks(components).map(|value| match *shown {
                            Shown::Component(k) => value[k],
                            Shown::Magnitude => value.iter().map(|v| v * v).sum::<f64>().sqrt(),
                        }));
                    }
                }
            }
        }
        match samples.iter().position(|value| !value.is_finite()) {
            Some(place) => {
                let before = |cell: &usize| lattices.points_in(self.mesh, &cells[..*cell + 1]) <= place;
                let cell = (0..cells.len()).take_while(before).count();
                Err(PictureError::CellNotFinite { name: self.label.clone(), cell, value: samples[place] })
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
        // A range that begins near zero begins at zero, so that the colour bar shows it.
        if low > 0.0 && low < 0.1 * high {
            low = 0.0;
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
        if !lives_on(field, self.mesh) {
            return Err(PictureError::OtherMesh { name: name.into() });
        }
        if let Some(region) = field.space().facet_region() {
            return Err(PictureError::OnFacets { name: name.into(), region: region.into() });
        }
        check_scope(field, name)?;
        let components = field.space().components();
        if components != 2 {
            return Err(PictureError::Length { name: name.into(), expected: 2, found: components });
        }
        match field.values().iter().position(|value| !value.is_finite()) {
            Some(index) => {
                Err(PictureError::NotFinite { name: name.into(), index, value: field.values()[index] })
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
        if let (Some((_, name, unit)), Some(longest)) = (&self.arrows, longest) {
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

impl Picture for FieldMap<'_> {
    fn draw(&self) -> Result<Drawing, PictureError> {
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
        let lattices = Lattices::of(self.mesh);
        let cells: Vec<u32> = (0..self.mesh.body_cells().end as u32).collect();
        let samples = self.sample(&lattices, &cells)?;
        let shading = self.shading(&samples)?;
        let outline = body.facets(self.mesh.boundary_facets());
        let before = self.undeformed.as_ref().map(|_| still.facets(self.mesh.boundary_facets()));
        let lines = self.lines.iter().map(|(points, ..)| points);
        let shown = bounds(outline.iter().chain(before.iter().flatten()).chain(lines));
        let window = self.window.unwrap_or_else(|| with_margin(shown, 0.04));
        let arrows = match &self.arrows {
            Some((field, name, _)) => {
                self.check_vector(field, name)?;
                Some(arrow_samples(&body, field))
            }
            None => None,
        };
        let longest =
            arrows.as_ref().map(|arrows| arrows.iter().map(|(_, u)| u[0].hypot(u[1])).fold(0.0, f64::max));
        let layout = Layout {
            title: &self.title,
            unit: self.unit.as_deref(),
            axes: [&self.axes[0], &self.axes[1]],
            largest: self.largest,
            window,
            bar: Some((shading, self.label.clone())),
            legend: Legend::new(self.keys(longest)),
        };
        let (mut drawing, frame) = layout.begin()?;
        let place = |x: [f64; 2]| frame.place(x);
        let clip = Some(frame.area);
        let values = samples.iter().map(|&value| value as f32).collect();
        drawing.surface(body.surface(&lattices, &cells, values, shading, place), clip);
        if self.mesh_lines {
            draw_mesh_lines(&mut drawing, &body, place, clip);
        }
        if self.outline {
            draw_polylines(&mut drawing, &outline, place, Stroke::solid(Colour::BLACK, 0.7), clip);
        }
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

/// Fields are drawn by the functions of the reference cell, which all cells have.
fn check_scope(field: &Field<2>, name: &str) -> Result<(), PictureError> {
    let space = field.space();
    match space.is_on_all_cells() {
        true => Ok(()),
        false => {
            let space = format!("{} {}", space.elements(), space.scope());
            Err(PictureError::Space { name: name.into(), space })
        }
    }
}
