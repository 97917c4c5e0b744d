//! The patch test while bodies slide, over the covered surface and over the one that is covered in part; balance of forces and moments.

use forms_contact::laws::mortar_bodies as law;
use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

use crate::exact::{check_tangent, multipliers, nodal, resultants};

pub const LAMBDA: f64 = 200.0 * 0.3 / (1.3 * 0.4);
pub const MU: f64 = 200.0 / 2.6;
/// The stretch of block and layer, which are ½ high.
const STRETCH: f64 = 0.98;

/// Degrees of displacements and multipliers.
const DEGREES: [(usize, usize); 3] = [(1, 1), (2, 1), (2, 2)];

/// The law on a layer that is loaded by the same pressure where the block does not cover it.
#[forms(dimension = 2)]
mod loaded {
    use forms_contact::laws::mortar_bodies::direct;
    pub use forms_contact::laws::mortar_bodies::{GammaN, Omega, Own, Touch, first_piola};

    #[includes(forms_contact::laws::mortar_bodies::Data)]
    pub struct Data {
        pub pressure: Param,
    }
    /// The layer's whole surface.
    #[facets]
    pub struct Surface;
    /// The part of the surface that the block covers.
    #[pairs]
    pub struct Cover;

    pub fn balance(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        g: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        r: Test<Scalar>,
    ) -> Form {
        direct(u, p, g, v, q, r) + integral(Surface, pressure * dot(n, v))
            - integral(Cover(u), pressure * dot(toward, this(v)))
    }
}

/// A layer of length 3 and a block of length 2 on it.
pub fn bodies(shape: CellShape, cells: [usize; 2]) -> Mesh<2> {
    let layer = rectangle([0.0, -0.5], [3.0, 0.0], [cells[0], 2], shape, 1).unwrap();
    let block = rectangle([0.0, 0.0], [2.0, 0.5], [cells[1], 2], shape, 1).unwrap();
    Mesh::of_bodies(&[("layer", &layer), ("block", &block)]).unwrap()
}

/// The displacement with the block moved by (aside, up). The nodes of the interface belong to two bodies: the block's are moved by its cells.
fn moved(space: &Arc<Space<2>>, [aside, up]: [f64; 2]) -> Field<2> {
    let mut values = vec![0.0; space.unknowns()];
    for cell in space.mesh().cell_region("block").unwrap() {
        for node in space.cell_nodes(*cell as usize) {
            values[2 * *node as usize] = aside;
            values[2 * *node as usize + 1] = up;
        }
    }
    Field::from_values(space, values).unwrap()
}

/// The largest errors of stress in the cells and of multipliers that are covered, as parts of the pressure, and Newton's steps.
pub fn errors(
    mesh: &Mesh<2>,
    (degree, of_multipliers): (usize, &Elements),
    pairing: &Pairing,
    offset: f64,
) -> (f64, f64, usize) {
    let pressure = MU * (1.0 / STRETCH - STRETCH) - LAMBDA * STRETCH.ln() / STRETCH;
    let space = Space::vector(mesh, degree).unwrap();
    let own = &pairing.surfaces[0].own;
    let traces = Space::of(mesh, of_multipliers.clone(), Scope::Facets(own.to_owned()), &[]).unwrap();
    let down = 1.0 - STRETCH;
    let mut held = Constraints::new(&space);
    held.fix("layer bottom", |_| [0.0; 2]).unwrap();
    held.fix("block top", |_| [offset, -down]).unwrap();
    for side in ["left", "right"] {
        held.fix_component(&format!("layer {side}"), 0, |_| 0.0).unwrap();
        held.fix_component(&format!("block {side}"), 0, |_| offset).unwrap();
    }
    let data = law::data().lambda(LAMBDA).mu(MU).gamma0(1000.0);
    let regions = loaded::Regions::default()
        .touch(pairing.clone())
        .own(own.as_str())
        .gamma_n("block right")
        .surface("layer top")
        .cover(Pairing::onto("layer top", "block bottom").at(PairQuadrature::Pieces));
    let model = loaded::Model { data: loaded::data_from(data).pressure(pressure), regions };
    let options = NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() };
    let start = nodal(&traces, |_| [0.5 * pressure]);
    let form = model.balance();
    let touching = Field::zero(&traces);
    let above = moved(&space, [offset, -1e-3]);
    let mut problem = Problem::new(&form, [&space, &traces, &traces]).constrained(&held).options(options);
    problem = problem.start([&above, &start, &touching]);
    let solved = problem.solve().unwrap_or_else(|error| panic!("{pairing} {offset}: {error}"));
    let assembler = Assembler::new(mesh);
    let stress = model.first_piola(&solved.fields[0]);
    let stress = assembler.at_quadrature_points(&stress, Entity::Cells, "all", 2).unwrap();
    let off = |value: &Vec<f64>| (value[3] + pressure).abs().max(value[1].abs()) / pressure;
    let worst = stress.values.iter().map(off).fold(0.0, f64::max);
    // Nodes between covered facets have the pressure, those that nothing faces have none.
    let is_covered = |x: &[f64; 2]| own == "block bottom" || (x[0] > offset - 0.4 && x[0] < offset + 2.4);
    let nodes = traces.positions().iter().zip(solved.fields[1].values());
    let off = nodes.map(|(x, p)| (p - if is_covered(x) { pressure } else { 0.0 }).abs() / pressure);
    (worst, off.fold(0.0, f64::max), solved.iterations())
}

pub const OFFSETS: [f64; 7] = [0.0, 0.137, 0.25, 0.401, 0.5, 0.77, 0.93];

#[test]
fn pressure_is_constant_while_bodies_slide() {
    println!(
        "| cells | degrees of u and p | own surface | error of the stress | of the multiplier | steps |"
    );
    for (shape, degrees, cells) in [
        (CellShape::Quadrilateral, [1, 1], [9, 8]),
        (CellShape::Quadrilateral, [2, 1], [6, 5]),
        (CellShape::Quadrilateral, [2, 2], [6, 5]),
        (CellShape::Triangle, [1, 1], [6, 10]),
        (CellShape::Triangle, [2, 2], [9, 4]),
    ] {
        let mesh = bodies(shape, cells);
        let (layer, block) = ("layer top", "block bottom");
        for pairing in [Pairing::onto(block, layer), Pairing::onto(layer, block)] {
            let pairing = pairing.at(PairQuadrature::Pieces);
            let is_covered = pairing.surfaces[0].own == block;
            let elements = Elements::Bernstein(degrees[1]);
            let all = OFFSETS.map(|offset| errors(&mesh, (degrees[0], &elements), &pairing, offset));
            let most = |of: fn(&(f64, f64, usize)) -> f64| all.iter().map(of).fold(0.0, f64::max);
            let [stress, multiplier, steps] = [most(|e| e.0), most(|e| e.1), most(|e| e.2 as f64)];
            println!("| {shape:?} | {degrees:?} | {pairing} | {stress:.1e} | {multiplier:.1e} | {steps} |");
            let tolerance = if degrees[0] == 1 { 1e-12 } else { 1e-11 };
            assert!(stress < tolerance, "{shape:?} {degrees:?} {pairing}: {stress:e}");
            assert!(!is_covered || multiplier < 1e-9, "{shape:?} {degrees:?} {pairing}: {multiplier:e}");
        }
    }
}

/// The block covers a part 10⁻², 10⁻⁴ or 10⁻⁸ of a facet of the layer.
#[test]
fn slivers_of_cover_do_no_harm() {
    for (degree, of_multipliers) in DEGREES {
        let mesh = bodies(CellShape::Quadrilateral, [9, 8]);
        let pairing = Pairing::onto("layer top", "block bottom").at(PairQuadrature::Pieces);
        for part in [1e-2, 1e-4, 1e-8] {
            let (stress, _, steps) = errors(
                &mesh,
                (degree, &Elements::Bernstein(of_multipliers)),
                &pairing,
                1.0 / 3.0 + part / 3.0,
            );
            println!("degree {degree}, {of_multipliers}, {part:e}: {stress:.1e} in {steps} steps");
            assert!(stress < 1e-7, "{degree} {of_multipliers} {part}: {stress:e}");
        }
    }
}

/// Bent plates: forces and moments of any pressure vanish to rounding, as they act along the ray; tangents with moving segments.
#[test]
fn forces_balance_and_tangents_are_exact() {
    let plates = |degree: usize| {
        let lower = structured([7, 1], CellShape::Quadrilateral, degree, |[s, t]: [f64; 2]| {
            [3.0 * s, 0.4 * t - 0.4 + 0.15 * (5.0 * s).sin()]
        });
        let upper = structured([5, 1], CellShape::Quadrilateral, degree, |[s, t]: [f64; 2]| {
            [0.45 + 2.1 * s, 0.02 + 0.4 * t + 0.15 * (0.75 + 3.5 * s).sin()]
        });
        Mesh::of_bodies(&[("lower", &lower.unwrap()), ("upper", &upper.unwrap())]).unwrap()
    };
    for (degree, of_multipliers) in DEGREES {
        let mesh = plates(degree);
        let (form, [at, along]) = bent_plates(&mesh, degree, of_multipliers);
        let (at, along) = (at.each_ref(), along.each_ref());
        let [force, moment] = resultants(&form, at);
        println!("degree {degree}, {of_multipliers}: {force:.1e} {moment:.1e}");
        assert!(force < 1e-13 && moment < 1e-13, "{degree} {of_multipliers}: {force:e} {moment:e}");
        check_tangent(&form, at, along, &format!("{degree} {of_multipliers}"));
    }
}

/// Flat surfaces, each second node of the upper one above a node of the lower one: the number of segments changes to one side of the displacement.
#[test]
fn tangents_are_exact_where_segments_change() {
    for (degree, of_multipliers) in DEGREES {
        let lower = rectangle([0.0, -0.4], [3.0, 0.0], [6, 1], CellShape::Quadrilateral, 1).unwrap();
        let upper = rectangle([0.5, 0.02], [2.0, 0.42], [6, 1], CellShape::Quadrilateral, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)]).unwrap();
        let (form, [[u, p, g], along]) = bent_plates(&mesh, degree, of_multipliers);
        let u = Field::zero(u.space());
        check_tangent(&form, [&u, &p, &g], along.each_ref(), &format!("{degree} {of_multipliers}"));
    }
}

type State = [Field<2>; 3];

/// The law between two plates, with a bent state and a direction.
fn bent_plates(mesh: &Mesh<2>, degree: usize, of_multipliers: usize) -> (Form<2>, [State; 2]) {
    let space = Space::vector(mesh, degree).unwrap();
    let pairing = Pairing::onto("upper bottom", "lower top").at(PairQuadrature::Pieces);
    let traces = multipliers(mesh, "upper bottom", of_multipliers, &[]);
    let data = law::data().lambda(1.0).mu(1.0).gamma0(30.0);
    let regions = law::Regions::default().touch(pairing).own("upper bottom").gamma_n("upper top");
    let form = law::Model { data, regions }.direct();
    let bent = |phase: f64| {
        let value = |x: &[f64; 2]| {
            let along = 0.05 * (2.0 * x[0] + phase).sin() + 0.03 * phase;
            [along, 0.03 * (3.0 * x[0] + x[1] + 2.0 * phase).cos()]
        };
        Field::interpolate(&space, value).unwrap()
    };
    let pressures = |phase: f64| Field::interpolate(&traces, |x| 2.0 + (4.0 * x[0] + phase).sin()).unwrap();
    let state = |[u, p, g]: [f64; 3]| [bent(u), pressures(p), pressures(g)];
    (form, [state([0.3, 0.0, 1.7]), state([1.1, 0.7, 2.9])])
}

/// Surfaces of tetrahedra and hexahedra that do not match: forces vanish to rounding, and tangents have the motion of the polygons.
#[test]
fn tangents_are_exact_in_space() {
    for (shape, degree) in
        [(CellShape::Tetrahedron, 1), (CellShape::Tetrahedron, 2), (CellShape::Hexahedron, 2)]
    {
        let body =
            |from: [f64; 3], to: [f64; 3], cells: [usize; 3]| cuboid(from, to, cells, shape, 1).unwrap();
        let slab = body([0.0, 0.0, -0.4], [1.5, 1.2, 0.0], [3, 2, 1]);
        let block = body([0.2, 0.1, 0.0], [1.1, 0.9, 0.4], [2, 2, 1]);
        let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap();
        let (space, own) = (Space::vector(&mesh, degree).unwrap(), "block bottom");
        let traces = multipliers(&mesh, own, degree, &[]);
        let regions = law::Regions::default()
            .touch(Pairing::onto(own, "slab top").at(PairQuadrature::Pieces))
            .own(own)
            .gamma_n("block top");
        let form = law::Model { data: law::data().lambda(1.0).mu(1.0).gamma0(30.0), regions }.direct();
        let bent = |phase: f64| {
            let value = |x: &[f64; 3]| -> [f64; 3] {
                let up = 0.02 * (x[0] * x[1] + phase).sin();
                [0.02 * (x[1] + phase).sin(), 0.02 * (2.0 * x[0] + phase).cos(), up]
            };
            Field::interpolate(&space, value).unwrap()
        };
        let nodal = |phase: f64| {
            Field::interpolate(&traces, |x: &[f64; 3]| 2.0 + (4.0 * x[0] + x[1] + phase).sin()).unwrap()
        };
        let at = [&bent(0.3), &nodal(0.0), &nodal(1.7)];
        let [force, _] = resultants(&form, at);
        println!("{shape:?} {degree}: {force:.1e}");
        assert!(force < 1e-13, "{shape:?} {degree}: {force:e}");
        check_tangent(&form, at, [&bent(1.1), &nodal(0.7), &nodal(2.9)], &format!("{shape:?} {degree}"));
    }
}
