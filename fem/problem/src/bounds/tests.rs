//! Bounds: the strictest one counts, and contradictions are named.

use super::*;
use crate::element::CellShape;
use crate::mesh::rectangle;

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn space() -> Result<Arc<Space<2>>, Box<dyn std::error::Error>> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1)?;
    Ok(Space::vector(&mesh, 1)?)
}

#[test]
fn the_strictest_bound_counts() -> Outcome {
    let mut bounds = Bounds::new(&space()?);
    bounds.at_least("all", |x| [x[0], f64::NEG_INFINITY])?.component_at_least("left", 0, |_| -1.0)?;
    bounds.component_at_most("left", 0, |_| 0.5)?.component_at_most("left", 0, |_| 0.25)?;
    assert_eq!(bounds.unknowns().len(), 9);
    assert_eq!(bounds.of(0), (0.0, 0.25));
    assert_eq!(bounds.of(1), (f64::NEG_INFINITY, f64::INFINITY));
    Ok(())
}

#[test]
fn contradictions_and_numbers_that_are_none_are_named() -> Outcome {
    let mut bounds = Bounds::new(&space()?);
    bounds.component_at_least("left", 1, |_| 0.5)?;
    let crossing = bounds.component_at_most("all", 1, |x| x[0]).map(|_| ()).unwrap_err().to_string();
    assert_eq!(
        crossing,
        "region \"all\": component 1 at [0.0, 0.0] has the upper bound 0, but region \"left\" gave it the lower bound 0.5"
    );
    let nan = bounds
        .at_least("top", |x| [0.0, if x[0] == 0.0 { f64::NAN } else { 0.0 }])
        .map(|_| ())
        .unwrap_err()
        .to_string();
    assert_eq!(nan, "region \"top\": the bound of component 1 at [0.0, 1.0] is NaN");
    assert!(bounds.at_least("top", |_| [f64::INFINITY, 0.0]).is_err());
    assert!(bounds.at_least("top", |_| 0.0).is_err() && bounds.at_least("nowhere", |_| [0.0; 2]).is_err());
    assert!(bounds.component_at_most("top", 2, |_| 0.0).is_err());
    // Nothing was entered.
    assert_eq!(bounds.unknowns().len(), 3);
    Ok(())
}
