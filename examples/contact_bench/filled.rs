//! Bodies whose gap has a mesh of its own, pressed at one node: what a formulation gets there.

use forms_fem::prelude::*;

use crate::outcome::Refusal;

/// Bodies and their gap on one mesh, whose cells have the names "body" and "medium".
#[derive(Clone, Debug)]
pub struct Filled {
    /// Displacements.
    pub space: Arc<Space<2>>,
    /// The name of the facets that are held.
    pub held: &'static str,
    /// The node that is moved.
    pub pressed: usize,
    /// The component that is moved.
    pub component: usize,
    /// Its displacements, one step after the other \[length\].
    pub ways: Vec<f64>,
    /// λ of the bodies \[stress\].
    pub lambda: f64,
    /// μ of the bodies \[stress\].
    pub mu: f64,
    /// λ and μ from which those of a medium are taken \[stress\]: derivatives are by the bodies' μ only.
    pub reference: [f64; 2],
    /// The size of the whole \[length\].
    pub size: f64,
    /// The options of Newton's method.
    pub options: NewtonOptions,
}

impl Filled {
    /// The rule of all integrals: 3 by 3 points on quadrilaterals.
    pub fn assembler(&self) -> Assembler<2> {
        Assembler::new(self.space.mesh()).with_quadrature(Quadrature::Degree(5))
    }

    /// The conditions with the node moved by this.
    ///
    /// # Errors
    /// A mesh without the facets.
    pub fn constraints(&self, way: f64) -> Result<Constraints<2>, Refusal> {
        let mut constraints = Constraints::new(&self.space);
        constraints.fix(self.held, |_| [0.0; 2])?;
        constraints.fix_node(self.pressed, self.component, way)?;
        Ok(constraints)
    }

    /// The displacement 1 of the node.
    ///
    /// # Errors
    /// None in practice.
    pub fn lift(&self) -> Result<Field<2>, Refusal> {
        let mut values = vec![0.0; self.space.unknowns()];
        values[2 * self.pressed + self.component] = 1.0;
        Ok(Field::from_values(&self.space, values)?)
    }
}

/// One step of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Newton steps.
    pub newton: usize,
    /// The force on the node, along its way's axis.
    pub force: f64,
    /// Its derivative by the bodies' μ.
    pub by_mu: f64,
    /// Its second derivative by the bodies' μ.
    pub by_mu_twice: f64,
    /// The least J at the points of the rule.
    pub least_volume: f64,
}
