//! Names of the basket's kernels in words, for tables and charts.

/// The parts of a kernel's name that begin it, longer ones first, with their words.
const PHYSICS: [(&str, &str); 8] = [
    ("nitsche_nh_tangent", "Nitsche with neo-Hooke, tangent"),
    ("nitsche_residual", "Nitsche, residual"),
    ("nitsche_tangent", "Nitsche, tangent"),
    ("neohooke_residual", "neo-Hooke, residual"),
    ("neohooke_tangent", "neo-Hooke, tangent"),
    ("elasticity", "elasticity"),
    ("poisson", "Poisson"),
    ("mass", "mass of vectors"),
];
const CELLS: [(&str, &str); 4] =
    [("tri", "triangles"), ("tet", "tetrahedra"), ("quad", "quadrilaterals"), ("hex", "hexahedra")];

/// The name in words: `elasticity_hex_Q2_g2` is "elasticity, hexahedra of degree 2, curved". A name of another form is
/// returned as it is.
pub fn plain_name(form: &str) -> String {
    in_words(form).unwrap_or_else(|| form.to_owned())
}

fn in_words(form: &str) -> Option<String> {
    let (physics, rest) = PHYSICS.iter().find_map(|(name, words)| Some((words, form.strip_prefix(name)?)))?;
    let mut parts = rest.strip_prefix('_')?.split('_');
    let cell = parts.next()?;
    let (_, cell) = CELLS.iter().find(|(name, _)| *name == cell)?;
    let degree = parts.next()?.trim_end_matches("vec").strip_prefix(['P', 'Q'])?;
    let mut words = format!("{physics}, {cell} of degree {degree}");
    for part in parts {
        match part.split_at_checked(1)? {
            ("q", degree) => words += &format!(", rule of degree {degree}"),
            ("g", "1") => (),
            ("g", "2") => words += ", curved",
            _ => return None,
        }
    }
    Some(words)
}
