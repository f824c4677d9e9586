//! From values on an axis to pixels: where cells begin and end, and which ticks get which label.

use crate::text::{Weight, width_px};

/// Labels with more characters are those of values that are no round numbers.
const LONG_LABEL: usize = 5;

/// One axis of the plot, with a cell around each value.
///
/// Linear between its ends, or logarithmic where each value is the same multiple of the one before; cells
/// meet halfway between neighbouring values, however irregular those are.
#[derive(Clone, Debug)]
pub struct Scale {
    /// The swept values, ascending.
    pub values: Vec<f64>,
    /// Borders of the cells, as they are spread.
    edges: Vec<f64>,
    spread: Spread,
    from_px: f64,
    to_px: f64,
}

/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Spread {
    Linear,
    Logarithmic,
}

impl Spread {
    /// Logarithmic for four positive values or more that grow by the same factor, but for their rounding.
    fn new(values: &[f64]) -> Self {
        let is_positive = values.iter().all(|value| *value > 0.0);
        if values.len() < 4 || !is_positive || is_even(values) {
            return Self::Linear;
        }
        let ratios: Vec<f64> = values.windows(2).map(|pair| libm::log(pair[1] / pair[0])).collect();
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        let is_alike = ratios.iter().all(|ratio| (ratio - mean).abs() <= 0.05 * mean);
        if is_alike { Self::Logarithmic } else { Self::Linear }
    }

    /// Where a value lies, before it is scaled to pixels; values without a logarithm lie far below all.
    fn place(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic => libm::log(value.max(1e-9)),
        }
    }
}

/// The least and the greatest of numbers; infinite where there is none.
pub fn ends(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let wider = |[low, high]: [f64; 2], value: f64| [low.min(value), high.max(value)];
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], wider)
}

impl Scale {
    /// Spreads the cells around ascending, finite values between two pixels.
    ///
    /// # Panics
    ///
    /// If there is no value.
    pub fn new(values: Vec<f64>, from_px: f64, to_px: f64) -> Self {
        let spread = Spread::new(&values);
        let places: Vec<f64> = values.iter().map(|value| spread.place(*value)).collect();
        Self { edges: edges(&places), values, spread, from_px, to_px }
    }

    /// Where a value lies, in pixels; outside the plot for values outside the cells.
    pub fn position_px(&self, value: f64) -> f64 {
        self.place_px(self.spread.place(value))
    }

    fn place_px(&self, place: f64) -> f64 {
        let low = self.edges[0];
        let high = self.edges[self.edges.len() - 1];
        self.from_px + (self.to_px - self.from_px) * ((place - low) / (high - low))
    }

    /// Whether what is straight in values is straight on the page.
    pub fn is_linear(&self) -> bool {
        self.spread == Spread::Linear
    }

    /// The pixels between which a value's cell lies, the smaller first.
    pub fn span_px(&self, index: usize) -> (f64, f64) {
        let one = self.place_px(self.edges[index]);
        let other = self.place_px(self.edges[index + 1]);
        (one.min(other), one.max(other))
    }

    /// Whether a value lies within the cells.
    pub fn contains(&self, value: f64) -> bool {
        let place = self.spread.place(value);
        self.edges[0] <= place && place <= self.edges[self.edges.len() - 1]
    }

    /// The labelled ticks: every value if there is room, else every few of them, or round numbers
    /// where evenly spaced values have long labels. The widest of some labels needs `room_px` along
    /// the axis, in pixels.
    pub fn ticks(&self, room_px: impl Fn(&[String]) -> f64) -> Vec<(f64, String)> {
        let texts = labels(&self.values);
        let room = room_px(&texts);
        let apart = self.apart(&self.values, room);
        if apart.len() < self.values.len() && is_even(&self.values) {
            let is_long = |text: &String| text.chars().count() > LONG_LABEL;
            if texts.iter().any(is_long) {
                return self.round_ticks(room_px);
            }
            return (2..self.values.len())
                .map(|stride| self.values.iter().copied().zip(texts.clone()).step_by(stride))
                .map(Iterator::collect::<Vec<_>>)
                .find(|ticks| {
                    let values: Vec<f64> = ticks.iter().map(|(value, _)| *value).collect();
                    self.apart(&values, room).len() == values.len()
                })
                .unwrap_or_else(|| vec![(self.values[0], texts[0].clone())]);
        }
        apart.into_iter().map(|index| (self.values[index], texts[index].clone())).collect()
    }

    /// Indices of values that are at least so far apart.
    fn apart(&self, values: &[f64], room_px: f64) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        for (index, value) in values.iter().enumerate() {
            let is_free = chosen.last().is_none_or(|last| {
                let away_px = self.position_px(*value) - self.position_px(values[*last]);
                away_px.abs() + 1e-6 >= room_px
            });
            if is_free {
                chosen.push(index);
            }
        }
        chosen
    }

    /// Multiples of the smallest 1, 2 or 5 times a power of ten whose labels have room.
    fn round_ticks(&self, room_px: impl Fn(&[String]) -> f64) -> Vec<(f64, String)> {
        let low = self.edges[0];
        let high = self.edges[self.edges.len() - 1];
        for step in round_steps([low, high]) {
            let values = multiples(step, low, high);
            let texts = labels(&values);
            if self.apart(&values, room_px(&texts)).len() == values.len() {
                return values.into_iter().zip(texts).collect();
            }
        }
        Vec::new()
    }
}

/// Round steps, ascending from a hundredth of a span.
pub fn round_steps([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    let decade = libm::pow(10.0, libm::floor(libm::log10((high - low) / 100.0)));
    (0..5).flat_map(move |power| {
        [1.0, 2.0, 5.0].map(|digit| digit * decade * libm::pow(10.0, f64::from(power)))
    })
}

fn is_even(values: &[f64]) -> bool {
    let gaps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let widest = gaps.iter().copied().fold(0.0, f64::max);
    gaps.iter().all(|gap| *gap >= 0.99 * widest)
}

fn multiples(step: f64, low: f64, high: f64) -> Vec<f64> {
    let first = libm::ceil(low / step);
    (0..1000)
        .map(|index| (first + f64::from(index)) * step)
        .take_while(|value| *value <= high)
        .collect()
}

/// Cell edges: halfway between neighbours, and symmetric about the first and the last value.
///
/// A lone value gets a cell of width 1.
fn edges(values: &[f64]) -> Vec<f64> {
    let (first, last) = match values {
        [] => panic!("an axis has at least one value"),
        [only] => return vec![only - 0.5, only + 0.5],
        [first, .., last] => (first, last),
    };
    let midpoints: Vec<f64> =
        values.windows(2).map(|pair| f64::midpoint(pair[0], pair[1])).collect();
    let mut edges = vec![2.0 * first - midpoints[0]];
    edges.extend(&midpoints);
    edges.push(2.0 * last - midpoints[midpoints.len() - 1]);
    edges
}

/// Values as labels: all with the same decimals, the fewest that keep every value where it is to
/// within a hundredth of the smallest gap.
pub fn labels(values: &[f64]) -> Vec<String> {
    let gap = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(f64::INFINITY, f64::min);
    let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let tolerance = if gap.is_finite() { 0.01 * gap } else { 0.001 * largest };
    let at = |decimals: usize| -> Vec<String> {
        values.iter().map(|value| format!("{value:.decimals$}")).collect()
    };
    let is_close = |texts: &[String]| {
        texts.iter().zip(values).all(|(text, value)| {
            let shown: f64 = text.parse().expect("a formatted number is a number");
            (shown - value).abs() <= tolerance
        })
    };
    let texts = (0..9).map(at).find(|texts| is_close(texts)).unwrap_or_else(|| at(9));
    texts.into_iter().map(|text| text.replace('-', "\u{2212}")).collect()
}

/// One value as a label.
pub fn label(value: f64) -> String {
    labels(&[value]).concat()
}

/// Width of the widest of some labels, in pixels.
pub fn widest_px(labels: &[String], size_px: f64) -> f64 {
    labels.iter().map(|label| width_px(label, size_px, Weight::Regular)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(left: f64, right: f64) -> bool {
        (left - right).abs() < 1e-9
    }

    #[test]
    fn cells_meet_halfway_between_irregular_values() {
        let scale = Scale::new(vec![1.0, 2.0, 10.0], 0.0, 135.0);

        assert_eq!(scale.edges, [0.5, 1.5, 6.0, 14.0]);
        assert!(close(scale.span_px(1).0, 10.0) && close(scale.span_px(1).1, 55.0));
        assert!(close(scale.position_px(2.0), 15.0));
    }

    #[test]
    fn values_that_grow_by_one_factor_have_cells_of_one_width() {
        let scale = Scale::new(vec![0.03, 0.06, 0.12, 0.24], 0.0, 400.0);

        let widths = (0..4).map(|index| scale.span_px(index)).map(|(from, to)| to - from);

        assert!(widths.into_iter().all(|width| close(width, 100.0)));
        assert!(close(scale.position_px(0.06), 150.0) && !scale.contains(0.0));
        assert!(scale.position_px(0.0) < 0.0, "far below");
    }

    #[test]
    fn an_axis_may_run_upwards_and_a_lone_value_sits_in_the_middle() {
        let upwards = Scale::new(vec![1.0, 2.0], 100.0, 0.0);
        assert!(close(upwards.position_px(1.0), 75.0));
        assert!(upwards.contains(2.5) && !upwards.contains(2.6));
        let lone = Scale::new(vec![9.0], 100.0, 0.0);
        assert!(close(lone.position_px(9.0), 50.0));
        assert!(close(lone.span_px(0).0, 0.0) && close(lone.span_px(0).1, 100.0));
    }

    #[test]
    fn crowded_labels_are_thinned_and_round_where_values_are_even() {
        let even: Vec<f64> = (0..10).map(f64::from).collect();
        let irregular = vec![1.0, 2.0, 3.0, 50.0, 100.0];
        let fine: Vec<f64> = (0..60).map(|step| 0.05 + 0.25 * f64::from(step) / 59.0).collect();
        let scale = |values: &[f64], to_px| Scale::new(values.to_vec(), 0.0, to_px);
        for (values, to_px, room_px, expected) in [
            (&even, 100.0, 25.0, &["0", "3", "6", "9"][..]),
            (&irregular, 125.0, 20.0, &["1", "50", "100"]),
            (&fine, 500.0, 40.0, &["0.05", "0.10", "0.15", "0.20", "0.25", "0.30"]),
        ] {
            let ticks = scale(values, to_px).ticks(|_| room_px);

            let texts: Vec<&str> = ticks.iter().map(|(_, text)| text.as_str()).collect();
            assert_eq!(texts, expected);
        }
        assert_eq!(scale(&even, 100.0).ticks(|_| 5.0).len(), 10);
        assert!(close(scale(&fine, 500.0).ticks(|_| 40.0)[2].0, 0.15), "it is where it belongs");
    }

    #[test]
    fn labels_share_the_fewest_decimals_that_distinguish_values() {
        assert_eq!(labels(&[0.05, 0.1, 0.2]), ["0.05", "0.10", "0.20"]);
        assert_eq!(labels(&[5.0, 9.0]), ["5", "9"]);
        assert_eq!(labels(&[0.1, 0.1 + 1.0 / 3.0]), ["0.100", "0.433"]);
        assert_eq!(labels(&[-0.5]), ["\u{2212}0.5"]);
        assert_eq!(label(0.0), "0");
    }
}
