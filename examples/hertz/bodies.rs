//! The two bodies and their obstacles. A quarter of each is enough.

use clap::ValueEnum;
use forms_fem::prelude::*;

/// R, radius of the ball \[mm\].
pub const RADIUS: f64 = 8.0;
/// Width of the quarter \[mm\]; the block is as high.
pub const WIDTH: f64 = 4.0;

/// What is pressed onto what.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Body {
    /// A ball, with its centre at the origin, on a rigid flat
    Ball,
    /// A block on a rigid ball around (0, 0, −R)
    Block,
}

/// Three quarters of the cells lie within 0.18 of the way, of equal size: the contact is among them. The others grow.
pub fn graded(t: f64) -> f64 {
    let (near, slope) = (0.75, 0.24);
    let rest = (1.0 - slope) / (1.0_f64 - near).powi(2);
    slope * t + rest * (t - near).max(0.0).powi(2)
}

impl Body {
    /// The name of its pictures.
    pub fn name(self) -> &'static str {
        match self {
            Body::Ball => "hertz_ball",
            Body::Block => "hertz_block",
        }
    }

    /// What pictures are called.
    pub fn title(self) -> &'static str {
        match self {
            Body::Ball => "A ball on a rigid flat",
            Body::Block => "A block on a rigid ball",
        }
    }

    /// z of the lower boundary.
    pub fn surface(self, x: f64, y: f64) -> f64 {
        match self {
            Body::Ball => -(RADIUS * RADIUS - x * x - y * y).sqrt(),
            Body::Block => 0.0,
        }
    }

    /// The unit cube's image: the ball up to the height of its centre, the block up to its width.
    pub fn map(self, [s, t, w]: [f64; 3]) -> [f64; 3] {
        let (x, y) = (WIDTH * graded(s), WIDTH * graded(t));
        match self {
            Body::Ball => [x, y, self.surface(x, y) * (1.0 - graded(w))],
            Body::Block => [x, y, WIDTH * graded(w)],
        }
    }

    /// n_y, the direction into the obstacle, and g, the distance to it.
    pub fn obstacle(self) -> (Given<[f64; 3], 3>, Given<f64, 3>) {
        match self {
            Body::Ball => (Given::constant([0.0, 0.0, -1.0]), Given::function(|x: &[f64; 3]| x[2] + RADIUS)),
            Body::Block => (
                Given::function(|x: &[f64; 3]| from_centre(x).1.map(|v| -v)),
                Given::function(|x: &[f64; 3]| from_centre(x).0 - RADIUS),
            ),
        }
    }

    /// The obstacle in the plane y = 0, and its name.
    pub fn outline(self) -> (Vec<[f64; 2]>, &'static str) {
        match self {
            Body::Ball => (vec![[0.0, -RADIUS], [WIDTH, -RADIUS]], "flat"),
            Body::Block => {
                let angles = (0..=60).map(|k| f64::from(k) / 60.0 * 0.65);
                (angles.map(|a| [RADIUS * a.sin(), RADIUS * a.cos() - RADIUS]).collect(), "ball")
            }
        }
    }
}

/// The distance to the point (0, 0, −R), and the unit vector away from it.
fn from_centre(x: &[f64; 3]) -> (f64, [f64; 3]) {
    let away = [x[0], x[1], x[2] + RADIUS];
    let length = away.iter().map(|v| v * v).sum::<f64>().sqrt();
    (length, away.map(|v| v / length))
}
