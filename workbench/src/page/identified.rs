//! An identified model as a page.

use super::Page;
use crate::WorkbenchError;
use crate::figure::Compared;
use crate::report::identified::Identified;

/// The page but for how it was made: how well the model does, then the recording that it meets worst.
///
/// # Errors
///
/// [`WorkbenchError`] if a figure cannot be drawn.
pub fn identified(
    identified: &Identified<'_>,
    worst: &Compared<'_>,
) -> Result<Page, WorkbenchError> {
    let mut page = Page::new("Model of an SMA actuator", &identified.verdict());
    page.section("The parameters");
    page.table(&identified.parameters());
    page.section("The recording that is met worst, and what the model says");
    page.how_to_read();
    for figure in worst.figures() {
        page.figure(&figure)?;
    }
    page.section("The recordings");
    page.table(&identified.recordings());
    page.notes(&identified.notes());
    Ok(page)
}
