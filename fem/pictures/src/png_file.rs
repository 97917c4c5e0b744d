//! A drawing as PNG.

use std::num::NonZeroUsize;

use tiny_skia::{FillRule, Mask, Paint, Path, PathBuilder, Pixmap, PixmapPaint, Transform};

use super::PictureError;
use super::colour_map::Colour;
use super::drawing::{Drawing, Item, Stroke};
use super::path::{Rectangle, Segment};
use super::shading::Pixels;

/// The bytes of a PNG file of the drawing, with its size in print noted in the file, made on the given number of threads.
///
/// # Errors
/// [`PictureError::Size`] of too many or no pixels; a failure of the encoder.
pub fn encode(drawing: &Drawing, dots_per_inch: f64, threads: NonZeroUsize) -> Result<Vec<u8>, PictureError> {
    let (rgb, size) = rgb(drawing, dots_per_inch, threads)?;
    // Lines and text compress well; a picture with shaded surfaces is half again to twice as large as with zlib, and written in a fraction of the time.
    let is_shaded = drawing.items.iter().any(|item| matches!(item, Item::Surface { .. }));
    let compression = if is_shaded { png::Compression::Fast } else { png::Compression::Balanced };
    encode_pixels(&rgb, size, (png::ColorType::Rgb, compression), Some(dots_per_inch))
}

/// Red, green and blue of each pixel of a drawing, row by row, with the numbers of columns and rows.
///
/// # Errors
/// [`PictureError::Size`] of too many or no pixels.
pub(crate) fn rgb(
    drawing: &Drawing,
    dots_per_inch: f64,
    threads: NonZeroUsize,
) -> Result<(Vec<u8>, [u32; 2]), PictureError> {
    let scale = dots_per_inch / 72.0;
    let [width, height] = drawing.size.map(|length| (length * scale).round());
    let too_large = PictureError::Size { width, height };
    if !(dots_per_inch > 0.0 && width * height <= 2e8 && width >= 1.0 && height >= 1.0) {
        return Err(too_large);
    }
    let mut page = Pixmap::new(width as u32, height as u32).ok_or(too_large)?;
    page.fill(tiny_skia::Color::WHITE);
    let mut masks = Masks::default();
    for item in &drawing.items {
        match item {
            Item::Path { segments, fill, stroke, clip } => {
                let Some(path) = path(segments) else { continue };
                let mask = masks.of(*clip, &page, scale);
                draw_path(&mut page, &path, *fill, stroke.as_ref(), scale, mask);
            }
            Item::Surface { surface, clip } => {
                let size = [page.width() as usize, page.height() as usize];
                let Some(pixels) = surface.pixels(scale, size, threads) else { continue };
                let mask = masks.of(*clip, &page, scale);
                let [x, y] = pixels.origin.map(|place| place as i32);
                let Some(image) = pixmap(pixels) else { continue };
                let paint = PixmapPaint::default();
                page.draw_pixmap(x, y, image.as_ref(), &paint, Transform::identity(), mask);
            }
        }
    }
    // The page is opaque, so premultiplied and plain colours agree; three of four bytes move together in place.
    let size = [page.width(), page.height()];
    let mut rgb = page.take();
    let pixels = rgb.len() / 4;
    for pixel in 0..pixels {
        rgb.copy_within(4 * pixel..4 * pixel + 3, 3 * pixel);
    }
    rgb.truncate(3 * pixels);
    Ok((rgb, size))
}

/// The bytes of a PNG file with transparency, for embedding.
///
/// # Errors
/// A failure of the encoder.
pub fn encode_surface(pixels: &Pixels) -> Result<Vec<u8>, PictureError> {
    let size = pixels.size.map(|length| length as u32);
    encode_pixels(&pixels.rgba, size, (png::ColorType::Rgba, png::Compression::Fast), None)
}

fn encode_pixels(
    data: &[u8],
    size: [u32; 2],
    (colours, compression): (png::ColorType, png::Compression),
    dots_per_inch: Option<f64>,
) -> Result<Vec<u8>, PictureError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(colours);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(compression);
    encoder.set_pixel_dims(dots_per_inch.map(|resolution| {
        let per_metre = (resolution / 0.0254).round() as u32;
        png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit: png::Unit::Meter }
    }));
    let encoding = |error: png::EncodingError| PictureError::Encoding { reason: error.to_string() };
    let mut writer = encoder.write_header().map_err(encoding)?;
    writer.write_image_data(data).map_err(encoding)?;
    writer.finish().map_err(encoding)?;
    Ok(bytes)
}

fn draw_path(
    page: &mut Pixmap,
    path: &Path,
    fill: Option<Colour>,
    stroke: Option<&Stroke>,
    scale: f64,
    mask: Option<&Mask>,
) {
    let transform = Transform::from_scale(scale as f32, scale as f32);
    if let Some(colour) = fill {
        page.fill_path(path, &paint(colour), FillRule::Winding, transform, mask);
    }
    if let Some(stroke) = stroke {
        let style = tiny_skia::Stroke {
            width: stroke.width as f32,
            line_join: tiny_skia::LineJoin::Round,
            dash: tiny_skia::StrokeDash::new(
                stroke.dashes.iter().map(|&length| length as f32).collect(),
                0.0,
            ),
            ..tiny_skia::Stroke::default()
        };
        page.stroke_path(path, &paint(stroke.colour), &style, transform, mask);
    }
}

fn paint(colour: Colour) -> Paint<'static> {
    let [red, green, blue] = colour.rgb;
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(red, green, blue, (colour.opacity.clamp(0.0, 1.0) * 255.0).round() as u8);
    paint
}

/// `None` for a path without extent or with a point that is not finite.
fn path(segments: &[Segment]) -> Option<Path> {
    let mut builder = PathBuilder::new();
    let float = |[x, y]: [f64; 2]| (x as f32, y as f32);
    for &segment in segments {
        match segment {
            Segment::Move(p) => {
                let (x, y) = float(p);
                builder.move_to(x, y);
            }
            Segment::Line(p) => {
                let (x, y) = float(p);
                builder.line_to(x, y);
            }
            Segment::Quadratic(a, p) => {
                let ((x1, y1), (x, y)) = (float(a), float(p));
                builder.quad_to(x1, y1, x, y);
            }
            Segment::Cubic(a, b, p) => {
                let ((x1, y1), (x2, y2), (x, y)) = (float(a), float(b), float(p));
                builder.cubic_to(x1, y1, x2, y2, x, y);
            }
            Segment::Close => builder.close(),
        }
    }
    builder.finish()
}

/// The mask of the last requested area. It is as large as the page, and consecutive items share it.
#[derive(Default)]
struct Masks(Option<(Rectangle, Option<Mask>)>);

impl Masks {
    fn of(&mut self, clip: Option<Rectangle>, page: &Pixmap, scale: f64) -> Option<&Mask> {
        let area = clip?;
        if self.0.as_ref().is_none_or(|(known, _)| *known != area) {
            self.0 = Some((area, mask(area, page, scale)));
        }
        self.0.as_ref().and_then(|(_, mask)| mask.as_ref())
    }
}

fn mask(area: Rectangle, page: &Pixmap, scale: f64) -> Option<Mask> {
    let corner = [area.left, area.top, area.right(), area.bottom()].map(|place| (place * scale) as f32);
    let rectangle = tiny_skia::Rect::from_ltrb(corner[0], corner[1], corner[2], corner[3])?;
    let mut mask = Mask::new(page.width(), page.height())?;
    mask.fill_path(&PathBuilder::from_rect(rectangle), FillRule::Winding, true, Transform::identity());
    Some(mask)
}

fn pixmap(mut pixels: Pixels) -> Option<Pixmap> {
    for pixel in pixels.rgba.chunks_exact_mut(4) {
        // Most pixels are whole or empty, and stay as they are.
        if !matches!(pixel[3], 0 | 255) {
            let colour = tiny_skia::ColorU8::from_rgba(pixel[0], pixel[1], pixel[2], pixel[3]).premultiply();
            pixel.copy_from_slice(&[colour.red(), colour.green(), colour.blue(), colour.alpha()]);
        }
    }
    let [width, height] = pixels.size.map(|length| length as u32);
    Pixmap::from_vec(pixels.rgba, tiny_skia::IntSize::from_wh(width, height)?)
}
