//! Lists of what was found last, with a largest number.

/// Searches that are kept, of the undeformed mesh and of displaced surfaces, and pairings with candidates; the oldest go.
pub(super) const KEPT: usize = 8;

/// Adds to a list with a largest number per kind; the oldest go.
pub(super) fn keep<T>(list: &mut Vec<T>, entry: T, limit: usize, of_this_kind: impl Fn(&T) -> bool) {
    if list.iter().filter(|one| of_this_kind(one)).count() == limit
        && let Some(oldest) = list.iter().position(of_this_kind)
    {
        list.remove(oldest);
    }
    list.push(entry);
}
