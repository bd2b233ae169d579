//! The archive of a unit.

use crate::archive::archive;
use crate::fmu::description::description;
use crate::fmu::variables::{FMU_LIBRARY, FMU_MARK, Fmi};
use crate::{ExportError, Exported};

/// The unit for a version of the standard: its description, the library, and the model as it was kept. All effects and loops leave with
/// it.
///
/// # Errors
///
/// [`ExportError::SampleTime`], [`ExportError::Library`] for a library that is not of this program's version, [`ExportError::TooLarge`].
pub fn fmu(
    exported: &Exported,
    fmi: Fmi,
    model_toml: &str,
    library: &[u8],
) -> Result<Vec<u8>, ExportError> {
    if !(exported.dt_s > 0.0 && exported.dt_s.is_finite()) {
        return Err(ExportError::SampleTime {
            value: exported.dt_s,
        });
    }
    let platform = platform(fmi, library).map_err(|found| ExportError::Library { found })?;
    let description = description(exported, fmi);
    let binary = format!("binaries/{platform}/{FMU_LIBRARY}.so");
    archive(&[
        ("modelDescription.xml", description.as_bytes()),
        (&binary, library),
        ("resources/model.toml", model_toml.as_bytes()),
    ])
    .ok_or(ExportError::TooLarge)
}

/// Folder of the platform that a library is for, or what it is.
fn platform(fmi: Fmi, library: &[u8]) -> Result<&'static str, &'static str> {
    const MACHINE: std::ops::Range<usize> = 18..20;
    const X86_64: [u8; 2] = [62, 0];
    if !library.starts_with(b"\x7fELF\x02\x01") {
        return Err("no 64-bit ELF file");
    }
    let mark = FMU_MARK.as_bytes();
    if !library.windows(mark.len()).any(|part| part == mark) {
        return Err("another library, or one of another version");
    }
    match library.get(MACHINE) {
        Some(machine) if machine == X86_64 => Ok(match fmi {
            Fmi::V2 => "linux64",
            Fmi::V3 => "x86_64-linux",
        }),
        _ => Err("a library of another processor than x86-64"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_libraries_of_this_version_leave() {
        let mut library = b"\x7fELF\x02\x01".to_vec();
        library.resize(18, 0);
        library.extend([62, 0]);
        assert_eq!(
            platform(Fmi::V2, &library),
            Err("another library, or one of another version")
        );
        library.extend(FMU_MARK.as_bytes());
        assert_eq!(platform(Fmi::V2, &library), Ok("linux64"));
        assert_eq!(platform(Fmi::V3, &library), Ok("x86_64-linux"));
        library[18] = 183;
        assert!(platform(Fmi::V3, &library).is_err());
        assert_eq!(platform(Fmi::V2, b"MZ"), Err("no 64-bit ELF file"));
    }
}
