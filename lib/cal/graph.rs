//! What an expression computes: operations without names, each distinct one stated once, operands before their users.

use super::functions::{Binary, Ternary, Unary};
use std::collections::HashMap;

/// A node's place in its graph.
pub(super) type Id = u32;

/// One operation on the results of other nodes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Node {
    /// The bits of a constant.
    Constant(u64),
    /// A ray variable.
    Channel(u16),
    /// A variable that the caller sets.
    Free(u16),
    /// A parameter of the routine.
    Parameter(u16),
    /// The real argument of the modifier whose number is the operand.
    Argument(Id),
    Unary(Unary, Id),
    Binary(Binary, Id, Id),
    Ternary(Ternary, [Id; 3]),
    /// Condition, value if it is above zero, value if not.
    If([Id; 3]),
    /// Rounded index from 1, then the choices.
    Select(Id, Box<[Id]>),
    /// A routine's number and its arguments.
    Call(u16, Box<[Id]>),
}

/// The nodes of one routine.
#[derive(Default)]
pub(super) struct Graph {
    nodes: Vec<Node>,
    /// Whether the node depends on the ray.
    varies: Vec<bool>,
    known: HashMap<Node, Id>,
}

impl Graph {
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    pub fn node(&self, id: Id) -> &Node {
        &self.nodes[id as usize]
    }

    /// Whether the value depends on a ray variable.
    pub fn varies(&self, id: Id) -> bool {
        self.varies[id as usize]
    }

    /// The value, if it is the same for every evaluation.
    pub fn value(&self, id: Id) -> Option<f64> {
        match self.node(id) {
            Node::Constant(bits) => Some(f64::from_bits(*bits)),
            _ => None,
        }
    }

    pub fn constant(&mut self, value: f64) -> Id {
        let value = if value.is_nan() { f64::NAN } else { value };
        self.add(Node::Constant(value.to_bits()))
    }

    pub fn unary(&mut self, f: Unary, a: Id) -> Id {
        match self.value(a) {
            Some(value) => self.constant(f.apply(value)),
            None => self.add(Node::Unary(f, a)),
        }
    }

    pub fn binary(&mut self, f: Binary, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(a), Some(b)) => self.constant(f.apply(a, b)),
            (Some(nan), _) | (_, Some(nan)) if nan.is_nan() => self.constant(nan),
            (_, Some(0.0)) if f == Binary::Divide => self.constant(f64::NAN),
            // Leave out what changes nothing.
            (_, Some(1.0)) if matches!(f, Binary::Multiply | Binary::Divide | Binary::Power) => a,
            (Some(1.0), _) if f == Binary::Multiply => b,
            (_, Some(2.0)) if f == Binary::Power => self.add(Node::Binary(Binary::Multiply, a, a)),
            _ => self.add(Node::Binary(f, a, b)),
        }
    }

    pub fn ternary(&mut self, f: Ternary, operands: [Id; 3]) -> Id {
        match operands.map(|id| self.value(id)) {
            [Some(x), Some(y), Some(z)] => self.constant(f.apply([x, y, z])),
            // What is wrong with an operand is wrong with it.
            known if known.iter().flatten().any(|value| value.is_nan()) => self.constant(f64::NAN),
            _ => self.add(Node::Ternary(f, operands)),
        }
    }

    /// The node as it stands, without a look at its operands.
    pub fn add(&mut self, node: Node) -> Id {
        if let Some(&id) = self.known.get(&node) {
            return id;
        }
        let id = self.nodes.len() as Id;
        let varies = matches!(node, Node::Channel(_)) || node.operands().any(|operand| self.varies(operand));
        self.nodes.push(node.clone());
        self.varies.push(varies);
        self.known.insert(node, id);
        id
    }
}

impl Node {
    /// The nodes it reads.
    pub fn operands(&self) -> impl Iterator<Item = Id> {
        let (few, many): ([Option<Id>; 3], &[Id]) = match self {
            Self::Constant(_) | Self::Channel(_) | Self::Free(_) | Self::Parameter(_) => ([None; 3], &[]),
            Self::Argument(a) | Self::Unary(_, a) => ([Some(*a), None, None], &[]),
            Self::Binary(_, a, b) => ([Some(*a), Some(*b), None], &[]),
            Self::Ternary(_, all) | Self::If(all) => (all.map(Some), &[]),
            Self::Select(index, choices) => ([Some(*index), None, None], choices),
            Self::Call(_, arguments) => ([None; 3], arguments),
        };
        few.into_iter().flatten().chain(many.iter().copied())
    }
}
