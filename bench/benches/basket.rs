//! Times of only our kernels: `cargo bench -p forms-bench`, or with a part of a name, `cargo bench -p forms-bench -- tet_P2`.
//!
//! One call of a symbol computes the element matrices of eight cells that are in the cache.

use divan::Bencher;
use divan::counter::ItemsCount;
use forms_bench::basket::BASKET;
use forms_bench::random_cells::BATCH;

fn main() {
    divan::main();
}

#[divan::bench(args = BASKET.iter().map(|entry| entry.name))]
fn element_matrices(bencher: Bencher, name: &str) {
    let Some(entry) = BASKET.iter().find(|entry| entry.name == name) else { return };
    let mut call = entry.prepare();
    bencher.counter(ItemsCount::new(BATCH)).bench_local(|| {
        divan::black_box(call.run());
    });
}
