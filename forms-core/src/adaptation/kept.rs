//! Descriptions that are made at run time and kept until the program ends, each once.
//!
//! Compiled descriptions are constants of the program, and all code refers to them as such. Those of sums are few: they depend on
//! which functions are added and on their places in the sum, but on no data. So a program that adds the same forms in each of its
//! steps keeps no more than one that adds them once.

use std::collections::HashSet;
use std::hash::Hash;
use std::sync::{LazyLock, Mutex, PoisonError};

use crate::degree::DegreeSum;
use crate::form::Integral;
use crate::kernel::{FieldSlot, Requirements};

type Kept<T> = LazyLock<Mutex<HashSet<&'static T>>>;

fn find_or_keep<T: Hash + Eq + ?Sized>(kept: &Kept<T>, value: Box<T>) -> &'static T {
    let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = kept.get(&*value) {
        return known;
    }
    let value: &'static T = Box::leak(value);
    kept.insert(value);
    value
}

/// A text.
pub(crate) fn text(value: String) -> &'static str {
    static KEPT: Kept<str> = Kept::new(Mutex::default);
    find_or_keep(&KEPT, value.into_boxed_str())
}

pub(super) fn requirements(value: Requirements) -> &'static Requirements {
    static KEPT: Kept<Requirements> = Kept::new(Mutex::default);
    find_or_keep(&KEPT, Box::new(value))
}

pub(super) fn integral(value: Integral) -> &'static Integral {
    static KEPT: Kept<Integral> = Kept::new(Mutex::default);
    find_or_keep(&KEPT, Box::new(value))
}

pub(super) fn slots(list: Box<[FieldSlot]>) -> &'static [FieldSlot] {
    static KEPT: Kept<[FieldSlot]> = Kept::new(Mutex::default);
    find_or_keep(&KEPT, list)
}

pub(super) fn degree_sums(list: Box<[DegreeSum]>) -> &'static [DegreeSum] {
    static KEPT: Kept<[DegreeSum]> = Kept::new(Mutex::default);
    find_or_keep(&KEPT, list)
}

pub(super) fn factors(list: Box<[[usize; 3]]>) -> &'static [[usize; 3]] {
    static KEPT: Kept<[[usize; 3]]> = Kept::new(Mutex::default);
    find_or_keep(&KEPT, list)
}

pub(super) fn numbers(list: Box<[usize]>) -> &'static [usize] {
    static KEPT: Kept<[usize]> = Kept::new(Mutex::default);
    find_or_keep(&KEPT, list)
}
