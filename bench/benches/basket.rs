//! Our kernels by themselves: `cargo bench -p forms-bench`, or with a part of a name, `cargo bench -p forms-bench -- tet_P2`.
//!
//! One call of a symbol computes the element matrices of eight cells that are in the cache.

use divan::Bencher;
use divan::counter::ItemsCount;
use forms_bench::basket::BASKET;
use forms_bench::random_cells::{BATCH, RandomCells};

fn main() {
    divan::main();
}

#[divan::bench(args = BASKET.iter().map(|entry| entry.name))]
fn element_matrices(bencher: Bencher, name: &str) {
    let Some(entry) = BASKET.iter().find(|entry| entry.name == name) else { return };
    let lengths = (entry.lengths)();
    let cells = RandomCells::new(&entry.setting, lengths.width);
    let mut matrices = vec![0.0; BATCH * lengths.size];
    bencher.counter(ItemsCount::new(BATCH)).bench_local(|| {
        // SAFETY: the arrays are as long as the plugin interface has them for this form.
        unsafe {
            (entry.batch)(
                BATCH as i32,
                matrices.as_mut_ptr(),
                cells.coefficients.as_ptr(),
                cells.constants.as_ptr(),
                cells.coordinates.as_ptr(),
                &0,
            );
        }
        divan::black_box(&mut matrices);
    });
}
