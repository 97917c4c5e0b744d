//! Pairs of displaced surfaces: rays from a displaced facet, along its normal, to the plane or surface of another one, which
//! may be hit outside of the facet. Kernels do not mind.

use forms_core::contract::OppositePoint;

use super::Nodal;
use super::mesh::{Element, Mesh, determinant, functions, inverse, pairs};

/// A simplex by its vertices, with ∇λ.
struct Simplex<const D: usize> {
    vertices: Vec<[f64; D]>,
    slopes: Vec<[f64; D]>,
    edges: Vec<[usize; 2]>,
}

impl<const D: usize> Simplex<D> {
    fn of(mesh: &Mesh<D>, element: &Element<D>) -> Self {
        let vertices: Vec<[f64; D]> = element.nodes[..=D].iter().map(|node| mesh.nodes[*node]).collect();
        let system: Vec<Vec<f64>> =
            vertices.iter().map(|x| [1.0].into_iter().chain(x.iter().copied()).collect()).collect();
        assert!(determinant(&system) != 0.0);
        let inverse = inverse(&system);
        let slopes = (0..=D).map(|i| std::array::from_fn(|axis| inverse[axis + 1][i])).collect();
        let edges = if element.nodes.len() > D + 1 { pairs(D + 1) } else { vec![] };
        Simplex { vertices, slopes, edges }
    }

    fn barycentric(&self, x: &[f64; D]) -> Vec<f64> {
        let at = |i: usize| {
            let other = if i == 0 { 1 } else { 0 };
            (0..D).map(|k| self.slopes[i][k] * (x[k] - self.vertices[other][k])).sum()
        };
        (0..=D).map(at).collect()
    }

    /// d and I + ∇d at a point.
    fn displaced(&self, element: &Element<D>, d: &[&Nodal], x: &[f64; D]) -> ([f64; D], [[f64; D]; D]) {
        let (mut place, mut deformation) = (*x, [[0.0; D]; D]);
        (0..D).for_each(|k| deformation[k][k] = 1.0);
        let basis = functions(&self.barycentric(x), &self.slopes, &self.edges);
        for (node, (basis, _)) in element.nodes.iter().zip(&basis) {
            for k in 0..D {
                let coefficient: f64 = d.iter().map(|d| d.values[node * D + k]).sum();
                place[k] += basis.value * coefficient;
                for (entry, slope) in deformation[k].iter_mut().zip(&basis.gradient) {
                    *entry += slope * coefficient;
                }
            }
        }
        (place, deformation)
    }
}

fn rows<const D: usize>(matrix: &[[f64; D]; D]) -> Vec<Vec<f64>> {
    matrix.iter().map(|row| row.to_vec()).collect()
}

/// A pair with its opposite points where the rays of the displaced surfaces hit.
pub fn slid<const D: usize>(mesh: &Mesh<D>, pair: &Element<D>, d: &[&Nodal]) -> Element<D> {
    let mut slid = pair.clone();
    let mut across = pair.across.clone().expect("a pair");
    let facing = across.clone();
    let (own, opposite) = (Simplex::of(mesh, pair), Simplex::of(mesh, &facing));
    let on_facet = opposite.barycentric(&across.points[0].geometry.position);
    let corners: Vec<[f64; D]> =
        (0..=D).filter(|i| on_facet[*i].abs() > 1e-9).map(|i| opposite.vertices[i]).collect();
    assert_eq!(corners.len(), D);
    let along = |j: usize| -> [f64; D] { std::array::from_fn(|k| corners[j + 1][k] - corners[0][k]) };
    let tangents: Vec<[f64; D]> = (0..D - 1).map(along).collect();
    for (point, other) in slid.points.iter_mut().zip(&mut across.points) {
        let (x, deformation) = own.displaced(pair, d, &point.geometry.position);
        let back = inverse(&rows(&deformation));
        let turned: [f64; D] =
            std::array::from_fn(|k| (0..D).map(|j| back[j][k] * point.geometry.normal[j]).sum());
        let length = turned.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        let toward = turned.map(|entry| entry / length * determinant(&rows(&deformation)).signum());
        let (mut place, mut gap) = (other.geometry.position, 0.0);
        for _ in 0..30 {
            let (y, deformation) = opposite.displaced(&facing, d, &place);
            let column = |j: usize, k: usize| -> f64 {
                match tangents.get(j) {
                    Some(tangent) => (0..D).map(|l| deformation[k][l] * tangent[l]).sum(),
                    None => -toward[k],
                }
            };
            let matrix: Vec<Vec<f64>> = (0..D).map(|k| (0..D).map(|j| column(j, k)).collect()).collect();
            let back = inverse(&matrix);
            let step: Vec<f64> =
                (0..D).map(|j| (0..D).map(|k| back[j][k] * (x[k] + gap * toward[k] - y[k])).sum()).collect();
            for (tangent, by) in tangents.iter().zip(&step) {
                (0..D).for_each(|k| place[k] += by * tangent[k]);
            }
            gap += step[D - 1];
            if step.iter().all(|step| step.abs() < 1e-14) {
                break;
            }
        }
        let (y, _) = opposite.displaced(&facing, d, &place);
        for k in 0..D {
            assert!((x[k] + gap * toward[k] - y[k]).abs() < 1e-12, "the ray misses");
        }
        let normal = other.geometry.normal;
        let shape_operator = [[0.0; D]; D];
        point.geometry.opposite = OppositePoint { gap, toward, position: place, normal, shape_operator };
        other.geometry.position = place;
        let basis = functions(&opposite.barycentric(&place), &opposite.slopes, &opposite.edges);
        (other.basis, other.hessians) = basis.into_iter().unzip();
    }
    slid.across = Some(across);
    slid
}
