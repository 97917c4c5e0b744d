//! The nodes of an element that are given one by one: how many belong to each vertex, edge, face and to the cell.

use super::CellShape;

/// Nodes of an element: those of the vertices, of the edges, in three dimensions of the faces, then those of the cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub shape: CellShape,
    /// Nodes per vertex, edge, face and cell; in two dimensions cells are the third.
    pub of_entity: [usize; 4],
    /// Reference coordinates; the third is zero in two dimensions.
    pub points: Vec<[f64; 3]>,
}

impl Layout {
    /// One node at the mean of the vertices of each vertex, edge, face and cell that has one.
    pub fn centred(shape: CellShape, of_entity: [usize; 4]) -> Self {
        let dimension = shape.dimension();
        let mean = |vertices: &[usize]| -> [f64; 3] {
            let points = vertices.iter().map(|vertex| shape.vertex_points()[*vertex]);
            points.fold([0.0; 3], |sum, x| std::array::from_fn(|k| sum[k] + x[k] / vertices.len() as f64))
        };
        let mut points = Vec::new();
        if of_entity[0] == 1 {
            points.extend((0..shape.vertices()).map(|vertex| mean(&[vertex])));
        }
        if of_entity[1] == 1 {
            points.extend(shape.edges().iter().map(|edge| mean(edge)));
        }
        if dimension == 3 && of_entity[2] == 1 {
            points.extend((0..shape.facets()).map(|local| mean(shape.facet_vertices(local))));
        }
        if of_entity[dimension] == 1 {
            points.push(shape.centre());
        }
        Layout { shape, of_entity, points }
    }

    /// The nodes of the Lagrange element of degree 2.
    pub fn of_degree_two(shape: CellShape) -> Self {
        let inside = usize::from(!shape.is_simplex());
        let of_entity = std::array::from_fn(|k| match k {
            0 | 1 => 1,
            k if k <= shape.dimension() => inside,
            _ => 0,
        });
        Layout::centred(shape, of_entity)
    }

    pub fn nodes(&self) -> usize {
        self.points.len()
    }

    /// The number that the counts of the entities add up to.
    pub fn counted(&self) -> usize {
        let [vertices, edges, faces, cells] = self.of_entity;
        let shape = self.shape;
        let plane = shape.dimension() == 2;
        let others = if plane { faces } else { shape.facets() * faces + cells };
        shape.vertices() * vertices + shape.edges().len() * edges + others
    }

    /// A point of a facet in the cell's coordinates, from steps towards its second and its last vertex.
    pub fn on_facet(&self, local: usize, [s, t]: [f64; 2]) -> [f64; 3] {
        let vertices = self.shape.facet_vertices(local);
        let [first, second, last] =
            [0, 1, vertices.len() - 1].map(|corner| self.shape.vertex_points()[vertices[corner]]);
        // On a triangle, points beyond the diagonal are turned back inside.
        let beyond = self.shape.is_simplex() && s + t > 1.0;
        let [s, t] = if beyond { [1.0 - s, 1.0 - t] } else { [s, t] };
        std::array::from_fn(|k| first[k] + s * (second[k] - first[k]) + t * (last[k] - first[k]))
    }

    /// The nodes on a facet: of its vertices, of the edges between successive ones in their direction, inside it.
    pub fn facet_nodes(&self, local: usize) -> Vec<usize> {
        let [of_vertex, of_edge, of_face, _] = self.of_entity;
        let vertices = self.shape.facet_vertices(local);
        let mut nodes: Vec<usize> =
            vertices.iter().flat_map(|vertex| vertex * of_vertex..(vertex + 1) * of_vertex).collect();
        let mut start = self.shape.vertices() * of_vertex;
        let sides = if vertices.len() == 2 { 1 } else { vertices.len() };
        for side in 0..sides {
            let [from, to] = [vertices[side], vertices[(side + 1) % vertices.len()]];
            for (edge, ends) in self.shape.edges().iter().enumerate() {
                let own = start + edge * of_edge..start + (edge + 1) * of_edge;
                if *ends == [from, to] {
                    nodes.extend(own);
                } else if *ends == [to, from] {
                    nodes.extend(own.rev());
                }
            }
        }
        start += self.shape.edges().len() * of_edge;
        if self.shape.dimension() == 3 {
            nodes.extend(start + local * of_face..start + (local + 1) * of_face);
        }
        nodes
    }

    /// The places of a facet's nodes on its own reference cell.
    pub fn facet_node_points(&self) -> Vec<[f64; 2]> {
        let vertices = self.shape.facet_vertices(0);
        let corner = |place: usize| self.shape.vertex_points()[vertices[place]];
        let minus = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| a[k] - b[k]) };
        let dot = |a: [f64; 3], b: [f64; 3]| -> f64 { (0..3).map(|k| a[k] * b[k]).sum() };
        let (along, last) = (minus(corner(1), corner(0)), minus(corner(vertices.len() - 1), corner(0)));
        let place = |node: usize| {
            let x = minus(self.points[node], corner(0));
            if vertices.len() == 2 {
                return [dot(x, along) / dot(along, along), 0.0];
            }
            let (a, b, c) = (dot(along, along), dot(along, last), dot(last, last));
            let (p, q) = (dot(x, along), dot(x, last));
            let determinant = a * c - b * b;
            [(c * p - b * q) / determinant, (a * q - b * p) / determinant]
        };
        self.facet_nodes(0).into_iter().map(place).collect()
    }
}
