//! Inf-sup constants of pairs of velocities and pressures: β² is the smallest eigenvalue of B A⁻¹ Bᵀ q = β² M q, constants left out.

use forms_fem::prelude::*;

use crate::shared::*;

/// A dense matrix, row after row.
struct Dense {
    size: usize,
    entries: Vec<f64>,
}

impl Dense {
    /// Factors A = L D Lᵀ in place, without pivots: L below the diagonal, D on it.
    fn factor(&mut self) {
        let n = self.size;
        for column in 0..n {
            let pivot = self.entries[column * n + column];
            let factors: Vec<f64> =
                (column + 1..n).map(|row| self.entries[row * n + column] / pivot).collect();
            let of_column: Vec<f64> = (column + 1..n).map(|row| self.entries[row * n + column]).collect();
            for (row, factor) in (column + 1..n).zip(&factors) {
                let target = &mut self.entries[row * n + column + 1..row * n + row + 1];
                for (entry, other) in target.iter_mut().zip(&of_column) {
                    *entry -= factor * other;
                }
                self.entries[row * n + column] = *factor;
            }
        }
    }

    /// L⁻¹ b of a factored matrix.
    fn forward(&self, b: &mut [f64]) {
        for row in 0..self.size {
            let known = &self.entries[row * self.size..row * self.size + row];
            b[row] -= known.iter().zip(&*b).map(|(l, x)| l * x).sum::<f64>();
        }
    }
}

/// β on a mesh, by the number of eigenvalues below: the signs of the pivots of B A⁻¹ Bᵀ − τ M.
fn constant(mesh: &Mesh<2>, of_u: &(Elements, Scope), of_p: &(Elements, Scope)) -> f64 {
    let velocities = Space::of(mesh, of_u.0.clone(), of_u.1.clone(), &[2]).unwrap();
    let pressures = Space::of(mesh, of_p.0.clone(), of_p.1.clone(), &[]).unwrap();
    let assembler = Assembler::new(mesh);
    let omega = stokes::Omega::on("all");
    let data = stokes::data().inertia(0.0).f([0.0; 2]);
    let (u, p) = (Field::zero(&velocities), Field::zero(&pressures));
    let flow =
        assembler.tangent(&stokes::flow(&data, &omega), &[&u, &p], &[&velocities, &pressures]).unwrap();
    let mass = assembler.tangent(&stokes::mass(&data, &omega), &[&p], &[&pressures]).unwrap();
    let mut walls = Constraints::new(&velocities);
    walls.fix("boundary", |_: &[f64; 2]| [0.0; 2]).unwrap();
    let free: Vec<usize> =
        (0..velocities.unknowns()).filter(|k| !walls.prescribed().contains_key(k)).collect();
    let (n, m, first) = (free.len(), pressures.unknowns(), velocities.unknowns());
    let mut place = vec![usize::MAX; first];
    free.iter().enumerate().for_each(|(index, unknown)| place[*unknown] = index);
    let mut a = Dense { size: n, entries: vec![0.0; n * n] };
    for (index, unknown) in free.iter().enumerate() {
        for (column, value) in row(&flow, *unknown).filter(|(column, _)| *column < first) {
            if place[column] < n {
                a.entries[index * n + place[column]] += value;
            }
        }
    }
    a.factor();
    let inverse_pivots: Vec<f64> = (0..n).map(|k| 1.0 / a.entries[k * n + k]).collect();
    let columns: Vec<Vec<f64>> = (0..m)
        .map(|pressure| {
            let mut b = vec![0.0; n];
            for (column, value) in row(&flow, first + pressure).filter(|(column, _)| *column < first) {
                if place[column] < n {
                    b[place[column]] += value;
                }
            }
            a.forward(&mut b);
            b
        })
        .collect();
    let scaled =
        |column: &Vec<f64>| -> Vec<f64> { column.iter().zip(&inverse_pivots).map(|(x, d)| x * d).collect() };
    let mut schur = vec![0.0; m * m];
    for i in 0..m {
        let left = scaled(&columns[i]);
        for j in 0..=i {
            let entry: f64 = left.iter().zip(&columns[j]).map(|(x, y)| x * y).sum();
            (schur[i * m + j], schur[j * m + i]) = (entry, entry);
        }
    }
    let below = |tau: f64| {
        let mut shifted = Dense { size: m, entries: schur.clone() };
        for k in 0..m {
            for (column, value) in row(&mass, k) {
                shifted.entries[k * m + column] -= tau * value;
            }
        }
        shifted.factor();
        (0..m).filter(|k| shifted.entries[k * m + k] < 0.0).count()
    };
    // One eigenvalue is zero: the constant pressure's.
    let (mut low, mut high) = (1e-9, 2.0);
    for _ in 0..25 {
        let middle = f64::sqrt(low * high);
        if below(middle) <= 1 { low = middle } else { high = middle }
    }
    low.sqrt()
}

/// The constants on four meshes.
fn constants(shape: CellShape, of_u: (Elements, Scope), of_p: (Elements, Scope)) -> [f64; 4] {
    let found = [2, 4, 6, 8].map(|n| constant(&distorted(n, shape, 1), &of_u, &of_p));
    println!("{} {} with {} {}: {found:.4?}", of_u.0, of_u.1, of_p.0, of_p.1);
    found
}

fn is_bounded(found: [f64; 4], bound: f64) {
    assert!(found.iter().all(|beta| *beta > bound), "{found:?}");
    // From the second to the last mesh they do not tend to zero.
    assert!(found[3] > 0.85 * found[1], "{found:?}");
}

#[test]
fn stable_pairs_have_constants_that_stay() {
    let nodal = |elements: Elements| (elements, Scope::Nodes);
    let jumping = |elements: Elements| (elements, Scope::Cell);
    let triangle = CellShape::Triangle;
    is_bounded(constants(triangle, nodal(Elements::Mini(1)), nodal(Elements::Lagrange(1))), 0.1);
    is_bounded(constants(triangle, nodal(Elements::Lagrange(2)), nodal(Elements::Lagrange(1))), 0.1);
    is_bounded(constants(triangle, nodal(Elements::Mini(2)), jumping(Elements::Lagrange(1))), 0.1);
    is_bounded(constants(triangle, nodal(Elements::CrouzeixRaviart), jumping(Elements::Lagrange(0))), 0.1);
    let quadrilateral = CellShape::Quadrilateral;
    is_bounded(constants(quadrilateral, nodal(Elements::Lagrange(2)), jumping(Elements::LinearInSpace)), 0.1);
}

#[test]
fn an_unstable_pair_is_found_out() {
    // Without bubbles there are pressures that no velocity sees.
    let linear = || (Elements::Lagrange(1), Scope::Nodes);
    let found = constants(CellShape::Triangle, linear(), linear());
    assert!(found[3] < 0.01, "{found:?}");
}
