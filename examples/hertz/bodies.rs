//! The two bodies: as the command line names them, and what pictures show of them.

use clap::ValueEnum;
use forms_contact::hertz::{Body, QUARTER_WIDTH, RADIUS};

/// The pair of bodies.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Contact {
    /// A ball, with its centre at the origin, on a rigid flat
    Ball,
    /// A block on a rigid ball around (0, 0, −R)
    Block,
}

impl Contact {
    /// The body.
    pub fn body(self) -> Body {
        match self {
            Contact::Ball => Body::Ball,
            Contact::Block => Body::Block,
        }
    }

    /// The name of its pictures.
    pub fn name(self) -> &'static str {
        match self {
            Contact::Ball => "hertz_ball",
            Contact::Block => "hertz_block",
        }
    }

    /// Name of the pictures.
    pub fn title(self) -> &'static str {
        match self {
            Contact::Ball => "A ball on a rigid flat",
            Contact::Block => "A block on a rigid ball",
        }
    }

    /// The obstacle in the plane y = 0, and its name.
    pub fn outline(self) -> (Vec<[f64; 2]>, &'static str) {
        match self {
            Contact::Ball => (vec![[0.0, -RADIUS], [QUARTER_WIDTH, -RADIUS]], "flat"),
            Contact::Block => {
                let angles = (0..=60).map(|k| f64::from(k) / 60.0 * 0.65);
                (angles.map(|a| [RADIUS * a.sin(), RADIUS * a.cos() - RADIUS]).collect(), "ball")
            }
        }
    }
}
