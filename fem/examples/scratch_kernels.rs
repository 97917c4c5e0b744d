use forms_fem::assemble::*;
use forms_fem::element::Lagrange;
use forms_fem::lanes::InstructionSet;
use forms_fem::prelude::*;
use std::time::Instant;

#[forms]
pub mod basket {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub gamma0: Param,
        pub gap: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaC;
    pub fn poisson(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
    }
    pub fn mass(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, dot(u, v))
    }
    fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * div(w) * I
    }
    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
    pub fn neo_hooke(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        let J = det(F);
        integral(Omega, mu / 2 * (inner(F, F) - D) - mu * ln(J) + lambda / 2 * pow(ln(J), 2))
    }
    fn normal_stress(w: Vector) -> Scalar {
        dot(n, (2 * mu * eps(w) + lambda * div(w) * I) * n)
    }
    pub fn nitsche(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let gamma = gamma0 * facet_area / cell_volume;
        let pressure = min(normal_stress(u) - gamma * (dot(u, n) - gap), 0);
        let tested = -normal_stress(v) - gamma * dot(v, n);
        integral(GammaC, normal_stress(u) * normal_stress(v) / gamma + pressure * tested / gamma)
    }
}

fn run<F: Form<D>, S: Sizes, const D: usize>(
    name: &str,
    form: F,
    shape: CellShape,
    degree: usize,
    geometry: usize,
    rule: usize,
    tangent: bool,
    best: f64,
    _s: S,
) {
    let e = Lagrange::new(shape, degree).unwrap();
    let g = Lagrange::new(shape, geometry).unwrap();
    let comps = form.fields()[0].components();
    let n = e.nodes();
    let mut fields = vec![];
    let gap = Lagrange::new(shape, 1).unwrap();
    let stride = n * comps + gap.nodes();
    if form.fields().iter().any(|f| f.name == "u") {
        fields.push(FieldLayout {
            name: "u".into(),
            element: e,
            offsets: (0..n).map(|i| i * comps).collect(),
        });
    }
    if form.fields().iter().any(|f| f.name == "gap") {
        fields.push(FieldLayout {
            name: "gap".into(),
            element: gap,
            offsets: (0..gap.nodes()).map(|i| n * comps + i).collect(),
        });
    }
    let layout = ElementLayout {
        geometry: g,
        element: e,
        coordinate_stride: g.nodes() * 3,
        coordinate_offsets: (0..g.nodes()).map(|i| 3 * i).collect(),
        coefficient_stride: stride,
        fields,
        rows: (0..n * comps).collect(),
    };
    let mut kernel = match ElementKernel::<F, S, D>::with_sizes(form, layout, &Quadrature::Degree(rule)) {
        Ok(k) => k,
        Err(e) => {
            println!("{name}: {e}");
            return;
        }
    };
    let pts = g.node_points::<D>();
    let mut x = vec![0.0; 256 * g.nodes() * 3];
    let mut seed = 1u64;
    let mut rnd = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    for c in 0..256 {
        for i in 0..g.nodes() {
            for a in 0..D {
                x[(c * g.nodes() + i) * 3 + a] = pts[i][a] + 0.02 * rnd();
            }
        }
    }
    let w: Vec<f64> = (0..256 * stride + 64).map(|_| 0.02 * rnd()).collect();
    let size = kernel.size();
    let out = if tangent { size * size } else { size };
    let mut a = vec![0.0; 8 * out];
    let mut call = |k: &mut ElementKernel<F, S, D>| {
        for b in 0..32 {
            let cells = ElementCells {
                count: 8,
                coordinates: &x[b * 8 * g.nodes() * 3..][..8 * g.nodes() * 3],
                coefficients: &w[b * 8 * stride..][..8 * stride],
                facet: 0,
            };
            if tangent { k.matrices(&cells, &mut a).unwrap() } else { k.vectors(&cells, &mut a).unwrap() }
        }
    };
    let mut t_best = f64::MAX;
    for set in [InstructionSet::best()] {
        kernel = kernel.with_instructions(set);
        call(&mut kernel);
        let reps = (2e6 / (best * 256.0) * 4.0) as usize + 1;
        for _ in 0..9 {
            let t = Instant::now();
            for _ in 0..reps {
                call(&mut kernel);
            }
            t_best = t_best.min(t.elapsed().as_nanos() as f64 / reps as f64 / 256.0);
        }
    }
    println!("{name:28} {t_best:9.1} ns, FFCx {best:9.1}, ratio {:6.2}", best / t_best);
}

fn main() {
    let only = std::env::args().nth(1).unwrap_or_default();
    fn data<const D: usize>() -> basket::Data<D> {
        basket::Data { lambda: 1.2, mu: 0.8, gamma0: 10.0, gap: Given::constant(0.0) }
    }
    let o = &basket::Omega::on("all");
    let c = &basket::GammaC::on("boundary");
    use CellShape::*;
    macro_rules! go {
        ($name:literal, $form:ident, $r:expr, $d:literal, $shape:ident, $deg:literal, $geo:literal, $rule:literal, $tangent:literal, $best:literal, $s:expr) => {
            if $name.contains(&only) {
                run::<_, _, $d>(
                    $name,
                    basket::$form(&data::<$d>(), $r),
                    $shape,
                    $deg,
                    $geo,
                    $rule,
                    $tangent,
                    $best,
                    $s,
                );
            }
        };
    }
    go!("poisson_tri_P1", poisson, o, 2, Triangle, 1, 1, 0, true, 11.0, Fixed::<3, 1, 3>);
    //go!("elasticity_tri_P1", elasticity, o, 2, Triangle, 1, 1, 0, true, 18.9, Fixed::<3, 1, 3>);
    //go!("poisson_tri_P2", poisson, o, 2, Triangle, 2, 1, 2, true, 38.7, Fixed::<6, 3, 3>);
    go!("elasticity_tri_P2", elasticity, o, 2, Triangle, 2, 1, 2, true, 137.7, Fixed::<6, 3, 3>);
    //go!("neohooke_tangent_tri_P2", neo_hooke, o, 2, Triangle, 2, 1, 2, true, 253.3, Fixed::<6, 3, 3>);
    //go!("neohooke_residual_tri_P2", neo_hooke, o, 2, Triangle, 2, 1, 2, false, 63.1, Fixed::<6, 3, 3>);
    //go!("mass_tri_P2", mass, o, 2, Triangle, 2, 1, 4, true, 124.6, Fixed::<6, 6, 3>);
    //go!("nitsche_residual_tri_P2", nitsche, c, 2, Triangle, 2, 1, 4, false, 67.4, Fixed::<6, 3, 3>);
    //go!("nitsche_tangent_tri_P2", nitsche, c, 2, Triangle, 2, 1, 4, true, 248.1, Fixed::<6, 3, 3>);
    //go!("poisson_tet_P1", poisson, o, 3, Tetrahedron, 1, 1, 0, true, 21.3, Fixed::<4, 1, 4>);
    //go!("elasticity_tet_P1", elasticity, o, 3, Tetrahedron, 1, 1, 0, true, 107.6, Fixed::<4, 1, 4>);
    go!("poisson_tet_P2", poisson, o, 3, Tetrahedron, 2, 1, 2, true, 157.8, Fixed::<10, 4, 4>);
    go!("elasticity_tet_P2", elasticity, o, 3, Tetrahedron, 2, 1, 2, true, 1584.0, Fixed::<10, 4, 4>);
    //go!("neohooke_tangent_tet_P2", neo_hooke, o, 3, Tetrahedron, 2, 1, 2, true, 2153.8, Fixed::<10, 4, 4>);
    //go!("neohooke_residual_tet_P2", neo_hooke, o, 3, Tetrahedron, 2, 1, 2, false, 282.9, Fixed::<10, 4, 4>);
    go!("mass_tet_P2", mass, o, 3, Tetrahedron, 2, 1, 4, true, 1226.0, Counted);
    //go!("nitsche_residual_tet_P2", nitsche, c, 3, Tetrahedron, 2, 1, 4, false, 331.1, Fixed::<10, 6, 4>);
    //go!("nitsche_tangent_tet_P2", nitsche, c, 3, Tetrahedron, 2, 1, 4, true, 3166.5, Fixed::<10, 6, 4>);
    //go!("elasticity_quad_Q2_g2", elasticity, o, 2, Quadrilateral, 2, 2, 4, true, 889.7, Fixed::<9, 9, 9>);
    //go!("elasticity_quad_Q2_g1", elasticity, o, 2, Quadrilateral, 2, 1, 4, true, 898.5, Fixed::<9, 9, 4>);
    //go!("poisson_quad_Q2_g1", poisson, o, 2, Quadrilateral, 2, 1, 4, true, 250.5, Fixed::<9, 9, 4>);
    //go!("elasticity_hex_Q1_g1", elasticity, o, 3, Hexahedron, 1, 1, 3, true, 2207.7, Fixed::<8, 8, 8>);
    //go!("poisson_hex_Q1_g1", poisson, o, 3, Hexahedron, 1, 1, 3, true, 299.0, Fixed::<8, 8, 8>);
    //go!("elasticity_hex_Q2_g1", elasticity, o, 3, Hexahedron, 2, 1, 4, true, 75106.7, Fixed::<27, 27, 8>);
    //go!("poisson_hex_Q2_g1", poisson, o, 3, Hexahedron, 2, 1, 4, true, 3796.0, Fixed::<27, 27, 8>);
    //go!("elasticity_hex_Q2_g2", elasticity, o, 3, Hexahedron, 2, 2, 4, true, 59512.0, Fixed::<27, 27, 27>);
}
