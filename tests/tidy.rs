//! The house is tidy: the map in `lib/lib.rs` is complete, rooms use only rooms above them, crates stay at home, files stay short, what the README and the manual show is there.

use std::collections::BTreeMap;
use std::fs::{read_dir, read_to_string};
use std::path::{Path, PathBuf};

/// The most lines of a file, and of a program.
const LONGEST: usize = 500;
const LONGEST_PROGRAM: usize = 110;

/// A line of the map.
struct Room {
    name: String,
    crates: Vec<String>,
}

/// The map, from the top.
fn map() -> Vec<Room> {
    let text = read(&root().join("lib/lib.rs"));
    let rows = text.lines().filter_map(|line| line.strip_prefix("//! | [`"));
    rows.map(|row| {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        assert!(cells.len() == 4 && !cells[1].is_empty(), "a room has a name, a question and crates: {row}");
        let crates = cells[2].split(',').map(str::trim).filter(|c| !c.is_empty());
        Room { name: cells[0].trim_end_matches("`]").into(), crates: crates.map(Into::into).collect() }
    })
    .collect()
}

#[test]
fn the_map_names_every_room_once() {
    let text = read(&root().join("lib/lib.rs"));
    let modules = text.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    let mut modules: Vec<&str> = modules.collect();
    let map = map();
    let mut rooms: Vec<&str> = map.iter().map(|room| room.name.as_str()).collect();
    modules.sort();
    rooms.sort();
    assert_eq!(modules, rooms);
}

#[test]
fn rooms_use_only_rooms_above_them() {
    let map = map();
    let floor = |name: &str| map.iter().position(|room| room.name == name);
    let mut wrong = Vec::new();
    for (path, room, code) in library() {
        let Some(here) = floor(&room) else { continue };
        for (number, line) in code.iter().enumerate() {
            for used in after(line, "crate::") {
                if floor(used).is_none_or(|there| there > here) {
                    wrong.push(format!("{}:{}: {room} uses {used}, which does not stand above it", path.display(), number + 1));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn crates_stay_at_home() {
    let map = map();
    let crates = dependencies();
    let mut wrong = Vec::new();
    let mut homes: BTreeMap<(String, String), bool> =
        map.into_iter().flat_map(|room| room.crates.into_iter().map(move |c| ((room.name.clone(), c), false))).collect();
    for (path, room, code) in library() {
        for (number, line) in code.iter().enumerate() {
            for name in crates.iter().filter(|name| line.match_indices(&format!("{name}::")).any(|(at, _)| begins(line, at))) {
                match homes.get_mut(&(room.clone(), name.clone())) {
                    Some(seen) => *seen = true,
                    None => wrong.push(format!("{}:{}: {name} is not at home in {room}", path.display(), number + 1)),
                }
            }
        }
    }
    wrong.extend(homes.iter().filter(|(_, seen)| !**seen).map(|((room, name), _)| format!("the map says {room} uses {name}; it does not")));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn files_are_short_and_say_what_they_answer() {
    let mut wrong = Vec::new();
    let folders = [("lib", LONGEST), ("src/bin", LONGEST_PROGRAM), ("tests", LONGEST), ("examples", LONGEST)];
    for (path, most) in folders.iter().flat_map(|(folder, most)| sources(&root().join(folder)).into_iter().map(|p| (p, *most))) {
        let text = read(&path);
        let lines = text.lines().count();
        if lines > most {
            wrong.push(format!("{}: {lines} lines, more than {most}", path.display()));
        }
        if !text.starts_with("//! ") && !path.ends_with("tests.rs") {
            wrong.push(format!("{}: no first sentence", path.display()));
        }
        if text.contains(concat!("todo", "!(")) || text.contains(concat!("unimplemented", "!(")) {
            wrong.push(format!("{}: not finished", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn no_test_is_left_out() {
    let suite = read(&root().join("tests/suite.rs"));
    for entry in read_dir(root().join("tests")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let is_used = path.is_dir() || name == "suite" || suite.contains(&format!("\nmod {name};"));
        assert!(is_used, "tests/suite.rs does not name {name}");
    }
}

#[test]
fn what_the_readme_shows_is_there() {
    let slug = |title: &str| title.to_lowercase().replace(|c: char| !(c.is_alphanumeric() || " -".contains(c)), "").replace(' ', "-");
    for page in ["README.md", "MANUAL.md"] {
        let text = read(&root().join(page));
        let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next()).filter(|link| !link.contains(':'));
        for link in links {
            let (file, section) = link.split_once('#').unwrap_or((link, ""));
            let file = root().join(if file.is_empty() { page } else { file });
            assert!(file.exists(), "{page}: {link}");
            let titles =
                |text: &str| text.lines().any(|line| line.starts_with('#') && slug(line.trim_start_matches(['#', ' '])) == section);
            assert!(section.is_empty() || titles(&read(&file)), "{page}: {link}");
        }
    }
}

/// The files of the library: path, room, and the lines of code without comments and tests.
fn library() -> Vec<(PathBuf, String, Vec<String>)> {
    let lib = root().join("lib");
    let files = sources(&lib).into_iter().filter(|path| !path.ends_with("lib.rs") && !path.ends_with("tests.rs"));
    files
        .map(|path| {
            let inside = path.strip_prefix(&lib).unwrap().to_path_buf();
            let room = inside.components().next().unwrap().as_os_str().to_string_lossy().trim_end_matches(".rs").to_string();
            let text = read(&path);
            let code = text.lines().take_while(|line| *line != "mod tests {");
            let code = code.map(|line| line.split("//").next().unwrap_or_default().to_string()).collect();
            (inside, room, code)
        })
        .collect()
}

/// The dependencies in Cargo.toml, as code spells them.
fn dependencies() -> Vec<String> {
    let text = read(&root().join("Cargo.toml"));
    let section = text.split("\n[dependencies]\n").nth(1).expect("a section [dependencies]");
    let lines = section.lines().take_while(|line| !line.starts_with('['));
    lines.filter_map(|line| line.split_once('=')).map(|(name, _)| name.trim().replace('-', "_")).collect()
}

/// The words that stand right after `path` in a line.
fn after<'a>(line: &'a str, path: &'a str) -> impl Iterator<Item = &'a str> {
    line.match_indices(path).filter(|(at, _)| begins(line, *at)).map(move |(at, _)| {
        let rest = &line[at + path.len()..];
        &rest[..rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len())]
    })
}

/// Whether a word begins there, and is not the end of a longer path.
fn begins(line: &str, at: usize) -> bool {
    !line[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':' || c == '$')
}

/// The Rust files in a folder and below it.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = read_dir(folder) else { return vec![] };
    let mut found = Vec::new();
    for path in entries.map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
