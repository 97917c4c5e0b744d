//! Conditions → truth values of a [`Graph`](crate::optimise::scalar::Graph).

use super::Scalariser;
use crate::optimise::scalar::{Node, Scalar};
use crate::parse::syntax::Comparison;
use crate::tensor::Truth;

impl Scalariser<'_> {
    pub(super) fn truth(&mut self, truth: &Truth) -> Scalar {
        match truth {
            Truth::Compare(comparison, a, b) => {
                let (a, b) = (self.scalar(*a), self.scalar(*b));
                match comparison {
                    Comparison::Less => self.graph.less(a, b),
                    Comparison::Greater => self.graph.less(b, a),
                    Comparison::LessEqual => self.graph.intern(Node::LessEqual(a, b)),
                    Comparison::GreaterEqual => self.graph.intern(Node::LessEqual(b, a)),
                    Comparison::Equal => self.graph.intern(Node::Equal(a, b)),
                    Comparison::NotEqual => {
                        let equal = self.graph.intern(Node::Equal(a, b));
                        self.graph.intern(Node::Not(equal))
                    }
                }
            }
            Truth::And(a, b) => {
                let (a, b) = (self.truth(a), self.truth(b));
                self.graph.intern(Node::And(a, b))
            }
            Truth::Or(a, b) => {
                let (a, b) = (self.truth(a), self.truth(b));
                self.graph.intern(Node::Or(a, b))
            }
            Truth::Not(a) => {
                let a = self.truth(a);
                self.graph.intern(Node::Not(a))
            }
        }
    }
}
