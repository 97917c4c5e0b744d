//! The contact forms evaluated without the compiler: plain loops over points and pairs of basis functions,
//! after the paper's text. Only the element's tables and the quadrature rules are the backend's.

use forms_fem::mesh::Facet;
use forms_fem::quadrature::{cell_rule, facet_rule};
use forms_fem::space::Space;
use nalgebra::{DMatrix, DVector};

use crate::bodies::{self, Body, CONTACT, DEGREE, EXTENSION, GAMMA0, LAMBDA, LOADED, MU};

/// All systems at a state.
pub struct ByLoops {
    /// a(u, v).
    pub stiffness: DMatrix<f64>,
    /// (14): left side minus ℓ(v).
    pub residual: DVector<f64>,
    /// Its Newton tangent.
    pub tangent: DMatrix<f64>,
    /// (21), rows q, columns p.
    pub discrete: DMatrix<f64>,
    /// (22).
    pub consistent: DMatrix<f64>,
    /// (41).
    pub extended: DMatrix<f64>,
    /// −∫M′q − ∫N′q, the right side of (21).
    pub discrete_side: DVector<f64>,
    /// That of (22), with the terms in N′_n.
    pub consistent_side: DVector<f64>,
    /// That of (41).
    pub extended_side: DVector<f64>,
    /// J.
    pub criterion: f64,
    /// ∫\[σ_n − γ(u_n − g)\]₋.
    pub force: f64,
    /// ∫H(β).
    pub length: f64,
    /// Points with β > 0, β > ξ, and all on Γ_C.
    pub points: [usize; 3],
    /// The smallest |β| and |β − ξ| on Γ_C.
    pub nearest_to_switch: f64,
}

/// A point of a cell or facet: basis functions there.
struct Point<const D: usize> {
    position: [f64; D],
    weight: f64,
    normal: [f64; D],
    value: Vec<f64>,
    gradient: Vec<[f64; D]>,
}

impl ByLoops {
    /// Everything at the body's state.
    pub fn new<const D: usize>(body: &Body<D>, theta: f64) -> Self {
        let size = body.space.unknowns();
        let (matrix, vector) = (DMatrix::zeros(size, size), DVector::zeros(size));
        let mut all = ByLoops {
            stiffness: matrix.clone(),
            residual: vector.clone(),
            tangent: matrix.clone(),
            discrete: matrix.clone(),
            consistent: matrix.clone(),
            extended: matrix,
            discrete_side: vector.clone(),
            consistent_side: vector.clone(),
            extended_side: vector,
            criterion: 0.0,
            force: 0.0,
            length: 0.0,
            points: [0; 3],
            nearest_to_switch: f64::INFINITY,
        };
        all.cells(body);
        let u = DVector::from_column_slice(body.u.values());
        all.residual += &all.stiffness * u;
        for matrix in [&mut all.tangent, &mut all.discrete, &mut all.consistent, &mut all.extended] {
            *matrix += &all.stiffness;
        }
        all.facets(body, theta);
        for side in [&mut all.consistent_side, &mut all.extended_side] {
            *side += &all.discrete_side;
        }
        all
    }

    fn cells<const D: usize>(&mut self, body: &Body<D>) {
        let space = &body.space;
        for cell in 0..space.mesh().cell_count() {
            let rule = cell_rule::<D>(space.mesh().cell_shape(cell), DEGREE)
                .unwrap_or_else(|error| panic!("{error}"));
            let unknowns = unknowns(space, cell);
            for point in points(space, cell, &rule.points, &rule.weights, None) {
                let u = at(&point, &unknowns, body.u.values());
                let (f, criterion) =
                    (bodies::body_force(&point.position), bodies::criterion_force(&point.position));
                self.criterion += point.weight * (0..D).map(|k| criterion[k] * u[k]).sum::<f64>();
                for (i, &row) in unknowns.iter().enumerate() {
                    let (a, value) = (i % D, point.value[i / D]);
                    self.residual[row] -= point.weight * f[a] * value;
                    self.discrete_side[row] -= point.weight * criterion[a] * value;
                    for (j, &column) in unknowns.iter().enumerate() {
                        let stress = stress(&point.gradient[j / D], j % D);
                        let product: f64 = (0..D).map(|k| stress[a][k] * point.gradient[i / D][k]).sum();
                        self.stiffness[(row, column)] += point.weight * product;
                    }
                }
            }
        }
    }

    fn facets<const D: usize>(&mut self, body: &Body<D>, theta: f64) {
        let mesh = body.space.mesh();
        let region = |name: &str| mesh.facet_region(name).unwrap_or_else(|error| panic!("{error}")).to_vec();
        let (contact, loaded) = (region(CONTACT), region(LOADED));
        for facet in region("boundary") {
            let unknowns = unknowns(&body.space, facet.cell as usize);
            for point in facet_points(&body.space, facet) {
                let u = at(&point, &unknowns, body.u.values());
                let weight = bodies::criterion_weight(&point.position);
                self.criterion += point.weight * weight / 2.0 * u.iter().map(|u| u * u).sum::<f64>();
                let traction = bodies::traction(&point.position);
                for (i, &row) in unknowns.iter().enumerate() {
                    let value = point.weight * point.value[i / D];
                    self.discrete_side[row] -= value * weight * u[i % D];
                    if loaded.contains(&facet) {
                        self.residual[row] -= value * traction[i % D];
                    }
                }
                if contact.contains(&facet) {
                    let h = mesh.diameter(facet.cell as usize);
                    self.contact_point(&point, &unknowns, body.u.values(), h, theta);
                }
            }
        }
    }

    fn contact_point<const D: usize>(
        &mut self,
        point: &Point<D>,
        unknowns: &[usize],
        u: &[f64],
        h: f64,
        theta: f64,
    ) {
        let (gamma, weight) = (GAMMA0 / h, point.weight);
        let direction = bodies::obstacle_normal(&point.position);
        // σ_n and the normal displacement of each basis function.
        let stresses: Vec<f64> = (0..unknowns.len())
            .map(|j| {
                let stress = stress(&point.gradient[j / D], j % D);
                (0..D)
                    .flat_map(|a| (0..D).map(move |b| (a, b)))
                    .map(|(a, b)| direction[a] * stress[a][b] * point.normal[b])
                    .sum()
            })
            .collect();
        let normals: Vec<f64> = (0..unknowns.len()).map(|j| direction[j % D] * point.value[j / D]).collect();
        let combine = |basis: &[f64]| -> f64 { basis.iter().zip(unknowns).map(|(b, k)| b * u[*k]).sum() };
        let (sigma, normal) = (combine(&stresses), combine(&normals));
        let beta = gamma * (normal - bodies::gap(&point.position)) - sigma;
        let xi = EXTENSION * h.sqrt();
        let active = |shift: f64| if beta > shift { 1.0 } else { 0.0 };
        self.force += weight * beta.max(0.0);
        self.length += weight * active(0.0);
        self.points[0] += usize::from(beta > 0.0);
        self.points[1] += usize::from(beta > xi);
        self.points[2] += 1;
        self.nearest_to_switch = self.nearest_to_switch.min(beta.abs()).min((beta - xi).abs());
        let slope = bodies::criterion_weight(&point.position) * normal;
        let scale = weight / gamma;
        for (i, &row) in unknowns.iter().enumerate() {
            let (s, v) = (stresses[i], normals[i]);
            let tested = theta * s - gamma * v;
            self.residual[row] -= scale * (theta * sigma * s + beta.max(0.0) * tested);
            for (side, shift) in [(&mut self.consistent_side, 0.0), (&mut self.extended_side, xi)] {
                side[row] += scale * slope * (theta * s - active(shift) * tested);
            }
            for (j, &column) in unknowns.iter().enumerate() {
                let (sp, vp) = (stresses[j], normals[j]);
                let symmetric = theta * sp * s;
                let place = (row, column);
                self.tangent[place] += scale * (active(0.0) * (sp - gamma * vp) * tested - symmetric);
                self.discrete[place] +=
                    scale * (active(0.0) * (s - gamma * v) * (theta * sp - gamma * vp) - symmetric);
                self.consistent[place] += scale * (active(0.0) * (sp - gamma * vp) * tested - symmetric);
                self.extended[place] += scale * (active(xi) * (sp - gamma * vp) * tested - symmetric);
            }
        }
    }
}

/// σ of the basis function with this gradient in one component.
fn stress<const D: usize>(gradient: &[f64; D], component: usize) -> [[f64; D]; D] {
    let mut stress = [[0.0; D]; D];
    for k in 0..D {
        stress[k][k] += LAMBDA * gradient[component];
        stress[component][k] += MU * gradient[k];
        stress[k][component] += MU * gradient[k];
    }
    stress
}

fn unknowns<const D: usize>(space: &Space<D>, cell: usize) -> Vec<usize> {
    space.cell_nodes(cell).iter().flat_map(|node| (0..D).map(move |k| *node as usize * D + k)).collect()
}

fn at<const D: usize>(point: &Point<D>, unknowns: &[usize], values: &[f64]) -> [f64; D] {
    let mut found = [0.0; D];
    for (i, unknown) in unknowns.iter().enumerate() {
        found[i % D] += point.value[i / D] * values[*unknown];
    }
    found
}

fn facet_points<const D: usize>(space: &Space<D>, facet: Facet) -> Vec<Point<D>> {
    let rule =
        facet_rule::<D>(space.mesh().cell_shape(facet.cell as usize), usize::from(facet.local), DEGREE);
    let rule = rule.unwrap_or_else(|error| panic!("{error}"));
    points(space, facet.cell as usize, &rule.points, &rule.weights, Some(&rule.tangents))
}

fn points<const D: usize>(
    space: &Space<D>,
    cell: usize,
    places: &[[f64; D]],
    weights: &[f64],
    tangents: Option<&[[f64; D]; 2]>,
) -> Vec<Point<D>> {
    let tables = space.cell_element(cell).tabulate(places);
    let mut found = Vec::new();
    for (q, (place, weight)) in places.iter().zip(weights).enumerate() {
        let (position, jacobian) = space.mesh().map(cell, place);
        let jacobian = DMatrix::from_fn(D, D, |i, j| jacobian[i][j]);
        let inverse = jacobian.clone().try_inverse().unwrap_or_else(|| panic!("a degenerate cell"));
        let mut normal = [0.0; D];
        let measure = match tangents {
            None => jacobian.determinant(),
            Some(tangents) => {
                let push = |t: &[f64; D]| &jacobian * DVector::from_column_slice(t);
                let (t, s) = (push(&tangents[0]), push(&tangents[1]));
                let direction = if D == 2 {
                    vec![t[1], -t[0]]
                } else {
                    vec![t[1] * s[2] - t[2] * s[1], t[2] * s[0] - t[0] * s[2], t[0] * s[1] - t[1] * s[0]]
                };
                let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
                normal = std::array::from_fn(|k| direction[k] / length);
                length
            }
        };
        let basis = q * tables.nodes..(q + 1) * tables.nodes;
        let gradient = tables.gradient[basis.clone()]
            .iter()
            .map(|slope| std::array::from_fn(|k| (0..D).map(|m| inverse[(m, k)] * slope[m]).sum()))
            .collect();
        let value = tables.value[basis].to_vec();
        found.push(Point { position, weight: weight * measure, normal, value, gradient });
    }
    found
}
