//! Files of a descent: its checkpoint, its history, and every n-th shape.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::checkpoint::{Checkpoint, CheckpointError};
use super::descent::Report;
use super::error::Failure;
use super::history::DescentState;
use super::stored_mesh::StoredMesh;
use crate::field::Field;
use crate::mesh::Mesh;
use crate::output::{VtuFile, write_whole};

/// A directory with `checkpoint.json`, `history.csv`, and `shape_0000.vtu` and so on with the coordinates of the nodes, and
/// next to each the mesh where it was made again, `shape_0000.json`. The checkpoint is written last, after the files that it refers to.
#[derive(Clone, Debug)]
pub struct Logbook {
    directory: PathBuf,
    settings: Value,
    changeable: Value,
    every: usize,
    /// Steps whose shapes are on disk.
    shapes: Vec<usize>,
}

impl Logbook {
    /// The logbook in a directory, which is made if needed. `settings` are all that the result depends on, by name; `changeable`
    /// those besides that a run which goes on may change, kept for the reader. Every n steps the shape is written
    /// (0: the first and the last alone).
    ///
    /// # Errors
    /// The system's error, with the name of the directory.
    pub fn new(
        directory: impl Into<PathBuf>,
        settings: Value,
        changeable: Value,
        every: usize,
    ) -> io::Result<Self> {
        let directory = directory.into();
        std::fs::create_dir_all(&directory)
            .map_err(|error| io::Error::new(error.kind(), format!("{}: {error}", directory.display())))?;
        Ok(Logbook { directory, settings, changeable, every, shapes: vec![] })
    }

    /// The directory.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// The state to go on from, with the shapes that were written on the way to it; `None` without a checkpoint.
    ///
    /// # Errors
    /// As [`Checkpoint::read`] and [`Checkpoint::state_for`].
    pub fn state(&mut self) -> Result<Option<DescentState>, CheckpointError> {
        let Some(mut checkpoint) = Checkpoint::<DescentState>::read(self.directory.join("checkpoint.json"))?
        else {
            return Ok(None);
        };
        let shapes = std::mem::take(&mut checkpoint.shapes);
        let state = checkpoint.state_for(&self.settings)?;
        self.shapes = shapes;
        Ok(Some(state))
    }

    /// Removal of the checkpoint: the next descent begins again.
    ///
    /// # Errors
    /// The system's error.
    pub fn forget(&mut self) -> io::Result<()> {
        self.shapes.clear();
        match std::fs::remove_file(self.directory.join("checkpoint.json")) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }

    /// A descent's report, written; `fields` on the shape go into its .vtu file.
    ///
    /// # Errors
    /// A file that cannot be written, by name.
    pub fn write<S, const D: usize>(
        &mut self,
        report: &Report<S, D>,
        fields: &[(&str, &Field<D>)],
    ) -> Result<(), Failure> {
        let (state, mesh) = (report.state, report.mesh);
        let iteration = state.iterations();
        let is_nth = iteration.checked_rem(self.every) == Some(0);
        if is_nth || iteration == 0 || state.finish.is_some() {
            let mut file = VtuFile::new(mesh);
            for (name, field) in fields {
                file = file.point_data(name, field)?;
            }
            file.write(self.shape(iteration, "vtu"))?;
            let text = serde_json::to_string(&(&state.nodes, &state.mesh))?;
            write_whole(self.shape(iteration, "json"), |file| writeln!(file, "{text}"))?;
            if let Err(place) = self.shapes.binary_search(&iteration) {
                self.shapes.insert(place, iteration);
            }
        }
        let csv = state.csv();
        write_whole(self.directory.join("history.csv"), |file| file.write_all(csv.as_bytes()))?;
        let (settings, changeable) = (self.settings.clone(), self.changeable.clone());
        let checkpoint = Checkpoint::new(settings, changeable, self.shapes.clone(), state.clone());
        Ok(checkpoint.write(self.directory.join("checkpoint.json"))?)
    }

    /// The shapes that were written on the way of a descent, with the numbers of their steps, however many steps lay
    /// between them in this run and in those before. A file that has been removed since is left out.
    ///
    /// # Errors
    /// A file that is not what was written.
    pub fn shapes<const D: usize>(&self, initial: &Mesh<D>) -> Result<Vec<(usize, Mesh<D>)>, Failure> {
        let mut shapes = Vec::new();
        for &number in &self.shapes {
            let path = self.shape(number, "json");
            let named = |why: String| format!("{}: {why}", path.display());
            let text = match std::fs::read_to_string(&path) {
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                text => text.map_err(|error| named(error.to_string()))?,
            };
            let (nodes, stored): (Vec<f64>, Option<StoredMesh>) =
                serde_json::from_str(&text).map_err(|error| named(error.to_string()))?;
            let nodes = nodes.chunks_exact(D).map(|node| std::array::from_fn(|k| node[k])).collect();
            let mesh = match stored {
                Some(stored) => stored.mesh().and_then(|mesh| mesh.with_nodes(nodes)),
                None => initial.with_nodes(nodes),
            };
            let mesh = mesh.map_err(|error| named(error.to_string()))?;
            shapes.push((number, mesh));
        }
        Ok(shapes)
    }

    fn shape(&self, number: usize, extension: &str) -> PathBuf {
        self.directory.join(format!("shape_{number:04}.{extension}"))
    }
}
