//! How a graph becomes operations: each node once, in the innermost branch that holds all its uses, in as few registers as will do.

use super::functions::Binary;
use super::graph::{Graph, Id, Node};
use super::run::{MAX_REGISTERS, Op, Register, Routine};
use std::collections::HashMap;

/// The routine that computes `results` from its parameters; `None` if it is too large.
pub(super) fn emit(graph: &Graph, results: &[Id], parameters: usize) -> Option<Routine> {
    let blocks = place(graph, results);
    if blocks.iter().any(|block| block.depth > MAX_DEPTH) {
        return None;
    }
    let mut emitter =
        Emitter { graph, blocks, registers: HashMap::new(), next: parameters, code: Vec::new(), tables: Vec::new(), lists: Vec::new() };
    emitter.block(0);
    let results: Vec<Register> = results.iter().map(|&id| emitter.operand(id)).collect();
    if emitter.next > usize::from(Register::MAX) || emitter.code.len() > MAX_CODE {
        return None;
    }
    let mut routine = Routine {
        code: emitter.code.into(),
        tables: emitter.tables.into(),
        lists: emitter.lists.into(),
        registers: emitter.next,
        results: results.into(),
    };
    allocate(&mut routine, parameters);
    (routine.registers <= MAX_REGISTERS).then_some(routine)
}

/// The most operations a routine may have.
const MAX_CODE: usize = 1 << 18;

/// The most branches within each other.
const MAX_DEPTH: usize = 1000;

/// A stretch of code that runs only if a branch takes it; the first is the whole routine.
struct Block {
    parent: usize,
    depth: usize,
    /// What is computed there, users before operands.
    nodes: Vec<Id>,
    /// For each choice among blocks made here: its node and the blocks of its choices.
    choices: HashMap<Id, Vec<usize>>,
}

/// Puts every node that is needed into the innermost block that holds all its uses.
fn place(graph: &Graph, results: &[Id]) -> Vec<Block> {
    let mut blocks = vec![Block { parent: 0, depth: 0, nodes: Vec::new(), choices: HashMap::new() }];
    let mut home: Vec<Option<usize>> = vec![None; graph.len()];
    fn enter(blocks: &[Block], home: &mut [Option<usize>], id: Id, block: usize) {
        let place = &mut home[id as usize];
        *place = Some(place.map_or(block, |before| {
            let (mut a, mut b) = (before, block);
            while a != b {
                if blocks[a].depth < blocks[b].depth {
                    std::mem::swap(&mut a, &mut b);
                }
                a = blocks[a].parent;
            }
            a
        }));
    }
    results.iter().for_each(|&id| enter(&blocks, &mut home, id, 0));
    // Operands have smaller numbers than their users.
    for id in (0..graph.len() as Id).rev() {
        let Some(block) = home[id as usize] else { continue };
        let node = graph.node(id);
        if matches!(node, Node::Constant(_) | Node::Parameter(_)) {
            continue;
        }
        blocks[block].nodes.push(id);
        let (condition, choices): (Id, &[Id]) = match node {
            Node::If(all) => (all[0], &all[1..]),
            Node::Select(index, choices) => (*index, choices),
            _ => {
                node.operands().for_each(|operand| enter(&blocks, &mut home, operand, block));
                continue;
            }
        };
        enter(&blocks, &mut home, condition, block);
        let depth = blocks[block].depth + 1;
        let mut inner = Vec::new();
        for &choice in choices {
            inner.push(blocks.len());
            blocks.push(Block { parent: block, depth, nodes: Vec::new(), choices: HashMap::new() });
            enter(&blocks, &mut home, choice, blocks.len() - 1);
        }
        blocks[block].choices.insert(id, inner);
    }
    blocks
}

struct Emitter<'a> {
    graph: &'a Graph,
    blocks: Vec<Block>,
    registers: HashMap<Id, Register>,
    /// Registers so far: each value has its own until `allocate`.
    next: usize,
    code: Vec<Op>,
    tables: Vec<u32>,
    lists: Vec<Register>,
}

impl Emitter<'_> {
    fn fresh(&mut self) -> Register {
        self.next += 1;
        (self.next - 1).min(usize::from(Register::MAX)) as Register
    }

    /// The register that holds a node's value here.
    fn operand(&mut self, id: Id) -> Register {
        match *self.graph.node(id) {
            Node::Constant(bits) => {
                let to = self.fresh();
                self.code.push(Op::Constant { to, value: f64::from_bits(bits) });
                to
            }
            Node::Parameter(i) => i,
            _ => self.registers[&id],
        }
    }

    fn block(&mut self, block: usize) {
        let nodes = std::mem::take(&mut self.blocks[block].nodes);
        for &id in nodes.iter().rev() {
            let to = self.fresh();
            self.node(id, block, to);
        }
    }

    /// Computes a node into the register `to`.
    fn node(&mut self, id: Id, block: usize, to: Register) {
        let op = match self.graph.node(id) {
            Node::If(all) => return self.branch(id, block, *all, to),
            Node::Select(index, choices) => return self.switch(id, block, *index, choices, to),
            &Node::Constant(bits) => Op::Constant { to, value: f64::from_bits(bits) },
            &Node::Parameter(a) => Op::Copy { to, a },
            &Node::Channel(index) => Op::Channel { to, index },
            &Node::Free(index) => Op::Free { to, index },
            &Node::Argument(a) => Op::Argument { to, a: self.operand(a) },
            &Node::Unary(f, a) => Op::Unary { f, to, a: self.operand(a) },
            &Node::Binary(f, a, b) => self.binary(f, a, b, to),
            &Node::Ternary(f, all) => Op::Ternary { f, to, a: all.map(|a| self.operand(a)) },
            Node::Call(routine, arguments) => {
                let registers: Vec<Register> = arguments.iter().map(|&a| self.operand(a)).collect();
                let list = self.lists.len() as u32;
                self.lists.push(registers.len() as Register);
                self.lists.extend(registers);
                Op::Call { to, routine: *routine, list }
            }
        };
        self.code.push(op);
        self.registers.insert(id, to);
    }

    fn binary(&mut self, f: Binary, a: Id, b: Id, to: Register) -> Op {
        match (f, self.graph.value(a), self.graph.value(b)) {
            (Binary::Add, None, Some(c)) => Op::AddConstant { to, a: self.operand(a), c },
            (Binary::Add, Some(c), None) => Op::AddConstant { to, a: self.operand(b), c },
            (Binary::Subtract, None, Some(c)) => Op::AddConstant { to, a: self.operand(a), c: -c },
            (Binary::Subtract, Some(c), None) => Op::ConstantSubtract { to, c, b: self.operand(b) },
            (Binary::Multiply, None, Some(c)) => Op::MultiplyConstant { to, a: self.operand(a), c },
            (Binary::Multiply, Some(c), None) => Op::MultiplyConstant { to, a: self.operand(b), c },
            (Binary::Divide, None, Some(c)) => Op::DivideConstant { to, a: self.operand(a), c },
            (Binary::Divide, Some(c), None) => Op::ConstantDivide { to, c, b: self.operand(b) },
            (Binary::Power, None, Some(c)) => Op::PowerConstant { to, a: self.operand(a), c },
            _ => {
                let (a, b) = (self.operand(a), self.operand(b));
                match f {
                    Binary::Add => Op::Add { to, a, b },
                    Binary::Subtract => Op::Subtract { to, a, b },
                    Binary::Multiply => Op::Multiply { to, a, b },
                    Binary::Divide => Op::Divide { to, a, b },
                    _ => Op::Binary { f, to, a, b },
                }
            }
        }
    }

    fn branch(&mut self, id: Id, block: usize, [condition, a, b]: [Id; 3], to: Register) {
        let inner = self.blocks[block].choices.remove(&id).unwrap_or_default();
        let condition = self.operand(condition);
        self.registers.insert(id, to);
        if inner.iter().all(|&i| self.blocks[i].nodes.is_empty()) {
            let (a, b) = (self.operand(a), self.operand(b));
            self.code.push(Op::Choose { to, condition, a, b });
            return;
        }
        let branch = self.code.len();
        self.code.push(Op::Branch { to, condition, otherwise: 0, end: 0 });
        self.choice(inner[0], a, to);
        let jump = self.code.len();
        self.code.push(Op::Jump { target: 0 });
        let otherwise = self.code.len() as u32;
        self.choice(inner[1], b, to);
        let end = self.code.len() as u32;
        self.code[branch] = Op::Branch { to, condition, otherwise, end };
        self.code[jump] = Op::Jump { target: end };
    }

    fn switch(&mut self, id: Id, block: usize, index: Id, choices: &[Id], to: Register) {
        let inner = self.blocks[block].choices.remove(&id).unwrap_or_default();
        let index = self.operand(index);
        self.registers.insert(id, to);
        let table = self.tables.len();
        self.code.push(Op::Switch { to, index, table: table as u32 });
        self.tables.extend([choices.len() as u32, 0]);
        self.tables.extend(choices.iter().map(|_| 0));
        let mut jumps = Vec::new();
        for (i, (&choice, &block)) in choices.iter().zip(&inner).enumerate() {
            self.tables[table + 2 + i] = self.code.len() as u32;
            self.choice(block, choice, to);
            jumps.push(self.code.len());
            self.code.push(Op::Jump { target: 0 });
        }
        let end = self.code.len() as u32;
        self.tables[table + 1] = end;
        jumps.into_iter().for_each(|jump| self.code[jump] = Op::Jump { target: end });
    }

    /// The code that is run if this choice is taken.
    fn choice(&mut self, block: usize, value: Id, to: Register) {
        // If the value is computed in the block, it comes last there, as the user of all the rest.
        if self.blocks[block].nodes.first() == Some(&value) {
            self.blocks[block].nodes.remove(0);
            self.block(block);
            return self.node(value, block, to);
        }
        self.block(block);
        match self.graph.value(value) {
            Some(value) => self.code.push(Op::Constant { to, value }),
            None => {
                let a = self.operand(value);
                self.code.push(Op::Copy { to, a });
            }
        }
    }
}

/// Lets values share registers. As code only jumps forward, a value is needed at most from its first to its last mention.
fn allocate(routine: &mut Routine, parameters: usize) {
    let end = routine.code.len();
    let mut last = vec![0; routine.registers];
    let lists = &mut routine.lists;
    for (i, op) in routine.code.iter_mut().enumerate() {
        registers(op, lists, &mut |r, _| last[usize::from(*r)] = i);
    }
    routine.results.iter().for_each(|&r| last[usize::from(r)] = end);
    let mut home: Vec<Option<Register>> = vec![None; routine.registers];
    let mut expiring: Vec<Vec<Register>> = vec![Vec::new(); end + 1];
    let mut free: Vec<Register> = Vec::new();
    let mut used = parameters;
    for i in 0..parameters {
        home[i] = Some(i as Register);
        expiring[last[i]].push(i as Register);
    }
    for (i, op) in routine.code.iter_mut().enumerate() {
        registers(op, lists, &mut |r, writes| {
            let place = &mut home[usize::from(*r)];
            if let Some(place) = *place {
                *r = place;
                return;
            }
            debug_assert!(writes, "a register is read before it is written");
            let register = free.pop().unwrap_or_else(|| {
                used += 1;
                (used - 1) as Register
            });
            *place = Some(register);
            expiring[last[usize::from(*r)]].push(register);
            *r = register;
        });
        free.append(&mut expiring[i]);
    }
    routine.results.iter_mut().for_each(|r| *r = home[usize::from(*r)].unwrap_or(*r));
    routine.registers = used;
}

/// Shows `each` the registers of an operation, and whether it writes them: those it reads first.
fn registers(op: &mut Op, lists: &mut [Register], each: &mut impl FnMut(&mut Register, bool)) {
    match op {
        Op::Constant { to, .. } | Op::Channel { to, .. } | Op::Free { to, .. } => each(to, true),
        Op::Argument { to, a } | Op::Copy { to, a } | Op::Unary { to, a, .. } => {
            each(a, false);
            each(to, true);
        }
        Op::AddConstant { to, a, .. }
        | Op::MultiplyConstant { to, a, .. }
        | Op::DivideConstant { to, a, .. }
        | Op::PowerConstant { to, a, .. }
        | Op::ConstantSubtract { to, b: a, .. }
        | Op::ConstantDivide { to, b: a, .. }
        | Op::Branch { to, condition: a, .. }
        | Op::Switch { to, index: a, .. } => {
            each(a, false);
            each(to, true);
        }
        Op::Add { to, a, b }
        | Op::Subtract { to, a, b }
        | Op::Multiply { to, a, b }
        | Op::Divide { to, a, b }
        | Op::Binary { to, a, b, .. } => {
            each(a, false);
            each(b, false);
            each(to, true);
        }
        Op::Ternary { to, a, .. } => {
            a.iter_mut().for_each(|r| each(r, false));
            each(to, true);
        }
        Op::Choose { to, condition, a, b } => {
            [condition, a, b].into_iter().for_each(|r| each(r, false));
            each(to, true);
        }
        Op::Call { to, list, .. } => {
            let start = *list as usize;
            let count = usize::from(lists[start]);
            lists[start + 1..=start + count].iter_mut().for_each(|r| each(r, false));
            each(to, true);
        }
        Op::Jump { .. } => (),
    }
}
