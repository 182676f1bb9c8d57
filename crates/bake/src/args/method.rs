//! Options of the denoising methods, built from the tables of parameters in the library.

use super::limits::LimitArgs;
use super::values::possible;
use crate::failure::Failure;
use crate::method_table::{self, MethodOption};
use clap::builder::{NonEmptyStringValueParser, PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, Id, ValueEnum};
use planish_geometry::denoise::{Denoiser, Denoising, Values};
use planish_geometry::source::Source;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Settings that a method starts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum PresetArg {
    /// Settings that work on most meshes
    #[default]
    Default,
    /// Settings of the authors of the method
    Paper,
}

/// Returns a parser of the names of methods.
pub(super) fn denoiser() -> impl TypedValueParser<Value = Denoiser> {
    let every = Denoiser::every();
    let names = every.iter().map(|method| PossibleValue::new(method.name()).help(method_table::summary(method)));
    PossibleValuesParser::new(names.collect::<Vec<_>>()).try_map(|name| Denoiser::named(&name))
}

/// Lists all options that say how to denoise, which have no meaning if the denoised mesh is given.
pub(super) fn options() -> Vec<Id> {
    let command = MethodArgs::augment_args(Command::new("denoise"));
    command.get_arguments().map(|arg| arg.get_id().clone()).collect()
}

/// Options for the method, its settings and its limits.
#[derive(Args, Debug)]
#[command(next_help_heading = "Denoising")]
pub(crate) struct MethodArgs {
    /// Denoising method; `planish help methods` lists the settings of each
    #[arg(long, value_parser = denoiser(), default_value = Denoiser::default().name())]
    method: Denoiser,
    /// Settings to start from; paper has those of the method's authors, where they differ
    #[arg(long, value_enum, default_value_t)]
    preset: PresetArg,
    #[command(flatten)]
    settings: SettingArgs,
    #[command(flatten)]
    limits: LimitArgs,
}

impl MethodArgs {
    /// Returns the method with its settings, and its limits for the mesh that was read from `path`.
    pub(crate) fn denoising(&self, source: &Source, path: &Path) -> Result<Denoising, Failure> {
        Ok(Denoising { denoiser: self.denoiser()?, limits: self.limits.limits(source, path)? })
    }

    /// Fails if the method does not have a setting that was given.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        self.denoiser().map(drop)
    }

    /// Lists the files of `--fix` and `--mask`.
    pub(crate) fn masks(&self) -> impl Iterator<Item = &PathBuf> {
        self.limits.masks()
    }

    /// Returns true if the method measures the noise at each vertex.
    pub(crate) fn measures_noise(&self) -> bool {
        matches!(self.method, Denoiser::Auto(_))
    }

    fn denoiser(&self) -> Result<Denoiser, Failure> {
        let mut denoiser = match self.preset {
            PresetArg::Default => self.method.clone(),
            PresetArg::Paper => {
                let paper = self.method.paper();
                paper.ok_or_else(|| goes_with("--preset paper", |method| method.paper().is_some()))?
            }
        };
        let given = &self.settings.given;
        if let Some((name, _)) = given.iter().find(|(name, _)| denoiser.parameter(name).is_none()) {
            return Err(goes_with(&format!("--{name}"), |method| method.parameter(name).is_some()));
        }
        denoiser.set_all(given).map_err(|e| Failure::Input(e.to_string()))?;
        Ok(denoiser)
    }
}

/// Makes the error of an option that the chosen method does not have.
fn goes_with(option: &str, has_it: impl Fn(&Denoiser) -> bool) -> Failure {
    let every = Denoiser::every();
    let methods: Vec<&str> = every.iter().filter(|method| has_it(method)).map(Denoiser::name).collect();
    Failure::Input(format!("{option} goes with --method {}", methods.join(", ")))
}

/// Settings that the user gave, by the names of their parameters.
#[derive(Debug)]
struct SettingArgs {
    given: Vec<(&'static str, Value)>,
}

impl Args for SettingArgs {
    fn augment_args(command: Command) -> Command {
        command.args(method_table::options().iter().map(arg))
    }
    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// Builds the option of a parameter.
fn arg(option: &MethodOption) -> Arg {
    let parameter = option.parameter();
    let arg = Arg::new(parameter.name).long(parameter.name).help(option.help());
    let arg = arg.aliases(parameter.alias);
    let word = || PossibleValuesParser::new(possible(parameter.choices())).map(Value::from);
    match parameter.values {
        Values::Word(_) | Values::Preset(_) => arg.value_name("WORD").value_parser(word()),
        Values::Words(_) => arg.value_name("WORDS").value_delimiter(',').action(ArgAction::Append).value_parser(word()),
        Values::Text(_) => arg.value_name("FILE").value_parser(NonEmptyStringValueParser::new().map(Value::from)),
        Values::Count { .. } | Values::Number { .. } => {
            let parse = move |text: &str| parameter.parse(text);
            let name = if matches!(parameter.values, Values::Count { .. }) { "N" } else { "X" };
            arg.value_name(name).allow_negative_numbers(true).value_parser(ValueParser::new(parse))
        }
    }
}

impl FromArgMatches for SettingArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let value = |option: MethodOption| {
            let mut values = matches.get_many::<Value>(option.name())?.cloned();
            let value = match option.parameter().values {
                Values::Words(_) => values.collect(),
                _ => values.next_back()?,
            };
            Some((option.name(), value))
        };
        Ok(Self { given: method_table::options().into_iter().filter_map(value).collect() })
    }
    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
