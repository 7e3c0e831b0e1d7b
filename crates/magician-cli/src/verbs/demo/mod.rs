//! Demonstration.
mod picture;
mod scene;

use crate::context::Context;
use crate::failure::Failure;
use clap::Args;

/// Watch an arm pick and place six cubes, and get a picture of it
#[derive(Args, Debug)]
pub(crate) struct Demo {}

impl Demo {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        Ok(())
    }
}
