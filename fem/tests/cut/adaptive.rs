//! Backgrounds that are fine around an interface, and follow it.

use forms_fem::adaptivity::{Adaptation, AdaptiveSolution, ErrorEstimate, InterfaceBand};
use forms_fem::cut::Cut;
use forms_fem::mesh::AdaptiveMesh;
use forms_fem::prelude::*;

use crate::{circle, level, square};

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// The largest diameter of a cut cell.
fn largest(cut: &Cut<2>) -> f64 {
    cut.cut_cells().iter().map(|cell| cut.mesh().diameter(*cell as usize)).fold(0.0, f64::max)
}

#[test]
fn bands_follow_the_interface() -> Outcome<()> {
    let area = form!(|| -> Functional { integral(cells("all"), 1) });
    let measured = |phi: &Field<2>| -> Outcome<f64> {
        Ok(Assembler::new(phi.space().mesh()).cut_by(phi)?.functional(&area)?)
    };
    let coarse = AdaptiveMesh::new(square(8, CellShape::Triangle))?;
    let band = InterfaceBand::new(0.03, 0.03)?;
    let disc = |space: &Arc<Space<2>>| -> Outcome<_> { Ok(Field::interpolate(space, circle)?) };
    let (mut mesh, mut phi) = band.fitted(&coarse, disc)?;
    // Order 2, with the cells of the band.
    assert!((measured(&phi)? - 0.49 * std::f64::consts::PI).abs() < 3e-4);
    let first = mesh.mesh().cell_count();
    for _ in 0..4 {
        let grown = Field::from_values(phi.space(), phi.values().iter().map(|v| v - 0.05).collect())?;
        let known = measured(&grown)?;
        (mesh, phi) = band.fitted(&mesh, |space| -> Outcome<_> { Ok(grown.onto(space).interpolated()?) })?;
        assert!((measured(&phi)? - known).abs() < 1e-12);
        assert!(largest(&*Cut::by(&phi)?) <= 0.03);
        // Less than a tenth of a uniform mesh of such cells, as at first.
        assert!(mesh.mesh().cell_count() < 2 * first, "{first} {}", mesh.mesh().cell_count());
    }
    assert_eq!(
        InterfaceBand::<2>::new(0.1, 0.0).err().map(|error| error.to_string()).as_deref(),
        Some("the size of the band's cells is 0; it must be positive")
    );
    Ok(())
}

#[test]
fn cycles_divide_the_cells_that_they_are_asked_to() -> Outcome<()> {
    let left = |x: &[f64; 2]| x[0] < 0.0;
    let band = InterfaceBand::new(0.0, 0.05)?.only_in(&left);
    let solve = |mesh: &Mesh<2>, _: Option<&Field<2>>| -> Outcome<_> {
        let phi = level(mesh, circle);
        let estimate = ErrorEstimate::of_squares(&vec![0.0; mesh.cell_count()])?;
        let large = band.large_cells(&phi);
        Ok(AdaptiveSolution::new(phi, estimate).dividing(large))
    };
    let found = Adaptation::to_tolerance(1.0).run(square(6, CellShape::Triangle), solve, |_| ())?;
    let cut = Cut::by(&found.solution.field)?;
    assert!(band.large_cells(&found.solution.field).is_empty() && found.steps.len() > 3);
    let on_left = |cell: &&u32| cut.mesh().cell_centre(**cell as usize)[0] < 0.0;
    let left = cut.cut_cells().iter().filter(on_left).map(|cell| cut.mesh().diameter(*cell as usize));
    assert!(left.fold(0.0, f64::max) <= 0.05 && largest(&cut) > 0.2);
    Ok(())
}
