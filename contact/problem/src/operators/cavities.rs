//! Forms of closed cavities.

use forms_fem::forms;

/// The volume that a wall encloses, after any displacement. Nothing is read from the module's data.
#[forms]
pub mod cavity {
    /// −(x + u)·cof(F) n/D: its integral over the cavity's whole wall is the enclosed volume, in two dimensions the area. n points out of the
    /// body and into the cavity.
    ///
    /// Where planes of symmetry cut the cavity, the wall is its part of one side and all of these planes pass through the origin. Reactions of
    /// such a plane then hold a part of the filling's force.
    pub fn enclosed(u: Vector) -> Scalar {
        -dot(cof(I + grad(u)) * n, x + u) / D
    }

    /// `enclosed` of the undeformed wall.
    pub fn enclosed_at_rest() -> Scalar {
        -dot(n, x) / D
    }
}
