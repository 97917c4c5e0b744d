//! A block of rubber that is pressed on a slab and drawn along it, over several of its cells, with Coulomb's friction at large sliding: load
//! steps, each with the slip since the last one.

use std::error::Error;

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies;
use forms_contact::laws::two_bodies;
use forms_fem::mesh::OctreeMesh;
use forms_fem::prelude::*;
use forms_fem::solve::LoadPath;

/// Friction between both bodies.
const FRICTION: f64 = 0.3;
/// The way of the block's top: down in the first half of the steps, along in the second.
const WAY: [f64; 2] = [0.9, -0.06];
/// The surfaces that touch.
pub const SURFACES: [&str; 2] = ["slab top", "block bottom"];
/// Load steps.
const STEPS: usize = 6;

/// The law between both bodies.
pub type Law = sliding_bodies::Model<2>;

/// Both bodies on one space.
pub struct DrawnBlock {
    space: Arc<Space<2>>,
    assembler: Assembler<2>,
    touch: Pairing,
}

impl DrawnBlock {
    /// With the given number of cells along the block's side, of degree 2.
    ///
    /// # Errors
    /// Too many cells, or none.
    pub fn new(cells: usize) -> Result<Self, Box<dyn Error>> {
        Self::on(&Self::mesh(cells)?, Pairing::between(SURFACES[0], SURFACES[1]))
    }

    /// The mesh of both bodies.
    ///
    /// # Errors
    /// Too many cells, or none.
    pub fn mesh(cells: usize) -> Result<Mesh<2>, Box<dyn Error>> {
        Self::with_slab(&Self::slab(cells)?, cells)
    }

    /// The mesh with cells of the slab that are divided where the block slides, some of them twice: nodes hang below its top.
    ///
    /// # Errors
    /// Too many cells, or none.
    pub fn trees(cells: usize) -> Result<Mesh<2>, Box<dyn Error>> {
        let mut slab = OctreeMesh::new(Self::slab(cells)?)?;
        for [left, right, lower] in [[0.6, 2.1, 0.3], [1.0, 1.7, 0.45]] {
            let is_near = |x: [f64; 2]| x[0] > left && x[0] < right && x[1] > lower;
            let mesh = slab.mesh();
            let near = (0..mesh.cell_count() as u32).filter(|cell| is_near(mesh.cell_centre(*cell as usize)));
            slab = slab.refined(&near.collect::<Vec<_>>())?.0;
        }
        Self::with_slab(slab.mesh(), cells)
    }

    fn slab(cells: usize) -> Result<Mesh<2>, Box<dyn Error>> {
        Ok(rectangle([0.0; 2], [3.0, 0.6], [4 * cells - 1, cells], CellShape::Quadrilateral, 1)?)
    }

    fn with_slab(slab: &Mesh<2>, cells: usize) -> Result<Mesh<2>, Box<dyn Error>> {
        let block = rectangle([0.3, 0.61], [1.3, 1.21], [cells, cells], CellShape::Triangle, 1)?;
        Ok(Mesh::of_bodies(&[("slab", slab), ("block", &block)])?)
    }

    /// Both bodies on their mesh, or a part of it, with the pairs of their surfaces.
    ///
    /// # Errors
    /// A mesh that is too large.
    pub fn on(mesh: &Mesh<2>, touch: Pairing) -> Result<Self, Box<dyn Error>> {
        let space = Space::vector(mesh, 2)?;
        let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(4));
        Ok(DrawnBlock { space, assembler: assembler.with_threads(Threads::new(1)), touch })
    }

    /// The slab held, the block's top at a part of its way.
    ///
    /// # Errors
    /// Regions that do not exist.
    pub fn held(&self, part: f64) -> Result<Constraints<2>, Box<dyn Error>> {
        let [along, down] = [(2.0 * part - 1.0).max(0.0) * WAY[0], (2.0 * part).min(1.0) * WAY[1]];
        let mut held = Constraints::new(&self.space);
        held.join_hanging_nodes()?;
        held.fix("slab bottom", |_| [0.0; 2])?;
        held.fix("block top", |_| [along, down])?;
        Ok(held)
    }

    /// A load step from the state before it.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn step(&self, part: f64, before: &Field<2>) -> Result<ContactProblem<2, Law>, Box<dyn Error>> {
        let data = two_bodies::data()
            .lambda(15.0)
            .mu(10.0)
            .gamma0(300.0)
            .friction(FRICTION)
            .displacement_before(before)
            .force_direction([1.0, 0.0])
            .criterion_force(|x: &[f64; 2]| [0.3 + x[0], 0.5 * x[1]]);
        let regions = sliding_bodies::Regions::default().touch(self.touch.clone()).gamma_n("block right");
        let law = sliding_bodies::Model { data, regions };
        Ok(ContactProblem::new(&self.space, law, self.held(part)?).assembler(self.assembler.clone()))
    }

    /// All steps, each solved as is said: the states that were reached.
    ///
    /// # Errors
    /// A step that was not solved.
    pub fn draw(
        &self,
        mut solve: impl FnMut(
            &ContactProblem<2, Law>,
            &Increment<'_, Field<2>>,
        ) -> Result<Solved<2>, Box<dyn Error>>,
    ) -> Result<LoadPath<Field<2>>, Box<dyn Error>> {
        let path = LoadSteps::uniform(STEPS, 1.0).advance(Field::zero(&self.space), |step| {
            let problem = self.step(step.factor, step.before)?;
            solve(&problem, step).map(Solved::into_field)
        });
        path.map_err(|error| error.to_string().into())
    }

    /// The last step's problem with the block's side alone as the own surface: its functionals are forces on the block.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn of_block(&self, before: &Field<2>) -> Result<Law, Box<dyn Error>> {
        let mut law = self.step(1.0, before)?.law;
        law.regions = law.regions.touch(Pairing::onto(SURFACES[1], SURFACES[0]));
        Ok(law)
    }

    /// The space of the displacement.
    pub fn space(&self) -> &Arc<Space<2>> {
        &self.space
    }

    /// Who assembles.
    pub fn assembler(&self) -> &Assembler<2> {
        &self.assembler
    }
}
