//! The table of a fleet as CSV.

use super::{Estimated, FleetReport, Found, Row};

/// Columns before those of the parameters.
const COLUMNS: [&str; 18] = [
    "rig",
    "status",
    "verdict",
    "findings",
    "output_unit",
    "train_rmse",
    "validate_rmse",
    "extended_train_rmse",
    "extended_validate_rmse",
    "noise_lower",
    "noise_upper",
    "implausible",
    "exit_code",
    "failure",
    "failed_file",
    "failed_line",
    "unit",
    "command",
];

impl FleetReport<'_> {
    /// A row a rig, then its parameters: value and the ends of the 95 % interval of each.
    ///
    /// A parameter whose name has no unit is in `output_unit` or a number. Findings are divided by `"; "`. A value that there is
    /// not is empty; numbers have all their digits.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in self.parameter_names() {
            // Of outputs in two units a parameter has two, and one column.
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let columns = COLUMNS.map(str::to_owned).into_iter();
        let of_parameters = names.iter().flat_map(|name| {
            let ends = ["", "_lower", "_upper"];
            ends.map(|end| format!("{name}{end}"))
        });
        let mut csv = line(columns.chain(of_parameters));
        for row in &self.rows {
            let own = row.cells(self.command).into_iter();
            let of_parameters = names.iter().flat_map(|name| {
                let mut own = row.parameters.iter();
                let one = own.find(|one| one.name == *name);
                let ends = one.and_then(|one| one.ci95);
                [
                    number(one.map(|one| one.value)),
                    number(ends.map(|[lower, _]| lower)),
                    number(ends.map(|[_, upper]| upper)),
                ]
            });
            csv += &line(own.chain(of_parameters));
        }
        csv
    }
}

impl Row {
    fn cells(&self, command: &str) -> [String; 18] {
        let findings: Vec<String> = self.findings.iter().map(whole).collect();
        let failure = self.failure.as_ref();
        let or_empty = |text: Option<&str>| text.unwrap_or_default().to_owned();
        [
            self.rig.clone(),
            self.status.id().to_owned(),
            or_empty(self.verdict.as_deref()),
            findings.join("; "),
            or_empty(self.output_unit.as_deref()),
            number(self.train_rmse),
            number(self.validate_rmse),
            number(self.extended_train_rmse),
            number(self.extended_validate_rmse),
            number(self.noise_lower),
            number(self.noise_upper),
            self.implausible.join("; "),
            self.exit_code
                .map_or(String::new(), |code| code.to_string()),
            self.sentence().to_owned(),
            or_empty(failure.and_then(|failure| failure.file.as_deref())),
            failure
                .and_then(|failure| failure.line)
                .map_or(String::new(), |line| line.to_string()),
            or_empty(self.unit.as_deref()),
            command.to_owned(),
        ]
    }
}

/// A finding with its names, sizes and probability.
fn whole(found: &Found) -> String {
    let names = std::iter::once(&found.effect).chain(&found.could_also_be);
    let names: Vec<&str> = names.map(String::as_str).collect();
    let sizes = found.parameters.iter().map(|one| {
        let Estimated {
            name, value, unit, ..
        } = one;
        let ends = one.ci95.map_or(String::new(), |[lower, upper]| {
            format!(" [{lower}, {upper}]")
        });
        let unit = if unit == "1" {
            String::new()
        } else {
            format!(" {unit}")
        };
        format!("{name} = {value}{unit}{ends}")
    });
    let mut said: Vec<String> = sizes.collect();
    said.extend(
        found
            .probability
            .map(|probability| format!("p = {probability}")),
    );
    format!("{} ({})", names.join(" or "), said.join(", "))
}

fn number(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

/// Cells of a line, quoted where they must be; a line break within one becomes a space.
fn line(cells: impl Iterator<Item = String>) -> String {
    let cells = cells.map(|cell| {
        let cell = cell.replace(['\n', '\r'], " ");
        if cell.contains([',', '"']) {
            format!("\"{}\"", cell.replace('"', "\"\""))
        } else {
            cell
        }
    });
    cells.collect::<Vec<_>>().join(",") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        let cells = ["a", "b,c", "say \"d\"", "e\nf"].map(str::to_owned);
        assert_eq!(line(cells.into_iter()), "a,\"b,c\",\"say \"\"d\"\"\",e f\n");
    }
}
