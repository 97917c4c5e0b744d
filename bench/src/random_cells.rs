//! The harness's cells, coefficients and constants (`peers/time_kernels.c`): random, and the same in every run.

use crate::basix::{dimension, node_count, node_points};
use crate::element_batch::Setting;

/// Cells of one batch.
pub const BATCH: usize = 8;
/// Cells that the harness makes.
const CELLS: usize = 256;

/// Input of a kernel for the harness's cells.
#[derive(Clone, Debug)]
pub struct RandomCells {
    /// λ, μ, γ₀.
    pub constants: [f64; 3],
    /// Coordinates: cell × node × 3, the last zero in two dimensions.
    pub coordinates: Vec<f64>,
    /// Coefficients: cell × coefficient.
    pub coefficients: Vec<f64>,
}

/// splitmix64, as numbers in [−1, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 * 2f64.powi(-52) - 1.0
    }
}

impl RandomCells {
    /// The cells of a kernel that reads `width` coefficients on each.
    pub fn new(setting: &Setting, width: usize) -> Self {
        let (shape, dimension) = (setting.shape, dimension(setting.shape));
        let reference = node_points(shape, setting.geometry, setting.order);
        let nodes = node_count(shape, setting.geometry);
        let mut random = Random(42);
        let mut coordinates = vec![0.0; CELLS * nodes * 3];
        let mut coefficients = vec![0.0; CELLS * width];
        for cell in 0..CELLS {
            let map = random_map(&mut random, dimension);
            for (node, point) in reference.iter().enumerate() {
                for axis in 0..dimension {
                    let mut x: f64 = (0..dimension).map(|k| map[axis][k] * point[k]).sum();
                    if !shape.is_simplex() {
                        x += 0.04 * random.next();
                    }
                    coordinates[(cell * nodes + node) * 3 + axis] = x;
                }
            }
            for coefficient in &mut coefficients[cell * width..(cell + 1) * width] {
                *coefficient = 0.02 * random.next();
            }
        }
        RandomCells { constants: [1.2, 0.8, 10.0], coordinates, coefficients }
    }
}

// I + a random matrix, until its determinant is at least 0.2.
fn random_map(random: &mut Random, dimension: usize) -> [[f64; 3]; 3] {
    loop {
        let mut m = [[0.0; 3]; 3];
        for (a, row) in m.iter_mut().enumerate().take(dimension) {
            for (b, entry) in row.iter_mut().enumerate().take(dimension) {
                *entry = f64::from(u8::from(a == b)) + 0.3 * random.next();
            }
        }
        let minor = |a: usize, b: usize| m[1][a] * m[2][b] - m[1][b] * m[2][a];
        let determinant = match dimension {
            2 => m[0][0] * m[1][1] - m[0][1] * m[1][0],
            _ => m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1),
        };
        if determinant >= 0.2 {
            return m;
        }
    }
}
