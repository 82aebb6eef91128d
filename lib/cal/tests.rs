use super::*;
use crate::resolve::Files;

fn value(expression: &str) -> f64 {
    let mut library = Library::new();
    let program = library.compile(FileId::GLOBAL, &[(expression, None)], &[]).unwrap_or_else(|e| panic!("{expression}: {e}"));
    program.eval(&ray().context()).unwrap_or(f64::NAN)
}

/// The ray `1 2 3 .6 0 .8` toward a source of 360°.
fn ray() -> Ray {
    let direction = Vec3::new(0.6, 0.0, 0.8);
    Ray::new(direction, -direction, Vec3::new(1.0, 2.0, 3.0))
}

fn error(text: &str) -> String {
    let mut library = Library::new();
    let files = Files::of([("f.cal", text.as_bytes())]);
    match library.load("f.cal", &files).and_then(|file| library.compile(file, &[("v", None)], &[])) {
        Ok(program) => panic!("{text}: {:?}", program.eval(&ray().context())),
        Err(error) => error.to_string(),
    }
}

/// The value of `expression` in a file of this text.
fn in_file(text: &str, expression: &str, arguments: &[f64]) -> f64 {
    let mut library = Library::new();
    let file = library.load("f.cal", &Files::of([("f.cal", text.as_bytes())])).unwrap();
    let program = library.compile(file, &[(expression, None)], arguments).unwrap();
    program.eval(&ray().context()).unwrap_or(f64::NAN)
}

/// `rcalc -n -e '$1=..'` (Radiance 6.0a), to the 9 digits it prints.
#[test]
fn operators_and_functions_are_rcalc_s() {
    for (expression, expected) in [
        ("-2^2", 4.0),
        ("2^3^2", 512.0),
        ("2*-3", -6.0),
        ("3 -- 3", 6.0),
        ("2^-1", 0.5),
        ("0^0", 1.0),
        ("1-2-3", -4.0),
        ("8/4/2", 1.0),
        ("+3", 3.0),
        ("2*+3", 6.0),
        ("-(2)^2", 4.0),
        ("-sqrt(4)^2", 4.0),
        ("{c}4{ {n} }", 4.0),
        ("1.e2", 100.0),
        (".5", 0.5),
        ("1.5e-2", 0.015),
        ("select(0,1,2,3)", 3.0),
        ("select(-.3,1,2)", 2.0),
        ("select(2.4,1,2,3)", 2.0),
        ("min(3,1,2)", 1.0),
        ("max(1)", 1.0),
        ("if(0,1,2)", 2.0),
        ("if(1,2)", 2.0),
        ("sin(1,2)", 0.841470985),
        ("atan2(1,2)", 0.463647609),
        ("floor(-1.5)", -2.0),
        ("ceil(1.2)", 2.0),
        ("tan(1)", 1.55740772),
        ("1/(1+exp(1000))", 0.0),
        ("log10(1000)", 3.0),
    ] {
        assert!((value(expression) - expected).abs() <= 1e-8 * expected.abs(), "{expression}: {}", value(expression));
    }
}

/// A brightfunc of the expression with the arguments 11 22 on a glow source of 360°, `echo 1 2 3 .6 0 .8 | rtrace -h -faa` (Radiance 6.0a).
#[test]
fn the_initialization_file_is_rtrace_s() {
    let recorded = [
        ("turbulence(.3,.4,.5,.1)", 0.2660514),
        ("turbulencex(.3,.4,.5,.1)", -0.6129574),
        ("turbulencez(.3,.4,.5,.01)", 2.881732),
        ("nrand(7)", 1.808646),
        ("unif2norm(.2)", -0.8414567),
        ("unif2norm(.9)", 1.281729),
        ("U", -3.333333),
        ("V", 1.666667),
        ("hermite(1,2,3,4,.3)", 1.405),
        ("bezier(1,2,3,4.5,.3)", 1.9135),
        ("bspline(1,2,3,4.5,.3)", 2.30225),
        ("bspline(1,-2,3,7,.6)", 1.049333),
        ("dot(P,D)", 3.0),
        ("cross(2,P,D)", 1.0),
        ("tri(7.3,2)", 0.7),
        ("mod(-7.3,2)", 0.7),
        ("fade(1,2,3)", 1.9),
        ("fade(1,2,17)", 2.0),
        ("grey(1,2,3)", 1.799737),
        ("clipgrey(.1,.2,.3)", 0.1799737),
        ("xor(1,1)", -1.0),
        ("xor(-1,2)", 2.0),
        ("inside(1,2,3)", 1.0),
        ("linterp(.2,3,4)", 3.2),
        ("sgn(-4)", -1.0),
        ("frac(-1.3)", 0.7),
        ("bound(1,5,3)", 3.0),
        ("Acos(1.5)", 0.0),
        ("Exp(-101)", 0.0),
        ("Sqrt(-1)", 0.0),
        ("Atan2(0,0)", 0.0),
        ("noise3d(2,.3,.4,.5)", -0.987183),
        ("noise3b(.3,.4,.5)", -0.987183),
        ("noise3z(.3,.4,.5)", -0.6883026),
        ("DEGREE", 0.01745329),
        ("FTINY", 1e-07),
        ("or(-1,-2)", -2.0),
        ("not(0)", 1.0),
        ("blue(1,2,-3)", 0.0),
        ("clip_g(1,2,3)", 1.0),
        ("abs(-3)", 3.0),
        ("S", 1.0),
        ("Px", 1.0),
        ("Rdot", 1.0),
        ("Nx", -0.6),
        ("Jy", 1.0),
        ("Lu", 0.0),
        ("arg(0)", 2.0),
        ("arg(-1)", 2.0),
        ("arg(1.6)", 22.0),
        ("A1", 11.0),
        ("P(0)", 3.0),
        ("1/Py", 0.5),
        ("if(Dx,1,noexist)", 1.0),
        ("if(Dx, 1)", 1.0),
        ("exp(-Dx*2000)", 0.0),
        ("1/(1+exp(3000*Dx))", 0.0),
        ("source_theta(180)", 36.8699),
    ];
    for (expression, expected) in recorded {
        let found = in_file("", expression, &[11.0, 22.0]);
        assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{expression}: {found}, not {expected}");
    }
}

/// The same for directions -.48 -.36 .8 and .48 .36 -.8.
#[test]
fn luminaire_angles_are_rtrace_s() {
    let mut library = Library::new();
    for (expression, up, down) in [
        ("source_theta(180)", 36.86990, 143.1301),
        ("source_phi(360)", 36.86990, 216.8699),
        ("source_phi(180)", 36.86990, 143.1301),
        ("source_phi(90)", 36.86990, 36.86990),
    ] {
        let program = library.compile(FileId::GLOBAL, &[(expression, None)], &[]).unwrap();
        for (sign, expected) in [(-1.0, up), (1.0, down)] {
            let d = Vec3::new(sign * 0.48, sign * 0.36, sign * -0.8);
            let found = program.eval(&Ray::new(d, -d, Vec3::ZERO).context()).unwrap();
            assert!((found - expected).abs() < 1e-4, "{expression}: {found}");
        }
    }
}

/// With the arguments 2 .3 .4 .5 and the ray `1 2 3 .6 0 .8`; the source is 1e10 away.
#[test]
fn luminaire_corrections_are_rtrace_s() {
    for (shape, expected) in [(0, 14.0), (1, 14.0), (2, 64.81481), (4, 108.9082)] {
        let found = in_file("", &format!("source_corr(7,{shape})"), &[2.0, 0.3, 0.4, 0.5]);
        assert!((found / expected - 1.0).abs() < 1e-6, "{shape}: {found}");
    }
}

/// A file with these definitions, `rtrace` as above: a name means what is known of it where it is read.
#[test]
fn names_belong_to_their_file() {
    let text = "a = sq(2); sq(x) = 100; b = sq(2); c = zz(1); zz(x)=5; d = if(-1, undef, 3); e = if(Dx-2, undef2, 3);
        f = fac(5); fac(n)=if(n-.5,n*fac(n-1),1); g = sq`(3); h = `sq(3); PI:3; j=PI; k = PI`; min=4;
        l(g,x)=g(x); m = l(sin, .5); n(x)=x; n=7; o(x,y)=x; sgn(x) = 10*sgn(x);";
    for (expression, expected) in [
        ("a", 4.0),
        ("b", 100.0),
        ("c", 5.0),
        ("d", 3.0),
        ("e", 3.0),
        ("f", 120.0),
        ("g", 9.0),
        ("h", 100.0),
        ("sq(3)", 100.0),
        ("zz(1)", 5.0),
        ("PI", 3.0),
        ("j", 3.0),
        ("k", std::f64::consts::PI),
        ("min", 4.0),
        ("m", 0.4794255386),
        ("n", 7.0),
        ("o(1)", 1.0),
        ("o(1,2,3)", 1.0),
        ("l(P,1)", 1.0),
        ("sgn(-3)", -10.0),
    ] {
        let found = in_file(text, expression, &[]);
        assert!((found - expected).abs() < 1e-9, "{expression}: {found}");
    }
}

#[test]
fn files_do_not_see_each_other() {
    let files = Files::of([("one.cal", b"v = 1; w = 10;" as &[u8]), ("dir/two.cal", b"v = 2; x = w`one;")]);
    let mut library = Library::new();
    let one = library.load("one.cal", &files).unwrap();
    let two = library.load("dir/two.cal", &files).unwrap();
    assert_eq!(library.load("one.cal", &Files::default()).unwrap(), one, "a file is read once");
    let mut value = |file, e| library.compile(file, &[(e, None)], &[]).map(|p| p.eval(&Context::default()).unwrap());
    assert_eq!((value(one, "v").unwrap(), value(two, "v").unwrap(), value(two, "x").unwrap()), (1.0, 2.0, 10.0));
    assert!(value(two, "w").is_err() && value(FileId::GLOBAL, "v").is_err());
}

#[test]
fn errors_name_the_place() {
    for (text, expected) in [
        ("v = 1;\nw = 2 +;", "f.cal:2:8: error: unexpected character"),
        ("v = --3;", "f.cal:1:6: error: unexpected character"),
        ("v = 3*(2;", "f.cal:1:9: error: ')' expected"),
        ("v = 1e;", "f.cal:1:7: error: missing exponent"),
        ("v = .;", "f.cal:1:5: error: badly formed number"),
        ("v = 1 2;", "f.cal:1:7: error: unexpected character; ';' expected"),
        ("v 3;", "f.cal:1:3: error: '=' or ':' expected"),
        ("{ v = 3;", "f.cal:1:1: error: comment without its closing '}'"),
        ("v = 3 + nope;", "f.cal:1:9: error: undefined variable 'nope'"),
        ("v = nope(3);", "f.cal:1:5: error: undefined function 'nope'"),
        ("v = 1/0;", "this has no value"),
        ("v : Dx;", "f.cal:1:5: error: 'v' is defined with ':' as a constant but depends on the ray"),
        ("v = w; w = v + 1;", "defined by itself"),
        ("v = A3;", "real argument 3 is missing; there are 0"),
        ("f(x,y) = x*y; v = f(2);", "f.cal:1:12: error: the call gives this function too few arguments"),
        ("v = select(9,1,2);", "there are 2"),
        ("v = sin;", "'sin'"),
        ("f(x) = x; v = f;", "'f' is a function; give it arguments"),
    ] {
        let error = error(text);
        assert!(error.contains(expected), "{text}: {error}");
    }
}

#[test]
fn an_expression_of_a_scene_is_pointed_at_in_the_scene() {
    let source = Source::new("room.rad", "void brightfunc p 2 Px*nope . 0 0");
    let span = Span::new(&source, 20, 27);
    let mut library = Library::new();
    let error = library.compile(FileId::GLOBAL, &[("Px*nope", Some(&span))], &[]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "room.rad:1:24: error: undefined variable 'nope'\n  void brightfunc p 2 Px*nope . 0 0\n                         ^^^^"
    );
}

#[test]
fn failures_are_failures() {
    for expression in
        ["1/(Dx-.6)", "sqrt(-Dx)", "log(Dx-.6)", "1/(Dx-.6)+sin(1)", "if(1/(Dx-.6), 1, 2)", "P(Px+3)", "arg(Dx+3)", "NxP", "10^(Dx*1000)"]
    {
        assert!(value(expression).is_nan(), "{expression}: {}", value(expression));
    }
    // What is not needed may fail.
    assert_eq!(value("if(Dx, 2, 1/(Dx-.6))"), 2.0);
    assert_eq!(value("select(1.2+Dx, 1, 2, sqrt(-Dx))"), 2.0);
}

#[test]
fn recursion_ends_or_fails() {
    let sum = "s(n) = if(n-.5, n + s(n-1), 0); t(f, n) = if(n-.5, f(n) + t(f, n-1), 0);
        even(n) = if(n-.5, odd(n-1), 1); odd(n) = if(n-.5, even(n-1), 0); forever(n) = forever(n+1) + Dx; same(n) = 1 + same(n); ";
    assert_eq!(in_file(sum, "s(10)", &[]), 55.0);
    assert_eq!(in_file(sum, "s(800)", &[]), 320400.0);
    assert_eq!(in_file(sum, "s(10*Dx)", &[]), 21.0);
    assert_eq!(in_file(sum, "t(sq, 10*Dx)", &[]), 91.0);
    assert_eq!(in_file(sum, "t(s, 3)", &[]), 10.0);
    assert_eq!(in_file(sum, "even(10*Dx)", &[]), 1.0);
    assert_eq!(in_file(sum, "odd(10*Dx) + even(3)", &[]), 0.0);
    assert!(in_file(sum, "forever(1)", &[]).is_nan());
    assert!(in_file(sum, "forever(Dx)", &[]).is_nan());
    assert!(in_file(sum, "same(Dx)", &[]).is_nan());
    assert_eq!(in_file(sum, "if(Dx, 3, forever(Dx))", &[]), 3.0);
}

#[test]
fn shared_parts_are_evaluated_once_however_often_they_are_named() {
    let mut text = String::from("v0 = Dx + 1; ");
    (1..200).for_each(|i| text += &format!("v{i} = (v{0} + v{0})/2; ", i - 1));
    assert_eq!(in_file(&text, "v199", &[]), 1.6);
}

#[test]
fn deep_and_long_expressions_are_no_danger() {
    let nested = format!("{}1{}", "(".repeat(200), ")".repeat(200));
    assert_eq!(value(&nested), 1.0);
    let mut library = Library::new();
    for depth in [300, 100_000] {
        for (open, close) in [("(", ")"), ("if(Dx,", ",1)"), ("2^", ""), ("-(", ")"), ("f(", "")] {
            let text = format!("{}1{}", open.repeat(depth), close.repeat(depth));
            assert!(library.compile(FileId::GLOBAL, &[(&text, None)], &[]).is_err());
        }
    }
    let ifs = format!("{}1{}", "if(Dx-Px,0,".repeat(200), ")".repeat(200));
    assert_eq!(value(&ifs), 1.0);
    let long = format!("0{}", "+Dx*Px".repeat(5000));
    assert!((value(&long) - 3000.0).abs() < 1e-6);
    let many = format!("select(Px+2000,{}7)", "Dx,".repeat(2000));
    assert_eq!(value(&many), 7.0);
    // Definitions that use each other, each a level deeper.
    let mut text = String::from("f0(x) = x + Dx; ");
    (1..2000).for_each(|i| text += &format!("f{i}(x) = if(x, f{}(x+1), 2); ", i - 1));
    let files = Files::of([("f.cal", text.as_bytes())]);
    let file = library.load("f.cal", &files).unwrap();
    assert!(library.compile(file, &[("f100(1)", None)], &[]).is_ok());
    assert!(library.compile(file, &[("f1999(Px)", None)], &[]).unwrap_err().to_string().contains("too deeply"));
    // Branches within each other, by way of variables that are known already.
    let mut text = String::from("v0 = Dx; ");
    (1..=3000).for_each(|i| text += &format!("v{i} = if(Dx-1, v{}, {i}); ", i - 1));
    let file = library.load("v.cal", &Files::of([("v.cal", text.as_bytes())])).unwrap();
    let by_way: String = (1..15).map(|i| format!("if(Dx-9,(1/0)*v{},0)+", 200 * i)).collect();
    assert!(library.compile(file, &[(&format!("{by_way}v900"), None)], &[]).is_ok());
    assert!(library.compile(file, &[(&format!("{by_way}v3000"), None)], &[]).is_err());
    // Definitions that double each other.
    let mut text = String::from("g0(x) = sin(x + Dx); ");
    (1..60).for_each(|i| text += &format!("g{i}(x) = g{0}(x) + g{0}(x+1); ", i - 1));
    library.load("g.cal", &Files::of([("g.cal", text.as_bytes())])).unwrap();
    let file = library.load("g.cal", &Files::default()).unwrap();
    assert!(library.compile(file, &[("g50(1)", None)], &[]).is_err());
}

#[test]
fn functions_can_be_applied_to_parameters() {
    let mut library = Library::new();
    let names: [(Written, &[usize]); 3] = [(("red", None), &[0, 1, 2]), (("noop", None), &[1]), (("grey", None), &[0, 1, 2])];
    let program = library.functions(FileId::GLOBAL, &names, 3, &[]).unwrap();
    let [r, g, b] = program.call(&Context::default(), &[-1.0, 2.0, 3.0]).unwrap();
    assert_eq!((r, g), (0.0, 2.0));
    assert!((b - (-0.265074126 + 2.0 * 0.670114631 + 3.0 * 0.064811243)).abs() < 1e-15);
    assert_eq!(library.parameters("red", FileId::GLOBAL), Some(3));
    assert_eq!(library.parameters("noop", FileId::GLOBAL), Some(1));
    assert_eq!(library.parameters("Dx", FileId::GLOBAL), None);
}

#[test]
fn every_shipped_file_is_in_the_language() {
    for (name, _) in shipped::SHIPPED {
        Library::new().load(name, &Files::default()).unwrap();
    }
}

proptest::proptest! {
    #[test]
    fn no_text_panics(text in ".{0,60}", words in proptest::collection::vec(proptest::sample::select(WORDS), 0..40)) {
        for text in [text, words.concat()] {
            let mut library = Library::new();
            let _ = library.define(Source::new("f.cal", text.clone()), FileId::GLOBAL);
            if let Ok(program) = library.compile(FileId::GLOBAL, &[(&text, None)], &[1.0, 2.0]) {
                let _ = program.eval(&ray().context());
            }
            if let Ok(program) = library.compile(FileId::GLOBAL, &[("a", None)], &[1.0, 2.0]) {
                let _ = program.eval(&ray().context());
            }
        }
    }
}

const WORDS: &[&str] = &[
    "a",
    "b",
    "f",
    "x",
    "y",
    "=",
    ":",
    ";",
    "(",
    ")",
    ",",
    "+",
    "-",
    "*",
    "/",
    "^",
    "1",
    "2.5",
    "0",
    "Dx",
    "Px",
    "$3",
    "if(",
    "select(",
    "arg(",
    "f(x)=",
    "f(x,y)=",
    "f(x-1)",
    "a=",
    "sin(",
    "max(",
    "P",
    "dot(",
    "{",
    "}",
    " ",
    "`",
    "noise3(1,Dx,2)",
    "if(x,f(x-.1),Px)",
    ";f(x)=",
];
