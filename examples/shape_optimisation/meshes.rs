//! New meshes for the present shape, and the walls that stay.

use std::f64::consts::{FRAC_PI_6, TAU};

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
/// The angle that stays between the cantilever's top and its ends: 30°.
const LEAST_ANGLE: f64 = FRAC_PI_6;
/// The change of criterion (relative) and volume from mesh to mesh, at most.
pub const TOLERANCE: f64 = 2e-3;

/// A new mesh of triangles, with cells of the given multiple of the sizes.
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
/// next hole has the other half; from the cantilever's least height and
/// least angles.
pub fn clearance(options: &Options, x: &[f64; 2]) -> Clearance<2> {
    let wall = options.wall();
    if options.case == Case::Cantilever {
        let [length, height] = cantilever::SIZE;
        let (sine, cosine) = LEAST_ANGLE.sin_cos();
        // From the rays below the ends of the top: cells in a cusp would be as thin as it is.
        let left = cosine * x[0] - sine * (height - x[1]);
        let right = cosine * (length - x[0]) - sine * (height - x[1]);
        return least([
            Clearance { distance: x[1] - wall, away: [0.0, 1.0] },
            Clearance { distance: left, away: [cosine, sine] },
            Clearance { distance: right, away: [-cosine, sine] },
        ]);
    }
    let radius = x[0].hypot(x[1]);
    let out = x.map(|x| x / radius);
    let sector = TAU / options.holes as f64;
    let from_side = x[1].atan2(x[0]).rem_euclid(sector);
    // The line through the centre that is nearer, and the way from it into the sector.
    let (angle, sign) = if from_side < 0.5 * sector { (from_side, 1.0) } else { (sector - from_side, -1.0) };
    let (sine, cosine) = (x[1].atan2(x[0]) - sign * angle).sin_cos();
    least([
        Clearance { distance: radius - INNER_RADIUS - wall, away: out },
        Clearance { distance: OUTER_RADIUS - wall - radius, away: out.map(|x| -x) },
        Clearance { distance: radius * angle.sin() - 0.5 * wall, away: [-sign * sine, sign * cosine] },
    ])
}

fn least(clearances: [Clearance<2>; 3]) -> Clearance<2> {
    let [first, second, third] = clearances;
    let nearer = |a: Clearance<2>, b: Clearance<2>| if b.distance < a.distance { b } else { a };
    nearer(nearer(first, second), third)
}

/// The least wall that a shape has \[cm\], at the nodes of its moving boundary: between holes and circles, or the least height of
/// the cantilever.
pub fn least_wall(options: &Options, mesh: &Mesh<2>, moving: &str) -> Result<f64, Failure> {
    let mut least = f64::INFINITY;
    for facet in mesh.facet_region(moving)? {
        let cell = facet.cell as usize;
        for local in mesh.cell_element(cell).facet_nodes(facet.local.into()) {
            let x = mesh.nodes()[mesh.cell(cell)[local] as usize];
            least = least.min(match options.case {
                Case::Cantilever => x[1],
                _ => options.wall() + clearance(options, &x).distance,
            });
        }
    }
    Ok(least)
}
