//! The patch test while bodies slide: a block on a longer layer, which is loaded by the same pressure where the block does not cover it,
//! has one pressure everywhere, wherever the block is.

use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

const LAMBDA: f64 = 200.0 * 0.3 / (1.3 * 0.4);
const MU: f64 = 200.0 / 2.6;
/// γ, above the bound of θ = 1 for degree 2: 9 (λ + 2μ)/h with cells of the height h = ¼.
const GAMMA: f64 = 12_000.0;
/// The shortening of block and layer, which are ½ high.
pub const DOWN: f64 = 0.01;

#[forms]
pub mod layers {
    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma: Param,
        theta: Param,
        /// 1 over one surface, 1/2 over both.
        share: Param,
        pressure: Param,
    }
    #[cells]
    pub struct Omega;
    /// The layer's whole surface.
    #[facets]
    pub struct Surface;
    #[pairs]
    pub struct Touch;
    /// The part of the surface that the block covers.
    #[pairs]
    pub struct Cover;

    pub fn stress(u: Vector) -> Tensor {
        lambda * div(u) * I + 2 * mu * eps(u)
    }
    fn bodies(u: Vector, v: Vector) -> Form {
        integral(Omega, inner(stress(u), eps(v))) + integral(Surface, pressure * dot(n, v))
            - integral(Cover(u), pressure * dot(toward, this(v)))
    }
    fn own(u: Vector) -> Vector {
        this(stress(u) * n)
    }
    pub fn nitsche(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let T = -neg_part(dot(own(u), toward) + gamma * gap) * toward;
        let variant = theta / gamma * dot(T - own(u), own(v));
        bodies(u, v) + integral(Touch(u), share * (variant - dot(T, jump(v))))
    }
    pub fn penalty(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        bodies(u, v) + integral(Touch(u), share * neg_part(gamma * gap) * dot(toward, jump(v)))
    }
    /// Nitsche's method with means over own facets.
    fn of_means(u: Vector, v: Vector) -> Scalar {
        let p = neg_part(mean(dot(own(u), toward) + gamma * gap));
        let variant = theta / gamma * (p * mean(dot(toward, own(v))) + dot(mean(own(u)), mean(own(v))));
        share * (p * mean(dot(toward, jump(v))) - variant)
    }
    pub fn facet_means(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        bodies(u, v) + means(Touch(u), 0, of_means(u, v))
    }
    pub fn vertex_means(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        bodies(u, v) + means(Touch(u), 1, of_means(u, v))
    }
    pub fn mean_penalty(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        bodies(u, v) + means(Touch(u), 0, share * neg_part(gamma * mean(gap)) * mean(dot(toward, jump(v))))
    }
    pub fn multiplier(u: Unknown<Vector>, m: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        bodies(u, v)
            - integral(Touch(u), this(m) * dot(toward, jump(v)))
            - integral(Touch(u), (this(m) + neg_part(this(m) + gamma * gap)) * this(q) / gamma)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    Nitsche(f64),
    /// The same with means over own facets, of degree 0 and 1.
    FacetMeans(f64),
    VertexMeans(f64),
    Penalty,
    MeanPenalty,
    Multiplier,
}

impl Method {
    /// With means as many as a displacement of a degree takes.
    pub fn of_means(theta: f64, degree: usize) -> Self {
        if degree == 1 { Method::FacetMeans(theta) } else { Method::VertexMeans(theta) }
    }

    /// The form of all methods but that with a multiplier.
    pub fn form<const D: usize>(self, model: &layers::Model<D>) -> Form<D>
    where
        Dim: Dimension<D>,
    {
        match self {
            Method::FacetMeans(_) => model.facet_means(),
            Method::VertexMeans(_) => model.vertex_means(),
            Method::Penalty => model.penalty(),
            Method::MeanPenalty => model.mean_penalty(),
            Method::Nitsche(_) | Method::Multiplier => model.nitsche(),
        }
    }
}

/// A layer of length 3 and a block of length 2 on it.
pub fn bodies(shape: CellShape, cells: [usize; 2]) -> Mesh<2> {
    sloped_bodies(shape, cells, 0.0)
}

/// A place or vector that is turned by an angle.
fn turned(angle: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sine, cosine) = angle.sin_cos();
    [cosine * x - sine * y, sine * x + cosine * y]
}

/// The layer and the block, turned by an angle.
fn sloped_bodies(shape: CellShape, cells: [usize; 2], angle: f64) -> Mesh<2> {
    let body = |count: usize, length: f64, low: f64| {
        let place = |[s, t]: [f64; 2]| turned(angle, [length * s, low + 0.5 * t]);
        structured([count, 2], shape, 1, place).unwrap()
    };
    let (layer, block) = (body(cells[0], 3.0, -0.5), body(cells[1], 2.0, 0.0));
    Mesh::of_bodies(&[("layer", &layer), ("block", &block)]).unwrap()
}

pub fn pressure_of(method: Method) -> f64 {
    let soft = if matches!(method, Method::Penalty | Method::MeanPenalty) { 1.0 / GAMMA } else { 0.0 };
    DOWN / (1.0 / (LAMBDA + 2.0 * MU) + soft)
}

/// The data of a method over one surface or both.
pub fn data_of<const D: usize>(method: Method, pairing: &Pairing) -> layers::Data<D> {
    let theta = match method {
        Method::Nitsche(theta) | Method::FacetMeans(theta) | Method::VertexMeans(theta) => theta,
        _ => 0.0,
    };
    let share = if pairing.surfaces.len() == 2 { 0.5 } else { 1.0 };
    layers::data().lambda(LAMBDA).mu(MU).gamma(GAMMA).theta(theta).share(share).pressure(pressure_of(method))
}

/// The forms of a method, and a displacement with the block moved by (`aside`, `up`). The nodes of the interface belong to two bodies: the
/// block's are moved by its cells.
pub fn layers_of(
    mesh: &Mesh<2>,
    method: Method,
    pairing: &Pairing,
    (u, aside, up): (&Field<2>, f64, f64),
) -> (layers::Model<2>, Field<2>) {
    let data = data_of(method, pairing);
    let regions = layers::Regions::default()
        .surface("layer top")
        .touch(pairing.clone().at(PairQuadrature::Pieces))
        .cover(Pairing::onto("layer top", "block bottom").at(PairQuadrature::Pieces));
    let space = u.space();
    let mut moved = vec![false; space.unknowns()];
    let mut values = u.values().to_vec();
    for cell in mesh.cell_region("block").unwrap() {
        for node in space.cell_nodes(*cell as usize) {
            let first = 2 * *node as usize;
            if !std::mem::replace(&mut moved[first], true) {
                values[first] += aside;
                values[first + 1] += up;
            }
        }
    }
    (layers::Model { data, regions }, Field::from_values(space, values).unwrap())
}

/// The largest error of the stress in the cells, the sideways force on the layer, both as parts of the pressure, and Newton's steps, with an
/// interface that is turned by an angle.
fn errors(
    (mesh, angle): (&Mesh<2>, f64),
    degree: usize,
    method: Method,
    pairing: &Pairing,
    offset: f64,
) -> (f64, f64, usize) {
    let space = Space::vector(mesh, degree).unwrap();
    let mut held = Constraints::new(&space);
    let (along, up) = (turned(angle, [1.0, 0.0]), turned(angle, [0.0, 1.0]));
    held.fix("layer bottom", |_| [0.0; 2]).unwrap();
    held.fix("block top", |_| turned(angle, [offset, -DOWN])).unwrap();
    for side in ["left", "right"] {
        held.slide(&format!("layer {side}"), |_| along, |_| 0.0).unwrap();
        held.slide(&format!("block {side}"), |_| along, |_| offset).unwrap();
    }
    let [aside, above] = turned(angle, [offset, -1e-3]);
    let (model, start) = layers_of(mesh, method, pairing, (&Field::zero(&space), aside, above));
    let pressure = pressure_of(method);
    let options = NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() };
    let (u, steps) = match method {
        Method::Multiplier => {
            let traces = Space::on_facets(mesh, "block bottom", degree).unwrap();
            let none = Field::interpolate(&traces, |_| -0.1).unwrap();
            let problem = Problem::new(&model.multiplier(), [&space, &traces]);
            let mut problem = problem.constrained(&held).options(options).start([&start, &none]);
            let solved = problem.solve().unwrap_or_else(|error| panic!("{method:?} {offset}: {error}"));
            (solved.fields[0].clone(), solved.iterations())
        }
        _ => {
            let form = method.form(&model);
            let mut problem = Problem::new(&form, &space).constrained(&held).options(options).start(&start);
            let solved = problem.solve().unwrap_or_else(|error| panic!("{method:?} {offset}: {error}"));
            (solved.field().clone(), solved.iterations())
        }
    };
    let assembler = Assembler::new(mesh);
    let stress = assembler.at_quadrature_points(&model.stress(&u), Entity::Cells, "all", 2).unwrap();
    // Along and across the interface, whose traction is that of the pressure.
    let traction = |value: &Vec<f64>| {
        let force: [f64; 2] = std::array::from_fn(|k| value[2 * k] * up[0] + value[2 * k + 1] * up[1]);
        [along, up].map(|axis| axis[0] * force[0] + axis[1] * force[1])
    };
    let largest = |of: &dyn Fn([f64; 2]) -> f64| {
        stress.values.iter().map(|value| of(traction(value)).abs()).fold(0.0, f64::max) / pressure
    };
    let (shear, normal) = (largest(&|[shear, _]| shear), largest(&|[_, normal]| normal + pressure));
    (shear.max(normal), shear, steps)
}

const OFFSETS: [f64; 7] = [0.0, 0.137, 0.25, 0.401, 0.5, 0.77, 0.93];

pub fn pairings() -> [Pairing; 3] {
    let (layer, block) = ("layer top", "block bottom");
    [Pairing::between(layer, block), Pairing::onto(layer, block), Pairing::onto(block, layer)]
}

/// All methods that a displacement of a degree takes.
pub fn methods(degree: usize) -> Vec<Method> {
    let of_theta = |theta| [Method::Nitsche(theta), Method::of_means(theta, degree)];
    let nitsche = [-1.0, 0.0, 1.0].into_iter().flat_map(of_theta);
    nitsche.chain([Method::Penalty, Method::MeanPenalty, Method::Multiplier]).collect()
}

/// All laws, degrees and cells: rounding on segments, per cent on whole facets.
#[test]
fn pressure_is_constant_while_bodies_slide() {
    println!("| cells | degree | law | surfaces | largest error | shear | steps |");
    for (shape, degree, cells) in [
        (CellShape::Quadrilateral, 1, [9, 8]),
        (CellShape::Quadrilateral, 2, [6, 5]),
        (CellShape::Triangle, 1, [6, 10]),
        (CellShape::Triangle, 2, [9, 4]),
    ] {
        let mesh = bodies(shape, cells);
        for method in methods(degree) {
            for pairing in pairings() {
                // Multipliers of what is not covered would be free.
                if method == Method::Multiplier && pairing.surfaces[0].own != "block bottom" {
                    continue;
                }
                let all = OFFSETS.map(|offset| errors((&mesh, 0.0), degree, method, &pairing, offset));
                let most = |of: fn(&(f64, f64, usize)) -> f64| all.iter().map(of).fold(0.0, f64::max);
                let [stress, shear, steps] = [most(|e| e.0), most(|e| e.1), most(|e| e.2 as f64)];
                println!(
                    "| {shape:?} | {degree} | {method:?} | {pairing} | {stress:.1e} | {shear:.1e} | {steps} |"
                );
                let tolerance = if degree == 1 { 1e-12 } else { 1e-11 };
                assert!(stress < tolerance, "{shape:?} {degree} {method:?} {pairing}: {stress:e}");
            }
        }
    }
}

/// The same on an interface that is sloped, with cells 3 : 4 and 2 : 5, at 20 offsets.
#[test]
fn pressure_is_constant_while_bodies_slide_along_a_slope() {
    for (shape, degree, cells) in [
        (CellShape::Quadrilateral, 1, [9, 8]),
        (CellShape::Quadrilateral, 2, [6, 10]),
        (CellShape::Triangle, 1, [6, 10]),
        (CellShape::Triangle, 2, [9, 8]),
    ] {
        let mesh = sloped_bodies(shape, cells, 0.4);
        for method in methods(degree) {
            let [both, _, block] = pairings();
            let pairing = if method == Method::Multiplier { block } else { both };
            let offsets = (0..20).map(|k| 0.05 * f64::from(k));
            let all = offsets.map(|offset| errors((&mesh, 0.4), degree, method, &pairing, offset));
            let [stress, shear] =
                all.fold([0.0_f64; 2], |most, found| [most[0].max(found.0), most[1].max(found.1)]);
            println!("{shape:?} {degree} {method:?}: {stress:.1e}, shear {shear:.1e}");
            let tolerance = if degree == 1 { 1e-12 } else { 1e-11 };
            assert!(stress < tolerance, "{shape:?} {degree} {method:?}: {stress:e}");
        }
    }
}

/// Systems condensed to what contact touches have the solutions of whole tangents.
#[test]
fn condensed_systems_have_the_same_solutions() {
    let mesh = bodies(CellShape::Quadrilateral, [9, 8]);
    let space = Space::vector(&mesh, 2).unwrap();
    let pairing = &pairings()[0];
    let start = Field::interpolate(&space, |x| [0.0, 1e-3 * (3.0 * x[0]).sin()]).unwrap();
    let (model, start) = layers_of(&mesh, Method::Nitsche(0.0), pairing, (&start, 0.31, -0.01));
    let mut held = Constraints::new(&space);
    held.fix("layer bottom", |_| [0.0; 2]).unwrap();
    held.fix("block top", |x| [0.31, -DOWN - 2e-3 * x[0]]).unwrap();
    let form = model.nitsche();
    let solve = |solver: &mut dyn LinearSolver| {
        let options = NewtonOptions { relative_tolerance: 1e-12, ..NewtonOptions::default() };
        let problem = Problem::new(&form, &space).constrained(&held).start(&start).solver(solver);
        let solved = problem.options(options).solve().unwrap();
        println!("{} steps", solved.iterations());
        (solved.iterations(), solved.into_field())
    };
    let (taken, one) = solve(&mut LuSolver::default());
    let (also, other) = solve(&mut CondensedSolver::default());
    let pairs = one.values().iter().zip(other.values());
    let difference = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(difference < 1e-12 && taken == also && taken <= 7, "{difference:e} {taken} {also}");
}
