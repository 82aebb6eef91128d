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
pub(super) fn run(routines: &[Routine], arguments: &[f64], parameters: &[f64], context: &Context, take: impl FnMut(f64)) {
    let machine = Machine { routines, arguments, context };
    let main = &routines[0];
    if routines.len() > 1 || main.registers > 256 {
        machine.start(&mut [0.0; STACK], parameters, take);
    } else if main.registers > 32 {
        machine.start(&mut [0.0; 256], parameters, take);
    } else {
        machine.start(&mut [0.0; 32], parameters, take);
    }
}

struct Machine<'a> {
    routines: &'a [Routine],
    arguments: &'a [f64],
    context: &'a Context<'a>,
}

impl Machine<'_> {
    #[inline]
    fn start(&self, stack: &mut [f64], parameters: &[f64], mut take: impl FnMut(f64)) {
        stack[..parameters.len()].copy_from_slice(parameters);
        let main = &self.routines[0];
        self.routine(main, stack, 0, &mut 0);
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
                Op::Channel { to, index } => reg!(to) = self.context.channels.get(usize::from(index)).copied().unwrap_or(f64::NAN),
                Op::Free { to, index } => reg!(to) = self.context.free.get(usize::from(index)).copied().unwrap_or(f64::NAN),
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
                    let condition = reg!(condition);
                    reg!(to) = if condition > 0.0 {
                        reg!(a)
                    } else if condition <= 0.0 {
                        reg!(b)
                    } else {
                        f64::NAN
                    };
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
                    let (count, index) = (table[0] as usize, reg!(index));
                    match usize::try_from(nearest(index)) {
                        Ok(choice @ 1..) if choice <= count && !index.is_nan() => next = table[1 + choice] as usize,
                        Ok(0) if !index.is_nan() => {
                            reg!(to) = count as f64;
                            next = table[1] as usize;
                        }
                        _ => {
                            reg!(to) = f64::NAN;
                            next = table[1] as usize;
                        }
                    }
                }
                Op::Jump { target } => next = target as usize,
                Op::Call { to, routine: callee, list } => {
                    let callee = &self.routines[usize::from(callee)];
                    let list = &routine.lists[list as usize..];
                    *calls += 1;
                    if depth >= MAX_DEPTH || *calls > MAX_CALLS || beyond.len() < callee.registers {
                        reg!(to) = f64::NAN;
                        continue;
                    }
                    for (i, &r) in list[1..=usize::from(list[0])].iter().enumerate() {
                        beyond[i] = reg!(r);
                    }
                    self.routine(callee, beyond, depth + 1, calls);
                    reg!(to) = beyond[usize::from(callee.results[0])];
                }
            }
        }
    }
}

/// `arg(n)`: the n-th argument, their number for n = 0 or less, NaN beyond.
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
        if parameters.len() != self.parameters {
            return Err(Failed);
        }
        let (mut values, mut count) = ([0.0; N], 0);
        self.results(context, parameters, |value| {
            if count < N {
                values[count] = value;
            }
            count += 1;
        });
        if count >= N && values.iter().all(|v| v.is_finite()) { Ok(values) } else { Err(Failed) }
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
