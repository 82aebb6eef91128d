//! RADIANCE's spellings of options, rewritten to the long options that clap knows.
//!
//! `-ab 2` becomes `--ab 2`; `-u+`, `-u-` and bare `-u` become `--u=true` or `--u=false`; `-ffc` becomes `--format=fc` and
//! `-ovn` `--specifiers=vn`; every view option goes, word for word, to one option that keeps their order; `@FILE` and `$NAME`
//! are replaced by their words. Only names that the program declares are rewritten. The values of an option are passed on as
//! they are, whatever they begin with.

use crate::error::{Error, Result};
use crate::view;
use clap::builder::ValueRange;
use clap::{Arg, ArgAction, Command};
use std::any::TypeId;
use std::collections::{HashMap, VecDeque};
use std::ffi::OsString;

/// The long option that receives the words of all view options.
pub const VIEW_WORDS: &str = "view-words";

/// Options whose value is attached to the letter: the letter, the long option it stands for, the letters the value may have.
/// With a blank (`-o FILE`, `-f FILE`) the same letter is another option.
const ATTACHED: [(char, &str, &str); 2] = [('f', "format", "afdc"), ('o', "specifiers", "odvVwWlLcpnNsmMrRxX~tT")];

/// RADIANCE's names of more than two letters.
const WORDS: [&str; 4] = ["defaults", "pRGB", "pXYZ", "features"];

/// RADIANCE's switches that are on when nothing is said.
const ON: [&str; 4] = ["bv", "dv", "h", "w"];

/// Options that cannot change the result, by clap's names for them.
const NO_TRACE: [&str; 8] = ["threads", "quiet", "progress", "output", "variance", "aov", "z", "explain"];

/// `@FILE` and `$NAME` that one command line may hold, counting those inside others.
const MAX_EXPANSIONS: usize = 64;

/// A command line after rewriting.
pub struct Rewritten {
    /// What clap shall see, the program's name first.
    pub words: Vec<OsString>,
    /// What was typed, without the options that cannot change the result, on one line.
    pub trail: String,
}

/// Whether a long name is RADIANCE's, to be typed and shown with one dash.
pub fn is_radiance(name: &str) -> bool {
    name.len() <= 2 || WORDS.contains(&name)
}

/// The letter that a long option stands for, if its value is attached to one.
pub fn attached(name: &str) -> Option<char> {
    ATTACHED.iter().find(|(_, long, _)| *long == name).map(|(letter, ..)| *letter)
}

/// Whether an option is one of RADIANCE's switches: a long name of RADIANCE's with one Boolean value.
pub fn is_switch(argument: &Arg) -> bool {
    argument.get_long().is_some_and(is_radiance)
        && matches!(argument.get_action(), ArgAction::Set)
        && argument.get_value_parser().type_id() == TypeId::of::<bool>()
}

/// Whether a word is a negative number: no option is one.
fn is_number(word: &str) -> bool {
    word[1..].starts_with(|c: char| c == '.' || c.is_ascii_digit())
}

/// Rewrites `words` (the program's name first) for `command`. `read` gives the text of an `@FILE`.
pub fn rewrite(command: &Command, words: Vec<OsString>, read: &dyn Fn(&str) -> Result<String>) -> Result<Rewritten> {
    let mut words = VecDeque::from(words);
    let name = words.pop_front().unwrap_or_default();
    let trail = vec![std::path::Path::new(&name).file_name().unwrap_or_default().to_owned()];
    let mut rewriter = Rewriter { command, words, out: vec![name], trail, switches: HashMap::new() };
    rewriter.run(read)?;
    Ok(Rewritten { words: rewriter.out, trail: one_line(&rewriter.trail) })
}

/// A rewriting under way.
struct Rewriter<'a> {
    command: &'a Command,
    /// What is still to be read.
    words: VecDeque<OsString>,
    out: Vec<OsString>,
    trail: Vec<OsString>,
    /// What each switch was last set to.
    switches: HashMap<String, bool>,
}

impl Rewriter<'_> {
    fn run(&mut self, read: &dyn Fn(&str) -> Result<String>) -> Result<()> {
        let mut expansions = 0;
        while let Some(word) = self.words.pop_front() {
            let text = word.to_str().unwrap_or_default();
            let (file, variable) = (text.strip_prefix('@'), text.strip_prefix('$'));
            if let Some(name) = file.or(variable).filter(|name| !name.is_empty()) {
                expansions += 1;
                if expansions > MAX_EXPANSIONS {
                    return Err(Error::new(format!(
                        "{text}: more than {MAX_EXPANSIONS} words beginning with @ or $ (does one name itself?)"
                    )));
                }
                let found = match file {
                    Some(_) => read(name)?,
                    None => std::env::var(name).map_err(|_| Error::new(format!("{text}: no such environment variable")))?,
                };
                for word in found.split_whitespace().rev() {
                    self.words.push_front(word.into());
                }
            } else if text == "--" {
                self.out.push(word);
                self.out.extend(self.words.drain(..).inspect(|word| self.trail.push(word.clone())));
            } else if text.len() > 1 && text.starts_with('-') && !is_number(text) {
                self.option(text)?;
            } else {
                self.trail.push(word.clone());
                self.out.push(word);
            }
        }
        Ok(())
    }

    /// Rewrites one option, which begins with a dash, and takes its values.
    fn option(&mut self, word: &str) -> Result<()> {
        let name = word.strip_prefix("--").unwrap_or(&word[1..]);
        let long = word.starts_with("--");
        if long && name.contains('=') {
            let traced = self.find(|a| a.get_long() == name.split('=').next()).is_none_or(leaves_trace);
            return self.pass(word, word.into(), 0, traced);
        }

        // View options keep their order among themselves, and a file among them its place.
        if self.find(|a| a.get_long() == Some(VIEW_WORDS)).is_some()
            && let Some(count) = view::option_values(name)
        {
            if self.words.len() < count {
                return Err(Error::new(format!("-{name} takes {count} value{}", if count == 1 { "" } else { "s" })));
            }
            let values: Vec<_> = self.words.drain(..count).collect();
            for part in std::iter::once(OsString::from(format!("-{name}"))).chain(values) {
                self.trail.push(part.clone());
                self.out.extend([format!("--{VIEW_WORDS}").into(), part]);
            }
            return Ok(());
        }

        // An option by its whole name.
        if let Some(argument) =
            self.find(|a| a.get_long() == Some(name) && (long || is_radiance(name) || ["help", "version"].contains(&name)))
        {
            if is_switch(argument) {
                let value = !self.value(name);
                return self.switch(word, name, value);
            }
            let (count, traced) = (values_of(argument), leaves_trace(argument));
            return self.pass(word, format!("--{name}").into(), count, traced);
        }
        if long {
            return self.pass(word, word.into(), 0, true);
        }
        if let Some(argument) = self.find(|a| name.len() == 1 && a.get_short() == name.chars().next()) {
            let (count, traced) = (values_of(argument), leaves_trace(argument));
            return self.pass(word, word.into(), count, traced);
        }

        // A switch with its new state, a letter with its value.
        if let Some(value) = name.strip_suffix(['+', '1']).map(|n| (n, true)).or(name.strip_suffix(['-', '0']).map(|n| (n, false)))
            && self.find(|a| a.get_long() == Some(value.0) && is_switch(a)).is_some()
        {
            return self.switch(word, value.0, value.1);
        }
        for (letter, option, letters) in ATTACHED {
            let Some(value) = name.strip_prefix(letter) else { continue };
            if self.find(|a| a.get_long() == Some(option)).is_some() && value.chars().all(|c| letters.contains(c)) {
                return self.pass(word, format!("--{option}={value}").into(), 0, true);
            }
            if self.find(|a| a.get_short() == Some(letter)).is_some() {
                return Err(Error::new(format!("unknown option '{word}'; write '-{letter} {value}' if {value} is a file")));
            }
        }
        // What is left may be Unix's `-n4`; all else is unknown.
        if let Some(argument) = self.find(|a| a.get_short() == name.chars().next()) {
            let traced = leaves_trace(argument);
            return self.pass(word, word.into(), 0, traced);
        }
        let meant = match self.find(|a| a.get_long() == Some(name)) {
            Some(_) => format!("; did you mean '--{name}'?"),
            None => String::new(),
        };
        Err(Error::new(format!("unknown option '{word}'{meant} (--help lists all options)")))
    }

    /// Passes an option on as `rewritten`, with as many of the following words as it has values.
    fn pass(&mut self, typed: &str, rewritten: OsString, count: usize, traced: bool) -> Result<()> {
        let values: Vec<_> = self.words.drain(..count.min(self.words.len())).collect();
        if traced {
            self.trail.push(typed.into());
            self.trail.extend(values.iter().cloned());
        }
        self.out.push(rewritten);
        self.out.extend(values);
        Ok(())
    }

    fn switch(&mut self, typed: &str, name: &str, value: bool) -> Result<()> {
        self.switches.insert(name.to_string(), value);
        self.pass(typed, format!("--{name}={value}").into(), 0, true)
    }

    /// What holds for a switch here: what it was last set to, or its default.
    fn value(&self, name: &str) -> bool {
        self.switches.get(name).copied().unwrap_or_else(|| ON.contains(&name))
    }

    fn find(&self, is: impl Fn(&&Arg) -> bool) -> Option<&Arg> {
        self.command.get_arguments().find(is)
    }
}

/// The number of values an option takes.
fn values_of(argument: &Arg) -> usize {
    if argument.get_action().takes_values() { argument.get_num_args().unwrap_or(ValueRange::SINGLE).min_values() } else { 0 }
}

fn leaves_trace(argument: &Arg) -> bool {
    !NO_TRACE.contains(&argument.get_id().as_str())
}

/// The words on one line, those with blanks in quotes, as RADIANCE writes them in headers.
fn one_line(words: &[OsString]) -> String {
    let quoted = words.iter().map(|word| {
        let word = word.to_string_lossy().replace(|c: char| c.is_control(), " ");
        match (word.is_empty() || word.contains([' ', '\'']), word.contains('"')) {
            (true, false) => format!("\"{word}\""),
            (_, true) => format!("'{word}'"),
            _ => word,
        }
    });
    quoted.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::super::{Common, Typed, ViewWords, parse};
    use super::*;
    use clap::Parser;

    #[derive(Parser, Debug)]
    #[command(name = "tool", version)]
    struct Tool {
        #[arg(long)]
        ab: Option<u32>,
        #[arg(long, num_args = 3)]
        av: Option<Vec<f64>>,
        #[arg(long)]
        u: Option<bool>,
        #[arg(long)]
        bv: Option<bool>,
        #[arg(long)]
        h: Option<bool>,
        #[arg(long)]
        x: Option<u32>,
        #[arg(long)]
        format: Option<String>,
        #[arg(long)]
        specifiers: Option<String>,
        #[arg(long)]
        error: Option<f64>,
        #[command(flatten)]
        view: ViewWords,
        #[command(flatten)]
        common: Common,
        files: Vec<String>,
    }

    fn typed(line: &str) -> Result<Typed<Tool>> {
        let read = |name: &str| match name {
            "render.opt" => Ok("-ab 5\n-av -.5 -1e-3 2 @more.opt".to_string()),
            "more.opt" => Ok("-u+".to_string()),
            "self" => Ok("@self".to_string()),
            _ => Err(Error::new(format!("{name}: no such file"))),
        };
        parse(line.split(' ').map(OsString::from).collect(), &read)
    }

    fn run(line: &str) -> (Tool, String) {
        match typed(line).unwrap() {
            Typed::Run(tool, trail) => (tool, trail),
            Typed::Print(text) => panic!("{}", String::from_utf8_lossy(&text)),
        }
    }

    fn error(line: &str) -> String {
        typed(line).unwrap_err().message
    }

    #[test]
    fn radiance_and_gnu_spellings_stand_side_by_side() {
        let (tool, _) = run("tool -ab 2 --error 0.01 -x 40 scene.rad -n 3 - --seed=7 -n4");
        assert_eq!((tool.ab, tool.error, tool.x, tool.common.threads, tool.common.seed), (Some(2), Some(0.01), Some(40), Some(4), 7));
        assert_eq!(tool.files, ["scene.rad", "-"]);
        assert_eq!(run("tool --ab 2 --ab=3").0.ab, Some(3));
    }

    #[test]
    fn values_may_be_negative_and_the_last_counts() {
        assert_eq!(run("tool -av 1 2 3 -av -.5 -1e-3 2").0.av, Some(vec![-0.5, -1e-3, 2.0]));
        assert_eq!(run("tool -o -n").0.common.output, Some("-n".into()));
    }

    #[test]
    fn switches_are_set_and_toggled_from_what_holds() {
        assert_eq!(run("tool").0.u, None);
        assert_eq!(run("tool -u").0.u, Some(true));
        assert_eq!(run("tool -u+ -u").0.u, Some(false));
        assert_eq!(run("tool -u- -u").0.u, Some(true));
        assert_eq!(run("tool -u1 -u0").0.u, Some(false));
        assert_eq!(run("tool -bv").0.bv, Some(false));
        assert_eq!(run("tool -bv -bv").0.bv, Some(true));
        assert_eq!(run("tool -bv-").0.bv, Some(false));
        assert_eq!(run("tool -h-").0.h, Some(false));
    }

    #[test]
    fn attached_letters_are_not_the_same_letter_with_a_blank() {
        let (tool, _) = run("tool -ffc -ovN -o out.hdr");
        assert_eq!((tool.format.as_deref(), tool.specifiers.as_deref()), (Some("fc"), Some("vN")));
        assert_eq!(tool.common.output, Some("out.hdr".into()));
        assert_eq!(error("tool -oout.hdr"), "unknown option '-oout.hdr'; write '-o out.hdr' if out.hdr is a file");
    }

    #[test]
    fn view_options_keep_their_order_and_their_words() {
        let (tool, _) = run("tool -vf cam.vf -ab 1 -vp -1 -2 -.5 -vth scene.rad");
        assert_eq!(tool.view.words, ["-vf", "cam.vf", "-vp", "-1", "-2", "-.5", "-vth"]);
        assert_eq!(error("tool -vp 1 2"), "-vp takes 3 values");
    }

    #[test]
    fn files_and_variables_of_options_are_read_where_an_option_may_stand() {
        let (tool, _) = run("tool @render.opt -x 3");
        assert_eq!((tool.ab, tool.av, tool.u, tool.x), (Some(5), Some(vec![-0.5, -1e-3, 2.0]), Some(true), Some(3)));
        assert_eq!(run("tool -o @render.opt").0.common.output, Some("@render.opt".into()));
        assert_eq!(run("tool -- @render.opt").0.files, ["@render.opt"]);
        assert!(error("tool @absent").contains("absent: no such file"));
        assert!(error("tool @self").contains("more than"));
        assert!(error("tool $NO_SUCH_NAME_HERE").contains("no such environment variable"));
    }

    #[test]
    fn unknown_options_are_named_as_they_were_typed() {
        assert_eq!(error("tool -zz"), "unknown option '-zz' (--help lists all options)");
        assert_eq!(error("tool -error 1"), "unknown option '-error'; did you mean '--error'? (--help lists all options)");
        assert!(error("tool --eror 1").contains("'--error'"));
        assert!(error("tool -ab two").starts_with("invalid value 'two' for '-ab <AB>'"), "{}", error("tool -ab two"));
        assert!(error("tool -av 1 2").contains("-av"));
        assert!(!error("tool -av 1 2").contains('\n'));
    }

    #[test]
    fn the_trail_is_what_was_typed_without_what_cannot_change_the_result() {
        let (_, trail) = run("/usr/bin/tool -ab 2 -n 4 -vp 0 0 1 -q --progress --threads=2 -u a.rad");
        assert_eq!(trail, "tool -ab 2 -vp 0 0 1 -u a.rad");
        assert_eq!(one_line(&["a b".into(), "c\nd".into(), "".into(), "e".into()]), "\"a b\" \"c d\" \"\" e");
    }

    #[test]
    fn help_manual_and_completions_show_radiance_names_with_one_dash() {
        let text = |line: &str| match typed(line).unwrap() {
            Typed::Print(text) => String::from_utf8(text).unwrap(),
            Typed::Run(..) => panic!("{line} ran"),
        };
        assert!(text("tool --help").contains(" -ab") && text("tool -help").contains("--error") && !text("tool --help").contains("--ab"));
        assert!(
            text("tool --man").contains(r"\-ab") && !text("tool --man").contains(r"\-\-ab") && text("tool --man").contains(r"\-\-error")
        );
        assert!(text("tool --help").contains("-vp X Y Z") && !text("tool --help").contains("view-words"));
        assert!(text("tool --completions bash").contains("--error"));
        assert!(text("tool --help").contains(" --man ") && text("tool --help").contains(" --completions <SHELL> "));
        assert_eq!(text("tool --version"), concat!("tool ", env!("CARGO_PKG_VERSION"), "\n"));
    }

    proptest::proptest! {
        #![proptest_config(proptest::prelude::ProptestConfig { failure_persistence: None, ..Default::default() })]

        #[test]
        fn no_words_panic(line in "(-{1,2}(ab|av|u|v[ptf]|f|o|n|seed|man|help|completions|)[-+=01a-z]{0,3}|@|[0-9.]{1,3}|é| ){0,9}") {
            if let Err(error) = typed(&format!("tool {line}")) {
                proptest::prop_assert!(!error.message.is_empty() && !error.message.contains('\n'), "{}", error.message);
            }
        }
    }
}
