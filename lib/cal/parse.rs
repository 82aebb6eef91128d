//! What a `.cal` text says: its statements as trees, names not yet looked up.
//!
//! ```text
//! file      := { statement ; }
//! statement := name = expr | name : expr | name(p,..) = expr | name(p,..) : expr | $n = expr
//! expr      := term { (+|-) term }
//! term      := power { (*|/) power }
//! power     := factor [ ^ power ]
//! factor    := [-|+] atom
//! atom      := ( expr ) | number | name | name(expr,..) | $n
//! ```

use nom::branch::alt;
use nom::bytes::complete::{take_while, take_while1};
use nom::character::complete::{char, digit1, one_of, satisfy};
use nom::combinator::{opt, recognize};
use nom::error::{ErrorKind, ParseError};
use nom::multi::separated_list1;
use nom::sequence::pair;
use nom::{Err, IResult, Parser};

/// What is wrong with the text and how many bytes were left when that was noticed.
#[derive(Debug, PartialEq)]
pub(super) struct Fault {
    pub left: usize,
    pub message: &'static str,
}

/// `name = body`, `name(parameters) = body`, or `$n = body` (named `$n`).
#[derive(Debug)]
pub(super) struct Statement {
    pub name: String,
    pub parameters: Option<Vec<String>>,
    /// Defined with `:` instead of `=`.
    pub constant: bool,
    pub body: Node,
}

/// An expression and where it begins: the number of bytes from there to the end of the text.
#[derive(Debug)]
pub(super) struct Node {
    pub expression: Expression,
    pub left: usize,
}

#[derive(Debug)]
pub(super) enum Expression {
    Number(f64),
    Channel(u32),
    Name(Name),
    Call(Name, Vec<Node>),
    Negate(Box<Node>),
    /// The first operand, then operands to add or (`true`) to subtract, from left to right.
    Sum(Box<Node>, Vec<(bool, Node)>),
    /// The first operand, then operands to multiply or (`true`) divide by, from left to right.
    Product(Box<Node>, Vec<(bool, Node)>),
    Power(Box<Node>, Box<Node>),
}

/// A name as written, and what it was found to mean.
#[derive(Debug)]
pub(super) struct Name {
    pub text: String,
    pub target: Target,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Target {
    Unbound,
    Parameter(usize),
    Symbol(usize),
}

/// How deep parentheses and calls may nest. What people write stays below 60.
const MAX_NESTING: usize = 250;

/// The statements of a function file.
pub(super) fn statements(text: &str) -> Result<Vec<Statement>, Fault> {
    let mut found = Vec::new();
    let finish = |e: Err<Fault>| match e {
        Err::Error(fault) | Err::Failure(fault) => fault,
        Err::Incomplete(_) => Fault { left: 0, message: "unexpected end" },
    };
    let (mut rest, ()) = blank(text).map_err(finish)?;
    while !rest.is_empty() {
        if let Some(after) = rest.strip_prefix(';') {
            (rest, ()) = blank(after).map_err(finish)?;
            continue;
        }
        let (after, statement) = statement(rest).map_err(finish)?;
        if !after.is_empty() && !after.starts_with(';') {
            return Err(Fault { left: after.len(), message: "unexpected character; ';' expected" });
        }
        found.push(statement);
        rest = after;
    }
    Ok(found)
}

/// A single expression that fills the text.
pub(super) fn expression(text: &str) -> Result<Node, Fault> {
    let parsed = blank(text).and_then(|(rest, ())| sum(rest, 0));
    match parsed {
        Ok(("", node)) => Ok(node),
        Ok((rest, _)) => Err(Fault { left: rest.len(), message: "unexpected character after the expression" }),
        Err(Err::Error(fault) | Err::Failure(fault)) => Err(fault),
        Err(Err::Incomplete(_)) => Err(Fault { left: 0, message: "unexpected end" }),
    }
}

type Parsed<'a, T> = IResult<&'a str, T, Fault>;

impl ParseError<&str> for Fault {
    fn from_error_kind(input: &str, _: ErrorKind) -> Self {
        let message = if input.is_empty() { "unexpected end" } else { "unexpected character" };
        Fault { left: input.len(), message }
    }

    fn append(_: &str, _: ErrorKind, other: Self) -> Self {
        other
    }
}

fn failure<T>(left: usize, message: &'static str) -> Parsed<'static, T> {
    Err(Err::Failure(Fault { left, message }))
}

/// White space and comments `{ .. }`, which nest.
fn blank(mut rest: &str) -> Parsed<'_, ()> {
    loop {
        rest = rest.trim_start_matches(|c: char| c.is_ascii_whitespace() || c == '\x0b');
        if !rest.starts_with('{') {
            return Ok((rest, ()));
        }
        let mut depth = 0usize;
        let end = rest.bytes().position(|b| {
            match b {
                b'{' => depth += 1,
                b'}' => depth -= 1,
                _ => (),
            }
            depth == 0
        });
        match end {
            Some(end) => rest = &rest[end + 1..],
            None => return Err(Err::Failure(Fault { left: rest.len(), message: "comment without its closing '}'" })),
        }
    }
}

/// `inner` and the blanks behind it.
fn lexeme<'a, T>(mut inner: impl Parser<&'a str, Output = T, Error = Fault>) -> impl FnMut(&'a str) -> Parsed<'a, T> {
    move |input| {
        let (rest, value) = inner.parse(input)?;
        let (rest, ()) = blank(rest)?;
        Ok((rest, value))
    }
}

/// A letter or a back quote, then letters, digits, `_`, `.` and back quotes.
fn name(input: &str) -> Parsed<'_, String> {
    let first = satisfy(|c| c.is_ascii_alphabetic() || c == '`');
    let further = take_while(|c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | '`'));
    lexeme(recognize(pair(first, further))).parse(input).map(|(rest, name)| (rest, name.to_string()))
}

fn channel(input: &str) -> Parsed<'_, u32> {
    let (rest, (_, digits)) = lexeme((char('$'), digit1)).parse(input)?;
    match digits.parse() {
        Ok(n @ 1..) => Ok((rest, n)),
        _ => failure(input.len(), "channels are numbered from 1"),
    }
}

fn statement(input: &str) -> Parsed<'_, Statement> {
    let (rest, name) = alt((name, |i| channel(i).map(|(rest, n)| (rest, format!("${n}"))))).parse(input)?;
    let list = (lexeme(char('(')), separated_list1(lexeme(char(',')), self::name), lexeme(char(')')));
    let (rest, parameters) = if rest.starts_with('(') && !name.starts_with('$') {
        let mut list = list;
        let (rest, (_, parameters, _)) = list.parse(rest)?;
        (rest, Some(parameters))
    } else {
        (rest, None)
    };
    let Ok((rest, sign)) = lexeme(one_of("=:")).parse(rest) as Parsed<char> else {
        return failure(rest.len(), "'=' or ':' expected");
    };
    let (rest, body) = sum(rest, 0)?;
    Ok((rest, Statement { name, parameters, constant: sign == ':', body }))
}

fn sum(input: &str, depth: usize) -> Parsed<'_, Node> {
    chain(input, "+-", |i| product(i, depth), Expression::Sum)
}

fn product(input: &str, depth: usize) -> Parsed<'_, Node> {
    chain(input, "*/", |i| power(i, depth), Expression::Product)
}

/// Operands between operators; `true` marks those behind the second operator.
fn chain<'a>(
    input: &'a str,
    operators: &'static str,
    operand: impl Fn(&'a str) -> Parsed<'a, Node>,
    build: fn(Box<Node>, Vec<(bool, Node)>) -> Expression,
) -> Parsed<'a, Node> {
    let (mut rest, first) = operand(input)?;
    let mut further = Vec::new();
    while let Ok((after, operator)) = lexeme(one_of(operators)).parse(rest) as Parsed<char> {
        let (after, node) = operand(after)?;
        further.push((operators.ends_with(operator), node));
        rest = after;
    }
    let node = if further.is_empty() { first } else { Node { expression: build(Box::new(first), further), left: input.len() } };
    Ok((rest, node))
}

fn power(input: &str, depth: usize) -> Parsed<'_, Node> {
    let (rest, base) = factor(input, depth)?;
    match lexeme(char('^')).parse(rest) as Parsed<char> {
        Ok((rest, _)) => {
            if depth >= MAX_NESTING {
                return failure(rest.len(), "nested too deeply");
            }
            let (rest, exponent) = power(rest, depth + 1)?;
            let expression = Expression::Power(Box::new(base), Box::new(exponent));
            Ok((rest, Node { expression, left: input.len() }))
        }
        Err(_) => Ok((rest, base)),
    }
}

fn factor(input: &str, depth: usize) -> Parsed<'_, Node> {
    let (rest, sign) = opt(lexeme(one_of("+-"))).parse(input)?;
    let (rest, node) = atom(rest, depth)?;
    match sign {
        Some('-') => Ok((rest, Node { expression: Expression::Negate(Box::new(node)), left: input.len() })),
        _ => Ok((rest, node)),
    }
}

fn atom(input: &str, depth: usize) -> Parsed<'_, Node> {
    let left = input.len();
    if depth >= MAX_NESTING {
        return failure(left, "nested too deeply");
    }
    let first = input.chars().next().unwrap_or(' ');
    if first == '(' {
        let (rest, _) = lexeme(char('(')).parse(input)?;
        let (rest, node) = sum(rest, depth + 1)?;
        let (rest, ()) = close(rest)?;
        Ok((rest, node))
    } else if first == '$' {
        let (rest, n) = channel(input)?;
        Ok((rest, Node { expression: Expression::Channel(n), left }))
    } else if first == '.' || first.is_ascii_digit() {
        let (rest, value) = number(input)?;
        Ok((rest, Node { expression: Expression::Number(value), left }))
    } else {
        let (rest, text) = name(input)?;
        let name = Name { text, target: Target::Unbound };
        if !rest.starts_with('(') {
            return Ok((rest, Node { expression: Expression::Name(name), left }));
        }
        let (mut rest, _) = lexeme(char('(')).parse(rest)?;
        let mut arguments = Vec::new();
        loop {
            let (after, node) = sum(rest, depth + 1)?;
            arguments.push(node);
            match lexeme(char(',')).parse(after) as Parsed<char> {
                Ok((after, _)) => rest = after,
                Err(_) => {
                    rest = after;
                    break;
                }
            }
        }
        let (rest, ()) = close(rest)?;
        Ok((rest, Node { expression: Expression::Call(name, arguments), left }))
    }
}

fn close(input: &str) -> Parsed<'_, ()> {
    match lexeme(char(')')).parse(input) as Parsed<char> {
        Ok((rest, _)) => Ok((rest, ())),
        Err(Err::Failure(fault)) => Err(Err::Failure(fault)),
        Err(_) => Err(Err::Failure(Fault { left: input.len(), message: "')' expected" })),
    }
}

/// Digits with at most one point, then perhaps an exponent; no sign.
fn number(input: &str) -> Parsed<'_, f64> {
    let digits = |c: char| c.is_ascii_digit() || c == '.';
    let (rest, mantissa) = take_while1(digits).parse(input)?;
    if mantissa.bytes().filter(|&b| b == b'.').count() > 1 || mantissa == "." {
        return failure(input.len(), "badly formed number");
    }
    let rest = match rest.strip_prefix(['e', 'E']) {
        None => rest,
        Some(exponent) => match (opt(one_of("+-")), digit1).parse(exponent) as Parsed<(Option<char>, &str)> {
            Ok((rest, _)) => rest,
            Err(_) => return failure(exponent.len(), "missing exponent"),
        },
    };
    let text = &input[..input.len() - rest.len()];
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => {
            let (rest, ()) = blank(rest)?;
            Ok((rest, value))
        }
        _ => failure(input.len(), "number out of range"),
    }
}
