//! The page that `anneal --report` writes: well-formed, whole in itself, with all that was found.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// What is unknown: a name that would break a page that did not escape it.
const START: &str = "void plastic \"<i>&co\" 0 0 5 .5 .5 .5 .05 .1\n";
const SCENE: &str = "void brightfunc wave 2 1+.8*sin(9*Dx)*sin(7*Dz+Dy) . 0 0\nwave glow sky 0 0 4 1 1 1 0\nsky source sky 0 0 4 0 0 1 360\n\
                     \"<i>&co\" sphere s 0 0 4 0 0 0 1\n";

fn run(program: &str, directory: &Path, arguments: &[&str]) -> Output {
    Command::new(program).current_dir(directory).args(arguments).output().unwrap()
}

/// The page of a recovery from a picture of `SCENE` as one of `scene`, and what was printed.
fn recovered(scene: &str) -> (String, String) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    fs::write(path.join("start.rad"), START).unwrap();
    fs::write(path.join("true.rad"), START.replace(".5 .5 .5 .05 .1", ".6 .4 .2 .08 .15")).unwrap();
    fs::write(path.join("scene.rad"), SCENE).unwrap();
    let view = "-vp 0 -5 0 -vd 0 1 0 -vh 30 -vv 30 -x 24 -y 24 --spp 200 -o target.hdr true.rad scene.rad";
    assert!(run(env!("CARGO_BIN_EXE_rtrace-rs"), path, &view.split(' ').collect::<Vec<_>>()).status.success());
    fs::write(path.join("scene.rad"), scene).unwrap();
    let arguments = ["--scene", "scene.rad", "--target", "target.hdr", "--report", "page.html", "start.rad"];
    let done = run(env!("CARGO_BIN_EXE_anneal"), path, &arguments);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    (fs::read_to_string(path.join("page.html")).unwrap(), String::from_utf8(done.stdout).unwrap())
}

/// The tags of a page, each with its name and attributes. Fails unless every element ends, in order, and every attribute is quoted.
fn tags(page: &str) -> Vec<(String, Vec<(String, String)>)> {
    let (mut open, mut found): (Vec<String>, Vec<_>) = (vec![], vec![]);
    let mut rest = page.strip_prefix("<!DOCTYPE html>").expect("a doctype");
    while let Some(at) = rest.find('<') {
        let text = &rest[..at];
        assert!(!text.contains('>') || open.last().is_some_and(|o| o == "style"), "a bare > in {text}");
        let end = at + rest[at..].find('>').expect("an end of the tag");
        let tag = &rest[at + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name));
            continue;
        }
        let tag_body = tag.trim_end_matches('/');
        let (name, mut words) = tag_body.split_once([' ', '\n']).unwrap_or((tag_body, ""));
        assert!(name.chars().all(|c| c.is_ascii_alphanumeric()), "{tag}");
        let mut attributes = vec![];
        while let Some((key, value)) = words.trim_start().split_once("=\"") {
            let (value, after) = value.split_once('"').expect("a closing quote");
            attributes.push((key.to_string(), value.to_string()));
            words = after;
        }
        assert_eq!(words.trim(), "", "{tag}");
        found.push((name.to_string(), attributes));
        if !tag.ends_with('/') {
            open.push(name.to_string());
        }
    }
    assert!(open.is_empty(), "{open:?} not closed");
    found
}

/// Fails if a page would fetch anything.
fn whole_in_itself(page: &str) {
    for (name, attributes) in tags(page) {
        assert!(!["script", "link", "iframe", "object", "embed", "base", "form", "use", "image"].contains(&name.as_str()), "{name}");
        for (key, value) in attributes {
            assert!(!key.starts_with("on") && !["href", "srcset", "xlink:href", "action", "data"].contains(&key.as_str()), "{key}={value}");
            assert!(key != "src" || value.starts_with("data:image/png;base64,"), "{value}");
        }
    }
    let outside_pictures: String = page.split("data:image/png;base64,").map(|s| s.split_once('"').map_or(s, |(_, after)| after)).collect();
    ["http:", "https:", "//", "url(", "@import"].iter().for_each(|word| assert!(!outside_pictures.contains(word), "{word}"));
}

#[test]
fn the_page_of_a_recovery_is_whole_and_tells_all() {
    let (page, printed) = recovered(SCENE);
    whole_in_itself(&page);
    // All digits that were printed, of values and of chi-squared.
    for line in printed.lines().take_while(|line| *line != "# end of what anneal says") {
        let number = line.split_whitespace().nth(2).unwrap();
        assert!(page.contains(&format!(">{number}<")), "{line}");
    }
    for text in
        ["red", "green", "blue", "spec", "rough", "absorbed", "Rendered with what was found", "Their difference", "--report page.html"]
    {
        assert!(page.contains(text), "{text}");
    }
    // Two spheres, target, rendering, difference, the scale.
    let pictures: Vec<_> = tags(&page).into_iter().filter(|t| t.0 == "img").collect();
    assert_eq!(pictures.len(), 6);
    assert!(page.contains("&lt;i&gt;&amp;co") && !page.contains("<i>&co"));
    // Both kinds of light, and paper.
    assert!(page.contains("prefers-color-scheme: dark") && page.contains("@media print"));
}

#[test]
fn all_that_is_doubted_is_on_the_page() {
    let (page, printed) = recovered(&SCENE.replace("1 1 1 0", "2 2 2 0"));
    let doubts: Vec<&str> = printed.lines().filter_map(|line| line.strip_prefix("# warning: ")).collect();
    assert!(
        doubts.iter().any(|doubt| doubt.starts_with("around the unknown the picture is 0.5 times as bright as the scene is")),
        "{printed}"
    );
    for doubt in doubts {
        assert!(page.contains(&format!("<li>{doubt}</li>")), "{doubt}");
    }
}

#[test]
fn the_page_of_a_search_with_a_command_needs_no_scene() {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("start.rad"), "void metal m\n0\n0\n5 .5 .5 .5 .5 .1\n").unwrap();
    let fake = r#"awk '/^5 /{print .02+($2-.8)^2+($3-.6)^2+($4-1)^2+($5-.9)^2+($2-.8)*($5-.9)+10*($6-.01)^2}' $MATERIAL"#;
    let arguments = ["--exec", fake, "--steps", "120", "--report", "page.html", "start.rad"];
    let done = run(env!("CARGO_BIN_EXE_anneal"), directory.path(), &arguments);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let page = fs::read_to_string(directory.path().join("page.html")).unwrap();
    whole_in_itself(&page);
    let doubt = "blue is at its upper bound 1; if it may lie beyond";
    assert!(page.contains(doubt) && page.contains("evaluation") && !page.contains("<img"), "{page}");
    assert!(page.contains("awk &#39;/^5 /{print"));
}

#[test]
fn a_page_is_written_whole_or_not_at_all() {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("start.rad"), "void metal m\n0\n0\n5 .5 .5 .5 .5 .1\n").unwrap();
    fs::write(directory.path().join("page.html"), "as it was").unwrap();
    let done = run(env!("CARGO_BIN_EXE_anneal"), directory.path(), &["--exec", "false", "--report", "page.html", "start.rad"]);
    assert_eq!(done.status.code(), Some(2));
    assert_eq!(fs::read_to_string(directory.path().join("page.html")).unwrap(), "as it was");
    let done =
        run(env!("CARGO_BIN_EXE_anneal"), directory.path(), &["--exec", "touch begun; echo 1", "--report", "no/page.html", "start.rad"]);
    assert_eq!(done.status.code(), Some(2));
    let message = String::from_utf8(done.stderr).unwrap();
    assert!(message.contains("anneal: error: no/page.html: no such file or directory"), "{message}");
    // That is said before anything is searched for.
    assert!(done.stdout.is_empty() && !directory.path().join("begun").exists());
}
