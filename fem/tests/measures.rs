//! The default rule on curved and skewed cells: lengths, areas, volumes and loads against closed forms, and against rules of high
//! degree. On affine cells it is the rule of the integrand.

use forms_fem::assemble::{ElementCells, ElementKernel, ElementLayout};
use forms_fem::contract::Datum;
use forms_fem::element::Lagrange;
use forms_fem::mesh::MeshError;
use forms_fem::prelude::*;

#[forms]
mod measured {
    pub struct Data {
        f: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Side;
    #[interior_facets]
    pub struct Inside;

    pub fn volume() -> Functional {
        integral(Omega, 1)
    }
    pub fn area() -> Functional {
        integral(Side, 1)
    }
    pub fn area_inside() -> Functional {
        integral(Inside, 1)
    }
    pub fn flux() -> Functional {
        integral(Side, dot(x, n))
    }
    pub fn load(v: Test<Scalar>) -> Form {
        integral(Omega, f * v)
    }
    pub fn pressure(v: Test<Scalar>) -> Form {
        integral(Side, f * v)
    }
    pub fn amount() -> Functional {
        integral(Omega, f)
    }
    pub fn weights(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, u * v)
    }
    pub fn bent() -> Functional {
        integral(Side, curvature * curvature)
    }
    pub fn mass(w: State<Scalar>) -> Functional {
        integral(Omega, w * w)
    }
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

const PI: f64 = std::f64::consts::PI;

fn data<const D: usize>(f: impl Datum<f64, D>) -> measured::Data<D> {
    measured::data().f(f)
}

/// ∫_Ω 1, ∫ 1 over a facet region, and the sums of loads that are tested with degree 1.
fn measures<const D: usize>(
    mesh: &Mesh<D>,
    side: &str,
    quadrature: Quadrature<D>,
) -> Result<[f64; 4], Box<dyn std::error::Error>>
where
    Dim: Dimension<D>,
{
    let assembler = Assembler::new(mesh).with_quadrature(quadrature);
    let (omega, side) = (measured::Omega::on("all"), measured::Side::on(side));
    let space = Space::scalar(mesh, 1)?;
    let data = data(1.0);
    let sum = |values: Vec<f64>| values.iter().sum::<f64>();
    Ok([
        assembler.functional(&measured::volume(&data, &omega))?,
        assembler.functional(&measured::area(&data, &side))?,
        sum(assembler.linear_form(&measured::load(&data, &omega), &space)?),
        sum(assembler.linear_form(&measured::pressure(&data, &side), &space)?),
    ])
}

/// Prints the table, and checks the orders between the last two meshes.
fn converge<const D: usize>(
    name: &str,
    side: &str,
    exact: [f64; 2],
    order: f64,
    meshes: &[Mesh<D>],
) -> Outcome
where
    Dim: Dimension<D>,
{
    let exact = [exact[0], exact[1], exact[0], exact[1]];
    let mut last: Option<[f64; 4]> = None;
    for mesh in meshes {
        let found = measures(mesh, side, Quadrature::Estimated)?;
        let errors: [f64; 4] = std::array::from_fn(|k| (found[k] / exact[k] - 1.0).abs());
        let orders = last.map(|last| -> [f64; 4] { std::array::from_fn(|k| (last[k] / errors[k]).log2()) });
        println!(
            "{name}, {} cells: {} {orders:.2?}",
            mesh.cell_count(),
            errors.map(|error| format!("{error:.1e}")).join(" ")
        );
        last = Some(errors);
        if let Some(orders) = orders.filter(|_| mesh.cell_count() == meshes[meshes.len() - 1].cell_count()) {
            for found in orders {
                assert!((found - order).abs() < 0.3, "{name}: {orders:?}");
            }
        }
    }
    Ok(())
}

#[test]
fn rings_discs_and_balls_converge_with_the_order_of_the_geometry() -> Outcome {
    for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
        let rings = [1, 2, 4].map(|n| annulus(1.0, 2.0, n, 12 * n, shape, 2));
        let rings = rings.into_iter().collect::<Result<Vec<_>, _>>()?;
        converge(&format!("ring, {shape:?}"), "outer", [3.0 * PI, 4.0 * PI], 4.0, &rings)?;
    }
    for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
        let balls = [1, 2, 4].map(|n| ball(1.0, [true; 3], n, n, shape, 2));
        let balls = balls.into_iter().collect::<Result<Vec<_>, _>>()?;
        converge(&format!("eighth of a ball, {shape:?}"), "sphere", [PI / 6.0, PI / 2.0], 4.0, &balls)?;
    }
    Ok(())
}

/// Straight hexahedra of a box, each vertex moved in its own direction by up to a part of the cell's size.
fn skewed(cells: usize, degree: usize, part: f64) -> Result<Mesh<3>, MeshError> {
    let (size, box_) =
        (1.0 / cells as f64, cuboid([0.0; 3], [1.0; 3], [cells; 3], CellShape::Hexahedron, 1)?);
    let mut number = 0_u32;
    let moved = box_.nodes().iter().map(|x| {
        x.map(|x| {
            number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            x + part * size * (f64::from(number >> 8) / f64::from(1 << 24) - 0.5)
        })
    });
    let straight = box_.with_nodes(moved.collect())?;
    if degree == 1 {
        return Ok(straight);
    }
    // The same cells with nodes of degree 2 on their trilinear maps.
    let fine = cuboid([0.0; 3], [1.0; 3], [cells; 3], CellShape::Hexahedron, 2)?;
    let mut nodes = fine.nodes().to_vec();
    for cell in 0..fine.cell_count() {
        for (node, reference) in fine.cell(cell).iter().zip(fine.cell_element(cell).node_points::<3>()) {
            nodes[*node as usize] = straight.map(cell, &reference).0;
        }
    }
    fine.with_nodes(nodes)
}

#[test]
fn volumes_and_faces_of_skewed_hexahedra() -> Outcome {
    for degree in 1..=2 {
        for cells in [1, 2, 3] {
            let mesh = skewed(cells, degree, 0.6)?;
            let found = measures(&mesh, "top", Quadrature::Estimated)?;
            let exact = measures(&mesh, "top", Quadrature::Degree(30))?;
            let errors: [f64; 4] = std::array::from_fn(|k| (found[k] / exact[k] - 1.0).abs());
            println!(
                "skewed, {cells} cells, degree {degree}: {}",
                errors.map(|e| format!("{e:.1e}")).join(" ")
            );
            // The Jacobian's determinant is a polynomial, a warped face's area is none.
            assert!(errors[0] < 1e-13 && errors[2] < 1e-13, "{errors:?}");
            assert!(errors[1] < 2e-4 && errors[3] < 2e-4, "{errors:?}");
            let assembler = Assembler::new(&mesh);
            let (data, boundary) = (data(1.0), measured::Side::on("boundary"));
            let flux = assembler.functional(&measured::flux(&data, &boundary))?;
            assert!((flux / (3.0 * found[0]) - 1.0).abs() < 1e-13, "{flux}");
            // Products of fields of degree 2 with the determinant.
            let w = Field::interpolate(&Space::scalar(&mesh, 2)?, |x| x[0] * x[1] - x[2] * x[2])?;
            let product = measured::mass(&data, &measured::Omega::on("all"), &w);
            let exact = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(30)).functional(&product)?;
            assert!((assembler.functional(&product)? / exact - 1.0).abs() < 1e-13);
            if cells > 1 {
                let inside = measured::area_inside(&data, &measured::Inside::on("interior"));
                let exact =
                    Assembler::new(&mesh).with_quadrature(Quadrature::Degree(30)).functional(&inside)?;
                assert!((assembler.functional(&inside)? / exact - 1.0).abs() < 2e-4);
            }
        }
    }
    Ok(())
}

/// Bilinear faces are curved, whatever the degree of the geometry that describes them.
#[test]
fn the_curvature_of_warped_faces() -> Outcome {
    let found = [1, 2].map(|degree| -> Result<f64, Box<dyn std::error::Error>> {
        let assembler = Assembler::new(&skewed(2, degree, 0.6)?).with_quadrature(Quadrature::Degree(12));
        Ok(assembler.functional(&measured::bent(&data(1.0), &measured::Side::on("boundary")))?)
    });
    let [linear, quadratic] = found;
    let (linear, quadratic) = (linear?, quadratic?);
    assert!(quadratic > 0.01 && (linear / quadratic - 1.0).abs() < 1e-10, "{linear}, {quadratic}");
    Ok(())
}

/// The number of quadrature points at which ∫ f reads f.
fn points<const D: usize>(mesh: &Mesh<D>) -> Result<usize, Box<dyn std::error::Error>>
where
    Dim: Dimension<D>,
{
    use std::sync::atomic::{AtomicUsize, Ordering};
    let count = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&count);
    let f = Given::function(move |_: &[f64; D]| {
        counted.fetch_add(1, Ordering::Relaxed);
        1.0
    });
    let assembler = Assembler::new(mesh).with_threads(Threads::ONE);
    assembler.functional(&measured::amount(&data(f), &measured::Omega::on("all")))?;
    Ok(count.load(Ordering::Relaxed))
}

#[test]
fn cells_with_affine_maps_keep_the_rule_of_the_integrand() -> Outcome {
    let sheared = |x: &[f64; 3]| [x[0] + 0.3 * x[1], x[1] - 0.2 * x[2], x[2] + 0.1 * x[0]];
    for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
        for degree in 1..=2 {
            let plain = cuboid([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1], shape, degree)?;
            let mesh = plain.with_nodes(plain.nodes().iter().map(sheared).collect())?;
            assert_eq!(points(&mesh)?, points(&plain)?);
            // Of two blocks of cells one is skewed: only its cells have more points.
            let mut nodes = plain.nodes().to_vec();
            let corner = nodes.iter().position(|x| *x == [2.0, 1.0, 1.0]).ok_or("no corner")?;
            nodes[corner] = [2.2, 1.1, 0.9];
            let skewed = plain.with_nodes(nodes)?;
            let touched =
                (0..skewed.cell_count()).filter(|cell| skewed.cell(*cell).contains(&(corner as u32))).count();
            let all = skewed.cell_count();
            let per_cell = points(&plain)? / all;
            let more = points(&skewed)? - per_cell * (all - touched);
            // Tetrahedra of degree 1 stay affine.
            match (shape, degree) {
                (CellShape::Tetrahedron, 1) => assert_eq!(more, per_cell * touched),
                _ => assert!(more > per_cell * touched && more % touched == 0, "{shape:?} {degree}: {more}"),
            }
        }
    }
    Ok(())
}

/// Cells that a caller lists may be skewed: their kernels have the rule with the measure.
#[test]
fn element_kernels_count_the_measure_of_listed_cells() -> Outcome {
    let mesh = skewed(1, 1, 0.6)?;
    let element = Lagrange::new(CellShape::Hexahedron, 1)?;
    let layout = ElementLayout {
        geometry: element,
        element,
        coordinate_stride: 24,
        coordinate_offsets: (0..8).map(|node| 3 * node).collect(),
        coefficient_stride: 0,
        fields: vec![],
        rows: (0..8).collect(),
    };
    let data = data(1.0);
    let form = measured::weights(&data, &measured::Omega::on("all"));
    let mut kernel = ElementKernel::new::<measured::weights::Kernels>(&form, layout, &Quadrature::Estimated)?;
    let coordinates: Vec<f64> = mesh.cell(0).iter().flat_map(|node| mesh.nodes()[*node as usize]).collect();
    let cells = ElementCells { count: 1, coordinates: &coordinates, coefficients: &[], facet: 0 };
    let mut matrix = vec![0.0; 64];
    kernel.matrices(&cells, &mut matrix)?;
    let exact = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(30));
    let volume = exact.functional(&measured::volume(&data, &measured::Omega::on("all")))?;
    assert!((matrix.iter().sum::<f64>() / volume - 1.0).abs() < 1e-13);
    Ok(())
}

/// Sums of assemblers of parts of the cells add up to the whole, where skewed and straight cells have rules of their own.
#[test]
fn shares_of_cells_add_up() -> Outcome {
    let box_ = cuboid([0.0; 3], [4.0, 1.0, 1.0], [4, 2, 1], CellShape::Hexahedron, 1)?;
    let moved = box_
        .nodes()
        .iter()
        .map(|x| if x[0] > 3.5 && x[1] > 0.7 { [x[0] + 0.3, x[1], x[2] * 1.2] } else { *x });
    let mesh = box_.with_nodes(moved.collect())?;
    let of = |assembler: &Assembler<3>| -> Result<[f64; 4], AssemblyError> {
        let (data, omega) = (data(1.0), measured::Omega::on("all"));
        let sides = ["boundary", "right"].map(measured::Side::on);
        Ok([
            assembler.functional(&measured::volume(&data, &omega))?,
            assembler.functional(&measured::area(&data, &sides[0]))?,
            assembler.functional(&measured::area(&data, &sides[1]))?,
            assembler.functional(&measured::area_inside(&data, &measured::Inside::on("interior")))?,
        ])
    };
    let whole = of(&Assembler::new(&mesh))?;
    let mut sum = [0.0; 4];
    for cells in [[0, 3, 5, 6], [1, 2, 4, 7]] {
        let share = of(&Assembler::new(&mesh).on_owned_cells(&cells)?)?;
        (0..4).for_each(|k| sum[k] += share[k]);
    }
    for (sum, whole) in sum.into_iter().zip(whole) {
        assert!((sum / whole - 1.0).abs() < 1e-14, "{sum} {whole}");
    }
    Ok(())
}

const CHILD: &str = "FORMS_TEST_STRAIGHT_FACETS";

/// A polygon that approximates a circle has no curvature: assembly says so, once per process, and is silent about curved facets.
#[test]
fn the_word_on_straight_facets() -> Outcome {
    if let Some(degree) = std::env::var_os(CHILD) {
        let degree = if degree == "1" { 1 } else { 2 };
        let ring = annulus(1.0, 2.0, 1, 64, CellShape::Quadrilateral, degree)?;
        let assembler = Assembler::new(&ring);
        let form = measured::bent(&data(1.0), &measured::Side::on("outer"));
        let [first, again] = [assembler.functional(&form)?, assembler.functional(&form)?];
        // ∫ κ² = 2π R / R² on the circle of radius 2; that of the parabolas is near to it in second order, (2π/64)² = 0.01.
        let exact = if degree == 1 { 0.0 } else { PI };
        assert!(first == again && (first - exact).abs() < 5e-3, "{first}");
        return Ok(());
    }
    for (degree, count) in [("1", 1), ("2", 0)] {
        let mut command = std::process::Command::new(std::env::current_exe()?);
        command.args(["the_word_on_straight_facets", "--nocapture"]);
        let output = command.env(CHILD, degree).env_remove("FORMS_QUIET").output()?;
        assert!(output.status.success(), "{output:?}");
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(text.matches("whose facets are straight").count(), count, "{text}");
    }
    Ok(())
}
