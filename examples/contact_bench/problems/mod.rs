//! Problems, a file each.

mod bar;
mod boxes;
mod cattaneo;
mod closing_c;
mod drawn_die;
mod grading;
mod half_ball;
mod half_ring;
mod hertz;
mod lame;
mod obstacle;
mod patch;
mod punch;
mod sliding_parabola;
mod squares;
mod two_balls;
mod wavy;

use crate::posed::Posed;

/// All problems.
pub fn all() -> Vec<Box<dyn Posed>> {
    let mut all: Vec<Box<dyn Posed>> = vec![
        Box::new(patch::Patch),
        Box::new(lame::Rings::Loaded),
        Box::new(lame::Rings::ShrinkFit),
        Box::new(lame::Rings::TightFit),
        Box::new(squares::Squares),
        Box::new(hertz::Line),
        Box::new(two_balls::TwoBalls::OverSoft),
        Box::new(two_balls::TwoBalls::OverHard),
        Box::new(sliding_parabola::SlidingParabola),
        Box::new(punch::Punch::PlaneStress),
        Box::new(punch::Punch::PlaneStrain),
    ];
    all.extend(wavy::PRESSURES.map(|part| -> Box<dyn Posed> { Box::new(wavy::Wavy { part }) }));
    all.push(Box::new(half_ball::HalfBall));
    for scheme in bar::SCHEMES {
        all.extend([1.0, 0.5].map(|courant| -> Box<dyn Posed> { Box::new(bar::Bar { scheme, courant }) }));
    }
    all.push(Box::new(cattaneo::Cattaneo));
    all.push(Box::new(boxes::Boxes));
    all.push(Box::new(drawn_die::DrawnDie::OverDie));
    all.push(Box::new(drawn_die::DrawnDie::OverSlab));
    all.push(Box::new(obstacle::Obstacle));
    all.push(Box::new(closing_c::ClosingC));
    all.push(Box::new(half_ring::HalfRing::Quadrilaterals));
    all.push(Box::new(half_ring::HalfRing::Triangles));
    all
}

/// λ and μ of E and ν in plane strain and in space.
pub fn lame(young: f64, poisson: f64) -> [f64; 2] {
    [young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson))]
}
