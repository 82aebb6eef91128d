//! Command lines simple enough to need no shell: words, quotes, pipes and input from a file.

/// One program of a pipeline.
#[derive(Debug, Default, PartialEq)]
pub struct Stage {
    /// The program and its arguments.
    pub words: Vec<String>,
    /// The file that it reads as standard input, if one is named.
    pub input: Option<String>,
}

/// The pipeline that a shell would run for `command`; `None` if it takes a real shell to tell (variables, patterns of
/// file names, several commands, output to files).
pub fn pipeline(command: &str) -> Option<Vec<Stage>> {
    let mut stages = vec![Stage::default()];
    let (mut word, mut input) = (None::<String>, false);
    let mut rest = command.chars().peekable();
    loop {
        let c = rest.next();
        if matches!(c, None | Some(' ' | '\t' | '\n' | '|' | '<')) {
            let stage = stages.last_mut()?;
            match word.take() {
                Some(text) if std::mem::take(&mut input) => stage.input = Some(text),
                Some(text) => stage.words.push(text),
                None => {}
            }
        }
        match c {
            None => break,
            Some(' ' | '\t') => {}
            // What stands on a second line is a second command.
            Some('\n') if rest.clone().all(char::is_whitespace) => break,
            Some('|') if !input && rest.peek() != Some(&'|') => stages.push(Stage::default()),
            Some('<') if !input && rest.peek() != Some(&'<') => input = true,
            Some('#') if word.is_none() => while rest.next_if(|&c| c != '\n').is_some() {},
            Some('\'') => {
                let word = word.get_or_insert_default();
                loop {
                    match rest.next()? {
                        '\'' => break,
                        c => word.push(c),
                    }
                }
            }
            Some('"') => {
                let word = word.get_or_insert_default();
                loop {
                    match rest.next()? {
                        '"' => break,
                        '$' | '`' => return None,
                        '\\' => match rest.next()? {
                            '\n' => {}
                            c @ ('"' | '\\' | '$' | '`') => word.push(c),
                            c => word.extend(['\\', c]),
                        },
                        c => word.push(c),
                    }
                }
            }
            Some('\\') => match rest.next()? {
                '\n' => {}
                c => word.get_or_insert_default().push(c),
            },
            Some('\n' | '|' | '<' | '>' | ';' | '&' | '(' | ')' | '$' | '`' | '*' | '?' | '[') => return None,
            Some('~' | '{' | '!') if word.is_none() => return None,
            Some(c) => word.get_or_insert_default().push(c),
        }
    }
    let complete = !input && stages.iter().all(|s| !s.words.is_empty() && !s.words[0].contains('='));
    complete.then_some(stages)
}

/// The word in quotes that a shell would take off, if it needs them.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-+._/:,%@=".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(command: &str) -> Option<Vec<Vec<String>>> {
        pipeline(command).map(|stages| stages.into_iter().map(|s| s.words).collect())
    }

    #[test]
    fn words_are_split_as_a_shell_splits_them() {
        // for w in COMMAND; do echo "[$w]"; done, in a POSIX shell.
        let split = words(" genbox 'a b' c\\ d \"e\\\"f\\g\" ''\\\n 1|xform -t 1 0 0 # turn it").unwrap();
        assert_eq!(split, [vec!["genbox", "a b", "c d", "e\"f\\g", "", "1"], vec!["xform", "-t", "1", "0", "0"]]);
        assert_eq!(words("xform objects\\box.rad").unwrap(), [["xform", "objectsbox.rad"]]);
        assert_eq!(pipeline("xform -s 2 < a.rad").unwrap()[0].input.as_deref(), Some("a.rad"));
    }

    #[test]
    fn what_needs_a_shell_is_left_to_one() {
        for command in [
            "a; b",
            "a && b",
            "a || b",
            "a > b",
            "cat *.rad",
            "echo $HOME",
            "echo `id`",
            "echo \"$(id)\"",
            "cat ~/a",
            "",
            "a |",
            "a 'b",
            "A=1 b",
            "a\nb",
            "a <<b",
            "! a",
        ] {
            assert_eq!(pipeline(command), None, "{command}");
        }
    }

    #[test]
    fn quoting_is_undone_by_splitting() {
        for word in ["a", "a b", "it's", "", "*", "-t"] {
            assert_eq!(words(&format!("x {}", quoted(word))).unwrap()[0][1], word);
        }
    }
}
