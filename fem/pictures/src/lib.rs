//! Pictures for papers, as PNG and as SVG: curves, bars, panels, and the page on which `forms-fem` draws fields and meshes.
//!
//! Lengths on the page are points, 1/72 inch. Text takes `_{…}` and `^{…}` for subscripts and
//! superscripts. Everything needed is compiled in: no system font, no system library.

mod animation;
#[doc(hidden)]
pub mod axes;
mod bar_chart;
mod colour_map;
mod curve;
#[doc(hidden)]
pub mod drawing;
#[doc(hidden)]
pub mod layout;
#[doc(hidden)]
pub mod legend;
mod line_plot;
mod panel;
#[doc(hidden)]
pub mod path;
#[doc(hidden)]
pub mod png_file;
mod sampling;
#[doc(hidden)]
pub mod shading;
mod surface_map;
#[doc(hidden)]
pub mod svg_file;
mod text;

use std::io::Write;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use thiserror::Error;

use forms_mesh::files::write_whole;

pub use animation::Animation;
pub use axes::Scale;
pub use bar_chart::BarChart;
pub use colour_map::{Colour, ColourMap};
pub use curve::{Curve, Marker};
pub use drawing::Drawing;
pub use line_plot::LinePlot;
pub use panel::Panel;
pub use surface_map::SurfaceMap;

/// Resolution of PNG files unless another one is asked for.
pub const DOTS_PER_INCH: f64 = 250.0;

/// Errors of drawing or writing a picture.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum PictureError {
    /// There is nothing to draw.
    #[error("there is nothing to draw in {picture}")]
    Empty {
        /// Name of the picture or of the curve.
        picture: String,
    },
    /// A value to be drawn is not a finite number.
    #[error("value {index} of \"{name}\" is {value}, which cannot be drawn")]
    NotFinite {
        name: String,
        /// Place in the data.
        index: usize,
        value: f64,
    },
    /// A value in a cell is not a finite number.
    #[error("\"{name}\" is {value} in cell {cell}, which cannot be drawn")]
    CellNotFinite { name: String, cell: usize, value: f64 },
    /// A field on another mesh than the picture's.
    #[error("the field \"{name}\" lives on another mesh")]
    OtherMesh { name: String },
    /// A field that has no values in cells.
    #[error(
        "the field \"{name}\" lives on the facets of \"{region}\" alone; sample it along them for a line plot"
    )]
    OnFacets {
        name: String,
        /// The facet region of its space.
        region: String,
    },
    /// A field on a space that pictures do not show.
    #[error("\"{name}\" has {space}, which pictures do not show")]
    Space {
        name: String,
        /// Elements and scope of its space.
        space: String,
    },
    /// The mesh has no such region.
    #[error(transparent)]
    Mesh(#[from] forms_mesh::mesh::MeshError),
    /// A logarithmic axis got a value that has no logarithm.
    #[error("value {index} of \"{name}\" is {value}, which cannot stand on a logarithmic axis")]
    NotPositive {
        name: String,
        /// Place in the data.
        index: usize,
        value: f64,
    },
    /// Data of the wrong length.
    #[error("\"{name}\" has {found} values where {expected} are needed")]
    Length { name: String, expected: usize, found: usize },
    /// An interval without length.
    #[error("the range of {name} from {low} to {high} has no length")]
    Range {
        /// The name of the values.
        name: String,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// A page that has no area or is too large.
    #[error("a picture of {width} × {height} cannot be drawn")]
    Size { width: f64, height: f64 },
    /// A frame of an animation that has another size than the first one.
    #[error("frame {frame} of an animation has {found:?} points, and the first one {first:?}")]
    Frame { frame: usize, found: [f64; 2], first: [f64; 2] },
    /// The embedded font cannot be read.
    #[error("the embedded font cannot be read: {reason}")]
    Font {
        /// The font reader's error.
        reason: String,
    },
    /// The picture cannot be encoded.
    #[error("the picture cannot be encoded: {reason}")]
    Encoding {
        /// The encoder's error.
        reason: String,
    },
    /// The file cannot be written.
    #[error("the picture cannot be written: {source}")]
    Write {
        /// The system's error, with the name of the file.
        source: std::io::Error,
    },
}

/// Something that can be drawn and written to a file.
pub trait Picture {
    /// Draws the picture.
    ///
    /// # Errors
    /// [`PictureError`] if the data cannot be drawn.
    fn draw(&self) -> Result<Drawing, PictureError>;

    /// Writes the picture as PNG at [`DOTS_PER_INCH`]. The file is written whole or not at all.
    ///
    /// ```no_run
    /// # use forms_pictures::{Curve, LinePlot, Picture};
    /// LinePlot::new().curve(Curve::new("", &[0.0, 1.0], &[0.0, 1.0])).write_png("line.png")?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`PictureError`] if the data cannot be drawn or the file cannot be written.
    fn write_png(&self, path: impl AsRef<Path>) -> Result<(), PictureError>
    where
        Self: Sized,
    {
        self.write_png_at(path, DOTS_PER_INCH)
    }

    /// Writes the picture as PNG at a resolution in dots per inch.
    ///
    /// # Errors
    /// [`PictureError`] if the data cannot be drawn or the file cannot be written.
    fn write_png_at(&self, path: impl AsRef<Path>, dots_per_inch: f64) -> Result<(), PictureError>
    where
        Self: Sized,
    {
        write_bytes(path.as_ref(), &png_file::encode(&self.draw()?, dots_per_inch, NonZeroUsize::MIN)?)
    }

    /// Writes the picture as SVG. The file is written whole or not at all.
    ///
    /// # Errors
    /// [`PictureError`] if the data cannot be drawn or the file cannot be written.
    fn write_svg(&self, path: impl AsRef<Path>) -> Result<(), PictureError>
    where
        Self: Sized,
    {
        write_bytes(path.as_ref(), svg_file::encode(&self.draw()?)?.as_bytes())
    }
}

impl Picture for Drawing {
    fn draw(&self) -> Result<Drawing, PictureError> {
        Ok(self.clone())
    }

    fn write_png_at(&self, path: impl AsRef<Path>, dots_per_inch: f64) -> Result<(), PictureError> {
        write_bytes(path.as_ref(), &png_file::encode(self, dots_per_inch, NonZeroUsize::MIN)?)
    }
}

/// Drawings of pictures, made on the given number of threads, in the order of the list.
///
/// # Errors
/// The first [`PictureError`] in the list.
pub fn draw_all(
    pictures: &[&(dyn Picture + Sync)],
    threads: NonZeroUsize,
) -> Result<Vec<Drawing>, PictureError> {
    let order: Vec<usize> = (0..pictures.len()).collect();
    on_threads(&order, threads, |number| pictures[number].draw()).into_iter().collect()
}

/// PNG files of drawings at [`DOTS_PER_INCH`], each written whole or not at all, on the given number of threads.
///
/// # Errors
/// The first [`PictureError`] in the list, of a drawing that cannot be encoded or a file that cannot be written.
pub fn write_all_png(
    drawings: &[(impl AsRef<Path> + Sync, Drawing)],
    threads: NonZeroUsize,
) -> Result<(), PictureError> {
    // The largest pages first, so that none of them is left to one thread at the end.
    let mut order: Vec<usize> = (0..drawings.len()).collect();
    let area = |drawing: &Drawing| drawing.size().iter().product::<f64>();
    order.sort_by(|a, b| area(&drawings[*b].1).total_cmp(&area(&drawings[*a].1)));
    // Threads beyond one for each page are shared among the pages.
    let own = NonZeroUsize::new(threads.get() / drawings.len().max(1)).unwrap_or(NonZeroUsize::MIN);
    let write = |number: usize| {
        let (path, drawing) = &drawings[number];
        write_bytes(path.as_ref(), &png_file::encode(drawing, DOTS_PER_INCH, own)?)
    };
    on_threads(&order, threads, write).into_iter().collect()
}

/// Results of work on the numbers 0, 1, … as far as `order` goes, begun in that order.
fn on_threads<R: Send>(order: &[usize], threads: NonZeroUsize, work: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let some = || -> Vec<(usize, R)> {
        let mut results = Vec::new();
        while let Some(&number) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            results.push((number, work(number)));
        }
        results
    };
    let others = threads.get().min(order.len()).saturating_sub(1);
    let mut results = std::thread::scope(|scope| {
        let others: Vec<_> = (0..others).map(|_| scope.spawn(some)).collect();
        let mut results = some();
        for other in others {
            results.extend(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        results
    });
    results.sort_by_key(|(number, _)| *number);
    results.into_iter().map(|(_, result)| result).collect()
}

fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), PictureError> {
    write_whole(path, |writer| writer.write_all(bytes)).map_err(|source| PictureError::Write { source })
}
