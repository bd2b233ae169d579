//! The roads from the baseline model to models with effects.

pub(crate) mod complete;
pub(crate) mod credit;
pub(crate) mod exchange;
pub(crate) mod families;
mod growth;
pub(crate) mod known;
pub(crate) mod occurs;
pub(crate) mod odds;
mod populations;
pub(crate) mod promote;
pub(crate) mod refit;
pub(crate) mod roads;
pub(crate) mod settle;
pub(crate) mod survey;
pub(crate) mod weighing;

pub(crate) use occurs::testable;
pub(crate) use promote::promoted;
pub(crate) use survey::Survey;
pub(crate) use weighing::at;
