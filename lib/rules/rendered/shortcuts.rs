//! What a renderer left out or guessed of the light in its picture.

use super::{Command, PROGRAMS};
use crate::rules::single;

/// From this `-lw` on, what ends there is more than a picture's last digits.
const HEAVY: f64 = 0.01;

/// What the last renderer in a picture's header changed of the light of a scene with so many lamps: a sentence each. Of rough reflection only if
/// something rough is sought, whose specularity may be as small as `least`. By how much, `rpict` told: of metal of roughness .1 opposite a window
/// before a wall, the same with `-ss 2`, `8` and `16`; of a floor in a room, `-ab 2 -ad 1024` with `-aa .1` and `-aa 0`; of a screen of trans
/// before a lamp, `-ab 2 -ad 512 -lw 0` with `-aa .1` and `-aa 0`; of the walls of one, `-ab 2 -ad 400 -aa 0` with `-as 128` and `-as 0`; of a
/// shade with one lamp in it and three beside, `-dt .05` and `-dt 0`.
pub fn shortcuts<'a>(lines: impl IntoIterator<Item = &'a str>, least: Option<f64>, lamps: usize) -> Vec<String> {
    let Some(command) = Command::last(lines, &PROGRAMS) else { return vec![] };
    let mut found = Vec::new();
    let mut say = |option: String, harm: &str, remedy: &str| {
        found.push(format!("the target was rendered by {} with {option}: {harm}; render it with {remedy}", command.program()));
    };
    if let Some(least) = least {
        if let Some((threshold, st)) = command.option("-st")
            && threshold > least
        {
            say(
                st,
                "a specularity up to that mirrors only lamps there and counts as diffuse otherwise: it comes out too small, colours too bright",
                "-st 0",
            );
        }
        match command.option("-ss") {
            Some((0.0, ss)) => say(ss, "rough surfaces reflect like mirrors there", "-ss 1"),
            Some((sampling, ss)) if sampling < 1.0 => say(ss, "rough surfaces reflect too sharply there", "-ss 1"),
            Some((sampling, ss)) if !single(sampling) && lamps > 0 && !command.is_ours() => {
                say(
                    ss,
                    "rough samples that follow one which met a lamp miss light there, 1 % of what is mirrored at 2, and 3 % at 8",
                    "-ss 1",
                );
            }
            _ => {}
        }
    }
    // Below zero, chance ends rays without loss.
    let cuts = command.option("-lr").is_none_or(|(reflections, _)| reflections >= 0.0);
    if let Some((weight, lw)) = command.option("-lw")
        && cuts
        && weight >= HEAVY
    {
        say(lw, "what is reflected more weakly than that is left out there", "-lw 1e-4");
    }
    if command.is_ours() {
        return found;
    }
    if let Some((spacing, ps)) = command.option("-ps")
        && spacing > 1.0
    {
        say(
            ps,
            "pixels between those that are traced are interpolated there where these hardly differ, and errors may be ten times as large",
            "-ps 1",
        );
    }
    if let Some(aa) = interpolated(&command) {
        say(aa, "light that bounces is interpolated there, 1 % off by .1 on a floor, 8 % on what light comes through near a lamp", "-aa 0");
    }
    if let Some(samples) = supersampled(&command) {
        say(samples, "light that bounces twice is too dark there, 4.5 % of a horse in the open, 14 % of a wall in a room", "-as 0");
    }
    if let Some(weight) = command.given("-aw").filter(|weight| *weight > 0.0) {
        say(format!("-aw {weight}"), "what stands for the bounces left out changes there from place to place, and does not here", "-aw 0");
    }
    if let Some((tested, dt)) = command.option("-dt")
        && tested > 0.0
        && lamps > 1
    {
        say(dt, "shadows of the fainter of several lamps are guessed there, which is up to .8 % of the light", "-dt 0");
    }
    found
}

/// Whether the last renderer in a picture's header guessed light that bounces, which all that is seen may be off by.
pub fn guesses_bounces<'a>(lines: impl IntoIterator<Item = &'a str>) -> bool {
    let command = Command::last(lines, &PROGRAMS).filter(|command| !command.is_ours());
    command.is_some_and(|command| interpolated(&command).or_else(|| supersampled(&command)).is_some())
}

/// The words for the accuracy by which a command of RADIANCE interpolates light that bounces; `None` if it does not.
fn interpolated(command: &Command) -> Option<String> {
    command.option("-aa").filter(|(accuracy, _)| *accuracy > 0.0 && command.bounces().is_some_and(|most| most > 0.0)).map(|(_, aa)| aa)
}

/// The words for how often it samples such light anew where that seems to pay, which tells from the second bounce on; `None` if it does not.
fn supersampled(command: &Command) -> Option<String> {
    command
        .option("-as")
        .filter(|(samples, _)| *samples > 0.0 && command.bounces().is_some_and(|most| most > 1.0))
        .map(|(_, samples)| samples)
}

/// What is to be said of a rendering in which only some surfaces gather indirect light, or that shows irradiance; of the first if it was not `typed`
/// which those are.
pub fn otherwise<'a>(lines: impl IntoIterator<Item = &'a str>, typed: bool) -> Option<String> {
    let command = Command::last(lines, &PROGRAMS)?;
    let given = |names: &[&'static str]| names.iter().copied().find(|name| command.after(name).is_some());
    let (what, harm, remedy) = if let Some(option) = given(&["-i", "-i+"]) {
        (option, "it shows irradiance, not what surfaces reflect", "render it without")
    } else {
        let option = given(&["-ae", "-aE", "-ai", "-aI"]).filter(|_| !typed)?;
        (option, "only some surfaces gather indirect light there", "give the same option here")
    };
    Some(format!("the target was rendered by {} with {what}: {harm}; {remedy}", command.program()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shortcuts_of_renderings_are_read_off_their_headers() {
        let said = |lines: &[&str], least, lamps| shortcuts(lines.iter().copied(), Some(least), lamps);
        assert!(said(&["rpict -ps 1 -st 0 -ss 1 -vf a.vf a.oct", "pfilt -x /2"], 0.0, 1).is_empty());
        assert!(said(&["rpict -ps 1 -st 0 -ab 1 -aa 0 -dt 0 a.oct"], 0.0, 2).is_empty());
        assert!(said(&["rtrace-rs -ab 2", "SOFTWARE= RADIANCE rtrace, -st .15"], 0.0, 2).is_empty());
        let defaults = said(&["/usr/bin/rpict -ab 1 -vf a.vf a.oct", "\tpfilt -x /2"], 0.0, 2);
        assert_eq!(defaults.len(), 4);
        for (said, option) in defaults.iter().zip(["-st 0.15", "-ps 4", "-aa 0.2", "-dt 0.05"]) {
            assert!(said.starts_with(&format!("the target was rendered by rpict with {option}, its default: ")), "{said}");
        }
        let twice = |options: &str| said(&[&format!("rpict -ps 1 -st 0 -aa 0 -dt 0 {options} a.oct")], 0.0, 2);
        assert!(twice("-ab 1").is_empty() && twice("-ab 2 -as 0").is_empty());
        assert!(guesses_bounces(["rpict -ab 1"]) && guesses_bounces(["rpict -ab 2 -aa 0"]));
        assert!(
            !["rpict", "rpict -ab 1 -aa 0", "rpict -ab 2 -aa 0 -as 0", "rpict -ab 2 -ad 0", "rtrace-rs -ab 2"]
                .iter()
                .any(|line| guesses_bounces([*line]))
        );
        assert!(twice("-ab 2")[0].ends_with("14 % of a wall in a room; render it with -as 0"));
        let [only] = &said(&["rtrace -st .3 -ss 0 -st .1 a.oct"], 0.2, 1)[..] else { panic!() };
        assert_eq!(only, "the target was rendered by rtrace with -ss 0: rough surfaces reflect like mirrors there; render it with -ss 1");
        assert!(shortcuts(["rpict -ps 1 -ab 1 -aa 0 -dt 0 -av .1 .1 .1 -aw 16 a.oct"], None, 1)[0].contains("with -aw 16: "));
        // Light is missing only where a lamp is met.
        let lost = |lamps| said(&["rpict -ps 1 -st 0 -ss 8 -dt 0 a.oct"], 0.0, lamps);
        assert!(lost(0).is_empty() && lost(1)[0].contains("miss light there"), "{:?}", lost(1));
        assert!(said(&["rtrace-rs -ab 2 -aa .2 -dt .05 -aw 16 a.rad"], 0.0, 2).is_empty());
        for (option, harm) in
            [("-ss 0.5", "too sharply"), ("-st 0.15", "too small"), ("-lw 0.5", "left out"), ("-lr 4 -lw 0.5", "left out")]
        {
            let [only] = &said(&[&format!("rtrace-rs {option} a.rad")], 0.0, 2)[..] else { panic!("{option}") };
            assert!(only.contains(harm), "{only}");
        }
        assert!(said(&["rtrace -aa 0 -dt 0 -st 0 -ss 1 -lw .5 a.oct"], 0.0, 2).is_empty());
        // Where nothing rough is sought, nothing is said of it.
        assert!(shortcuts(["rpict -ps 1 a.oct"], None, 1).is_empty());
    }

    #[test]
    fn pictures_of_something_else_than_radiance_are_told() {
        let said = |line: &'static str, typed| otherwise([line], typed).unwrap_or_default();
        assert!(said("rpict -ae floor a.oct", false).contains("rpict with -ae: only some surfaces"));
        assert!(said("rtrace-rs -i a.rad", true).contains("rtrace-rs with -i: it shows irradiance"));
        assert!(said("rpict -ae floor a.oct", true).is_empty() && said("rpict -ab 1 a.oct", false).is_empty());
    }
}
