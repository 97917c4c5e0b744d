//! Animated PNG files: browsers and most viewers play them, others show the first frame.

use std::num::NonZeroUsize;
use std::path::Path;

use super::drawing::Drawing;
use super::{Picture, PictureError, png_file, write_bytes};

/// Pictures that follow each other, as one animated PNG file that begins anew after the last one.
///
/// ```no_run
/// # use forms_pictures::{Animation, Curve, LinePlot};
/// let mut animation = Animation::new(0.1);
/// for step in 0..20 {
///     let plot = LinePlot::new().curve(Curve::new("", &[0.0, 1.0], &[0.0, f64::from(step)])).y_range(0.0, 20.0);
///     animation = animation.frame(&plot)?;
/// }
/// animation.write_png_at("line.png", 96.0)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Animation {
    seconds: f64,
    frames: Vec<Drawing>,
}

impl Animation {
    /// An animation that shows each frame for this time \[s\], to thousandths.
    pub fn new(seconds: f64) -> Self {
        Animation { seconds, frames: vec![] }
    }

    /// The animation with one more frame.
    ///
    /// # Errors
    /// [`PictureError`] if the picture cannot be drawn; [`PictureError::Frame`] of another size.
    pub fn frame(mut self, picture: &impl Picture) -> Result<Self, PictureError> {
        let drawing = picture.draw()?;
        if let Some(first) = self.frames.first().filter(|first| first.size() != drawing.size()) {
            let frame = self.frames.len();
            return Err(PictureError::Frame { frame, found: drawing.size(), first: first.size() });
        }
        self.frames.push(drawing);
        Ok(self)
    }

    /// The animation as a file, at a resolution in dots per inch. It is written whole or not at all.
    ///
    /// # Errors
    /// [`PictureError::Empty`] without frames; a time that is not positive; a file that cannot be encoded or written.
    pub fn write_png_at(&self, path: impl AsRef<Path>, dots_per_inch: f64) -> Result<(), PictureError> {
        write_bytes(path.as_ref(), &self.encode(dots_per_inch)?)
    }

    fn encode(&self, dots_per_inch: f64) -> Result<Vec<u8>, PictureError> {
        let milliseconds = (1e3 * self.seconds).round();
        if !(1.0..=65_535.0).contains(&milliseconds) {
            let name = "the seconds of a frame".to_owned();
            return Err(PictureError::Range { name, low: 0.0, high: self.seconds });
        }
        let Some((first, later)) = self.frames.split_first() else {
            return Err(PictureError::Empty { picture: "the animation".to_owned() });
        };
        let encoding = |error: png::EncodingError| PictureError::Encoding { reason: error.to_string() };
        let (mut shown, size) = png_file::rgb(first, dots_per_inch, NonZeroUsize::MIN)?;
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        // An animation is looked at more often than it is written.
        encoder.set_compression(png::Compression::High);
        encoder.set_animated(self.frames.len() as u32, 0).map_err(encoding)?;
        encoder.set_frame_delay(milliseconds as u16, 1000).map_err(encoding)?;
        let mut writer = encoder.write_header().map_err(encoding)?;
        writer.write_image_data(&shown).map_err(encoding)?;
        for frame in later {
            let (next, _) = png_file::rgb(frame, dots_per_inch, NonZeroUsize::MIN)?;
            let part = Part::changed(&shown, &next, size[0] as usize);
            // Each is compared with the other one that is known, so both begin at the corner of the page.
            writer.reset_frame_position().map_err(encoding)?;
            writer.set_frame_dimension(part.width as u32, part.height as u32).map_err(encoding)?;
            writer.set_frame_position(part.left as u32, part.top as u32).map_err(encoding)?;
            writer.write_image_data(&part.of(&next, size[0] as usize)).map_err(encoding)?;
            shown = next;
        }
        writer.finish().map_err(encoding)?;
        Ok(bytes)
    }
}

/// The rectangle of a page that a frame changes \[pixel\].
#[derive(Debug, PartialEq)]
struct Part {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl Part {
    /// The smallest one; one pixel where nothing changes.
    fn changed(before: &[u8], after: &[u8], columns: usize) -> Self {
        let [mut left, mut right, mut top, mut bottom] = [usize::MAX, 0, usize::MAX, 0];
        let pixels = before.chunks_exact(3).zip(after.chunks_exact(3)).enumerate();
        for (place, _) in pixels.filter(|(_, (before, after))| before != after) {
            let (row, column) = (place / columns, place % columns);
            (left, right) = (left.min(column), right.max(column));
            (top, bottom) = (top.min(row), bottom.max(row));
        }
        match left {
            usize::MAX => Part { left: 0, top: 0, width: 1, height: 1 },
            _ => Part { left, top, width: right + 1 - left, height: bottom + 1 - top },
        }
    }

    /// Its pixels.
    fn of(&self, page: &[u8], columns: usize) -> Vec<u8> {
        let rows = self.top..self.top + self.height;
        let row = |row: usize| &page[3 * (row * columns + self.left)..][..3 * self.width];
        rows.flat_map(row).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Curve, LinePlot};

    fn plot(end: f64) -> LinePlot {
        LinePlot::new().curve(Curve::new("", &[0.0, 1.0], &[0.0, end])).y_range(0.0, 2.0).size(120.0, 80.0)
    }

    /// Frames are decoded as parts of the page, which together give the pages of single pictures.
    #[test]
    fn frames_are_the_pictures() {
        let ends = [1.0, 2.0, 2.0, 0.5];
        let animation =
            ends.iter().try_fold(Animation::new(0.25), |all, end| all.frame(&plot(*end))).unwrap();
        let bytes = animation.encode(72.0).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let control = reader.info().animation_control.unwrap();
        assert_eq!((control.num_frames, control.num_plays), (4, 0));
        let columns = reader.info().width as usize;
        let mut page = vec![0; reader.output_buffer_size().unwrap()];
        for end in ends {
            let mut pixels = vec![0; page.len()];
            let info = reader.next_frame(&mut pixels).unwrap();
            let frame = *reader.info().frame_control().unwrap();
            assert_eq!((frame.delay_num, frame.delay_den), (250, 1000));
            for row in 0..info.height as usize {
                let at = 3 * ((frame.y_offset as usize + row) * columns + frame.x_offset as usize);
                let line = &pixels[row * info.line_size..][..3 * info.width as usize];
                page[at..at + line.len()].copy_from_slice(line);
            }
            assert_eq!(
                page,
                png_file::rgb(&plot(end).draw().unwrap(), 72.0, NonZeroUsize::MIN).unwrap().0,
                "{end}"
            );
        }
    }

    #[test]
    fn misfits_are_refused() {
        let one = Animation::new(0.1).frame(&plot(1.0)).unwrap();
        let message = one.frame(&plot(1.0).size(90.0, 80.0)).err().unwrap().to_string();
        assert_eq!(
            message,
            "frame 1 of an animation has [90.0, 80.0] points, and the first one [120.0, 80.0]"
        );
        assert!(matches!(Animation::new(0.1).encode(72.0), Err(PictureError::Empty { .. })));
        let still = Animation::new(0.0).frame(&plot(1.0)).unwrap();
        assert!(matches!(still.encode(72.0), Err(PictureError::Range { .. })));
    }
}
