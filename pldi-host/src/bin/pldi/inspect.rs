//! `pldi inspect`: stub
#[derive(Debug, clap::Args)]
pub struct Inspect {}
impl Inspect {
    pub fn run(&self) -> anyhow::Result<()> {
        Ok(())
    }
}
