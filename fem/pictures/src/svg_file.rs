//! A drawing as SVG. Text is written as outlines, so that every reader shows the same picture;
//! shaded surfaces are embedded as PNG.

use std::fmt::Write;
use std::num::NonZeroUsize;

use super::PictureError;
use super::colour_map::Colour;
use super::drawing::{Drawing, Item};
use super::path::{Rectangle, Segment};
use super::png_file;
use forms_mesh::files::base64;

/// Resolution of embedded surfaces \[pixels per point\]: 288 dots per inch.
const SURFACE_SCALE: f64 = 4.0;

/// The text of an SVG file of the drawing.
///
/// # Errors
/// A failure of the encoder of embedded pictures.
pub fn encode(drawing: &Drawing) -> Result<String, PictureError> {
    let mut text = String::new();
    write_elements(&mut text, drawing)?;
    Ok(text)
}

fn write_elements(text: &mut String, drawing: &Drawing) -> Result<(), PictureError> {
    let encoding = |error: std::fmt::Error| PictureError::Encoding { reason: error.to_string() };
    let [width, height] = drawing.size;
    writeln!(
        text,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}pt\" height=\"{height}pt\" \
         viewBox=\"0 0 {width} {height}\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>"
    )
    .map_err(encoding)?;
    for (number, item) in drawing.items.iter().enumerate() {
        let (Item::Path { clip, .. } | Item::Surface { clip, .. }) = item;
        let clipped = match clip {
            Some(area) => {
                write_clip(text, number, *area).map_err(encoding)?;
                format!(" clip-path=\"url(#clip{number})\"")
            }
            None => String::new(),
        };
        match item {
            Item::Path { segments, fill, stroke, .. } => {
                let fill = fill.map_or("fill=\"none\"".into(), |colour| attribute("fill", colour));
                let stroke = stroke.as_ref().map_or(String::new(), |stroke| {
                    let dashes: Vec<String> = stroke.dashes.iter().map(f64::to_string).collect();
                    format!(
                        " {} stroke-width=\"{}\" stroke-linejoin=\"round\" stroke-dasharray=\"{}\"",
                        attribute("stroke", stroke.colour),
                        stroke.width,
                        if dashes.is_empty() { "none".into() } else { dashes.join(" ") },
                    )
                });
                writeln!(text, "<path{clipped} {fill}{stroke} d=\"{}\"/>", path_data(segments))
                    .map_err(encoding)?;
            }
            Item::Surface { surface, .. } => {
                let page = drawing.size.map(|length| (length * SURFACE_SCALE).ceil() as usize);
                let Some(pixels) = surface.pixels(SURFACE_SCALE, page, NonZeroUsize::MIN) else { continue };
                let [x, y] = pixels.origin.map(|place| place as f64 / SURFACE_SCALE);
                let [width, height] = pixels.size.map(|length| length as f64 / SURFACE_SCALE);
                write!(
                    text,
                    "<image{clipped} x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
                     href=\"data:image/png;base64,"
                )
                .map_err(encoding)?;
                base64::append(text, &png_file::encode_surface(&pixels)?);
                text.push_str("\"/>\n");
            }
        }
    }
    text.push_str("</svg>\n");
    Ok(())
}

fn write_clip(text: &mut String, number: usize, area: Rectangle) -> std::fmt::Result {
    let Rectangle { left, top, width, height } = area;
    writeln!(
        text,
        "<clipPath id=\"clip{number}\"><rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/>\
         </clipPath>"
    )
}

fn attribute(name: &str, colour: Colour) -> String {
    let [red, green, blue] = colour.rgb;
    let code = format!("{name}=\"#{red:02x}{green:02x}{blue:02x}\"");
    if colour.opacity >= 1.0 { code } else { format!("{code} {name}-opacity=\"{}\"", colour.opacity) }
}

fn path_data(segments: &[Segment]) -> String {
    let point = |[x, y]: [f64; 2]| format!("{} {}", rounded(x), rounded(y));
    let pieces: Vec<String> = segments
        .iter()
        .map(|&segment| match segment {
            Segment::Move(p) => format!("M{}", point(p)),
            Segment::Line(p) => format!("L{}", point(p)),
            Segment::Quadratic(a, p) => format!("Q{} {}", point(a), point(p)),
            Segment::Cubic(a, b, p) => format!("C{} {} {}", point(a), point(b), point(p)),
            Segment::Close => "Z".into(),
        })
        .collect();
    pieces.join("")
}

/// A coordinate to a hundredth of a point.
fn rounded(coordinate: f64) -> f64 {
    (coordinate * 100.0).round() / 100.0
}
