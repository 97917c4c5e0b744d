//! Lists of candidates that are kept from one displacement to the next: pairs, and all that is assembled on them, are those of a
//! search that knows nothing of an earlier one, to the last bit.

use forms_fem::pairs::Approach;
use forms_fem::prelude::*;

use crate::sliding_pairs::boxes;

#[forms]
mod gaps {
    #[pairs]
    pub struct Touch;
    /// It reads all that a pair is: both points, the gap, the direction.
    pub fn opening(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(u), gap * dot(toward, jump(v)))
    }
}

/// A path of displacements: many small steps, now and then a long one, some of them rotations.
fn path<const D: usize>(space: &Arc<Space<D>>, steps: usize) -> Vec<Field<D>> {
    let mut state = 17_u64;
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
    };
    let (mut drift, mut turn) = ([0.0; D], 0.0_f64);
    let mut displacements = Vec::new();
    for step in 0..steps {
        let size = if step % 13 == 12 { 0.3 } else { 0.02 };
        for (axis, drift) in drift.iter_mut().enumerate() {
            *drift += if axis + 1 == D { 0.1 * size * random() } else { size * random() };
        }
        turn += 0.2 * size * random();
        let bend: [f64; D] = std::array::from_fn(|_| 0.02 * random());
        let displaced = Field::interpolate(space, |x: &[f64; D]| -> [f64; D] {
            let upper = f64::from(u8::from(x[D - 1] > 1.01));
            let (sine, cosine) = (turn * upper).sin_cos();
            let arm = [x[0] - 0.5, x[D - 1] - 1.5];
            let turned = [cosine * arm[0] - sine * arm[1] - arm[0], sine * arm[0] + cosine * arm[1] - arm[1]];
            std::array::from_fn(|axis| {
                let rotation = if axis == 0 {
                    turned[0]
                } else if axis + 1 == D {
                    turned[1]
                } else {
                    0.0
                };
                upper * drift[axis] + rotation + bend[axis] * (3.0 * x[0] + 2.0 * x[D - 1]).sin()
            })
        });
        displacements.push(displaced.unwrap());
    }
    displacements
}

fn along_a_path<const D: usize>(degree: usize, cells: [usize; 2], pairing: &Pairing)
where
    Dim: Dimension<D>,
{
    let mut offset = [0.03; D];
    offset[D - 1] = 0.02;
    let mesh = boxes(cells, offset);
    let space = Space::vector(&mesh, degree).unwrap();
    let form = gaps::opening(&gaps::Touch::on(pairing.clone()));
    let keeping = [1, 3].map(|threads| Assembler::new(&mesh).with_threads(Threads::new(threads)));
    let mut open = vec![];
    for u in path(&space, 50) {
        let fresh = Assembler::new(&mesh).with_threads(Threads::ONE);
        let expected =
            (fresh.pairs_at(pairing, 3, &u).unwrap(), fresh.residual(&form, &[&u], &[&space]).unwrap());
        for assembler in &keeping {
            let report = assembler.pairs_at(pairing, 3, &u).unwrap();
            assert_eq!(report, expected.0);
            assert!(assembler.residual(&form, &[&u], &[&space]).unwrap() == expected.1);
        }
        open.push(expected.0.open);
    }
    // The path is one on which points find and lose their partners.
    open.sort_unstable();
    open.dedup();
    assert!(open.len() > 5, "{open:?}");
}

#[test]
fn pairs_do_not_remember_in_the_plane() {
    for degree in [1, 2, 3] {
        along_a_path::<2>(degree, [5, 7], &Pairing::between("below", "above"));
    }
    along_a_path::<2>(2, [5, 7], &Pairing::within("touch"));
    along_a_path::<2>(1, [5, 7], &Pairing::between("below", "above").within_reach(0.07));
}

#[test]
fn pairs_do_not_remember_in_space() {
    for degree in [1, 2] {
        along_a_path::<3>(degree, [2, 3], &Pairing::between("below", "above"));
    }
}

/// Reports of displaced surfaces that are known: an overlap, its place, points that face nothing.
#[test]
fn reports_at_an_iterate() {
    let mesh = boxes([4, 4], [0.0, 0.01]);
    let space = Space::vector(&mesh, 2).unwrap();
    let assembler = Assembler::new(&mesh);
    // The upper body moves by half a cell to the right and sinks, most in its middle.
    let depth = |x: f64| 0.05 - 0.04 * (x - 0.6).powi(2);
    let u = Field::zero(&space);
    assert_eq!(assembler.pairs_at(&Pairing::onto("below", "above"), 3, &u).unwrap().open, 0);
    let upper = space.nodes_on("above").unwrap();
    let mut values = u.values().to_vec();
    for node in upper {
        let x = space.positions()[node as usize];
        values[2 * node as usize] = 0.125;
        values[2 * node as usize + 1] = -0.01 - depth(x[0] + 0.125);
    }
    let pressed = Field::from_values(&space, values).unwrap();
    let report = assembler.pairs_at(&Pairing::onto("below", "above"), 3, &pressed).unwrap();
    // One of eight points is beyond the end of the upper surface: a half of the first facet, one of its two points.
    assert_eq!((report.points, report.open, report.rejected), (7, 1, 0));
    let (at, nearest) = (report.deepest_at.unwrap(), 0.5 + 0.125 * (1.0 - 1.0 / 3.0_f64.sqrt()));
    assert!((at[0] - nearest).abs() < 1e-14 && at[1] == 1.0, "{at:?}");
    assert!((report.deepest_overlap - depth(at[0])).abs() < 1e-14, "{report:?}");
}

/// A square above a square, then one with a bent side: distances along a slanted direction that are known.
#[test]
fn first_touch_along_a_direction() {
    let mut mesh = Mesh::clone(&boxes::<2>([4, 5], [0.0, 0.4]));
    mesh.name_cells("upper", |x| x[1] > 1.2).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let assembler = Assembler::new(&mesh);
    let zero = Field::zero(&space);
    let approach = |direction| Approach { moving: "upper".to_owned(), direction, overlap: 1e-3 };
    for pairing in [Pairing::between("below", "above"), Pairing::onto("below", "above")] {
        // Down by 0.4 on the way of 0.5 along (3, −4)/5.
        let touch = assembler.first_touch(&pairing, 3, &zero, &approach([0.6, -0.8])).unwrap();
        assert!((touch.distance - 0.5).abs() < 1e-14, "{}", touch.distance);
        let report = assembler.pairs_at(&pairing, 3, &touch.start).unwrap();
        assert!((report.deepest_overlap - 0.8e-3).abs() < 1e-14, "{report:?}");
        assert!(report.points > 0 && report.open > 0);
    }
    // A bent surface: the depth of its lowest quadrature point is what is missing.
    let bent =
        Field::interpolate(&space, |x: &[f64; 2]| [0.0, if x[1] > 1.2 { 0.1 * x[0] * x[0] } else { 0.0 }])
            .unwrap();
    let touch =
        assembler.first_touch(&Pairing::onto("above", "below"), 3, &bent, &approach([0.0, -2.0])).unwrap();
    let lowest = 0.1 * (1.0 - 1.0 / 3.0_f64.sqrt());
    assert!((touch.distance - 0.4 - 0.1 * lowest * lowest).abs() < 1e-14, "{}", touch.distance);
    assert!((touch.at[0] - lowest).abs() < 1e-14);
    // Away, along nothing, and cells to which both belong.
    let of = |approach| {
        assembler.first_touch(&Pairing::onto("below", "above"), 3, &zero, &approach).unwrap_err().to_string()
    };
    assert_eq!(of(approach([0.0, 1.0])), "the cells \"upper\" meet no opposite surface along [0.0, 1.0]");
    assert!(of(approach([0.0, 0.0])).starts_with("a body cannot approach along [0.0, 0.0]"));
    let all = Approach { moving: "all".to_owned(), ..approach([0.0, -1.0]) };
    assert!(
        of(all).starts_with("of the surfaces \"below\" and \"above\" one must belong to the cells \"all\"")
    );
}
