//! The tasks of a factorisation, which threads share.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::rooms::Room;
use super::triangles::Triangles;
use super::{Numeric, PANEL, Scratch, panels};
use crate::elimination::Task;
use crate::threads::Threads;

impl<P: Triangles> Numeric<'_, P> {
    /// Factors into the values; an error is the place in the elimination order of the first pivot that is not taken.
    pub(in crate::cholesky) fn factorise(&self, threads: Threads, values: &mut [f64]) -> Result<(), usize> {
        let units = &self.elimination.units;
        let (mut rooms, mut rest, mut start) = (Vec::with_capacity(units.len()), values, 0);
        for unit in units {
            let count = self.values(unit.supernodes.clone()).len();
            let (own, others) = rest.split_at_mut(count);
            rooms.push(Room::new(unit, start, own));
            (rest, start) = (others, start + count);
        }
        // Tasks on later columns are left out: they may depend on the one that failed. Those on earlier columns are done, so that the first is found.
        let failed = AtomicUsize::new(usize::MAX);
        self.elimination.factorisation.run(threads, &mut Scratch::default(), |number, scratch| {
            let task = self.elimination.tasks[number];
            let place = self.first_column(task);
            if place < failed.load(Ordering::Relaxed)
                && let Err(column) = self.carry_out(task, &rooms, scratch)
            {
                failed.fetch_min(column, Ordering::Relaxed);
            }
        });
        match failed.into_inner() {
            usize::MAX => Ok(()),
            column => Err(column),
        }
    }

    fn first_column(&self, task: Task) -> usize {
        let (unit, panel) = match task {
            Task::Range(unit) | Task::Open(unit) => (unit, 0),
            Task::Gather(unit, panel) | Task::Take(unit, panel, _) => (unit, panel),
        };
        let supernode = self.elimination.units[unit as usize].supernodes.start;
        self.columns(supernode).start + panel as usize * PANEL
    }

    fn carry_out<'v>(&self, task: Task, rooms: &[Room<'v>], scratch: &mut Scratch) -> Result<(), usize> {
        match task {
            Task::Range(unit) => self.range(unit as usize, rooms, scratch),
            Task::Open(unit) => {
                let unit = unit as usize;
                let Some(values) = rooms[unit].take() else { return Ok(()) };
                scratch.begin(rooms[unit].start);
                scratch.prefault(rooms[unit].start, values.len(), values);
                let columns = self.columns(self.elimination.units[unit].supernodes.start);
                let height = values.len() / (P::COUNT * columns.len());
                rooms[unit].cut(values, Self::panel_length(height));
                Ok(())
            }
            Task::Gather(unit, panel) => self.panel(unit as usize, panel as usize, None, rooms, scratch),
            Task::Take(unit, panel, earlier) => {
                self.panel(unit as usize, panel as usize, Some(earlier as usize), rooms, scratch)
            }
        }
    }

    /// Factors the supernodes of a unit one after the other.
    fn range<'v>(&self, unit: usize, rooms: &[Room<'v>], scratch: &mut Scratch) -> Result<(), usize> {
        let (room, supernodes) = (&rooms[unit], self.elimination.units[unit].supernodes.clone());
        let Some(values) = room.take() else { return Ok(()) };
        scratch.begin(room.start);
        for supernode in supernodes.clone() {
            let place = self.values(supernode..supernode + 1);
            let (known, later) = values.split_at_mut(place.start - room.start);
            scratch.prefault(place.start, place.len(), later);
            let source = Source { first: supernodes.start, start: room.start, own: known, rooms };
            self.supernode(supernode, source, &mut later[..place.len()], scratch)?;
        }
        room.publish(values);
        Ok(())
    }

    /// One step of a panel: what earlier supernodes take from it, or what an earlier panel does; and its factorisation after the last of them.
    fn panel<'v>(
        &self,
        unit: usize,
        panel: usize,
        earlier: Option<usize>,
        rooms: &[Room<'v>],
        scratch: &mut Scratch,
    ) -> Result<(), usize> {
        let (room, supernode) = (&rooms[unit], self.elimination.units[unit].supernodes.start);
        let Some(values) = room.take_panel(panel) else { return Ok(()) };
        let columns = self.columns(supernode);
        let height = columns.len() + self.symbolic.supernode(supernode).pattern().len();
        let first = panel * PANEL;
        let next = match earlier {
            None => {
                self.place_rows(supernode, scratch);
                let source = Source { first: supernode, start: room.start, own: &[], rooms };
                let Scratch { places, own, .. } = &mut *scratch;
                self.gather(supernode, columns.start + first, source, (values, height), places, own);
                0
            }
            Some(earlier) => {
                let Some(known) = room.panel(earlier) else { return Ok(()) };
                panels::take::<P>((known, earlier * PANEL), (values, height), first, &mut scratch.own);
                earlier + 1
            }
        };
        if next < panel {
            room.put_back(panel, values);
            return Ok(());
        }
        let place = columns.start + first;
        panels::factor((self.pivots, place), (values, height), first, &mut scratch.own)
            .map_err(|column| place + column)?;
        room.publish_panel(panel, values);
        Ok(())
    }
}

/// Earlier supernodes: those of the unit at work, and those of units that are known.
#[derive(Clone, Copy)]
pub(super) struct Source<'s, 'v> {
    /// The unit's first supernode.
    pub(super) first: usize,
    /// Place of its first value among all.
    pub(super) start: usize,
    pub(super) own: &'s [f64],
    pub(super) rooms: &'s [Room<'v>],
}
