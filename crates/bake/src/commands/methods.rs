//! The command `planish methods`.

use crate::args::MethodsArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::method_table;
use planish_files::method_list;
use planish_geometry::denoise::Denoiser;

pub(crate) fn run(args: &MethodsArgs, console: &Console) -> Result<(), Failure> {
    if args.markdown {
        return console.print_bytes(method_table::markdown().as_bytes());
    }
    let methods = args.method.clone().map_or_else(|| Denoiser::every().to_vec(), |method| vec![method]);
    console.report(&method_list::json(&methods), || method_table::text(&methods))
}
