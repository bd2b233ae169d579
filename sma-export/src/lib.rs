#![doc = include_str!("../README.md")]

mod archive;
mod c;
mod constants;
mod error;
mod exported;
mod fmu;
mod number;
mod python;
mod source;
mod template;

pub use c::{CNumbers, CPrefix, c_header};
pub use error::ExportError;
pub use exported::{Controller, Exported, Labels};
pub use fmu::{FMU_LIBRARY, FMU_MARK, FMU_TIME, Fmi, FmuVariable, fmu, fmu_guid};
pub use python::python_module;
