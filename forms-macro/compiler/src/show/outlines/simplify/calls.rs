//! Calls of the module's functions and their derivatives: what vanishes, what is linear, what is shorter than its name.

use super::Simplifier;
use crate::show::read::varied;
use crate::tensor::{Named, Operator, Tensor, Variable};

impl Simplifier<'_, '_> {
    /// (∂g/∂w):e, with g itself a derivative, is one more direction of it.
    pub(super) fn derivative_of_partial(&mut self, operator: &Operator, origin: Tensor) -> Option<Tensor> {
        let Operator::Inner(a, b) = *operator else { return None };
        for (partial, direction) in [(a, b), (b, a)] {
            let Operator::Partial(expression, Variable::Node(variable)) = self.arena.node(partial).operator
            else {
                continue;
            };
            let Operator::Named(Named::Call { function, arguments, directions }) =
                self.arena.node(expression).operator.clone()
            else {
                continue;
            };
            let held = self.arena.reachable(&directions.concat()).contains(&variable);
            let stands: Vec<bool> =
                arguments.iter().map(|one| self.arena.reachable(&[*one]).contains(&variable)).collect();
            let once = arguments.iter().zip(&stands).all(|(one, stands)| !stands || *one == variable);
            if directions.is_empty() || held || !once {
                continue;
            }
            let row = arguments.iter().zip(&stands).map(|(one, stands)| match stands {
                true => direction,
                false => {
                    let shape = self.arena.shape(*one).to_vec();
                    self.arena.push(Operator::Zero, shape, self.arena.span(origin))
                }
            });
            let row = row.collect();
            // The test function's direction comes first.
            let directions = [vec![row], directions].concat();
            return Some(self.simpler(
                Operator::Named(Named::Call { function, arguments, directions }),
                &[],
                origin,
            ));
        }
        None
    }

    pub(super) fn call(
        &mut self,
        function: usize,
        arguments: &[Tensor],
        directions: &[Vec<Tensor>],
        shape: &[usize],
        origin: Tensor,
    ) -> Option<Tensor> {
        let Some(row) = directions.first() else {
            let zero: Vec<bool> = arguments.iter().map(|argument| self.arena.is_zero(*argument)).collect();
            let vanishes = zero.contains(&true) && self.outlines.vanishes(function, &zero);
            return vanishes.then(|| self.zero(shape, origin));
        };
        let varied = varied(self.arena, directions);
        let definition = self.outlines.definition(function, &varied)?;
        if definition.value.is_none() {
            return Some(self.zero(shape, origin));
        }
        // What is shorter than its name.
        let short = definition.value.is_some_and(|value| definition.arena.reachable(&[value]).len() <= 4);
        if directions.len() > 1 && !short {
            return None;
        }
        let call = |this: &mut Self, replaced: &[bool]| {
            let arguments = arguments.iter().zip(row).zip(replaced);
            let arguments =
                arguments.map(|((argument, direction), on)| if *on { *direction } else { *argument });
            let named = Named::Call { function, arguments: arguments.collect(), directions: vec![] };
            this.push(Operator::Named(named), shape.to_vec(), origin)
        };
        // Linear in all that varies together, or in each by itself.
        if directions.len() == 1 && self.outlines.is_linear(function, &varied[0]) {
            return Some(call(self, &varied[0]));
        }
        if short {
            return self.outlines.body(self.arena, function, arguments, directions, self.fields)?;
        }
        let singles: Vec<Vec<bool>> = (0..row.len())
            .filter(|index| varied[0][*index])
            .map(|index| (0..row.len()).map(|other| other == index).collect())
            .collect();
        if !singles.iter().all(|single| self.outlines.is_linear(function, single)) {
            return None;
        }
        let calls: Vec<Tensor> = singles.iter().map(|single| call(self, single)).collect();
        let mut sum: Option<Tensor> = None;
        for one in calls {
            sum = Some(match sum {
                Some(sum) => self.push(Operator::Add(sum, one), shape.to_vec(), origin),
                None => one,
            });
        }
        sum
    }
}
