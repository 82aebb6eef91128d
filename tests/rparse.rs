//! rparse as a program and the rooms behind it: round trips, recorded answers of RADIANCE's programs, and RADIANCE itself over many
//! real files where both are there.

use crate::corpus::files;
use crate::fed::fed;
use inverad::error::Source;
use inverad::expand::{Flat, expand};
use inverad::rad::{Document, Primitive};
use inverad::resolve::Files;
use proptest::prelude::*;
use rayon::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs rparse in `directory` with these arguments, and `input` on its standard input: status, output, what was said.
fn rparse(directory: &Path, arguments: &[&str], input: &[u8]) -> (i32, Vec<u8>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rparse"));
    let output = fed(command.args(arguments).current_dir(directory).env_remove("RAD_COMMANDS"), input);
    (output.status.code().unwrap(), output.stdout, String::from_utf8_lossy(&output.stderr).into_owned())
}

/// What rparse prints on a text that it has nothing to say about.
fn printed(arguments: &[&str], input: &str) -> String {
    let (status, output, said) = rparse(Path::new("."), arguments, input.as_bytes());
    assert_eq!((status, said.as_str()), (0, ""), "{arguments:?} {input}");
    String::from_utf8(output).unwrap()
}

const SCENE: &str = "# A red ball.\nvoid plastic red\n0\n0\n5  .7 .1 .1   .05 .1  # dull\n\nvoid metal unused 0 0 5 1 1 1 1 0\n\
                     red sphere 'the ball'\n0 0 4 0 0 1e-3 1\n!xform -n up -t 0 0 2 /dev/null\n";

#[test]
fn a_scene_is_printed_flat_and_canonical() {
    let scene = "void light m 0 0 3 1 1 1\nvoid alias a m\n!echo 'm sphere \"a b\" 0 0 4 1 2 3 4' | xform -n up -s .5\nm polygon p 0 0 9 0 0 0 1 0 0 0 1 0\n#@probe 1 2 3 sky";
    let flat = "void light m\n0\n0\n3 1 1 1\n\nvoid alias a m\n\nm sphere \"up.a b\"\n0\n0\n4 0.5 1 1.5 2\n\nm polygon p\n0\n0\n9\n  0 0 0\n  1 0 0\n  0 1 0\n\n#@probe 1 2 3 sky\n";
    assert_eq!(printed(&[], scene), flat);
    assert_eq!(printed(&["-"], flat), flat);
    // Meshes and octrees bear their transform as words.
    let placed = printed(&[], "!echo void mesh a 3 pot.rtm -rz 90 0 0 | xform -t 1 2 3\nvoid instance b 5 b.oct -t 1 2 3 0 0\n");
    let flat = "void mesh a\n9 pot.rtm -rz 90 -i 1 -t 1 2 3\n0\n0\n\nvoid instance b\n5 b.oct -t 1 2 3\n0\n0\n\n";
    assert_eq!(placed, flat);
}

#[test]
fn what_oconv_would_refuse_is_not_printed_in_silence() {
    let (status, output, said) = rparse(Path::new("."), &[], b"void light m 0 0 3 1 1 1\nm polygon p 0 0 6 0 0 0 1 1 1\n");
    assert_eq!((status, output.len()), (2, 0));
    assert!(said.contains("<stdin>:2:3: error: polygon needs three real arguments for each of at least three vertices, not 6"), "{said}");
    // Another scene may define it: the unknown of a recovery, for instance.
    let (status, output, said) = rparse(Path::new("."), &[], b"it sphere s 0 0 4 0 0 0 1\n");
    assert!(status == 0 && output.starts_with(b"it sphere s\n"));
    assert!(said.contains("warning: <stdin>:1:1: no modifier `it` is defined before this; define it above"), "{said}");
}

#[test]
fn keep_changes_nothing_but_what_is_set() {
    assert_eq!(printed(&["--keep"], SCENE), SCENE);
    assert_eq!(
        printed(&["--keep", "--set", "red:rough=0.25", "--set", "red:a1=1"], SCENE),
        SCENE.replace(".7", "1").replace(".1  #", "0.25  #")
    );
    let bytes = b"# caf\xe9\r\n\tvoid glow 'g' 0 0 4 1 1 1 0\r\n";
    let (status, output, _) = rparse(Path::new("."), &["--keep"], bytes);
    assert_eq!((status, output.as_slice()), (0, &bytes[..]));
    let (status, _, said) = rparse(Path::new("."), &["--keep", "--set", "blue:rough=1"], SCENE.as_bytes());
    assert_eq!((status, said.as_str()), (2, "rparse: error: no modifier is called `blue`\n"));
    assert_eq!(rparse(Path::new("."), &["--set", "red:rough=1"], SCENE.as_bytes()).0, 2);
}

#[test]
fn materials_are_those_that_surfaces_use() {
    let scene = "void plastic b 0 0 5 1 1 1 0 0 void brightfunc f 2 x . 0 0 f metal m 0 0 5 1 1 1 1 0 void plastic c 0 0 5 1 1 1 0 0\n\
                 void mixfunc mix 4 b m .5 . 0 0 mix sphere s 0 0 4 0 0 0 1";
    let names: Vec<String> =
        printed(&["--materials"], scene).split("\n\n").filter_map(|p| p.split_whitespace().nth(2).map(String::from)).collect();
    assert_eq!(names, ["b", "f", "m", "mix"]);
}

#[test]
fn json_has_a_line_for_each_primitive() {
    let line = r#"{"file":"<stdin>","line":2,"modifier":"red","type":"ring","id":"r","sargs":["s"],"iargs":[],"fargs":[1.0,2.5]}"#;
    assert_eq!(printed(&["--json"], "# ring\nred ring r 1 s 0 2 1 2.5"), format!("{line}\n"));
}

#[test]
fn a_check_finds_every_problem_in_one_run() {
    let wrong = "void plastic a 0 0 5 1 1 1 0 x\nb sphere s 0 0 4 0 0 0 1\nvoid sphere t 0 0 3 0 0 1\n!frobnicate\n";
    let (status, output, said) = rparse(Path::new("."), &["--check"], wrong.as_bytes());
    assert_eq!((status, output.len()), (1, 0));
    let places: Vec<&str> = said.lines().filter_map(|l| l.strip_prefix("rparse: <stdin>:")?.split(": error:").next()).collect();
    assert_eq!(places, ["1:30", "4:1", "2:1", "3:6"], "{said}");
    // Types that are none, one after the other.
    let types =
        "void plastik a 0 0 5 1 1 1 0 0\nvoid metall b 0 0 5 1 1 1 0 0\nvoid spheer s\n0\n0\n4 0 0 0 1\nvoid sphre t 0 0 4 0 0 0 1\n";
    let (_, _, said) = rparse(Path::new("."), &["--check"], types.as_bytes());
    let meant: Vec<&str> = said.lines().filter_map(|l| l.strip_suffix("` is one")?.rsplit('`').next()).collect();
    assert_eq!(meant, ["plastic", "metal", "sphere", "sphere"], "{said}");
    let (status, output, said) = rparse(Path::new("."), &["--check"], SCENE.as_bytes());
    assert_eq!((status, output.len()), (0, 0), "{said}");
    assert!(said.starts_with("rparse: warning: <stdin>:10:1: the command printed no primitive"), "{said}");
}

#[test]
fn a_check_says_what_the_renderer_would_refuse_beside_all_else() {
    let ball = |modifier: &str| format!("{modifier} sphere s 0 0 4 0 0 0 1\n");
    let wrong = [
        "void brightfunc q 2 (1+ . 0 0\nq plastic a 0 0 5 1 1 1 0 0\n",
        "void colorfunc n 4 1 nowhere 1 . 0 0\nn texfunc f 4 0 0 g none.cal 0 0\nf plastic b 0 0 5 1 1 1 0 0\n",
        "void colorpict p 7 red green blue none.hdr . Dx Dy 0 0\np metal c 0 0 5 1 1 1 0 0\n",
        "void mixfunc m 4 a b x+ . 0 0\nvoid glow e 0 0 4 1 1 1 0\ne source sky 0 0 4 0 0 1 360\n",
        &["a", "a", "b", "c", "m", "later"].map(ball).concat(),
        "#@probe 0 0 e\n#@probe 0 0 nan e\n#@probe 0 0 0 sun\n#@probe 0 0 0 e\n",
        // What nothing uses may be anything.
        "void brightfunc unused 2 (1+ none.cal 0 0\n",
    ]
    .concat();
    let (status, output, said) = rparse(Path::new("."), &["--check"], wrong.as_bytes());
    assert_eq!((status, output.len()), (1, 0), "{said}");
    let mut places: Vec<&str> = said.lines().filter_map(|l| l.strip_prefix("rparse: <stdin>:")?.split(": error:").next()).collect();
    places.sort();
    let wanted = ["16:1", "17:1", "18:1", "19:1", "1:24", "3:22", "4:21", "6:35", "8:24"];
    assert_eq!(places, wanted, "{said}");
    let (_, _, rendered) = rparse(Path::new("."), &["--check"], format!("void brightfunc q 2 (1+ . 0 0\n{}", ball("q")).as_bytes());
    assert!(rendered.starts_with("rparse: <stdin>:1:24: error: "), "{rendered}");
}

#[test]
fn what_is_wrong_with_what_a_command_prints_is_said_once_where_the_command_stands() {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("inner.rad"), "\n!genbox oak box 1 1 1 | xform -n inner\n").unwrap();
    let scene = b"# A box, and one in another file.\n!genbox pine box 1 1 1\n!xform -t 2 0 0 inner.rad\n";
    let (status, _, said) = rparse(directory.path(), &["--check"], scene);
    let lines: Vec<&str> = said.lines().filter(|line| line.starts_with("rparse: ")).collect();
    let [pine, oak] = &lines[..] else { panic!("{said}") };
    assert!(status == 1 && pine.starts_with("rparse: <stdin>:2:1: error: no modifier `pine` is defined before this"), "{said}");
    assert!(pine.ends_with(" (in line 2 of what this prints)") && said.contains("  !genbox pine box 1 1 1\n  ^^^^^^^\n"), "{said}");
    assert!(oak.starts_with("rparse: inner.rad:2:1: error: no modifier `oak`"), "{said}");
}

#[test]
fn an_octree_is_told_from_a_scene_file_and_a_command_that_was_typed_is_run() {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("x.oct"), include_bytes!("import/plain.oct")).unwrap();
    for mode in [&["x.oct"][..], &["--check", "x.oct"]] {
        let (status, _, said) = rparse(directory.path(), mode, b"");
        let wanted = "rparse: error: x.oct: this is an octree, not a scene file: rtrace-rs reads it; give rparse the scene files that it was made from\n";
        assert_eq!((status, said.as_str()), (2, wanted));
    }
    let flat = b"void light l\n0\n0\n3 1 1 1\n\n";
    let (status, output, said) = rparse(directory.path(), &["!echo void light l 0 0 3 1 1 1"], b"");
    assert_eq!((status, output.as_slice(), said.as_str()), (0, &flat[..], ""));
    assert_eq!(rparse(directory.path(), &["!exit 3"], b"").0, 2);
}

#[test]
fn commands_run_only_when_allowed() {
    let directory = tempfile::tempdir().unwrap();
    let scene = b"!touch pwned\n!echo void plastic p 0 0 0\n";
    for denied in [&[][..], &["--commands", "deny"], &["--check"]] {
        let (status, _, said) = rparse(directory.path(), denied, scene);
        assert!(status > 0 && said.contains("<stdin>:1:1: error: ") && said.contains("--commands allow"), "{said}");
        assert!(!directory.path().join("pwned").exists());
    }
    let (status, output, _) = rparse(directory.path(), &["--commands", "allow"], scene);
    assert_eq!((status, output.as_slice()), (0, &b"void plastic p\n0\n0\n0\n\n"[..]));
    assert!(directory.path().join("pwned").exists());
    fs::remove_file(directory.path().join("pwned")).unwrap();
    fs::write(directory.path().join("scene.rad"), scene).unwrap();
    for (more, wanted) in [(&[][..], 2), (&["--commands", "deny"], 2), (&["--commands", "allow"], 0)] {
        let mut render = Command::new(env!("CARGO_BIN_EXE_rtrace-rs"));
        let output = fed(render.args(["-h", "scene.rad"]).args(more).current_dir(directory.path()).env_remove("RAD_COMMANDS"), b"");
        assert_eq!(output.status.code(), Some(wanted), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(directory.path().join("pwned").exists(), wanted == 0);
    }
    assert_eq!(rparse(directory.path(), &["--commands", "deny"], b"!echo void plastic p 0 0 0\n").0, 2);
    // The environment says the same, and nothing else.
    for (said, built_in, wanted) in [("deny", true, 2), ("allow", true, 0), ("allow", false, 0), ("yes", true, 2)] {
        let input: &[u8] = if built_in { b"!echo void plastic p 0 0 0\n" } else { scene };
        let mut command = Command::new(env!("CARGO_BIN_EXE_rparse"));
        let output = fed(command.current_dir(directory.path()).env("RAD_COMMANDS", said), input);
        assert_eq!(output.status.code(), Some(wanted), "{said}: {}", String::from_utf8_lossy(&output.stderr));
    }
    // What is typed may, unless a file is called so.
    let (status, _, said) = rparse(directory.path(), &["--commands", "deny", "!touch here"], b"");
    assert!(status == 2 && said.contains("commands are denied") && !directory.path().join("here").exists(), "{said}");
    fs::write(directory.path().join("!touch here"), "void plastic p 0 0 0\n").unwrap();
    let (status, output, _) = rparse(directory.path(), &["!touch here"], b"");
    assert_eq!((status, output.as_slice()), (0, &b"void plastic p\n0\n0\n0\n\n"[..]));
    assert!(!directory.path().join("here").exists());
}

#[test]
fn stats_say_what_rendering_requires() {
    let stats = printed(&["--stats"], &SCENE.replace("!xform -n up -t 0 0 2 /dev/null\n", ""));
    assert!(stats.contains("requires     spheres, glossy reflection\n") && !stats.contains("unsupported"), "{stats}");
}

// --- round trips ---

/// A statement with random white space, quotes and numbers as people write them.
fn statement() -> impl Strategy<Value = String> {
    let space = "[ \t\r\n]{1,3}";
    let word = "[a-zA-Z0-9_.é]{1,8}|\"[a-z '#]{0,6}\"|'[a-z\"!]{0,6}'|[a-z]\"[a-z ]{0,3}\"[a-z]";
    let number = "[+-]?[0-9]{1,4}(\\.[0-9]{0,9})?(e[+-]?[0-9]{1,2})?";
    let primitive =
        (word, "plastic|metal|polygon|glow|texfunc", word, prop::collection::vec(word, 0..4), prop::collection::vec(number, 0..9), space)
            .prop_map(|(modifier, kind, name, strings, reals, space)| {
                let mut words = vec![format!("m{modifier}"), kind, name, strings.len().to_string()];
                words.extend(strings);
                words.extend(["0".into(), reals.len().to_string()]);
                words.extend(reals);
                words.join(&space)
            });
    let alias = (word, word, word).prop_map(|(a, b, c)| format!("m{a} alias {b} {c}"));
    prop_oneof![6 => primitive, 1 => alias, 1 => "#[ -~é]{0,20}\r?\n", 1 => "![a-z |]{0,20}(\\\\\n[a-z]{0,5})?\n", 1 => "[ \t\n]{0,4}"]
}

/// All that a primitive says.
fn content(p: &Primitive) -> (&str, &str, &str, &[String], &[f64]) {
    (&p.modifier, &p.kind, &p.name, &p.strings, &p.reals)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_read_is_printed_byte_for_byte_and_canonical_text_reads_the_same(statements in prop::collection::vec(statement(), 0..12)) {
        let text = statements.join("\n");
        let document = Document::parse(Source::new("t.rad", text.as_str())).unwrap();
        prop_assert_eq!(document.bytes(), text.as_bytes());
        let primitives: Vec<Primitive> = document.primitives().cloned().collect();
        let flat = Flat { primitives, ..Flat::default() };
        let again = Document::parse(Source::new("again.rad", flat.to_string())).unwrap();
        prop_assert_eq!(again.primitives().map(content).collect::<Vec<_>>(), flat.primitives.iter().map(content).collect::<Vec<_>>());
        let flat_again = Flat { primitives: again.primitives().cloned().collect(), ..Flat::default() };
        prop_assert_eq!(flat_again.to_string(), flat.to_string());
    }
}

// --- RADIANCE's own answers ---

/// Whether a primitive is the recorded or printed `theirs`, numbers to their printed digits; `size` is that of the scene's numbers.
fn agrees(ours: &Primitive, theirs: &Primitive, size: f64) -> bool {
    // xform prints 12 digits, and 6 of a medium's numbers.
    let digits = if matches!(theirs.kind.as_str(), "dielectric" | "interface" | "mist") { 2e-6 } else { 2e-11 };
    let same = |(a, b): (&f64, &f64)| (a - b).abs() <= digits * a.abs().max(size);
    let (a, b) = (content(ours), content(theirs));
    (a.0, a.1, a.2, a.3, a.4.len()) == (b.0, b.1, b.2, b.3, b.4.len()) && a.4.iter().zip(b.4).all(same)
}

/// What differs first between two lists of primitives.
fn difference(ours: &[Primitive], theirs: &[Primitive]) -> Option<String> {
    if ours.len() != theirs.len() {
        return Some(format!("{} primitives instead of {}", ours.len(), theirs.len()));
    }
    let wrong = ours.iter().zip(theirs).find(|(a, b)| {
        let size = a.reals.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
        !agrees(a, b, size)
    });
    wrong.map(|(a, b)| format!("{a} instead of {b}").split_whitespace().collect::<Vec<_>>().join(" "))
}

fn primitives(text: &str) -> Vec<Primitive> {
    Document::parse(Source::new("theirs", text)).unwrap().primitives().cloned().collect()
}

#[test]
fn recorded_answers_of_xform_and_the_generators_are_met() {
    let files = Files::of([
        ("parts.rad", &include_bytes!("rparse/parts.rad")[..]),
        ("moves.txt", include_bytes!("rparse/moves.txt")),
        ("part/b.rad", include_bytes!("rparse/part/b.rad")),
        ("part/c.rad", include_bytes!("rparse/part/c.rad")),
    ]);
    let cases: Vec<&str> = include_str!("rparse/recorded.txt").split("\n$ ").skip(1).collect();
    assert!(cases.len() > 40);
    for case in cases {
        let (command, theirs) = case.split_once('\n').unwrap();
        let document = Document::parse(Source::new("scene.rad", format!("!{command}"))).unwrap();
        let flat = expand(vec![document], &files).unwrap();
        assert_eq!(difference(&flat.primitives, &primitives(theirs)), None, "{command}: {:?}", flat.warnings);
    }
}

/// What comparing one file came to.
enum Verdict {
    Agrees,
    Differs(String),
    /// oconv refuses it, and so does `rparse --check`.
    Refused,
    /// oconv refuses it, but `rparse --check` does not, or not in the right way.
    Missed(String),
}

/// Compares rparse with RADIANCE's programs on one file, alone in its directory.
fn compare(path: &Path) -> Verdict {
    let (directory, name) = (path.parent().unwrap(), path.file_name().unwrap().to_str().unwrap());
    let radiance = |program: &str, argument: &[&str], input: &[u8]| fed(Command::new(program).args(argument).current_dir(directory), input);
    let oconv = radiance("oconv", &[name], b"");
    if !oconv.status.success() {
        let (status, _, said) = rparse(directory, &["--check", name], b"");
        let placed =
            said.lines().any(|line| line.contains(": error: ") && line.split(':').nth(2).is_some_and(|n| n.parse::<usize>().is_ok()));
        return if status == 1 && placed { Verdict::Refused } else { Verdict::Missed(format!("status {status}: {said}")) };
    }
    let (status, ours, said) = rparse(directory, &[name], b"");
    if status != 0 {
        return Verdict::Differs(said);
    }
    let theirs = radiance("xform", &["-e", name], b"").stdout;
    let read = |bytes: Vec<u8>| Document::read("printed", bytes).map(|d| d.primitives().cloned().collect::<Vec<_>>());
    let wrong = match (read(ours.clone()), read(theirs)) {
        (Ok(ours), Ok(theirs)) => difference(&ours, &theirs),
        (Err(error), _) | (_, Err(error)) => Some(error.to_string()),
    };
    let refused =
        || Some(radiance("oconv", &["-"], &ours)).filter(|o| !o.status.success()).map(|o| String::from_utf8_lossy(&o.stderr).into_owned());
    wrong.or_else(refused).map_or(Verdict::Agrees, Verdict::Differs)
}

#[test]
fn real_files_are_read_as_radiance_reads_them() {
    let Some((corpus, files)) = files::corpus(&["oconv", "xform"]) else { return };
    let verdicts: Vec<(&PathBuf, Verdict)> = files.par_iter().map(|path| (path, compare(path))).collect();
    let count = |wanted: fn(&Verdict) -> bool| verdicts.iter().filter(|(_, v)| wanted(v)).count();
    let (agree, differ) = (count(|v| matches!(v, Verdict::Agrees)), count(|v| matches!(v, Verdict::Differs(_))));
    let (refused, missed) = (count(|v| matches!(v, Verdict::Refused)), count(|v| matches!(v, Verdict::Missed(_))));
    for (path, verdict) in &verdicts {
        if let Verdict::Differs(why) | Verdict::Missed(why) = verdict {
            eprintln!("{}: {}", path.strip_prefix(&corpus).unwrap().display(), why.lines().next().unwrap_or(""));
        }
    }
    eprintln!(
        "of {} files that oconv accepts, {agree} agree with xform -e; of {} that it refuses, {refused} are explained",
        agree + differ,
        refused + missed
    );
    assert!(agree * 100 >= (agree + differ) * 99 && missed == 0);
}
