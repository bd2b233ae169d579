//! Grey-box identification of a Wiener model from recordings
