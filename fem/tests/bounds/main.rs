//! Bounds on unknowns: closed forms, derivatives, what bounds combine with and what is refused; quantities that are kept positive.

mod combinations;
mod damage;
mod obstacle;
mod positivity;

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;
