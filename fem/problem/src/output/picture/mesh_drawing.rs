//! Meshes with their named regions in different colours.

use super::body::{Body, Lattices, bounds};
use super::body_lines::{draw_mesh_lines, draw_polylines, with_margin};
use super::drawing::{Drawing, Stroke};
use super::layout::Layout;
use super::legend::{Key, Legend};
use super::shading::Shading;
use super::{Colour, ColourMap, Marker};
use super::{Picture, PictureError};
use crate::mesh::{Facet, Mesh};
use crate::solve::Oscillation;

/// Width of the first region's line \[pt\].
const REGION_LINE: f64 = 3.2;

/// A picture of a mesh; named facets are drawn as thick lines.
pub struct MeshDrawing<'a> {
    mesh: &'a Mesh<2>,
    regions: Vec<(String, Vec<Facet>)>,
    cells: Vec<(String, Vec<u32>)>,
    points: Vec<(String, Vec<[f64; 2]>)>,
    title: String,
    unit: Option<String>,
    window: Option<[[f64; 2]; 2]>,
    largest: [f64; 2],
}

impl<'a> MeshDrawing<'a> {
    /// The mesh without regions.
    pub fn new(mesh: &'a Mesh<2>) -> MeshDrawing<'a> {
        MeshDrawing {
            mesh,
            regions: Vec::new(),
            cells: Vec::new(),
            points: Vec::new(),
            title: String::new(),
            unit: Some(String::new()),
            window: None,
            largest: [300.0, 300.0],
        }
    }

    /// A region of facets in a colour of its own, with its name in the legend.
    ///
    /// # Errors
    /// [`PictureError::Mesh`] if there is no such region.
    pub fn region(self, name: &str) -> Result<Self, PictureError> {
        self.named_region(name, name)
    }

    /// A region of facets in a colour of its own, with another name than its own in the legend.
    ///
    /// # Errors
    /// [`PictureError::Mesh`] if there is no such region.
    pub fn named_region(mut self, region: &str, name: &str) -> Result<Self, PictureError> {
        self.regions.push((name.into(), self.mesh.facet_region(region)?.to_vec()));
        Ok(self)
    }

    /// A region of cells, filled with a colour of its own, with its name in the legend.
    ///
    /// # Errors
    /// [`PictureError::Mesh`] if there is no such region.
    pub fn cell_region(mut self, name: &str) -> Result<Self, PictureError> {
        self.cells.push((name.into(), self.mesh.cell_region(name)?.to_vec()));
        Ok(self)
    }

    /// All regions of facets except the whole boundary, smaller ones over larger ones.
    pub fn all_regions(mut self) -> Self {
        let names = self.mesh.facet_region_names().filter(|&name| name != "boundary");
        for name in names {
            if let Ok(facets) = self.mesh.facet_region(name) {
                self.regions.push((name.into(), facets.to_vec()));
            }
        }
        self.regions.sort_by_key(|(_, facets)| std::cmp::Reverse(facets.len()));
        self
    }

    /// Points with a marker, and their name in the legend.
    pub fn points(mut self, points: &[[f64; 2]], name: &str) -> Self {
        self.points.push((name.into(), points.to_vec()));
        self
    }

    /// The points that oscillated before Newton's method failed, by region and by the switch that changes.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// use forms_fem::output::picture::{MeshDrawing, Picture};
    ///
    /// # fn draw(mesh: &Mesh<2>, error: &NewtonError) -> Result<(), Box<dyn std::error::Error>> {
    /// if let Some(oscillation) = &error.oscillation {
    ///     MeshDrawing::new(mesh).oscillation(oscillation).write_svg("oscillation.svg")?;
    /// }
    /// # Ok(())
    /// # }
    /// ```
    pub fn oscillation(mut self, oscillation: &Oscillation) -> Self {
        let mut groups: Vec<(String, Vec<[f64; 2]>)> = vec![];
        for point in &oscillation.points {
            let [x, y] = point.position[..] else { continue };
            let switches: Vec<String> = point.switches.iter().map(usize::to_string).collect();
            let plural = if switches.len() == 1 { "switch" } else { "switches" };
            let name = format!("{}: {plural} {}", point.region, switches.join(", "));
            match groups.iter_mut().find(|(known, _)| *known == name) {
                Some((_, points)) => points.push([x, y]),
                None => groups.push((name, vec![[x, y]])),
            }
        }
        self.points.extend(groups);
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

    /// The picture without axes.
    pub fn without_axes(mut self) -> Self {
        self.unit = None;
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

    /// The line of a region: it is thinner where it would hide an earlier region altogether.
    fn stroke(&self, number: usize) -> Stroke {
        let facets = &self.regions[number].1;
        let hidden = |other: &[Facet]| other.iter().all(|facet| facets.contains(facet));
        let below = self.regions[..number].iter().filter(|(_, other)| hidden(other)).count();
        Stroke::solid(Colour::of_series(number), REGION_LINE / (1.0 + 0.9 * below as f64))
    }

    fn keys(&self) -> Vec<Key> {
        let regions = self.regions.iter().enumerate();
        let mut keys: Vec<Key> = regions
            .map(|(k, (name, _))| Key { text: name.clone(), stroke: self.stroke(k), marker: None })
            .collect();
        keys.extend(self.cells.iter().enumerate().map(|(k, (name, _))| Key {
            text: name.clone(),
            stroke: Stroke::solid(cell_colour(k), 8.0),
            marker: None,
        }));
        keys.extend(self.points.iter().enumerate().map(|(k, (name, _))| Key {
            text: name.clone(),
            stroke: Stroke::solid(self.point_colour(k), 0.0),
            marker: Some(Marker::Circle),
        }));
        keys
    }

    /// Points have colours that regions do not have.
    fn point_colour(&self, number: usize) -> Colour {
        Colour::of_series(self.regions.len() + number + 1)
    }
}

/// A pale colour for a region of cells.
fn cell_colour(number: usize) -> Colour {
    let rgb = Colour::of_series(number + 2).rgb.map(|channel| ((u16::from(channel) + 2 * 255) / 3) as u8);
    Colour { rgb, opacity: 1.0 }
}

impl Picture for MeshDrawing<'_> {
    fn draw(&self) -> Result<Drawing, PictureError> {
        let body = Body { mesh: self.mesh, displacement: None };
        let outline = body.facets(self.mesh.boundary_facets());
        let layout = Layout {
            title: &self.title,
            unit: self.unit.as_deref(),
            axes: ["x", "y"],
            largest: self.largest,
            window: self.window.unwrap_or_else(|| with_margin(bounds(&outline), 0.04)),
            bar: None,
            legend: Legend::new(self.keys()),
        };
        let (mut drawing, frame) = layout.begin()?;
        let place = |x: [f64; 2]| frame.place(x);
        let clip = Some(frame.area);
        let lattices = Lattices::of(self.mesh);
        let mut fill = |cells: &[u32], colour: Colour| {
            let shading =
                Shading { map: ColourMap::Viridis, range: [0.0, 1.0], levels: None, flat: Some(colour) };
            let values = vec![0.0; lattices.points_in(self.mesh, cells)];
            drawing.surface(body.surface(&lattices, cells, values, shading, place), clip);
        };
        let all: Vec<u32> = (0..self.mesh.body_cells().end as u32).collect();
        fill(&all, Colour::grey(238));
        for (number, (_, cells)) in self.cells.iter().enumerate() {
            fill(cells, cell_colour(number));
        }
        draw_mesh_lines(&mut drawing, &body, place, clip);
        draw_polylines(&mut drawing, &outline, place, Stroke::solid(Colour::BLACK, 0.7), clip);
        for (number, (_, facets)) in self.regions.iter().enumerate() {
            draw_polylines(&mut drawing, &body.facets(facets), place, self.stroke(number), clip);
        }
        for (number, (_, points)) in self.points.iter().enumerate() {
            for point in points.iter().map(|point| place(*point)).filter(|point| frame.area.contains(*point))
            {
                let edge = Stroke::solid(Colour::WHITE, 0.5);
                drawing.path(Marker::Circle.outline(point, 2.6), Some(self.point_colour(number)), Some(edge));
            }
        }
        layout.finish(&mut drawing, &frame);
        Ok(drawing)
    }
}
