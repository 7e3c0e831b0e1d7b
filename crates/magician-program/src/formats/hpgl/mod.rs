//! HPGL plots (`.plt`).

use super::{ReadOptions, Reading};
use crate::Problem;

pub(super) fn read(_bytes: &[u8], _options: &ReadOptions) -> Result<Reading, Problem> {
    Err(Problem::of_file("this format is not read yet"))
}
