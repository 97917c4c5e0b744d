//! Reads the tokens that the attribute gives: per function, its integrals and their kernels.

use std::collections::BTreeMap;

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::punctuated::Punctuated;
use syn::{Expr, ExprStruct, FnArg, ImplItem, ImplItemFn, Item, ItemMod, Pat, Stmt, Token, Type};

use crate::dump::counts::operations;
use crate::tensor::Side;

use super::interpreter::{Scope, Value, evaluate, run};

/// The kernels of one function in one dimension, as emitted.
#[derive(Default)]
pub struct Function {
    /// Types of the constructor's arguments that are plain names.
    pub argument_types: Vec<String>,
    pub residual: Vec<Integral>,
    /// Joined on each region, completed by what is not joined; empty where nothing is.
    pub whole_residual: Vec<Integral>,
    pub whole_tangent: Vec<Integral>,
    pub tangent: Vec<Integral>,
    pub action: Vec<Integral>,
    /// The index of each unknown's direction among the fields.
    pub directions: Vec<usize>,
    pub switches: Vec<Integral>,
    /// Of a functional, or the value of an expression.
    pub density: Vec<Integral>,
}

/// A `contract::Integral` with its kernel.
#[derive(Clone)]
pub struct Integral {
    pub region: usize,
    pub displacement: String,
    /// Number of the test function, and its side.
    pub test: (usize, Side),
    /// Number of the unknown, and the trial function's side.
    pub trial: (usize, Side),
    pub dependence: String,
    pub symmetric: bool,
    pub kernel: Kernel,
}

/// One kernel.
#[derive(Clone)]
pub struct Kernel {
    pub constants: BTreeMap<String, Value>,
    new: syn::Block,
    methods: BTreeMap<String, ImplItemFn>,
}

impl Kernel {
    /// The kernel with its parameters.
    pub fn prepare(&self, parameters: &[f64]) -> Value {
        let mut scope = Scope::from([("parameters".to_string(), Value::numbers(parameters.iter().copied()))]);
        run(&self.new, &mut scope).expect("`new` gives the kernel")
    }

    /// Operations in a method's text, a multiply-add as one.
    pub fn operations(&self, method: &str) -> usize {
        let block = &self.methods[method].block;
        let parts = parts_of(block).map(|part| self.operations(&part.method)).sum::<usize>();
        let text = block.to_token_stream();
        let contracted = text.to_string().matches("multiply_add").count();
        operations(text) - contracted + parts
    }

    /// The result of a method, and what became of its arguments.
    pub fn call(
        &self,
        method: &str,
        prepared: Option<&Value>,
        arguments: &[Value],
    ) -> (Option<Value>, Scope) {
        let method = &self.methods[method];
        let mut scope = Scope::new();
        let mut arguments = arguments.iter();
        for input in &method.sig.inputs {
            match input {
                FnArg::Receiver(_) => {
                    scope.insert("self".into(), prepared.expect("a kernel with its parameters").clone());
                }
                FnArg::Typed(input) => {
                    let Pat::Ident(name) = &*input.pat else { panic!("an argument is a name") };
                    let value = arguments.next().expect("as many arguments as declared").clone();
                    check_length(&input.ty, &value);
                    scope.insert(name.ident.to_string(), value);
                }
            }
        }
        assert!(arguments.next().is_none(), "as many arguments as declared");
        let mut last = method.block.clone();
        for part in parts_of(&method.block) {
            let kept = self.run_part(&part, &scope);
            scope.insert(part.name, kept);
            last.stmts.remove(0);
        }
        let result = run(&last, &mut scope);
        if let (syn::ReturnType::Type(_, ty), Some(result)) = (&method.sig.output, &result) {
            check_length(ty, result);
        }
        (result, scope)
    }

    /// The array that a part keeps.
    fn run_part(&self, part: &Part, scope: &Scope) -> Value {
        let method = &self.methods[&part.method];
        let Some(FnArg::Typed(inputs)) = method.sig.inputs.last() else { panic!("a part takes a tuple") };
        let (Pat::Tuple(names), Type::Tuple(types)) = (&*inputs.pat, &*inputs.ty) else {
            panic!("a part takes a tuple");
        };
        assert_eq!(names.elems.len(), part.arguments.elems.len(), "as many arguments as declared");
        let mut inner = Scope::from([("self".to_string(), scope["self"].clone())]);
        for ((name, ty), argument) in names.elems.iter().zip(&types.elems).zip(&part.arguments.elems) {
            let Pat::Ident(name) = name else { panic!("an argument is a name") };
            let value = evaluate(argument, scope);
            check_length(ty, &value);
            inner.insert(name.ident.to_string(), value);
        }
        let kept = run(&method.block, &mut inner).expect("a part keeps something");
        let syn::ReturnType::Type(_, ty) = &method.sig.output else { panic!("a part keeps something") };
        check_length(ty, &kept);
        kept
    }
}

/// `let kept_0 = L::apart::<Self, 0>(self, (cell, geometry, fields));`, with the part's number in the array's name.
struct Part {
    name: String,
    method: String,
    arguments: syn::ExprTuple,
}

/// The parts that a function begins with.
fn parts_of(block: &syn::Block) -> impl Iterator<Item = Part> {
    block.stmts.iter().map_while(|statement| {
        let Stmt::Local(local) = statement else { return None };
        let (Pat::Ident(name), Expr::Call(call)) = (&local.pat, &*local.init.as_ref()?.expr) else {
            return None;
        };
        if !call.func.to_token_stream().to_string().replace(' ', "").starts_with("L::apart::<Self,") {
            return None;
        }
        let Expr::Tuple(arguments) = &call.args[1] else { panic!("a part takes a tuple") };
        let name = name.ident.to_string();
        Some(Part { method: name.replace("kept_", "part_"), name, arguments: arguments.clone() })
    })
}

/// `[L; 3]` has three entries.
fn check_length(ty: &Type, value: &Value) {
    let ty = match ty {
        Type::Reference(inner) => &*inner.elem,
        other => other,
    };
    if let Type::Array(array) = ty {
        let length = evaluate(&array.len, &Scope::new()).index();
        assert_eq!(value.list().len(), length, "the length of an emitted array");
    }
}

/// All functions of a module that was emitted for one dimension.
pub fn read(tokens: TokenStream) -> BTreeMap<String, Function> {
    let file: syn::File = syn::parse2(tokens).expect("emitted code is Rust");
    let mut functions: BTreeMap<String, Function> = BTreeMap::new();
    let mut argument_types: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for item in &file.items {
        let Item::Mod(module) = item else { panic!("the attribute gives one module") };
        for item in items(module) {
            match item {
                Item::Mod(function) => {
                    functions.insert(function.ident.to_string(), read_function(function));
                }
                Item::Fn(constructor) => {
                    let types = constructor.sig.inputs.iter().filter_map(plain_type).collect();
                    argument_types.insert(constructor.sig.ident.to_string(), types);
                }
                _ => {}
            }
        }
    }
    for (name, function) in &mut functions {
        function.argument_types = argument_types.remove(name).unwrap_or_default();
    }
    functions
}

/// `omega_region: &Omega` → `Omega`
fn plain_type(input: &FnArg) -> Option<String> {
    let FnArg::Typed(input) = input else { return None };
    let Type::Reference(reference) = &*input.ty else { return None };
    let Type::Path(path) = &*reference.elem else { return None };
    path.path.get_ident().map(ToString::to_string)
}

fn items(module: &ItemMod) -> &[Item] {
    module.content.as_ref().map_or(&[], |(_, items)| &items[..])
}

fn read_function(module: &ItemMod) -> Function {
    let mut kernels: BTreeMap<String, Kernel> = BTreeMap::new();
    for item in items(module) {
        if let Item::Mod(inner) = item {
            kernels.extend(read_kernels(inner));
        }
    }
    let mut function = Function::default();
    for item in items(module) {
        let Item::Impl(implementation) = item else { continue };
        let Some((name, _)) = &implementation.trait_ else { continue };
        if name.segments.last().is_none_or(|last| last.ident != "Integrals") {
            continue;
        }
        for item in &implementation.items {
            let ImplItem::Fn(method) = item else { continue };
            let list = match method.sig.ident.to_string().as_str() {
                "residual" => &mut function.residual,
                "joined_residual" => &mut function.whole_residual,
                "tangent" => &mut function.tangent,
                "joined_tangent" => &mut function.whole_tangent,
                "action" => &mut function.action,
                "fields" => {
                    function.directions = directions(&method.block);
                    continue;
                }
                "switches" => &mut function.switches,
                "density" => &mut function.density,
                _ => continue,
            };
            let Some(Stmt::Expr(Expr::Macro(terms), None)) = method.block.stmts.first() else {
                panic!("a list of terms")
            };
            let terms = terms.mac.parse_body_with(Punctuated::<ExprStruct, Token![,]>::parse_terminated);
            list.extend(terms.expect("a list of terms").iter().map(|term| read_term(term, &kernels)));
        }
    }
    function.complete_whole();
    function
}

impl Function {
    fn complete_whole(&mut self) {
        let joined: Vec<_> = self.whole_residual.iter().map(Integral::place).collect();
        if joined.is_empty() {
            return;
        }
        let apart = |integral: &&Integral| !joined.contains(&integral.place());
        self.whole_residual.extend(self.residual.iter().filter(apart).cloned().collect::<Vec<_>>());
        self.whole_tangent.extend(self.tangent.iter().filter(apart).cloned().collect::<Vec<_>>());
    }
}

impl Integral {
    fn place(&self) -> (usize, String) {
        (self.region, self.displacement.clone())
    }
}

/// The places of `role: contract::Role::Direction(0)`, `Direction(1)`, .. in the list that the block gives.
fn directions(block: &syn::Block) -> Vec<usize> {
    let Some(Stmt::Expr(Expr::Reference(list), None)) = block.stmts.first() else {
        panic!("a list of fields")
    };
    let Expr::Array(list) = &*list.expr else { panic!("a list of fields") };
    let texts: Vec<String> = list.elems.iter().map(|one| one.to_token_stream().to_string()).collect();
    let place =
        |number: usize| texts.iter().position(|text| text.contains(&format!("Direction ({number}usize)")));
    (0..).map_while(place).collect()
}

/// `contract::Term { integral: &kernels_2::Tangent0::INTEGRAL, kernel: B::bilinear(kernels_2::Tangent0::new(..)) }`
fn read_term(term: &ExprStruct, kernels: &BTreeMap<String, Kernel>) -> Integral {
    let Some(Expr::Call(taken)) = term.fields.iter().nth(1).map(|member| &member.expr) else {
        panic!("a term has a kernel")
    };
    let Some(Expr::Call(new)) = taken.args.first() else { panic!("a backend takes a new kernel") };
    let Expr::Path(path) = &*new.func else { panic!("a kernel is made by `new`") };
    let kernel = path.path.segments.iter().nth_back(1).expect("a kernel's name").ident.to_string();
    let kernel = &kernels[&kernel];
    let Value::Structure(members) = &kernel.constants["INTEGRAL"] else { panic!("an integral's members") };
    let side = |name: &str| match members[name].word() {
        "This" => Side::This,
        "Other" => Side::Other,
        other => panic!("the side is {other}"),
    };
    Integral {
        region: members["region"].index(),
        displacement: format!("{:?}", members["displacement"]),
        test: (members["test"].index(), side("test_side")),
        trial: (members["trial"].index(), side("trial_side")),
        dependence: members["dependence"].word().to_string(),
        symmetric: members["symmetric"].truth(),
        kernel: kernel.clone(),
    }
}

/// The members of an integral's description, without its degree, about which nothing is proved here.
fn members(integral: &syn::ExprStruct) -> Value {
    let known = integral
        .fields
        .iter()
        .filter(|member| !matches!(&member.member, syn::Member::Named(name) if name == "degree"));
    let members = known.map(|member| match &member.member {
        syn::Member::Named(name) => (name.to_string(), evaluate(&member.expr, &Scope::new())),
        syn::Member::Unnamed(_) => panic!("members have names"),
    });
    Value::Structure(members.collect())
}

fn read_kernels(module: &ItemMod) -> BTreeMap<String, Kernel> {
    let mut kernels: BTreeMap<String, Kernel> = BTreeMap::new();
    for item in items(module) {
        let Item::Impl(implementation) = item else { continue };
        let Type::Path(name) = &*implementation.self_ty else { continue };
        let name = name.path.get_ident().expect("a kernel's name").to_string();
        let kernel = kernels.entry(name).or_insert_with(|| Kernel {
            constants: BTreeMap::new(),
            new: syn::parse_quote!({}),
            methods: BTreeMap::new(),
        });
        for item in &implementation.items {
            match item {
                ImplItem::Fn(method) if method.sig.ident == "new" => kernel.new = method.block.clone(),
                ImplItem::Fn(method) => {
                    kernel.methods.insert(method.sig.ident.to_string(), method.clone());
                }
                ImplItem::Const(constant) => {
                    let value = match &constant.expr {
                        Expr::Struct(integral) if constant.ident == "INTEGRAL" => members(integral),
                        other => evaluate(other, &Scope::new()),
                    };
                    kernel.constants.insert(constant.ident.to_string(), value);
                }
                _ => {}
            }
        }
    }
    kernels
}
