use super::*;
use crate::resolve::Files;
use crate::vector::Vec3;

fn flat(files: &[(&str, &str)]) -> Result<Flat> {
    let resolve = Files::of(files.iter().map(|(name, text)| (*name, text.as_bytes())));
    expand(vec![Document::parse(Source::new(files[0].0, files[0].1))?], &resolve)
}

fn lines(flat: &Flat) -> Vec<String> {
    flat.primitives.iter().map(|p| p.to_string().split_whitespace().collect::<Vec<_>>().join(" ")).collect()
}

/// One line for each primitive of `text` after `xform OPTIONS`.
fn xformed(options: &str, text: &str) -> Vec<String> {
    lines(&flat(&[("a.rad", &format!("!xform {options} b.rad")), ("b.rad", text)]).unwrap())
}

#[test]
fn arrays_name_and_place_their_copies() {
    // xform -n p -a 2 -t 1 0 0 -i 2 -t 0 1 0 -a 2 -rz 90 -s 2, on a sphere at 1 2 3; numbers as printed.
    let names: Vec<_> =
        flat(&[("a.rad", "!xform -n p -a 2 -t 1 0 0 -i 2 -t 0 1 0 -a 2 -rz 90 -s 2 b.rad"), ("b.rad", "m sphere s 0 0 4 1 2 3 4")])
            .unwrap()
            .primitives;
    let expected =
        [("p.0.0.s", [1., 4., 3., 4.]), ("p.0.1.s", [-8., 2., 6., 8.]), ("p.1.0.s", [2., 4., 3., 4.]), ("p.1.1.s", [-8., 4., 6., 8.])];
    for (p, (name, reals)) in names.iter().zip(expected) {
        assert_eq!(p.name, name);
        assert!((Vec3::from_slice(&p.reals) - Vec3::from_slice(&reals)).length() < 1e-14 && p.reals[3] == reals[3]);
    }
}

#[test]
fn every_type_moves_as_it_should() {
    // xform -t 1 2 3 -s 2, then xform -I -my -s -3; recorded.
    let scene = "p ring r 0 0 8 0 0 0 0 0 1 1 2\nvoid glow g 0 0 4 1 1 1 5\nvoid spotlight l 0 0 7 1 1 1 90 0 0 -1\n\
                 p polygon q 0 0 9 1 0 0 0 1 0 0 0 1\nvoid mist m 1 l 0 3 1 2 3\nvoid alias a p\np cone c 0 0 8 0 0 0 0 0 1 1 2\n\
                 void brightfunc f 2 x . 0 0\np mesh h 1 h.rtm 0 0\nvoid source o 0 0 4 0 0 1 3\nvoid plastic p 0 0 5 .5 .5 .5 0 .1";
    assert_eq!(
        xformed("-t 1 2 3 -s 2", scene),
        [
            "p ring r 0 0 8 2 4 6 0 0 2 2 4",
            "void glow g 0 0 4 1 1 1 10",
            "void spotlight l 0 0 7 1 1 1 90 0 0 -2",
            "p polygon q 0 0 9 4 4 6 2 6 6 2 4 8",
            "void mist m 1 l 0 3 0.5 1 1.5",
            "void alias a p",
            "p cone c 0 0 8 2 4 6 2 4 8 2 4",
            "void brightfunc f 10 x . -i 1 -t 1 2 3 -s 2 0 0",
            "p mesh h 9 h.rtm -i 1 -t 1 2 3 -s 2 0 0",
            "void source o 0 0 4 0 0 2 3",
            "void plastic p 0 0 5 0.5 0.5 0.5 0 0.1",
        ]
    );
    assert_eq!(
        xformed("-I -n x -my -s -3", scene)[..4],
        [
            "p ring x.r 0 0 8 0 0 0 0 0 3 3 6",
            "void glow g 0 0 4 1 1 1 15",
            "void spotlight l 0 0 7 1 1 1 90 0 0 3",
            "p polygon x.q 0 0 9 0 0 -3 0 3 0 -3 0 0",
        ]
        .map(|s| s.to_string())
    );
    assert_eq!(xformed("-n x -m n", scene)[4..7], ["void mist m 1 x.l 0 3 1 2 3", "void alias a p", "n cone x.c 0 0 8 0 0 0 0 0 1 1 2"]);
    assert_eq!(xformed("-mx", scene)[3], "p polygon q 0 0 9 0 0 1 0 1 0 -1 0 0");
    // xform -s 2 on these prints 6 digits: .707107 .774597 .83666.
    let glass = xformed("-s 2", "void dielectric d 0 0 5 .5 .6 .7 1.5 0");
    assert_eq!(glass, [format!("void dielectric d 0 0 5 {:?} {:?} {:?} 1.5 0", 0.5f64.sqrt(), 0.6f64.sqrt(), 0.7f64.sqrt())]);
}

#[test]
fn argument_files_make_a_copy_for_each_line() {
    // xform -n k -m z -f args -a 2 -t 1 0 0, recorded.
    let flat = flat(&[
        ("a.rad", "!xform -n k -m z -f args -a 2 -t 1 0 0 b.rad"),
        ("b.rad", "m sphere s 0 0 4 1 2 3 4"),
        ("args", "-t 1 0 0\n\n# comment\n-s 2\n"),
    ]);
    assert_eq!(
        lines(&flat.unwrap()),
        [
            "z sphere k.0.0.s 0 0 4 2 2 3 4",
            "z sphere k.0.1.s 0 0 4 3 2 3 4",
            "z sphere k.1.0.s 0 0 4 2 4 6 8",
            "z sphere k.1.1.s 0 0 4 3 4 6 8"
        ]
    );
}

#[test]
fn what_is_wrong_with_valid_is_said() {
    let surface = |valid: &str| flat(&[("a.rad", &*format!("!gensurf m s s t 's*t' 1 1 -e 'valid({valid}'"))]).unwrap();
    let count = |valid: &str| (surface(valid).primitives.len(), surface(valid).warnings.concat());
    assert_eq!((count("s,t)=s-2").0, count("s,t)=1").0), (0, 2));
    // As in RADIANCE, a function of one parameter is none.
    assert_eq!(count("s)=s-2").0, 2);
    let (none, said) = count("s,t)=nowhere(s)");
    assert!(none == 0 && said.contains("nowhere"), "{said}");
}

#[test]
fn commands_in_a_file_run_in_its_directory() {
    let files = [
        ("a.rad", "!xform -c -t 1 0 0 d/b.rad\n!cat d/c.rad | xform -s 2\n!echo m sphere e 0 0 4 0 0 0 1"),
        ("d/b.rad", "!xform -s 2 c.rad"),
        ("d/c.rad", "m sphere c 0 0 4 1 0 0 1"),
        ("c.rad", "m sphere top 0 0 4 1 0 0 1"),
    ];
    // With -c the command of b.rad is left to the reader of a.rad, where c.rad is another file.
    let out = flat(&files).unwrap();
    assert_eq!(lines(&out), ["m sphere top 0 0 4 3 0 0 2", "m sphere c 0 0 4 2 0 0 2", "m sphere e 0 0 4 0 0 0 1"]);
    let mut expanded = files;
    expanded[0].1 = "!xform -t 1 0 0 d/b.rad";
    assert_eq!(lines(&flat(&expanded).unwrap()), ["m sphere c 0 0 4 3 0 0 2"]);
}

#[test]
fn a_file_that_includes_itself_is_an_error_that_says_so() {
    let error = flat(&[("a.rad", "!xform ./b.rad"), ("./b.rad", "!cat a.rad")]).unwrap_err().to_string();
    assert!(error.contains("a.rad includes itself through `!xform ./b.rad`, `b.rad`, `!cat a.rad`"), "{error}");
}

#[test]
fn a_command_that_fails_is_a_warning() {
    let out =
        flat(&[("a.rad", "m sphere s 0 0 4 0 0 0 1\n!xform b.rad none.rad\n!xform -s 0 b.rad"), ("b.rad", "m sphere b 0 0 4 1 0 0 1")])
            .unwrap();
    assert_eq!(out.primitives.len(), 2);
    assert!(out.warnings[0].starts_with("a.rad:2:1: none.rad"), "{:?}", out.warnings);
    assert!(out.warnings[1].contains("cannot scale to nothing"), "{:?}", out.warnings);
}

#[test]
fn other_commands_are_left_to_the_resolver() {
    let error = flat(&[("a.rad", "# scene\n!touch pwned\n")]).unwrap_err().to_string();
    assert!(error.starts_with("a.rad:2:1: error: command not run: touch pwned"), "{error}");
    assert!(flat(&[("a.rad", "!cat b.rad > c.rad\n")]).is_err());
}

#[test]
fn arrays_are_bounded() {
    let array = |words: &str| flat(&[("a.rad", &format!("!xform {words} b.rad")), ("b.rad", "m sphere b 0 0 4 1 0 0 1")]);
    for words in ["-a 99999999", "-a 999999 -t 1 0 0 -a 999999"] {
        assert!(array(words).unwrap_err().to_string().contains("smaller array"), "{words}");
    }
    assert_eq!(array("-i 99999999 -t 1 0 0").unwrap().primitives[0].reals, [1e8, 0.0, 0.0, 1.0]);
    let out = array("-i 2000 -s 2").unwrap();
    assert_eq!((out.primitives.len(), out.warnings.len()), (0, 2));
    assert_eq!(array("-a 400 -t 3 0 0 -a 300 -t 0 3 0").unwrap().primitives.len(), 120_000);
    let bomb: Vec<_> = (0..20).map(|i| (format!("{i}.rad"), format!("!xform -a 100 {}.rad", i + 1))).collect();
    let mut files: Vec<(&str, &str)> = bomb.iter().map(|(n, t)| (n.as_str(), t.as_str())).collect();
    files.push(("20.rad", "m sphere b 0 0 4 1 0 0 1"));
    assert!(flat(&files).unwrap_err().to_string().contains("smaller arrays"));
}

#[test]
fn probes_move_with_their_surroundings() {
    let out = flat(&[
        ("a.rad", "!xform -t 1 0 0 -s 2 b.rad\n#@note kept\n"),
        ("b.rad", "m sphere b 0 0 4 1 0 0 1\n#@probe 1 2 .5 \"my sky\"\n# not one\n#@ nor this"),
    ])
    .unwrap();
    assert_eq!(out.to_string(), "m sphere b\n0\n0\n4 4 0 0 2\n\n#@probe 4 4 1 \"my sky\"\n#@note kept\n");
}

#[test]
fn boxes_have_the_corners_and_names_of_genbox() {
    // genbox m b 1 2 3 OPTIONS, recorded in part.
    let boxed = |options: &str| lines(&flat(&[("a.rad", &format!("!genbox m b 1 2 3 {options}"))]).unwrap());
    assert_eq!(boxed("").len(), 6);
    assert_eq!(boxed("")[0], "m polygon b.1540 0 0 12 1 0 0 1 0 3 0 0 3 0 0 0");
    assert_eq!(boxed("-i")[1], "m polygon b.4620 0 0 12 1 2 0 1 0 0 1 0 3 1 2 3");
    let bevelled = boxed("-b .1");
    assert_eq!((bevelled.len(), &bevelled[10][..]), (26, "m polygon b.TjiS 0 0 12 0.9 1.9 3 0.9 2 2.9 0.1 2 2.9 0.1 1.9 3"));
    let round = boxed("-r .1");
    assert_eq!((round.len(), &round[11][..]), (26, "m cylinder b.vz 0 0 7 0.9 1.9 0.1 0.9 1.9 2.9 0.1"));
    assert_eq!(round[24], "m sphere b.y 0 0 4 0.1 1.9 2.9 0.1");
}
