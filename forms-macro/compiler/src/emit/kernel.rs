//! Kernels: `impl LinearKernel<D>`, `impl BilinearKernel<D>`, `impl ExpressionKernel<D>`.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::external::ExternalNames;
use super::layout::{Layout, PointsOf};
use super::print::{Demand, PartBody, Printer, Store, from_point, kept_name};
use crate::optimise::linear::{Coefficients, of_component};
use crate::optimise::plan::BilinearPlan;
use crate::optimise::scalar::{Argument, Derivative, Graph, Node, Scalar};
use crate::optimise::straight_line::{Code, Level, Value};
use crate::optimise::{BilinearIntegral, varies_over_cell};
use crate::options::Points;
use crate::tensor::{FieldInfo, Geometry};

/// `contract::Operations`.
fn operations([point, test, trial, pair, finish]: [usize; 5]) -> TokenStream {
    quote! {
        contract::Operations { point: #point, test: #test, trial: #trial, pair: #pair, finish: #finish }
    }
}

/// The text of a function at a point.
struct PointFunction {
    /// Functions of its own for its parts, where it is long.
    parts: TokenStream,
    /// Implementations by which a lane calls them with its own instructions.
    entries: TokenStream,
    statements: TokenStream,
    operations: usize,
}

/// Movement of the points of an integral.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    Fixed,
    /// An unknown displaces them.
    Slides,
    /// An unknown of an energy displaces them, which is to be differentiated twice.
    OfEnergy,
    /// A level set function cuts the body.
    ByLevelSet,
}

/// Writes the kernels of one function in one dimension.
pub struct KernelWriter<'a> {
    pub graph: &'a mut Graph,
    pub fields: &'a [FieldInfo],
    pub externals: &'a ExternalNames,
    pub dimension: usize,
    /// The points of the integral that is written.
    pub points_of: PointsOf,
    /// Whether kernels for derivatives by points are wanted.
    pub points: Points,
}

impl KernelWriter<'_> {
    /// Σ over slots of coefficient × weight × basis, per test component.
    pub fn linear(&mut self, name: &Ident, test: usize, flux: &Coefficients, motion: Motion) -> TokenStream {
        let d = self.dimension;
        let components: usize = self.fields[test].shape.iter().product();
        let weight = self.graph.intern(Node::Weight);
        let mut roots = Vec::new();
        for component in 0..components {
            let mut parts = Vec::new();
            for (derivative, coefficient) in of_component(flux, component) {
                let basis = self.graph.intern(Node::Basis(Argument::Test, derivative));
                parts.push(self.graph.product(&[(coefficient, 1), (weight, 1), (basis, 1)]));
            }
            roots.push(self.graph.sum(&parts));
        }
        let layout = Layout::new(self.graph, self.fields, self.dimension, &roots).on(self.points_of);
        let mut code = Code::new(self.graph, &roots);
        let values: Vec<Value> = roots.iter().map(|root| code.lower(*root)).collect();

        let printer = Printer { code: &code, externals: self.externals };
        let (mut form, mut cell, mut point) = (Store::default(), Store::default(), Store::default());
        let test_body = printer.print(&values, Level::Node, &|node| self.basis(node), &mut |value, _| {
            from_point(&mut point, value)
        });
        let (test_statements, test_results) = (test_body.statements, test_body.results);
        let point_function =
            self.point_function(name, &printer, &point.values, &layout, &mut form, &mut cell);
        let cell_function = self.cell_function(&printer, &cell, &mut form);
        let structure = self.structure(name, &printer, &form, &point_function);
        let point_statements = &point_function.statements;
        let (cell_count, point_count) = (cell.values.len(), point.values.len());
        let requirements = &layout.requirements;
        let operations = operations([point_function.operations, test_body.operations, 0, 0, 0]);
        let motion = match motion {
            Motion::Fixed => None,
            Motion::Slides => Some(quote! { const SLIDES: bool = true; }),
            Motion::OfEnergy => Some(quote! { const SLIDES: bool = true; const OF_ENERGY: bool = true; }),
            Motion::ByLevelSet => Some(quote! { const MOVED_BY_LEVEL_SET: bool = true; }),
        };

        quote! {
            #structure
            impl contract::LinearKernel<#d> for #name {
                const REQUIREMENTS: contract::Requirements = #requirements;
                const TEST_COMPONENTS: usize = #components;
                const OPERATIONS: contract::Operations = #operations;
                #motion
                type Cell<L: Lane> = [L; #cell_count];
                type Flux<L: Lane> = [L; #point_count];
                type Block<L: Lane> = [L; #components];
                #cell_function
                #[inline(always)]
                fn point<L: Lane>(&self, cell: &[L; #cell_count], geometry: &contract::PointGeometry<L, #d>, fields: &[L]) -> [L; #point_count] {
                    #point_statements
                }
                #[inline(always)]
                fn test<L: Lane>(&self, point: &[L; #point_count], basis: &contract::Basis<L, #d>, further: &contract::Further<L, #d>) -> [L; #components] {
                    #test_statements
                    [#(#test_results),*]
                }
            }
        }
    }

    /// One integral of a tangent, by its plan.
    pub fn bilinear(&mut self, name: &Ident, integral: &BilinearIntegral) -> TokenStream {
        let d = self.dimension;
        let [rows, columns] =
            [integral.test, integral.trial].map(|one| self.fields[one.field].shape.iter().product::<usize>());
        let entries = rows * columns;
        let BilinearPlan { tests, trials, sums, block } = &integral.plan;
        let nonzero: Vec<bool> = block.iter().map(|entry| !self.graph.is_zero(*entry)).collect();
        let cell_constant =
            !tests.iter().chain(trials).any(|factor| self.graph.depends(*factor, varies_over_cell));
        let roots: Vec<Scalar> = integral.plan.roots().copied().collect();
        let layout = Layout::new(self.graph, self.fields, self.dimension, &roots).on(self.points_of);
        let mut code = Code::new(self.graph, &roots);
        let mut lower =
            |list: &[Scalar]| -> Vec<Value> { list.iter().map(|scalar| code.lower(*scalar)).collect() };
        let (tests, trials, block) = (lower(tests), lower(trials), lower(block));

        let printer = Printer { code: &code, externals: self.externals };
        let (mut form, mut cell, mut point) = (Store::default(), Store::default(), Store::default());
        let test = printer.print(&tests, Level::Node, &|node| self.basis(node), &mut |value, _| {
            from_point(&mut point, value)
        });
        let trial = printer.print(&trials, Level::Node, &|node| self.basis(node), &mut |value, _| {
            from_point(&mut point, value)
        });
        let finish = {
            let mut demand = Demand { form: &mut form, cell: &mut cell };
            // Once per pair of functions.
            printer
                .print(&block, Level::Node, &|node| self.basis(node), &mut |value, _| demand.in_lanes(value))
        };
        let point_function =
            self.point_function(name, &printer, &point.values, &layout, &mut form, &mut cell);
        let cell_function = self.cell_function(&printer, &cell, &mut form);
        let structure = self.structure(name, &printer, &form, &point_function);
        let point_statements = &point_function.statements;
        let pair_operations = sums.iter().map(Vec::len).sum();
        let operations = operations([
            point_function.operations,
            test.operations,
            trial.operations,
            pair_operations,
            finish.operations,
        ]);
        let pair = sums.iter().enumerate().filter(|(_, pairs)| !pairs.is_empty()).map(|(entry, pairs)| {
            let start = quote! { accumulator[#entry] };
            let sum = pairs.iter().fold(
                start,
                |sum, (test, trial)| quote! { L::multiply_add(test[#test], trial[#trial], #sum) },
            );
            quote! { accumulator[#entry] = #sum; }
        });
        let (cell_count, point_count) = (cell.values.len(), point.values.len());
        let (test_count, trial_count, sum_count) = (tests.len(), trials.len(), sums.len());
        let (test_statements, test_results) = (test.statements, test.results);
        let (trial_statements, trial_results) = (trial.statements, trial.results);
        let (finish_statements, finish_results) = (finish.statements, finish.results);
        let symmetric = integral.symmetric;
        let requirements = &layout.requirements;
        quote! {
            #structure
            impl contract::BilinearKernel<#d> for #name {
                const REQUIREMENTS: contract::Requirements = #requirements;
                const TEST_COMPONENTS: usize = #rows;
                const TRIAL_COMPONENTS: usize = #columns;
                const SYMMETRIC: bool = #symmetric;
                const CELL_CONSTANT: bool = #cell_constant;
                const NONZERO: &'static [bool] = &[#(#nonzero),*];
                const OPERATIONS: contract::Operations = #operations;
                type Cell<L: Lane> = [L; #cell_count];
                type Point<L: Lane> = [L; #point_count];
                type Test<L: Lane> = [L; #test_count];
                type Trial<L: Lane> = [L; #trial_count];
                type Accumulator<L: Lane> = [L; #sum_count];
                type Block<L: Lane> = [L; #entries];
                #cell_function
                #[inline(always)]
                fn point<L: Lane>(&self, cell: &[L; #cell_count], geometry: &contract::PointGeometry<L, #d>, fields: &[L]) -> [L; #point_count] {
                    #point_statements
                }
                #[inline(always)]
                fn test<L: Lane>(&self, point: &[L; #point_count], basis: &contract::Basis<L, #d>, further: &contract::Further<L, #d>) -> [L; #test_count] {
                    #test_statements
                    [#(#test_results),*]
                }
                #[inline(always)]
                fn trial<L: Lane>(&self, point: &[L; #point_count], basis: &contract::Basis<L, #d>, further: &contract::Further<L, #d>) -> [L; #trial_count] {
                    #trial_statements
                    [#(#trial_results),*]
                }
                #[inline(always)]
                fn zero_factors<L: Lane>() -> ([L; #test_count], [L; #trial_count]) {
                    ([L::splat(0.0); #test_count], [L::splat(0.0); #trial_count])
                }
                #[inline(always)]
                fn zero<L: Lane>() -> [L; #sum_count] {
                    [L::splat(0.0); #sum_count]
                }
                #[inline(always)]
                fn pair<L: Lane>(accumulator: &mut [L; #sum_count], test: &[L; #test_count], trial: &[L; #trial_count]) {
                    #(#pair)*
                }
                #[inline(always)]
                fn finish<L: Lane>(&self, cell: &[L; #cell_count], accumulator: &[L; #sum_count]) -> [L; #entries] {
                    #finish_statements
                    [#(#finish_results),*]
                }
            }
        }
    }

    /// A density or derived field.
    pub fn expression(&mut self, name: &Ident, components: &[Scalar], shape: &[usize]) -> TokenStream {
        let d = self.dimension;
        let count = components.len();
        let layout = Layout::new(self.graph, self.fields, self.dimension, components).on(self.points_of);
        let mut code = Code::new(self.graph, components);
        let values: Vec<Value> = components.iter().map(|component| code.lower(*component)).collect();
        let printer = Printer { code: &code, externals: self.externals };
        let (mut form, mut cell) = (Store::default(), Store::default());
        let point_function = self.point_function(name, &printer, &values, &layout, &mut form, &mut cell);
        let statements = &point_function.statements;
        let cell_function = self.cell_function(&printer, &cell, &mut form);
        let structure = self.structure(name, &printer, &form, &point_function);
        let cell_count = cell.values.len();
        let requirements = &layout.requirements;
        quote! {
            #structure
            impl contract::ExpressionKernel<#d> for #name {
                const REQUIREMENTS: contract::Requirements = #requirements;
                const SHAPE: &'static [usize] = &[#(#shape),*];
                type Cell<L: Lane> = [L; #cell_count];
                type Value<L: Lane> = [L; #count];
                #cell_function
                #[inline(always)]
                fn evaluate<L: Lane>(&self, cell: &[L; #cell_count], geometry: &contract::PointGeometry<L, #d>, fields: &[L]) -> [L; #count] {
                    #statements
                }
            }
        }
    }

    /// The function at a point that gives these values.
    fn point_function(
        &self,
        kernel: &Ident,
        printer: &Printer,
        values: &[Value],
        layout: &Layout,
        form: &mut Store,
        cell: &mut Store,
    ) -> PointFunction {
        let mut demand = Demand { form, cell };
        let (parts, body) = printer.print_in_parts(
            values,
            Level::Point,
            &|node| self.at_point(node, layout),
            &mut |value, level| demand.text(value, level),
        );
        let (d, cell_count) = (self.dimension, demand.cell.values.len());
        let (mut functions, mut entries, mut calls) =
            (TokenStream::new(), TokenStream::new(), TokenStream::new());
        let (mut arrays, mut types) = (vec![], vec![]);
        for (number, PartBody { statements, results }) in parts.into_iter().enumerate() {
            let (name, array, count) = (format_ident!("part_{number}"), kept_name(number), results.len());
            functions.extend(quote! {
                #[inline(always)]
                fn #name<L: Lane>(
                    &self,
                    (cell, geometry, fields, #(#arrays),*): (&[L; #cell_count], &contract::PointGeometry<L, #d>, &[L], #(&#types),*),
                ) -> [L; #count] {
                    #statements
                    [#(#results),*]
                }
            });
            entries.extend(quote! {
                impl<L: Lane> contract::Parts<L, #number> for #kernel {
                    type Argument<'a> = (&'a [L; #cell_count], &'a contract::PointGeometry<L, #d>, &'a [L], #(&'a #types),*);
                    type Kept = [L; #count];
                    #[inline(always)]
                    fn part(&self, argument: Self::Argument<'_>) -> [L; #count] {
                        self.#name(argument)
                    }
                }
            });
            calls.extend(quote! {
                let #array = L::apart::<Self, #number>(self, (cell, geometry, fields, #(&#arrays),*));
            });
            arrays.push(array);
            types.push(quote! { [L; #count] });
        }
        let (last, results) = (body.statements, body.results);
        let statements = quote! {
            #calls
            #last
            [#(#results),*]
        };
        PointFunction { parts: functions, entries, statements, operations: body.operations }
    }

    fn cell_function(&self, printer: &Printer, cell: &Store, form: &mut Store) -> TokenStream {
        let count = cell.values.len();
        let mut unused = Store::default();
        let mut demand = Demand { form, cell: &mut unused };
        let terminal = |node: &Node| match node {
            Node::Geometry(Geometry::Diameter, _) => quote! { geometry.diameter },
            Node::Geometry(Geometry::CellVolume, _) => quote! { geometry.cell_volume },
            Node::Opposite(Geometry::Diameter) => quote! { geometry.opposite_diameter },
            Node::Opposite(_) => quote! { geometry.opposite_volume },
            _ => quote! { geometry.facet_area },
        };
        let body = printer
            .print(&cell.values, Level::Cell, &terminal, &mut |value, level| demand.text(value, level));
        let (statements, results) = (body.statements, body.results);
        quote! {
            #[inline(always)]
            fn cell<L: Lane>(&self, geometry: &contract::CellGeometry<L>) -> [L; #count] {
                #statements
                [#(#results),*]
            }
        }
    }

    /// The kernel's struct: what is known with the parameters.
    fn structure(
        &self,
        name: &Ident,
        printer: &Printer,
        form: &Store,
        PointFunction { parts, entries, .. }: &PointFunction,
    ) -> TokenStream {
        let count = form.values.len();
        let terminal = |node: &Node| match node {
            Node::Parameter(index) => quote! { parameters[#index] },
            _ => quote! { f64::NAN },
        };
        let body = printer.print(&form.values, Level::Form, &terminal, &mut |_, _| quote! { f64::NAN });
        let (statements, results) = (body.statements, body.results);
        let (member, value) = match printer.code.reads_tables() {
            true => {
                (quote! { tables: ::std::vec::Vec<contract::Table>, }, quote! { tables: tables.to_vec(), })
            }
            false => (quote! {}, quote! {}),
        };
        quote! {
            #[derive(Clone)]
            pub struct #name {
                form: [f64; #count],
                #member
            }
            impl #name {
                pub fn new(parameters: &[f64], tables: &[contract::Table]) -> Self {
                    type L = f64;
                    #statements
                    #name { form: [#(#results),*], #value }
                }
                #parts
            }
            #entries
        }
    }

    fn basis(&self, node: &Node) -> TokenStream {
        match node {
            Node::Basis(_, Derivative::Value) => quote! { basis.value },
            Node::Basis(_, Derivative::First(axis)) => quote! { basis.gradient[#axis] },
            Node::Basis(_, Derivative::Second(first, second)) => quote! { further.hessian[#first][#second] },
            Node::Basis(_, Derivative::MeanValue) => quote! { further.mean.value },
            Node::Basis(_, Derivative::MeanFirst(axis)) => quote! { further.mean.gradient[#axis] },
            Node::Accumulated(index) => quote! { accumulator[#index] },
            _ => quote! { f64::NAN },
        }
    }

    fn at_point(&self, node: &Node, layout: &Layout) -> TokenStream {
        match node {
            Node::Weight => quote! { geometry.weight },
            Node::Geometry(Geometry::Normal, component) => quote! { geometry.normal[#component] },
            Node::Geometry(Geometry::Position, component) => quote! { geometry.position[#component] },
            Node::Geometry(Geometry::Curvature, _) => quote! { geometry.curvature },
            Node::Geometry(Geometry::ShapeOperator, entry) => {
                let (row, column) = (entry / self.dimension, entry % self.dimension);
                quote! { geometry.opposite.shape_operator[#row][#column] }
            }
            Node::Geometry(Geometry::Gap, _) => quote! { geometry.opposite.gap },
            Node::Geometry(Geometry::Toward, component) => quote! { geometry.opposite.toward[#component] },
            Node::Geometry(Geometry::OppositePosition, component) => {
                quote! { geometry.opposite.position[#component] }
            }
            Node::Geometry(Geometry::OppositeNormal, component) => {
                quote! { geometry.opposite.normal[#component] }
            }
            Node::Field { field, side, component, derivative } => {
                let index = layout.position(*field, *side, *component, *derivative);
                quote! { fields[#index] }
            }
            _ => quote! { f64::NAN },
        }
    }
}
