//! A form bound to a mesh: every field checked and resolved, every parameter finite.

pub(super) mod entities;
mod functions_on_pairs;
pub(super) mod means;
pub(super) mod notices;
pub(super) mod outline;
pub(super) mod owned_cells;
pub(super) mod pair_histories;

use std::ops::Deref;
use std::sync::{Arc, Mutex, PoisonError};

use forms_core::contract::{FieldDescription, Region, Requirements, Role, Source, Term};
use forms_core::source::PositionFunction;

use self::entities::Entities;
use self::means::FoundMeans;
use self::owned_cells::OwnedCells;
use super::kernels::VectorKernel;
use super::{Assembler, AssemblyError};
use crate::contract::Function;
use crate::cut::Cut;
use crate::element::{Element, Elements, Lagrange, PerShape};
use crate::field::{Field, FieldView};
use crate::history::{PointStorage, Snapshot, degree_of};
use crate::instantiate::instantiate;
use crate::lanes::InstructionSet;
use crate::linear_algebra::vector::is_finite;
use crate::mesh::Mesh;
use crate::pairs::{Displacement, DisplacementField, KnownPairs, PairError, Pairs};
use crate::quadrature::Quadrature;
use crate::space::Space;
use crate::threads::Threads;

/// The source of a field's values, resolved.
pub(super) enum Values<'a, const D: usize> {
    /// A test function: it has no values.
    Absent,
    /// Means over own facets, which a group has.
    Means,
    Constant(&'a [f64]),
    Function {
        function: &'a PositionFunction<D>,
        gradient: Option<&'a PositionFunction<D>>,
    },
    Discrete {
        element: usize,
        space: &'a Space<D>,
        values: &'a [f64],
    },
    History(Snapshot<'a, D>),
    /// Coefficients on cells that the caller lists: those of node n start at `offsets[n]` in the list of its
    /// cell, one component after the other.
    Given {
        element: usize,
        offsets: Arc<[usize]>,
    },
}

/// A list of one's own, or another's.
pub(super) enum List<'a, T> {
    Own(Vec<T>),
    Other(&'a [T]),
}

impl<T> Deref for List<'_, T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        match self {
            List::Own(list) => list,
            List::Other(list) => list,
        }
    }
}

/// A form's name, fields and data, checked against a mesh.
pub(super) struct Binding<'a, const D: usize> {
    pub name: &'static str,
    pub mesh: &'a Mesh<D>,
    pub fields: &'a [FieldDescription],
    pub values: List<'a, Values<'a, D>>,
    /// The distinct elements of all discrete fields and test spaces.
    pub elements: List<'a, Tabulated>,
    pub regions: &'a [Region],
    /// The cells whose integrals are wanted, where they are not all.
    pub owned: Option<&'a OwnedCells>,
    /// The body that is cut from the mesh.
    pub cut: Option<&'a Cut<D>>,
    /// The search for contact pairs, and its threads; none where cells are listed.
    pub searches: Option<(&'a KnownPairs<D>, Threads)>,
    /// Pairs that one of the form's integrals asked for: others have the same.
    found: Mutex<Vec<Found<D>>>,
    /// The integrals that make means over own facets, the element with which they are integrated, and those that were made.
    means: &'a [Term<VectorKernel<D>>],
    constant: Option<usize>,
    found_means: Mutex<Vec<FoundMeans>>,
    /// Instructions with which means are made.
    pub instructions: InstructionSet,
}

/// The pairs of a region, displaced by some fields, with a rule of some degree.
struct Found<const D: usize> {
    region: usize,
    displacement: Option<Vec<usize>>,
    degree: usize,
    pairs: Arc<Pairs<D>>,
}

/// An element that is tabulated, on cells of any shape or as its trace on facets.
#[derive(Clone, PartialEq)]
pub(super) struct Tabulated {
    /// The elements on the mesh's shapes.
    pub elements: Arc<PerShape<Element>>,
    pub degree: usize,
    pub on_facets: bool,
}

impl Tabulated {
    /// A Lagrange element on cells.
    pub fn lagrange(element: Lagrange) -> Self {
        let elements = Arc::new([(element.shape, Element::Lagrange(element))].into_iter().collect());
        Tabulated { elements, degree: element.degree, on_facets: false }
    }
}

impl<'a, const D: usize> Binding<'a, D> {
    #[inline(never)]
    pub fn new(
        form: &'a Function<D>,
        mesh: &'a Mesh<D>,
        unknowns: &[FieldView<'a, D>],
    ) -> Result<Self, AssemblyError> {
        let (name, fields, inputs) = (form.name(), form.fields(), form.inputs());
        form.check().map_err(|source| AssemblyError::Combination { source })?;
        for (value, parameter) in inputs.parameters.iter().zip(&inputs.parameter_names) {
            if !value.is_finite() {
                let (parameter, value) = (parameter.clone(), *value);
                return Err(AssemblyError::Parameter { form: name, parameter, value });
            }
        }
        let expected = fields.iter().filter(|field| matches!(field.role, Role::Unknown(_))).count();
        if unknowns.len() != expected {
            let found = unknowns.len();
            return Err(AssemblyError::Count { form: name, what: "unknowns", expected, found });
        }
        notices::check_instructions(name, InstructionSet::best())?;
        Threads::from_environment().map_err(|what| AssemblyError::Environment { form: name, what })?;
        notices::tell(name, inputs);
        let mut binding = Binding::empty(name, fields, &inputs.regions, mesh);
        let mut values = Vec::with_capacity(fields.len());
        for (index, field) in fields.iter().enumerate() {
            let value = match (field.role, &inputs.sources[index]) {
                (Role::Unknown(number), _) => binding.discrete(field, unknowns[number], mesh)?,
                (Role::Mean(_), _) => Values::Means,
                (Role::Test(_), _) | (_, None) => Values::Absent,
                (_, Some(source)) => binding.resolve(field, source, mesh)?,
            };
            values.push(value);
        }
        binding.values = List::Own(values);
        binding.bind_means(form);
        Ok(binding)
    }

    /// This binding for integrals over the cells that an assembler owns, with its contact pairs.
    #[inline(never)]
    pub fn assembled_by(mut self, assembler: &'a Assembler<D>) -> Self {
        self.owned = assembler.owned.as_deref();
        self.cut = assembler.cut.as_deref();
        self.searches = Some((&assembler.known_pairs, assembler.threads));
        self.instructions = assembler.instructions;
        self
    }

    /// The threads of the assembler.
    pub fn threads(&self) -> Threads {
        self.searches.map_or(Threads::ONE, |(_, threads)| threads)
    }

    /// The directions of an action, bound: one per unknown and on its space.
    ///
    /// # Errors
    /// [`AssemblyError`]: another number of directions, or one that does not fit its unknown.
    #[inline(never)]
    pub fn bind_directions(
        &mut self,
        directions: &[FieldView<'a, D>],
        mesh: &Mesh<D>,
    ) -> Result<(), AssemblyError> {
        let fields = self.fields;
        let expected = fields.iter().filter(|field| matches!(field.role, Role::Direction(_))).count();
        if directions.len() != expected {
            let found = directions.len();
            return Err(AssemblyError::Count { form: self.name, what: "directions", expected, found });
        }
        for (index, field) in fields.iter().enumerate() {
            if let Role::Direction(number) = field.role {
                let value = self.discrete(field, directions[number], mesh)?;
                if let List::Own(values) = &mut self.values {
                    values[index] = value;
                }
            }
        }
        Ok(())
    }

    /// Whether its cells are those that a caller lists; only their shape is known.
    pub fn lists_cells(&self) -> bool {
        self.searches.is_none()
    }

    /// A binding that holds no values yet, and no element.
    #[inline(never)]
    pub fn empty(
        name: &'static str,
        fields: &'a [FieldDescription],
        regions: &'a [Region],
        mesh: &'a Mesh<D>,
    ) -> Self {
        Binding {
            name,
            mesh,
            fields,
            values: List::Own(vec![]),
            elements: List::Own(vec![]),
            regions,
            owned: None,
            cut: None,
            searches: None,
            found: Mutex::default(),
            means: &[],
            constant: None,
            found_means: Mutex::default(),
            instructions: InstructionSet::best(),
        }
    }

    /// The source of the values of a field that is no unknown and no test function.
    ///
    /// # Errors
    /// [`AssemblyError`]: a source that does not fit its field, or values that are not finite.
    #[inline(never)]
    pub fn resolve(
        &mut self,
        field: &FieldDescription,
        source: &'a Source<D>,
        mesh: &Mesh<D>,
    ) -> Result<Values<'a, D>, AssemblyError> {
        let (expected, found) = (field.components(), source.components());
        if expected != found {
            return Err(AssemblyError::Components { form: self.name, field: field.name, expected, found });
        }
        match source {
            Source::Constant(values) => {
                self.check_finite(field, values)?;
                Ok(Values::Constant(values))
            }
            Source::Function { function, gradient, .. } => {
                Ok(Values::Function { function, gradient: gradient.as_ref() })
            }
            Source::History(handle) => {
                let found = PointStorage::of(&**handle).and_then(|storage| storage.snapshot(mesh));
                let mismatch = |source| AssemblyError::History { form: self.name, field: field.name, source };
                found.map(Values::History).map_err(mismatch)
            }
            Source::Discrete(handle) => match handle.as_any().downcast_ref::<Field<D>>() {
                Some(known) => self.discrete(field, known.view(), mesh),
                None => Err(AssemblyError::ForeignField { form: self.name, field: field.name, dimension: D }),
            },
        }
    }

    fn discrete(
        &mut self,
        field: &FieldDescription,
        known: FieldView<'a, D>,
        mesh: &Mesh<D>,
    ) -> Result<Values<'a, D>, AssemblyError> {
        let FieldView { space, values, finite } = known;
        let (expected, found) = (field.components(), space.components());
        if expected != found {
            return Err(AssemblyError::Components { form: self.name, field: field.name, expected, found });
        }
        if !space.mesh.is_same(mesh) {
            return Err(AssemblyError::OtherMesh { form: self.name, field: field.name });
        }
        if !finite {
            self.check_finite(field, values)?;
        }
        let element = self.element(space);
        Ok(Values::Discrete { element, space, values })
    }

    fn check_finite(&self, field: &FieldDescription, values: &[f64]) -> Result<(), AssemblyError> {
        if is_finite(values) {
            return Ok(());
        }
        Err(AssemblyError::NotFinite { form: self.name, field: field.name, position: None })
    }

    /// The index of a space's element among those that are tabulated.
    #[inline(never)]
    pub fn element(&mut self, space: &Space<D>) -> usize {
        let elements = Arc::clone(&space.on_shapes);
        self.tabulated(Tabulated {
            elements,
            degree: space.degree,
            on_facets: space.facet_region().is_some(),
        })
    }

    /// The index of an element among those that are tabulated.
    #[inline(never)]
    pub fn tabulated(&mut self, element: Tabulated) -> usize {
        if let Some(known) = self.elements.iter().position(|known| *known == element) {
            return known;
        }
        let mut elements = self.elements.to_vec();
        elements.push(element);
        self.elements = List::Own(elements);
        self.elements.len() - 1
    }

    /// Check of the test functions' spaces against the form.
    ///
    /// # Errors
    /// [`AssemblyError`]: a space that does not fit its test function.
    #[inline(never)]
    pub fn check_tests(&self, tests: &[&Arc<Space<D>>], mesh: &Mesh<D>) -> Result<(), AssemblyError> {
        let declared: Vec<&FieldDescription> =
            self.fields.iter().filter(|field| matches!(field.role, Role::Test(_))).collect();
        if declared.len() != tests.len() {
            let (expected, found) = (declared.len(), tests.len());
            return Err(AssemblyError::Count { form: self.name, what: "test functions", expected, found });
        }
        for (field, space) in declared.into_iter().zip(tests) {
            let (expected, found) = (field.components(), space.components());
            if expected != found {
                let (form, field) = (self.name, field.name);
                return Err(AssemblyError::Components { form, field, expected, found });
            }
            if !space.mesh.is_same(mesh) {
                return Err(AssemblyError::OtherMesh { form: self.name, field: field.name });
            }
        }
        Ok(())
    }

    /// Degrees of the fields, for the estimate of a quadrature degree.
    #[inline(never)]
    pub fn degrees(&self, tests: &[&Arc<Space<D>>]) -> Vec<usize> {
        let degree = |(field, values): (&FieldDescription, &Values<D>)| match (field.role, values) {
            (Role::Test(number), _) => tests.get(number).map_or(0, |space| space.degree),
            (_, Values::Discrete { element, .. }) => self.elements[*element].degree,
            // A function of position is taken for a quadratic, as an interpolant on the mesh would be.
            (_, Values::Function { .. }) => 2,
            _ => 0,
        };
        self.fields.iter().zip(self.values.iter()).map(degree).collect()
    }

    /// A history that a kernel reads and the degree of its rule, which all of them share.
    ///
    /// # Errors
    /// [`AssemblyError::History`]: histories with different rules.
    #[inline(never)]
    pub fn history_degree(
        &self,
        requirements: &Requirements,
        quadrature: &Quadrature<D>,
    ) -> Result<Option<(&'static str, usize)>, AssemblyError> {
        let read = requirements.fields.iter().filter_map(|slot| match &self.values[slot.field] {
            Values::History(history) => Some((self.fields[slot.field].name, history.storage)),
            _ => None,
        });
        degree_of(self.name, read, quadrature)
    }

    /// The cells or facets of a region of the form, those that are owned.
    ///
    /// # Errors
    /// Those of the region.
    #[inline(never)]
    pub fn entities(&self, region: usize) -> Result<Entities<'a>, AssemblyError> {
        let all = Entities::inside(self.cut, self.mesh, self.name, &self.regions[region])?;
        Ok(OwnedCells::among(self.owned, all))
    }

    /// The degree of the rule at whose points the fields, test and trial functions of an integral are known.
    ///
    /// # Errors
    /// [`AssemblyError::OffItsPoints`]: several rules, one of them that of a history.
    pub fn degree_at_points(
        &self,
        requirements: &Requirements,
        arguments: &[(Role, &Space<D>)],
        of_history: Option<usize>,
        place: &str,
    ) -> Result<Option<usize>, AssemblyError> {
        let mut degree = of_history;
        for (field, space) in self.read_by(requirements, arguments) {
            let Elements::Points(own) = space.elements() else { continue };
            if degree.is_some_and(|known| known != *own) {
                let (form, place, elements) = (self.name, place.to_owned(), space.elements().clone());
                return Err(AssemblyError::OffItsPoints { form, field, place, elements });
            }
            degree = Some(*own);
        }
        Ok(degree)
    }

    /// The names and spaces of the fields, test and trial functions of an integral.
    fn read_by<'b>(
        &'b self,
        requirements: &'b Requirements,
        arguments: &'b [(Role, &'b Space<D>)],
    ) -> impl Iterator<Item = (&'static str, &'b Space<D>)> {
        let read = requirements.fields.iter().filter_map(|slot| match &self.values[slot.field] {
            Values::Discrete { space, .. } => Some((self.fields[slot.field].name, &**space)),
            _ => None,
        });
        read.chain(arguments.iter().map(|(role, space)| (self.name_of(*role), *space)))
    }

    /// The degree of the nodes over which an integral with the rule of vertices is a sum: 2 where it has Bernstein's functions of that degree, else 1.
    ///
    /// # Errors
    /// [`AssemblyError::OtherNodes`]: functions of several kinds on facets, one of them with other nodes than vertices.
    pub fn degree_of_coefficients(
        &self,
        requirements: &Requirements,
        arguments: &[(Role, &Space<D>)],
        place: &str,
    ) -> Result<usize, AssemblyError> {
        let on_facets =
            || self.read_by(requirements, arguments).filter(|(_, space)| space.facet_region().is_some());
        let is_quadratic =
            |elements: &Elements| matches!(elements, Elements::Bernstein(2) | Elements::DualOfBernstein);
        let Some((field, _)) = on_facets().find(|(_, space)| is_quadratic(space.elements())) else {
            return Ok(1);
        };
        match on_facets().find(|(_, space)| !is_quadratic(space.elements())) {
            None => Ok(2),
            Some((other, space)) => {
                let (form, place, elements) = (self.name, place.to_owned(), space.elements().clone());
                Err(AssemblyError::OtherNodes { form, field, place, other, elements })
            }
        }
    }

    /// The contact pairs of a region of the form; `displacement` are the fields whose sum displaces their surfaces.
    ///
    /// # Errors
    /// [`AssemblyError`] with a [`PairError`] of the search.
    #[inline(never)]
    pub fn pairs(
        &self,
        region: usize,
        displacement: Option<&[usize]>,
        quadrature: &Quadrature<D>,
        degree: usize,
    ) -> Result<Arc<Pairs<D>>, AssemblyError> {
        let lock = || self.found.lock().unwrap_or_else(PoisonError::into_inner);
        let is_wanted = |found: &&Found<D>| {
            (found.region, found.degree) == (region, degree) && found.displacement.as_deref() == displacement
        };
        if let Some(found) = lock().iter().find(is_wanted) {
            return Ok(Arc::clone(&found.pairs));
        }
        let (number, fields) = (region, displacement.map(<[usize]>::to_vec));
        let region = &self.regions[region];
        let refused = |source| pair_error(self.name, region, source);
        let (known, threads) =
            self.searches.ok_or_else(|| refused(PairError::Refused { place: "an element kernel" }))?;
        let pairing = region.pairing.as_ref().ok_or_else(|| refused(PairError::NoPairing))?;
        let displacement =
            displacement.map(|fields| self.displacement(fields)).transpose().map_err(refused)?;
        let pairs = known.find(self.mesh, pairing, quadrature, degree, displacement.as_ref(), threads);
        let pairs = pairs.map_err(refused)?;
        if let Some(cut) = self.cut {
            cut.check_pairs(&pairs).map_err(|source| {
                let place = format!("the pairs `{}` ({})", region.symbol, region.name);
                AssemblyError::Cut { form: self.name, place, source }
            })?;
        }
        lock().push(Found { region: number, displacement: fields, degree, pairs: Arc::clone(&pairs) });
        Ok(pairs)
    }

    fn displacement(&self, fields: &[usize]) -> Result<Displacement<'_, D>, PairError> {
        let view = |field: &usize| match self.values[*field] {
            Values::Discrete { space, values, .. } if space.displaces() => {
                Ok(DisplacementField { space, values })
            }
            _ => Err(PairError::NoDisplacement { field: self.fields[*field].name }),
        };
        Ok(Displacement { fields: fields.iter().map(view).collect::<Result<_, _>>()? })
    }

    /// The name of the field with a role, for messages.
    pub fn name_of(&self, role: Role) -> &'static str {
        self.fields.iter().find(|field| field.role == role).map_or("", |field| field.name)
    }
}

/// An error of a form's contact pairs.
pub(crate) fn pair_error(form: &'static str, region: &Region, source: PairError) -> AssemblyError {
    AssemblyError::Pairs { form, symbol: region.symbol, pairing: region.name.clone(), source }
}

instantiate!(
    binding:
    Binding::<D>::new,
    Binding::<D>::assembled_by,
    Binding::<D>::bind_directions,
    Binding::<D>::empty,
    Binding::<D>::resolve,
    Binding::<D>::element,
    Binding::<D>::tabulated,
    Binding::<D>::check_tests,
    Binding::<D>::degrees,
    Binding::<D>::history_degree,
    Binding::<D>::entities,
    Binding::<D>::pairs
);
