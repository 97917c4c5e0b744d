//! Pictures for papers, as PNG and as SVG: fields on bodies, meshes with their regions, curves, bars, panels.
//!
//! Lengths on the page are points, 1/72 inch. Text takes `_{…}` and `^{…}` for subscripts and
//! superscripts. Everything needed is compiled in: no system font, no system library.

mod body;
mod body_lines;
mod field_map;
mod mesh_drawing;

#[doc(inline)]
pub use forms_pictures::{
    Animation, BarChart, Colour, ColourMap, Curve, DOTS_PER_INCH, Drawing, LinePlot, Marker, Panel, Picture,
    PictureError, Scale, SurfaceMap, draw_all, write_all_png,
};
use forms_pictures::{axes, drawing, layout, legend, path, shading};

pub use field_map::{FieldMap, Shown};
pub use mesh_drawing::MeshDrawing;

#[cfg(test)]
mod tests;
