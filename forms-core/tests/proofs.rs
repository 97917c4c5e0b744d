//! Properties of a form that the compiler proves: dependence on the unknowns, symmetry, what is constant on a
//! cell, what is zero, degrees. Each flag is seen to flip when the form is perturbed.

use Dependence::{Constant, Linear, Nonlinear};
use forms_core::contract::*;
use forms_core::forms;

#[forms(crate = forms_core)]
pub mod forms_to_judge {
    pub struct Data {
        lambda: Param,
        mu: Param,
        theta: Param,
        gamma0: Param,
        n_y: Param<Vector>,
        wind: Given<Vector>,
        gap: Given<Scalar>,
        f: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaC;

    fn sigma(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
    fn sigma_n(w: Vector) -> Scalar {
        dot(sigma(w) * n, n_y)
    }
    fn gamma() -> Scalar {
        gamma0 / h
    }
    fn pressure(w: Vector) -> Scalar {
        sigma_n(w) - gamma() * (dot(w, n_y) - gap)
    }

    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(sigma(u), eps(v)) - dot(f, v))
    }
    pub fn convected(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) + integral(Omega, dot(grad(u) * wind, v))
    }
    pub fn rotated(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(sigma(u) + skew(grad(u)), grad(v)))
    }
    pub fn half_skew(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(sigma(u) + dot(f, f) * u[0] * I, grad(v)))
    }
    pub fn nitsche(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v) - integral(GammaC, theta / gamma() * sigma_n(u) * sigma_n(v))
    }
    pub fn contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(GammaC, neg_part(pressure(u)) / gamma() * (theta * sigma_n(v) - gamma() * dot(v, n_y)))
    }
    pub fn contact_at_one(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(GammaC, neg_part(pressure(u)) / gamma() * (sigma_n(v) - gamma() * dot(v, n_y)))
    }
    pub fn neo_hooke(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        let J = det(F);
        integral(Omega, mu / 2 * (inner(F, F) - D) - mu * ln(J) + lambda / 2 * pow(ln(J), 2))
    }
    pub fn neo_hooke_by_hand(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let F = I + grad(u);
        let H = transpose(inv(F));
        integral(Omega, inner(mu * (F - H) + lambda * ln(det(F)) * H, grad(v)))
    }
    pub fn vector_laplacian(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, exp(gap) * inner(grad(u), grad(v)))
    }
    /// Saint Venant–Kirchhoff, its stress typed by hand: F (2μ E + λ tr E I).
    pub fn piola_by_hand(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let F = I + grad(u);
        let E = (transpose(F) * F - I) / 2;
        integral(Omega, inner(F * (2 * mu * E + lambda * tr(E) * I), grad(v)))
    }
    pub fn piola_with_a_slip(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let F = I + grad(u);
        let E = (transpose(F) * F - I) / 2;
        integral(Omega, inner((2 * mu * E + lambda * tr(E) * I) * F, grad(v)))
    }

    pub fn load(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, mu * v)
    }
    pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, gap * u * v)
    }
    pub fn square(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, u * u * v)
    }
    pub fn state_square(w: State<Scalar>, u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, w * w * u * v)
    }
    pub fn all_three(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (u * u * v - u * v) / mu + gap * v)
    }
    pub fn affine(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, mu * (u * v + lambda * v))
    }
    /// Looks nonlinear, is not.
    pub fn cancels(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (u * u / mu + 2 * u - u * u / mu) * v)
    }
    pub fn switched(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, if gap > 0 { u * v } else { 2 * u * v })
    }
    pub fn switched_to_a_load(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, if gap > 0 { u * v } else { 2 * v })
    }
    pub fn switched_by_u(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, if u > 0 { u * v } else { 2 * u * v })
    }

    pub fn times_zero(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, mu * v + 0 * u * u * v)
    }
    pub fn minus_itself(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, mu * v + exp(u - u) * v + (u - u) * v + (sin(u) - sin(u)) * dot(grad(u), grad(v)))
    }
    pub fn integrals_cancel(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let once = u * u * v;
        integral(Omega, mu * v) + integral(Omega, once) - integral(Omega, u * v * u)
    }
    /// Known fields only: no unknown can be differentiated.
    pub fn skew_trace(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, dot(f, v) + tr(skew(grad(u))) * div(v))
    }

    pub fn on_the_cell(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, exp(h) * sqrt(cell_volume) * pow(mu, 0.3) * dot(grad(u), grad(v)))
    }
    pub fn at_the_point(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, exp(h) * sqrt(cell_volume) * pow(mu, 0.3) * exp(gap) * dot(grad(u), grad(v)))
    }

    pub fn degrees(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(GammaC, pow(dot(u, u), 2) * dot(v, x))
    }
    pub fn degrees_of_functions(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, exp(u) * v)
    }
    pub fn degree_of_determinant(u: Unknown<Vector>) -> Functional {
        integral(Omega, det(grad(u)))
    }
    pub fn degree_of_kink(u: Unknown<Scalar>) -> Functional {
        integral(Omega, neg_part(u) * heaviside(u) * max(u, 1))
    }
}

/// Everything a backend learns of the integrals of a form, by themselves and of their kernels.
struct Told<K> {
    integrals: Vec<Integral>,
    kernels: Vec<K>,
}

impl<K: Copy> Told<K> {
    fn of(terms: &[Term<K>]) -> Self {
        Told {
            integrals: terms.iter().map(|term| *term.integral).collect(),
            kernels: terms.iter().map(|term| term.kernel).collect(),
        }
    }
}

fn residual<const D: usize>(form: &Form<D>) -> Told<LinearConstants> {
    Told::of(form.residual())
}

fn tangent<const D: usize>(form: &Form<D>) -> Told<BilinearConstants> {
    let told = Told::of(form.tangent());
    for (integral, kernel) in told.integrals.iter().zip(&told.kernels) {
        assert_eq!(integral.symmetric, kernel.symmetric);
    }
    told
}

impl Told<BilinearConstants> {
    /// Products per pair.
    fn products(&self) -> Vec<usize> {
        self.kernels.iter().map(|kernel| kernel.operations.pair).collect()
    }
    /// Which coefficients are constant on the cell.
    fn constant(&self) -> Vec<bool> {
        self.kernels.iter().map(|kernel| kernel.cell_constant).collect()
    }
}

/// A backend that keeps how many numbers a kernel of a tangent keeps per cell, point, and node pair.
struct Sizes;

impl<const D: usize> Backend<D> for Sizes {
    type Linear = ();
    type Bilinear = [usize; 3];
    type Expression = ();

    fn linear<K: LinearKernel<D>>(_: K) {}
    fn bilinear<K: BilinearKernel<D>>(_: K) -> [usize; 3] {
        let sizes = [size_of::<K::Cell<f64>>(), size_of::<K::Point<f64>>(), size_of::<K::Accumulator<f64>>()];
        sizes.map(|size| size / size_of::<f64>())
    }
    fn expression<K: ExpressionKernel<D>>(_: K) {}
}

fn sizes<I: Integrals<D>, const D: usize>(form: &Form<D>) -> Vec<[usize; 3]> {
    assert!(form.has_integrals::<I>());
    I::tangent::<Sizes>(form.inputs().constants()).iter().map(|term| term.kernel).collect()
}

fn dependence<const D: usize>(form: &Form<D>) -> (Vec<Dependence>, Vec<Dependence>) {
    fn of<K>(told: &Told<K>) -> Vec<Dependence> {
        told.integrals.iter().map(|integral| integral.dependence).collect()
    }
    (of(&residual(form)), of(&tangent(form)))
}

fn symmetric<const D: usize>(form: &Form<D>) -> Vec<bool> {
    tangent(form).integrals.iter().map(|integral| integral.symmetric).collect()
}

fn data<const D: usize>() -> forms_to_judge::Data<D> {
    forms_to_judge::data()
        .lambda(1.0)
        .mu(1.0)
        .theta(-1.0)
        .gamma0(1.0)
        .n_y([0.0; D])
        .wind([1.0; D])
        .gap(0.0)
        .f([0.0; D])
}

/// A form of the module by name, in a dimension, with the regions it takes.
macro_rules! form {
    ($name:ident, $d:literal $(, $region:ident)*) => {
        forms_to_judge::$name::<$d>(&data() $(, &forms_to_judge::$region::on("there"))*)
    };
}

#[test]
fn dependence_flips_with_the_form() {
    assert_eq!(dependence(&form!(load, 2, Omega)), (vec![Constant], vec![]));
    assert_eq!(dependence(&form!(mass, 2, Omega)), (vec![Linear], vec![Linear]));
    assert_eq!(dependence(&form!(square, 2, Omega)), (vec![Nonlinear], vec![Nonlinear]));
    assert_eq!(dependence(&form!(elasticity, 3, Omega)), (vec![Constant, Linear], vec![Linear]));
    assert_eq!(dependence(&form!(contact, 3, GammaC)), (vec![Nonlinear], vec![Nonlinear]));
    // On the same cells what is linear goes with what is not: one visit computes both.
    assert_eq!(dependence(&form!(all_three, 3, Omega)), (vec![Constant, Nonlinear], vec![Nonlinear]));
    assert_eq!(dependence(&form!(affine, 2, Omega)), (vec![Constant, Linear], vec![Linear]));
    assert_eq!(dependence(&form!(cancels, 2, Omega)), (vec![Linear], vec![Linear]));
}

#[test]
fn a_state_is_known_and_an_unknown_is_not() {
    let state = Source::Constant(vec![2.0]);
    let form = forms_to_judge::state_square::<2>(&data(), &forms_to_judge::Omega::on("there"), state);
    assert_eq!(dependence(&form), (vec![Linear], vec![Linear]));
    assert_eq!(dependence(&form!(switched, 2, Omega)), (vec![Linear], vec![Linear]));
    assert_eq!(dependence(&form!(switched_by_u, 2, Omega)), (vec![Nonlinear], vec![Nonlinear]));
}

#[test]
fn linear_integrals_vanish_with_the_unknown_unless_a_load_is_in_them() {
    fn of<K>(told: Told<K>) -> Vec<(Dependence, bool)> {
        told.integrals.iter().map(|one| (one.dependence, one.vanishes)).collect()
    }
    assert_eq!(of(residual(&form!(elasticity, 3, Omega))), [(Constant, false), (Linear, true)]);
    assert_eq!(of(residual(&form!(affine, 2, Omega))), [(Constant, false), (Linear, true)]);
    assert_eq!(of(residual(&form!(cancels, 2, Omega))), [(Linear, true)]);
    assert_eq!(of(residual(&form!(switched, 2, Omega))), [(Linear, true)]);
    assert_eq!(of(residual(&form!(switched_to_a_load, 2, Omega))), [(Linear, false)]);
    // Where it vanishes or not, nothing is said of what is not linear, nor of tangents.
    assert_eq!(of(residual(&form!(square, 2, Omega))), [(Nonlinear, false)]);
    assert_eq!(of(tangent(&form!(elasticity, 3, Omega))), [(Linear, false)]);
}

#[test]
fn linear_parts_keep_their_regions() {
    let told = residual(&form!(nitsche, 3, Omega, GammaC));
    let found: Vec<_> = told.integrals.iter().map(|one| (one.region, one.dependence)).collect();
    assert_eq!(found, [(0, Constant), (0, Linear), (1, Linear)]);
}

#[test]
fn symmetry_flips_with_the_form() {
    assert_eq!(symmetric(&form!(elasticity, 2, Omega)), [true]);
    assert_eq!(symmetric(&form!(elasticity, 3, Omega)), [true]);
    assert_eq!(symmetric(&form!(convected, 2, Omega)), [false]);
    assert_eq!(symmetric(&form!(convected, 3, Omega)), [false]);
    // A skew part tested with the gradient is symmetric, an unmatched column is not.
    assert_eq!(symmetric(&form!(rotated, 3, Omega)), [true]);
    assert_eq!(symmetric(&form!(half_skew, 3, Omega)), [false]);
}

#[test]
fn the_linear_part_of_nitsche_is_symmetric_for_every_theta_and_contact_is_not() {
    // θ is a parameter: the proof is for all its values.
    assert_eq!(symmetric(&form!(nitsche, 2, Omega, GammaC)), [true, true]);
    assert_eq!(symmetric(&form!(nitsche, 3, Omega, GammaC)), [true, true]);
    assert_eq!(symmetric(&form!(contact, 2, GammaC)), [false]);
    assert_eq!(symmetric(&form!(contact, 3, GammaC)), [false]);
    assert_eq!(symmetric(&form!(contact_at_one, 2, GammaC)), [true]);
    assert_eq!(symmetric(&form!(contact_at_one, 3, GammaC)), [true]);
}

#[test]
fn energies_are_symmetric_and_stresses_by_hand_are_expanded() {
    assert_eq!(symmetric(&form!(neo_hooke, 2, Omega)), [true]);
    assert_eq!(symmetric(&form!(neo_hooke, 3, Omega)), [true]);
    assert_eq!(symmetric(&form!(piola_by_hand, 2, Omega)), [true]);
    assert_eq!(symmetric(&form!(piola_by_hand, 3, Omega)), [true]);
    assert_eq!(symmetric(&form!(piola_with_a_slip, 2, Omega)), [false]);
    assert_eq!(symmetric(&form!(piola_with_a_slip, 3, Omega)), [false]);
}

#[test]
fn zeros_leave_no_tangent() {
    assert_eq!(dependence(&form!(times_zero, 2, Omega)), (vec![Constant], vec![]));
    assert_eq!(dependence(&form!(minus_itself, 2, Omega)), (vec![Constant], vec![]));
    assert_eq!(dependence(&form!(integrals_cancel, 2, Omega)), (vec![Constant], vec![]));
    assert_eq!(dependence(&form!(skew_trace, 3, Omega)), (vec![Constant], vec![]));
}

#[test]
fn what_is_constant_on_a_cell_is_computed_there() {
    // The factor is one number per cell. It meets the weight at the points, and the block is one sum; or only the weight is
    // kept there and S_kk accumulates, which is a little less where points are many (the factor's degree is a guess).
    assert_eq!(sizes::<forms_to_judge::on_the_cell::Kernels, 3>(&form!(on_the_cell, 3, Omega)), [[1, 1, 3]]);
    assert_eq!(sizes::<forms_to_judge::on_the_cell::Kernels, 2>(&form!(on_the_cell, 2, Omega)), [[1, 1, 1]]);
    // Two moduli: nothing but the weight at points, and the D² sums of products of derivatives. The block's end reads
    // the moduli, and sums of them, from constants of the cell, in all lanes.
    assert_eq!(sizes::<forms_to_judge::elasticity::Kernels, 3>(&form!(elasticity, 3, Omega)), [[3, 1, 9]]);
    assert_eq!(sizes::<forms_to_judge::elasticity::Kernels, 2>(&form!(elasticity, 2, Omega)), [[4, 1, 4]]);
    // With a field in it, the factor times the weight is one number per point, its cell part one per cell.
    assert_eq!(
        sizes::<forms_to_judge::at_the_point::Kernels, 3>(&form!(at_the_point, 3, Omega)),
        [[1, 1, 1]]
    );
}

#[test]
fn blocks_cost_what_their_algebra_needs() {
    // By hand, in D dimensions. A vector Laplacian is one sum of D products, a mass matrix one product; the entries off the
    // diagonal are zero.
    for told in [tangent(&form!(vector_laplacian, 2, Omega)), tangent(&form!(vector_laplacian, 3, Omega))] {
        let d = told.products()[0];
        assert_eq!(told.constant(), [false]);
        let diagonal: Vec<bool> = (0..d * d).map(|entry| entry / d == entry % d).collect();
        assert_eq!(told.kernels[0].nonzero, diagonal);
    }
    let plane = sizes::<forms_to_judge::vector_laplacian::Kernels, 2>(&form!(vector_laplacian, 2, Omega));
    let space = sizes::<forms_to_judge::vector_laplacian::Kernels, 3>(&form!(vector_laplacian, 3, Omega));
    assert_eq!([plane[0][2], space[0][2]], [1, 1]);
    assert_eq!(tangent(&form!(vector_laplacian, 3, Omega)).products(), [3]);
    assert_eq!(tangent(&form!(mass, 3, Omega)).products(), [1]);
    // S_kl: D².
    assert_eq!(tangent(&form!(elasticity, 3, Omega)).products(), [9]);
    assert_eq!(tangent(&form!(elasticity, 3, Omega)).constant(), [true]);
    // neo-Hooke: μ ∇φ·∇φ; then (cof F ∇φ) ⊗ (cof F ∇φ), D², and ∂² det: none on the diagonal, three sums of three in
    // three dimensions, one of two in two.
    assert_eq!(tangent(&form!(neo_hooke, 3, Omega)).products(), [3 + 9 + 9]);
    assert_eq!(tangent(&form!(neo_hooke, 2, Omega)).products(), [2 + 4 + 2]);
    assert_eq!(tangent(&form!(neo_hooke, 3, Omega)).constant(), [false]);
    // Its stress with F⁻ᵀ, all in one integral: the identity's sum and two products per entry.
    assert_eq!(tangent(&form!(neo_hooke_by_hand, 3, Omega)).products(), [3 + 2 * 9]);
    // Contact: σ_n and the pressure once per basis function, then one product per entry.
    assert_eq!(tangent(&form!(contact, 3, GammaC)).products(), [9]);
    assert_eq!(tangent(&form!(nitsche, 3, Omega, GammaC)).products(), [9, 9]);
}

/// The degree of the integral at `index`, for fields of degree 2, a geometry of degree 2.
fn degree<K>(told: &Told<K>, index: usize, simplex: bool) -> usize {
    told.integrals[index].degree.of(&[2; 8], 2, simplex)
}

#[test]
fn degrees_follow_the_integrand() {
    // f·v: 2 + 2; σ : ε: twice 2, and 1 each on simplices.
    let told = residual(&form!(elasticity, 3, Omega));
    assert_eq!([degree(&told, 0, false), degree(&told, 1, false)], [4, 4]);
    assert_eq!([degree(&told, 0, true), degree(&told, 1, true)], [4, 2]);
    // (u·u)² v·x: 8 + 2 + 2.
    assert_eq!(degree(&residual(&form!(degrees, 2, GammaC)), 0, true), 12);
    // exp(u) v: (2 + 2) + 2, as UFL guesses.
    assert_eq!(degree(&residual(&form!(degrees_of_functions, 2, Omega)), 0, true), 6);
    let omega = forms_to_judge::Omega::on("there");
    let form = forms_to_judge::degree_of_determinant::<3>(&data(), &omega);
    assert_eq!(degree(&Told::of(form.densities()), 0, true), 3);
    let form = forms_to_judge::degree_of_determinant::<2>(&data(), &omega);
    assert_eq!(degree(&Told::of(form.densities()), 0, true), 2);
    // Kinks count as what they cut: 2 + 0 + 2.
    let form = forms_to_judge::degree_of_kink::<2>(&data(), &omega);
    assert_eq!(degree(&Told::of(form.densities()), 0, true), 4);
}
