//! Tables for a terminal.

use comfy_table::{Cell, CellAlignment, ContentArrangement, Table, TableComponent, presets};

/// Columns of a line beyond which a table folds its longest cells.
const WIDTH: u16 = 110;

/// A table without lines but one below its header.
pub fn table<'h>(header: impl IntoIterator<Item = &'h str>) -> Table {
    let mut table = Table::new();
    table
        .load_preset(presets::NOTHING)
        .set_style(TableComponent::HeaderLines, '─')
        .set_header(header.into_iter().collect::<Vec<_>>());
    table
}

/// A [`table`] that folds its longest cells if a line is too long.
pub fn folding<'h>(header: impl IntoIterator<Item = &'h str>) -> Table {
    let mut table = table(header);
    table
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(WIDTH);
    table
}

/// A cell whose text stands at the right.
#[must_use]
pub fn right(text: String) -> Cell {
    Cell::new(text).set_alignment(CellAlignment::Right)
}

/// Text without blanks at the ends of lines: tables pad their last column.
#[must_use]
pub fn unpadded(text: &str) -> String {
    text.lines()
        .map(|line| line.trim_end().to_owned() + "\n")
        .collect()
}
