//! New meshes for the present shape, and the walls that stay.

use std::f64::consts::TAU;

use forms_contact::hollow_cylinder::{CONTACT, CONTACT_CELLS, INNER_RADIUS, OUTER_RADIUS};
use forms_fem::mesh::{Mesh, Remeshing, Sizes, Surface, onto_sphere};
use forms_fem::shape_optimisation::{Clearance, Failure};

use crate::cantilever;
use crate::options::{Case, Options};

/// Edges of the ring's cells where it is thick, for one cell per side of a sector \[cm\].
const RING_SIZE: f64 = 4.4;
/// Edges of new cells over the edge of an old one.
const CANTILEVER_SIZE: f64 = 0.9;
/// The smallest edges over the wall that stays: two across, and some more where the wall is curved.
const SMALLEST: f64 = 0.3;
/// The criterion and the volume from mesh to mesh.
pub const TOLERANCE: f64 = 2e-3;

/// A new mesh of triangles, with cells of so many times the sizes.
pub fn remeshed(options: &Options, mesh: &Mesh<2>, factor: f64) -> Result<Mesh<2>, Failure> {
    let per_side = options.cells_per_side() as f64;
    if options.case == Case::Cantilever {
        let largest = CANTILEVER_SIZE * cantilever::SIZE[0] / (10.0 * per_side);
        let sizes = Sizes::between(0.2 * largest, largest).scaled(factor);
        return Ok(Remeshing::new(sizes).remesh(mesh)?);
    }
    let largest = RING_SIZE / per_side;
    let sizes = Sizes::between((SMALLEST * options.wall()).min(largest), largest).scaled(factor);
    let (inner, outer) = (onto_sphere([0.0; 2], INNER_RADIUS), onto_sphere([0.0; 2], OUTER_RADIUS));
    let surfaces: [Surface<2>; 2] = [("inner", &inner), ("outer", &outer)];
    let remeshing = Remeshing::new(sizes)
        .onto(&surfaces)
        .with_cells_of_facets(&[(CONTACT_CELLS, CONTACT)])
        .in_sectors([0.0; 2], options.holes, 0.0);
    Ok(remeshing.remesh(mesh)?)
}

/// The clearance of a place: from the walls at the ring's circles and from half a wall at the sides of its sector, where the
/// next hole has the other half; from the least height of the cantilever.
pub fn clearance(options: &Options, x: &[f64; 2]) -> Clearance<2> {
    let wall = options.wall();
    if options.case == Case::Cantilever {
        return Clearance { distance: x[1] - wall, away: [0.0, 1.0] };
    }
    let radius = x[0].hypot(x[1]);
    let out = x.map(|x| x / radius);
    let sector = TAU / options.holes as f64;
    let from_side = x[1].atan2(x[0]).rem_euclid(sector);
    // The line through the centre that is nearer, and the way from it into the sector.
    let (angle, sign) = if from_side < 0.5 * sector { (from_side, 1.0) } else { (sector - from_side, -1.0) };
    let (sine, cosine) = (x[1].atan2(x[0]) - sign * angle).sin_cos();
    let clearances = [
        Clearance { distance: radius - INNER_RADIUS - wall, away: out },
        Clearance { distance: OUTER_RADIUS - wall - radius, away: out.map(|x| -x) },
        Clearance { distance: radius * angle.sin() - 0.5 * wall, away: [-sign * sine, sign * cosine] },
    ];
    let [first, ..] = clearances;
    clearances
        .into_iter()
        .fold(first, |least, other| if other.distance < least.distance { other } else { least })
}

/// The least wall that a shape has \[cm\], at the nodes of its moving boundary.
pub fn least_wall(options: &Options, mesh: &Mesh<2>, moving: &str) -> Result<f64, Failure> {
    let mut least = f64::INFINITY;
    for facet in mesh.facet_region(moving)? {
        let cell = facet.cell as usize;
        for local in mesh.cell_element(cell).facet_nodes(facet.local.into()) {
            let x = mesh.nodes()[mesh.cell(cell)[local] as usize];
            least = least.min(clearance(options, &x).distance);
        }
    }
    Ok(options.wall() + least)
}
