use crate::context::Context;
use crate::failure::Failure;
use clap::Args;
/// x
#[derive(Args, Debug)]
pub(crate) struct Calibrate {}
impl Calibrate {
    pub(crate) fn run(self, _: &mut Context) -> Result<(), Failure> {
        Ok(())
    }
}
