//! What goes together: a picture, the parts of one, or rays, and the files that each of them writes.
//!
//! An option that only tunes the rendering may stand anywhere, as in a file of options that serves several programs. One that asks for
//! something that would not come about is refused.

use super::{Arguments, PictureOptions};
use crate::error::{Error, Result};
use std::path::Path;

/// Ends of names that are taken for a picture that is no OpenEXR.
const OTHER_PICTURES: [&str; 3] = ["hdr", "pic", "png"];

/// Ends of names of pictures that rays are not answered with.
const NO_ANSWERS: [&str; 2] = ["exr", "png"];

/// Ends of names of pictures that are not written.
const UNWRITTEN: [&str; 6] = ["jpg", "jpeg", "tif", "tiff", "gif", "bmp"];

/// Whether the name of a file ends so, in capitals or not.
pub fn ends_in(path: &Path, ends: &[&str]) -> bool {
    path.extension().is_some_and(|extension| ends.iter().any(|end| extension.eq_ignore_ascii_case(end)))
}

impl Arguments {
    /// Refuses what asks for something that would not come about, or under a name that says something else.
    pub fn check(&self) -> Result<()> {
        self.picture.check()?;
        let (view, rays) = (!self.view.words.is_empty(), &self.rays);
        let PictureOptions { z, exr, variance, aov, coverage, luminance, scotopic, melanopic, .. } = &self.picture;
        if view && self.merge {
            return Err(Error::new("--merge: the view is that of the parts; leave the view options out"));
        }
        if view || self.merge {
            let of_rays = [
                rays.specifiers.as_ref().filter(|letters| *letters != "v").map(|letters| format!("-o{letters}")),
                rays.format.as_ref().filter(|format| !format.ends_with('c')).map(|format| format!("-f{format}")),
                (rays.point_irradiance == Some(true)).then(|| "-I".into()),
                luminance.then(|| "-pY".into()),
                scotopic.then(|| "-pS".into()),
                melanopic.then(|| "-pM".into()),
            ];
            if let Some(option) = of_rays.into_iter().flatten().next() {
                let other = if view { "a view" } else { "--merge" };
                return Err(Error::new(format!("{option} is for rays on standard input, {other} for a picture: leave one of them out")));
            }
        } else {
            let of_pictures = [
                ("--samples", self.accuracy.samples.is_some()),
                ("--variance", variance.is_some()),
                ("--coverage", coverage.is_some()),
                ("--aov", aov.is_some()),
                ("-z", z.is_some()),
                ("--exr", *exr),
            ];
            if let Some((option, _)) = of_pictures.into_iter().find(|(_, given)| *given) {
                return Err(Error::new(format!("{option} is for pictures: give a view (-vf FILE, -vp …)")));
            }
        }
        self.named(view || self.merge)?;
        self.coloured(view || self.merge)
    }

    /// Refuses colours that a format cannot hold.
    fn coloured(&self, picture: bool) -> Result<()> {
        let PictureOptions { exr, xyz, luminance, scotopic, melanopic, .. } = &self.picture;
        let into_exr = *exr || self.common.output.as_deref().is_some_and(|path| ends_in(path, &["exr"]));
        if picture && *xyz && into_exr {
            return Err(Error::new("-pXYZ: an OpenEXR file holds red, green and blue here: leave it out, or write a RADIANCE picture"));
        }
        let colors = self.rays.format.as_ref().is_some_and(|format| format.ends_with('c'));
        let single = [(luminance, "-pY"), (scotopic, "-pS"), (melanopic, "-pM")].into_iter().find(|(given, _)| **given);
        match single.filter(|_| !picture && colors) {
            Some((_, option)) => Err(Error::new(format!("{option} is one number for each ray, -f…c three: write numbers (-fff, -ffa)"))),
            None => Ok(()),
        }
    }

    /// Refuses files whose names promise another format than they would have.
    fn named(&self, picture: bool) -> Result<()> {
        let PictureOptions { exr, variance, aov, .. } = &self.picture;
        let output = self.common.output.as_deref();
        if let Some(path) = output.filter(|path| !picture && ends_in(path, &NO_ANSWERS)) {
            let (path, other) = (path.display(), path.with_extension("hdr"));
            let remedy = format!("with -f…c they are a RADIANCE picture: name it {}, or give a view (-vf FILE, -vp …)", other.display());
            return Err(Error::new(format!("{path}: rays are not answered in this format; {remedy}")));
        }
        if let Some(path) = output.filter(|path| ends_in(path, &UNWRITTEN)) {
            let (path, [hdr, exr, png]) = (path.display(), ["hdr", "exr", "png"].map(|end| path.with_extension(end).display().to_string()));
            return Err(Error::new(format!("{path}: such a file is not written; name it {hdr} or {exr}, or {png} to look at")));
        }
        if let Some([_, path]) = aov.as_deref()
            && path.starts_with('-')
        {
            return Err(Error::new(format!("--aov needs NAMES and FILE.exr; {path} is no name of a file (write ./{path} if it is)")));
        }
        let of_exr = [
            ("--samples", output.filter(|_| self.accuracy.samples.is_some())),
            ("--exr", output.filter(|_| *exr)),
            ("--variance", variance.as_deref()),
            ("--aov", aov.as_ref().map(|words| Path::new(&words[1]))),
        ];
        match of_exr.into_iter().find_map(|(option, path)| Some((option, path.filter(|path| ends_in(path, &OTHER_PICTURES))?))) {
            Some((option, path)) => {
                let (path, other) = (path.display(), path.with_extension("exr"));
                Err(Error::new(format!("{path}: {option} writes OpenEXR; name the file {}", other.display())))
            }
            None => Ok(()),
        }
    }

    /// Where something is written: files, and `-` for standard output.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let PictureOptions { z, variance, aov, .. } = &self.picture;
        let aov = aov.as_ref().map(|words| Path::new(&words[1]));
        [Some(self.common.output()), z.as_deref(), variance.as_deref(), aov].into_iter().flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Typed, parse};

    /// What is said of a command line; nothing if it may be.
    fn said(line: &str) -> String {
        let none = |name: &str| Err(Error::new(format!("{name}: no such file")));
        let words = line.split(' ').map(Into::into).collect();
        let possible = parse::<Arguments>(words, &none).and_then(|typed| match typed {
            Typed::Run(arguments, _) => arguments.check(),
            Typed::Print(text) => panic!("{}", String::from_utf8_lossy(&text)),
        });
        possible.err().map(|error| error.message).unwrap_or_default()
    }

    #[test]
    fn what_would_not_come_about_is_refused_with_a_remedy() {
        for (line, wanted) in [
            ("-vp 0 0 1 --samples 0..2 --aov normal a.exr s.rad", "cannot be used with"),
            ("-vp 0 0 1 --samples 0..2 --variance v.exr s.rad", "cannot be used with"),
            ("-vp 0 0 1 --samples 0..2 --coverage it s.rad", "cannot be used with"),
            ("-vp 0 0 1 --samples 0..2 -pXYZ s.rad", "cannot be used with"),
            ("-vp 0 0 1 --coverage it --variance v.exr s.rad", "cannot be used with"),
            ("-vp 0 0 1 --coverage it --aov normal a.exr s.rad", "cannot be used with"),
            ("--merge --aov normal a.exr p.exr", "cannot be used with"),
            ("--merge --coverage it p.exr", "cannot be used with"),
            ("--merge -z z.f p.exr", "cannot be used with"),
            ("--merge -vf a.vf p.exr", "--merge: the view is that of the parts"),
            ("--merge -oL p.exr", "-oL is for rays on standard input, --merge for a picture"),
            ("-vp 0 0 1 -oL s.rad", "-oL is for rays on standard input, a view for a picture: leave one of them out"),
            ("-vp 0 0 1 -faf s.rad", "-faf is for rays"),
            ("-vp 0 0 1 -I s.rad", "-I is for rays"),
            ("-vp 0 0 1 -pY s.rad", "-pY is for rays"),
            ("-vp 0 0 1 -pS s.rad", "-pS is for rays"),
            ("-vp 0 0 1 -pM s.rad", "-pM is for rays"),
            ("--variance v.exr s.rad", "--variance is for pictures: give a view (-vf FILE, -vp …)"),
            ("--coverage it s.rad", "--coverage is for pictures"),
            ("--aov normal a.exr s.rad", "--aov is for pictures"),
            ("--samples 0..2 s.rad", "--samples is for pictures"),
            ("-z z.f s.rad", "-z is for pictures"),
            ("--exr s.rad", "--exr is for pictures"),
            ("-vp 0 0 1 -pXYZ -o x.EXR s.rad", "-pXYZ: an OpenEXR file holds red, green and blue here"),
            ("--merge --exr -pXYZ p.exr", "-pXYZ: an OpenEXR file holds red, green and blue here"),
            ("-fac -pY s.rad", "-pY is one number for each ray, -f…c three"),
        ] {
            let found = said(&format!("rtrace-rs {line}"));
            assert!(found.contains(wanted), "{line}: {found}");
        }
    }

    #[test]
    fn a_name_that_promises_another_format_is_refused() {
        let remedy = "p.hdr: --samples writes OpenEXR; name the file p.exr";
        assert_eq!(said("rtrace-rs -vp 0 0 1 --samples 0..5 -o p.hdr s.rad"), remedy);
        assert!(said("rtrace-rs -vp 0 0 1 --exr -o p.PIC s.rad").contains("p.PIC: --exr writes OpenEXR"));
        assert!(said("rtrace-rs -vp 0 0 1 --variance a/v.hdr s.rad").contains("name the file a/v.exr"));
        assert!(said("rtrace-rs -vp 0 0 1 --aov normal n.png s.rad").contains("name the file n.exr"));
        assert!(said("rtrace-rs -vp 0 0 1 -o p.JPG s.rad").ends_with("name it p.hdr or p.exr, or p.png to look at"));
        assert!(said("rtrace-rs -vp 0 0 1 --aov normal -o n.exr s.rad").contains("--aov needs NAMES and FILE.exr"));
        assert!(said("rtrace-rs -fac -o x.exr s.rad").contains("x.exr: rays are not answered in this format; with -f…c they are"));
    }

    #[test]
    fn what_does_no_harm_is_accepted() {
        for line in [
            "-vp 0 0 1 -x 40 -y 30 -ld- -ffc -ov -I- -h- -te m s.rad",
            "-vp 0 0 1 --variance v.exr --aov normal a.exr -z z.f --exr -o - s.rad",
            "-vp 0 0 1 --coverage it -z z.f --exr -o mask.exr s.rad",
            "-vp 0 0 1 --samples 0..2 -z z.f -o part s.rad",
            "-vp 0 0 1 -o p.png s.rad",
            "--merge --variance v.exr -pXYZ -o p.hdr p.exr",
            "-vp 0 0 1 -pXYZ -o p.hdr s.rad",
            "-x 40 -y 30 -ld- -pj 0 -pd 0 -pa 1 -ps 4 -pt .05 -dp 512 -ffc -pXYZ -o p.hdr s.rad",
            "-fff -pY s.rad",
        ] {
            assert_eq!(said(&format!("rtrace-rs {line}")), "", "{line}");
        }
    }
}
