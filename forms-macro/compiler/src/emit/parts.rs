//! Cuts of a long straight line into functions of a bounded size, for compilers take more than linear time over long ones.

use std::collections::HashMap;

use crate::optimise::straight_line::{Code, Instruction, Value};
use crate::sorted::SortedSet;

/// Operations of a part at least; what has less than twice as many stays in one piece.
const OPERATIONS: usize = 1000;

/// One function of a straight line.
pub struct Part {
    /// Its instructions, operands first.
    pub values: Vec<Value>,
    /// The values that later parts, or the results, read of it, in the order of its slots.
    pub kept: Vec<Value>,
}

/// The parts of these values of one level; one if they are few.
pub fn parts(code: &Code, own: &[Value], roots: &[Value]) -> Vec<Part> {
    let count = code.operations(own) / OPERATIONS;
    if count < 2 {
        return vec![Part { values: own.to_vec(), kept: vec![] }];
    }
    let cut = Cut::new(code, own, code.operations(own).div_ceil(count));
    let mut parts: Vec<Part> =
        (0..cut.count).map(|number| Part { values: cut.values(code, own, number), kept: vec![] }).collect();
    let mut kept: Vec<SortedSet<Value>> = vec![SortedSet::new(); parts.len()];
    let mut keep = |value: Value, reader: usize| {
        if let Some(part) = cut.part(value).filter(|part| *part < reader) {
            kept[part].insert(value);
        }
    };
    for (number, part) in parts.iter().enumerate() {
        for value in &part.values {
            code.instruction(*value).operands().into_iter().for_each(|operand| keep(operand, number));
        }
    }
    roots.iter().for_each(|root| keep(*root, cut.count));
    for (part, kept) in parts.iter_mut().zip(kept) {
        part.kept = kept.into_iter().collect();
    }
    parts
}

/// Which part computes which value.
struct Cut {
    part: HashMap<Value, usize>,
    count: usize,
}

impl Cut {
    /// In the order of the instructions, with the given number of operations in each part; an entry of a call goes where the call is, for what the call gives is kept by
    /// entries.
    fn new(code: &Code, own: &[Value], most: usize) -> Cut {
        let (mut part, mut number, mut operations) = (HashMap::new(), 0, 0);
        for value in own.iter().filter(|value| !is_repeated(code, **value)) {
            if let Instruction::Entry(call, ..) = code.instruction(*value) {
                part.insert(*value, part.get(call).copied().unwrap_or(number));
                continue;
            }
            if operations == most {
                (number, operations) = (number + 1, 0);
            }
            operations += usize::from(code.instruction(*value).is_operation());
            part.insert(*value, number);
        }
        Cut { part, count: number + 1 }
    }

    fn part(&self, value: Value) -> Option<usize> {
        self.part.get(&value).copied()
    }

    /// The instructions of a part: its own values, and those that it repeats for them.
    fn values(&self, code: &Code, own: &[Value], number: usize) -> Vec<Value> {
        let of_level: SortedSet<Value> = own.iter().copied().collect();
        let mut values: SortedSet<Value> = SortedSet::new();
        let mut pending: Vec<Value> =
            own.iter().copied().filter(|value| self.part(*value) == Some(number)).collect();
        while let Some(value) = pending.pop() {
            if values.insert(value) {
                let operands = code.instruction(value).operands().into_iter();
                pending.extend(operands.filter(|one| is_repeated(code, *one) && of_level.contains(one)));
            }
        }
        values.into_iter().collect()
    }
}

/// Values that each part reads or computes again: inputs cost nothing, and truth values are not stored.
fn is_repeated(code: &Code, value: Value) -> bool {
    let instruction = code.instruction(value);
    matches!(instruction, Instruction::Terminal(_)) || instruction.is_truth()
}
