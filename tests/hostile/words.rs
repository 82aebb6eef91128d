//! Broken arguments.

use super::bytes_of_picture;
use super::harness::Case;
use super::texts::{SCENE, SEE};

pub fn arguments() -> Vec<Case> {
    let rows: Vec<(String, &str)> = [
        // All programs alike.
        ("rparse --frobnicate main.rad", "--frobnicate"),
        ("imgdiff --frobnicate a a", "--frobnicate"),
        ("rtrace-rs --frobnicate main.rad", "--frobnicate"),
        ("anneal --frobnicate main.rad", "--frobnicate"),
        ("rparse -n 0 main.rad", "0"),
        ("rparse -n -1 main.rad", "-1"),
        ("rparse -n 99999 main.rad", "99999"),
        ("rparse -n many main.rad", "many"),
        ("rparse --seed -1 main.rad", "-1"),
        ("rparse --seed 99999999999999999999 main.rad", "99999999999999999999"),
        ("rparse -o", "-o"),
        ("rparse -o no/such/place main.rad", "no/such/place"),
        ("rparse -o . main.rad", "."),
        ("rparse -o /dev/full main.rad", "/dev/full: no space left"),
        ("rparse - -", "standard input"),
        ("rparse @", "@"),
        ("rparse @none.opt main.rad", "none.opt"),
        ("rparse @loop.opt main.rad", "loop.opt"),
        ("imgdiff @loop.opt a", "loop.opt"),
        ("rparse --commands maybe main.rad", "maybe"),
        ("rparse --check --json main.rad", "--json"),
        ("rparse --set m:rough=1 main.rad", "--keep"),
        ("rparse --keep --set m main.rad", "m"),
        ("rparse --keep --set m:rough main.rad", "rough"),
        ("rparse --keep --set n:rough=1 main.rad", "n"),
        ("rparse --keep --set m:a9=1 main.rad", "5 real arguments, not 9"),
        ("rparse --keep --set m:rough=x main.rad", "x"),
        ("rparse --keep --set m:rough=nan main.rad", "nan"),
        ("rparse --keep --set m:rough=1e999 main.rad", "1e999"),
        ("imgdiff", "A"),
        ("imgdiff a a a", "a"),
        ("imgdiff --metric worth a a", "worth"),
        ("imgdiff --fail-above x a a", "x"),
        ("imgdiff --heatmap no/such/h.png a a", "no/such"),
        ("imgdiff -o /dev/full a a", "/dev/full"),
        ("imgdiff --heatmap h.png --side-by-side h.png a a", "h.png: named for two outputs"),
        ("imgdiff -o h.png --heatmap ./h.png a a", "h.png: named for two outputs"),
        ("imgdiff a a --heatmap ./a", "a: read here, and would be lost"),
        ("imgdiff - -", "standard input"),
        ("imgdiff --all --metric mse a a", "--metric"),
        // The renderer.
        ("rtrace-rs -ab 1", "standard input holds the rays"),
        ("SEE -x 0 main.rad", "-x"),
        ("SEE -x -5 main.rad", "-5"),
        ("SEE -x wide main.rad", "wide"),
        ("SEE -x 18446744073709551615 -y 18446744073709551615 main.rad", "2^28"),
        ("SEE -x 100000 -y 100000 main.rad", "2^28"),
        ("SEE -pa nan main.rad", "-pa"),
        ("SEE -pj nan main.rad", "-pj"),
        ("SEE -pj 1.5 main.rad", "-pj must be from 0 to 1, not 1.5"),
        ("SEE -pd -1 main.rad", "-pd must be 0 or more, not -1"),
        ("SEE -ds -1 main.rad", "-ds must be 0 or more, not -1"),
        ("SEE -me 0 -1 0 main.rad", "-me must be 0 or more, not -1"),
        ("SEE -ab x main.rad", "x"),
        ("SEE -ab 99999999999999999999 main.rad", "-ab"),
        ("SEE -av 1 1 main.rad", "-av"),
        ("SEE -av nan 1 1 main.rad", "-av"),
        ("SEE -st nan main.rad", "-st"),
        ("SEE -lw nan main.rad", "-lw"),
        ("SEE -lw 0 main.rad", "-lr above 0"),
        ("SEE -dj 2 main.rad", "-dj"),
        ("SEE -lr 1e9 main.rad", "-lr"),
        ("SEE -me nan 0 0 main.rad", "-me"),
        ("SEE --ward 1993 main.rad", "1993"),
        ("SEE -vt main.rad", "-vt"),
        ("SEE -vtx main.rad", "-vtx"),
        ("SEE -vp 0 0 main.rad", "main.rad"),
        ("SEE -vp 0 0 nan main.rad", "-vp"),
        ("SEE -vp 0 0 1e999 main.rad", "-vp"),
        ("SEE -vd 0 0 0 main.rad", "-vd"),
        ("SEE -vu 0 1 0 main.rad", "-vu"),
        ("SEE -vh 0 main.rad", "-vh"),
        ("SEE -vh 180 main.rad", "-vh"),
        ("SEE -vtc -vh 361 main.rad", "-vh"),
        ("SEE -vf none.vf main.rad", "none.vf"),
        ("SEE -vf", "-vf"),
        ("SEE --coverage m -pXYZ main.rad", "-pXYZ"),
        ("SEE -u maybe main.rad", "maybe"),
        ("SEE -o no/such/place main.rad", "no/such/place"),
        ("SEE -o /dev/full main.rad", "/dev/full"),
        ("SEE --variance /dev/full main.rad", "/dev/full"),
        ("SEE --variance no/such/v.exr main.rad", "no/such"),
        ("SEE -o v.exr --variance v.exr main.rad", "v.exr: named for two outputs"),
        ("SEE -z v.exr --aov normal ./v.exr main.rad", "v.exr: named for two outputs"),
        ("SEE -o ./main.rad main.rad", "main.rad: read here, and would be lost"),
        ("SEE -vf main.rad -o main.rad none.rad", "main.rad: read here, and would be lost"),
        ("rtrace-rs --merge main.rad none.exr -o main.rad", "main.rad: read here, and would be lost"),
        ("rparse --check -o out main.rad", "cannot be used with"),
        ("SEE -x 99999999999 -y 99999999999 main.rad", "2^28"),
        ("SEE --error 0.1 main.rad", "--error"),
        ("SEE --time 1 main.rad", "--time"),
        ("SEE -aE none.txt main.rad", "none.txt"),
        ("rtrace-rs -vp 0 -5 0 --spp 0 main.rad", "--spp"),
        ("rtrace-rs -vp 0 -5 0 --spp -1 main.rad", "-1"),
        ("rtrace-rs -vp 0 -5 0 --error 0 main.rad", "--error"),
        ("rtrace-rs -vp 0 -5 0 --error nan main.rad", "--error"),
        ("rtrace-rs -vp 0 -5 0 --time -1 main.rad", "--time"),
        ("rtrace-rs -vp 0 -5 0 --time nan main.rad", "--time"),
        // The search.
        ("anneal", "START.rad"),
        ("anneal main.rad", "--exec"),
        ("anneal main.rad main.rad", "one START.rad"),
        ("anneal propose", "propose"),
        ("anneal propose none", "none"),
        ("anneal tell none 1", "none"),
        ("anneal tell none nan?", "nan?"),
        ("anneal best none", "none"),
        ("anneal propose no/such/state main.rad", "no/such/state"),
        ("anneal propose /dev/full main.rad", "/dev/full"),
        ("anneal --exec echo~1 --steps 0 main.rad", "--steps"),
        ("anneal --exec echo~1 --steps -1 main.rad", "-1"),
        ("anneal --exec echo~1 --steps 99999999999999999999 main.rad", "--steps"),
        ("anneal --exec echo~1 --stages 0 main.rad", "--stages"),
        ("anneal --exec echo~1 --stages 256 main.rad", "--stages"),
        ("anneal --exec echo~1 --time nan main.rad", "--time"),
        ("anneal --exec echo~1 --tolerance -1 main.rad", "--tolerance"),
        ("anneal --exec echo~1 --tolerance .1 --no-polish main.rad", "--no-polish"),
        ("anneal --exec echo~1 --residuals 0 main.rad", "--residuals"),
        ("anneal --exec echo~1 --param rough main.rad", "rough"),
        ("anneal --exec echo~1 --param rough=1:0 main.rad", "rough=1:0"),
        ("anneal --exec echo~1 --param rough=0:1:0 main.rad", "rough=0:1:0"),
        ("anneal --exec echo~1 --param rough=9:0:1 main.rad", "rough=9:0:1"),
        ("anneal --exec echo~1 --param rough=nan:0:1 main.rad", "nan"),
        ("anneal --exec echo~1 --param rough=0:0:1e999 main.rad", "1e999"),
        ("anneal --exec echo~1 --param glow=0:0:1 main.rad", "glow"),
        ("anneal --exec echo~1 --param a99=0:0:1 main.rad", "a99"),
        ("anneal --exec echo~1 --param rough=.1:-1:.3 main.rad", "a roughness is not below 0"),
        ("anneal --exec echo~1 --param a5=.1:-1:.3 main.rad", "a roughness is not below 0"),
        ("anneal --exec echo~1 --param spec=.1:-1:.3 main.rad", "a share of light is not below 0"),
        ("anneal --exec echo~1 --param rough=0:.3 main.rad", "rough=:0:.3"),
        ("anneal --exec echo~1 --fix nothing main.rad", "nothing"),
        ("anneal --exec echo~1 --fix red=.6 main.rad", "--fix takes names alone"),
        ("anneal --exec echo~1 --fix red,green,blue,spec,rough main.rad", ""),
        ("anneal --exec echo~1 --tie red=nothing main.rad", "nothing"),
        ("anneal --exec echo~1 --groups rgb/nothing main.rad", "nothing"),
        ("anneal --exec echo~1 --material n main.rad", "n"),
        ("anneal --exec true main.rad", "--exec"),
        ("anneal --exec false main.rad", "--exec"),
        ("anneal --exec echo~nan main.rad", "start"),
        ("anneal --exec echo~inf main.rad", "start"),
        ("anneal --exec /no/such/program main.rad", "/no/such/program"),
        ("anneal --exec kill~-9~$$ main.rad", "--exec"),
        ("anneal --exec printf~'\\033[31m\\n' main.rad", "--exec"),
        ("anneal --exec echo~1 --log no/such/log main.rad", "no/such/log"),
        ("anneal --exec echo~1 --log /dev/full main.rad", "/dev/full"),
        ("anneal --exec echo~1 --state no/such/state --steps 4 main.rad", "no/such/state"),
        ("anneal --exec echo~1 --state s --report s main.rad", "s: named for two outputs"),
        ("anneal --exec echo~1 --log s -o s main.rad", "s: named for two outputs"),
        ("anneal propose s main.rad -o s", "s: named for two outputs"),
        ("anneal propose s main.rad --report s.html", "give --report to best"),
        ("anneal --scene main.rad --target a.hdr --log main.rad start.rad", "main.rad: read here, and would be lost"),
        ("anneal --scene s.rad --target a.hdr --log main.rad main.rad", "main.rad: read here, and would be lost"),
        ("anneal --scene s.rad --target a.hdr -vf main.rad --report main.rad start.rad", "main.rad: read here, and would be lost"),
        ("anneal --exec echo~1 --scene main.rad start.rad", "cannot be used with"),
        ("anneal propose main.rad --fix red", "leave --fix out"),
        ("anneal tell main.rad 3 --steps 9", "leave --steps out"),
        ("anneal best main.rad --param red=.5:0:1", "leave --param out"),
        ("anneal --exec echo~1 --param red=.5:0:1e300 main.rad", "no bound is farther from 0 than 1e9"),
        ("anneal --exec echo~1 -o /dev/full --steps 4 main.rad", "/dev/full"),
    ]
    .map(|(line, place)| (line.replace("SEE", SEE), place))
    .into();
    let picture = bytes_of_picture();
    let case = |(line, place): &(String, &str)| Case::new("arguments", line, *place).with("main.rad", SCENE);
    let mut cases: Vec<Case> = rows
        .iter()
        .map(|row| {
            let case = case(row);
            let case = if row.0.starts_with("imgdiff") { case.with("a", &picture[..]).reading(&picture) } else { case };
            if row.0.contains("loop.opt") { case.with("loop.opt", "@loop.opt\n") } else { case }
        })
        .collect();
    // Arguments of great length, of control characters, of nothing.
    let long = "x".repeat(100_000);
    for program in ["rparse", "imgdiff", "rtrace-rs", "anneal"] {
        for (label, word, place) in [("long", long.as_str(), "xxxx"), ("control characters", "\u{1b}[31m\n\r", ""), ("empty", "", "")] {
            let line = match program {
                "rtrace-rs" => format!("{SEE} {word}"),
                "anneal" => format!("anneal --exec echo~1 {word}"),
                _ => format!("{program} {word}"),
            };
            cases.push(Case::new(format!("a file name: {label}"), &line, place));
            if !word.is_empty() {
                cases
                    .push(Case::new(format!("an option: {label}"), &format!("{program} --{word} main.rad"), place).with("main.rad", SCENE));
            }
        }
    }
    cases
}
