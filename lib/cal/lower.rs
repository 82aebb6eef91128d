//! From definitions to a graph: every name looked up, every call replaced by what it computes, constants folded.
//!
//! Arguments are substituted where they are used, so they are evaluated lazily; as the graph states everything once, they are evaluated at
//! most once. Functions passed by name are known by then. Only functions that call themselves remain calls, unless constant arguments
//! end the recursion here.

use super::emit::emit;
use super::functions::{Binary, Builtin, Unary, nearest};
use super::graph::{Graph, Id, Node};
use super::parse::{self, Expression, Target};
use super::run::{Program, Routine, argument, run};
use super::{Context, Definition, Library, Meaning, Text};
use crate::error::Error;
use std::cell::Cell;
use std::collections::{HashMap, HashSet};

/// Why lowering ended.
pub(super) enum Stop {
    Error(Error),
    /// A recursion did not come to its end within bounds.
    Endless,
}

/// What a function's name stands for.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Function {
    Builtin(Builtin),
    Symbol(usize),
}

/// What a parameter stands for.
enum Binding<'e> {
    Function(Function),
    /// An argument as written, where it was written, and its node once it is needed.
    Written(&'e parse::Node, &'e Scope<'e>, Cell<Option<Id>>),
    Ready(Id),
    Missing,
}

/// What kind of argument a recursive function is compiled for.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Kind {
    Value,
    Function(Function),
    Missing,
}

/// Where an expression stands: the text, and the parameters around it.
pub(super) struct Scope<'e> {
    text: &'e Text,
    bindings: Vec<Binding<'e>>,
}

impl<'e> Scope<'e> {
    /// A scope without parameters.
    pub fn of(text: &'e Text) -> Self {
        Self { text, bindings: Vec::new() }
    }
}

/// How deep expressions may nest, counting through the definitions they use.
const MAX_DEPTH: usize = 900;
/// How much deeper, and how many nodes longer, a recursion over constants may make an expression before it becomes a call.
const UNROLL_DEPTH: usize = 500;
const UNROLL_NODES: usize = 3000;
/// How many parts of expressions may be visited for one program.
const MAX_WORK: usize = 3_000_000;

type Lowered = Result<Id, Stop>;

/// The work in progress for one program.
pub(super) struct Lowering<'l> {
    library: &'l Library,
    arguments: &'l [f64],
    graph: Graph,
    /// The node of each variable met so far; `None` while it is being lowered.
    variables: HashMap<usize, Option<Id>>,
    /// The functions that remain calls; `None` while one is being lowered. The first is the program itself.
    routines: Vec<Option<Routine>>,
    reads_ray: Vec<u64>,
    /// Which routine is which function, for which arguments that are functions (or missing).
    instances: HashMap<(usize, Vec<Kind>), usize>,
    recursive: HashMap<usize, bool>,
    /// Recursions whose end was looked for in vain.
    endless: HashSet<usize>,
    /// While a recursion is unrolled: the depth and size at which to give up.
    unrolling: Option<(usize, usize)>,
    depth: usize,
    work: usize,
    /// The first thing that is wrong; it matters if the result needs it.
    problem: Option<Error>,
}

impl<'l> Lowering<'l> {
    pub fn new(library: &'l Library, arguments: &'l [f64]) -> Self {
        Self {
            library,
            arguments,
            graph: Graph::default(),
            variables: HashMap::new(),
            routines: vec![None],
            reads_ray: vec![0],
            instances: HashMap::new(),
            recursive: HashMap::new(),
            endless: HashSet::new(),
            unrolling: None,
            depth: 0,
            work: 0,
            problem: None,
        }
    }

    /// The root node of an expression.
    pub fn expression(&mut self, node: &parse::Node, text: &Text) -> Result<Id, Error> {
        let lowered = self.lower(node, &Scope::of(text));
        self.root(lowered, || {
            text.error(
                node.left,
                "this has no value (division by zero, an argument outside a function's range, or a recursion without end)",
            )
        })
    }

    /// The root node of a function applied to some of the program's parameters.
    pub fn applied(&mut self, symbol: usize, name: &str, parameters: &[usize], text: &Text) -> Result<Id, Error> {
        let Some(function) = self.library.function_of(symbol) else {
            return Err(text.error(text.len(), format!("undefined function '{name}'")));
        };
        let operands: Vec<Id> = parameters.iter().map(|&i| self.graph.add(Node::Parameter(i as u16))).collect();
        let bindings = operands.into_iter().map(Binding::Ready).collect();
        let lowered = match function {
            Function::Builtin(builtin) => self.builtin_of(builtin, &Scope { text, bindings }, text.len()),
            Function::Symbol(symbol) => self.call(symbol, bindings, &Scope::of(text), text.len()),
        };
        self.root(lowered, || text.error(text.len(), format!("'{name}' has no value")))
    }

    /// The program with these results.
    pub fn finish(mut self, roots: &[Id], parameters: usize) -> Option<Program> {
        let constants: Option<Vec<f64>> = roots.iter().map(|&id| self.graph.value(id)).collect();
        self.routines[0] = Some(emit(&self.graph, roots, parameters)?);
        self.reads_ray[0] = reads(&self.graph);
        let uses_arguments = (0..self.graph.len()).any(|id| matches!(self.graph.node(id as Id), Node::Argument(_)));
        let routines: Vec<Routine> = self.routines.into_iter().collect::<Option<_>>()?;
        Some(Program {
            arguments: if uses_arguments || routines.len() > 1 { self.arguments.into() } else { [].into() },
            routines: routines.into(),
            parameters,
            channels: self.reads_ray.iter().fold(0, |all, mask| all | mask),
            constants: constants.map(Into::into),
        })
    }

    fn root(&mut self, lowered: Lowered, no_value: impl Fn() -> Error) -> Result<Id, Error> {
        match lowered {
            Ok(id) if self.graph.value(id).is_some_and(|v| !v.is_finite()) => Err(self.problem.take().unwrap_or_else(no_value)),
            Ok(id) => Ok(id),
            Err(Stop::Error(error)) => Err(error),
            Err(Stop::Endless) => Err(no_value()),
        }
    }

    /// Notes what is wrong and gives a node without a value: only what needs it fails.
    fn wrong(&mut self, scope: &Scope, at: usize, message: impl Into<String>) -> Lowered {
        if self.problem.is_none() {
            self.problem = Some(scope.text.error(at, message));
        }
        Ok(self.graph.constant(f64::NAN))
    }

    fn lower(&mut self, node: &parse::Node, scope: &Scope) -> Lowered {
        self.work += 1;
        if self.work > MAX_WORK {
            return Err(Stop::Error(scope.text.error(node.left, "this expands to too large an expression")));
        }
        if self.unrolling.is_some_and(|(depth, nodes)| self.depth > depth || self.graph.len() > nodes) {
            return Err(Stop::Endless);
        }
        if self.depth > MAX_DEPTH {
            return Err(Stop::Error(scope.text.error(node.left, "definitions that use each other nest too deeply")));
        }
        self.depth += 1;
        let lowered = self.lower_inner(node, scope);
        self.depth -= 1;
        lowered
    }

    fn lower_inner(&mut self, node: &parse::Node, scope: &Scope) -> Lowered {
        match &node.expression {
            Expression::Number(value) => Ok(self.graph.constant(*value)),
            Expression::Channel(n) => Ok(self.channel(*n as usize - 1)),
            Expression::Name(name) => match name.target {
                Target::Parameter(i) => self.parameter(i, scope, node.left),
                Target::Symbol(symbol) => self.variable(symbol, &name.text, scope, node.left),
                Target::Unbound => self.wrong(scope, node.left, format!("unknown name '{}'", name.text)),
            },
            Expression::Negate(inner) => {
                let inner = self.lower(inner, scope)?;
                Ok(self.graph.unary(Unary::Negate, inner))
            }
            Expression::Sum(first, rest) => self.chain(first, rest, [Binary::Add, Binary::Subtract], scope),
            Expression::Product(first, rest) => self.chain(first, rest, [Binary::Multiply, Binary::Divide], scope),
            Expression::Power(base, exponent) => {
                let (base, exponent) = (self.lower(base, scope)?, self.lower(exponent, scope)?);
                Ok(self.graph.binary(Binary::Power, base, exponent))
            }
            Expression::Call(name, arguments) => {
                let function = match name.target {
                    Target::Parameter(i) => match scope.bindings.get(i) {
                        Some(Binding::Function(function)) => Some(*function),
                        _ => None,
                    },
                    Target::Symbol(symbol) => self.library.function_of(symbol),
                    Target::Unbound => None,
                };
                match function {
                    None => self.wrong(scope, node.left, format!("undefined function '{}'", name.text)),
                    Some(Function::Builtin(builtin)) => {
                        let bindings = arguments.iter().map(|argument| self.bind(argument, scope)).collect();
                        self.builtin_of(builtin, &Scope { text: scope.text, bindings }, node.left)
                    }
                    Some(Function::Symbol(symbol)) => {
                        let bindings = arguments.iter().map(|argument| self.bind(argument, scope)).collect();
                        self.call(symbol, bindings, scope, node.left)
                    }
                }
            }
        }
    }

    fn channel(&mut self, index: usize) -> Id {
        self.graph.add(Node::Channel(index.min(usize::from(u16::MAX)) as u16))
    }

    fn chain(&mut self, first: &parse::Node, rest: &[(bool, parse::Node)], operators: [Binary; 2], scope: &Scope) -> Lowered {
        let mut value = self.lower(first, scope)?;
        for (second, node) in rest {
            let operand = self.lower(node, scope)?;
            value = self.graph.binary(operators[usize::from(*second)], value, operand);
        }
        Ok(value)
    }

    fn bind<'e>(&self, argument: &'e parse::Node, scope: &'e Scope<'e>) -> Binding<'e> {
        if let Expression::Name(name) = &argument.expression {
            match name.target {
                Target::Parameter(i) => match scope.bindings.get(i) {
                    Some(Binding::Function(function)) => return Binding::Function(*function),
                    Some(Binding::Ready(id)) => return Binding::Ready(*id),
                    _ => (),
                },
                Target::Symbol(symbol) if !self.library.is_variable(symbol) => {
                    if let Some(function) = self.library.function_of(symbol) {
                        return Binding::Function(function);
                    }
                }
                _ => (),
            }
        }
        Binding::Written(argument, scope, Cell::new(None))
    }

    fn parameter(&mut self, i: usize, scope: &Scope, at: usize) -> Lowered {
        match scope.bindings.get(i) {
            Some(Binding::Ready(id)) => Ok(*id),
            Some(Binding::Written(node, around, known)) => match known.get() {
                Some(id) => Ok(id),
                None => {
                    let id = self.lower(node, around)?;
                    known.set(Some(id));
                    Ok(id)
                }
            },
            Some(Binding::Function(_)) => self.wrong(scope, at, "a function is used as if it were a value; give it arguments"),
            Some(Binding::Missing) | None => self.wrong(scope, at, "the call gives this function too few arguments"),
        }
    }

    fn variable(&mut self, symbol: usize, name: &str, scope: &Scope, at: usize) -> Lowered {
        let library = self.library;
        let definition: &Definition = match &library.symbols[symbol].meaning {
            Some(Meaning::Variable(definition)) => definition,
            Some(Meaning::Channel(index)) => return Ok(self.channel(usize::from(*index))),
            Some(Meaning::Free(index)) => return Ok(self.graph.add(Node::Free(*index as u16))),
            Some(Meaning::Function(_)) => return self.wrong(scope, at, format!("'{name}' is a function; give it arguments")),
            None => return self.wrong(scope, at, format!("undefined variable '{name}'")),
        };
        match self.variables.get(&symbol) {
            Some(Some(id)) => return Ok(*id),
            Some(None) => return self.wrong(scope, at, format!("'{name}' is defined by itself")),
            None => (),
        }
        self.variables.insert(symbol, None);
        let lowered = self.lower(&definition.statement.body, &Scope::of(&definition.text));
        self.variables.remove(&symbol);
        let id = lowered?;
        if definition.statement.constant && self.graph.varies(id) {
            let message = format!("'{name}' is defined with ':' as a constant but depends on the ray; define it with '='");
            return Err(Stop::Error(definition.text.error(definition.statement.body.left, message)));
        }
        self.variables.insert(symbol, Some(id));
        Ok(id)
    }

    /// A function without definition, applied to all the bindings of `scope`.
    fn builtin_of(&mut self, builtin: Builtin, scope: &Scope, at: usize) -> Lowered {
        if scope.bindings.len() < builtin.arity() {
            return self.wrong(scope, at, "too few arguments");
        }
        let first = self.parameter(0, scope, at)?;
        let constant = self.graph.value(first);
        match builtin {
            Builtin::Unary(f) => Ok(self.graph.unary(f, first)),
            Builtin::Binary(f) => {
                let second = self.parameter(1, scope, at)?;
                Ok(self.graph.binary(f, first, second))
            }
            Builtin::Ternary(f) => {
                let (second, third) = (self.parameter(1, scope, at)?, self.parameter(2, scope, at)?);
                Ok(self.graph.ternary(f, [first, second, third]))
            }
            Builtin::Fold(f) => {
                let mut value = first;
                for i in 1..scope.bindings.len() {
                    let operand = self.parameter(i, scope, at)?;
                    value = self.graph.binary(f, value, operand);
                }
                Ok(value)
            }
            Builtin::If => match constant {
                Some(c) if c.is_nan() => Ok(first),
                Some(c) => self.parameter(if c > 0.0 { 1 } else { 2 }, scope, at),
                None => {
                    let (a, b) = (self.parameter(1, scope, at)?, self.parameter(2, scope, at)?);
                    Ok(if a == b { a } else { self.graph.add(Node::If([first, a, b])) })
                }
            },
            Builtin::Select => {
                let count = scope.bindings.len() - 1;
                match constant.map(|c| (c.is_nan(), nearest(c))) {
                    Some((false, 0)) => Ok(self.graph.constant(count as f64)),
                    Some((false, n)) if n >= 1 && n as usize <= count => self.parameter(n as usize, scope, at),
                    Some(_) => self.wrong(scope, at, format!("select has no choice of that number; there are {count}")),
                    None => {
                        let choices = (1..=count).map(|i| self.parameter(i, scope, at)).collect::<Result<_, _>>()?;
                        Ok(self.graph.add(Node::Select(first, choices)))
                    }
                }
            }
            Builtin::Arg => match constant {
                Some(n) => match argument(self.arguments, n) {
                    missing if missing.is_nan() => {
                        self.wrong(scope, at, format!("real argument {} is missing; there are {}", nearest(n), self.arguments.len()))
                    }
                    value => Ok(self.graph.constant(value)),
                },
                None => Ok(self.graph.add(Node::Argument(first))),
            },
        }
    }

    /// A defined function, applied to `bindings`.
    fn call(&mut self, symbol: usize, bindings: Vec<Binding>, scope: &Scope, at: usize) -> Lowered {
        let library = self.library;
        let Some(Meaning::Function(definition)) = &library.symbols[symbol].meaning else {
            return self.wrong(scope, at, "undefined function");
        };
        let inner = Scope { text: &definition.text, bindings };
        if !self.is_recursive(symbol) || self.unrolling.is_some() {
            return self.lower(&definition.statement.body, &inner);
        }
        // See whether constant arguments bring the recursion to an end.
        let count = definition.parameters().len();
        let mut values = Vec::new();
        for i in 0..count.min(inner.bindings.len()) {
            if !matches!(inner.bindings[i], Binding::Function(_) | Binding::Missing) {
                values.push(self.parameter(i, &inner, at)?);
            }
        }
        if !self.endless.contains(&symbol) && values.iter().any(|&id| self.graph.value(id).is_some()) {
            let problem = self.problem.clone();
            self.unrolling = Some((self.depth + UNROLL_DEPTH.min(MAX_DEPTH.saturating_sub(self.depth)), self.graph.len() + UNROLL_NODES));
            let unrolled = self.lower(&definition.statement.body, &inner);
            self.unrolling = None;
            match unrolled {
                Err(Stop::Endless) => {
                    self.problem = problem;
                    self.endless.insert(symbol);
                }
                done => return done,
            }
        }
        let key: Vec<Kind> = (0..count)
            .map(|i| match inner.bindings.get(i) {
                Some(Binding::Function(function)) => Kind::Function(*function),
                Some(Binding::Missing) | None => Kind::Missing,
                Some(_) => Kind::Value,
            })
            .collect();
        let routine = self.routine(symbol, definition, key, scope, at)?;
        let constants: Option<Vec<f64>> = values.iter().map(|&id| self.graph.value(id)).collect();
        match constants {
            Some(constants) if self.is_constant(routine) => Ok(self.evaluate(routine, &constants)),
            _ => Ok(self.graph.add(Node::Call(routine as u16, values.into()))),
        }
    }

    /// The routine of a function that calls itself, for these kinds of arguments.
    fn routine(&mut self, symbol: usize, definition: &Definition, key: Vec<Kind>, scope: &Scope, at: usize) -> Result<usize, Stop> {
        if let Some(&routine) = self.instances.get(&(symbol, key.clone())) {
            return Ok(routine);
        }
        if self.routines.len() >= usize::from(u16::MAX) {
            return Err(Stop::Error(scope.text.error(at, "this needs too many different recursive functions")));
        }
        let routine = self.routines.len();
        let outside = (std::mem::take(&mut self.graph), std::mem::take(&mut self.variables));
        let mut parameters = 0;
        let bindings = key
            .iter()
            .map(|kind| match kind {
                Kind::Function(function) => Binding::Function(*function),
                Kind::Missing => Binding::Missing,
                Kind::Value => {
                    parameters += 1;
                    Binding::Ready(self.graph.add(Node::Parameter(parameters as u16 - 1)))
                }
            })
            .collect();
        self.instances.insert((symbol, key), routine);
        self.routines.push(None);
        self.reads_ray.push(0);
        let result = self.lower(&definition.statement.body, &Scope { text: &definition.text, bindings });
        let body = std::mem::replace(&mut self.graph, outside.0);
        self.variables = outside.1;
        let code = emit(&body, &[result?], parameters);
        self.reads_ray[routine] = reads(&body);
        match code {
            Some(code) => self.routines[routine] = Some(code),
            None => return Err(Stop::Error(scope.text.error(at, "this expands to too large an expression"))),
        }
        Ok(routine)
    }

    /// Whether a routine is complete and its result depends on its parameters only.
    fn is_constant(&self, routine: usize) -> bool {
        // Whatever it may call is among the routines so far; ask it of all of them.
        self.routines[1..].iter().all(Option::is_some) && self.reads_ray[1..].iter().all(|&mask| mask == 0) && routine > 0
    }

    /// The result of a complete routine for constants.
    fn evaluate(&mut self, routine: usize, constants: &[f64]) -> Id {
        let routines = std::mem::take(&mut self.routines);
        // Enter through a routine that calls it.
        let mut enter = Graph::default();
        let operands = constants.iter().map(|&value| enter.constant(value)).collect();
        let call = enter.add(Node::Call(routine as u16, operands));
        let mut program: Vec<Routine> = vec![emit(&enter, &[call], 0).unwrap_or_default()];
        program.extend(routines.into_iter().skip(1).flatten());
        let mut value = f64::NAN;
        run(&program, self.arguments, &[], &Context::default(), |result| value = result);
        self.routines = program.into_iter().map(Some).collect();
        self.routines[0] = None;
        self.graph.constant(value)
    }

    /// Whether a function can come back to itself.
    fn is_recursive(&mut self, symbol: usize) -> bool {
        if let Some(&known) = self.recursive.get(&symbol) {
            return known;
        }
        let (mut seen, mut open) = (HashSet::new(), vec![symbol]);
        let mut found = false;
        while let Some(next) = open.pop() {
            if let Some(Meaning::Variable(definition) | Meaning::Function(definition)) = &self.library.symbols[next].meaning {
                for &used in &definition.uses {
                    found |= used == symbol;
                    if seen.insert(used) {
                        open.push(used);
                    }
                }
            }
        }
        self.recursive.insert(symbol, found);
        found
    }
}

/// Which ray variables a graph reads, as bits. Free variables count as bit 63.
fn reads(graph: &Graph) -> u64 {
    (0..graph.len()).fold(0, |mask, id| match graph.node(id as Id) {
        Node::Channel(index) => mask | 1 << index.min(&62),
        Node::Free(_) => mask | 1 << 63,
        _ => mask,
    })
}
