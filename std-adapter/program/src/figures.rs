//! Figures for people: medians, and numbers that can be read.

/// The smallest value that at least `share` of all values do not exceed; zero where there are none.
pub(crate) fn quantile<T: Copy + Default + PartialOrd>(values: &[T], share: f64) -> T {
    let mut sorted = values.to_vec();
    sorted.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or_default()
}

pub(crate) fn median<T: Copy + Default + PartialOrd>(values: &[T]) -> T {
    quantile(values, 0.5)
}

/// With commas: 1,024,000.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// `number` and the noun, with an s where it is not one.
pub(crate) fn counted(number: u64, noun: &str) -> String {
    let s = if number == 1 { "" } else { "s" };
    format!("{} {noun}{s}", grouped(number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_that_occurred() {
        let values: Vec<u32> = (1..=20).rev().collect();
        assert_eq!((median(&values), quantile(&values, 0.95), quantile(&values, 1.0)), (10, 19, 20));
        assert_eq!((median(&[7]), quantile(&[7], 0.95)), (7, 7));
        assert_eq!(median::<f64>(&[]), 0.0);
    }

    #[test]
    fn numbers_are_grouped() {
        let texts = [0, 999, 1000, 1_024_000].map(grouped);
        assert_eq!(texts, ["0", "999", "1,000", "1,024,000"]);
        assert_eq!((counted(1, "frame"), counted(2, "frame")), ("1 frame".into(), "2 frames".into()));
    }
}
