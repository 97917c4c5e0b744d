//! The families of reference files, and the files of each.

use super::ReferenceFile;
use super::format::folder;

/// The families of files: the beginning of the file's name, and of the test that consumes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// The stiffness of linear elasticity.
    Elasticity,
    /// Scalar matrices, a load, norms.
    Poisson,
    /// Energies with their derivatives.
    NeoHookean,
    /// The same, with two invariants.
    MooneyRivlin,
    /// The same, for a scalar field.
    PLaplacian,
    /// Two unknowns.
    Stokes,
    /// A tensor of rank 4.
    AnisotropicElasticity,
    /// Discontinuous elements, terms on interior facets.
    InteriorPenalty,
    /// Jumps of first and second derivatives.
    GhostPenalty,
    /// The direct contact problem and its adjoints.
    Nitsche,
}

impl Family {
    /// Every family.
    pub const ALL: [Family; 10] = [
        Family::Elasticity,
        Family::Poisson,
        Family::NeoHookean,
        Family::MooneyRivlin,
        Family::PLaplacian,
        Family::Stokes,
        Family::AnisotropicElasticity,
        Family::InteriorPenalty,
        Family::GhostPenalty,
        Family::Nitsche,
    ];

    /// The start of its files' names.
    pub fn prefix(self) -> &'static str {
        match self {
            Family::Elasticity => "elasticity",
            Family::Poisson => "poisson",
            Family::NeoHookean => "neo_hookean",
            Family::MooneyRivlin => "mooney_rivlin",
            Family::PLaplacian => "p_laplacian",
            Family::Stokes => "stokes",
            Family::AnisotropicElasticity => "anisotropic_elasticity",
            Family::InteriorPenalty => "interior_penalty",
            Family::GhostPenalty => "ghost_penalty",
            Family::Nitsche => "nitsche",
        }
    }

    /// Its files, read.
    pub fn files(self) -> Vec<ReferenceFile> {
        let mine = |name: &String| name.starts_with(&format!("{}_", self.prefix()));
        names().into_iter().filter(mine).map(|name| ReferenceFile::read(&name)).collect()
    }
}

/// The names of all reference files, without extension, sorted.
pub fn names() -> Vec<String> {
    let entries = std::fs::read_dir(folder()).unwrap_or_else(|error| panic!("tests/scikit_fem: {error}"));
    let paths = entries.map(|entry| entry.unwrap_or_else(|error| panic!("tests/scikit_fem: {error}")).path());
    let mut names: Vec<String> = paths
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .collect();
    names.sort();
    names
}
