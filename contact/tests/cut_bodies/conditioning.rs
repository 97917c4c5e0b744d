//! Ghost penalties and aggregates: the condition of Nitsche's method on a circle at many positions, the least eigenvalue for θ = 1, polynomials.

use forms_contact::law::ContactLaw;
use forms_contact::laws::cut_nitsche;
use forms_contact::parameter_ranges::ParameterRanges;
use forms_fem::linear_algebra::{CsrMatrix, SymmetricEigen};
use forms_fem::mesh::disc;
use forms_fem::prelude::*;

use crate::{cut, square};

fn data(theta: f64, degree: usize, ghost: f64) -> cut_nitsche::Data<2> {
    cut_nitsche::data()
        .lambda(1.0)
        .mu(1.0)
        .gamma0(30.0 * (degree * degree) as f64)
        .obstacle_normal([0.0, -1.0])
        .gap(0.0)
        .theta(theta)
        .ghost_slopes(ghost)
        .ghost_bends(ghost / 10.0)
}

/// A remedy for small cuts.
#[derive(Clone, Copy)]
enum Remedy {
    /// The ghost penalty with g₁ and g₂ = g₁/10.
    Penalty(f64),
    Aggregates,
}

/// Nitsche's method with Dirichlet values on facets.
#[forms(dimension = 2)]
mod fitted {
    use forms_contact::operators::linear_elastic::stress;
    use forms_contact::operators::weak_dirichlet::dirichlet_density;

    #[includes(
        forms_contact::operators::linear_elastic::Data,
        forms_contact::operators::weak_dirichlet::Data
    )]
    pub struct Data {}
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Rim;

    pub fn held(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
            + integral(Rim, dirichlet_density(stress(u) * n, u, stress(v) * n, v))
    }
}

/// The dense matrix on a fitted disc whose cells are about as large as those of the square.
fn fitted_matrix(theta: f64) -> (usize, Vec<f64>) {
    let mesh = disc(0.7, [false; 2], 3, 2, CellShape::Triangle, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let data = fitted::data().lambda(1.0).mu(1.0).gamma0(30.0).theta(theta).prescribed([0.0; 2]);
    let form = fitted::Model { data, regions: fitted::Regions::default().rim("circle") }.held();
    let whole: CsrMatrix = Assembler::new(&mesh).tangent(&form, &[&Field::zero(&space)], &[&space]).unwrap();
    let size = space.unknowns();
    let mut dense = vec![0.0; size * size];
    for row in 0..size {
        let (columns, values) = whole.row(row);
        columns.iter().zip(values).for_each(|(column, value)| dense[row * size + *column as usize] = *value);
    }
    (size, dense)
}

/// The dense matrix of Nitsche's method with Dirichlet values on a circle, at the free unknowns of active cells.
fn matrix(cells: usize, degree: usize, shift: [f64; 2], theta: f64, remedy: Remedy) -> (usize, Vec<f64>) {
    let mesh = square(cells);
    let (ghost, body) = {
        let body = cut(&mesh, |x| (x[0] - shift[0]).hypot(x[1] - shift[1]) - 0.7);
        match remedy {
            Remedy::Penalty(ghost) => (ghost, body),
            Remedy::Aggregates => {
                let aggregated = body.cut().unwrap().aggregated().unwrap();
                (0.1, Assembler::new(&mesh).with_cut(&aggregated).unwrap())
            }
        }
    };
    let space = Space::vector(&mesh, degree).unwrap();
    let mut held = Constraints::new(&space);
    body.cut().unwrap().hold_outside(&mut held).unwrap();
    let regions = cut_nitsche::regions().gamma_c("all").gamma_d("all").gamma_n("boundary");
    let model = cut_nitsche::Model { data: data(theta, degree, ghost), regions };
    let form = model.without_contact() + model.dirichlet();
    let whole: CsrMatrix = body.tangent(&form, &[&Field::zero(&space)], &[&space]).unwrap();
    let free = held.free();
    let size = free.len();
    let mut dense = vec![0.0; size * size];
    // An unknown by free ones.
    let mut terms: Vec<Vec<(usize, f64)>> = vec![vec![]; space.unknowns()];
    free.iter().enumerate().for_each(|(k, unknown)| terms[*unknown] = vec![(k, 1.0)]);
    for (unknown, relation) in held.relations() {
        let place = |(free, a): &(usize, f64)| (terms[*free][0].0, *a);
        terms[*unknown] = relation.terms.iter().map(place).collect();
    }
    for (row, own) in terms.iter().enumerate() {
        let (columns, values) = whole.row(row);
        for (column, value) in columns.iter().zip(values) {
            for (i, a) in own {
                for (j, b) in &terms[*column as usize] {
                    dense[i * size + j] += a * value * b;
                }
            }
        }
    }
    (size, dense)
}

/// The condition in the Euclidean norm.
fn condition((size, a): &(usize, Vec<f64>)) -> f64 {
    let size = *size;
    let mut product = vec![0.0; size * size];
    for k in 0..size {
        let row = &a[k * size..][..size];
        for i in (0..size).filter(|i| row[*i] != 0.0) {
            for j in 0..size {
                product[i * size + j] += row[i] * row[j];
            }
        }
    }
    let eigen = SymmetricEigen::of(size, &product).unwrap();
    let largest = eigen.values.iter().copied().fold(f64::MIN, f64::max);
    let least = eigen.values.iter().copied().fold(f64::MAX, f64::min);
    (largest / least.max(0.0)).sqrt()
}

/// Positions of the circle, without a pattern.
fn positions(count: usize) -> impl Iterator<Item = [f64; 2]> {
    (0..count).map(|k| [0.618_034, 0.754_878].map(|step| ((k as f64 + 0.5) * step).fract() * 0.25))
}

#[test]
fn condition_does_not_depend_on_the_cut() {
    let count = if std::env::var_os("FORMS_SWEEPS").is_some() { 1000 } else { 40 };
    let worst = |remedy: Remedy, count: usize| {
        positions(count).map(|shift| condition(&matrix(8, 1, shift, -1.0, remedy))).fold(0.0, f64::max)
    };
    let found = [Remedy::Penalty(0.1), Remedy::Aggregates].map(|remedy| worst(remedy, count));
    let without = worst(Remedy::Penalty(0.0), 40);
    let (size, a) = fitted_matrix(-1.0);
    let fitted = condition(&(size, a));
    println!(
        "worst condition of {count} positions {found:.0?}, fitted with {size} unknowns {fitted:.0}, of 40 without a remedy {without:.1e}"
    );
    assert!(found.iter().all(|worst| *worst < 10.0 * fitted), "{found:?} {fitted}");
    assert!(without > 1e4, "{without}");
}

#[test]
fn symmetric_variant_is_positive_with_a_remedy_only() {
    let least = |degree: usize, shift: [f64; 2], remedy: Remedy| {
        let (size, a) = matrix(8, degree, shift, 1.0, remedy);
        for i in 0..size {
            for j in 0..i {
                assert!((a[i * size + j] - a[j * size + i]).abs() < 1e-10);
            }
        }
        let eigen = SymmetricEigen::of(size, &a).unwrap();
        eigen.values.iter().copied().fold(f64::MAX, f64::min)
    };
    let worst =
        |degree, remedy| positions(12).map(|shift| least(degree, shift, remedy)).fold(f64::MAX, f64::min);
    let (penalty, aggregates) = (Remedy::Penalty(0.1), Remedy::Aggregates);
    let with =
        [(1, penalty), (2, penalty), (1, aggregates), (2, aggregates)].map(|(k, remedy)| worst(k, remedy));
    let without = worst(1, Remedy::Penalty(0.0));
    println!("least eigenvalues: {with:.4?}, without a remedy {without:.3}");
    assert!(with.iter().all(|least| *least > 0.0) && without < 0.0, "{with:?}, {without}");
}

#[test]
fn polynomials_are_reproduced() {
    for degree in [1, 2] {
        for theta in [-1.0, 0.0, 1.0] {
            for ghost in [0.1, 0.3] {
                let mesh = square(8);
                let body = cut(&mesh, |x| (x[0] - 0.013).hypot(x[1] + 0.021) - 0.7);
                let space = Space::vector(&mesh, degree).unwrap();
                let mut held = Constraints::new(&space);
                body.cut().unwrap().hold_outside(&mut held).unwrap();
                let bend = if degree == 2 { 1.0 } else { 0.0 };
                let exact = move |x: &[f64; 2]| {
                    [0.3 * x[0] - 0.2 * x[1] + bend * x[0] * x[1], 0.1 + 0.5 * x[1] - bend * x[0] * x[0]]
                };
                // λ = μ = 1: div σ = 2 ∇ div u + Δu, of the quadratic part ∇ div u = (0, 1) and Δu = (0, −2): zero.
                let data = data(theta, degree, ghost)
                    .prescribed(Given::function(exact))
                    .body_force(Given::function(move |_| [0.0, 0.0]));
                let regions = cut_nitsche::regions().gamma_d("all").gamma_n("boundary").gamma_c("all");
                let model = cut_nitsche::Model { data, regions };
                let form = model.without_contact() + model.dirichlet();
                let u = Problem::new(&form, &space).assembler(&body).constrained(&held).solve().unwrap();
                let u = u.into_field();
                let mut worst = 0.0_f64;
                for (node, x) in
                    space.positions().iter().enumerate().filter(|(n, _)| !held.is_prescribed(2 * n))
                {
                    let expected = exact(x);
                    (0..2).for_each(|k| worst = worst.max((u.at_node(node)[k] - expected[k]).abs()));
                }
                assert!(worst < 1e-11, "P{degree} θ = {theta} g₁ = {ghost}: {worst:e}");
            }
        }
    }
}

#[test]
fn positive_theta_without_a_penalty_is_refused() {
    let regions = cut_nitsche::regions();
    let law = |theta, ghost| cut_nitsche::Model { data: data(theta, 1, ghost), regions: regions.clone() };
    assert!(law(1.0, 0.1).check("direct").is_ok() && law(0.0, 0.0).check("direct").is_ok());
    let error = law(1.0, 0.0).check("direct").unwrap_err().to_string();
    assert!(error.contains("`ghost_slopes` is 0; it must be positive where θ > 0"), "{error}");
    assert_eq!(law(1.0, 0.1).contact_region(), "gamma_c");
}
