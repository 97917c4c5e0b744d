//! The inf-sup constant of multipliers with the displacements' degree between meshes that do not match: √min eig(B K⁻¹ Bᵀ, h M), which does not
//! fall as the meshes are refined.

use forms_fem::prelude::*;

use crate::exact::nodal;

#[forms(dimension = 2)]
mod glued {
    pub struct Data {
        /// z, and the size of the own cells.
        pub source: Given<Scalar>,
        pub size: Param,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;
    #[facets]
    pub struct Own;

    /// Elastic bodies, E = 1 and ν = 0.3, whose surfaces have the normal distance h z: p = (B K⁻¹ Bᵀ)⁻¹ h M z.
    pub fn balance(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, inner(eps(u) / 1.3 + 0.3 / (1.3 * 0.4) * div(u) * I, eps(v)))
            + integral(Touch, this(p) * dot(toward, jump(v)) + this(q) * dot(toward, jump(u)))
            + integral(Own, size * source * q)
    }
    pub fn product(a: State<Scalar>, b: State<Scalar>) -> Functional {
        integral(Own, a * b)
    }
}

/// By the power method on the inverse.
fn constant(degree: usize, elements: &Elements, [own, other]: [usize; 2]) -> f64 {
    let body = |count: usize, low: f64| {
        let cells = [count, count.div_ceil(2)];
        rectangle([0.0, low], [1.0, low + 0.5], cells, CellShape::Quadrilateral, 1).unwrap()
    };
    let mesh = Mesh::of_bodies(&[("lower", &body(own, 0.0)), ("upper", &body(other, 0.5))]).unwrap();
    let space = Space::vector(&mesh, degree).unwrap();
    let traces = Space::of(&mesh, elements.clone(), Scope::Facets("lower top".into()), &[]).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("lower bottom", |_| [0.0; 2]).unwrap();
    held.fix("upper top", |_| [0.0; 2]).unwrap();
    let assembler = Assembler::new(&mesh);
    let regions =
        glued::Regions::default().touch(Pairing::onto("lower top", "upper bottom")).own("lower top");
    let model = |z: &Field<2>| glued::Model {
        data: glued::data().source(Given::field(z)).size(1.0 / own as f64),
        regions: regions.clone(),
    };
    let product = |a: &Field<2>, b: &Field<2>| assembler.functional(&model(a).product(a, b)).unwrap();
    let mut z = nodal(&traces, |x| [(7.0 * x[0]).sin() + (31.0 * x[0]).cos()]);
    let mut largest = 0.0;
    for _ in 0..60 {
        let size = product(&z, &z).sqrt();
        let unit = z.values().iter().map(|value| value / size).collect();
        z = Field::from_values(&traces, unit).unwrap();
        let form = model(&z).balance();
        let mut problem = Problem::new(&form, [&space, &traces]).constrained(&held).assembler(&assembler);
        let [_, p] = problem.solve().unwrap().fields;
        let found = product(&z, &p).abs();
        let is_settled = (found / largest - 1.0_f64).abs() < 1e-7;
        (z, largest) = (p, found);
        if is_settled {
            break;
        }
    }
    largest.recip().sqrt()
}

/// It stays the same within 2 % from the second refinement on. That of dual functions, which span the same space on each facet, is as large
/// but for some per cent.
#[test]
fn multipliers_are_stable() {
    println!("| degree, functions | own : other | inf-sup constant, refined 1, 2, 4 times |");
    for (degree, elements) in [
        (1, Elements::Bernstein(1)),
        (1, Elements::Dual),
        (2, Elements::Bernstein(2)),
        (2, Elements::DualOfBernstein),
    ] {
        for cells in [[3, 4], [3, 9], [9, 3]] {
            let found = [1, 2, 4].map(|times| constant(degree, &elements, cells.map(|count| count * times)));
            println!("| {degree}, {elements} | {cells:?} | {found:.4?} |");
            let change = (found[2] / found[1] - 1.0).abs();
            assert!(change < 0.02 && found[2] > 0.4, "{degree} {elements} {cells:?}: {found:?}");
        }
    }
}
