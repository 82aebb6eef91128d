//! The model at, near and beyond the ends of its parameters: finite, not negative, continuous where the model is, equal to the closed form
//! where there is one, unchanged when the scene is scaled or moved.
//!
//! `cargo test --release --test suite extremes:: -- --nocapture` (`make extremes`) prints the table and draws more random scenes.

mod chance;
mod lamps;
mod lobes;
mod neighbours;
mod places;
mod polished;
mod search;
mod table;
mod transparent;

use rayon::prelude::*;
use table::Table;

/// What a part of the table is called, and what fills it.
type Chapter = (&'static str, fn(&mut Table));

const CHAPTERS: [Chapter; 7] = [
    ("polished and diffuse surfaces in a white furnace: the albedo, part by part", polished::fill),
    ("rough surfaces in a white furnace: the integral of the lobe's formula", lobes::fill),
    ("transparent surfaces: Fresnel, the sum of all inner reflections, Beer", transparent::fill),
    ("lamps and environments: the irradiance of what has a closed form", lamps::fill),
    ("shapes, scales and places: the same picture everywhere", places::fill),
    ("neighbouring values of every parameter: the same light", neighbours::fill),
    ("the search at the ends of its bounds", search::fill),
];

#[test]
fn every_extreme_holds() {
    let tables: Vec<Table> = CHAPTERS.into_par_iter().map(|(title, fill)| Table::filled(title, fill)).collect();
    let text: String = tables.iter().map(Table::text).collect();
    let (count, wrong) = tables.iter().fold((0, 0), |(count, wrong), t| (count + t.count(), wrong + t.wrong()));
    println!("{text}{count} cases, {wrong} of them wrong");
    assert_eq!(wrong, 0);
    assert!(count >= 300, "{count}");
}

#[test]
fn light_is_finite_and_not_negative_in_random_scenes() {
    let count = if cfg!(debug_assertions) { 1500 } else { 100_000 };
    chance::draw(count);
}
