//! The plans that the compiler chooses, seen in what kernels keep and in where they make blocks.

use toy_backend::contract::{self, *};

use crate::{assert_near, data, gamma_c, omega, signorini};

/// Sizes of what the kernels keep, in numbers per node or node pair.
struct Sizes(Vec<[usize; 4]>);

impl<const D: usize> BilinearVisitor<D> for Sizes {
    type Error = ();
    fn visit<K: BilinearKernel<D>>(&mut self, _: &Integral, _: &K) -> Result<(), ()> {
        self.0.push([
            size_of::<K::Point<f64>>() / 8,
            size_of::<K::Test<f64>>() / 8,
            size_of::<K::Trial<f64>>() / 8,
            size_of::<K::Accumulator<f64>>() / 8,
        ]);
        Ok(())
    }
}

fn sizes<const D: usize>(form: &impl contract::Form<D>) -> Vec<[usize; 4]> {
    let mut sizes = Sizes(vec![]);
    contract::Form::tangent(form, &mut sizes).expect("nothing fails here");
    sizes.0
}

#[test]
fn constant_coefficients_are_accumulated_and_contact_is_factored() {
    // ∂_k φ_i and w ∂_l φ_j: D factors each, no coefficient at points but the weight, D × D sums.
    let elasticity = signorini::elasticity(&data::<3>(), &omega());
    assert_eq!(sizes(&elasticity), [[1, 3, 3, 9]]);
    // θ σ_n(v) − γ v·n_y and its like, D factors each, block by block.
    let contact = signorini::contact(&data::<3>(), &gamma_c());
    let [[_, test, trial, sums]] = sizes(&contact)[..] else { panic!("one integral") };
    assert_eq!((test, trial, sums), (3, 3, 9));
    // Another way to see it: the accumulated form's block is made in `finish`, the contact's in `pair`.
    struct Finish(Vec<Vec<f64>>);
    impl BilinearVisitor<3> for Finish {
        type Error = ();
        fn visit<K: BilinearKernel<3>>(&mut self, _: &Integral, kernel: &K) -> Result<(), ()> {
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
                &kernel.test(&point, &basis, &[[0.0; 3]; 3]),
                &kernel.trial(&point, &basis, &[[0.0; 3]; 3]),
            );
            self.0.push(kernel.finish(&cell, &sum).as_ref().to_vec());
            Ok(())
        }
    }
    let mut finish = Finish(vec![]);
    contract::Form::tangent(&elasticity, &mut finish).expect("nothing fails here");
    // ∇φ = e_x on both sides: (λ + 2μ, μ, μ) on the diagonal.
    let expected = [1.3 + 1.4, 0.0, 0.0, 0.0, 0.7, 0.0, 0.0, 0.0, 0.7];
    for (found, expected) in finish.0[0].iter().zip(expected) {
        assert_near(*found, expected, 1.0);
    }
}
