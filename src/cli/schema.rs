//! `sinew schema`: the JSON Schema of the muscle file.

use crate::failure::Failure;
use crate::print;
use sinew::rig::muscle_file;

pub fn run() -> Result<(), Failure> {
    print::line(&serde_json::to_string_pretty(&muscle_file::schema()).map_err(Failure::input)?)
}
