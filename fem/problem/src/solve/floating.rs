//! Bodies and tools that move freely where a matrix is singular, in words.

use std::fmt;

/// The body or tool that moves freely at an unknown that a singular matrix does not determine, as far as it is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Floating {
    /// Nothing that is a rigid motion.
    Nothing,
    /// The whole of the mesh.
    Whole {
        /// The rigid motions that nothing resists, in words: "translation along x", "rotation about (0, 0)".
        motions: Vec<String>,
    },
    /// One of several bodies, the others at rest.
    Body {
        /// The name of its cells, where a region has no other ones.
        name: Option<String>,
        /// Its rigid motions that nothing resists, in words.
        motions: Vec<String>,
    },
    /// A rigid surface, on the cell that carries it.
    Tool {
        /// Its name.
        name: String,
        /// Whether the unknown is what displaces it.
        displaces: bool,
    },
}

impl fmt::Display for Floating {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Floating::Nothing => f.write_str(
                "a boundary condition or a pinned value is missing, or the spaces do not fit each other",
            ),
            Floating::Whole { motions } => write!(f, "the body can move rigidly: {}", motions.join(", ")),
            Floating::Body { name, motions } => {
                match name {
                    Some(name) => write!(f, "the body \"{name}\"")?,
                    None => f.write_str("the body there")?,
                }
                write!(
                    f,
                    " can move rigidly: {}. Hold it by a condition or by weak springs; a body that only contact holds \
                     must begin in contact (`Assembler::first_touch`)",
                    motions.join(", ")
                )
            }
            Floating::Tool { name, displaces: true } => write!(
                f,
                "it belongs to the rigid surface \"{name}\", whose motion is not given: prescribe it \
                 (`Constraints::move_rigidly`), or let forces decide on it (`Constraints::rigid_body`)"
            ),
            Floating::Tool { name, displaces: false } => write!(
                f,
                "it belongs to the rigid surface \"{name}\", where no integral reads this unknown: prescribe it there, as by \
                 `constraints.fix(\"{name}\", |_| 0.0)`"
            ),
        }
    }
}
