//! A controller as a page.

use super::Page;
use crate::WorkbenchError;
use crate::figure::{loops, tracks};
use crate::report::tuned::TunedReport;

/// The page but for how it was made: the gains and what they do, then what they rest on.
///
/// # Errors
///
/// [`WorkbenchError`] if a figure cannot be drawn.
pub fn tuned(tuned: &TunedReport<'_>) -> Result<Page, WorkbenchError> {
    let mut page = Page::new("Controller of an SMA actuator", &tuned.verdict());
    page.section("What is followed, and how");
    page.how_to_read();
    for figure in tracks(tuned) {
        page.figure(&figure)?;
    }
    page.table(&tuned.tracks_table());
    page.section("The response to the step, by the terms of the cost (weighted)");
    page.table(&tuned.terms_table());
    page.section("Rest at the set point");
    page.table(&tuned.rest_table());
    page.section(match tuned.schedules {
        None => "How near the loop is to instability, where it is steepest",
        Some(_) => "How near the loop is to instability, at the worst level and branch",
    });
    for figure in loops(tuned) {
        page.figure(&figure)?;
    }
    if let Some(schedules) = tuned.schedules_table() {
        page.section("Gains by the output's level and branch");
        if let Some(factors) = tuned.schedule_table() {
            page.table(&factors);
        }
        page.table(&schedules);
    }
    page.section("What the gains stand");
    page.table(&tuned.robust_table());
    if let Some(front) = tuned.front_table() {
        page.section("Controllers of which none is both more accurate and more sparing");
        page.table(&front);
    }
    page.notes(&tuned.notes());
    Ok(page)
}
