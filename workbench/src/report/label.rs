//! Names of recordings for people.

/// The last part of a recording's path, or all of it where two of `all` would look alike.
pub fn label<'n, 'a>(name: &'n str, all: impl Iterator<Item = &'a str>) -> &'n str {
    let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let alike = all.filter(|other| other.ends_with(last)).count();
    if alike > 1 { name } else { last }
}

#[cfg(test)]
mod tests {
    use super::label;

    #[test]
    fn a_path_is_shown_where_two_names_look_alike() {
        let all = ["may/run.csv", "june/run.csv", "june/step.csv"];
        assert_eq!(label("june/step.csv", all.into_iter()), "step.csv");
        assert_eq!(label("june/run.csv", all.into_iter()), "june/run.csv");
    }
}
