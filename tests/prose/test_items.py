"""What `items.py` finds in a source.

    python3 -m unittest discover -s tests/prose
"""

import unittest

from items import documented_items, is_riddle, is_verb_phrase, lacks_errors

SOURCE = '''
/// The rows of a matrix.
#[derive(Clone)]
pub struct Rows;

impl Rows {
    /// The same with other rows.
    pub fn with<F: Fn(u32) -> u32>(self, rows: F) -> Self {
        self
    }

    /// Adds a row.
    ///
    /// # Errors
    /// A row that is there.
    pub fn add(
        &mut self,
        row: u32,
    ) -> Result<(), Error> {
        Ok(())
    }

    /// Values of a row.
    pub fn values(&self, of: impl Fn() -> Result<u32, Error>) -> Vec<f64> {
        vec![]
    }

    /// The row of a name.
    pub fn find(&self, name: &str) -> Result<u32, Error> {
        Err(Error)
    }

    pub fn undocumented(&self) -> Result<u32, Error> {
        Err(Error)
    }
}

#[cfg(test)]
mod tests {
    /// What is tested.
    pub fn helper() {}
}
'''


class Items(unittest.TestCase):
    def test_items_with_documentation(self):
        items = list(documented_items(SOURCE))
        self.assertEqual([name for _, _, name, _, _ in items], ["Rows", "with", "add", "values", "find"])
        self.assertEqual([kind for _, kind, *_ in items], ["struct", "fn", "fn", "fn", "fn"])

    def test_faults(self):
        items = {name: (kind, docs, signature) for _, kind, name, docs, signature in documented_items(SOURCE)}
        self.assertEqual([name for name, (_, docs, _) in items.items() if is_riddle(docs)], ["with"])
        self.assertEqual([name for name, (_, docs, _) in items.items() if is_verb_phrase(docs)], ["add"])
        self.assertTrue(is_verb_phrase("Solves A x = b."))
        self.assertFalse(is_verb_phrase("Loads of a tool."))
        # A result of a closure that is passed in is none of the function.
        self.assertEqual([name for name, item in items.items() if lacks_errors(*item)], ["find"])


if __name__ == "__main__":
    unittest.main()
