//! The plans that the compiler chooses, seen in what kernels keep and in where they make blocks.

use toy_backend::contract::*;

use crate::{assert_near, data, gamma_c, omega, signorini};

/// A backend that records how many numbers the kernels keep per node or node pair.
struct Sizes;

impl<const D: usize> Backend<D> for Sizes {
    type Linear = ();
    type Bilinear = [usize; 4];
    type Expression = ();

    fn linear<K: LinearKernel<D>>(_: K) {}
    fn bilinear<K: BilinearKernel<D>>(_: K) -> [usize; 4] {
        let sizes = [
            size_of::<K::Point<f64>>(),
            size_of::<K::Test<f64>>(),
            size_of::<K::Trial<f64>>(),
            size_of::<K::Accumulator<f64>>(),
        ];
        sizes.map(|size| size / size_of::<f64>())
    }
    fn expression<K: ExpressionKernel<D>>(_: K) {}
}

fn sizes<I: Integrals<D>, const D: usize>(form: &Form<D>) -> Vec<[usize; 4]> {
    assert!(form.has_integrals::<I>());
    I::tangent::<Sizes>(form.inputs().constants()).iter().map(|term| term.kernel).collect()
}

/// A backend that keeps the block of a node pair at one point, with ∇φ = e_x on both sides.
struct Finish;

impl Backend<3> for Finish {
    type Linear = ();
    type Bilinear = Vec<f64>;
    type Expression = ();

    fn linear<K: LinearKernel<3>>(_: K) {}
    fn bilinear<K: BilinearKernel<3>>(kernel: K) -> Vec<f64> {
        let cell = kernel.cell(&CellGeometry {
            diameter: 1.0,
            cell_volume: 1.0,
            facet_area: 1.0,
            opposite_diameter: 0.0,
            opposite_volume: 0.0,
        });
        let fields = vec![0.5; K::REQUIREMENTS.field_length];
        let geometry = PointGeometry {
            weight: 1.0,
            position: [0.0; 3],
            normal: [0.0, 1.0, 0.0],
            curvature: 0.0,
            opposite: OppositePoint::none(),
        };
        let point = kernel.point(&cell, &geometry, &fields);
        let basis = Basis { value: 0.0, gradient: [1.0, 0.0, 0.0] };
        let mut sum = K::zero();
        K::pair(
            &mut sum,
            &kernel.test(&point, &basis, &Further::none()),
            &kernel.trial(&point, &basis, &Further::none()),
        );
        kernel.finish(&cell, &sum).as_ref().to_vec()
    }
    fn expression<K: ExpressionKernel<3>>(_: K) {}
}

#[test]
fn constant_coefficients_are_accumulated_and_contact_is_factored() {
    // ∂_k φ_i and w ∂_l φ_j: D factors each, no coefficient at points but the weight, D × D sums.
    let elasticity = signorini::elasticity(&data::<3>(), &omega());
    assert_eq!(sizes::<signorini::elasticity::Kernels, 3>(&elasticity), [[1, 3, 3, 9]]);
    // θ σ_n(v) − γ v·n_y and its like, D factors each, block by block.
    let contact = signorini::contact(&data::<3>(), &gamma_c());
    let [[_, test, trial, sums]] = sizes::<signorini::contact::Kernels, 3>(&contact)[..] else {
        panic!("one integral")
    };
    assert_eq!((test, trial, sums), (3, 3, 9));
    // Another way to see it: the accumulated form's block is made in `finish`, the contact's in `pair`.
    let constants = elasticity.inputs().constants();
    let blocks = <signorini::elasticity::Kernels as Integrals<3>>::tangent::<Finish>(constants);
    // ∇φ = e_x on both sides: (λ + 2μ, μ, μ) on the diagonal.
    let expected = [1.3 + 1.4, 0.0, 0.0, 0.0, 0.7, 0.0, 0.0, 0.0, 0.7];
    assert_eq!(blocks[0].kernel.len(), expected.len());
    for (found, expected) in blocks[0].kernel.iter().zip(expected) {
        assert_near(*found, expected, 1.0);
    }
}
