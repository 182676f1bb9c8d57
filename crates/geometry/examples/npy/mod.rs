//! Files of NumPy, which the examples write for the training scripts.

/// Head of a file of NumPy, version 1.0 of its format, with this type and shape of its numbers.
pub(crate) fn head(dtype: &str, rows: usize, columns: usize) -> Vec<u8> {
    let mut header = format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes
}
