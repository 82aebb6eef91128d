//! The program anneal, driven as a user drives it, with a shell command in the place of a renderer.

#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;
use tempfile::TempDir;

const START: &str = "# the horse\nvoid metal horse\n0\n0\n5 0.50 .5 .5 0.5 0.1  # to be found\nhorse sphere s 0 0 4 0 0 0 1\n";

/// A quadratic in the material's numbers, 0.02 at .8 .6 .3 .9 .01.
const FAKE: &str = r#"awk '/^5 /{printf "%.17g\n", .02+($2-.8)^2+($3-.6)^2+($4-.3)^2+($5-.9)^2+($2-.8)*($5-.9)+10*($6-.01)^2}' $MATERIAL"#;
const TRUTH: [f64; 5] = [0.8, 0.6, 0.3, 0.9, 0.01];

/// A directory with START.rad in it.
fn directory() -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("start.rad"), START).unwrap();
    directory
}

fn command(directory: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_anneal"));
    command
        .current_dir(directory)
        .env("TMPDIR", directory)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

fn run(directory: &Path, arguments: &[&str]) -> Output {
    command(directory, arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// The real arguments in what was printed.
fn reals(printed: &str) -> Vec<f64> {
    let line = printed.lines().find(|line| line.starts_with("5 ")).unwrap();
    line.split_whitespace().skip(1).take(5).map(|word| word.parse().unwrap()).collect()
}

fn worst(found: &[f64]) -> f64 {
    found.iter().zip(TRUTH).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn the_file_of_a_candidate_is_one_word_wherever_it_is() {
    let directory = directory();
    let place = directory.path().join("a b's");
    fs::create_dir(&place).unwrap();
    for word in ["{}", "'{}'", "\"{}\""] {
        let exec = FAKE.replace("$MATERIAL", word);
        let done = command(directory.path(), &["--exec", &exec, "--steps", "4", "start.rad"]).env("TMPDIR", &place).output().unwrap();
        assert_eq!(text(&done.stderr).matches("error: ").count(), 0, "{word}: {}", text(&done.stderr));
    }
}

#[test]
fn noise_that_repeats_is_said() {
    let told = |exec: &str| text(&run(directory().path(), &["--exec", exec, "--steps", "400", "start.rad"]).stderr);
    let noisy = FAKE.replace(".02+", "1+.05*sin(2000*$2+1700*$3+2300*$4+1900*$5+5000*$6)+");
    let (smooth, noisy) = (told(FAKE), told(&noisy));
    assert!(!smooth.contains("warning"), "{smooth}");
    assert!(noisy.contains("warning: chi-squared jumps by 0.0") && noisy.contains("imgdiff --unbiased"), "{noisy}");
}

#[test]
fn an_answer_takes_the_place_of_the_one_before() {
    let directory = directory();
    let search = |exec: &str| run(directory.path(), &["--exec", exec, "--steps", "30", "-o", "start.rad", "start.rad"]);
    // Comments of the file's own stay, whatever they begin with.
    let start = fs::read_to_string(directory.path().join("start.rad")).unwrap();
    fs::write(directory.path().join("start.rad"), format!("# type of finish\n# red 3 coats\n{start}")).unwrap();
    let done = search("echo 4");
    assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
    let first = fs::read_to_string(directory.path().join("start.rad")).unwrap();
    assert!(
        first.contains("# red 0.50 ± 0.29: not determined\n") && first.matches("not determined: the chi-squareds").count() == 5,
        "{first}"
    );
    search(FAKE);
    let second = fs::read_to_string(directory.path().join("start.rad")).unwrap();
    assert!(
        second.matches("# chi2 ").count() == 1
            && !second.contains("not determined")
            && second.contains("\n# type of finish\n# red 3 coats\n# the horse\nvoid metal"),
        "{second}"
    );
}

#[test]
fn a_command_leads_to_the_material() {
    let directory = directory();
    let done = run(directory.path(), &["--exec", FAKE, "--steps", "150", "--log", "log.jsonl", "start.rad"]);
    let printed = text(&done.stdout);
    assert_eq!((done.status.code(), text(&done.stderr).as_str()), (Some(0), ""), "{printed}");
    assert!(worst(&reals(&printed)) < 1e-3, "{printed}");
    // Comments first, then the file as it was but for the numbers.
    assert!(printed.starts_with("# chi2 0.02"), "{printed}");
    let comments: Vec<&str> = printed.lines().take_while(|line| *line != "# the horse").collect();
    for (name, line) in ["red", "green", "blue", "spec", "rough"].iter().zip(&comments[1..]) {
        assert!(line.starts_with(&format!("# {name} ")) && line.contains(" ± "), "{line}");
    }
    let rest = &printed[printed.find("# the horse").unwrap()..];
    let numbers = reals(&printed).iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ");
    assert_eq!(rest, START.replace("0.50 .5 .5 0.5 0.1", &numbers));
    // The log has a line for each evaluation.
    let log = fs::read_to_string(directory.path().join("log.jsonl")).unwrap();
    let first: serde_json::Value = serde_json::from_str(log.lines().next().unwrap()).unwrap();
    assert_eq!((first["step"].as_u64(), first["phase"].as_str(), first["values"]["rough"].as_f64()), (Some(1), Some("survey"), Some(0.1)));
    assert!(log.lines().count() <= 150);
}

#[test]
fn the_same_command_gives_the_same_bytes_and_another_seed_another_way() {
    let directory = directory();
    let go = |seed: &str| run(directory.path(), &["--exec", FAKE, "--steps", "40", "--seed", seed, "start.rad"]).stdout;
    assert_eq!(go("1"), go("1"));
    assert_ne!(go("1"), go("2"));
}

#[test]
fn a_killed_search_goes_on_to_the_same_bytes() {
    let directory = directory();
    let lamp = directory.path().join("lamp");
    fs::write(&lamp, "on").unwrap();
    let slow = format!("sleep .01; test -e lamp || exit 1; {FAKE}");
    let arguments = |state: &'static str, log: &'static str| {
        ["--exec", &slow, "--steps", "150", "--state", state, "--log", log, "start.rad"].map(String::from)
    };
    let whole = run(directory.path(), &arguments("whole", "whole.jsonl").each_ref().map(String::as_str));
    let mut killed = 0;
    for _ in 0..2 {
        let mut child = command(directory.path(), &arguments("cut", "cut.jsonl").each_ref().map(String::as_str)).spawn().unwrap();
        sleep(Duration::from_millis(900));
        // SIGKILL: the program cannot do anything about it.
        child.kill().unwrap();
        killed += i32::from(child.wait().unwrap().code().is_none());
    }
    assert!(killed > 0, "the search was over before it could be killed");
    assert!(directory.path().join("cut").exists());
    let cut = run(directory.path(), &arguments("cut", "cut.jsonl").each_ref().map(String::as_str));
    assert_eq!(text(&cut.stdout), text(&whole.stdout));
    for (a, b) in [("whole", "cut"), ("whole.jsonl", "cut.jsonl")] {
        assert_eq!(fs::read(directory.path().join(a)).unwrap(), fs::read(directory.path().join(b)).unwrap(), "{a}");
    }
    // A finished search is not done again; with more steps it goes on.
    fs::remove_file(lamp).unwrap();
    let again = run(directory.path(), &arguments("cut", "cut.jsonl").each_ref().map(String::as_str));
    assert_eq!(text(&again.stdout), text(&whole.stdout), "{}", text(&again.stderr));
}

#[test]
fn a_state_is_not_taken_for_another_search() {
    let directory = directory();
    let first = run(directory.path(), &["--exec", FAKE, "--steps", "20", "--state", "s", "start.rad"]);
    assert_eq!(first.status.code(), Some(0));
    let other = run(directory.path(), &["--exec", FAKE, "--steps", "20", "--state", "s", "--fix", "rough", "start.rad"]);
    assert_eq!(other.status.code(), Some(2));
    assert!(text(&other.stderr).contains("s: it keeps a search with other options; remove it"), "{}", text(&other.stderr));
    let other = run(directory.path(), &["--exec", "echo 77", "--steps", "20", "--state", "s", "start.rad"]);
    assert!(text(&other.stderr).contains("another command"), "{}", text(&other.stderr));
    fs::write(directory.path().join("other.rad"), START.replace(".5", ".6")).unwrap();
    let other = run(directory.path(), &["--exec", FAKE, "--steps", "20", "--state", "s", "other.rad"]);
    assert!(text(&other.stderr).contains("another start file"), "{}", text(&other.stderr));
    fs::write(directory.path().join("s"), "{}").unwrap();
    let damaged = run(directory.path(), &["best", "s"]);
    assert_eq!(damaged.status.code(), Some(2));
    assert!(text(&damaged.stderr).contains("not a search that anneal keeps"), "{}", text(&damaged.stderr));
}

#[test]
fn step_by_step_is_the_same_search() {
    let directory = directory();
    let whole = run(directory.path(), &["--exec", FAKE, "--steps", "30", "start.rad"]);
    let mut rounds = 0;
    let last = loop {
        let mut arguments = vec!["propose", "state"];
        if rounds == 0 {
            arguments.extend(["start.rad", "--steps", "30"]);
        }
        let next = run(directory.path(), &arguments);
        if next.status.code() == Some(1) {
            break next;
        }
        assert_eq!(next.status.code(), Some(0), "{}", text(&next.stderr));
        fs::write(directory.path().join("next.rad"), &next.stdout).unwrap();
        let judge = format!("MATERIAL=next.rad; {FAKE}");
        let told = if rounds % 2 == 0 {
            let chi2 = Command::new("sh").current_dir(directory.path()).args(["-c", &judge]).output().unwrap();
            run(directory.path(), &["tell", "state", text(&chi2.stdout).trim()])
        } else {
            let tell = format!("{{ {judge}; }} | '{}' tell state", env!("CARGO_BIN_EXE_anneal"));
            Command::new("sh").current_dir(directory.path()).args(["-c", &tell]).output().unwrap()
        };
        assert_eq!((told.status.code(), told.stderr.len()), (Some(0), 0), "{}", text(&told.stderr));
        // A scheduler may try again what has succeeded.
        let again = run(directory.path(), &["tell", "state", "0"]);
        let said = text(&again.stderr);
        rounds += 1;
        assert!(
            again.status.code() == Some(2) && said.contains(if rounds < 30 { "has been told; get a candidate" } else { "is over" }),
            "{said}"
        );
    };
    assert_eq!((rounds, text(&last.stdout)), (30, text(&whole.stdout)));
    assert_eq!(run(directory.path(), &["best", "state"]).stdout, whole.stdout);
    let over = run(directory.path(), &["tell", "state", "-0.5"]);
    assert_eq!(over.status.code(), Some(2));
    assert!(text(&over.stderr).contains("the search is over"), "{}", text(&over.stderr));
}

#[test]
fn a_budget_that_ends_before_the_tolerance_is_status_1() {
    let directory = directory();
    let go = |steps: &str| run(directory.path(), &["--exec", FAKE, "--steps", steps, "--tolerance", "1e-3", "start.rad"]);
    let (short, long) = (go("30"), go("300"));
    assert_eq!((short.status.code(), long.status.code()), (Some(1), Some(0)));
    assert!(text(&short.stderr).contains("give it more --steps or --time"), "{}", text(&short.stderr));
    assert_eq!(text(&long.stderr), "");
    assert!(worst(&reals(&text(&short.stdout))) < 1.0);
    assert!(worst(&reals(&text(&long.stdout))) < 1e-3);
}

#[test]
fn an_interrupted_search_writes_the_best_so_far() {
    let slow = format!("sleep .02; {FAKE}");
    // As Ctrl-C does it, and as `timeout` does: it signals the program and its process group.
    for line in ["kill -INT $1", "kill -TERM $1; kill -TERM $1"] {
        let directory = directory();
        let child = command(directory.path(), &["--exec", &slow, "--steps", "5000", "--state", "s", "start.rad"]).spawn().unwrap();
        sleep(Duration::from_millis(700));
        let pid = child.id().to_string();
        assert!(Command::new("sh").args(["-c", line, "sh", &pid]).status().unwrap().success());
        let done = child.wait_with_output().unwrap();
        assert_eq!(done.status.code(), Some(1), "{}", text(&done.stderr));
        assert_eq!(reals(&text(&done.stdout)).len(), 5);
        assert!(text(&done.stderr).contains("interrupted after"), "{}", text(&done.stderr));
        assert!(directory.path().join("s").exists());
    }
}

#[test]
fn a_time_limit_is_kept() {
    let directory = directory();
    let done = run(directory.path(), &["--exec", &format!("sleep .02; {FAKE}"), "--time", "1.5", "start.rad"]);
    assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
    // No more evaluations than there is time for, however fast the machine is.
    let evaluations = text(&done.stdout).split("after ").nth(1).and_then(|rest| rest.split(' ').next()?.parse::<u32>().ok()).unwrap();
    assert!((2..=80).contains(&evaluations), "{evaluations}");
    let few = run(directory.path(), &["--exec", FAKE, "--time", "1000", "--steps", "9", "start.rad"]);
    assert!(text(&few.stdout).contains("after 9 evaluations"));
}

#[test]
fn a_closed_pipe_ends_it_quietly() {
    let directory = directory();
    let line = format!(
        "'{}' --exec '{}' --steps 5 --report page start.rad | true; echo ${{PIPESTATUS[0]}}",
        env!("CARGO_BIN_EXE_anneal"),
        "sleep .05; echo 1"
    );
    let done = Command::new("bash").current_dir(directory.path()).args(["-c", &line]).output().unwrap();
    assert_eq!((text(&done.stdout).as_str(), text(&done.stderr).as_str()), ("0\n", ""));
    // The page is not lost.
    assert!(fs::read_to_string(directory.path().join("page")).unwrap().ends_with("</html>\n"));
}

#[test]
fn trouble_is_one_line_and_status_2() {
    let directory = directory();
    let trouble = |arguments: &[&str]| {
        let done = run(directory.path(), arguments);
        let message = text(&done.stderr);
        assert_eq!((done.status.code(), done.stdout.len()), (Some(2), 0), "{arguments:?} {message}");
        assert!(message.starts_with("anneal: "), "{message}");
        message
    };
    assert!(trouble(&["start.rad"]).contains("or --exec"));
    assert!(trouble(&[]).contains("START.rad"));
    assert!(trouble(&["--exec", "echo 1", "absent.rad"]).contains("absent.rad: no such file"));
    assert!(trouble(&["--exec", "echo no light >&2; exit 4", "start.rad"]).contains("exit status: 4; it said: no light"));
    assert!(trouble(&["--exec", "true", "start.rad"]).contains("printed nothing"));
    assert!(trouble(&["--exec", "echo nan", "start.rad"]).contains("the chi-squared of the start is NaN"));
    assert!(
        trouble(&["--exec", FAKE, "--fix", "ior", "start.rad"])
            .starts_with("anneal: start.rad:2:6: error: metal `horse` has no parameter `ior`")
    );
    let said = trouble(&["--exec", FAKE, "--param", "red=2", "start.rad"]);
    assert!(said.contains("not three numbers; write NAME=START:LOW:HIGH") && said.matches("error: ").count() == 1, "{said}");
    assert!(trouble(&["--exec", FAKE, "--steps", "0", "start.rad"]).contains("greater than 0"));
    assert!(trouble(&["propose", "absent"]).contains("absent: no such file; begin with anneal propose absent START.rad"));
    assert!(trouble(&["tell", "absent", "1"]).contains("absent: no such file"));
    fs::write(directory.path().join("broken.rad"), "void metal m\n0\n0\n5 .5 .5 x .5 .1\n").unwrap();
    assert!(trouble(&["--exec", FAKE, "broken.rad"]).starts_with("anneal: broken.rad:4:9: error: "));
    assert!(
        trouble(&["--exec", FAKE, "--state", "no/such/state", "--steps", "3", "start.rad"])
            .contains("no/such/state: no such file or directory")
    );
}

#[test]
fn a_command_that_does_not_look_at_the_material_is_warned_of() {
    let directory = directory();
    let done = run(directory.path(), &["--exec", "echo 1", "--steps", "30", "start.rad"]);
    assert_eq!(done.status.code(), Some(0));
    assert!(text(&done.stderr).contains("does the command use $MATERIAL?"), "{}", text(&done.stderr));
}

#[test]
fn what_a_noisy_judge_leaves_open_is_not_blamed_on_the_light() {
    let directory = directory();
    // Noise that is a hundred times as large as what it hides.
    let judge = r#"awk '/^5 /{print 2 + .01 * $2 + sin(1e6 * ($2 + $3 + $4 + $5 + $6))}' $MATERIAL"#;
    let done = run(directory.path(), &["--exec", judge, "--steps", "60", "start.rad"]);
    let said = text(&done.stderr);
    assert!(said.contains("is not determined: the chi-squareds that were seen are too few, or too noisy, or say little of it; "), "{said}");
    assert!(!said.contains("this picture and this light"), "{said}");
}

#[test]
fn stages_ties_and_bounds_reach_the_command() {
    let directory = directory();
    // The coarse stage is the same in other units.
    let staged = format!("test -n \"$STAGE\" || exit 9; {FAKE} | awk -v s=$STAGE '{{printf \"%.17g\\n\", $1*s*s}}'");
    let arguments =
        ["--exec", &staged, "--steps", "200", "--stages", "2", "--param", "spec=.9:.5:1", "--fix", "spec", "--log", "log", "start.rad"];
    let done = run(directory.path(), &arguments);
    assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
    let found = reals(&text(&done.stdout));
    assert!(found[3] == 0.9 && worst(&found) < 1e-3, "{found:?}");
    let log = fs::read_to_string(directory.path().join("log")).unwrap();
    assert!(log.contains("\"stage\":1") && log.contains("\"stage\":2") && !log.contains("spec"));

    let done = run(directory.path(), &["--exec", FAKE, "--steps", "100", "--tie", "red=green=blue", "start.rad"]);
    let found = reals(&text(&done.stdout));
    assert!(found[0] == found[1] && found[1] == found[2]);
}
