//! Broken texts: scenes, function files, data files, views, Wavefront meshes; and what is no text at all.

use super::harness::{Case, Content};

/// Sees a scene.
pub const SEE: &str = "rtrace-rs -n 1 -vp 0 -5 0 -x 8 -y 8 --spp 1";

/// A scene that can be seen.
pub const SCENE: &str = "# One ball.\nvoid plastic m\n0\n0\n5 .5 .5 .5 0 0\nm sphere s\n0\n0\n4 0 0 0 1\n";

/// Who refuses a broken scene.
#[derive(Clone, Copy, PartialEq)]
enum By {
    /// Whoever reads it.
    All,
    /// `rparse --check` and the renderer.
    Check,
}

/// What no kind of input may be.
pub fn nonsense() -> Vec<(&'static str, Content)> {
    let noise: Vec<u8> = (0..4096u32).map(|i| (i.wrapping_mul(2654435761) >> 13) as u8).collect();
    vec![
        ("empty", Content::from("")),
        ("one zero byte", Content::from(&b"\0"[..])),
        ("zero bytes", Content::Bytes(vec![0; 4096])),
        ("noise", Content::Bytes(noise.clone())),
        ("noise after a signature", Content::Bytes([b"#?RADIANCE\n", &noise[..]].concat())),
        ("another kind of file", Content::from(&b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\x02\0\0\0"[..])),
        ("a line without an end", Content::Bytes(vec![b'x'; 100_000])),
    ]
}

/// What cannot be read.
pub fn unreadable() -> Vec<(&'static str, Option<Content>)> {
    vec![
        ("missing", None),
        ("a directory", Some(Content::Directory)),
        ("a link to itself", Some(Content::Link("bad"))),
        ("without an end", Some(Content::Link("/dev/zero"))),
    ]
}

pub fn scenes() -> Vec<Case> {
    use By::{All, Check};
    let m = "void plastic m 0 0 5 .5 .5 .5 0 0\n";
    let with = |text: &str| format!("{m}{text}\n");
    let rows: Vec<(&str, String, &str, By)> = vec![
        ("cut after the modifier", with("m"), "bad:2:1", All),
        ("cut after the type", with("m sphere"), "bad:2:", All),
        ("cut after the name", with("m sphere s"), "bad:2:", All),
        ("cut after a count", with("m sphere s 0 0"), "bad:2:", All),
        ("cut among the numbers", with("m sphere s 0 0 4 0 0"), "bad:2:", All),
        ("cut in a quoted name", with("m sphere 's"), "bad:2:", All),
        ("cut in an alias", with("m alias"), "bad:2:", All),
        ("no number where one stands", with("m sphere s 0 0 4 0 0 x 1"), "bad:2:", All),
        ("a number with a tail", with("m sphere s 0 0 4 0 0 1x 1"), "bad:2:", All),
        ("not a number", with("m sphere s 0 0 4 0 0 nan 1"), "bad:2:", All),
        ("infinite", with("m sphere s 0 0 4 0 inf 0 1"), "bad:2:", All),
        ("beyond all numbers", with("m sphere s 0 0 4 0 0 1e999 1"), "bad:2:", All),
        ("hexadecimal", with("m sphere s 0 0 4 0 0 0x10 1"), "bad:2:", All),
        ("decimal comma", with("m sphere s 0 0 4 0 0 1,5 1"), "bad:2:", All),
        ("a count that is no number", with("m sphere s zero 0 4 0 0 0 1"), "bad:2:", All),
        ("counts beyond all words", "m plastic b 99999999\n".repeat(20_000), "bad:1:", All),
        ("a negative count", with("m sphere s -1 0 4 0 0 0 1"), "bad:2:", All),
        ("a fraction of a count", with("m sphere s 0.5 0 4 0 0 0 1"), "bad:2:", All),
        ("a huge count", with("m sphere s 0 0 999999999 0 0 0 1"), "bad:2:", All),
        ("a count beyond all numbers", with("m sphere s 0 0 99999999999999999999 0"), "bad:2:", All),
        ("integers where there are none", with("m sphere s 0 1 7 4 0 0 0 1"), "bad:2:", All),
        ("a zero byte in a number", with("m sphere s 0 0 4 0\0 0 0 1"), "bad:2:", All),
        ("a zero byte for a type", with("m \0 s 0 0 4 0 0 0 1"), "bad:2:", All),
        ("an unknown type", with("m ball s 0 0 4 0 0 0 1"), "bad:2:", All),
        ("a type in the wrong case", with("m Sphere s 0 0 4 0 0 0 1"), "bad:2:", All),
        ("a command without an end", format!("!{}\n", "echo x ".repeat(1000)), "bad:1:", All),
        ("a control character", with("m \u{1b}[31mball s 0 0 0"), "bad:2:", All),
        ("an undefined modifier", with("n sphere s 0 0 4 0 0 0 1"), "bad:2:", Check),
        ("an undefined target of an alias", with("m alias b n\nb sphere s 0 0 4 0 0 0 1"), "bad:2:", Check),
        ("a modifier of itself", "m plastic m 0 0 5 .5 .5 .5 0 0\nm sphere s 0 0 4 0 0 0 1\n".into(), "bad:1:", Check),
        ("two materials in one chain", with("m metal n 0 0 5 1 1 1 1 0\nn sphere s 0 0 4 0 0 0 1"), "bad:", Check),
        ("a sphere with three numbers", with("m sphere s 0 0 3 0 0 1"), "bad:2:", Check),
        ("half a vertex", with("m polygon p 0 0 10 0 0 0 1 0 0 0 1 0 1"), "bad:2:", Check),
        ("a source without direction", "void light l 0 0 3 1 1 1\nl source s 0 0 4 0 0 0 1\n".into(), "bad:2:", Check),
        ("a source of no angle", "void light l 0 0 3 1 1 1\nl source s 0 0 4 0 0 1 0\n".into(), "bad:2:", Check),
        ("a mesh without file", with("m mesh s 0 0 0"), "bad:2:", Check),
        ("a mesh that is not there", with("m mesh s 1 none.rtm 0 0"), "none.rtm", Check),
        ("an instance that is not there", with("m instance s 1 none.oct 0 0"), "none.oct", Check),
        ("a transform that is none", with("m mesh s 3 none.rtm -q 1 0 0"), "bad:2:", Check),
        ("a plastic with four numbers", "void plastic m 0 0 4 1 1 1 0\nm sphere s 0 0 4 0 0 0 1\n".into(), "bad:1:", Check),
        (
            "an ashik2 with a power below 0",
            "void ashik2 m 4 1 0 0 . 0 8 0 0 0 .1 .1 .1 20 -2\nm sphere s 0 0 4 0 0 0 1\n".into(),
            "bad:1:47",
            Check,
        ),
        ("a picture that is not there", colorpict("none.hdr"), "none.hdr", Check),
        ("a function file that is not there", brightfunc("f", "none.cal"), "none.cal", Check),
        ("an expression without an end", brightfunc("(1+", "."), "bad:1:", Check),
        ("a function that is not there", brightfunc("nowhere(1)", "."), "bad:1:", Check),
        ("a number of nothing", brightfunc("1e999", "."), "bad:1:", Check),
        ("an expression of brackets", brightfunc(&"(".repeat(500), "."), "bad:1:", Check),
        ("an expression of signs", brightfunc(&"-".repeat(500), "."), "bad:1:", Check),
        ("a data file that is not there", brightdata("none.dat"), "none.dat", Check),
        ("a program", format!("!rm -rf /no/such/place\n{SCENE}"), "bad:1:", All),
        ("a program after a pipe", format!("!echo x | sh -c 'id'\n{SCENE}"), "bad:1:", All),
        ("a file that includes itself", format!("{SCENE}!cat bad\n"), "bad:", All),
        ("a file that transforms itself", format!("{SCENE}!xform -t 1 0 0 bad\n"), "bad:", All),
        ("a bomb of copies", format!("{SCENE}!echo '!echo !xform -a 1000 x' | xform -a 1000\n"), "bad:10:", All),
    ];
    let rows: Vec<_> = rows.into_iter().chain(bombs().into_iter().map(|(label, text)| (label, text, "bad:", Check))).collect();
    let mut cases = Vec::new();
    for (label, text, place, by) in &rows {
        let all = [("rparse", 2, All), ("rparse --check", 1, Check), (SEE, 2, Check), ("anneal --exec echo~1", 2, All)];
        for (line, status, reader) in all {
            // anneal reads its start alone: commands in it are not its business.
            if (*by == All || reader == Check) && !(line.starts_with("anneal") && text.contains('!')) {
                cases.push(Case::new(*label, &format!("{line} bad"), *place).with("bad", text.as_str()).ending(status));
            }
        }
        if *by == All {
            let place = place.replace("bad:", "<stdin>:");
            if !label.starts_with("a file that") {
                cases.push(Case::new(*label, "rparse", place).reading(text.as_bytes()));
            }
        }
    }
    for (label, content) in nonsense() {
        for line in ["rparse", SEE, "anneal --exec echo~1"] {
            // An empty scene is a scene.
            if label != "empty" || line.starts_with("anneal") {
                cases.push(Case::new(label, &format!("{line} bad"), "bad").with("bad", content.clone()));
            }
        }
    }
    let lines = ["rparse bad", "rparse --check bad", &format!("{SEE} bad"), "anneal --exec echo~1 bad"];
    cases.extend(unread(&lines));
    cases
}

/// Small scenes that stand for much work.
fn bombs() -> Vec<(&'static str, String)> {
    let m = "void plastic m 0 0 5 .5 .5 .5 0 0\n";
    let before = |i: usize, first: &str| if i == 0 { first.to_string() } else { format!("x{}", i - 1) };
    let lines = |count: usize, line: &dyn Fn(usize) -> String| (0..count).map(line).collect::<String>();
    let ball = |i: usize| format!("x{i} sphere s 0 0 4 0 0 0 1\n");
    let mix = |i: usize| format!("void mixfunc x{i} 4 {0} {0} .5 . 0 0\n", before(i, "m"));
    let mirror = |i: usize| format!("void mirror x{i} 1 {} 0 3 1 1 1\n", before(i, "m"));
    let pattern = |i: usize| format!("{} brightfunc x{i} 2 .9 . 0 0\n", before(i, "void"));
    // Nine mixtures of one another, and an illum that they stand for; again of that illum, and so on.
    let mixed = |i: usize, j: usize| if j > 0 { format!("a{i}_{}", j - 1) } else { before(i, "m") };
    let mixed = |i: usize| lines(9, &|j| format!("void mixfunc a{i}_{j} 4 {0} {0} .5 . 0 0\n", mixed(i, j)));
    let illum = |i: usize| format!("{}void illum x{i} 1 a{i}_8 0 3 1 1 1\n{}", mixed(i), ball(i));
    vec![
        ("illums of mixtures of illums", format!("{m}{}", lines(4, &illum))),
        ("mixtures of mixtures", format!("{m}{}{}", lines(30, &mix), ball(29))),
        ("mixtures too deep", format!("{m}{}{}", lines(1000, &mix), ball(999))),
        ("mirrors of mirrors", format!("{m}{}{}", lines(50_000, &mirror), ball(49_999))),
        ("patterns on patterns", format!("{}x19999 plastic y 0 0 5 1 1 1 0 0\ny sphere s 0 0 4 0 0 0 1\n", lines(20_000, &pattern))),
    ]
}

/// Arrays of arrays, each in a file of its own.
pub fn arrays() -> Vec<Case> {
    let mut cases = Vec::new();
    for (line, status) in [("rparse bad", 2), ("rparse --check bad", 1), (&format!("{SEE} bad"), 2)] {
        let nested = Case::new("arrays of arrays of arrays", line, "c:1:1").with("bad", "!xform -a 1000 -t 1 0 0 b\n");
        let nested = nested.with("b", "!xform -a 1000 -t 0 1 0 c\n").with("c", "!xform -a 1000 -t 0 0 1 d\n").with("d", SCENE);
        cases.push(nested.ending(status));
    }
    cases
}

/// Files that cannot be read, in the place of `bad`.
pub fn unread(lines: &[&str]) -> Vec<Case> {
    let mut cases = Vec::new();
    for (label, content) in unreadable() {
        for line in lines {
            let case = Case::new(label, line, "bad").with("main.rad", "");
            cases.push(match &content {
                Some(content) => case.with("bad", content.clone()),
                None => case,
            });
        }
    }
    cases
}

fn colorpict(file: &str) -> String {
    format!("void colorpict p 7 red green blue {file} . Dx Dy 0 0\np plastic m 0 0 5 .5 .5 .5 0 0\nm sphere s 0 0 4 0 0 0 1\n")
}

fn brightfunc(expression: &str, file: &str) -> String {
    format!("void brightfunc p 2 {expression} {file} 0 0\np plastic m 0 0 5 .5 .5 .5 0 0\nm sphere s 0 0 4 0 0 0 1\n")
}

fn brightdata(file: &str) -> String {
    format!("void brightdata p 4 noop {file} . Dx 0 0\np plastic m 0 0 5 .5 .5 .5 0 0\nm sphere s 0 0 4 0 0 0 1\n")
}

/// A scene whose surface needs the file `bad`.
pub fn scene_of(kind: &str) -> String {
    match kind {
        "cal" => brightfunc("f", "./bad"),
        "dat" => brightdata("./bad"),
        "hdr" => colorpict("./bad"),
        _ => format!("{SCENE}m {kind} b 1 ./bad 0 0\n"),
    }
}

/// The file `bad` in a scene that uses it as this kind.
pub fn used_as(kind: &str, label: &str, content: impl Into<Content>, place: &str) -> Case {
    Case::new(label, &format!("{SEE} main.rad"), place).with("main.rad", scene_of(kind).as_str()).with("bad", content)
}

/// The same, rendered and checked.
pub fn refused_as(kind: &str, label: &str, content: impl Into<Content>, place: &str) -> [Case; 2] {
    let rendered = used_as(kind, label, content, place);
    let checked = Case { words: ["rparse", "--check", "main.rad"].map(String::from).into(), ..rendered.clone() };
    [rendered, checked.ending(1)]
}

/// What these programs accept.
pub fn whole() -> Vec<Case> {
    vec![
        Case::new("scene", "rparse bad", "").with("bad", SCENE),
        Case::new("scene", "rparse --check bad", "").with("bad", SCENE),
        Case::new("scene", &format!("{SEE} bad"), "").with("bad", SCENE),
        Case::new("scene", "anneal --exec echo~1 --steps 3 --no-polish bad", "").with("bad", SCENE),
        Case::new("view", "rtrace-rs -n 1 -x 8 -y 8 --spp 1 -vf bad main.rad", "")
            .with("main.rad", SCENE)
            .with("bad", "VIEW= -vp 0 -5 0\n"),
        used_as("cal", "functions", "g(x) = x; f = g(1);", ""),
        used_as("dat", "data", "1 0 1 3 1 2 3", ""),
        used_as("mesh", "wavefront", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ""),
    ]
}

pub fn functions() -> Vec<Case> {
    let deep = |open: &str, close: &str| format!("f = {}1{};", open.repeat(100_000), close.repeat(100_000));
    let chain: String = (0..20_000).map(|i| format!("f{} = f{}+1;", i, i + 1)).collect();
    let doubling: String = (0..64).map(|i| format!("g{i}(x) = g{0}(x)+g{0}(x+1);", i + 1)).collect();
    let rows: Vec<(&str, String)> = vec![
        ("no end of a definition", "f = 1 +".into()),
        ("no value", "f = ;".into()),
        ("no name", "= 1;".into()),
        ("an operator too many", "f = 1 * / 2;".into()),
        ("a bracket too many", "f = (1));".into()),
        ("a comment without an end", "f = 1; { and on".into()),
        ("a zero byte", "f = 1\0;".into()),
        ("a letter of another script", "f = α;".into()),
        ("a number with two points", "f = 1.2.3;".into()),
        ("an argument too few", "g(x,y) = y; f = g(1);".into()),
        ("a function that is a variable", "g(x) = x; f = g;".into()),
        ("a variable that is a function", "g = 1; f = g(1);".into()),
        ("itself", "f = f + 1;".into()),
        ("itself around a corner", "f = g; g = h; h = f;".into()),
        ("64 functions that double", format!("{doubling} g64(x) = x*Px; f = g0(Px);")),
        ("a chain without a last link", format!("{chain} f = f0;")),
        ("deep brackets", deep("(", ")")),
        ("deep signs", deep("-", "")),
        ("deep calls", deep("sin(", ")")),
        ("deep powers", deep("2^", "")),
        ("an unknown name", "f = nowhere;".into()),
        ("an argument that is not there", "f = A(99);".into()),
        ("a name without an end", format!("f = {};", "x".repeat(200_000))),
    ];
    let mut cases: Vec<Case> = rows.iter().flat_map(|(label, text)| refused_as("cal", label, text.as_str(), "bad")).collect();
    // What is missing is missed by the scene.
    let place = |label: &str| if label == "empty" { "main.rad:1:21" } else { "bad" };
    cases.extend(nonsense().into_iter().flat_map(|(label, content)| refused_as("cal", label, content, place(label))));
    cases.extend(refused_as("cal", "no definition of the name", "g = 1;", "main.rad:1:21"));
    cases.extend(unread_in("cal"));
    cases
}

/// Files that cannot be read, in a scene that uses them as this kind.
pub fn unread_in(kind: &str) -> Vec<Case> {
    let line = format!("{SEE} main.rad");
    let mut cases = unread(&[&line]);
    for case in &mut cases {
        case.files[0].1 = Content::from(scene_of(kind).as_str());
    }
    cases
}

pub fn tables() -> Vec<Case> {
    let rows = [
        ("no number of dimensions", "x"),
        ("no dimension", "0"),
        ("too many dimensions", "6 0 1 2 0 1 2 0 1 2 0 1 2 0 1 2 0 1 2 1"),
        ("a dimension without an end", "1 0"),
        ("one position", "1 0 1 1 5"),
        ("a negative number of positions", "1 0 1 -3 5 5 5"),
        ("a huge number of positions", "1 0 1 268435456 1 2 3"),
        ("a number of positions beyond all numbers", "1 0 1 99999999999999999999 1"),
        ("a product beyond all numbers", "5 0 1 65536 0 1 65536 0 1 65536 0 1 65536 0 1 65536 1"),
        ("a product near the limit", "2 0 1 16384 0 1 16384 1 2 3"),
        ("too few values", "1 0 1 3 1 2"),
        ("a value that is none", "1 0 1 3 1 x 3"),
        ("a value that is not a number", "1 0 1 3 1 nan 3"),
        ("a value beyond all numbers", "1 0 1 3 1 1e999 3"),
        ("positions that go back and forth", "1 0 0 3 1 3 2 5 6 7"),
        ("equal ends", "1 1 1 3 5 6 7"),
        ("a zero byte", "1 0 1 3 1\0 2 3"),
        ("a blank of another script", "1\n0 4\u{a0}1\n"),
    ];
    let mut cases: Vec<Case> = rows.iter().flat_map(|(label, text)| refused_as("dat", label, *text, "bad")).collect();
    cases.extend(nonsense().into_iter().flat_map(|(label, content)| refused_as("dat", label, content, "bad")));
    cases.extend(unread_in("dat"));
    cases
}

pub fn views() -> Vec<Case> {
    let rows = [
        ("no view", "rpict\n"),
        ("a direction of nothing", "VIEW= -vd 0 0 0\n"),
        ("up along the direction", "VIEW= -vd 0 0 1 -vu 0 0 -2\n"),
        ("a view of 180 degrees", "VIEW= -vtv -vh 180\n"),
        ("a view of no size", "VIEW= -vh 0\n"),
        ("a negative size", "VIEW= -vv -30\n"),
        ("planes that cross", "VIEW= -vo 5 -va 2\n"),
        ("a view in the wrong place", "\nVIEW= -vp 0 0 5\n"),
    ];
    let line = "rtrace-rs -n 1 -x 8 -y 8 --spp 1 -vf bad main.rad";
    let case = |label: &str, content: Content, place: &str| Case::new(label, line, place).with("main.rad", SCENE).with("bad", content);
    let mut cases: Vec<Case> = rows.iter().map(|(label, text)| case(label, Content::from(*text), "")).collect();
    cases.extend(nonsense().into_iter().map(|(label, content)| case(label, content, "bad")));
    cases.extend(unread(&[line]));
    cases
}

pub fn objects() -> Vec<Case> {
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let face = |text: &str| format!("{corners}{text}\n");
    let rows: Vec<(&str, String, &str)> = vec![
        ("a vertex of two numbers", "v 0 0\n".into(), "bad:1:"),
        ("a vertex of no numbers", "v\n".into(), "bad:1:"),
        ("a vertex of words", "v 0 zero 0\n".into(), "bad:1:"),
        ("a vertex that is not a number", "v 0 nan 0\n".into(), "bad:1:"),
        ("a vertex beyond all numbers", "v 0 1e999 0\n".into(), "bad:1:"),
        ("a normal of words", face("vn a b c"), "bad:4:"),
        ("a coordinate of words", face("vt a b"), "bad:4:"),
        ("a face of two corners", face("f 1 2"), "bad:4:"),
        ("a face of no corners", face("f"), "bad:4:"),
        ("a corner beyond the vertices", face("f 1 2 4"), "bad:4:"),
        ("a corner before the vertices", face("f 1 2 -4"), "bad:4:"),
        ("corner 0", face("f 0 1 2"), "bad:4:"),
        ("a corner of words", face("f 1 2 x"), "bad:4:"),
        ("a corner beyond all numbers", face("f 1 2 99999999999999999999"), "bad:4:"),
        ("a corner of four parts", face("f 1/1/1/1 2 3"), "bad:4:"),
        ("a normal that is not there", face("f 1//1 2//1 3//1"), "bad:4:"),
        ("a coordinate that is not there", face("f 1/1 2/1 3/1"), "bad:4:"),
        ("a face of too many corners", face(&format!("f {}", "1 2 3 ".repeat(20_000))), "bad:4:"),
        ("no face at all", corners.into(), "bad"),
        ("a zero byte", face("f 1 2\0 3"), "bad:4:"),
    ];
    let mut cases: Vec<Case> = rows.iter().map(|(label, text, place)| used_as("mesh", label, text.as_str(), place)).collect();
    cases.extend(nonsense().into_iter().flat_map(|(label, content)| refused_as("mesh", label, content, "bad")));
    cases.extend(unread_in("mesh"));
    cases
}
