//! Random numbers for everything that a form can read.

use crate::check::CheckedFunction;
use crate::parse::syntax::{MemberKind, Module};
use crate::reference::{Jet, ORDERS, Point};

/// Steele, Lea, Flood (2014): SplitMix64.
#[derive(Clone)]
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [−1, 1).
    pub fn number(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Uniform in [0.5, 1.5): lengths, areas, weights.
    pub fn positive(&mut self) -> f64 {
        1.0 + 0.5 * self.number()
    }

    pub fn numbers(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.number()).collect()
    }

    /// Quantities that move with the shape rely on the length of a normal.
    fn unit_vector(&mut self, dimension: usize) -> Vec<f64> {
        let mut vector = self.numbers(dimension);
        let length = vector.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        vector.iter_mut().for_each(|entry| *entry /= length);
        vector
    }

    /// A field with symmetric higher derivatives, and any means.
    pub fn jet(&mut self, components: usize, dimension: usize) -> Jet {
        let mut jet: Jet =
            (0..=ORDERS as u32).map(|order| self.numbers(components * dimension.pow(order))).collect();
        for (order, numbers) in jet.iter_mut().enumerate() {
            let directions = dimension.pow(order as u32);
            for entry in 0..numbers.len() {
                // The entry with ascending directions is everyone's.
                let (component, mut rest) = (entry / directions, entry % directions);
                let mut axes = Vec::new();
                for _ in 0..order {
                    axes.push(rest % dimension);
                    rest /= dimension;
                }
                axes.sort_unstable();
                let sorted = axes.iter().fold(0, |index, axis| index * dimension + axis);
                numbers[entry] = numbers[component * directions + sorted];
            }
        }
        jet.extend([0, 1].map(|order| self.numbers(components * dimension.pow(order))));
        jet
    }
}

/// Σ c_a φ e_a: a vector of basis functions with these coefficients.
pub fn combination(basis: &Jet, coefficients: &[f64]) -> Jet {
    let spread = |numbers: &Vec<f64>| {
        coefficients
            .iter()
            .flat_map(|coefficient| numbers.iter().map(move |entry| coefficient * entry))
            .collect()
    };
    basis.iter().map(spread).collect()
}

/// Points of one cell with their quadrature weights: parameters and the cell's geometry are the same at all.
pub fn points(
    module: &Module,
    checked: &CheckedFunction,
    count: usize,
    random: &mut Random,
) -> Vec<(f64, Point)> {
    let dimension = checked.dimension;
    let members = module.members();
    let parameters: Vec<Vec<f64>> = members
        .map(|member| match member.kind {
            MemberKind::Param => random.numbers(member.rank.shape(dimension).iter().product()),
            MemberKind::Given | MemberKind::Carried | MemberKind::History | MemberKind::Table => vec![],
        })
        .collect();
    let facet_area = random.positive();
    let [diameter, cell_volume] = [(); 2].map(|()| [(); 2].map(|()| random.positive()));
    (0..count)
        .map(|_| {
            let mut fields = || {
                let shapes = checked.fields.iter().map(|field| &field.shape);
                shapes.map(|shape| random.jet(shape.iter().product(), dimension)).collect()
            };
            let point = Point {
                fields: [fields(), fields()],
                parameters: parameters.clone(),
                position: random.numbers(dimension),
                normal: random.unit_vector(dimension),
                curvature: random.number(),
                diameter,
                cell_volume,
                facet_area,
            };
            (random.positive(), point)
        })
        .collect()
}
