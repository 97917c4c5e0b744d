//! Common parts of an element kernel's integrals: the layout of the caller's lists, and the reference cell.

use forms_core::contract::{FieldDescription, Role};

use super::{ElementCells, ElementLayout};
use crate::assemble::AssemblyError;
use crate::assemble::batch::Cells;
use crate::assemble::binding::{Binding, List, Tabulated, Values};
use crate::assemble::element_kernel::fixed::FixedTables;
use crate::assemble::element_kernel::sizes::{Array, Sizes};
use crate::assemble::groups::Group;
use crate::contract::Form;
use crate::lanes::{Checked, Order};
use crate::mesh::Mesh;

/// Tables that are prepared once.
pub(super) struct ElementTables<const D: usize> {
    /// The reference cell as a mesh.
    pub reference: Mesh<D>,
    pub layout: ElementLayout,
    /// Values and elements of the form's fields, if the caller lists all of them.
    pub known: Option<(Vec<Values<'static, D>>, Vec<Tabulated>)>,
    /// Orders of the entries of a matrix, of a symmetric one, and of a vector.
    pub orders: [Order; 3],
    pub instructions: Checked,
}

impl<const D: usize> ElementTables<D> {
    /// Values that the caller lists, by field; `None` of those that come with the form.
    pub fn listed(&self, form: &Form<D>, binding: &mut Binding<D>) -> Vec<Option<Values<'static, D>>> {
        let value = |field: &FieldDescription| {
            let listed = self.layout.fields.iter().find(|known| known.name == field.name);
            let source = !matches!(
                field.role,
                Role::Unknown(_) | Role::Test(_) | Role::Direction(_) | Role::Mean(_) | Role::MeanTest(_)
            );
            match listed {
                Some(listed) => {
                    let element = Tabulated::lagrange(listed.element);
                    let element = binding.tabulated(element);
                    Some(Values::Given { element, offsets: listed.offsets.as_slice().into() })
                }
                None if source => None,
                None => Some(Values::Absent),
            }
        };
        form.fields().iter().map(value).collect()
    }

    pub fn bind<'a>(&'a self, form: &'a Form<D>) -> Result<Binding<'a, D>, AssemblyError> {
        let inputs = form.inputs();
        let mut binding = Binding::empty(form.name(), form.fields(), &inputs.regions, &self.reference);
        if let Some((values, elements)) = &self.known {
            (binding.values, binding.elements) = (List::Other(values), List::Other(elements));
            return Ok(binding);
        }
        // The arguments' element is the first one.
        binding.tabulated(Tabulated::lagrange(self.layout.element));
        let mut values = Vec::with_capacity(form.fields().len());
        let listed = self.listed(form, &mut binding);
        for ((field, listed), source) in form.fields().iter().zip(listed).zip(&inputs.sources) {
            values.push(match (listed, source) {
                (Some(listed), _) => listed,
                (None, Some(source)) => binding.resolve(field, source, &self.reference)?,
                (None, None) => Values::Absent,
            });
        }
        binding.values = List::Own(values);
        Ok(binding)
    }

    /// A group's tables as arrays, whose lengths must be the group's.
    ///
    /// # Errors
    /// [`AssemblyError::Layout`]: tables of other lengths.
    pub fn fixed<S: Sizes>(
        &self,
        form: &'static str,
        group: &Group<D>,
    ) -> Result<FixedTables<S, D>, AssemblyError> {
        let unsuited = |what: String| AssemblyError::Layout { form, what };
        let Some((values, _)) = &self.known else {
            let what = "with fixed sizes the caller lists the coefficients of every field";
            return Err(unsuited(what.to_owned()));
        };
        let side = &group.sides[0];
        for (what, found, fixed) in [
            ("nodes", side.elements[0].nodes, <S::Nodes<f64> as Array<f64>>::LENGTH),
            ("points", group.points(), <S::Points<f64> as Array<f64>>::LENGTH),
            ("geometry nodes", side.geometry.nodes, <S::GeometryNodes<f64> as Array<f64>>::LENGTH),
        ] {
            if found != fixed {
                return Err(unsuited(format!("there are {found} {what}, and {fixed} are fixed")));
            }
        }
        Ok(FixedTables::new(group, values, &self.layout))
    }

    pub fn cells<'a>(&'a self, cells: &ElementCells<'a>) -> Cells<'a, D> {
        Cells::Given {
            coordinates: cells.coordinates,
            stride: self.layout.coordinate_stride,
            offsets: &self.layout.coordinate_offsets,
            coefficients: cells.coefficients,
            coefficient_stride: self.layout.coefficient_stride,
        }
    }
}
