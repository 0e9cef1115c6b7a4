//! Writes the page: one HTML file that needs nothing else.

use super::chart;
use super::machine::Machine;
use super::result::{Bars, Figure, Section, Table, Value, Verdict};
use crate::figures::grouped;
use anyhow::Result;
use std::fmt::Write;

const STYLE: &str = include_str!("page.css");

/// Tables of more rows are folded up.
const OPEN_ROWS: usize = 12;

/// The answer in five numbers: each with what it is of.
pub(super) type Answer = Vec<(String, String)>;

pub(super) fn page(
    machine: &Machine,
    plan: &str,
    answer: &Answer,
    sections: &[Section],
    sum: &Verdict,
) -> Result<String> {
    let mut html = String::new();
    write!(
        html,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>trisap: the report</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <h1>How fast is trisap here, and is it right?</h1>\n"
    )?;
    html.push_str("<ul class=\"answer\">\n");
    for (number, of) in answer {
        writeln!(html, "<li><b>{}</b> {}</li>", escaped(number), escaped(of))?;
    }
    writeln!(
        html,
        "</ul>\n<p>{} The {plan} report; times are worth something where nothing else runs.</p>",
        escaped(&machine.to_string())
    )?;
    writeln!(html, "<p>{}</p>", verdict(sum))?;
    html.push_str("<nav><ul>\n");
    for section in sections {
        writeln!(html, "<li><a href=\"#{}\">{}</a></li>", section.id, escaped(section.title))?;
    }
    html.push_str("</ul></nav>\n");
    for section in sections {
        self::section(&mut html, section)?;
    }
    html.push_str("</body>\n</html>\n");
    Ok(html)
}

fn section(html: &mut String, section: &Section) -> Result<()> {
    writeln!(html, "<section id=\"{}\">\n<h2>{}</h2>", section.id, escaped(section.title))?;
    for paragraph in &section.text {
        writeln!(html, "<p>{}</p>", marked(paragraph))?;
    }
    if section.verdict.frames > 0 {
        writeln!(html, "<p>{}</p>", verdict(&section.verdict))?;
    }
    for bars in &section.bars {
        self::bars(html, bars)?;
    }
    if !section.figures.is_empty() {
        html.push_str("<div class=\"figures\">\n");
        for figure in &section.figures {
            self::figure(html, figure)?;
        }
        html.push_str("</div>\n");
    }
    for table in &section.tables {
        self::table(html, table)?;
    }
    html.push_str("</section>\n");
    Ok(())
}

fn verdict(sum: &Verdict) -> String {
    let Verdict { frames, pairs, misses, faults } = *sum;
    let checked = format!(
        "The pairs of {} steps were compared with an independent method: {} pairs, {} misses",
        grouped(frames),
        grouped(pairs),
        grouped(misses)
    );
    if sum.is_good() {
        format!("{checked}.")
    } else {
        format!("<span class=\"bad\">{checked}, {} other faults.</span>", grouped(faults))
    }
}

/// Drawn by the page itself: it has as much room as there is.
fn bars(html: &mut String, bars: &Bars) -> Result<()> {
    writeln!(html, "<h3>{} <small>{}</small></h3>\n<ul class=\"bars\">", escaped(&bars.title), bars.note)?;
    let most = bars.bars.iter().map(|(_, number)| *number).fold(f64::MIN_POSITIVE, f64::max);
    for (name, number) in &bars.bars {
        let (share, decimals) = (100.0 * number / most, bars.decimals);
        let name = escaped(name);
        writeln!(
            html,
            "<li>{name}<span><i style=\"width:{share:.1}%\"></i></span><b>{number:.decimals$} {}</b></li>",
            bars.unit
        )?;
    }
    html.push_str("</ul>\n");
    Ok(())
}

fn figure(html: &mut String, figure: &Figure) -> Result<()> {
    let title = escaped(&figure.title);
    writeln!(html, "<figure>\n<figcaption>{title} <small>{}</small></figcaption>", figure.note)?;
    let named = || figure.series.iter().filter(|series| !series.name.is_empty());
    let names: Vec<_> = named().map(|series| series.name.as_str()).collect();
    let label = format!("{}: {} over {}; {}", figure.title, figure.y.label, figure.x.label, names.join(", "));
    let svg = chart::draw(figure)?;
    let attributes = format!("<svg role=\"img\" aria-label=\"{}\" ", escaped(&label));
    writeln!(html, "{}", sized_by_the_page(&svg.replacen("<svg ", &attributes, 1)))?;
    html.push_str("<ul class=\"legend\">\n");
    for series in named() {
        let class = if series.reference { "reference" } else { "measured" };
        writeln!(
            html,
            "<li><i class=\"{class}\" style=\"border-color: var(--c{})\"></i>{}</li>",
            series.colour % chart::COLOURS.len(),
            escaped(&series.name)
        )?;
    }
    html.push_str("</ul>\n</figure>\n");
    Ok(())
}

/// The drawing without a size of its own.
fn sized_by_the_page(svg: &str) -> String {
    let (head, rest) = svg.split_once('>').unwrap_or((svg, ""));
    let mut kept = head.to_owned();
    for name in [" width=\"", " height=\""] {
        if let Some(start) = kept.find(name) {
            let end =
                kept[start + name.len()..].find('"').map_or(kept.len(), |at| start + name.len() + at + 1);
            kept.replace_range(start..end, "");
        }
    }
    format!("{kept}>{rest}")
}

fn table(html: &mut String, table: &Table) -> Result<()> {
    let open = if table.rows.len() <= OPEN_ROWS { " open" } else { "" };
    writeln!(
        html,
        "<details{open}><summary>{} (<a href=\"{id}.csv\">{id}.csv</a>)</summary>\n<div class=\"wide\"><table>\n<tr>",
        escaped(&table.title),
        id = table.id
    )?;
    let is_text = |column: usize| table.rows.iter().any(|row| matches!(row[column], Value::Text(_)));
    for (column, title) in table.columns.iter().enumerate() {
        writeln!(html, "<th{}>{}</th>", class(is_text(column)), escaped(title))?;
    }
    html.push_str("</tr>\n");
    for row in &table.rows {
        html.push_str("<tr>");
        for (column, value) in row.iter().enumerate() {
            let text = match value {
                Value::Text(text) => escaped(text),
                Value::Count(count) => grouped(*count),
                Value::Number(number, 0) => grouped(number.round() as u64),
                Value::Number(number, decimals) => format!("{number:.decimals$}"),
                Value::Missing => "–".into(),
            };
            write!(html, "<td{}>{text}</td>", class(is_text(column)))?;
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</table></div></details>\n");
    Ok(())
}

fn class(text: bool) -> &'static str {
    if text { " class=\"text\"" } else { "" }
}

/// With what stands between backticks as code.
fn marked(text: &str) -> String {
    let parts = text.split('`').enumerate();
    parts
        .map(|(at, part)| if at % 2 == 1 { format!("<code>{}</code>", escaped(part)) } else { escaped(part) })
        .collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_style_knows_the_colours_of_the_charts() {
        for (at, colour) in chart::COLOURS.iter().enumerate() {
            let hex = format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2);
            for attribute in ["stroke", "fill"] {
                let rule = format!("svg [{attribute}=\"{hex}\"] {{ {attribute}: var(--c{at}); }}");
                assert!(STYLE.contains(&rule), "{rule}");
            }
            assert!(STYLE.contains(&format!("--c{at}: {};", hex.to_lowercase())), "{hex}");
        }
    }

    #[test]
    fn backticks_become_code() {
        assert_eq!(marked("with `a<b` on"), "with <code>a&lt;b</code> on");
    }

    #[test]
    fn drawings_lose_their_size_and_nothing_else() {
        let svg = "<svg width=\"440\" height=\"320\" viewBox=\"0 0 440 320\">\n<rect width=\"1\"/></svg>";
        assert_eq!(sized_by_the_page(svg), "<svg viewBox=\"0 0 440 320\">\n<rect width=\"1\"/></svg>");
    }
}
