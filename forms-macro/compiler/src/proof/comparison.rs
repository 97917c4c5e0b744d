//! Compares emitted kernels with the reference evaluator at random data, and what the compiler claims of
//! an integral (symmetric, linear, constant) with the numbers.

mod claims;

use super::assembly::{Points, bilinear, expression, linear};
use super::data::{Random, combination, points};
use super::emitted::{Function, Integral, read};
use super::source::Source;
use crate::check::{CheckedFunction, Content};
use crate::reference::{Budget, Condition, Evaluator};
use crate::tensor::{FieldRole, Side};

/// Arguments nearer to a kink or a singularity than this are not compared.
const DISTANCE: f64 = 1e-3;
/// Larger numbers are not compared.
const MAGNITUDE: f64 = 1e6;
/// Tolerance relative to the largest intermediate number: 4e6 units in the last place, because terms may cancel twice.
const TOLERANCE: f64 = 1e-9;

/// The budget of the reference for all numbers of a module, in products: two to five seconds.
const BUDGET: u64 = 2_000_000_000;

/// Numbers that were compared, and those that were left out as badly conditioned or for lack of budget.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    pub compared: usize,
    pub skipped: usize,
}

/// The first difference, in words.
pub type Difference = String;

/// Compares all functions of a module.
pub fn compare(source: &Source, seed: u64) -> Result<Tally, Difference> {
    let checked = source.checked()?;
    let module = source.module();
    let emitted = read(source.emitted());
    let mut tally = Tally::default();
    let budget = &Budget::new(BUDGET);
    for checked in &checked {
        let name = module.functions[checked.function].name.to_string();
        let emitted = emitted.get(&name).ok_or_else(|| format!("`{name}` was not emitted"))?;
        let regions: Vec<usize> = emitted
            .argument_types
            .iter()
            .filter_map(|ty| module.regions.iter().position(|region| region.name == ty))
            .collect();
        let count_of_regions = module.regions.len();
        let mut random = Random(seed);
        let here = points(&module, checked, 2, &mut random);
        let mut elsewhere = here.clone();
        for (_, point) in &mut elsewhere {
            for fields in &mut point.fields {
                for (jet, field) in fields.iter_mut().zip(&checked.fields) {
                    if matches!(field.role, FieldRole::Unknown(_)) {
                        *jet = random.jet(field.shape.iter().product(), checked.dimension);
                    }
                }
            }
        }
        let nodes =
            [0, 1].map(|_| -> Vec<_> { here.iter().map(|_| random.jet(1, checked.dimension)).collect() });
        let comparison = Comparison {
            checked,
            emitted,
            budget,
            regions,
            count_of_regions,
            seed,
            name,
            here,
            elsewhere,
            nodes,
        };
        comparison.run(&mut tally)?;
    }
    Ok(tally)
}

struct Comparison<'a> {
    checked: &'a CheckedFunction,
    emitted: &'a Function,
    budget: &'a Budget,
    /// The module's region of each region of the emitted form.
    regions: Vec<usize>,
    count_of_regions: usize,
    seed: u64,
    name: String,
    here: Vec<(f64, crate::reference::Point)>,
    /// The same with other values of the unknowns.
    elsewhere: Vec<(f64, crate::reference::Point)>,
    /// Two basis functions.
    nodes: [Vec<crate::reference::Jet>; 2],
}

/// A test or trial function on one side.
struct Argument {
    number: usize,
    side: Side,
    field: usize,
    components: usize,
    /// A random vector: what is compared is the block times it, all entries at once.
    coefficients: Vec<f64>,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Comparison<'_> {
    fn run(&self, tally: &mut Tally) -> Result<(), Difference> {
        match self.checked.content {
            Content::Value(_) => self.value(tally)?,
            Content::Functional(_) => self.densities(tally)?,
            Content::Energy(_) => {
                self.densities(tally)?;
                self.form(tally)?;
            }
            Content::Form(_) => self.form(tally)?,
        }
        self.claims(tally)
    }

    /// The indices of the fields that play a role, in its order, with their components.
    fn of_role(&self, is: impl Fn(FieldRole) -> bool) -> Vec<(usize, usize)> {
        let fields = self.checked.fields.iter().enumerate().filter(|(_, field)| is(field.role));
        fields.map(|(index, field)| (index, field.shape.iter().product())).collect()
    }

    fn unknowns(&self) -> Vec<(usize, usize)> {
        self.of_role(|role| matches!(role, FieldRole::Unknown(_)))
    }

    /// An energy is tested with variations of its unknowns.
    fn tests(&self) -> Vec<(usize, usize)> {
        match self.checked.content {
            Content::Energy(_) => self.unknowns(),
            _ => self.of_role(|role| matches!(role, FieldRole::Test(_))),
        }
    }

    /// Compares a number with the weighted sum of the reference over the points.
    fn near(
        &self,
        what: &str,
        found: f64,
        points: &Points,
        reference: impl Fn(&Evaluator, usize) -> f64,
        tally: &mut Tally,
    ) -> Result<(), Difference> {
        let mut expected = 0.0;
        let mut condition = Condition { distance: f64::INFINITY, magnitude: 1.0 };
        for (index, (weight, point)) in points.iter().enumerate() {
            let evaluator = Evaluator::new(self.checked, point, self.budget);
            expected += weight * reference(&evaluator, index);
            let own = evaluator.condition();
            condition.distance = condition.distance.min(own.distance);
            condition.magnitude = condition.magnitude.max(own.magnitude);
        }
        if condition.distance < DISTANCE || condition.magnitude > MAGNITUDE {
            tally.skipped += 1;
            return Ok(());
        }
        tally.compared += 1;
        // Written so that a NaN is a difference.
        if (found - expected).abs() <= TOLERANCE * condition.magnitude {
            return Ok(());
        }
        Err(format!(
            "{what} of `{}` in {}D: the kernel gives {found}, the reference {expected} ({condition:?})",
            self.name, self.checked.dimension
        ))
    }

    fn value(&self, tally: &mut Tally) -> Result<(), Difference> {
        let [integral] = &self.emitted.density[..] else { return Err("a value has one kernel".into()) };
        for (point, values) in self.here.iter().zip(expression(&integral.kernel, &self.here)) {
            let alone = std::slice::from_ref(point);
            for (entry, value) in values.iter().enumerate() {
                let found = point.0 * value;
                self.near(
                    &format!("component {entry}"),
                    found,
                    alone,
                    |at, _| at.components()[entry],
                    tally,
                )?;
            }
        }
        Ok(())
    }

    fn on<'i>(&self, list: &'i [Integral], region: usize) -> Vec<&'i Integral> {
        list.iter().filter(|integral| self.regions[integral.region] == region).collect()
    }

    fn densities(&self, tally: &mut Tally) -> Result<(), Difference> {
        for region in 0..self.count_of_regions {
            let mut found = 0.0;
            for integral in self.on(&self.emitted.density, region) {
                let values = expression(&integral.kernel, &self.here);
                found +=
                    self.here.iter().zip(values).map(|((weight, _), value)| weight * value[0]).sum::<f64>();
            }
            self.near("the density", found, &self.here, |at, _| at.density(region), tally)?;
        }
        Ok(())
    }

    fn sides(&self) -> &'static [Side] {
        match Evaluator::reads_other_side(self.checked) {
            true => &[Side::This, Side::Other],
            false => &[Side::This],
        }
    }

    /// All test functions (or trial functions), on each side if there are two.
    fn arguments(&self, fields: &[(usize, usize)]) -> Vec<Argument> {
        let sides = self.sides();
        let mut random = Random(self.seed);
        let mut arguments = Vec::new();
        for (number, (field, components)) in fields.iter().enumerate() {
            for side in sides {
                let coefficients = random.numbers(*components);
                let (field, components) = (*field, *components);
                arguments.push(Argument { number, side: *side, field, components, coefficients });
            }
        }
        arguments
    }

    /// Residual and tangent, for all regions, test functions and unknowns, at both states.
    fn form(&self, tally: &mut Tally) -> Result<(), Difference> {
        let (tests, trials) = (self.arguments(&self.tests()), self.arguments(&self.unknowns()));
        for points in [&self.here, &self.elsewhere] {
            for region in 0..self.count_of_regions {
                for test in &tests {
                    self.residual(points, region, test, tally)?;
                    for trial in &trials {
                        self.tangent(points, region, [test, trial], tally)?;
                    }
                    self.action(points, region, test, tally)?;
                }
            }
        }
        Ok(())
    }

    fn residual(
        &self,
        points: &Points,
        region: usize,
        test: &Argument,
        tally: &mut Tally,
    ) -> Result<(), Difference> {
        let node = &self.nodes[0];
        let reference = |at: &Evaluator, point: usize| {
            at.residual(region, (test.field, test.side, &combination(&node[point], &test.coefficients)))
        };
        for (name, integrals) in
            [("residual", &self.emitted.residual), ("whole residual", &self.emitted.whole_residual)]
        {
            if integrals.is_empty() && name == "whole residual" {
                continue;
            }
            let mut found = vec![0.0; test.components];
            for integral in self.on(integrals, region) {
                if integral.test == (test.number, test.side) {
                    let block = linear(&integral.kernel, points, node);
                    found.iter_mut().zip(block).for_each(|(sum, share)| *sum += share);
                }
            }
            let what = format!("{name} {}, {:?}", test.number, test.side);
            self.near(&what, dot(&found, &test.coefficients), points, reference, tally)?;
        }
        Ok(())
    }

    fn tangent(
        &self,
        points: &Points,
        region: usize,
        [test, trial]: [&Argument; 2],
        tally: &mut Tally,
    ) -> Result<(), Difference> {
        let [first, second] = &self.nodes;
        let reference = |at: &Evaluator, point: usize| {
            let row = combination(&first[point], &test.coefficients);
            let column = combination(&second[point], &trial.coefficients);
            at.tangent(region, (test.field, test.side, &row), (trial.field, trial.side, &column))
        };
        let functions = ((test.number, test.side), (trial.number, trial.side));
        for (name, integrals) in
            [("tangent", &self.emitted.tangent), ("whole tangent", &self.emitted.whole_tangent)]
        {
            if integrals.is_empty() && name == "whole tangent" {
                continue;
            }
            let mut found = vec![0.0; test.components * trial.components];
            for integral in self.on(integrals, region) {
                if (integral.test, integral.trial) == functions {
                    let block = bilinear(&integral.kernel, points, first, second);
                    found.iter_mut().zip(block).for_each(|(sum, share)| *sum += share);
                }
            }
            let rows: Vec<f64> =
                found.chunks(trial.components).map(|row| dot(row, &trial.coefficients)).collect();
            let what = format!("{name} {} {:?}, {} {:?}", test.number, test.side, trial.number, trial.side);
            self.near(&what, dot(&rows, &test.coefficients), points, reference, tally)?;
        }
        Ok(())
    }

    /// The action is the tangent with the directions for trial functions, on both sides at once.
    fn action(
        &self,
        points: &Points,
        region: usize,
        test: &Argument,
        tally: &mut Tally,
    ) -> Result<(), Difference> {
        let unknowns = self.unknowns();
        let directions = &self.emitted.directions;
        if directions.len() != unknowns.len() {
            return Err(format!("`{}` has {} directions", self.name, directions.len()));
        }
        let mut random = Random(self.seed.wrapping_add(1));
        let mut extended = points.to_vec();
        for (_, point) in &mut extended {
            for fields in &mut point.fields {
                fields.resize(directions.last().map_or(0, |last| last + 1).max(fields.len()), vec![]);
                for (direction, (_, components)) in directions.iter().zip(&unknowns) {
                    fields[*direction] = random.jet(*components, self.checked.dimension);
                }
            }
        }
        let node = &self.nodes[0];
        let mut found = vec![0.0; test.components];
        for integral in self.on(&self.emitted.action, region) {
            if integral.test == (test.number, test.side) {
                let block = linear(&integral.kernel, &extended, node);
                found.iter_mut().zip(block).for_each(|(sum, share)| *sum += share);
            }
        }
        let sides = self.sides();
        let reference = |at: &Evaluator, point: usize| {
            let row = combination(&node[point], &test.coefficients);
            let mut sum = 0.0;
            for (number, (unknown, _)) in unknowns.iter().enumerate() {
                for side in sides {
                    let jets = &extended[point].1.fields[*side as usize];
                    let trial = (*unknown, *side, &jets[directions[number]]);
                    sum += at.tangent(region, (test.field, test.side, &row), trial);
                }
            }
            sum
        };
        let what = format!("action {}, {:?}", test.number, test.side);
        self.near(&what, dot(&found, &test.coefficients), points, reference, tally)
    }
}
