//! Volumes in NRRD files (`.nrrd`, and `.nhdr` with its values in another file): <https://teem.sourceforge.net/nrrd/format.html>.

use super::VolumeFile;
use super::numbers::{self, ByteOrder};
use glam::{DAffine3, DMat3, DVec3};
use planish_files::compression;
use planish_files::failure::Failure;
use planish_files::input::{self, NamedFile, Trust};
use planish_files::text::one_line;
use planish_render::settings::volume::{MAX_VALUES, SampleType};
use std::collections::HashMap;
use std::path::Path;

/// Bytes that every file begins with; a digit follows.
const MAGIC: &[u8] = b"NRRD000";

/// Bytes of a file of values that are read at most: the largest volume in double precision, and room before it.
const LARGEST: u64 = 9 * MAX_VALUES;

/// Fields of a header by name. Keys of one's own (`key:=value`) and comments are left out.
struct Header(HashMap<String, String>);

/// Description of the values in a header.
#[derive(Debug, PartialEq)]
struct Layout {
    size: [u32; 3],
    sample: SampleType,
    order: ByteOrder,
    is_compressed: bool,
    /// Lines, and then bytes, to leave out; `None` leaves out all but the values at the end.
    line_skip: usize,
    byte_skip: Option<usize>,
    spacing: DVec3,
    model_from_index: Option<DAffine3>,
    /// File of the values; `None` where they follow the header.
    data_file: Option<String>,
}

/// Reads a file. A file of values that it names is read by the rule.
pub(super) fn read(path: &Path, trust: Trust) -> Result<VolumeFile, Failure> {
    let bytes = input::read(path)?;
    let failed = |reason: String| Failure::at(path, one_line(&reason));
    let (header, body) = split(&bytes).map_err(failed)?;
    let layout = Layout::new(&header).map_err(failed)?;
    let expected = numbers::byte_count(layout.size, layout.sample).map_err(|e| failed(e.to_string()))?;
    let (detached, blamed);
    let (body, blamed) = match &layout.data_file {
        Some(name) => {
            let folder = input::folder_of(path);
            blamed = folder.join(name);
            detached = NamedFile { path: &blamed, folder, trust, largest: LARGEST }.read()?;
            (&detached[..], &*blamed)
        }
        None => (body, path),
    };
    let failed = |reason: String| Failure::at(blamed, one_line(&reason));
    let body = skip_lines(body, layout.line_skip).map_err(failed)?;
    let unpacked;
    let body = if layout.is_compressed {
        let skipped = layout.byte_skip.unwrap_or(0) as u64;
        if skipped > LARGEST {
            return Err(failed(format!("skips {skipped} bytes; at most {LARGEST} are unpacked")));
        }
        unpacked = compression::decompressed_to(body, expected.saturating_add(skipped));
        unpacked.as_deref().map_err(|e| match e {
            compression::CompressionError::TooLarge => {
                failed(format!("holds more than the {expected} bytes of its values"))
            }
            compression::CompressionError::Damaged => failed("its compressed values are damaged or cut".to_owned()),
        })?
    } else {
        body
    };
    let skip = layout.byte_skip.unwrap_or(body.len().saturating_sub(expected as usize));
    let body = body.get(skip..).ok_or_else(|| failed(format!("ends before byte {skip}, where its values begin")))?;
    let values = numbers::read(body, layout.size, layout.sample, layout.order).map_err(|e| failed(e.to_string()))?;
    let Layout { size, spacing, model_from_index, .. } = layout;
    Ok(VolumeFile { size, values, spacing, model_from_index })
}

/// Separates the header from what follows its empty line.
fn split(bytes: &[u8]) -> Result<(Header, &[u8]), String> {
    if !bytes.starts_with(MAGIC) || !bytes.get(MAGIC.len()).is_some_and(u8::is_ascii_digit) {
        return Err("is no NRRD file; a file of bare numbers needs --volume-size and --volume-type".to_owned());
    }
    let mut fields = HashMap::new();
    let mut rest = bytes;
    for number in 1.. {
        // A header without values may end without an empty line.
        let end = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        let line = rest[..end].strip_suffix(b"\r").unwrap_or(&rest[..end]);
        rest = rest.get(end + 1..).unwrap_or_default();
        if line.is_empty() {
            break;
        }
        if number == 1 || line[0] == b'#' {
            continue;
        }
        let line = std::str::from_utf8(line).map_err(|_| format!("line {number}: is not text"))?;
        // A key of one's own may have any value.
        if line.split_once(":=").is_some_and(|(key, _)| !key.contains(": ")) {
            continue;
        }
        let (name, value) = line.split_once(':').ok_or_else(|| format!("line {number}: is no field"))?;
        fields.insert(name.trim().to_lowercase().replace(' ', ""), value.trim().to_owned());
    }
    Ok((Header(fields), rest))
}

fn skip_lines(mut bytes: &[u8], lines: usize) -> Result<&[u8], String> {
    for _ in 0..lines {
        let end = bytes.iter().position(|b| *b == b'\n');
        bytes = &bytes[end.ok_or("has fewer lines than its header skips")? + 1..];
    }
    Ok(bytes)
}

impl Header {
    fn get(&self, name: &str) -> Option<&str> {
        self.0.get(name).map(String::as_str)
    }

    fn need(&self, name: &str) -> Result<&str, String> {
        self.get(name).ok_or_else(|| format!("its header has no `{name}`"))
    }

    /// Three numbers.
    fn three<T: std::str::FromStr>(&self, name: &str) -> Result<Option<[T; 3]>, String> {
        let Some(text) = self.get(name) else { return Ok(None) };
        let numbers: Option<Vec<T>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
        let numbers = numbers.and_then(|numbers| <[T; 3]>::try_from(numbers).ok());
        numbers.map(Some).ok_or_else(|| format!("`{name}: {text}` are not three numbers"))
    }

    fn whole(&self, name: &str) -> Result<i64, String> {
        let text = self.get(name).unwrap_or("0");
        text.parse().map_err(|_| format!("`{name}: {text}` is not a whole number"))
    }

    /// Three vectors, `(1,0,0) (0,1,0) (0,0,1)`, or one.
    fn vectors(&self, name: &str) -> Result<Option<Vec<DVec3>>, String> {
        let Some(text) = self.get(name) else { return Ok(None) };
        let vector = |part: &str| {
            let numbers: Vec<f64> = part.split(',').map(|n| n.trim().parse().ok()).collect::<Option<_>>()?;
            Some(DVec3::from(<[f64; 3]>::try_from(numbers).ok()?)).filter(|v| v.is_finite())
        };
        let parts = text.split(')').map(str::trim).filter(|part| !part.is_empty());
        let vectors: Option<Vec<DVec3>> = parts.map(|part| vector(part.strip_prefix('(')?)).collect();
        vectors.map(Some).ok_or_else(|| format!("`{name}: {text}` are not vectors of three numbers"))
    }
}

impl Layout {
    fn new(header: &Header) -> Result<Self, String> {
        let dimension = header.need("dimension")?;
        if dimension != "3" {
            return Err(format!("has {dimension} axes, and a volume has 3"));
        }
        let size = header.three("sizes")?.ok_or("its header has no `sizes`")?;
        let sample = sample_type(header.need("type")?)?;
        let encoding = header.need("encoding")?;
        let is_compressed = match encoding {
            "raw" => false,
            "gzip" | "gz" => true,
            other => return Err(format!("has its values as `{other}`; raw and gzip are read")),
        };
        let order = match header.get("endian") {
            Some("big") => ByteOrder::Big,
            Some("little") => ByteOrder::Little,
            None if sample.bytes() == 1 => ByteOrder::Little,
            other => return Err(format!("`endian: {}` is neither little nor big", other.unwrap_or_default())),
        };
        let line_skip = usize::try_from(header.whole("lineskip")?).map_err(|_| "skips a negative number of lines")?;
        let byte_skip = match header.whole("byteskip")? {
            -1 if !is_compressed => None,
            skip => Some(usize::try_from(skip).map_err(|_| "skips a negative number of bytes")?),
        };
        let data_file = header.get("datafile").map(str::to_owned);
        if data_file.as_deref().is_some_and(|name| name.starts_with("LIST") || name.contains('%')) {
            return Err("has its values in several files; one is read".to_owned());
        }
        let (spacing, model_from_index) = placement(header)?;
        Ok(Self { size, sample, order, is_compressed, line_skip, byte_skip, spacing, model_from_index, data_file })
    }
}

/// Sides of a voxel, and the position of the grid where the header has an origin.
fn placement(header: &Header) -> Result<(DVec3, Option<DAffine3>), String> {
    let Some(directions) = header.vectors("spacedirections")? else {
        let spacing = header.three::<f64>("spacings")?.map_or(DVec3::ONE, DVec3::from);
        // Some programs write that the spacing is not known.
        let spacing = DVec3::select(spacing.is_nan_mask(), DVec3::ONE, spacing);
        if !(spacing.is_finite() && spacing.min_element() > 0.0) {
            return Err(format!("its `spacings` {spacing} are not lengths"));
        }
        return Ok((spacing, None));
    };
    let [x, y, z] = <[DVec3; 3]>::try_from(directions).map_err(|_| "its `space directions` are not three vectors")?;
    let axes = DMat3::from_cols(x, y, z);
    if axes.determinant() == 0.0 || !axes.is_finite() {
        return Err("its `space directions` lie in a plane".to_owned());
    }
    let origin = match header.vectors("spaceorigin")?.as_deref() {
        None => None,
        Some([origin]) => Some(*origin),
        Some(_) => return Err("its `space origin` is not one vector".to_owned()),
    };
    let model_from_index = origin.map(|origin| DAffine3::from_mat3_translation(axes, origin));
    Ok((DVec3::new(x.length(), y.length(), z.length()), model_from_index))
}

fn sample_type(name: &str) -> Result<SampleType, String> {
    Ok(match name {
        "signed char" | "int8" | "int8_t" => SampleType::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => SampleType::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => SampleType::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => SampleType::U16,
        "int" | "signed int" | "int32" | "int32_t" => SampleType::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => SampleType::U32,
        "float" => SampleType::F32,
        "double" => SampleType::F64,
        other => {
            return Err(format!(
                "has values of type `{other}`; integers of 8, 16 and 32 bits, float and double are read"
            ));
        }
    })
}
