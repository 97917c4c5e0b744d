//! A body that is cut from a mesh by a level set function, whose own surface is inside of cells.

use forms_fem::assemble::PointValues;
use forms_fem::cut::{Cut, CutError};
use forms_fem::prelude::*;

/// Places and weights of Gauss's rule with five points on \[−1, 1\].
const RULE: [[f64; 2]; 5] = [
    [-0.906_179_845_938_664, 0.236_926_885_056_189_1],
    [-0.538_469_310_105_683_1, 0.478_628_670_499_366_5],
    [0.0, 0.568_888_888_888_888_9],
    [0.538_469_310_105_683_1, 0.478_628_670_499_366_5],
    [0.906_179_845_938_664, 0.236_926_885_056_189_1],
];

/// Steps of the secant method from a chord to a curved surface.
const SECANTS: usize = 5;

/// A body that is cut from the mesh of a case.
#[derive(Clone, Debug)]
pub struct CutBody {
    /// The level set function, negative in the body.
    pub level: Field<2>,
    /// The body.
    pub cut: Arc<Cut<2>>,
    /// The assembler on it.
    pub assembler: Assembler<2>,
}

impl CutBody {
    /// The body on a mesh where a function is negative. On quadrilaterals its boundary is curved.
    ///
    /// # Errors
    /// A function that is negative nowhere.
    pub fn of(mesh: &Mesh<2>, level: impl Fn(&[f64; 2]) -> f64) -> Result<Self, forms_fem::output::Failure> {
        let degree = if mesh.cell_shape(0) == CellShape::Quadrilateral { 2 } else { 1 };
        let level = Field::interpolate(&Space::scalar(mesh, degree)?, level)?;
        let cut = Cut::by(&level)?;
        let assembler = Assembler::new(mesh).with_cut(&cut)?;
        Ok(CutBody { level, cut, assembler })
    }

    /// Conditions on unknowns that the body does not have.
    ///
    /// # Errors
    /// Conditions on another mesh.
    pub fn hold_outside(&self, constraints: &mut Constraints<2>) -> Result<(), CutError> {
        self.cut.hold_outside(constraints)
    }

    /// A function that needs no facet at points of the surface inside of cells, with weights: those of the chords of a curved one.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn at_surface(&self, function: &Expression<2>) -> Result<PointValues<2>, AssemblyError> {
        let (mut places, mut weights) = (vec![], vec![]);
        for [a, b] in self.cut.interface() {
            let half = 0.5 * (b[0] - a[0]).hypot(b[1] - a[1]);
            for [at, weight] in RULE {
                let on_chord = [0, 1].map(|k| 0.5 * ((1.0 - at) * a[k] + (1.0 + at) * b[k]));
                let normal = [(b[1] - a[1]) / (2.0 * half), (a[0] - b[0]) / (2.0 * half)];
                places.push(self.on_surface(on_chord, normal, half));
                weights.push(half * weight);
            }
        }
        let found = Assembler::new(self.cut.mesh()).at_points(function, &places)?;
        Ok(PointValues { weights, ..found })
    }

    /// The place near a chord, along its normal, where the function vanishes; that on the chord where it is straight, or outside of the mesh.
    fn on_surface(&self, chord: [f64; 2], normal: [f64; 2], half: f64) -> [f64; 2] {
        let place = |off: f64| [0, 1].map(|k| chord[k] + off * normal[k]);
        let value = |off: f64| self.level.evaluate(&place(off)).map(|value| value[0]);
        // Chords are off by a small part of their length.
        let (mut before, mut off) = (1e-3 * half, 0.0);
        for _ in 0..SECANTS {
            let (Ok(last), Ok(now)) = (value(before), value(off)) else { return chord };
            if now == last || self.level.space().degree() == 1 {
                break;
            }
            (before, off) = (off, off - now * (off - before) / (now - last));
        }
        place(off)
    }
}
