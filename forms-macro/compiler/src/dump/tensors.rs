//! Tensor nodes as text: one line per node, operands first.

use crate::tensor::{Arena, FieldInfo, Operator, Tensor};

/// The nodes that `roots` are made of: `t7 [2, 2] = Scale(t3, t6)`.
pub fn lines(arena: &Arena, fields: &[FieldInfo], roots: &[Tensor]) -> String {
    let mut text = String::new();
    for node in arena.reachable(roots) {
        let shape = arena.shape(node);
        text += &format!("  t{} {shape:?} = {}\n", node.0, operator(&arena.node(node).operator, fields));
    }
    text
}

/// An operator by its own name, with fields by theirs.
fn operator(operator: &Operator, fields: &[FieldInfo]) -> String {
    let mut text = format!("{operator:?}");
    for (index, field) in fields.iter().enumerate() {
        for end in [",", " }"] {
            text = text.replace(&format!("field: {index}{end}"), &format!("field: {}{end}", field.name));
        }
    }
    text.replace("Tensor(", "t(").split("t(").enumerate().fold(String::new(), |text, (index, part)| {
        match (index, part.split_once(')')) {
            (0, _) | (_, None) => text + part,
            (_, Some((number, rest))) => text + "t" + number + rest,
        }
    })
}

/// The fields of a function: name, role, shape.
pub fn field_lines(fields: &[FieldInfo]) -> String {
    fields.iter().map(|field| format!("  {}: {:?} {:?}\n", field.name, field.role, field.shape)).collect()
}
