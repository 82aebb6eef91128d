//! `anneal` at and beyond the ends: proposals stay inside, the answer is the best there is, whatever chi-squared is.

use super::table::Table;
use inverad::anneal::{Annealer, Options, Parameter};

/// The value that a search of one parameter answers with, or NaN if it ever left its bounds.
fn found([low, start, high]: [f64; 3], chi2: impl Fn(f64) -> f64) -> f64 {
    let parameter = Parameter { name: "p".into(), start, low, high };
    let mut annealer = Annealer::new(vec![parameter], Options { steps: 300, ..Options::default() }).unwrap();
    let mut inside = true;
    while let Some(values) = annealer.propose() {
        let value = values[0];
        inside &= (low..=high).contains(&value);
        annealer.tell(chi2(value));
    }
    if inside { annealer.best().map_or(f64::NAN, |best| best.values[0]) } else { f64::NAN }
}

pub fn fill(table: &mut Table) {
    // The best value at an end, beyond it, between; from a start at an end.
    for bounds in [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.5, 1.0]] {
        for (aim, expected) in [(0.0, 0.0), (1.0, 1.0), (-3.0, 0.0), (2.0, 1.0), (0.3, 0.3), (1e-9, 1e-9)] {
            let got = found(bounds, |v| (v - aim) * (v - aim));
            table.near(format!("bounds {bounds:?}, best at {aim:e}"), 1.0 + expected, 1.0 + got, 1e-3);
        }
    }
    // Bounds of all sizes.
    for size in [1e-300, 1e-30, 1e-9, 1e9, 1e30, 1e300] {
        let got = found([0.0, 0.1 * size, size], |v| (v / size - 0.7) * (v / size - 0.7));
        table.near(format!("bounds 0 to {size:e}, best at .7 of it"), 0.7, got / size, 1e-3);
        let got = found([-size, 0.1 * size, size], |v| (v / size + 0.7) * (v / size + 0.7));
        table.near(format!("bounds -{size:e} to {size:e}, best at -.7 of it"), -0.7, got / size, 1e-3);
    }
    let narrow = found([1.0, 1.0, 1.0 + 1e-15], |v| v);
    table.within("bounds 1 to 1 + 1e-15", 1.0, 1.0 + 1e-15, narrow);
    // Whatever chi-squared is: huge, tiny, negative, none.
    for scale in [1e-300, 1e-30, 1e30, 1e300] {
        let got = found([0.0, 0.5, 1.0], |v| (v - 0.3) * (v - 0.3) * scale);
        table.near(format!("chi-squared of the order of {scale:e}"), 0.3, got, 1e-3);
    }
    let bowl = |v: f64| (v - 0.3) * (v - 0.3);
    table.near("chi-squared below 0", 0.3, found([0.0, 0.5, 1.0], |v| bowl(v) - 5.0), 1e-3);
    table.near("chi-squared infinite beyond .5", 0.3, found([0.0, 0.4, 1.0], |v| if v > 0.5 { f64::INFINITY } else { bowl(v) }), 1e-3);
    table.near("chi-squared no number below .2", 0.3, found([0.0, 0.4, 1.0], |v| if v < 0.2 { f64::NAN } else { bowl(v) }), 1e-3);
    table.within("chi-squared always the same", 0.0, 1.0, found([0.0, 0.5, 1.0], |_| 1.0));
    let none = Parameter { name: "p".into(), start: 0.5, low: 0.0, high: 1.0 };
    // Bounds that hold nothing are refused.
    for (low, start, high) in [
        (1.0, 1.0, 1.0),
        (1.0, 0.5, 0.0),
        (0.0, 2.0, 1.0),
        (f64::NAN, 0.5, 1.0),
        (0.0, f64::NAN, 1.0),
        (0.0, 0.5, f64::INFINITY),
        (-1e308, 0.0, 1e308),
    ] {
        let refused = Annealer::new(vec![Parameter { low, start, high, ..none.clone() }], Options::default()).is_err();
        table.near(format!("bounds {low:e} to {high:e} from {start:e}: refused"), 1.0, f64::from(u8::from(refused)), 0.0);
    }
}
