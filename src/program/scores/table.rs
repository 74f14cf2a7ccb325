//! A table as text: cells that are already words or figures.

use std::fmt::Write as _;

/// A table with a title and a line about what its figures mean.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub(crate) struct Table {
    /// What it shows.
    pub(crate) title: String,
    /// What the figures are and how they were taken.
    pub(crate) note: String,
    /// Names of the columns.
    pub(crate) head: Vec<String>,
    /// Rows of as many cells; a cell without a figure holds a dash.
    pub(crate) rows: Vec<Vec<String>>,
}

impl Table {
    /// Aligned columns for a terminal, the first to the left, the others to the right.
    pub(crate) fn to_text(&self) -> String {
        let lines = || std::iter::once(&self.head).chain(&self.rows);
        let width = |column: usize| {
            lines().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max()
        };
        let widths: Vec<usize> = (0..self.head.len()).map(|c| width(c).unwrap_or(0)).collect();
        let mut text = format!("{}\n{}\n", self.title, self.note);
        for row in lines() {
            let mut line = String::new();
            for (i, (cell, &width)) in row.iter().zip(&widths).enumerate() {
                // Writing to a string cannot fail.
                let _ = if i == 0 {
                    write!(line, "  {cell:<width$}")
                } else {
                    write!(line, "  {cell:>width$}")
                };
            }
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text
    }

    /// A Markdown section with the table.
    pub(crate) fn to_markdown(&self) -> String {
        let row = |cells: &[String]| {
            let cells: Vec<_> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let mut text = format!("## {}\n\n{}\n\n{}", self.title, self.note, row(&self.head));
        let rules = (0..self.head.len()).map(|i| if i == 0 { "---" } else { "---:" });
        text += &format!("| {} |\n", rules.collect::<Vec<_>>().join(" | "));
        self.rows.iter().for_each(|cells| text += &row(cells));
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let words = |cells: &[&str]| cells.iter().map(|&cell| cell.to_owned()).collect::<Vec<_>>();
        Table {
            title: "T".into(),
            note: "n.".into(),
            head: words(&["name", "x"]),
            rows: vec![words(&["a|b", "1"]), words(&["é", "-10"])],
        }
    }

    #[test]
    fn text_is_aligned() {
        assert_eq!(table().to_text(), "T\nn.\n  name    x\n  a|b     1\n  é     -10\n");
    }

    #[test]
    fn markdown_keeps_bars_apart() {
        let text = table().to_markdown();
        assert!(text.contains("| name | x |\n| --- | ---: |\n| a\\|b | 1 |\n"), "{text}");
    }
}
