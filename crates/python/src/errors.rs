//! Failures as exceptions of the package.

use planish_files::failure::Failure;
use pyo3::PyErr;

pyo3::import_exception!(planish._errors, InputError);
pyo3::import_exception!(planish._errors, InternalError);
pyo3::import_exception!(planish._errors, Interrupted);

/// Makes the exception of a failure.
pub(crate) fn raised(failure: Failure) -> PyErr {
    match failure {
        Failure::Input(reason) => InputError::new_err(reason),
        Failure::Internal(reason) => InternalError::new_err(reason),
        Failure::Interrupted => Interrupted::new_err("interrupted; there is no result"),
    }
}
