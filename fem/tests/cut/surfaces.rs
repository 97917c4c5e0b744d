//! Bodies that closed surfaces give: signed distances compared with closed forms, measures of a sphere from an STL file, what is refused.

use forms_fem::cut::{CutError, signed_distance};
use forms_fem::mesh::RigidSurface;
use forms_fem::prelude::*;

/// A file in binary STL.
fn stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut file = vec![b' '; 80];
    file.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        file.extend([0_u8; 12]);
        file.extend(triangle.as_flattened().iter().flat_map(|x| (*x as f32).to_le_bytes()));
        file.extend([0, 0]);
    }
    file
}

/// The surface of the cube (−1, 1)³ in n × n squares on each side, mapped.
fn cube(n: i32, map: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<[[f64; 3]; 3]> {
    let mut triangles = Vec::new();
    for (axis, side) in [0, 1, 2].into_iter().flat_map(|axis| [(axis, -n), (axis, n)]) {
        for (a, b) in (0..n).flat_map(|a| (0..n).map(move |b| (a, b))) {
            let corner = |a: i32, b: i32| {
                let mut place = [side; 3];
                (place[(axis + 1) % 3], place[(axis + 2) % 3]) = (2 * a - n, 2 * b - n);
                map(place.map(|k| f64::from(k) / f64::from(n)))
            };
            let mut square = [corner(a, b), corner(a + 1, b), corner(a + 1, b + 1), corner(a, b + 1)];
            if side < 0 {
                square.reverse();
            }
            triangles.extend([[0, 1, 2], [0, 2, 3]].map(|of| of.map(|k| square[k])));
        }
    }
    triangles
}

fn surface(triangles: &[[[f64; 3]; 3]]) -> RigidSurface<3> {
    RigidSurface::from_stl(&stl(triangles)).unwrap()
}

/// Some thousand points around the cube, on its edges and planes as well.
fn points() -> impl Iterator<Item = [f64; 3]> {
    (0..13_i32.pow(3)).map(|k| [k % 13, k / 13 % 13, k / 169].map(|k| 0.25 * f64::from(k - 6)))
}

/// The signed distance to the cube (−1, 1)³.
fn of_cube(x: &[f64; 3]) -> f64 {
    let off = x.map(|x| x.abs() - 1.0);
    let outside = off.iter().map(|off| off.max(0.0).powi(2)).sum::<f64>().sqrt();
    outside + off.iter().copied().fold(f64::MIN, f64::max).min(0.0)
}

#[test]
fn distances_to_a_cube_are_exact() {
    for n in [1, 4] {
        let distance = surface(&cube(n, |x| x)).signed_distance().unwrap();
        for x in points() {
            let (found, expected) = (distance.at(&x), of_cube(&x));
            assert!((found - expected).abs() < 1e-15, "{x:?}: {found}, not {expected}");
        }
    }
    // Far from a fine surface, and close to it, where many pieces are taken together.
    let distance = surface(&cube(20, |x| x)).signed_distance().unwrap();
    for (x, expected) in [([30.0, 0.3, 0.1], 29.0), ([1.0 - 1e-9, 0.31, 0.17], -1e-9), ([0.0; 3], -1.0)] {
        assert!((distance.at(&x) - expected).abs() < 1e-13, "{x:?}: {}", distance.at(&x));
    }
}

/// A cube with a cubic hole, two cubes that overlap, two that share an edge, and a mould.
#[test]
fn sides_are_those_of_winding_numbers() {
    let scaled = |factor: f64| cube(2, |x| x.map(|x| factor * x));
    let reversed = |triangles: Vec<[[f64; 3]; 3]>| -> Vec<[[f64; 3]; 3]> {
        triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect()
    };
    let hollow = surface(&[scaled(1.0), reversed(scaled(0.5))].concat()).signed_distance().unwrap();
    for x in points() {
        let expected = of_cube(&x).max(-0.5 * of_cube(&x.map(|x| 2.0 * x)));
        assert!((hollow.at(&x) - expected).abs() < 1e-15, "{x:?}: {}", hollow.at(&x));
    }
    let moved = |by: [f64; 3]| cube(1, move |x| [0, 1, 2].map(|k| x[k] + by[k]));
    for by in [[0.7, 0.4, 0.2], [2.0, 2.0, 0.0]] {
        let both = surface(&[moved([0.0; 3]), moved(by)].concat()).signed_distance().unwrap();
        for x in points() {
            let each = [of_cube(&x), of_cube(&[0, 1, 2].map(|k| x[k] - by[k]))];
            if each.iter().all(|of_one| of_one.abs() > 1e-6) {
                assert_eq!(both.at(&x) < 0.0, each[0].min(each[1]) < 0.0, "{x:?} {each:?}");
            }
        }
    }
    let cube = surface(&scaled(1.0));
    let turned = cube.facets().iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let mould = RigidSurface::new(cube.points().to_vec(), turned).unwrap().signed_distance().unwrap();
    for x in points().filter(|x| of_cube(x) != 0.0) {
        assert!((mould.at(&x) + of_cube(&x)).abs() < 1e-15, "{x:?}: {}", mould.at(&x));
    }
}

#[test]
fn sphere_from_a_file_has_its_volume_and_surface() {
    let centre = [0.013, -0.021, 0.007];
    let onto_sphere = |x: [f64; 3]| {
        let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
        [0, 1, 2].map(|k| centre[k] + 0.7 * x[k] / length)
    };
    let path = std::env::temp_dir().join(format!("sphere_{}.stl", std::process::id()));
    std::fs::write(&path, stl(&cube(24, onto_sphere))).unwrap();
    let sphere = RigidSurface::from_stl_file(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let area: f64 = sphere
        .outline(|x| *x)
        .iter()
        .map(|corners| {
            let [a, b] = [1, 2].map(|k| [0, 1, 2].map(|i| corners[k][i] - corners[0][i]));
            let normal = [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
            0.5 * normal.iter().map(|x| x * x).sum::<f64>().sqrt()
        })
        .sum();
    let errors = |cells: usize| {
        let mesh = cuboid([-1.0; 3], [1.0; 3], [cells; 3], CellShape::Tetrahedron, 1).unwrap();
        let ball = Assembler::new(&mesh).cut_by(&signed_distance(&sphere, &mesh).unwrap()).unwrap();
        let volume = ball.functional(&form!(|| -> Functional { integral(cells("all"), 1) })).unwrap();
        let surface = ball.functional(&form!(|| -> Functional { integral(interface("all"), 1) })).unwrap();
        [(volume - sphere.enclosed().unwrap()).abs(), (surface - area).abs()]
    };
    let found = [errors(8), errors(16)];
    for k in 0..2 {
        let order = (found[0][k] / found[1][k]).log2();
        assert!((order - 2.0).abs() < 0.2, "order {order} of {found:?}");
    }
}

#[test]
fn open_surfaces_are_refused_with_the_facet() {
    let triangles = cube(1, |x| x);
    let open = surface(&triangles[..11]);
    let told = open.signed_distance().unwrap_err().to_string();
    assert!(
        told.starts_with("the surface is open: 3 edges have only one facet, the first is that of facet "),
        "{told}"
    );
    let mesh = cuboid([-1.0; 3], [1.0; 3], [2; 3], CellShape::Tetrahedron, 1).unwrap();
    assert_eq!(signed_distance(&open, &mesh).unwrap_err(), CutError::Surface { text: told });
    // Mistakes in a file are named with the file.
    let path = std::env::temp_dir().join(format!("broken_{}.stl", std::process::id()));
    std::fs::write(&path, &stl(&triangles)[..300]).unwrap();
    let told = RigidSurface::from_stl_file(&path).unwrap_err().to_string();
    std::fs::remove_file(&path).unwrap();
    let start = format!("{}: the STL file says that it has 12 triangles", path.display());
    assert!(told.starts_with(&start) && told.ends_with("it breaks off in triangle 4, at byte 300"), "{told}");
}
