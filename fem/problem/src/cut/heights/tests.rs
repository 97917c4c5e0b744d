//! Rules on parts of squares and cubes: volumes and surfaces compared with closed forms and a fine reference, weights, degenerate places.

use super::bernstein::{from_nodes, from_vertices};
use super::cell::line_rule;
use super::{Walk, Wanted, points};

/// The coefficients of a function of degree 2 in each direction.
fn of<const N: usize>(f: impl Fn(&[f64; 3]) -> f64) -> [f64; N] {
    let mut c = std::array::from_fn(|k| f(&[k % 3, k / 3 % 3, k / 9].map(|place| 0.5 * place as f64)));
    from_nodes(&mut c);
    c
}

fn lines(count: usize) -> Vec<(f64, f64)> {
    line_rule(2 * count - 1).unwrap()
}

/// The integral of a function of place and normal over what is wanted; weights are positive and points inside.
fn sum<const N: usize>(
    c: &[f64; N],
    wanted: Wanted,
    count: usize,
    f: impl Fn(&[f64; 3], &[f64; 3]) -> f64,
) -> f64 {
    // Compensated, as near tangents there are many points.
    let (rule, mut sum, mut lost) = (lines(count), 0.0, 0.0);
    points(c, wanted, &Walk::new([&rule; 3]), &mut |place, weight, normal| {
        assert!(weight > 0.0 && weight.is_finite(), "{weight}");
        assert!(place.iter().all(|x| (0.0..=1.0).contains(x)), "{place:?}");
        let term = weight * f(&place, &normal) - lost;
        let next: f64 = sum + term;
        (sum, lost) = (next, (next - sum) - term);
    });
    sum
}

fn measure<const N: usize>(c: &[f64; N], wanted: Wanted, count: usize) -> f64 {
    sum(c, wanted, count, |_, _| 1.0)
}

/// Numbers without a pattern in (−1, 1).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// The volume of {φ < 0} by exact intervals on many lines, the midpoint rule in each part between kinks that it knows nothing of.
fn reference<const N: usize>(c: &[f64; N], lines: usize) -> f64 {
    let axes = if N == 9 { 1 } else { 2 };
    let count = lines.pow(axes);
    let of_line = |index: usize| {
        let at = [index % lines, index / lines].map(|k| (k as f64 + 0.5) / lines as f64);
        let values = super::line(c, 0, &at);
        // Three samples give the quadratic, whose zeros are found by bisection on a fine grid of signs.
        let value = |t: f64| {
            let s = 1.0 - t;
            s * s * values[0] + 2.0 * s * t * values[1] + t * t * values[2]
        };
        let turn = (values[0] - values[1]) / (values[0] - 2.0 * values[1] + values[2]);
        let mut ends = vec![0.0, 1.0];
        if (1e-12..1.0).contains(&turn) {
            ends.insert(1, turn);
        }
        let part = |ends: &[f64]| {
            let (mut a, mut b) = (ends[0], ends[1]);
            match (value(a) < 0.0, value(b) < 0.0) {
                (true, true) => b - a,
                (false, false) => 0.0,
                (is_first, _) => {
                    for _ in 0..60 {
                        let middle = 0.5 * (a + b);
                        if (value(middle) < 0.0) == is_first { a = middle } else { b = middle }
                    }
                    if is_first { a - ends[0] } else { ends[1] - a }
                }
            }
        };
        ends.windows(2).map(part).sum::<f64>()
    };
    (0..count).map(of_line).sum::<f64>() / count as f64
}

#[test]
fn hyperbola_has_its_area_and_length() {
    let mut c = [0.0_f64; 9];
    for k in [0, 2, 6, 8] {
        c[k] = [k % 3, k / 3].iter().map(|place| 0.5 * *place as f64).product::<f64>() - 0.25;
    }
    from_vertices(&mut c);
    let area = 0.25 * (1.0 + 4.0_f64.ln());
    assert!((measure(&c, Wanted::Inside, 12) - area).abs() < 1e-13);
    assert!((measure(&c, Wanted::Interface, 16) - 1.132_090_393_3).abs() < 1e-9);
}

#[test]
fn planes_and_parabolas_are_exact() {
    let plane = |x: &[f64; 3]| x[0] + x[1] + x[2] - 0.77;
    let square: [f64; 9] = of(plane);
    assert!((measure(&square, Wanted::Inside, 2) - 0.77_f64.powi(2) / 2.0).abs() < 1e-15);
    assert!((measure(&square, Wanted::Interface, 1) - 2.0_f64.sqrt() * 0.77).abs() < 1e-15);
    let cube: [f64; 27] = of(plane);
    assert!((measure(&cube, Wanted::Inside, 2) - 0.77_f64.powi(3) / 6.0).abs() < 1e-15);
    assert!((measure(&cube, Wanted::Interface, 2) - 0.75_f64.sqrt() * 0.77 * 0.77).abs() < 1e-14);
    // A graph of degree 2 over the others.
    let bowl: [f64; 27] = of(|x| x[2] - 0.2 - 0.5 * x[0] * x[0] - 0.2 * x[1]);
    assert!((measure(&bowl, Wanted::Inside, 3) - 0.2 - 0.5 / 3.0 - 0.1).abs() < 1e-14);
}

#[test]
fn circles_and_spheres_converge_with_twice_the_points() {
    // A quarter and an eighth with the centre at a corner; slopes vanish at the ends of the arc in turn.
    let radius = 0.83_f64;
    let disc: [f64; 9] = of(|x| x[0] * x[0] + x[1] * x[1] - radius * radius);
    let ball: [f64; 27] = of(|x| x[0] * x[0] + x[1] * x[1] + x[2] * x[2] - radius * radius);
    let pi = std::f64::consts::PI;
    let exact =
        [pi * radius.powi(2) / 4.0, pi * radius / 2.0, pi * radius.powi(3) / 6.0, pi * radius.powi(2) / 2.0];
    let errors = |count: usize| {
        let found = [
            measure(&disc, Wanted::Inside, count),
            measure(&disc, Wanted::Interface, count),
            measure(&ball, Wanted::Inside, count),
            measure(&ball, Wanted::Interface, count),
        ];
        [0, 1, 2, 3].map(|k| (found[k] / exact[k] - 1.0).abs())
    };
    let [coarse, fine, finest] = [2, 4, 12].map(errors);
    println!("{coarse:?} {fine:?} {finest:?}");
    for k in 0..4 {
        assert!(fine[k] < 0.2 * coarse[k] && finest[k] < 1e-9, "{coarse:?} {fine:?} {finest:?}");
    }
}

#[test]
fn degenerate_places_have_their_volumes() {
    // Zeros at a face, at a corner, along an edge, tangent to a face from both sides, a double zero, a saddle, two parts, a tunnel.
    let check = |f: &dyn Fn(&[f64; 3]) -> f64, volume: f64, surface: f64, tolerance: f64| {
        let c: [f64; 27] = of(f);
        let [inside, outside, interface] =
            [Wanted::Inside, Wanted::Outside, Wanted::Interface].map(|wanted| measure(&c, wanted, 12));
        assert!((inside + outside - 1.0).abs() < 1e-13, "{inside} {outside}");
        assert!(
            (inside - volume).abs() < 1e-12,
            "volume {inside}, not {volume}, off by {:e}",
            inside - volume
        );
        assert!(
            (interface - surface).abs() < tolerance,
            "surface {interface}, not {surface}, off by {:e}",
            interface - surface
        );
    };
    let pi = std::f64::consts::PI;
    check(&|x| x[0], 0.0, 0.0, 1e-15);
    check(&|x| -x[0], 1.0, 0.0, 1e-15);
    check(&|x| x[0] - 1.0, 1.0, 0.0, 1e-15);
    check(&|x| x[0] + x[1] + x[2], 0.0, 0.0, 1e-15);
    check(&|x| x[0] - x[1], 0.5, 2.0_f64.sqrt(), 1e-13);
    check(&|x| (x[0] - 0.5).powi(2), 0.0, 0.0, 1e-15);
    check(&|x| -(x[0] - 0.5).powi(2), 1.0, 0.0, 1e-15);
    check(&|x| (x[0] - 0.5).powi(2) - 1e-10, 2e-5, 2.0, 1e-12);
    check(&|x| (x[0] - 0.25) * (x[0] - 0.75), 0.5, 2.0, 1e-13);
    check(&|x| (x[0] - 0.5) * (x[1] - 0.5), 0.5, 2.0, 2e-6);
    // A bubble that nodes do not see, and one that touches a face from inside.
    let ball = |x: &[f64; 3], centre: [f64; 3], radius: f64| {
        (0..3).map(|k| (x[k] - centre[k]).powi(2)).sum::<f64>() - radius * radius
    };
    let volume = |radius: f64| [4.0 * pi * radius.powi(3) / 3.0, 4.0 * pi * radius * radius];
    for (centre, radius) in
        [([0.25, 0.26, 0.74], 0.2), ([0.5, 0.5, 0.3], 0.3), ([0.5; 3], 0.5), ([0.31, 0.4, 0.6], 1e-3)]
    {
        let [volume, surface] = volume(radius);
        check(&|x| ball(x, centre, radius), volume, surface, 1e-11);
        check(&|x| -ball(x, centre, radius), 1.0 - volume, surface, 1e-11);
    }
    // A cylinder through the cube: a tunnel, when it is outside.
    let cylinder = |x: &[f64; 3]| (x[0] - 0.52).powi(2) + (x[1] - 0.47).powi(2) - 0.09;
    check(&cylinder, 0.09 * pi, 0.6 * pi, 1e-12);
    check(&|x| -cylinder(x), 1.0 - 0.09 * pi, 0.6 * pi, 1e-12);
    // A cone with its tip inside.
    check(
        &|x| (x[0] - 0.5).powi(2) + (x[1] - 0.5).powi(2) - (x[2] - 0.4).powi(2) / 4.0,
        pi / 12.0 * (0.4_f64.powi(3) + 0.6_f64.powi(3)),
        pi * 0.5 * 1.25_f64.sqrt() * (0.4_f64.powi(2) + 0.6_f64.powi(2)),
        1e-6,
    );
}

#[test]
fn random_cells_have_the_volume_of_a_fine_reference() {
    let mut numbers = Numbers(7);
    let mut worst = [0.0_f64; 4];
    for number in 0..4000 {
        // Of degree 2, and nearly flat ones, as on fine meshes.
        let bend = [1.0, 0.3, 0.05][number % 3];
        let plane: [f64; 4] = std::array::from_fn(|_| numbers.next());
        let mut c: [f64; 9] = of(|x| plane[0] * x[0] + plane[1] * x[1] + 0.7 * plane[2]);
        c.iter_mut().for_each(|entry| *entry += bend * numbers.next());
        let [inside, outside] = [Wanted::Inside, Wanted::Outside].map(|wanted| measure(&c, wanted, 8));
        worst[0] = worst[0].max((inside + outside - 1.0).abs());
        let miss = (inside - reference(&c, 1000)).abs();
        worst[3] = worst[3].max(miss);
        assert!(miss < 1e-4, "{c:?}: {inside}, off by {miss:e}");
        // The divergence theorem for (x, 0) and (0, y), with the edges of the square.
        for axis in 0..2 {
            let own = sum(&c, Wanted::Interface, 8, |x, n| x[axis] * n[axis]);
            let edge: [f64; 3] = super::face(&c, axis, 1);
            let zeros = super::Zeros::of(&[edge]);
            let (mut length, mut start) = (0.0, 0.0);
            for k in 0..=zeros.list().len() {
                let end = zeros.list().get(k).copied().unwrap_or(1.0);
                if (edge[0] < 0.0) == (k % 2 == 0) {
                    length += end - start;
                }
                start = end;
            }
            worst[1] = worst[1].max((inside - own - length).abs());
        }
    }
    println!("squares: inside and outside, divergence theorem, -, reference {worst:?}");
    assert!(worst[0] < 1e-13 && worst[1] < 1e-5, "{worst:?}");
    for number in 0..300 {
        let bend = [1.0, 0.3, 0.05][number % 3];
        let plane: [f64; 4] = std::array::from_fn(|_| numbers.next());
        let mut c: [f64; 27] = of(|x| plane[0] * x[0] + plane[1] * x[1] + plane[2] * x[2] + 0.7 * plane[3]);
        c.iter_mut().for_each(|entry| *entry += bend * numbers.next());
        let [inside, outside] = [Wanted::Inside, Wanted::Outside].map(|wanted| measure(&c, wanted, 5));
        worst[2] = worst[2].max((inside + outside - 1.0).abs());
        let miss = (inside - reference(&c, 100)).abs();
        worst[3] = worst[3].max(miss);
        assert!(miss < 2e-4, "{c:?}: {inside}, off by {miss:e}");
    }
    println!("cubes: inside and outside, reference {:?}", &worst[2..]);
    assert!(worst[2] < 1e-13, "{worst:?}");
}
