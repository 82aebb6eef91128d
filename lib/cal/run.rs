//! How a compiled expression is evaluated: a list of operations on numbered registers, jumping forward only.

use super::functions::{Binary, Ternary, Unary, divide, nearest, power};
use super::{Context, Failed};

/// A number of a register.
pub(super) type Register = u16;

/// One step. `to` is the register that receives the result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Op {
    Constant {
        to: Register,
        value: f64,
    },
    Channel {
        to: Register,
        index: u16,
    },
    Free {
        to: Register,
        index: u16,
    },
    Argument {
        to: Register,
        a: Register,
    },
    Copy {
        to: Register,
        a: Register,
    },
    Add {
        to: Register,
        a: Register,
        b: Register,
    },
    Subtract {
        to: Register,
        a: Register,
        b: Register,
    },
    Multiply {
        to: Register,
        a: Register,
        b: Register,
    },
    Divide {
        to: Register,
        a: Register,
        b: Register,
    },
    AddConstant {
        to: Register,
        a: Register,
        c: f64,
    },
    MultiplyConstant {
        to: Register,
        a: Register,
        c: f64,
    },
    DivideConstant {
        to: Register,
        a: Register,
        c: f64,
    },
    ConstantSubtract {
        to: Register,
        c: f64,
        b: Register,
    },
    ConstantDivide {
        to: Register,
        c: f64,
        b: Register,
    },
    PowerConstant {
        to: Register,
        a: Register,
        c: f64,
    },
    Unary {
        f: Unary,
        to: Register,
        a: Register,
    },
    Binary {
        f: Binary,
        to: Register,
        a: Register,
        b: Register,
    },
    Ternary {
        f: Ternary,
        to: Register,
        a: [Register; 3],
    },
    /// One of two values that exist already.
    Choose {
        to: Register,
        condition: Register,
        a: Register,
        b: Register,
    },
    /// Go on if the condition is above zero, to `otherwise` if not; without a condition, the result fails and `end` is next.
    Branch {
        to: Register,
        condition: Register,
        otherwise: u32,
        end: u32,
    },
    /// Go to the place `index` says in the table: its length, the end, then a place for each choice.
    Switch {
        to: Register,
        index: Register,
        table: u32,
    },
    Jump {
        target: u32,
    },
    /// The result of a routine for the arguments in `list`: their number, then their registers.
    Call {
        to: Register,
        routine: u16,
        list: u32,
    },
}

/// The operations of an expression, or of a function that calls itself.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Routine {
    pub code: Box<[Op]>,
    pub tables: Box<[u32]>,
    pub lists: Box<[Register]>,
    /// How many registers it needs. The first hold its parameters.
    pub registers: usize,
    /// The registers that hold the results at the end.
    pub results: Box<[Register]>,
}

/// How deep functions may call themselves.
const MAX_DEPTH: usize = 1000;
/// How many calls an evaluation may make.
const MAX_CALLS: usize = 1_000_000;
/// How many registers there are for all calls in progress.
const STACK: usize = 16_384;

/// The most registers a routine may have.
pub(super) const MAX_REGISTERS: usize = STACK / 2;

/// Evaluates the first of `routines` and hands its results to `take`, in order.
#[inline]
pub(super) fn run(routines: &[Routine], arguments: &[f64], parameters: &[f64], context: &Context, take: impl FnMut(f64)) {
    let machine = Machine { routines, arguments, context };
    if routines.len() > 1 || routines[0].registers > 256 {
        machine.start::<STACK>(parameters, take);
    } else if routines[0].registers > 16 {
        machine.start::<256>(parameters, take);
    } else {
        machine.start::<16>(parameters, take);
    }
}

struct Machine<'a> {
    routines: &'a [Routine],
    arguments: &'a [f64],
    context: &'a Context<'a>,
}

impl Machine<'_> {
    // Kept apart for each size, so that small programs do not pay for a large stack.
    #[inline(never)]
    fn start<const REGISTERS: usize>(&self, parameters: &[f64], mut take: impl FnMut(f64)) {
        let mut stack = [0.0; REGISTERS];
        stack[..parameters.len()].copy_from_slice(parameters);
        let main = &self.routines[0];
        self.routine(main, &mut stack, 0, &mut 0);
        main.results.iter().for_each(|&r| take(stack[usize::from(r)]));
    }

    fn routine(&self, routine: &Routine, stack: &mut [f64], depth: usize, calls: &mut usize) {
        let (frame, beyond) = stack.split_at_mut(routine.registers);
        let mut next = 0;
        macro_rules! reg {
            ($r:expr) => {
                frame[usize::from($r)]
            };
        }
        while let Some(&op) = routine.code.get(next) {
            next += 1;
            match op {
                Op::Constant { to, value } => reg!(to) = value,
                Op::Channel { to, index } => reg!(to) = value_or_nan(self.context.channels, index),
                Op::Free { to, index } => reg!(to) = value_or_nan(self.context.free, index),
                Op::Argument { to, a } => reg!(to) = argument(self.arguments, reg!(a)),
                Op::Copy { to, a } => reg!(to) = reg!(a),
                Op::Add { to, a, b } => reg!(to) = reg!(a) + reg!(b),
                Op::Subtract { to, a, b } => reg!(to) = reg!(a) - reg!(b),
                Op::Multiply { to, a, b } => reg!(to) = reg!(a) * reg!(b),
                Op::Divide { to, a, b } => reg!(to) = divide(reg!(a), reg!(b)),
                Op::AddConstant { to, a, c } => reg!(to) = reg!(a) + c,
                Op::MultiplyConstant { to, a, c } => reg!(to) = reg!(a) * c,
                Op::DivideConstant { to, a, c } => reg!(to) = reg!(a) / c,
                Op::ConstantSubtract { to, c, b } => reg!(to) = c - reg!(b),
                Op::ConstantDivide { to, c, b } => reg!(to) = divide(c, reg!(b)),
                Op::PowerConstant { to, a, c } => reg!(to) = power(reg!(a), c),
                Op::Unary { f, to, a } => reg!(to) = f.apply(reg!(a)),
                Op::Binary { f, to, a, b } => reg!(to) = f.apply(reg!(a), reg!(b)),
                Op::Ternary { f, to, a } => reg!(to) = f.apply(a.map(|r| reg!(r))),
                Op::Choose { to, condition, a, b } => {
                    let (condition, a, b) = (reg!(condition), reg!(a), reg!(b));
                    reg!(to) = if condition.is_nan() { f64::NAN } else { [b, a][usize::from(condition > 0.0)] };
                }
                Op::Branch { to, condition, otherwise, end } => {
                    let condition = reg!(condition);
                    if condition > 0.0 {
                        continue;
                    } else if condition <= 0.0 {
                        next = otherwise as usize;
                    } else {
                        reg!(to) = f64::NAN;
                        next = end as usize;
                    }
                }
                Op::Switch { to, index, table } => {
                    let table = &routine.tables[table as usize..];
                    match choice(reg!(index), table[0]) {
                        Ok(place) => next = table[1 + place] as usize,
                        Err(value) => {
                            reg!(to) = value;
                            next = table[1] as usize;
                        }
                    }
                }
                Op::Jump { target } => next = target as usize,
                Op::Call { to, routine: callee, list } => {
                    let arguments = &routine.lists[list as usize..];
                    reg!(to) = self.call(callee, &arguments[1..=usize::from(arguments[0])], frame, beyond, depth, calls);
                }
            }
        }
    }

    /// The result of a routine for the arguments in these registers of the caller.
    #[inline(never)]
    fn call(&self, callee: u16, arguments: &[Register], frame: &[f64], beyond: &mut [f64], depth: usize, calls: &mut usize) -> f64 {
        let callee = &self.routines[usize::from(callee)];
        *calls += 1;
        if depth >= MAX_DEPTH || *calls > MAX_CALLS || beyond.len() < callee.registers {
            return f64::NAN;
        }
        for (to, &r) in beyond.iter_mut().zip(arguments) {
            *to = frame[usize::from(r)];
        }
        self.routine(callee, beyond, depth + 1, calls);
        beyond[usize::from(callee.results[0])]
    }
}

fn value_or_nan(values: &[f64], index: u16) -> f64 {
    values.get(usize::from(index)).copied().unwrap_or(f64::NAN)
}

/// The choice that a rounded index picks among `count`, from 1; or what the selection gives instead.
#[inline(never)]
fn choice(index: f64, count: u32) -> Result<usize, f64> {
    match nearest(index) {
        _ if index.is_nan() => Err(f64::NAN),
        0 => Err(f64::from(count)),
        n if n >= 1 && n <= i64::from(count) => Ok(n as usize),
        _ => Err(f64::NAN),
    }
}

/// `arg(n)`: the n-th argument, their number for n = 0 or less, NaN beyond.
#[inline(never)]
pub(super) fn argument(arguments: &[f64], n: f64) -> f64 {
    match nearest(n) {
        _ if n.is_nan() => f64::NAN,
        ..=0 => arguments.len() as f64,
        n => arguments.get(n as usize - 1).copied().unwrap_or(f64::NAN),
    }
}

/// A compiled set of expressions. It never changes, and any number of threads may evaluate it.
#[derive(Debug, PartialEq)]
pub struct Program {
    /// The expressions, then the functions that call themselves.
    pub(super) routines: Box<[Routine]>,
    /// The modifier's real arguments, if some are chosen during evaluation.
    pub(super) arguments: Box<[f64]>,
    /// How many parameters it takes.
    pub(super) parameters: usize,
    /// Bit i: it reads ray variable `$(i+1)`.
    pub(super) channels: u64,
    /// The values, if all are constant.
    pub(super) constants: Option<Box<[f64]>>,
}

impl Program {
    /// The value of the first expression.
    ///
    /// # Errors
    /// It has none here: a division by zero, an argument outside a function's domain, too deep a recursion.
    #[inline]
    pub fn eval(&self, context: &Context) -> Result<f64, Failed> {
        let mut first = None;
        self.results(context, &[], |value| _ = first.get_or_insert(value));
        first.filter(|v| v.is_finite()).ok_or(Failed)
    }

    /// The values of the first `N` expressions.
    ///
    /// # Errors
    /// As [`Program::eval`], for any of them; also when there are fewer.
    #[inline]
    pub fn eval_all<const N: usize>(&self, context: &Context) -> Result<[f64; N], Failed> {
        self.call(context, &[])
    }

    /// The values of the first `N` functions of a program made by `Library::functions`, for these parameters.
    ///
    /// # Errors
    /// As [`Program::eval_all`]; also when the number of parameters is not the one it was compiled for.
    #[inline]
    pub fn call<const N: usize>(&self, context: &Context, parameters: &[f64]) -> Result<[f64; N], Failed> {
        let mut values = [0.0; N];
        self.eval_into(context, parameters, &mut values)?;
        Ok(values)
    }

    /// As [`Program::call`], for as many expressions as there is room in `values`.
    ///
    /// # Errors
    /// As [`Program::call`].
    #[inline]
    pub fn eval_into(&self, context: &Context, parameters: &[f64], values: &mut [f64]) -> Result<(), Failed> {
        if parameters.len() != self.parameters {
            return Err(Failed);
        }
        let mut count = 0;
        self.results(context, parameters, |value| {
            if let Some(place) = values.get_mut(count) {
                *place = value;
            }
            count += 1;
        });
        if count >= values.len() && values.iter().all(|v| v.is_finite()) { Ok(()) } else { Err(Failed) }
    }

    /// The value, if it is the same for every ray (of the first expression).
    pub fn constant(&self) -> Option<f64> {
        self.constants.as_ref().and_then(|all| all.first().copied())
    }

    /// Whether it reads only these ray variables (numbers from 0, in the order of [`super::Ray`]).
    pub fn reads_only(&self, channels: std::ops::Range<usize>) -> bool {
        self.channels >> channels.end.min(63) == 0 && self.channels & ((1 << channels.start.min(63)) - 1) == 0
    }

    #[inline]
    fn results(&self, context: &Context, parameters: &[f64], mut take: impl FnMut(f64)) {
        match &self.constants {
            Some(constants) => constants.iter().for_each(|&value| take(value)),
            None => run(&self.routines, &self.arguments, parameters, context, take),
        }
    }
}
