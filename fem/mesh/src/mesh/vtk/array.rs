//! The values of a file's arrays.

use super::error::VtkProblem;

/// Values at the nodes or on the cells of a mesh, `values[place * components + component]`.
#[derive(Clone, Debug, PartialEq)]
pub struct VtkArray {
    /// The array's name in the file.
    pub name: String,
    /// Number of values per node or cell.
    pub components: usize,
    /// The values, in the file's units.
    pub values: Vec<f64>,
}

/// An array of a file.
#[derive(Clone, Debug)]
pub(super) struct RawArray {
    pub(super) name: String,
    pub(super) components: usize,
    pub(super) values: Values,
}

/// Numbers as the file has them.
#[derive(Clone, Debug)]
pub(super) enum Values {
    Integers(Vec<i64>),
    Reals(Vec<f64>),
}

/// A type of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NumberType {
    /// Bytes.
    pub(super) size: usize,
    sort: Sort,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sort {
    Signed,
    Unsigned,
    Real,
}

impl NumberType {
    pub(super) const BYTE: NumberType = NumberType { size: 1, sort: Sort::Unsigned };
    pub(super) const INT: NumberType = NumberType { size: 4, sort: Sort::Signed };
    pub(super) const FLOAT: NumberType = NumberType { size: 4, sort: Sort::Real };

    /// By its name in an XML file or in a legacy file.
    pub(super) fn of(name: &str) -> Option<Self> {
        let (size, sort) = match name.to_ascii_lowercase().as_str() {
            "int8" | "char" | "signed_char" | "vtktypeint8" => (1, Sort::Signed),
            "uint8" | "unsigned_char" | "vtktypeuint8" => (1, Sort::Unsigned),
            "int16" | "short" | "vtktypeint16" => (2, Sort::Signed),
            "uint16" | "unsigned_short" | "vtktypeuint16" => (2, Sort::Unsigned),
            // Legacy files store identifiers in 32 bits.
            "int32" | "int" | "vtktypeint32" | "vtkidtype" => (4, Sort::Signed),
            "uint32" | "unsigned_int" | "vtktypeuint32" => (4, Sort::Unsigned),
            "int64" | "long" | "vtktypeint64" => (8, Sort::Signed),
            "uint64" | "unsigned_long" | "vtktypeuint64" => (8, Sort::Unsigned),
            "float32" | "float" => (4, Sort::Real),
            "float64" | "double" => (8, Sort::Real),
            _ => return None,
        };
        Some(NumberType { size, sort })
    }

    /// Numbers from their bytes.
    pub(super) fn decode(self, bytes: &[u8], little: bool) -> Values {
        let words = bytes.chunks_exact(self.size).map(|chunk| {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            if !little {
                word[..chunk.len()].reverse();
            }
            u64::from_le_bytes(word)
        });
        let empty = 64 - 8 * self.size as u32;
        match (self.sort, self.size) {
            (Sort::Real, 4) => {
                Values::Reals(words.map(|word| f64::from(f32::from_bits(word as u32))).collect())
            }
            (Sort::Real, _) => Values::Reals(words.map(f64::from_bits).collect()),
            (Sort::Signed, _) => {
                Values::Integers(words.map(|word| ((word << empty) as i64) >> empty).collect())
            }
            // What is beyond the largest integer is no number of a point, cell or region.
            (Sort::Unsigned, _) => {
                Values::Integers(words.map(|word| i64::try_from(word).unwrap_or(i64::MAX)).collect())
            }
        }
    }

    /// Numbers from words; the first word that is none is the error.
    pub(super) fn parse<'a>(self, mut words: impl Iterator<Item = &'a str>) -> Result<Values, &'a str> {
        if self.sort == Sort::Real {
            return words
                .map(|word| word.parse().map_err(|_| word))
                .collect::<Result<_, _>>()
                .map(Values::Reals);
        }
        words
            .try_fold(Vec::new(), |mut values, word| {
                values.push(word.parse::<i64>().map_err(|_| word)?);
                Ok(values)
            })
            .map(Values::Integers)
    }
}

impl Values {
    pub(super) fn len(&self) -> usize {
        match self {
            Values::Integers(values) => values.len(),
            Values::Reals(values) => values.len(),
        }
    }

    /// As reals.
    pub(super) fn real(&self, place: usize) -> f64 {
        match self {
            Values::Integers(values) => values[place] as f64,
            Values::Reals(values) => values[place],
        }
    }

    /// As an integer, if it is a whole number.
    pub(super) fn integer(&self, place: usize) -> Option<i64> {
        match self {
            Values::Integers(values) => Some(values[place]),
            // The bound is where reals stop to tell whole numbers apart.
            Values::Reals(values) => {
                let value = values[place];
                (value.fract() == 0.0 && value.abs() < 9.0e15).then_some(value as i64)
            }
        }
    }

    /// All as integers, for an array that holds nothing else.
    pub(super) fn integers(self, array: &str) -> Result<Vec<i64>, VtkProblem> {
        match self {
            Values::Integers(values) => Ok(values),
            Values::Reals(_) => Err(VtkProblem::array(array, "its numbers are not of an integer type")),
        }
    }
}

impl RawArray {
    /// An array with the given number of tuples.
    pub(super) fn new(
        name: &str,
        components: usize,
        tuples: usize,
        values: Values,
    ) -> Result<Self, VtkProblem> {
        let expected = components.checked_mul(tuples);
        if expected != Some(values.len()) || components == 0 {
            let reason =
                format!("it has {} values where {tuples} times {components} are needed", values.len());
            return Err(VtkProblem::array(name, reason));
        }
        Ok(RawArray { name: name.to_owned(), components, values })
    }

    /// The values at some places.
    pub(super) fn at(&self, places: &[usize]) -> VtkArray {
        let tuple =
            |&place: &usize| (0..self.components).map(move |k| self.values.real(place * self.components + k));
        VtkArray {
            name: self.name.clone(),
            components: self.components,
            values: places.iter().flat_map(tuple).collect(),
        }
    }
}
