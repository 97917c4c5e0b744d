//! Rules on the triangle and the tetrahedron: symmetric ones of low degree, conical products above.

use super::gauss::gauss_jacobi;
use super::tables;

/// Points and weights of a rule that is exact to `degree` on the unit triangle.
///
/// Degrees 1, 2, 4, 5, 6 have 1, 3, 6, 7, 12 symmetric points (Strang and Fix 1973, Radon 1948, Dunavant
/// 1985), degrees 7, 8, 9 have 15, 16, 19 (Dunavant 1985; Witherden and Vincent 2015); higher ones are conical products of
/// Gauss-Jacobi rules with (⌊degree/2⌋ + 1)² points.
pub fn triangle(degree: usize) -> (Vec<[f64; 2]>, Vec<f64>) {
    let mut orbits = Orbits::<2>::default();
    match degree {
        0 | 1 => orbits.centre(1.0),
        2 => orbits.vertex(1.0 / 6.0, 1.0 / 3.0),
        3 | 4 => {
            let root = (38.0 - 44.0 * 0.4_f64.sqrt()).sqrt();
            let weight_root = (213_125.0 - 53_320.0 * 10f64.sqrt()).sqrt();
            orbits.vertex((8.0 - 10f64.sqrt() + root) / 18.0, (620.0 + weight_root) / 3720.0);
            orbits.vertex((8.0 - 10f64.sqrt() - root) / 18.0, (620.0 - weight_root) / 3720.0);
        }
        5 => {
            orbits.centre(9.0 / 40.0);
            orbits.vertex((6.0 - 15f64.sqrt()) / 21.0, (155.0 - 15f64.sqrt()) / 1200.0);
            orbits.vertex((6.0 + 15f64.sqrt()) / 21.0, (155.0 + 15f64.sqrt()) / 1200.0);
        }
        6 => {
            orbits.vertex(0.249_286_745_170_910_42, 0.116_786_275_726_379_37);
            orbits.vertex(0.063_089_014_491_502_23, 0.050_844_906_370_206_82);
            let (a, b) = (0.053_145_049_844_816_95, 0.310_352_451_033_784_4);
            let c = 1.0 - a - b;
            for point in [[a, b], [b, a], [a, c], [c, a], [b, c], [c, b]] {
                orbits.push(point, 0.082_851_075_618_373_57);
            }
        }
        _ if orbits.tabulated(tables::TRIANGLE, degree) => {}
        _ => {
            let n = degree / 2 + 1;
            for (x, wx) in gauss_jacobi(n, 1) {
                for (s, ws) in gauss_jacobi(n, 0) {
                    // `push` takes weights that sum to one.
                    orbits.push([x, (1.0 - x) * s], 2.0 * wx * ws);
                }
            }
        }
    }
    orbits.scaled(0.5)
}

/// Points and weights of a rule that is exact to `degree` on the unit tetrahedron.
///
/// Degrees 1, 2, 3, 5 have 1, 4, 8, 14 symmetric points (Keast 1986; Zhang, Cui and Liu 2009; Walkington
/// 2000), degrees 6, 7 have 24, 35 (Keast 1986; Witherden and Vincent 2015); higher ones are conical products of Gauss-Jacobi rules with (⌊degree/2⌋ + 1)³ points.
pub fn tetrahedron(degree: usize) -> (Vec<[f64; 3]>, Vec<f64>) {
    let mut orbits = Orbits::<3>::default();
    match degree {
        0 | 1 => orbits.centre(1.0),
        2 => orbits.vertex((5.0 - 5f64.sqrt()) / 20.0, 0.25),
        3 => {
            orbits.vertex(0.328_054_696_711_426_6, 0.138_527_966_511_862_14);
            orbits.vertex(0.106_952_273_932_930_68, 0.111_472_033_488_137_86);
        }
        4 | 5 => {
            orbits.vertex(0.310_885_919_263_300_6, 6.0 * 0.018_781_320_953_002_642);
            orbits.vertex(0.092_735_250_310_891_23, 6.0 * 0.012_248_840_519_393_658);
            let (a, weight) = (0.045_503_704_125_649_65, 6.0 * 0.007_091_003_462_846_911);
            let b = 0.5 - a;
            for point in [[a, a, b], [a, b, a], [b, a, a], [a, b, b], [b, a, b], [b, b, a]] {
                orbits.push(point, weight);
            }
        }
        _ if orbits.tabulated(tables::TETRAHEDRON, degree) => {}
        _ => {
            let n = degree / 2 + 1;
            for (x, wx) in gauss_jacobi(n, 2) {
                for (s, ws) in gauss_jacobi(n, 1) {
                    for (t, wt) in gauss_jacobi(n, 0) {
                        let point = [x, (1.0 - x) * s, (1.0 - x) * (1.0 - s) * t];
                        orbits.push(point, 6.0 * wx * ws * wt);
                    }
                }
            }
        }
    }
    orbits.scaled(1.0 / 6.0)
}

// Collects points orbit by orbit, with weights that sum to one.
#[derive(Default)]
struct Orbits<const D: usize> {
    points: Vec<[f64; D]>,
    weights: Vec<f64>,
}

impl<const D: usize> Orbits<D> {
    fn push(&mut self, point: [f64; D], weight: f64) {
        self.points.push(point);
        self.weights.push(weight);
    }

    fn centre(&mut self, weight: f64) {
        self.push([1.0 / (D + 1) as f64; D], weight);
    }

    // The D + 1 points with barycentric coordinates (a, .., a, 1 - D a).
    fn vertex(&mut self, a: f64, weight: f64) {
        self.push([a; D], weight);
        for k in 0..D {
            let mut point = [a; D];
            point[k] = 1.0 - D as f64 * a;
            self.push(point, weight);
        }
    }

    // The points of the table's rule of a degree, if there is one: each orbit's in all orders of the barycentric coordinates.
    fn tabulated<const N: usize>(&mut self, rules: &[tables::Orbits<N>], degree: usize) -> bool {
        let Some((_, orbits)) = rules.iter().find(|(of, _)| *of == degree) else { return false };
        for (weight, barycentric) in *orbits {
            let first = self.points.len();
            for order in 0..N.pow(N as u32) {
                let places: [usize; N] = std::array::from_fn(|k| order / N.pow(k as u32) % N);
                let is_permutation = (0..N).all(|place| places.contains(&place));
                let point = std::array::from_fn(|k| barycentric[places[k]]);
                if is_permutation && !self.points[first..].contains(&point) {
                    self.push(point, *weight);
                }
            }
        }
        true
    }

    fn scaled(self, volume: f64) -> (Vec<[f64; D]>, Vec<f64>) {
        (self.points, self.weights.into_iter().map(|weight| volume * weight).collect())
    }
}
