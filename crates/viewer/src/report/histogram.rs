//! Histograms as pictures that any browser draws.

use super::{html, rounded};
use std::fmt::Write as _;

/// A histogram of numbers.
#[derive(Clone, Debug)]
pub struct Histogram {
    /// Heading.
    pub title: String,
    /// Meaning of the numbers.
    pub caption: String,
    /// Unit of the numbers.
    pub unit: String,
    /// Numbers at the ends of the bins.
    range: [f64; 2],
    /// Count of numbers in each bin.
    bins: Vec<usize>,
    /// Count of numbers outside of the bins.
    outside: usize,
}

/// Number of bins.
const BINS: usize = 40;

/// Width and height of the picture, and the height of the axis below the bars.
const SIZE: [f64; 3] = [320.0, 150.0, 20.0];

impl Histogram {
    /// Counts numbers in bins of one width, from the 0.5th to the 99.5th percentile, so that a few far ones do not squeeze all others
    /// into one bin. `None` if no number is finite.
    pub fn new(title: &str, caption: &str, unit: &str, numbers: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = numbers.into_iter().filter(|x| x.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        if sorted.is_empty() {
            return None;
        }
        // Numbers that are there, so that of a few none is outside.
        let last = (sorted.len() - 1) as f64;
        let [mut low, mut high] = [(0.005 * last).floor(), (0.995 * last).ceil()].map(|rank| sorted[rank as usize]);
        if low == high {
            let margin = if low == 0.0 { 1.0 } else { 0.5 * low.abs() };
            (low, high) = (low - margin, high + margin);
        }
        let mut bins = vec![0; BINS];
        let mut outside = 0;
        for x in sorted {
            if (low..=high).contains(&x) {
                let bin = (BINS as f64 * ((x - low) / (high - low))) as usize;
                bins[bin.min(BINS - 1)] += 1;
            } else {
                outside += 1;
            }
        }
        let [title, caption, unit] = [title, caption, unit].map(str::to_owned);
        Some(Self { title, caption, unit, range: [low, high], bins, outside })
    }

    /// The histogram as a figure of HTML.
    pub(super) fn figure(&self) -> String {
        let [width, height, axis] = SIZE;
        let [low, high] = self.range;
        let most = self.bins.iter().max().copied().unwrap_or(0).max(1) as f64;
        let base = height - axis;
        let title = html(&self.title);
        let mut out = format!("<figure><svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{title}\">");
        let step = width / BINS as f64;
        for (i, &count) in self.bins.iter().enumerate().filter(|(_, count)| **count > 0) {
            let tall = ((base - 4.0) * count as f64 / most).max(0.5);
            let (x, y, w) = (i as f64 * step + 0.5, base - tall, step - 1.0);
            let _ = write!(out, "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{tall:.1}\"/>");
        }
        let _ = write!(out, "<line x1=\"0\" y1=\"{base}\" x2=\"{width}\" y2=\"{base}\"/>");
        let mut label = |x: f64, anchor: &str, number: f64| {
            let y = height - 5.0;
            let _ = write!(out, "<text x=\"{x:.1}\" y=\"{y}\" text-anchor=\"{anchor}\">{}</text>", rounded(number));
        };
        label(0.0, "start", low);
        label(width, "end", high);
        let zero = width * -low / (high - low);
        if (60.0..width - 60.0).contains(&zero) {
            label(zero, "middle", 0.0);
        }
        let outside = match self.outside {
            0 => String::new(),
            n => format!(" {n} lie outside."),
        };
        let caption = format!("{} In {}.{outside}", self.caption, self.unit);
        let _ = writeln!(out, "</svg><figcaption><b>{title}.</b> {}</figcaption></figure>", html(&caption));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_counted_once() {
        let numbers = (0..1000).map(f64::from).chain([f64::NAN, 1e9]);
        let histogram = Histogram::new("a", "b", "c", numbers).unwrap();
        assert_eq!(histogram.bins.iter().sum::<usize>() + histogram.outside, 1001);
        let (least, most) = (histogram.bins.iter().min().unwrap(), histogram.bins.iter().max().unwrap());
        assert!(most - least <= 2, "even numbers fill even bins: {:?}", histogram.bins);
        assert!(histogram.outside > 0 && histogram.figure().contains("lie outside"));
    }

    #[test]
    fn numbers_that_are_all_alike_lie_in_the_middle_and_none_have_no_histogram() {
        for x in [0.0, 3.5, -2.0] {
            let bins = Histogram::new("a", "b", "c", [x; 7]).unwrap().bins;
            assert_eq!(bins[BINS / 2], 7, "{x}: {bins:?}");
        }
        assert!(Histogram::new("a", "b", "c", [f64::NAN]).is_none());
    }
}
