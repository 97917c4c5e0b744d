//! Writes a mesh as Gmsh would, after the format's description and without the reader's tables.

use forms_fem::element::CellShape;
use forms_fem::mesh::{BOUNDARY, EVERYWHERE, Facet, INTERIOR, Mesh};

/// A version and an encoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Text4,
    Little4,
    Big4,
    /// With `size_t` of four bytes.
    Short4,
    Text2,
    Little2,
    Big2,
}

impl Format {
    pub const ALL: [Format; 7] = [
        Format::Text4,
        Format::Little4,
        Format::Big4,
        Format::Short4,
        Format::Text2,
        Format::Little2,
        Format::Big2,
    ];

    fn is_text(self) -> bool {
        matches!(self, Format::Text4 | Format::Text2)
    }

    fn is_big(self) -> bool {
        matches!(self, Format::Big4 | Format::Big2)
    }

    fn is_version_4(self) -> bool {
        !matches!(self, Format::Text2 | Format::Little2 | Format::Big2)
    }
}

struct Writer {
    bytes: Vec<u8>,
    format: Format,
}

impl Writer {
    fn line(&mut self, text: &str) {
        self.bytes.extend(text.as_bytes());
        self.bytes.push(b'\n');
    }

    fn number<const N: usize>(&mut self, text: String, mut little: [u8; N]) {
        if self.format.is_text() {
            self.bytes.extend(text.as_bytes());
            self.bytes.push(b' ');
            return;
        }
        if self.format.is_big() {
            little.reverse();
        }
        self.bytes.extend(little);
    }

    fn integer(&mut self, value: i32) {
        self.number(value.to_string(), value.to_le_bytes());
    }

    fn size(&mut self, value: usize) {
        if self.format == Format::Short4 {
            self.number(value.to_string(), (value as u32).to_le_bytes());
        } else {
            self.number(value.to_string(), (value as u64).to_le_bytes());
        }
    }

    fn reals(&mut self, values: impl IntoIterator<Item = f64>) {
        for value in values {
            // Seventeen digits are enough to come back.
            self.number(format!("{value:?}"), value.to_le_bytes());
        }
    }

    // Between numbers that belong together there is nothing in binary files.
    fn end_line(&mut self) {
        if self.format.is_text() {
            self.bytes.push(b'\n');
        }
    }

    fn section(&mut self, name: &str, write: impl FnOnce(&mut Self)) {
        self.line(&format!("${name}"));
        write(self);
        self.line("");
        self.line(&format!("$End{name}"));
    }
}

// A region: dimension, tag (of group and entity), name, and elements as lists of nodes from 1.
struct Block {
    dimension: usize,
    tag: i32,
    groups: Vec<(i32, String)>,
    elements: Vec<Vec<usize>>,
    code: i32,
}

// The vertices between which Gmsh's second-order nodes lie, in its order: edges, faces, the cell.
fn second_order(code: i32) -> Vec<Vec<usize>> {
    let lists: &[&[usize]] = match code {
        8 => &[&[0, 1]],
        9 => &[&[0, 1], &[1, 2], &[2, 0]],
        10 => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0], &[0, 1, 2, 3]],
        11 => &[&[0, 1], &[1, 2], &[2, 0], &[3, 0], &[3, 2], &[3, 1]],
        12 => &[
            &[0, 1],
            &[0, 3],
            &[0, 4],
            &[1, 2],
            &[1, 5],
            &[2, 3],
            &[2, 6],
            &[3, 7],
            &[4, 5],
            &[4, 7],
            &[5, 6],
            &[6, 7],
            &[0, 3, 2, 1],
            &[0, 1, 5, 4],
            &[0, 4, 7, 3],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[4, 5, 6, 7],
            &[0, 1, 2, 3, 4, 5, 6, 7],
        ],
        _ => &[],
    };
    lists.iter().map(|list| list.to_vec()).collect()
}

// Gmsh's list of nodes of an entity of a cell with these vertices, numbered from 1.
fn nodes_of<const D: usize>(mesh: &Mesh<D>, cell: usize, vertices: &[usize], code: i32) -> Vec<usize> {
    let nodes = mesh.cell(cell);
    let points = mesh.cell_element(cell).node_points::<D>();
    let between = second_order(code).into_iter().map(|list| {
        let middle: [f64; D] = std::array::from_fn(|k| {
            list.iter().map(|&place| points[vertices[place]][k]).sum::<f64>() / list.len() as f64
        });
        let near = |point: &[f64; D]| (0..D).all(|k| (point[k] - middle[k]).abs() < 1e-12);
        points.iter().position(near).expect("the element has a node there")
    });
    vertices.iter().copied().chain(between).map(|node| nodes[node] as usize + 1).collect()
}

fn blocks<const D: usize>(mesh: &Mesh<D>) -> Vec<Block> {
    let degree = mesh.degree() - 1;
    let codes = |cell: usize| {
        match mesh.cell_shape(cell) {
            CellShape::Triangle => [[2, 9], [1, 8]],
            CellShape::Quadrilateral => [[3, 10], [1, 8]],
            CellShape::Tetrahedron => [[4, 11], [2, 9]],
            CellShape::Hexahedron => [[5, 12], [3, 10]],
        }
        .map(|codes| codes[degree])
    };
    // In the plane the facets of all shapes are alike, and in space there is one shape.
    let [_, facet_code] = codes(0);
    let names: Vec<&str> = mesh.cell_region_names().filter(|name| *name != EVERYWHERE).collect();
    let mut blocks: Vec<Block> = Vec::new();
    for cell in 0..mesh.cell_count() {
        let [cell_code, _] = codes(cell);
        let vertices: Vec<usize> = (0..mesh.cell_shape(cell).vertices()).collect();
        // Cells of one shape in the same regions are one entity; an entity's cells follow each other.
        let mut groups: Vec<(i32, String)> = Vec::new();
        for (tag, name) in names.iter().enumerate() {
            if mesh.cell_region(name).expect("the name is listed").contains(&(cell as u32)) {
                groups.push((tag as i32 + 1, (*name).to_owned()));
            }
        }
        let element = nodes_of(mesh, cell, &vertices, cell_code);
        match blocks.last_mut() {
            Some(block) if block.groups == groups && block.code == cell_code => {
                block.elements.push(element);
            }
            _ => {
                let tag = blocks.len() as i32 + 1;
                blocks.push(Block { dimension: D, tag, groups, elements: vec![element], code: cell_code });
            }
        }
    }
    let exterior = mesh.facet_region_names().filter(|name| *name != BOUNDARY);
    let exterior = exterior.map(|name| (name, mesh.facet_region(name).expect("it is listed").to_vec()));
    let interior = mesh.interior_facet_region_names().filter(|name| *name != INTERIOR).map(|name| {
        let sides = mesh.interior_facet_region(name).expect("it is listed");
        (name, sides.iter().map(|sides| sides[0]).collect::<Vec<Facet>>())
    });
    for (place, (name, facets)) in exterior.chain(interior).enumerate() {
        let element = |facet: &Facet| {
            let vertices = mesh.cell_shape(facet.cell as usize).facet_vertices(facet.local.into());
            nodes_of(mesh, facet.cell as usize, vertices, facet_code)
        };
        let tag = place as i32 + 1;
        let elements = facets.iter().map(element).collect();
        blocks.push(Block {
            dimension: D - 1,
            tag,
            groups: vec![(tag, name.to_owned())],
            elements,
            code: facet_code,
        });
    }
    blocks
}

/// The bytes of a file.
pub fn write<const D: usize>(mesh: &Mesh<D>, format: Format) -> Vec<u8> {
    let blocks = blocks(mesh);
    let mut writer = Writer { bytes: vec![], format };
    let version = if format.is_version_4() { "4.1" } else { "2.2" };
    let size = if format == Format::Short4 { 4 } else { 8 };
    writer.section("MeshFormat", |writer| {
        writer.line(&format!("{version} {} {size}", u8::from(!format.is_text())));
        if !format.is_text() {
            writer.integer(1);
        }
    });
    writer.section("PhysicalNames", |writer| {
        let mut names: Vec<String> = blocks
            .iter()
            .flat_map(|block| {
                block.groups.iter().map(|(tag, name)| format!("{} {tag} \"{name}\"", block.dimension))
            })
            .collect();
        names.sort();
        names.dedup();
        writer.line(&names.len().to_string());
        names.iter().for_each(|name| writer.line(name));
    });
    if format.is_version_4() {
        version_4(&mut writer, mesh, &blocks);
    } else {
        version_2(&mut writer, mesh, &blocks);
    }
    writer.bytes
}

fn position<const D: usize>(node: &[f64; D]) -> [f64; 3] {
    std::array::from_fn(|k| node.get(k).copied().unwrap_or(0.0))
}

fn version_4<const D: usize>(writer: &mut Writer, mesh: &Mesh<D>, blocks: &[Block]) {
    writer.section("Entities", |writer| {
        for dimension in 0..4 {
            writer.size(blocks.iter().filter(|block| block.dimension == dimension).count());
        }
        writer.end_line();
        for dimension in 1..4 {
            for block in blocks.iter().filter(|block| block.dimension == dimension) {
                writer.integer(block.tag);
                writer.reals([0.0; 6]);
                writer.size(block.groups.len());
                block.groups.iter().for_each(|(tag, _)| writer.integer(*tag));
                // Two bounding entities, one against its direction.
                writer.size(2);
                writer.integer(1);
                writer.integer(-2);
                writer.end_line();
            }
        }
    });
    writer.section("Nodes", |writer| {
        let count = mesh.node_count();
        // Two blocks, the second one with parameters, and an empty one.
        let first = count / 2;
        [3, count, 1, count].into_iter().for_each(|size| writer.size(size));
        writer.end_line();
        for (range, parametric) in [(0..first, 0), (first..first, 0), (first..count, 1)] {
            writer.integer(D as i32);
            writer.integer(1);
            writer.integer(parametric);
            writer.size(range.len());
            writer.end_line();
            for node in range.clone() {
                writer.size(node + 1);
                writer.end_line();
            }
            for node in range {
                writer.reals(position(&mesh.nodes()[node]));
                writer.reals(vec![0.25; D * parametric as usize]);
                writer.end_line();
            }
        }
    });
    writer.section("Elements", |writer| {
        let count = blocks.iter().map(|block| block.elements.len()).sum();
        [blocks.len(), count, 1, count].into_iter().for_each(|size| writer.size(size));
        writer.end_line();
        let mut tag = 0;
        for block in blocks {
            [block.dimension as i32, block.tag, block.code].into_iter().for_each(|x| writer.integer(x));
            writer.size(block.elements.len());
            writer.end_line();
            for element in &block.elements {
                tag += 1;
                writer.size(tag);
                element.iter().for_each(|&node| writer.size(node));
                writer.end_line();
            }
        }
    });
}

fn version_2<const D: usize>(writer: &mut Writer, mesh: &Mesh<D>, blocks: &[Block]) {
    writer.section("Nodes", |writer| {
        writer.line(&mesh.node_count().to_string());
        for (node, x) in mesh.nodes().iter().enumerate() {
            writer.integer(node as i32 + 1);
            writer.reals(position(x));
            writer.end_line();
        }
    });
    writer.section("Elements", |writer| {
        // An element once per group, or once without one.
        let times = |block: &Block| block.groups.len().max(1);
        let count: usize = blocks.iter().map(|block| block.elements.len() * times(block)).sum();
        writer.line(&count.to_string());
        let mut tag = 0;
        for block in blocks {
            let groups: Vec<i32> = match block.groups.len() {
                0 => vec![0],
                _ => block.groups.iter().map(|(tag, _)| *tag).collect(),
            };
            if !writer.format.is_text() {
                let count = (block.elements.len() * groups.len()) as i32;
                [block.code, count, 2].into_iter().for_each(|x| writer.integer(x));
            }
            for element in &block.elements {
                for &group in &groups {
                    tag += 1;
                    writer.integer(tag);
                    if writer.format.is_text() {
                        writer.integer(block.code);
                        writer.integer(2);
                    }
                    writer.integer(group);
                    writer.integer(block.tag);
                    element.iter().for_each(|&node| writer.integer(node as i32));
                    writer.end_line();
                }
            }
        }
    });
}
