//! Which function files ship with the project: our own text for RADIANCE's names.

/// The text of the function file of that name.
pub fn shipped(name: &str) -> Option<&'static str> {
    SHIPPED.iter().find(|(file, _)| *file == name).map(|(_, text)| *text)
}

macro_rules! files {
    ($($name:literal),* $(,)?) => { &[$(($name, include_str!($name))),*] };
}

pub(super) const SHIPPED: &[(&str, &str)] = files!["curves.cal", "rayinit.cal",];
