//! Functions written in Rust and tabulated laws: against the same things written in the language, closed forms and
//! differences, one lane and four.

mod spectral;

use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::lanes::Four;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{Nodal, energy, expression, functional, residual, tangent};

/// (1 + k |g|²) g where |g|² is above k, else g (1 + |g|⁴): an `if` and a loop.
pub fn flux<R: Real, const D: usize>(g: [R; D], k: R) -> [R; D] {
    let mut square = R::zero();
    for component in g {
        square += component * component;
    }
    let factor = if square > k { k * square + 1.0 } else { square * square + 1.0 };
    g.map(|component| factor * component)
}

/// The neo-Hookean energy of `hyperelastic` in energies.rs.
pub fn psi<R: Real, const D: usize>(f: [[R; D]; D], mu: R, lambda: R) -> R {
    let squares: R = f.iter().flatten().map(|entry| *entry * *entry).sum();
    let logarithm = determinant(f).ln();
    mu / 2.0 * (squares - D as f64) - mu * logarithm + lambda / 2.0 * logarithm.powi(2)
}

/// By Gauss's elimination.
fn determinant<R: Real, const D: usize>(mut a: [[R; D]; D]) -> R {
    let mut product = R::one();
    for pivot in 0..D {
        product *= a[pivot][pivot];
        for row in pivot + 1..D {
            let factor = a[row][pivot] / a[pivot][pivot];
            let upper = a[pivot];
            for (entry, upper) in a[row].iter_mut().zip(upper) {
                *entry -= factor * upper;
            }
        }
    }
    product
}

mod laws {
    use super::Real;

    pub fn softened<R: Real>(s: R) -> R {
        if s > 0.1 { (s * 2.0).exp() } else { s.sin() + 1.0 }
    }
    pub mod tensors {
        use super::Real;
        pub fn stress<R: Real, const D: usize>(e: [[R; D]; D], b: [R; D]) -> [[R; D]; D] {
            std::array::from_fn(|i| std::array::from_fn(|j| e[i][j] * e[j][i] * b[i] + e[i][i]))
        }
    }
}

#[forms(crate = toy_backend, matrix_free)]
pub mod outside {
    pub struct Data {
        mu: Param,
        lambda: Param,
        b: Param<Vector>,
        law: Table,
        straight: Table,
    }
    #[cells]
    pub struct Omega;

    extern "Rust" {
        fn flux(g: Vector, k: Scalar) -> Vector;
        fn psi(F: Tensor, mu: Scalar, lambda: Scalar) -> Scalar;
        #[at(super::laws::softened)]
        fn softened(s: Scalar) -> Scalar;
        #[at(laws::tensors::stress)]
        fn stress(e: Tensor, b: Vector) -> Tensor;
    }

    pub fn diffusion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flux(grad(u), 0.05 + u * u), grad(v)) + softened(u) * v)
    }
    pub fn energy(u: Unknown<Vector>) -> Energy {
        integral(Omega, psi(I + grad(u), mu, lambda))
    }
    pub fn piola(u: Vector) -> Tensor {
        let F = I + grad(u);
        diff(psi(F, mu, lambda), F)
    }
    /// Second derivatives in the form, third ones in its tangent.
    pub fn stiffness(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let F = I + grad(u);
        let C = diff(diff(psi(F, mu, lambda), F), F);
        integral(Omega, dot(b, v) * inner(outer(b, b), C[0][0]))
    }
    pub fn by_parameter(u: State<Vector>) -> Functional {
        derivative(integral(Omega, psi(I + grad(u), mu, lambda)), mu, 2)
    }
    pub fn elastic(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(eps(u), b), grad(v)))
    }
    /// The factor is known with the parameters, and on each cell.
    pub fn linear(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, softened(mu) * law(lambda) * u * v + softened(h) * law(h) * v)
    }
    pub fn tabulated(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, law(u) * dot(grad(u), grad(v)) + straight(u) * v)
    }
    pub fn stored(u: Unknown<Scalar>) -> Energy {
        integral(Omega, law(u) + straight(law(u)))
    }
    pub fn gradient_of_law(u: Scalar) -> Vector {
        grad(law(u) * softened(u))
    }
}

/// The same without anything outside; `straight` is 2 − 3 s.
#[forms(crate = toy_backend)]
pub mod inside {
    pub struct Data {
        mu: Param,
        lambda: Param,
        b: Param<Vector>,
    }
    #[cells]
    pub struct Omega;

    fn flux(g: Vector, k: Scalar) -> Vector {
        let square = dot(g, g);
        if square > k { (k * square + 1) * g } else { (square * square + 1) * g }
    }
    fn psi(F: Tensor) -> Scalar {
        let J = det(F);
        mu / 2 * (inner(F, F) - D) - mu * ln(J) + lambda / 2 * pow(ln(J), 2)
    }
    fn softened(s: Scalar) -> Scalar {
        if s > 0.1 { exp(2 * s) } else { sin(s) + 1 }
    }
    pub fn diffusion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flux(grad(u), 0.05 + u * u), grad(v)) + softened(u) * v)
    }
    pub fn energy(u: Unknown<Vector>) -> Energy {
        integral(Omega, psi(I + grad(u)))
    }
    pub fn piola(u: Vector) -> Tensor {
        let F = I + grad(u);
        diff(psi(F), F)
    }
    pub fn stiffness(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let F = I + grad(u);
        let C = diff(diff(psi(F), F), F);
        integral(Omega, dot(b, v) * inner(outer(b, b), C[0][0]))
    }
    pub fn by_parameter(u: State<Vector>) -> Functional {
        derivative(integral(Omega, psi(I + grad(u))), mu, 2)
    }
    pub fn linear(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, softened(mu) * u * v)
    }
    pub fn straight(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (2 - 3 * u) * v)
    }
}

const MU: f64 = 0.6;
const LAMBDA: f64 = 1.7;

fn b<const D: usize>() -> [f64; D] {
    std::array::from_fn(|i| 0.3 - 0.45 * i as f64)
}

fn law() -> Result<Table, TableError> {
    Table::natural_spline(&[[-1.0, 0.5], [-0.1, 1.0], [0.1, 1.3], [0.2, 2.0], [2.0, 3.0]])
}

fn data<const D: usize>() -> Result<(outside::Data<D>, inside::Data<D>), TableError> {
    let straight = Table::linear(&[[-1.0, 5.0], [0.0, 2.0], [4.0, -10.0]])?;
    let outside = outside::data().mu(MU).lambda(LAMBDA).b(b()).law(law()?).straight(straight);
    Ok((outside, inside::data().mu(MU).lambda(LAMBDA).b(b())))
}

struct State<const D: usize> {
    mesh: Mesh<D>,
    u: [Nodal; 1],
    s: [Nodal; 1],
}

impl<const D: usize> State<D> {
    fn new(seed: u64) -> Self {
        let mut random = Random(seed);
        let mesh = Mesh::<D>::cube(&mut random);
        let nodes = mesh.nodes.len();
        State { u: [random.field(nodes, D, 0.1, 0.25)], s: [random.field(nodes, 1, 0.15, 0.4)], mesh }
    }

    /// Residual and tangent of two forms agree, and those by four lanes with those by one.
    fn agree(&self, first: &Form<D>, second: &Form<D>, unknowns: &[Nodal]) {
        let one = residual::<f64, D>(&self.mesh, first, unknowns);
        close(&one, &residual::<f64, D>(&self.mesh, second, unknowns), 1e-12, first.name());
        let matrix = tangent::<f64, D>(&self.mesh, first, unknowns).concat();
        let other = tangent::<f64, D>(&self.mesh, second, unknowns).concat();
        close(&matrix, &other, 1e-11, first.name());
        self.lanes(first, unknowns);
    }

    /// Four lanes give what one gives.
    fn lanes(&self, form: &Form<D>, unknowns: &[Nodal]) {
        let one = residual::<f64, D>(&self.mesh, form, unknowns);
        close(&residual::<Four, D>(&self.mesh, form, unknowns), &one, 1e-14, form.name());
        let one = tangent::<f64, D>(&self.mesh, form, unknowns).concat();
        close(&tangent::<Four, D>(&self.mesh, form, unknowns).concat(), &one, 1e-14, form.name());
    }

    /// The tangent is the difference quotient of the residual.
    fn differences(&self, form: &Form<D>, unknowns: &[Nodal; 1]) {
        let matrix = tangent::<f64, D>(&self.mesh, form, unknowns);
        let step = 1e-6;
        for column in 0..unknowns[0].values.len() {
            let moved = |step: f64| {
                let mut moved = unknowns.clone();
                moved[0].values[column] += step;
                residual::<f64, D>(&self.mesh, form, &moved)
            };
            let (ahead, behind) = (moved(step), moved(-step));
            let slope: Vec<f64> = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * step)).collect();
            let own: Vec<f64> = matrix.iter().map(|row| row[column]).collect();
            close(&own, &slope, 1e-7, form.name());
        }
    }

    /// The residual is the difference quotient of the energy.
    fn of_energy(&self, form: &Energy<D>, unknowns: &[Nodal; 1]) {
        let own = residual::<f64, D>(&self.mesh, form, unknowns);
        let step = 1e-6;
        let moved = |column: usize, step: f64| {
            let mut moved = unknowns.clone();
            moved[0].values[column] += step;
            energy(&self.mesh, form, &moved)
        };
        let slope = |column| (moved(column, step) - moved(column, -step)) / (2.0 * step);
        let slopes: Vec<f64> = (0..own.len()).map(slope).collect();
        close(&own, &slopes, 1e-7, form.name());
    }
}

fn close(a: &[f64], b: &[f64], tolerance: f64, what: &str) {
    assert_eq!(a.len(), b.len());
    let scale = b.iter().fold(1.0_f64, |scale, value| scale.max(value.abs()));
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= tolerance * scale, "{what}: {a} is not {b}");
    }
}

type Outcome = Result<(), TableError>;

fn functions<const D: usize>(seed: u64) -> Outcome
where
    Dim: Dimension<D>,
{
    let state = State::<D>::new(seed);
    let (outer, inner) = data::<D>()?;
    let (omega, same) = (outside::Omega::on("all"), inside::Omega::on("all"));
    state.agree(&outside::diffusion(&outer, &omega), &inside::diffusion(&inner, &same), &state.s);
    state.agree(&outside::energy(&outer, &omega), &inside::energy(&inner, &same), &state.u);
    state.agree(&outside::stiffness(&outer, &omega), &inside::stiffness(&inner, &same), &state.u);
    state.differences(&outside::elastic(&outer, &omega), &state.u);
    state.lanes(&outside::elastic(&outer, &omega), &state.u);

    let energies = [
        energy(&state.mesh, &outside::energy(&outer, &omega), &state.u),
        energy(&state.mesh, &inside::energy(&inner, &same), &state.u),
    ];
    assert!((energies[0] - energies[1]).abs() < 1e-13);
    let source = || state.u[0].source::<D>();
    let by_parameter = [
        functional(&state.mesh, &outside::by_parameter(&outer, &omega, source())),
        functional(&state.mesh, &inside::by_parameter(&inner, &same, source())),
    ];
    assert!((by_parameter[0] - by_parameter[1]).abs() < 1e-13);
    let all = (Entity::Cells, "all");
    let stresses = [
        expression(&state.mesh, &outside::piola(&outer, source()), all).concat(),
        expression(&state.mesh, &inside::piola(&inner, source()), all).concat(),
    ];
    close(&stresses[0], &stresses[1], 1e-13, "piola");

    // softened(μ) law(λ): known with the form.
    let outer_matrix = tangent::<f64, D>(&state.mesh, &outside::linear(&outer, &omega), &state.s).concat();
    let inner_matrix = tangent::<f64, D>(&state.mesh, &inside::linear(&inner, &same), &state.s).concat();
    let scaled: Vec<f64> = inner_matrix.iter().map(|entry| entry * outer.law.value(LAMBDA)).collect();
    close(&outer_matrix, &scaled, 1e-14, "linear");
    state.lanes(&outside::linear(&outer, &omega), &state.s);
    Ok(())
}

#[test]
fn functions_in_rust_agree_with_the_language() -> Outcome {
    functions::<2>(3)?;
    functions::<3>(4)
}

#[test]
fn an_energy_in_rust_has_a_symmetric_tangent() -> Outcome {
    let form = outside::energy(&data::<3>()?.0, &outside::Omega::on("all"));
    let is_right = |integral: &Integral| integral.symmetric && integral.dependence == Dependence::Nonlinear;
    assert!(!form.tangent().is_empty() && form.tangent().iter().all(|term| is_right(term.integral)));
    Ok(())
}

#[test]
fn constant_arguments_leave_an_integral_linear() -> Outcome {
    let form = outside::linear(&data::<2>()?.0, &outside::Omega::on("all"));
    let found: Vec<_> = form.residual().iter().map(|term| term.integral.dependence).collect();
    assert_eq!(found, [Dependence::Constant, Dependence::Linear]);
    Ok(())
}

#[test]
fn tables_are_laws_with_derivatives() -> Outcome {
    let state = State::<2>::new(5);
    let (outer, inner) = data::<2>()?;
    let (omega, same) = (outside::Omega::on("all"), inside::Omega::on("all"));
    let tabulated = outside::tabulated(&outer, &omega);
    state.differences(&tabulated, &state.s);
    state.lanes(&tabulated, &state.s);
    let stored = outside::stored(&outer, &omega);
    state.of_energy(&stored, &state.s);
    state.differences(&stored, &state.s);
    state.lanes(&stored, &state.s);

    // Without a gradient only the straight law is left.
    let constant = [Nodal { components: 1, values: vec![0.7; state.mesh.nodes.len()] }];
    let found = residual::<f64, 2>(&state.mesh, &tabulated, &constant);
    let expected = residual::<f64, 2>(&state.mesh, &inside::straight(&inner, &same), &constant);
    close(&found, &expected, 1e-14, "straight");

    let all = (Entity::Cells, "all");
    let gradient = expression(&state.mesh, &outside::gradient_of_law(&outer, state.s[0].source::<2>()), all);
    let mut points = gradient.iter();
    for element in state.mesh.elements(Entity::Cells, "all") {
        for point in &element.points {
            let value = |field: &dyn Fn(&Basis<f64, 2>) -> f64| -> f64 {
                element.nodes.iter().zip(&point.basis).map(|(n, b)| field(b) * state.s[0].values[*n]).sum()
            };
            let s = value(&|basis| basis.value);
            let law = outer.law.clone();
            let product = |s: f64| law.value(s) * laws::softened(s);
            let slope = (product(s + 1e-6) - product(s - 1e-6)) / 2e-6;
            let expected = [0, 1].map(|axis| slope * value(&|basis| basis.gradient[axis]));
            close(points.next().map_or(&[], |found| found), &expected, 1e-8, "gradient of a law");
        }
    }
    assert_eq!(format!("{:?}", outer.straight), "Table(3 points from -1 to 4)");
    assert!(format!("{tabulated:?}").contains("Table(5 points"));
    Ok(())
}
