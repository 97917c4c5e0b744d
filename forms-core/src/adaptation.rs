//! A compiled function as an addend of a sum: its factor, and the numbers that its fields and regions have there.
//!
//! Kernels and descriptions of integrals name fields and regions by number. In a sum the fields and regions of several functions
//! are in one list, so that the descriptions are written again with other numbers. The kernels are the same.

mod kept;

pub(crate) use self::kept::text;
use crate::degree::{Degree, DegreeSum};
use crate::form::{Integral, Means};
use crate::kernel::{FieldSlot, Requirements};

/// A factor of kernels, and new numbers of fields and regions.
#[derive(Clone, Copy, Debug)]
pub struct Adaptation<'a> {
    factor: f64,
    /// The new number of each field.
    fields: &'a [usize],
    /// The number of regions before those of the function.
    regions: usize,
    /// The number of lists of means before those of the function.
    means: usize,
}

impl<'a> Adaptation<'a> {
    /// The factor, the new number of each field, and the numbers of regions and of lists of means before those of the function.
    pub(crate) fn new(factor: f64, fields: &'a [usize], regions: usize, means: usize) -> Self {
        Adaptation { factor, fields, regions, means }
    }

    /// The same without the factor.
    pub(crate) fn without_factor(self) -> Self {
        Adaptation { factor: 1.0, ..self }
    }

    /// The factor of all that a kernel computes.
    pub fn factor(&self) -> f64 {
        self.factor
    }

    /// Inputs of a kernel, with the new numbers of fields.
    pub fn requirements(&self, of_kernel: &'static Requirements) -> &'static Requirements {
        let is_kept = |slot: &FieldSlot| self.fields[slot.field] == slot.field;
        if of_kernel.fields.iter().all(is_kept) {
            return of_kernel;
        }
        let slots = of_kernel.fields.iter().map(|slot| FieldSlot { field: self.fields[slot.field], ..*slot });
        kept::requirements(Requirements { fields: kept::slots(slots.collect()), ..*of_kernel })
    }

    /// The description of an integral, with the new numbers of fields and regions.
    pub(crate) fn integral(&self, integral: &'static Integral) -> &'static Integral {
        let degree_is_kept =
            |sum: &DegreeSum| sum.fields.iter().all(|[field, ..]| self.fields[*field] == *field);
        let is_displaced = integral.displacement.is_some();
        let means_are_kept = self.means == 0 || integral.means.is_none();
        if self.regions == 0
            && !is_displaced
            && means_are_kept
            && integral.degree.0.iter().all(degree_is_kept)
        {
            return integral;
        }
        let numbers =
            |fields: &[usize]| kept::numbers(fields.iter().map(|field| self.fields[*field]).collect());
        let degree_sum = |sum: &DegreeSum| {
            let factors =
                sum.fields.iter().map(|[field, order, count]| [self.fields[*field], *order, *count]);
            DegreeSum { fields: kept::factors(factors.collect()), ..*sum }
        };
        kept::integral(Integral {
            region: self.regions + integral.region,
            displacement: integral.displacement.map(numbers),
            means: integral.means.map(|means| Means { number: self.means + means.number, ..means }),
            degree: Degree(kept::degree_sums(integral.degree.0.iter().map(degree_sum).collect())),
            ..*integral
        })
    }
}
