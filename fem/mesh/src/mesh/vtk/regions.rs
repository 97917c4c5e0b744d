//! Which region each cell of a grid belongs to, and what the regions are called.

use std::collections::{BTreeMap, BTreeSet};

use super::VtkReader;
use super::error::VtkProblem;
use super::grid::Grid;
use crate::mesh::imported::Contents;

/// Names of arrays that hold regions: ours and those of meshio (from Gmsh and from Medit) and VMTK.
const USUAL: [&str; 4] = ["region", "gmsh:physical", "CellEntityIds", "medit:ref"];

/// The number of each cell.
pub(super) struct Regions {
    pub(super) numbers: Vec<i64>,
}

impl Regions {
    /// The numbers of the array that the reader names or that has a usual name, if there is one.
    pub(super) fn find(grid: &Grid, reader: &VtkReader) -> Result<Option<Self>, VtkProblem> {
        let with_name = |name: &str| grid.cell_data.iter().find(|array| array.name == name);
        let array = match &reader.array {
            Some(name) => Some(with_name(name).ok_or_else(|| no_array(name, grid))?),
            None => USUAL.into_iter().find_map(with_name),
        };
        let Some(array) = array else {
            // Names are for numbers, and there are none.
            return match reader.cells.is_empty() && reader.facets.is_empty() {
                true => Ok(None),
                false => Err(no_array(USUAL[0], grid)),
            };
        };
        let number = |cell: usize| {
            let place = cell * array.components;
            let number = array.values.integer(place).filter(|_| array.components == 1);
            let value = || array.values.real(place);
            number.ok_or_else(|| VtkProblem::NoRegionNumber {
                array: array.name.clone(),
                cell,
                value: value(),
            })
        };
        let numbers = (0..grid.types.len()).map(number).collect::<Result<_, _>>()?;
        Ok(Some(Regions { numbers }))
    }

    /// Names the groups of cells and facets.
    pub(super) fn name<const D: usize>(
        &self,
        reader: &VtkReader,
        contents: &mut Contents,
    ) -> Result<(), VtkProblem> {
        for (dimension, names, what, prefix) in
            [(D, &reader.cells, "cell", "region"), (D - 1, &reader.facets, "facet", "facets")]
        {
            let of_dimension = contents.elements.iter().zip(&self.numbers);
            let of_dimension = of_dimension.filter(|(element, _)| element.kind.dimension == dimension);
            let numbers: BTreeSet<i64> =
                of_dimension.map(|(_, &number)| number).filter(|&number| number >= 0).collect();
            if let Some((&number, name)) = names.iter().find(|(number, _)| !numbers.contains(number)) {
                let existing = numbers.into_iter().collect();
                return Err(VtkProblem::NoSuchNumber { name: name.clone(), what, number, existing });
            }
            let named =
                |number: i64| names.get(&number).cloned().unwrap_or_else(|| format!("{prefix} {number}"));
            let group_names: BTreeMap<_, _> =
                numbers.into_iter().map(|number| ((dimension, number), named(number))).collect();
            contents.names.extend(group_names);
        }
        Ok(())
    }
}

fn no_array(name: &str, grid: &Grid) -> VtkProblem {
    let existing = grid.cell_data.iter().map(|array| array.name.clone()).collect();
    VtkProblem::NoRegionArray { array: name.to_owned(), existing }
}
