//! After `optimise`: the scalars, and each integral with its plan and what the others would have cost.

use super::{Dump, costs};
use crate::optimise::linear::{Coefficients, SidedField};
use crate::optimise::plan::BilinearPlan;
use crate::optimise::scalar::{Derivative, Graph, Node, Scalar};
use crate::optimise::{BilinearIntegral, Description, Optimised};
use crate::parse::syntax::Module;
use crate::tensor::{FieldInfo, Side};

impl Dump {
    /// Scalars, then residual, tangent, switches, density and value in terms of them.
    pub fn optimised(&mut self, module: &Module, optimised: &Optimised) {
        let name = module.functions[optimised.function].name.to_string();
        if !self.wants(&name, optimised.dimension) {
            return;
        }
        self.heading("optimised", &name, optimised.dimension);
        let Optimised { graph, fields, .. } = optimised;
        self.text += "scalars:\n";
        for scalar in graph.reachable(&roots(optimised)) {
            self.text += &format!("  s{} = {}\n", scalar.0, node(graph, scalar, fields));
        }
        for (what, integrals) in [
            ("residual", &optimised.residual),
            ("whole residual", &optimised.joined),
            ("action", &optimised.action),
        ] {
            for integral in integrals {
                self.text += &format!(
                    "{what} {}, tested by {}\n{}",
                    description(&integral.description, module),
                    sided(integral.test, fields),
                    coefficients(&integral.flux)
                );
                self.text += &costs::of_linear(integral, optimised, module);
            }
        }
        for (what, integrals) in
            [("tangent", &optimised.tangent), ("whole tangent", &optimised.joined_tangent)]
        {
            for integral in integrals {
                self.text += &tangent(what, integral, graph, module, fields);
            }
        }
        for (what, integrals) in [("switches", &optimised.switches), ("density", &optimised.density)] {
            for integral in integrals {
                self.text += &format!(
                    "{what} {}: {}\n",
                    description(&integral.description, module),
                    list(&integral.components)
                );
            }
        }
        if let Some((components, shape)) = &optimised.value {
            self.text += &format!("value {shape:?}: {}\n", list(components));
        }
    }
}

fn roots(optimised: &Optimised) -> Vec<Scalar> {
    let mut roots: Vec<Scalar> = Vec::new();
    for integral in optimised.residual.iter().chain(&optimised.joined).chain(&optimised.action) {
        roots.extend(integral.flux.values());
    }
    for integral in optimised.tangent.iter().chain(&optimised.joined_tangent) {
        roots.extend(integral.plan.roots());
    }
    for integral in optimised.switches.iter().chain(&optimised.density) {
        roots.extend(&integral.components);
    }
    roots.extend(optimised.value.iter().flat_map(|(components, _)| components));
    roots
}

fn tangent(
    what: &str,
    integral: &BilinearIntegral,
    graph: &Graph,
    module: &Module,
    fields: &[FieldInfo],
) -> String {
    let mut text = format!(
        "{what} {}, {} with {}, {}\n",
        description(&integral.description, module),
        sided(integral.test, fields),
        sided(integral.trial, fields),
        if integral.symmetric { "symmetric" } else { "not proved symmetric" }
    );
    text += &costs::of_bilinear(integral, graph, module);
    let BilinearPlan { tests, trials, sums, block } = &integral.plan;
    text += &format!("  test factors: {}\n  trial factors: {}\n", list(tests), list(trials));
    for (index, products) in sums.iter().enumerate() {
        let products =
            products.iter().map(|(test, trial)| format!("s{} s{}", tests[*test].0, trials[*trial].0));
        text += &format!("  A{index} = Σ {}\n", products.collect::<Vec<_>>().join(" + "));
    }
    text += &format!("  block: {}\n", list(block));
    text
}

fn description(description: &Description, module: &Module) -> String {
    format!("on {}, {:?}", module.regions[description.region].name, description.dependence)
}

fn sided(function: SidedField, fields: &[FieldInfo]) -> String {
    let name = &fields[function.field].name;
    match function.side {
        Side::This => name.clone(),
        side => format!("{name} ({side:?})"),
    }
}

fn coefficients(flux: &Coefficients) -> String {
    flux.iter()
        .map(|((component, order), scalar)| {
            format!("  s{} × {} of component {component}\n", scalar.0, derivative(*order, "φ"))
        })
        .collect()
}

/// A derivative of a basis function.
fn derivative(derivative: Derivative, basis: &str) -> String {
    match format!("{derivative:?}").as_str() {
        "Value" => basis.into(),
        other => format!("{other} {basis}"),
    }
}

fn list(scalars: &[Scalar]) -> String {
    let names: Vec<String> = scalars.iter().map(|scalar| format!("s{}", scalar.0)).collect();
    format!("[{}]", names.join(", "))
}

fn node(graph: &Graph, scalar: Scalar, fields: &[FieldInfo]) -> String {
    match graph.node(scalar) {
        Node::Number(bits) => f64::from_bits(*bits).to_string(),
        Node::Parameter(index) => format!("parameters[{index}]"),
        Node::Field { field, side, component, derivative: order } => {
            let name = sided(SidedField { field: *field, side: *side }, fields);
            derivative(*order, &format!("{name}[{component}]"))
        }
        Node::Accumulated(index) => format!("A{index}"),
        Node::Sum { constant, terms } => {
            let constant = f64::from_bits(*constant);
            let first = (constant != 0.0).then(|| constant.to_string());
            let terms = terms.iter().map(|(coefficient, term)| match f64::from_bits(*coefficient) {
                1.0 => format!("s{}", term.0),
                coefficient => format!("{coefficient} s{}", term.0),
            });
            first.into_iter().chain(terms).collect::<Vec<_>>().join(" + ")
        }
        Node::Product(factors) => {
            let factors = factors.iter().map(|(factor, exponent)| match exponent {
                1 => format!("s{}", factor.0),
                exponent => format!("s{}^{exponent}", factor.0),
            });
            factors.collect::<Vec<_>>().join(" ")
        }
        other => format!("{other:?}").replace("Scalar(", "(s"),
    }
}
