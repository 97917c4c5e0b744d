//! Derivatives of integrals over a cut body by the nodal values of its level set function: the points and weights move, the fields are fixed
//! in space.

use std::ops::Range;
use std::sync::Arc;

use forms_core::contract::{Entity, FieldSlot, Role, Term};

use super::batch::Cells;
use super::binding::entities::Entities;
use super::binding::{Binding, Values};
use super::element_loops::vectors::ElementVectors;
use super::groups::cut_groups::CutTables;
use super::groups::{Group, OwnPoints, groups};
use super::kernels::VectorKernel;
use super::{Assembler, AssemblyError};
use crate::contract::{Form, Function};
use crate::cut::{Cut, CutError, CutSide, GHOST};
use crate::field::{Field, FieldView, views};
use crate::instantiate::instantiate;
use crate::space::Space;

impl<const D: usize> Assembler<D> {
    /// The derivative of R(u; p) by the values of the level set function that cuts the body: one entry per node of the function's space. u
    /// are the form's unknowns, p fields in the place of its test functions; both keep their values on the background mesh.
    ///
    /// It is the exact derivative of what is assembled, with points and weights that move, also for integrands with kinks, as long as no node
    /// changes sides. The derivative of a criterion J(u) at a solution of R(u; v) = 0 is that of J + R(u; p) with the adjoint state p of
    /// `derivative(R(u, p), u, q) + derivative(J, u, q)`. A functional ∫ f is the form ∫ f t with t = 1. The module has the option
    /// `#[forms(level_set_derivatives)]`.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([-1.0; 2], [1.0; 2], [16, 16], CellShape::Triangle, 1)?;
    /// let space = Space::scalar(&mesh, 1)?;
    /// let disc = |radius: f64| -> Result<Assembler<2>, Box<dyn std::error::Error>> {
    ///     let phi = Field::interpolate(&space, |x| x[0].hypot(x[1]) - radius)?;
    ///     Ok(Assembler::new(&mesh).cut_by(&phi)?)
    /// };
    /// let area = form!(|t: Test<Scalar>| integral(cells("all"), t), level_set_derivatives);
    /// let one = Field::interpolate(&Space::discontinuous_scalar(&mesh, 0)?, |_| 1.0)?;
    /// let slope = disc(0.71)?.derivative_by_level_set(&area, &[], &[&one])?;
    /// // φ + t has the radius 0.71 − t.
    /// let rate: f64 = slope.iter().sum();
    /// let measured = form!(|| -> Functional { integral(cells("all"), 1) });
    /// let [larger, smaller] = [disc(0.7101)?.functional(&measured)?, disc(0.7099)?.functional(&measured)?];
    /// assert!((rate + (larger - smaller) / 2e-4).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// An assembler that is on no cut body, a form whose module does not have the option, fields that do not fit, and data without a derivative in space: a
    /// function of position without a gradient, or one written in Rust; interior facets that the interface crosses, other than "ghost".
    pub fn derivative_by_level_set(
        &self,
        form: &Form<D>,
        unknowns: &[&Field<D>],
        tests: &[&Field<D>],
    ) -> Result<Vec<f64>, AssemblyError> {
        self.derivative_by_cut(form, &views(unknowns), &views(tests))
    }

    #[inline(never)]
    fn derivative_by_cut(
        &self,
        form: &Function<D>,
        unknowns: &[FieldView<D>],
        tests: &[FieldView<D>],
    ) -> Result<Vec<f64>, AssemblyError> {
        let refused =
            |source| AssemblyError::Cut { form: form.name(), place: "its derivative".to_owned(), source };
        let Some(cut) = self.cut.as_deref() else { return Err(refused(CutError::NoCut)) };
        let mut binding = self.bind(form, unknowns)?;
        let spaces: Vec<&Arc<Space<D>>> = tests.iter().map(|test| test.space).collect();
        binding.check_tests(&spaces, &self.mesh)?;
        let elements: Vec<usize> = spaces.iter().map(|space| binding.element(space)).collect();
        let degrees = binding.degrees(&spaces);
        let mut gradient = vec![0.0; cut.node_count()];
        for term in form.residual() {
            let (integral, constants) = (term.integral, term.kernel.constants());
            let region = &binding.regions[integral.region];
            if region.entity == Entity::InteriorFacets
                && region.name != GHOST
                && let Entities::InteriorFacets(facets) = binding.entities(integral.region)?
                && let Some(crossed) = facets.iter().find(|sides| cut.side_of_facet(sides[0]) == CutSide::Cut)
            {
                return Err(refused(CutError::InteriorFacet {
                    position: self.mesh.facet_centre(crossed[0]).to_vec(),
                }));
            }
            let (test, element) = (&tests[integral.test], elements[integral.test]);
            let arguments = [(Role::Test(integral.test), &**test.space)];
            let found =
                groups(&binding, integral, &self.quadrature, &degrees, constants.requirements, &arguments)?;
            for group in found {
                let side = group.side(form.name(), integral.test_side)?;
                let name = binding.name_of(Role::Test(integral.test));
                group.check_support(form.name(), name, test.space, side)?;
                // Whole cells and facets, and pairs, do not move.
                if let Some(OwnPoints::Cut(pieces)) = &group.own {
                    let moving = Moving { assembler: self, binding: &binding, term, element };
                    moving.add((&group, pieces), cut, test, &mut gradient)?;
                }
            }
        }
        Ok(gradient)
    }
}

/// One term on a group whose points move.
struct Moving<'a, const D: usize> {
    assembler: &'a Assembler<D>,
    binding: &'a Binding<'a, D>,
    term: &'a Term<VectorKernel<D>>,
    /// That of the test function.
    element: usize,
}

impl<const D: usize> Moving<'_, D> {
    fn add(
        &self,
        (group, pieces): (&Group<D>, &CutTables<D>),
        cut: &Cut<D>,
        test: &FieldView<D>,
        gradient: &mut [f64],
    ) -> Result<(), AssemblyError> {
        let Moving { assembler, binding, term, element } = *self;
        let side = &group.sides[0];
        let task = ElementVectors { binding, group, cells: Cells::Mesh(binding.mesh), side: 0, element };
        let (local, components) = (side.facet.map(|(local, _)| local), term.kernel.constants().components);
        let (length, count) = (group.points() * pieces.stride(), group.entities());
        let parts = assembler.threads.count().min(count.div_ceil(64)).max(1);
        let parts = (0..parts).map(|part| part * count / parts..(part + 1) * count / parts).collect();
        // Each cell's numbers are its own, so that threads do not show.
        let found = assembler.threads.run(parts, |entities: Range<usize>| {
            let nodes =
                side.cells[entities.clone()].iter().flat_map(|cell| test.space.nodes_at(*cell, local));
            let coefficients =
                nodes.flat_map(|node| &test.values[*node as usize * components..][..components]);
            let tests: Vec<f64> = coefficients.map(|value| term.kernel.factor() * value).collect();
            let (mut points, mut derivatives) = (Vec::new(), Vec::new());
            term.kernel.slopes_on_pieces(&task, (&tests, entities), &mut |first, slopes| {
                for (entity, slopes) in slopes.chunks_exact(length).enumerate() {
                    pieces.by_nodal_values(
                        (cut, side),
                        first + entity,
                        slopes,
                        &mut points,
                        &mut derivatives,
                    );
                }
                Ok(())
            })?;
            Ok(derivatives)
        });
        let parts: Vec<Vec<f64>> = found.into_iter().collect::<Result<_, AssemblyError>>()?;
        let nodes = side.cells.iter().flat_map(|cell| cut.level_nodes(*cell));
        for (node, number) in nodes.zip(parts.iter().flatten()) {
            if !number.is_finite() {
                return Err(self.no_gradient(group));
            }
            gradient[*node as usize] += number;
        }
        Ok(())
    }

    #[cold]
    fn no_gradient(&self, group: &Group<D>) -> AssemblyError {
        let Moving { binding, term, .. } = *self;
        let without = |slot: &&FieldSlot| matches!(binding.values[slot.field], Values::Function { .. });
        let slots = term.kernel.constants().requirements.fields;
        let field =
            slots.iter().find(without).map_or("an external function", |slot| binding.fields[slot.field].name);
        let source = CutError::NoGradient { field };
        AssemblyError::Cut { form: binding.name, place: group.place.clone(), source }
    }
}

instantiate!(cut_derivative: Assembler::<D>::derivative_by_cut);
