//! Sinks for element matrices and vectors, batch by batch.

use crate::assemble::AssemblyError;

/// Takes the results of a batch.
pub(in crate::assemble) trait Sink {
    /// Memory for `count` results of `size` numbers each, that of entity `first` first.
    fn room(&mut self, first: usize, count: usize, size: usize) -> &mut [f64];
    /// The memory that was given last has been filled.
    fn filled(&mut self, first: usize, count: usize, size: usize) -> Result<(), AssemblyError>;
}

/// Callback for element matrices or vectors: the first entity, and those of it and its successors.
pub(in crate::assemble) type Deliver<'a> = &'a mut dyn FnMut(usize, &[f64]) -> Result<(), AssemblyError>;

/// Numbers in a line of the first cache.
const LINE: usize = 8;

/// Hands over each batch from a buffer, times a factor.
pub(in crate::assemble) struct Buffered<'a> {
    factor: f64,
    buffer: Vec<f64>,
    /// The first number that begins a line of the cache: vectors that lie across two lines are written at half of the speed.
    start: usize,
    deliver: Deliver<'a>,
}

impl<'a> Buffered<'a> {
    pub fn new(factor: f64, deliver: Deliver<'a>) -> Self {
        Buffered { factor, buffer: vec![], start: 0, deliver }
    }
}

impl Sink for Buffered<'_> {
    #[inline]
    fn room(&mut self, _: usize, count: usize, size: usize) -> &mut [f64] {
        if self.buffer.len() < count * size + LINE {
            self.buffer.resize(count * size + LINE, 0.0);
            self.start = self.buffer.as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
        }
        &mut self.buffer[self.start..][..count * size]
    }

    #[inline]
    fn filled(&mut self, first: usize, count: usize, size: usize) -> Result<(), AssemblyError> {
        let filled = &mut self.buffer[self.start..][..count * size];
        if self.factor != 1.0 {
            filled.iter_mut().for_each(|value| *value *= self.factor);
        }
        (self.deliver)(first, filled)
    }
}

/// Writes to memory of the caller, over what is there or in addition to it.
pub(in crate::assemble) struct Direct<'a> {
    pub target: &'a mut [f64],
    /// Room for results before they are added; `None`: they are not added.
    pub addend: Option<&'a mut Vec<f64>>,
}

impl Sink for Direct<'_> {
    #[inline(always)]
    fn room(&mut self, first: usize, count: usize, size: usize) -> &mut [f64] {
        match &mut self.addend {
            None => &mut self.target[first * size..][..count * size],
            Some(addend) => {
                addend.resize(count * size, 0.0);
                &mut addend[..]
            }
        }
    }

    #[inline(always)]
    fn filled(&mut self, first: usize, count: usize, size: usize) -> Result<(), AssemblyError> {
        if let Some(addend) = &self.addend {
            for (sum, value) in self.target[first * size..][..count * size].iter_mut().zip(&addend[..]) {
                *sum += *value;
            }
        }
        Ok(())
    }
}
