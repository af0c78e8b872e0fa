//! `encoring program`: values that shall count, all of them or none.

use std::path::PathBuf;

use clap::Args;
use encoring_workshop::{KeptEncoder, ParameterFile};

use crate::arguments::bus::Target;
use crate::arguments::range::{Range, Wanted, wanted};
use crate::output::{Answer, Failure, bad_input};
use crate::programming::How;

/// Program an encoder: write, check, read back, compare
///
/// It begins nothing that the data check would refuse. If a step fails it writes the old values back and checks them. The
/// report shows what every parameter holds at the end.
#[derive(Args, Debug)]
#[command(
    args_conflicts_with_subcommands = false,
    after_help = "\
Exit codes:
  0  done and verified, or nothing to change
  1  refused by the encoder, not confirmed, or another master is at work
  2  wrong input or wrong usage
  3  no answer, or the values are not known afterwards

Examples:
  encoring program --bus sim --at 2 rotary --steps-per-turn 1000 --turns 3.5
  encoring program --bus sim --at 0 --yes linear --length-mm 500 --resolution-mm 0.1
  encoring program --bus modbus-tcp://192.168.1.10 --at 1 --model ce-100-m --file axis-3.toml"
)]
pub(crate) struct Arguments {
    /// The range instead of a file
    #[command(subcommand)]
    range: Option<Range>,
    /// File of parameters, such as a backup; a parameter that is not in it stays as it is
    #[arg(long, value_name = "FILE.toml")]
    file: Option<PathBuf>,
    #[command(flatten)]
    how: How,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let file = match (&arguments.file, &arguments.range) {
        (Some(path), None) => {
            let file = ParameterFile::read(path).map_err(bad_input)?;
            let at = arguments.how.encoder.at;
            let kept = file.at(at).map_err(|problem| bad_input(format!("{}: {problem}", path.display())))?;
            if kept.values.is_empty() && kept.parts.is_empty() {
                let path = path.display();
                return Err(bad_input(format!("{path}: no value in [parameters], so nothing to program")));
            }
            file.may_be_written(path, kept).map_err(bad_input)?;
            Some(kept.clone())
        }
        (None, Some(_)) => None,
        (Some(_), Some(_)) => {
            return Err(bad_input("--file and a range are two ways to say the values; give one of them"));
        }
        (None, None) => {
            return Err(bad_input(
                "nothing to program is given: add --file FILE.toml, rotary ..., or linear ...",
            ));
        }
    };
    arguments.how.run("program", |target| match (file, &arguments.range) {
        (Some(file), _) => of_file(file, target),
        (None, Some(range)) => wanted(range, target.model, target.steps_per_turn()),
        (None, None) => Ok(Wanted::default()),
    })
}

/// The values of a file, if it is one of this encoder.
fn of_file(file: KeptEncoder, target: Target) -> Result<Wanted, Failure> {
    if file.model != target.model {
        return Err(bad_input(format!(
            "--file: the values are of a {}, the encoder is a {}; `encoring restore --as {}` carries values over",
            file.model, target.model, target.model
        )));
    }
    match (file.label.native, target.native) {
        (Some(file), Some(own)) if file != own => Err(bad_input(format!(
            "--file: the values are of an encoder with {file} steps per turn, this one has {own}; look at its rating plate"
        ))),
        _ => {
            let whole = file.values.into_iter().map(|(parameter, value)| (parameter, value.into()));
            Ok(Wanted { values: whole.chain(file.parts).collect(), warnings: Vec::new(), zero: None })
        }
    }
}
