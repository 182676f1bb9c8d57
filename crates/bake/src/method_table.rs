//! Prints the tables of parameters: in the help, in `planish methods`, and in `docs/methods.md`.

use planish_geometry::denoise::{Denoiser, Parameter, Values};
use serde_json::Value;
use std::fmt::Write as _;

/// An option of the command line: the parameters of one name, in all methods that have it.
pub(crate) struct MethodOption {
    /// Methods with their parameter of that name; at least one.
    users: Vec<(Denoiser, &'static Parameter)>,
}

/// Returns all options, in the order in which methods name them.
pub(crate) fn options() -> Vec<MethodOption> {
    let mut all: Vec<MethodOption> = Vec::new();
    for method in Denoiser::every() {
        for parameter in method.options() {
            let user = (method.clone(), parameter);
            match all.iter_mut().find(|option| option.name() == parameter.name) {
                Some(option) => option.users.push(user),
                None => all.push(MethodOption { users: vec![user] }),
            }
        }
    }
    all
}

impl MethodOption {
    /// Name of the option, without dashes.
    pub(crate) fn name(&self) -> &'static str {
        self.parameter().name
    }

    /// Parameter of the first method that has the option; name and values are the same in all methods.
    pub(crate) fn parameter(&self) -> &'static Parameter {
        self.users[0].1
    }

    /// Help for the command line: methods with the meaning of the option, defaults and range.
    pub(crate) fn help(&self) -> String {
        let names = |methods: &[&str]| methods.join(", ");
        let meanings = self.grouped(|_, parameter| meaning(parameter));
        let meanings: Vec<String> =
            meanings.iter().map(|(text, methods)| format!("{}: {text}", names(methods))).collect();
        let mut defaults = self.grouped(default_text);
        // The default that most methods share is printed without their names.
        defaults.sort_by_key(|(_, methods)| std::cmp::Reverse(methods.len()));
        let other = defaults.iter().skip(1).map(|(text, methods)| format!("; {text} with {}", names(methods)));
        let default = defaults.first().map(|(text, _)| text.clone()).into_iter().chain(other).collect::<String>();
        let range = range(self.parameter()).map(|range| format!(" [range: {range}]")).unwrap_or_default();
        format!("{} [default: {default}]{range}", meanings.join("; "))
    }

    /// Groups methods for which `text` is equal.
    fn grouped(&self, text: impl Fn(&Denoiser, &Parameter) -> String) -> Vec<(String, Vec<&'static str>)> {
        let mut groups: Vec<(String, Vec<&'static str>)> = Vec::new();
        for (method, parameter) in &self.users {
            let text = text(method, parameter);
            match groups.iter_mut().find(|group| group.0 == text) {
                Some(group) => group.1.push(method.name()),
                None => groups.push((text, vec![method.name()])),
            }
        }
        groups
    }
}

/// Summary of a method with its paper.
pub(crate) fn summary(method: &Denoiser) -> String {
    let cite = method.info().reference.map(|paper| format!(" ({})", paper.cite)).unwrap_or_default();
    format!("{}{cite}", method.summary())
}

/// Meaning of a parameter, with its unit.
fn meaning(parameter: &Parameter) -> String {
    let unit = parameter.unit.map(|unit| format!(", in {unit}")).unwrap_or_default();
    format!("{}{unit}", parameter.help)
}

/// Default of a parameter of a method, as text.
fn default_text(method: &Denoiser, parameter: &Parameter) -> String {
    let sets_it = |p: &&Parameter| {
        matches!(p.values, Values::Preset(_)) && p.name != parameter.name && parameter.pointer.starts_with(p.pointer)
    };
    match (method.options().find(sets_it), method.get(parameter)) {
        (Some(preset), _) => format!("as --{} has it", preset.name),
        (None, Value::Null) if matches!(parameter.values, Values::Text(_)) => "built in".to_owned(),
        (None, Value::Null) => "chosen from the mesh".to_owned(),
        (None, value) => parameter.text(&value),
    }
}

/// Range of a numeric parameter; `None` for words.
fn range(parameter: &Parameter) -> Option<String> {
    match parameter.values {
        Values::Count { max, .. } => Some(format!("0 to {max}")),
        Values::Number { min, max, .. } => Some(format!("{min} to {max}")),
        Values::Word(_) | Values::Words(_) | Values::Preset(_) | Values::Text(_) => None,
    }
}

/// Lists methods and their parameters for people.
pub(crate) fn text(methods: &[Denoiser]) -> String {
    let mut out = String::new();
    for method in methods {
        let _ = writeln!(out, "{}\n  {}", method.name(), summary(method));
        for parameter in method.options() {
            let range = range(parameter).map(|range| format!(" [range: {range}]")).unwrap_or_default();
            let default = default_text(method, parameter);
            let name = parameter.name;
            let _ = writeln!(out, "    --{name:17} {} [default: {default}]{range}", meaning(parameter));
            // Words are listed only for a single method; for all methods they would be many lines.
            for word in parameter.choices().iter().filter(|_| methods.len() == 1) {
                let _ = writeln!(out, "      {:17} {}", word.name, word.help);
            }
        }
        out.push('\n');
    }
    if methods.len() > 1 {
        out.push_str("`planish methods NAME` shows one of them, with all words that its settings take.\n");
    }
    out
}

const MARKDOWN_HEAD: &str = "# Methods\n
<!-- Made by `cargo run -- methods --markdown > docs/methods.md`; a test says when that has to be done again. -->\n
Each method is chosen by `--method NAME`, and has the options below. *field* is where the manifest of a map has the setting, inside
`method`; values outside the range are refused there as well. What the [words](#words) mean is said once, at the end.\n
| method | |
| --- | --- |
";

/// Lists methods and their parameters as a page of the documentation.
pub(crate) fn markdown() -> String {
    let mut out = MARKDOWN_HEAD.to_owned();
    let mark = |method: &Denoiser| if *method == Denoiser::default() { " (default)" } else { "" };
    for method in Denoiser::every() {
        // The anchor of the heading below.
        let (name, mark) = (method.name(), mark(&method));
        let anchor = if mark.is_empty() { name.to_owned() } else { format!("{name}-default") };
        let _ = writeln!(out, "| [{name}](#{anchor}){mark} | {} |", method.summary());
    }
    for method in Denoiser::every() {
        let _ = write!(out, "\n## {}{}\n\n{}.\n", method.name(), mark(&method), method.summary());
        if let Some(paper) = method.info().reference {
            let _ = writeln!(out, "\n{}: {}.", paper.cite, paper.title);
        }
        if method.paper().is_some_and(|paper| paper != method) {
            let _ = writeln!(out, "\n`--preset paper` has the settings of its authors.");
        }
        out.push_str("\n| option | field | default | range | |\n| --- | --- | --- | --- | --- |\n");
        for p in method.options() {
            let words = || p.choices().iter().map(|word| format!("`{}`", word.name)).collect::<Vec<_>>().join(", ");
            let range = range(p).unwrap_or_else(words);
            let default = default_text(&method, p);
            let _ = writeln!(out, "| `--{}` | `{}` | {default} | {range} | {} |", p.name, p.path(), meaning(p));
        }
    }
    out.push_str("\n## Words\n");
    for option in options().iter().filter(|option| !option.parameter().choices().is_empty()) {
        let _ = writeln!(out, "\n`--{}`: {}\n", option.name(), option.parameter().help);
        for word in option.parameter().choices() {
            let _ = writeln!(out, "- `{}`: {}", word.name, word.help);
        }
    }
    out
}
