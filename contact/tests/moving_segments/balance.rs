//! Balance of forces and moments, and covered lengths, on moving segments of bent and kinked surfaces in any position; the same bits on
//! any number of threads.

use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;
use forms_fem::threads::Threads;

use crate::rings::rings;
use crate::shape::pressed;
use crate::tangent::{hairpin, wave};

#[forms]
pub mod springs {
    pub struct Data {
        gamma: Param,
        #[default(0.5)]
        share: Param,
    }
    #[pairs]
    pub struct Touch;

    pub fn forces(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(u), share * gamma * gap * dot(toward, jump(v)))
    }
    fn of_means(u: Vector, v: Vector) -> Scalar {
        share * gamma * mean(gap) * mean(dot(toward, jump(v)))
    }
    pub fn forces_of_facets(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        means(Touch(u), 0, of_means(u, v))
    }
    pub fn forces_of_vertices(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        means(Touch(u), 1, of_means(u, v))
    }
    /// The energy of springs at points.
    pub fn energy(u: Unknown<Vector>) -> Energy {
        integral(Touch(u), share * gamma / 2 * sqr(gap))
    }
    /// Its gradient at held points.
    pub fn gradient(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(energy(u), u, v)
    }
    fn stored(u: Vector) -> Energy {
        means(Touch(u), 0, gamma / 2 * sqr(mean(gap)))
    }
    /// Forces along the change of the mean gaps.
    pub fn potential_forces(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(stored(u), u, v)
    }
    pub fn covered(u: State<Vector>) -> Functional {
        integral(Touch(u), 1)
    }
    pub fn moment(u: State<Vector>) -> Functional {
        integral(Touch(u), this(dot(x, x)))
    }
}

/// A bent plate below another one, with these numbers of cells and a geometry of this degree.
pub fn plates(shape: CellShape, geometry: usize, cells: [usize; 2]) -> Mesh<2> {
    let lower = structured([cells[0], 1], shape, geometry, |[s, t]: [f64; 2]| {
        [3.0 * s, 0.4 * t - 0.4 + 0.15 * (5.0 * s).sin()]
    });
    let upper = structured([cells[1], 1], shape, geometry, |[s, t]: [f64; 2]| {
        [0.45 + 2.1 * s, 0.02 + 0.4 * t + 0.15 * (0.75 + 3.5 * s).sin()]
    });
    Mesh::of_bodies(&[("lower", &lower.unwrap()), ("upper", &upper.unwrap())]).unwrap()
}

pub fn bent(space: &Arc<Space<2>>, phase: f64) -> Field<2> {
    Field::interpolate(space, |x| {
        [0.05 * (2.0 * x[0] + phase).sin() + 0.03 * phase, 0.03 * (3.0 * x[0] + x[1] + 2.0 * phase).cos()]
    })
    .unwrap()
}

pub fn model<const D: usize>(pairing: &Pairing) -> springs::Model<D> {
    let regions = springs::Regions::default().touch(pairing.clone().at(PairQuadrature::Pieces));
    springs::Model { data: springs::data().gamma(7.0), regions }
}

/// Springs at points and with means.
pub fn forms<const D: usize>(pairing: &Pairing) -> [Form<D>; 3]
where
    Dim: Dimension<D>,
{
    let model = model::<D>(pairing);
    [model.forces(), model.forces_of_facets(), model.forces_of_vertices()]
}

/// The largest of the components of the sum of the forces and of their moment about the origin, and the sum of the forces' sizes.
fn resultants(form: &Form<2>, u: &Field<2>) -> (f64, f64) {
    let space = u.space();
    let places = Field::interpolate(space, |x| *x).unwrap();
    let forces = Assembler::new(space.mesh()).residual(form, &[u], &[space]).unwrap();
    let (mut sum, mut moment, mut size) = ([0.0; 2], 0.0, 0.0);
    for (node, f) in forces.chunks_exact(2).enumerate() {
        let at = |k: usize| places.values()[2 * node + k] + u.values()[2 * node + k];
        sum = [sum[0] + f[0], sum[1] + f[1]];
        moment += at(0) * f[1] - at(1) * f[0];
        size += f[0].abs() + f[1].abs();
    }
    (sum.into_iter().chain([moment]).fold(0.0, |most: f64, value| most.max(value.abs())), size)
}

/// Forces and moments about the origin vanish to rounding, whatever the cut, on kinked and on curved surfaces.
#[test]
fn forces_and_moments_balance() {
    let (lower, upper) = ("lower top", "upper bottom");
    for (shape, geometry, degree) in [
        (CellShape::Quadrilateral, 1, 1),
        (CellShape::Quadrilateral, 1, 2),
        (CellShape::Triangle, 2, 2),
        (CellShape::Quadrilateral, 2, 2),
    ] {
        let mesh = plates(shape, geometry, [7, 9]);
        let space = Space::vector(&mesh, degree).unwrap();
        for pairing in
            [Pairing::between(lower, upper), Pairing::onto(lower, upper), Pairing::onto(upper, lower)]
        {
            let cases =
                [0.0, 1.9, 3.1].into_iter().flat_map(|phase| forms(&pairing).map(|form| (phase, form)));
            for (phase, form) in cases {
                let (off, size) = resultants(&form, &bent(&space, phase));
                assert!(size > 0.1 && off < 1e-13 * size, "{shape:?} {pairing} {phase}: {off:e} of {size}");
            }
        }
    }
}

/// Rings whose polygons see each other from both sides, also with all nodes of one at nodes of the other, and a hairpin whose arms face each other.
#[test]
fn forces_and_moments_of_rings_and_hairpins_balance() {
    for degree in [1, 2] {
        for (cells, turn) in [([32, 44], 0.21), ([32, 32], 0.0), ([16, 32], 0.0)] {
            let mesh = rings(degree, cells, turn);
            let space = Space::vector(&mesh, degree).unwrap();
            for (phase, aside) in [(0.4, [0.03, -0.02]), (2.1, [0.0, 0.02]), (2.9, [-0.01, 0.04])] {
                let u = pressed(wave(&space, 0.02, phase), "inner", aside);
                for form in forms(&Pairing::between("inner rim", "outer hole")) {
                    let (off, size) = resultants(&form, &u);
                    let name = format!("degree {degree}, {cells:?}");
                    assert!(size > 0.1 && off < 1e-13 * size, "{name}: {off:e} of {size}");
                }
            }
        }
        let pin = hairpin();
        let space = Space::vector(&pin, degree).unwrap();
        for u in [Field::zero(&space), wave(&space, 0.02, 0.4), wave(&space, 0.03, 2.1)] {
            for form in forms(&Pairing::within("top").within_reach(0.5)) {
                let (off, size) = resultants(&form, &u);
                assert!(size > 0.1 && off < 1e-13 * size, "degree {degree}: {off:e} of {size}");
            }
        }
    }
}

/// The weights add up to what is covered, with ends inside of facets: of a flat layer under a block that is moved along it.
#[test]
fn weights_add_up_to_what_is_covered() {
    for (shape, degree) in [(CellShape::Quadrilateral, 1), (CellShape::Triangle, 2)] {
        let layer = rectangle([0.0, -1.0], [3.0, 0.0], [7, 1], shape, 1).unwrap();
        let block = rectangle([0.2, 0.0], [1.5, 1.0], [3, 1], shape, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("layer", &layer), ("block", &block)]).unwrap();
        let space = Space::vector(&mesh, degree).unwrap();
        let block = mesh.cell_region("block").unwrap();
        let pairing = Pairing::onto("layer top", "block bottom");
        let law = model(&pairing);
        let assembler = Assembler::new(&mesh);
        for step in 0..25 {
            let aside = 0.06 * f64::from(step);
            let mut values = vec![0.0; space.unknowns()];
            for node in block.iter().flat_map(|cell| space.cell_nodes(*cell as usize)) {
                values[2 * *node as usize] = aside;
            }
            let u = Field::from_values(&space, values).unwrap();
            let covered = assembler.functional(&law.covered(&u)).unwrap();
            assert!((covered - 1.3).abs() < 4e-15, "{shape:?} {aside}: {covered}");
            let ends = [0.2 + aside, 1.5 + aside];
            let exact = (ends[1].powi(3) - ends[0].powi(3)) / 3.0;
            let second = assembler.functional(&law.moment(&u)).unwrap();
            assert!((second - exact).abs() < 2e-14, "{shape:?} {aside}: {second} is not {exact}");
            let report = assembler.pairs_at(&pairing.clone().at(PairQuadrature::Pieces), 4, &u).unwrap();
            assert!((report.paired_measure - 1.3).abs() < 4e-15 && (report.measure - 3.0).abs() < 1e-14);
            assert!(report.segments >= 4 && report.dropped_parts >= 2 && report.open == 0, "{report:?}");
        }
    }
}

#[test]
fn bits_do_not_depend_on_threads_or_on_what_was_found_before() {
    let mesh = plates(CellShape::Quadrilateral, 2, [300, 371]);
    let space = Space::vector(&mesh, 2).unwrap();
    let forms = forms(&Pairing::between("lower top", "upper bottom"));
    let kept: Vec<_> =
        [1, 2, 3, 7].map(|threads| Assembler::new(&mesh).with_threads(Threads::new(threads))).into();
    for phase in [0.3, 0.31] {
        let u = bent(&space, phase);
        for form in &forms {
            let fresh = Assembler::new(&mesh).residual(form, &[&u], &[&space]).unwrap();
            let known = kept[0].tangent(form, &[&u], &[&space]).unwrap();
            for assembler in &kept {
                assert!(assembler.residual(form, &[&u], &[&space]).unwrap() == fresh);
                let tangent = assembler.tangent(form, &[&u], &[&space]).unwrap();
                assert!(tangent.values() == known.values());
            }
        }
    }
}
