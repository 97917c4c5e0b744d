//! Tasks that depend on each other, with counted costs: threads take the most urgent task that is ready.
//!
//! The graph does not depend on the number of threads, and a task does the same whoever does it: results have the same bits.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use crate::threads::Threads;

/// Tasks, numbered so that each comes after those that it depends on.
#[derive(Debug, Default)]
pub(crate) struct TaskGraph {
    costs: Vec<f64>,
    /// Starts of each task's dependents.
    pointers: Vec<u32>,
    dependents: Vec<u32>,
    /// Number of tasks that each depends on.
    needs: Vec<u32>,
    /// Cost of the most costly chain of tasks from each one on.
    urgency: Vec<f64>,
}

/// Counted work of a stage, and how far threads can share it.
#[derive(Clone, Debug, PartialEq)]
pub struct SharedWork {
    /// Sum of all tasks' costs \[operations\].
    pub work: f64,
    /// Cost of the most costly chain of tasks that depend on each other \[operations\].
    pub critical_path: f64,
    /// Numbers of threads with the cost until the last of them has finished \[operations\].
    spans: Vec<(usize, f64)>,
}

impl SharedWork {
    /// Numbers of threads for which speed-ups are counted.
    pub const THREADS: [usize; 5] = [2, 4, 8, 16, 64];

    /// Counted work of tasks that do not depend on each other, which each number of threads shares in parts of its own.
    pub fn of_parts(parts: impl Fn(usize) -> Vec<f64>) -> Self {
        let spans = Self::THREADS.map(|threads| (threads, parts(threads).into_iter().fold(0.0, f64::max)));
        let work = parts(1).into_iter().sum();
        SharedWork { work, critical_path: spans[Self::THREADS.len() - 1].1, spans: spans.to_vec() }
    }

    /// Counted work of one thread.
    pub(crate) fn alone(work: f64) -> Self {
        Self::of_parts(|_| vec![work])
    }

    /// This stage and one after it.
    pub(crate) fn then(mut self, next: &Self) -> Self {
        self.work += next.work;
        self.critical_path += next.critical_path;
        self.spans.iter_mut().zip(&next.spans).for_each(|((_, span), (_, other))| *span += other);
        self
    }

    /// The largest speed-up by one of the numbers of [`SharedWork::THREADS`]: the work divided by the cost until the last thread has finished, if
    /// threads wait only for tasks. Memory and the time to hand tasks over are not counted.
    pub fn speed_up(&self, threads: usize) -> Option<f64> {
        let (_, span) = self.spans.iter().find(|(count, _)| *count == threads)?;
        Some(if *span > 0.0 { self.work / span } else { 1.0 })
    }
}

/// A task that is ready: the most urgent first, and of equals the one with the smallest number.
type Ready = BinaryHeap<(u64, Reverse<u32>)>;

struct State {
    ready: Ready,
    needs: Vec<u32>,
    running: usize,
}

impl TaskGraph {
    /// Tasks of the given costs. An edge is a task and a later one that depends on it; edges may repeat.
    pub(crate) fn new(costs: Vec<f64>, edges: &[(u32, u32)]) -> Self {
        let count = costs.len();
        let (mut pointers, mut needs) = (vec![0_u32; count + 2], vec![0_u32; count]);
        for (before, after) in edges {
            pointers[*before as usize + 2] += 1;
            needs[*after as usize] += 1;
        }
        for k in 2..pointers.len() {
            pointers[k] += pointers[k - 1];
        }
        let mut dependents = vec![0_u32; edges.len()];
        for (before, after) in edges {
            let next = &mut pointers[*before as usize + 1];
            dependents[*next as usize] = *after;
            *next += 1;
        }
        pointers.pop();
        let mut graph = TaskGraph { costs, pointers, dependents, needs, urgency: vec![0.0; count] };
        for task in (0..count).rev() {
            let after = graph.dependents(task).iter().map(|after| graph.urgency[*after as usize]);
            graph.urgency[task] = graph.costs[task] + after.fold(0.0, f64::max);
        }
        graph
    }

    fn dependents(&self, task: usize) -> &[u32] {
        &self.dependents[self.pointers[task] as usize..self.pointers[task + 1] as usize]
    }

    fn key(&self, task: u32) -> (u64, Reverse<u32>) {
        // Costs are not negative, and their bits have the same order.
        (self.urgency[task as usize].to_bits(), Reverse(task))
    }

    fn first_ready(&self) -> Ready {
        (0..).zip(&self.needs).filter(|(_, needs)| **needs == 0).map(|(task, _)| self.key(task)).collect()
    }

    /// Does all tasks, one thread in the order of their numbers. One thread has the memory at hand.
    pub(crate) fn run<Memory: Default + Send>(
        &self,
        threads: Threads,
        memory: &mut Memory,
        work: impl Fn(usize, &mut Memory) + Send + Sync,
    ) {
        let count = self.costs.len();
        if threads == Threads::ONE || count < 2 {
            (0..count).for_each(|task| work(task, memory));
            return;
        }
        let state = State { ready: self.first_ready(), needs: self.needs.clone(), running: 0 };
        let (state, changed) = (Mutex::new(state), Condvar::new());
        let mut memories = vec![Some(memory)];
        memories.resize_with(threads.count().min(count), || None);
        threads.run(memories, |memory| {
            let mut own = Memory::default();
            let memory = memory.unwrap_or(&mut own);
            while let Some(task) = next(&state, &changed) {
                let mut turn = Turn { graph: self, task, state: &state, changed: &changed, is_done: false };
                work(task, memory);
                turn.is_done = true;
            }
        });
    }

    /// Cost until all tasks are done, if the given number of threads take the most urgent task that is ready.
    fn span(&self, threads: usize) -> f64 {
        let (mut ready, mut needs) = (self.first_ready(), self.needs.clone());
        // Ends of the tasks at work, the first one first.
        let mut running: BinaryHeap<Reverse<(u64, u32)>> = BinaryHeap::new();
        let mut now = 0.0;
        loop {
            while running.len() < threads
                && let Some((_, Reverse(task))) = ready.pop()
            {
                let end: f64 = now + self.costs[task as usize];
                running.push(Reverse((end.to_bits(), task)));
            }
            let Some(Reverse((end, task))) = running.pop() else { return now };
            now = f64::from_bits(end);
            for after in self.dependents(task as usize) {
                needs[*after as usize] -= 1;
                if needs[*after as usize] == 0 {
                    ready.push(self.key(*after));
                }
            }
        }
    }

    /// The counted work.
    pub(crate) fn shared_work(&self) -> SharedWork {
        SharedWork {
            work: self.costs.iter().sum(),
            critical_path: self.urgency.iter().copied().fold(0.0, f64::max),
            spans: SharedWork::THREADS.map(|threads| (threads, self.span(threads))).to_vec(),
        }
    }
}

fn lock(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The next task; none if all are done or at work and nothing will follow. Whoever waits does so for a task that is at work.
fn next(state: &Mutex<State>, changed: &Condvar) -> Option<usize> {
    let mut state = lock(state);
    loop {
        if let Some((_, Reverse(task))) = state.ready.pop() {
            state.running += 1;
            return Some(task as usize);
        }
        if state.running == 0 {
            return None;
        }
        state = changed.wait(state).unwrap_or_else(PoisonError::into_inner);
    }
}

/// The time in which a thread does a task. Its end is made known even if the task panics, or other threads would wait forever.
struct Turn<'a> {
    graph: &'a TaskGraph,
    task: usize,
    state: &'a Mutex<State>,
    changed: &'a Condvar,
    is_done: bool,
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        let mut state = lock(self.state);
        state.running -= 1;
        if !self.is_done {
            state.ready.clear();
        }
        for after in self.graph.dependents(self.task).iter().filter(|_| self.is_done) {
            state.needs[*after as usize] -= 1;
            if state.needs[*after as usize] == 0 {
                state.ready.push(self.graph.key(*after));
            }
        }
        drop(state);
        self.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// A binary tree of 127 tasks, children first, each of cost one.
    fn tree() -> TaskGraph {
        let edges: Vec<(u32, u32)> = (0..126).map(|task| (task, 64 + task / 2)).collect();
        TaskGraph::new(vec![1.0; 127], &edges)
    }

    #[test]
    fn each_task_comes_once_and_after_what_it_depends_on() {
        let graph = tree();
        for threads in [1, 2, 3, 7, 16] {
            let ends: Vec<AtomicUsize> = (0..127).map(|_| AtomicUsize::new(0)).collect();
            let clock = AtomicUsize::new(1);
            graph.run(Threads::new(threads), &mut (), |task, ()| {
                if task >= 64 {
                    for child in [2 * (task - 64), 2 * (task - 64) + 1] {
                        assert!(ends[child].load(Ordering::SeqCst) > 0, "{child} before {task}");
                    }
                }
                let before = ends[task].swap(clock.fetch_add(1, Ordering::SeqCst), Ordering::SeqCst);
                assert_eq!(before, 0);
            });
            assert_eq!(clock.into_inner(), 128);
        }
    }

    #[test]
    fn speed_ups_are_those_of_a_schedule() {
        let counted = tree().shared_work();
        assert_eq!((counted.work, counted.critical_path), (127.0, 7.0));
        // Levels of 64, 32, 16, 8, 4, 2 and 1 tasks.
        assert_eq!(counted.speed_up(64), Some(127.0 / 7.0));
        assert_eq!(counted.speed_up(2), Some(127.0 / 64.0));
        assert_eq!(counted.speed_up(16), Some(127.0 / 11.0));
        assert_eq!(counted.speed_up(5), None);
        let parts = SharedWork::of_parts(|threads| vec![64.0 / threads as f64; threads]);
        assert_eq!((parts.work, parts.speed_up(16)), (64.0, Some(16.0)));
    }

    #[test]
    #[should_panic(expected = "the fifth")]
    fn a_panic_of_a_task_ends_the_run() {
        tree().run(Threads::new(4), &mut (), |task, ()| assert!(task != 5, "the fifth"));
    }
}
