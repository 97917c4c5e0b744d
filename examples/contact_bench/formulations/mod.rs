//! Formulations, a file each. A new one is a file and its two lines here; a program of your own needs none.

mod augmented_lagrangian;
mod barrier;
mod bounds;
mod exponential;
mod mean_nitsche;
mod mortar;
mod nitsche;
mod penalty;
mod proximal;
mod third_medium;
mod uzawa;

use contact_bench::Formulation;

/// All formulations, with their variants.
pub fn all() -> Vec<Box<dyn Formulation>> {
    let mut all = vec![];
    add(&mut all, nitsche::all());
    add(&mut all, penalty::all());
    add(&mut all, augmented_lagrangian::all());
    add(&mut all, uzawa::all());
    add(&mut all, mean_nitsche::all());
    add(&mut all, mortar::all());
    add(&mut all, bounds::all());
    add(&mut all, proximal::all());
    add(&mut all, barrier::all());
    add(&mut all, exponential::all());
    add(&mut all, third_medium::all());
    all
}

fn add<F: Formulation + 'static>(all: &mut Vec<Box<dyn Formulation>>, more: Vec<F>) {
    all.extend(more.into_iter().map(|one| -> Box<dyn Formulation> { Box::new(one) }));
}
