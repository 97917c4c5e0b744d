//! Laws whose pressure is a function of the gap: barriers, exponentials, tables. Layers with known answers, tangents, adjoints, derivatives by the shape.

mod barrier;
mod bodies;
mod closures;
mod layer;
