//! Two squares whose contact ends at unknown places (Hüeber's thesis, page 44; CalculiX's test hueeber1).

use forms_fem::mesh::Facet;
use forms_fem::output::Failure;
use forms_fem::prelude::*;

use crate::body;
use crate::case::{Case, Contact};
use crate::outcome::Outcome;
use crate::problem::{Problem, Quantity};

/// Lower \[0,10\]², upper above it; mm and MPa.
pub struct Squares;

impl Problem for Squares {
    fn name(&self) -> String {
        "squares".to_owned()
    }

    fn statement(&self) -> &'static str {
        "Hüeber's two squares, mm and MPa, 15 and 17.5 cells on the coarsest mesh; CalculiX on 60 and 70 cells"
    }

    fn case(&self, level: usize, degree: usize) -> Result<Case, Failure> {
        let square = |low: f64, cells: usize| {
            rectangle([0.0, low], [10.0, low + 10.0], [cells; 2], CellShape::Quadrilateral, 1)
        };
        let (lower, upper) = (square(0.0, 15 << level)?, square(10.0, (35 << level) / 2)?);
        let mut mesh = Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)])?;
        let mut sides: Vec<Facet> = mesh.facet_region("lower left")?.to_vec();
        sides.extend_from_slice(mesh.facet_region("lower right")?);
        mesh.name_listed_facets("sides", &sides)?;
        let space = Space::vector(&mesh, degree)?;
        let mut constraints = Constraints::new(&space);
        constraints.fix("lower bottom", |_| [0.0; 2])?;
        constraints.fix("upper top", |_| [0.0, -5e-4])?;
        let materials = Space::of(&mesh, Elements::Lagrange(0), Scope::Cell, &[])?;
        let of_bodies = |lower: f64, upper: f64| {
            Field::interpolate(&materials, move |x| if x[1] < 10.0 { lower } else { upper })
        };
        let (soft, hard) = (super::lame(15000.0, 0.2), super::lame(20000.0, 0.4));
        let data = body::data()
            .lambda(&of_bodies(soft[0], hard[0])?)
            .mu(&of_bodies(soft[1], hard[1])?)
            .young(&of_bodies(15000.0, 20000.0)?)
            .traction(|x: &[f64; 2]| if x[0] < 5.0 { [0.1, -1.0] } else { [-0.1, -1.0] });
        Ok(Case {
            space,
            constraints,
            data,
            loaded: "sides".to_owned(),
            cut: None,
            contact: Contact::Bodies(["lower top", "upper bottom"].map(str::to_owned)),
            start: None,
            pressure: 0.5,
            approach: 5e-4,
        })
    }

    fn quantities(&self, _case: &Case, found: &Outcome) -> Result<Vec<Quantity>, Failure> {
        let mut all = vec![];
        let places = [(9.6667, [4.735e-4, -1.0478e-3]), (5.5, [4.983e-5, -4.6762e-4])];
        let names = [["u_x(9.6667)", "u_y(9.6667)"], ["u_x(5.5)", "u_y(5.5)"]];
        for ((x, exact), names) in places.into_iter().zip(names) {
            // Just below the surface, for the point is one of both bodies.
            let u = found.u.evaluate(&[x, 10.0 - 1e-9])?;
            all.extend((0..2).map(|k| Quantity { name: names[k], value: u[k], exact: Some(exact[k]) }));
        }
        let pressures = &found.pressures;
        let length = pressures.integral(|_, pressure| if pressure > 0.0 { 1.0 } else { 0.0 });
        all.push(Quantity { name: "force", value: pressures.force(), exact: None });
        all.push(Quantity { name: "contact length", value: length, exact: None });
        Ok(all)
    }
}
