//! The threshold of γ₀ from the material of isotropic bodies: for laws between bodies, at finite strain, and in motion, which have no forms of linear
//! elasticity on a flat obstacle.

use forms_fem::contract::{Datum, Region};
use forms_fem::forms;
use forms_fem::prelude::*;

use crate::threshold::{Threshold, largest_eigenvalues, on_cells_of_facets};

/// Linear elasticity and the products of its tractions.
#[forms]
pub mod isotropic {
    use crate::operators::linear_elastic::stress;

    /// The material, and the divisor of products of tractions.
    pub struct Data {
        /// λ \[stress\].
        pub lambda: Given<Scalar>,
        /// μ \[stress\].
        pub mu: Given<Scalar>,
        /// The divisor of products of tractions \[stress\]; 1 for the products themselves.
        pub scale: Given<Scalar>,
        /// 1 where the whole traction counts, 0 where its normal part does.
        pub tangential: Param,
    }

    /// The cells.
    #[cells]
    pub struct Omega;
    /// A surface that may touch.
    #[facets]
    pub struct Surface;

    /// ∫ σ(u):ε(v).
    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }

    /// ∫ σ(u)n·σ(v)n/s, or ∫ σ_n(u) σ_n(v)/s.
    pub fn product(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let of_whole = dot(stress(u) * n, stress(v) * n);
        let of_normal = dot(stress(u) * n, n) * dot(stress(v) * n, n);
        integral(Surface, (tangential * of_whole + (1 - tangential) * of_normal) / scale)
    }
}

/// The part of the traction that a law's contact term takes from the stress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Traction {
    /// σ_n: contact without friction.
    Normal,
    /// σn: contact with friction.
    Whole,
}

/// Surfaces, stresses and parameters that the threshold of γ₀ depends on.
#[derive(Clone, Debug)]
pub struct NitscheContact<'a, const D: usize> {
    /// Names of the surfaces that are integrated over. A rigid one has no stress, and is left out.
    pub surfaces: Vec<&'a str>,
    /// λ \[stress\].
    pub lambda: Given<f64, D>,
    /// μ \[stress\].
    pub mu: Given<f64, D>,
    /// γ₀ \[stress\].
    pub gamma0: Given<f64, D>,
    /// θ.
    pub theta: f64,
    /// Part of each surface's integral: ½ where both of two surfaces are integrated over.
    pub share: f64,
    /// The part of the traction.
    pub traction: Traction,
}

impl<'a, const D: usize> NitscheContact<'a, D> {
    /// The data of a surface on rigid obstacles, with friction and θ = 0.
    pub fn of_surface(surface: &'a str, [lambda, mu, gamma0]: [impl Datum<f64, D>; 3]) -> Self {
        NitscheContact {
            surfaces: vec![surface],
            lambda: lambda.given(),
            mu: mu.given(),
            gamma0: gamma0.given(),
            theta: 0.0,
            share: 1.0,
            traction: Traction::Whole,
        }
    }

    /// The data of the surfaces of a region's contact pairs that are integrated over, with friction and θ = 0.
    pub fn of_pairs(pairs: &'a Region, [lambda, mu, gamma0]: [&Given<f64, D>; 3], share: f64) -> Self {
        let facings = pairs.pairing.iter().flat_map(|pairing| &pairing.surfaces);
        let mut surfaces: Vec<&str> = facings.map(|facing| facing.own.as_str()).collect();
        surfaces.sort_unstable();
        surfaces.dedup();
        NitscheContact {
            surfaces,
            lambda: lambda.clone(),
            mu: mu.clone(),
            gamma0: gamma0.clone(),
            theta: 0.0,
            share,
            traction: Traction::Whole,
        }
    }
}

/// The threshold of γ₀ for displacements in a space, with the stiffness of the undeformed body: γ₀ ≥ s (1+θ)²/4 h_T λ_T as in
/// [`threshold`](crate::threshold), times the share of each surface's integral. The neo-Hookean and the St Venant–Kirchhoff material
/// begin with Hooke's law; what compression adds to their stiffness is not looked at.
///
/// The threshold's γ₀, where it varies, is that of its worst cell, the one with the least γ₀ compared with what it asks for.
///
/// # Errors
/// Data that do not fit.
pub fn material_threshold<const D: usize>(
    assembler: &Assembler<D>,
    space: &Arc<Space<D>>,
    contact: &NitscheContact<'_, D>,
) -> Result<Threshold, AssemblyError>
where
    Dim: Dimension<D>,
{
    let theta = contact.theta;
    let factor = contact.share * (1.0 + theta).powi(2) / 4.0;
    let mesh = space.mesh();
    let is_tool = |name: &str| mesh.rigid_surface_names().any(|tool| tool == name);
    let surfaces: Vec<&str> = contact.surfaces.iter().copied().filter(|name| !is_tool(name)).collect();
    let data = |scale: Given<f64, D>| {
        isotropic::data()
            .lambda(contact.lambda.clone())
            .mu(contact.mu.clone())
            .scale(scale)
            .tangential(if contact.traction == Traction::Whole { 1.0 } else { 0.0 })
    };
    let (of_one, of_gamma0) = (data(Given::constant(1.0)), data(contact.gamma0.clone()));
    let elasticity = isotropic::Model::new(of_one.clone()).elasticity();
    let assembler = on_cells_of_facets(assembler, space, elasticity.name(), &surfaces)?;
    let zero = Field::zero(space);
    let largest = |data: &isotropic::Data<D>| -> Result<Vec<(u32, f64)>, AssemblyError> {
        let energies = assembler.element_matrices(&elasticity, &[&zero], &[space])?;
        let mut products = vec![];
        for surface in &surfaces {
            let product = isotropic::product(data, &isotropic::Surface::on(*surface));
            products.extend(assembler.element_matrices(&product, &[&zero], &[space])?);
        }
        let found = largest_eigenvalues(energies, products, assembler.threads());
        Ok(found.into_iter().map(|(cell, largest)| (cell, largest.unwrap_or(f64::INFINITY))).collect())
    };
    let size = |cell: u32| factor * mesh.diameter(cell as usize);
    let parts = largest(&of_gamma0)?;
    let worst = parts.iter().map(|(cell, largest)| (*cell, size(*cell) * largest));
    let Some((worst, part)) = worst.max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Ok(Threshold { required: 0.0, gamma0: f64::INFINITY, theta, worst: None });
    };
    let products = largest(&of_one)?;
    let required =
        products.iter().find(|(cell, _)| *cell == worst).map_or(f64::INFINITY, |(_, largest)| *largest);
    let required = size(worst) * required;
    let worst = Some(mesh.cell_centre(worst as usize).to_vec());
    Ok(Threshold { required, gamma0: required / part, theta, worst })
}

/// The function `threshold` that a law names by `threshold_by`, from its material: the members λ (or K, which asks for a little more), μ and γ₀ of
/// its data, on the facets of a region or on the surfaces of pairs.
macro_rules! threshold_of_material {
    (@ $name:ident, $module:ident, |$law:ident| $contact:expr) => {
        fn $name<const D: usize>(
            $law: &$module::Model<D>,
            assembler: &forms_fem::prelude::Assembler<D>,
            space: &forms_fem::prelude::Arc<forms_fem::prelude::Space<D>>,
        ) -> Result<$crate::threshold::Threshold, forms_fem::prelude::AssemblyError>
        where
            forms_fem::prelude::Dim: forms_fem::prelude::Dimension<D>,
        {
            $crate::material_threshold::material_threshold(assembler, space, &$contact)
        }
    };
    ($name:ident, $module:ident, facets: $region:ident, $lambda:ident) => {
        $crate::material_threshold::threshold_of_material!(@ $name, $module, |law| {
            let materials = [law.data.$lambda, law.data.mu, law.data.gamma0];
            $crate::material_threshold::NitscheContact::of_surface(&law.regions.$region.0.name, materials)
        });
    };
    ($name:ident, $module:ident, pairs: $region:ident, $lambda:ident $(, theta: $theta:ident)? $(, traction: $traction:ident)?) => {
        $crate::material_threshold::threshold_of_material!(@ $name, $module, |law| {
            let materials = [&law.data.$lambda, &law.data.mu, &law.data.gamma0];
            $crate::material_threshold::NitscheContact {
                $(theta: law.data.$theta,)?
                $(traction: $crate::material_threshold::Traction::$traction,)?
                ..$crate::material_threshold::NitscheContact::of_pairs(&law.regions.$region.0, materials, law.data.share)
            }
        });
    };
}
pub(crate) use threshold_of_material;
