//! Several pictures side by side on one page.

use super::axes::{GAP, TITLE_TEXT};
use super::drawing::Drawing;
use super::text::Anchor;
use super::{Picture, PictureError};

/// A panel of pictures, filled row after row.
#[derive(Clone)]
pub struct Panel {
    columns: usize,
    letters: bool,
    title: String,
    drawings: Vec<Drawing>,
}

impl Panel {
    /// An empty panel with a number of columns (at least one).
    pub fn new(columns: usize) -> Panel {
        Panel { columns: columns.max(1), letters: false, title: String::new(), drawings: Vec::new() }
    }

    /// One more picture.
    ///
    /// # Errors
    /// [`PictureError`] if the picture cannot be drawn.
    pub fn picture(mut self, picture: &impl Picture) -> Result<Panel, PictureError> {
        self.drawings.push(picture.draw()?);
        Ok(self)
    }

    /// Letters (a), (b), … at the upper left corner of each picture.
    pub fn letters(mut self) -> Panel {
        self.letters = true;
        self
    }

    /// Title above all pictures.
    pub fn title(mut self, title: &str) -> Panel {
        self.title = title.into();
        self
    }
}

impl Picture for Panel {
    fn draw(&self) -> Result<Drawing, PictureError> {
        if self.drawings.is_empty() {
            return Err(PictureError::Empty { picture: format!("the panel \"{}\"", self.title) });
        }
        let columns = self.columns.min(self.drawings.len());
        let rows = self.drawings.len().div_ceil(columns);
        let (mut widths, mut heights) = (vec![0.0_f64; columns], vec![0.0_f64; rows]);
        for (k, drawing) in self.drawings.iter().enumerate() {
            let [width, height] = drawing.size();
            widths[k % columns] = widths[k % columns].max(width);
            heights[k / columns] = heights[k / columns].max(height);
        }
        let gap = 2.0 * GAP;
        // The letters have a strip of their own above each row.
        let strip = if self.letters { TITLE_TEXT + GAP } else { 0.0 };
        heights.iter_mut().for_each(|height| *height += strip);
        let header = if self.title.is_empty() { 0.0 } else { TITLE_TEXT + 3.0 * GAP };
        let total = |lengths: &[f64]| lengths.iter().sum::<f64>() + gap * (lengths.len() - 1) as f64;
        let size = [total(&widths), header + total(&heights)];
        let mut page = Drawing::new(size)?;
        page.text(&self.title, TITLE_TEXT + 1.0, [size[0] / 2.0, GAP + TITLE_TEXT], Anchor::at(0.5, 0.0));
        for (k, drawing) in self.drawings.iter().enumerate() {
            let (column, row) = (k % columns, k / columns);
            let left = widths[..column].iter().sum::<f64>() + gap * column as f64;
            let top = header + heights[..row].iter().sum::<f64>() + gap * row as f64;
            // A smaller picture is in the middle of its column, at the top of its row.
            let inset = (widths[column] - drawing.size()[0]) / 2.0;
            page.place(drawing.clone(), [left + inset, top + strip]);
            if self.letters {
                let letter = char::from(b'a' + (k % 26) as u8);
                page.text(&format!("({letter})"), TITLE_TEXT, [left + GAP, top + GAP], Anchor::at(0.0, 1.0));
            }
        }
        Ok(page)
    }
}
