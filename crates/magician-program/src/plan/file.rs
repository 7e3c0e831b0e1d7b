//! Plans as files of our own.

use super::Plan;
use crate::Problem;
use crate::formats::{ReadOptions, Reading};

pub(crate) fn read(_bytes: &[u8], _options: &ReadOptions) -> Result<Reading<Plan>, Problem> {
    Err(Problem::of_file("this format is not read yet"))
}
