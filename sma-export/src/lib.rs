#![doc = include_str!("../README.md")]

mod c;
mod constants;
mod error;
mod exported;
mod number;
mod python;
mod source;
mod template;

pub use c::{CNumbers, CPrefix, c_header};
pub use error::ExportError;
pub use exported::{Controller, Exported, Labels};
pub use python::python_module;
