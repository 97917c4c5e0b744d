//! Instructions → straight-line Rust.

use std::collections::HashMap;

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::external::ExternalNames;
use super::parts::parts;
use crate::optimise::scalar::Node;
use crate::optimise::straight_line::{Code, Instruction, Level, Value};
use crate::sorted::SortedSet;
use crate::tensor::{External, Function};

/// Names of a block at most. Each `let` opens a scope inside the last, and where rustc writes debug information its stack
/// ends between 1,600 and 3,000 of them.
const NAMES: usize = 500;

/// The text of one function, and what it wants from the functions before it.
pub struct Body {
    pub statements: TokenStream,
    pub results: Vec<TokenStream>,
    /// Number of operations.
    pub operations: usize,
}

/// The text of one part of a function, with the values that it keeps.
pub struct PartBody {
    pub statements: TokenStream,
    pub results: Vec<TokenStream>,
}

/// The name of the array that a part leaves to later ones.
pub fn kept_name(part: usize) -> Ident {
    format_ident!("kept_{part}")
}

/// The text by which each value is read.
type Texts = HashMap<Value, TokenStream>;

/// One `let`.
struct Line {
    value: Value,
    name: Ident,
    right: TokenStream,
    reads: Vec<Value>,
}

impl Line {
    /// Gives the value a name, by which later lines read it.
    fn new(value: Value, right: TokenStream, reads: Vec<Value>, texts: &mut Texts) -> Self {
        let name = format_ident!("t{}", value.0);
        texts.insert(value, quote! { #name });
        Line { value, name, right, reads }
    }
}

/// The lines in blocks of a bounded number; each leaves what later ones, or the results, read.
fn in_blocks(lines: &[Line], results: &[Value]) -> TokenStream {
    let blocks: Vec<&[Line]> = lines.chunks(NAMES).collect();
    let mut last_reader: HashMap<Value, usize> = HashMap::new();
    for (number, block) in blocks.iter().enumerate() {
        last_reader.extend(block.iter().flat_map(|line| line.reads.iter().map(|value| (*value, number))));
    }
    last_reader.extend(results.iter().map(|value| (*value, blocks.len())));
    let mut text = TokenStream::new();
    for (number, block) in blocks.iter().enumerate() {
        let lets: TokenStream =
            block.iter().map(|Line { name, right, .. }| quote! { let #name = #right; }).collect();
        if number + 1 == blocks.len() {
            text.extend(lets);
            continue;
        }
        let kept =
            block.iter().filter(|line| last_reader.get(&line.value).is_some_and(|reader| *reader > number));
        let kept: Vec<&Ident> = kept.map(|line| &line.name).collect();
        text.extend(quote! { let (#(#kept,)*) = { #lets (#(#kept,)*) }; });
    }
    text
}

/// Values that one function leaves to later ones, in the order of their slots.
#[derive(Default)]
pub struct Store {
    pub values: Vec<Value>,
}

impl Store {
    fn slot(&mut self, value: Value) -> usize {
        self.values.iter().position(|known| *known == value).unwrap_or_else(|| {
            self.values.push(value);
            self.values.len() - 1
        })
    }
}

/// Keeps what a function asks of the functions before it: values known with the form's parameters,
/// and values of the cell.
pub struct Demand<'s> {
    pub form: &'s mut Store,
    pub cell: &'s mut Store,
}

impl Demand<'_> {
    /// The text of an earlier value in a function that sees `self.form` and `cell`.
    pub fn text(&mut self, value: Value, level: Level) -> TokenStream {
        match level {
            Level::Form => {
                let slot = self.form.slot(value);
                quote! { L::splat(self.form[#slot]) }
            }
            _ => self.in_lanes(value),
        }
    }

    /// The same in all lanes already: a product reads it from memory, where a number would be spread by an instruction of its own.
    pub fn in_lanes(&mut self, value: Value) -> TokenStream {
        let slot = self.cell.slot(value);
        quote! { cell[#slot] }
    }
}

/// The text of an earlier value in a function that sees only what the point left.
pub fn from_point(store: &mut Store, value: Value) -> TokenStream {
    let slot = store.slot(value);
    quote! { point[#slot] }
}

/// Writes the functions of one kernel.
pub struct Printer<'a> {
    pub code: &'a Code<'a>,
    pub externals: &'a ExternalNames,
}

impl Printer<'_> {
    /// Prints the function of a level that computes `roots`. Terminals are printed by `terminal`;
    /// values of earlier levels are asked for by `earlier`, which gives their text.
    pub fn print(
        &self,
        roots: &[Value],
        level: Level,
        terminal: &dyn Fn(&Node) -> TokenStream,
        earlier: &mut dyn FnMut(Value, Level) -> TokenStream,
    ) -> Body {
        let own = self.code.own(roots, level);
        let operations = self.code.operations(&own);
        let mut texts = Texts::new();
        let statements = self.statements(&own, roots, terminal, earlier, &mut texts);
        let results = roots.iter().map(|root| self.text(*root, earlier, &mut texts)).collect();
        Body { statements, results, operations }
    }

    /// The same in parts, each a function of its own where there are several.
    pub fn print_in_parts(
        &self,
        roots: &[Value],
        level: Level,
        terminal: &dyn Fn(&Node) -> TokenStream,
        earlier: &mut dyn FnMut(Value, Level) -> TokenStream,
    ) -> (Vec<PartBody>, Body) {
        let own = self.code.own(roots, level);
        let parts = parts(self.code, &own, roots);
        if parts.len() == 1 {
            return (vec![], self.print(roots, level, terminal, earlier));
        }
        let mut known = Texts::new();
        let mut bodies = vec![];
        for (number, part) in parts.iter().enumerate() {
            let mut texts = known.clone();
            let statements = self.statements(&part.values, &part.kept, terminal, earlier, &mut texts);
            let results = part.kept.iter().map(|value| self.text(*value, earlier, &mut texts)).collect();
            bodies.push(PartBody { statements, results });
            let array = kept_name(number);
            known
                .extend(part.kept.iter().enumerate().map(|(slot, value)| (*value, quote! { #array[#slot] })));
        }
        // Inputs that are results themselves.
        let inputs: Vec<Value> =
            own.iter().copied().filter(|value| roots.contains(value) && !known.contains_key(value)).collect();
        let statements = self.statements(&inputs, roots, terminal, earlier, &mut known);
        let results = roots.iter().map(|root| self.text(*root, earlier, &mut known)).collect();
        let operations = parts.iter().map(|part| self.code.operations(&part.values)).sum();
        (bodies, Body { statements, results, operations })
    }

    /// A `let` for each value, and for each constant before the first of several that read it; `results` are read at the end.
    fn statements(
        &self,
        values: &[Value],
        results: &[Value],
        terminal: &dyn Fn(&Node) -> TokenStream,
        earlier: &mut dyn FnMut(Value, Level) -> TokenStream,
        texts: &mut Texts,
    ) -> TokenStream {
        let named = self.constants_read_twice(values);
        let mut lines = Vec::with_capacity(values.len());
        for value in values {
            let reads = self.code.instruction(*value).operands();
            for constant in reads.iter().filter(|operand| named.contains(operand)) {
                if !texts.contains_key(constant) {
                    let right = self.text(*constant, earlier, texts);
                    lines.push(Line::new(*constant, right, vec![], texts));
                }
            }
            let right = self.print_instruction(*value, terminal, earlier, texts);
            lines.push(Line::new(*value, right, reads, texts));
        }
        in_blocks(&lines, results)
    }

    /// Numbers, and values known with the parameters, that more than one of these instructions reads. Named, they are spread over
    /// the lanes, and read by rustc, once.
    fn constants_read_twice(&self, values: &[Value]) -> SortedSet<Value> {
        let mut read: Vec<Value> = values
            .iter()
            .flat_map(|value| self.code.instruction(*value).operands())
            .filter(|operand| {
                matches!(self.code.instruction(*operand), Instruction::Number(_))
                    || self.code.level(*operand) == Level::Form
            })
            .collect();
        read.sort_unstable();
        read.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect()
    }

    fn text(
        &self,
        value: Value,
        earlier: &mut dyn FnMut(Value, Level) -> TokenStream,
        texts: &mut Texts,
    ) -> TokenStream {
        if let Some(text) = texts.get(&value) {
            return text.clone();
        }
        let text = match self.code.instruction(value) {
            Instruction::Number(bits) => print_number(f64::from_bits(*bits)),
            _ => earlier(value, self.code.level(value)),
        };
        texts.insert(value, text.clone());
        text
    }

    fn print_instruction(
        &self,
        value: Value,
        terminal: &dyn Fn(&Node) -> TokenStream,
        earlier: &mut dyn FnMut(Value, Level) -> TokenStream,
        texts: &mut Texts,
    ) -> TokenStream {
        use Instruction::*;
        let instruction = self.code.instruction(value).clone();
        let operands: Vec<TokenStream> =
            instruction.operands().iter().map(|operand| self.text(*operand, earlier, texts)).collect();
        let [a, b, c] = std::array::from_fn(|index| operands.get(index).cloned().unwrap_or_default());
        match instruction {
            Number(bits) => print_number(f64::from_bits(bits)),
            Terminal(scalar) => terminal(self.code.graph.node(scalar)),
            Add(..) => quote! { #a + #b },
            Subtract(..) => quote! { #a - #b },
            Multiply(..) => quote! { #a * #b },
            MultiplyAdd(..) => quote! { L::multiply_add(#a, #b, #c) },
            // Processors have an instruction for it, which compilers find.
            MultiplySubtract(..) => quote! { L::multiply_add(-#a, #b, #c) },
            Divide(..) => quote! { #a / #b },
            Negate(_) => quote! { -#a },
            Apply(function, _) => {
                let name = format_ident!("{}", function_name(function));
                quote! { L::#name(#a) }
            }
            Power(..) => quote! { L::powf(#a, #b) },
            Atan2(..) => quote! { L::atan2(#a, #b) },
            Minimum(..) => quote! { L::minimum(#a, #b) },
            Maximum(..) => quote! { L::maximum(#a, #b) },
            Select(..) => quote! { L::select(#a, #b, #c) },
            Less(..) => quote! { L::less(#a, #b) },
            LessEqual(..) => quote! { L::less_equal(#a, #b) },
            Equal(..) => quote! { L::equal(#a, #b) },
            And(..) => quote! { L::and(#a, #b) },
            Or(..) => quote! { L::or(#a, #b) },
            Not(_) => quote! { L::not(#a) },
            Entry(_, list, output) => quote! { #a[#list][#output] },
            Call { function, outputs, derivatives, .. } => {
                self.print_call(value, function, &operands, outputs, &derivatives)
            }
        }
    }
}

impl Printer<'_> {
    /// One array per list of inputs to differentiate by, with all outputs.
    fn print_call(
        &self,
        value: Value,
        function: External,
        inputs: &[TokenStream],
        outputs: usize,
        derivatives: &[Vec<usize>],
    ) -> TokenStream {
        let order = derivatives.first().map_or(0, Vec::len);
        let name = match function {
            External::Table(member) => {
                let index = self.externals.tables[member];
                let tables = match self.code.level(value) {
                    Level::Form => quote! { tables },
                    _ => quote! { self.tables },
                };
                return quote! { [[contract::tabulated(&#tables[#index], #order, #(#inputs),*)]] };
            }
            External::Function(index) => {
                let name = &self.externals.functions[index];
                quote! { super::super::#name }
            }
            External::TensorExponential => quote! { contract::TensorExponential },
            External::TensorLogarithm => quote! { contract::TensorLogarithm },
            External::TensorSquareRoot => quote! { contract::TensorSquareRoot },
        };
        let number = (0..order).fold(quote! { f64 }, |inner, _| quote! { contract::Dual<#inner> });
        let (input_count, count) = (inputs.len(), derivatives.len());
        quote! {
            contract::external::<#name, #number, L, #input_count, #outputs, #count, #order>(
                [#(#inputs),*],
                [#([#(#derivatives),*]),*],
            )
        }
    }
}

fn print_number(value: f64) -> TokenStream {
    if value.is_nan() {
        quote! { L::splat(f64::NAN) }
    } else if value.is_infinite() {
        if value > 0.0 {
            quote! { L::splat(f64::INFINITY) }
        } else {
            quote! { L::splat(f64::NEG_INFINITY) }
        }
    } else if value < 0.0 {
        let value = -value;
        quote! { L::splat(-#value) }
    } else {
        quote! { L::splat(#value) }
    }
}

/// Name of the `Lane` method; the kinks have become selects.
fn function_name(function: Function) -> &'static str {
    match function {
        Function::Sqrt => "sqrt",
        Function::Exp => "exp",
        Function::Ln => "ln",
        Function::Sin => "sin",
        Function::Cos => "cos",
        Function::Tan => "tan",
        Function::Asin => "asin",
        Function::Acos => "acos",
        Function::Atan => "atan",
        Function::Sinh => "sinh",
        Function::Cosh => "cosh",
        Function::Tanh => "tanh",
        Function::Asinh => "asinh",
        Function::Acosh => "acosh",
        Function::Atanh => "atanh",
        Function::Log10 => "log10",
        Function::Erf => "erf",
        Function::Erfc => "erfc",
        Function::Abs
        | Function::Sign
        | Function::Heaviside
        | Function::PositivePart
        | Function::NegativePart => "abs",
    }
}
