//! Draws a figure as SVG.
//!
//! Colours are those of the light scheme; the page's style replaces them in the dark one. Legends are the page's, so that
//! they can break into lines.

use super::result::{Axis, Figure, Scale, Series};
use anyhow::{Result, anyhow};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;
use std::ops::Range;

/// Narrow, so that the text stays readable where the page is as narrow as a phone.
const SIZE: (u32, u32) = (440, 320);
/// Of the text; the library takes it for the height of a line.
const TEXT: i32 = 19;
const DOT: i32 = 3;

/// Of the series, the text and the grid. Whoever changes one changes the style of the page as well.
pub(super) const COLOURS: [RGBColor; 6] = [
    RGBColor(0x00, 0x63, 0xa6),
    RGBColor(0xc4, 0x4e, 0x00),
    RGBColor(0x00, 0x7a, 0x5a),
    RGBColor(0x9a, 0x3f, 0x86),
    RGBColor(0x8a, 0x66, 0x00),
    RGBColor(0x5b, 0x5b, 0xd6),
];
const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
const GRID: RGBColor = RGBColor(0xdd, 0xdd, 0xdd);

pub(super) fn draw(figure: &Figure) -> Result<String> {
    let mut svg = String::new();
    let points = || figure.series.iter().flat_map(|series| series.points.iter().copied());
    let x = Ticks::over(&figure.x, points().map(|(x, _)| x));
    let y = Ticks::over(&figure.y, points().map(|(_, y)| y));
    lines(SVGBackend::with_string(&mut svg, SIZE).into_drawing_area(), figure, x, y)
        .map_err(|error| anyhow!("cannot draw '{}': {error}", figure.title))?;
    Ok(svg)
}

fn lines<'a>(
    area: DrawingArea<SVGBackend<'a>, plotters::coord::Shift>,
    figure: &Figure,
    x: Ticks,
    y: Ticks,
) -> Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>> {
    let mut chart = ChartBuilder::on(&area)
        .margin(8)
        .margin_top(14)
        .margin_right(20)
        .x_label_area_size(46)
        .y_label_area_size(66)
        .build_cartesian_2d(x, y)?;
    let text = ("sans-serif", TEXT).into_font().color(&INK);
    chart
        .configure_mesh()
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .label_style(text.clone())
        .axis_desc_style(text)
        .x_desc(figure.x.label)
        .y_desc(figure.y.label)
        .draw()?;
    for Series { points, reference, colour, .. } in &figure.series {
        let style = COLOURS[colour % COLOURS.len()].stroke_width(2);
        if *reference {
            chart.draw_series(DashedLineSeries::new(points.iter().copied(), 6, 4, style))?;
        } else {
            chart.draw_series(LineSeries::new(points.iter().copied(), style))?;
            chart.draw_series(points.iter().map(|&at| Circle::new(at, DOT, style.filled())))?;
        }
    }
    area.present()
}

/// The numbers along an axis.
struct Ticks {
    scale: Scale,
    /// Places, as [`Ticks::place`] gives them, and those of the numbers.
    low: f64,
    high: f64,
    at: Vec<f64>,
}

impl Ticks {
    fn over(axis: &Axis, values: impl Iterator<Item = f64>) -> Self {
        let (least, most) = values.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
        match axis.scale {
            Scale::Linear => Self::linear(if most > 0.0 { most } else { 1.0 }),
            Scale::Logarithmic => Self::logarithmic(least, most),
        }
    }

    /// From zero, with four to eight round steps.
    fn linear(most: f64) -> Self {
        let power = 10_f64.powf((most / 4.0).log10().floor());
        let step = [5.0, 2.0, 1.0].map(|round| round * power).into_iter().find(|step| most / step >= 4.0);
        let step = step.unwrap_or(power);
        let count = (most / step).ceil();
        let at = (0..=count as u32).map(|k| f64::from(k) * step).collect();
        Self { scale: Scale::Linear, low: 0.0, high: count * step, at }
    }

    /// Powers of ten, as far apart as there is room for their labels.
    fn logarithmic(least: f64, most: f64) -> Self {
        let (low, high) = if least > 0.0 { (least.log10(), most.log10()) } else { (0.0, 1.0) };
        let (low, high) = (low - 0.05, high + 0.05);
        let (first, last) = (low.ceil() as i32, high.floor() as i32);
        let apart = ((last - first) / 6 + 1) as usize;
        let mut at: Vec<f64> = (first..=last).step_by(apart).map(f64::from).collect();
        if at.len() < 2 {
            // Less than two powers: 2 and 5 as well.
            let decades = low.floor() as i32..=high.ceil() as i32;
            let all = decades.flat_map(|k| [1.0, 2.0, 5.0].map(|round: f64| f64::from(k) + round.log10()));
            at = all.filter(|place| (low..=high).contains(place)).collect();
        }
        Self { scale: Scale::Logarithmic, low, high, at }
    }

    /// Where a value stands.
    fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Logarithmic => value.log10(),
        }
    }

    /// The value at a place.
    fn value(&self, place: f64) -> f64 {
        match self.scale {
            Scale::Linear => place,
            Scale::Logarithmic => 10_f64.powf(place),
        }
    }
}

impl Ranged for Ticks {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        let share = (self.place(*value) - self.low) / (self.high - self.low);
        (f64::from(start) + share * f64::from(end - start)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.at.iter().map(|place| self.value(*place)).collect()
    }

    fn range(&self) -> Range<f64> {
        self.value(self.low)..self.value(self.high)
    }
}

impl ValueFormatter<f64> for Ticks {
    /// Short: 1,024,000 would not fit on a phone.
    fn format(value: &f64) -> String {
        let value = *value;
        let text = |value: f64| {
            let digits = (2.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 9.0);
            let text = format!("{value:.*}", digits as usize);
            if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.').to_owned()
            } else {
                text
            }
        };
        match value.abs() {
            0.0 => "0".into(),
            size if size >= 999_999_999.5 => format!("{} G", text(value / 1e9)),
            size if size >= 999_999.5 => format!("{} M", text(value / 1e6)),
            size if size >= 999.5 => format!("{} k", text(value / 1e3)),
            _ => text(value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        for most in [0.003, 0.07, 1.0, 7.3, 99.9, 100.0, 1234.5] {
            let ticks = Ticks::linear(most);
            assert!((5..=9).contains(&ticks.at.len()), "{most}: {:?}", ticks.at);
            assert!(ticks.high >= most && ticks.high < 1.5 * most, "{most}: {}", ticks.high);
        }
        for (least, most) in [(1e3, 1.024e6), (0.02, 0.05), (0.9, 11.0), (1e-3, 1e9), (5.0, 5.0)] {
            let ticks = Ticks::logarithmic(least, most);
            assert!((1..=8).contains(&ticks.at.len()) || least == most, "{least} to {most}: {:?}", ticks.at);
            assert!(ticks.low < least.log10() && ticks.high > most.log10());
        }
    }

    #[test]
    fn labels_are_short() {
        let labels = [0.0, 0.01, 0.25, 1.0, 1e3, 1.5e6, 1e9].map(|value| Ticks::format(&value));
        assert_eq!(labels, ["0", "0.01", "0.25", "1", "1 k", "1.5 M", "1 G"]);
    }
}
