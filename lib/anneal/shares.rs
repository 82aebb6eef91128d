//! Which evaluations of a search go to what.

use super::{BELIEVED, Options, polish};

/// Part of the evaluations that the survey gets, and how many for each parameter at most.
const SURVEY: (f64, usize) = (0.1, 8);
/// Part of the evaluations that the polish gets.
const POLISH: f64 = 0.45;

/// How many evaluations the survey gets, the start included.
pub fn survey(options: &Options, parameters: usize) -> usize {
    1 + ((options.steps as f64 * SURVEY.0) as usize).min(SURVEY.1 * parameters)
}

/// After how many evaluations the walk ends.
pub fn walk_end(options: &Options, parameters: usize) -> usize {
    if !options.polish {
        // The best is to be measured again.
        return options.steps - (options.steps / 10).min(2 * BELIEVED as usize);
    }
    // A quadratic needs some values more than it has coefficients, but never most of them.
    let needed = polish::coefficients(parameters) + 8;
    options.steps - ((options.steps as f64 * POLISH) as usize).max(needed.min(options.steps / 2))
}

/// How much of the walk is done, 0 to 1.
pub fn walk_progress(told: usize, options: &Options, parameters: usize) -> f64 {
    let (begin, end) = (survey(options, parameters) as f64, walk_end(options, parameters) as f64);
    if (told as f64) < end { ((told as f64 - begin) / (end - begin).max(1.0)).clamp(0.0, 1.0) } else { 1.0 }
}

/// The stage at that progress.
pub fn stage_at(shares: &[f64], progress: f64) -> usize {
    let mut left = progress * shares.iter().sum::<f64>();
    shares
        .iter()
        .take(shares.len() - 1)
        .take_while(|share| {
            left -= **share;
            left >= 0.0
        })
        .count()
}
