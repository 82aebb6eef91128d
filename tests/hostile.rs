//! Broken files and arguments, through the real programs: each is refused by one message that names the place and by the right exit
//! status, within a second and 200 MB, without a panic, and leaves nothing behind.

#![cfg(target_os = "linux")]

mod bytes;
mod harness;
mod parts;
mod texts;
mod words;

use harness::refuse;
use inverad::picture::{Header, Picture};

/// A small picture that is whole.
fn bytes_of_picture() -> Vec<u8> {
    Picture::new(4, 4, Header::new("made")).unwrap().write_hdr().unwrap()
}

#[test]
fn what_is_whole_is_accepted() {
    harness::accept(&[texts::whole(), bytes::whole(), parts::whole()].concat());
}

#[test]
fn scenes() {
    refuse("scenes", &texts::scenes());
    refuse("arrays", &texts::arrays());
}

#[test]
fn function_files() {
    refuse("function files", &texts::functions());
}

#[test]
fn data_files() {
    refuse("data files", &texts::tables());
}

#[test]
fn views() {
    refuse("views", &texts::views());
}

#[test]
fn wavefront_meshes() {
    refuse("Wavefront meshes", &texts::objects());
}

#[test]
fn pictures() {
    refuse("pictures", &bytes::pictures());
}

#[test]
fn openexr() {
    refuse("OpenEXR", &bytes::exr());
}

#[test]
fn compiled_meshes() {
    refuse("compiled meshes", &bytes::meshes());
}

#[test]
fn octrees() {
    refuse("octrees", &bytes::octrees());
}

#[test]
fn states() {
    refuse("states", &bytes::states());
}

#[test]
fn arguments() {
    refuse("arguments", &words::arguments());
}

#[test]
fn parts_of_pictures() {
    refuse("parts of pictures", &parts::parts());
}

#[test]
fn rays() {
    refuse("rays", &parts::rays());
}

#[test]
fn probes() {
    refuse("probes", &parts::probes());
}

#[test]
fn files_of_options() {
    refuse("files of options", &parts::options());
}
