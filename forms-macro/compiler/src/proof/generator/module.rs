//! A random module: data, regions, functions that others call, and one function of each kind of result.

use super::expression::{Callable, Limits, Name, Writer};
use super::{Choices, Shape};

/// The text of a module that the compiler must accept in this dimension.
pub fn module(list: &[u32], dimension: usize) -> String {
    let mut choices = Choices::new(list);
    let choices = &mut choices;
    let order = if crate::check::builtins::builtin("hess").is_some() { 2 } else { 1 };
    let kind = choices.below(6);
    let (mut data, mut members) = (String::new(), Vec::new());
    for index in 0..choices.below(4) {
        let shape = *choices.one_of(&Shape::FIELDS);
        let (letter, ty) = *choices.one_of(&[("p", "Param"), ("g", "Given"), ("c", "Carried")]);
        let given = ty != "Param";
        let text = format!("{letter}{index}");
        data += &format!("        pub {text}: {ty}<{}>,\n", shape.name());
        members.push(Name { text, shape, field: given, variable: true, order: 0, smooth: true });
    }
    let mut text = format!("    pub struct Data {{\n{data}    }}\n");
    text += "    #[cells]\n    pub struct Omega;\n    #[facets]\n    pub struct Gamma;\n    #[interior_facets]\n    pub struct Skeleton;\n";

    let mut functions: Vec<Callable> = Vec::new();
    for index in 0..choices.below(3) {
        let (function, written) = helper(choices, dimension, &members, &functions, index);
        functions.push(function);
        text += &written;
    }

    let (mut names, mut tests, mut arguments) = (Vec::new(), Vec::new(), Vec::new());
    let mut declare =
        |letter: &str, role: &str, count: usize, choices: &mut Choices, list: &mut Vec<Name>| {
            for index in 0..count {
                let shape = *choices.one_of(&Shape::FIELDS);
                let name = format!("{letter}{index}");
                arguments.push(match role {
                    "" => format!("{name}: {}", shape.name()),
                    _ => format!("{name}: {role}<{}>", shape.name()),
                });
                list.push(Name { text: name, shape, field: true, variable: true, order: 0, smooth: true });
            }
        };
    // Forms are the likeliest.
    let (role, result) = match kind {
        0..3 => ("Unknown", "Form"),
        3 => ("Unknown", "Energy"),
        4 => ("State", "Functional"),
        _ => ("State", *choices.one_of(&["Scalar", "Vector", "Tensor"])),
    };
    let unknowns = 1 + choices.below(2);
    declare("u", role, unknowns, choices, &mut names);
    if result == "Form" {
        let count = 1 + choices.below(2);
        declare("v", "Test", count, choices, &mut tests);
    }
    let states = choices.below(2);
    declare("s", "State", states, choices, &mut names);
    names.extend(members);
    let arguments = arguments.join(", ");

    let mut writer = Writer { choices, dimension, names, tests, functions: &functions, lets: 0 };
    let body = match result {
        "Scalar" | "Vector" | "Tensor" => {
            let shape = Shape::FIELDS.into_iter().find(|shape| shape.name() == result);
            let limits = Limits {
                size: 12,
                order,
                smooth: false,
                facets: false,
                sideless: false,
                means: true,
                test: None,
            };
            writer.expression(shape.unwrap_or(Shape::Scalar), limits)
        }
        _ => integrals(&mut writer, order),
    };
    text += &format!("    pub fn form({arguments}) -> {result} {{\n        {body}\n    }}\n");
    format!("pub mod random {{\n{text}}}\n")
}

/// A function of plain arguments.
fn helper(
    choices: &mut Choices,
    dimension: usize,
    members: &[Name],
    functions: &[Callable],
    index: usize,
) -> (Callable, String) {
    let result = *choices.one_of(&Shape::FIELDS);
    let order = choices.below(2);
    let arguments: Vec<Shape> = (0..1 + choices.below(2)).map(|_| *choices.one_of(&Shape::FIELDS)).collect();
    let own = arguments.iter().enumerate().map(|(number, shape)| Name {
        text: format!("a{number}"),
        shape: *shape,
        // Whatever the caller passes: it has derivatives, yet `derivative` may not name it.
        field: true,
        variable: false,
        order: 0,
        smooth: true,
    });
    let names = own.chain(members.iter().cloned()).collect();
    let text = format!("helper{index}");
    let declared: Vec<String> =
        arguments.iter().enumerate().map(|(number, shape)| format!("a{number}: {}", shape.name())).collect();
    let mut writer = Writer { choices, dimension, names, tests: vec![], functions, lets: 0 };
    let limits =
        Limits { size: 5, order, smooth: true, facets: false, sideless: false, means: false, test: None };
    let body = writer.expression(result, limits);
    let declared = declared.join(", ");
    let written = format!("    fn {text}({declared}) -> {} {{\n        {body}\n    }}\n", result.name());
    (Callable { text, arguments, result, order }, written)
}

/// A sum of integrals over both regions.
fn integrals(writer: &mut Writer, order: usize) -> String {
    let mut sum = String::new();
    for index in 0..1 + writer.choices.below(3) {
        let region = *writer.choices.one_of(&["Omega", "Gamma", "Omega", "Skeleton"]);
        let (facets, sideless) = (region != "Omega", region == "Skeleton");
        let test = match writer.tests.len() {
            0 => None,
            count => Some(writer.choices.below(count)),
        };
        let limits = Limits { size: 14, order, smooth: false, facets, sideless, means: true, test };
        let density = writer.expression(Shape::Scalar, limits);
        let mut integral = format!("integral({region}, {density})");
        // The measure moves, too; everything in the integral must have a derivative by the shape.
        if writer.choices.below(4) == 1 && order >= 1 {
            let smooth = Limits {
                size: 8,
                order: order - 1,
                smooth: true,
                facets: false,
                sideless,
                means: false,
                test,
            };
            let theta = Limits { size: 4, sideless: false, means: true, test: None, ..smooth };
            let density = writer.expression(Shape::Scalar, smooth);
            let theta = writer.expression(Shape::Vector, theta);
            integral = format!("derivative(integral({region}, {density}), shape, {theta})");
        }
        let parameters = writer.names.iter().filter(|name| !name.field && name.shape == Shape::Scalar);
        let parameter = parameters.map(|name| name.text.clone()).next().unwrap_or("3".into());
        sum += &match (index, writer.choices.below(4)) {
            (0, _) => integral,
            (_, 0) => format!(" + {integral}"),
            (_, 1) => format!(" - {integral}"),
            (_, 2) => format!(" + {parameter} * {integral}"),
            _ => format!(" - {integral} / 2"),
        };
    }
    sum
}
