//! Options of volumes.

use clap::Args;
use planish_render::settings::environment::Part;
use planish_render::settings::volume::{
    Placement, RawVolume, SampleType, Transfer, TransferPreset, VolumeDisplay, VolumeSource, VolumeView,
};
use planish_render::settings::{Range, Shading};
use std::path::{Path, PathBuf};

/// Options of a volume and of how it is drawn.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct VolumeArgs {
    /// Volume: `distance`, the signed distance to the mesh; an NRRD file; or a file of bare numbers with --volume-size.
    #[arg(long, value_name = "WHAT")]
    volume: Option<PathBuf>,

    /// Number of values along the longest side of `--volume distance` [default: 96].
    #[arg(long, value_name = "N", requires = "volume", conflicts_with = "volume_size")]
    volume_grid: Option<u32>,

    /// Number of values along each axis of a file of bare numbers, the first axis fastest.
    #[arg(long, value_name = "X,Y,Z", requires = "volume_type", value_parser = three::<u32>)]
    volume_size: Option<[u32; 3]>,

    /// Type of the bare numbers, little-endian.
    #[arg(long, value_name = "TYPE", requires = "volume_size")]
    volume_type: Option<SampleType>,

    /// Lengths of the sides of a voxel of bare numbers, in any unit [default: 1,1,1].
    #[arg(long, value_name = "X,Y,Z", requires = "volume_size", value_parser = three::<f32>)]
    volume_spacing: Option<[f32; 3]>,

    /// Position of the volume: where its file says, or around the mesh.
    #[arg(long, value_name = "WHERE")]
    volume_place: Option<Placement>,

    /// What is drawn of the volume [default: rays; hidden with --shading solid].
    #[arg(long, value_name = "WHAT")]
    volume_show: Option<VolumeDisplay>,

    /// Colours and opacities of the values.
    #[arg(long, value_name = "PRESET")]
    transfer: Option<TransferPreset>,

    /// Values at the ends of the transfer function [default: all that there are].
    #[arg(long, value_name = "LOW,HIGH", allow_hyphen_values = true, value_parser = range)]
    volume_range: Option<Range>,

    /// Opaque plane across an axis of the volume, at a share of its box, such as `x=0.5`; up to three.
    #[arg(long, value_name = "AXIS=SHARE", value_parser = slice)]
    slice: Vec<(usize, f32)>,

    /// Part of the volume that is drawn along an axis, such as `z=0.2..1`; up to three.
    #[arg(long, value_name = "AXIS=FROM..TO", value_parser = clip)]
    clip: Vec<(usize, [f32; 2])>,

    /// Leave the mesh out and draw the volume alone.
    #[arg(long)]
    hide_mesh: bool,
}

impl VolumeArgs {
    /// The file that is read, so that it is not written over.
    pub(super) fn file(&self) -> Option<&Path> {
        self.volume.as_deref().filter(|path| *path != Path::new("distance"))
    }

    /// The first option that is given.
    fn is_given(&self) -> bool {
        let Self { volume, volume_place, volume_show, transfer, volume_range, slice, clip, hide_mesh, .. } = self;
        volume.is_some()
            || volume_place.is_some()
            || volume_show.is_some()
            || transfer.is_some()
            || volume_range.is_some()
            || !slice.is_empty()
            || !clip.is_empty()
            || *hide_mesh
    }

    fn source(&self) -> Option<VolumeSource> {
        let Some(file) = self.file() else {
            return self.volume.as_ref().map(|_| match self.volume_grid {
                Some(size) => VolumeSource::Distance { size },
                None => VolumeSource::default(),
            });
        };
        Some(match (self.volume_size, self.volume_type) {
            (Some(size), Some(sample)) => VolumeSource::Raw(RawVolume {
                file: file.to_owned(),
                size,
                sample,
                spacing: self.volume_spacing.unwrap_or([1.0; 3]),
            }),
            _ => VolumeSource::File(file.to_owned()),
        })
    }

    /// Writes what the command line says over the settings of a picture with this shading.
    pub(super) fn override_view(&self, view: &mut Option<VolumeView>, shading: Shading) {
        if !self.is_given() {
            return;
        }
        let is_new = view.is_none();
        let view = view.get_or_insert_default();
        if let Some(source) = self.source() {
            view.source = source;
        }
        if is_new && shading == Shading::Solid {
            view.display = VolumeDisplay::Hidden;
        }
        view.placement = self.volume_place.unwrap_or(view.placement);
        view.display = self.volume_show.unwrap_or(view.display);
        view.range = self.volume_range.or(view.range);
        if let Some(preset) = self.transfer {
            view.transfer = Transfer::Preset(preset);
        }
        for &(axis, share) in &self.slice {
            view.slices[axis] = Some(share);
        }
        for &(axis, [low, high]) in &self.clip {
            (view.low[axis], view.high[axis]) = (low, high);
        }
        if self.hide_mesh {
            view.mesh = Part::Hidden;
        }
    }
}

fn three<T: std::str::FromStr>(text: &str) -> Result<[T; 3], String> {
    let numbers: Option<Vec<T>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
    let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or_else(|| "expected three numbers, for example 64,64,32".to_owned())
}

fn range(text: &str) -> Result<Range, String> {
    let ends = text.split_once(',').and_then(|(low, high)| Some((low.trim().parse().ok()?, high.trim().parse().ok()?)));
    ends.map(|(low, high)| Range { low, high }).ok_or_else(|| "expected two numbers, for example -1,1".to_owned())
}

/// Index of an axis, and what is said about it.
fn axis(text: &str) -> Option<(usize, &str)> {
    let (name, value) = text.split_once('=')?;
    Some((["x", "y", "z"].iter().position(|axis| *axis == name)?, value))
}

fn slice(text: &str) -> Result<(usize, f32), String> {
    let found = axis(text).and_then(|(axis, share)| Some((axis, share.parse().ok()?)));
    found.ok_or_else(|| "expected an axis and a share of the box, for example x=0.5".to_owned())
}

fn clip(text: &str) -> Result<(usize, [f32; 2]), String> {
    let found = axis(text).and_then(|(axis, part)| {
        let (from, to) = part.split_once("..")?;
        Some((axis, [from.parse().ok()?, to.parse().ok()?]))
    });
    found.ok_or_else(|| "expected an axis and a part of the box, for example z=0.2..1".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::Args;
    use clap::Parser as _;
    use planish_render::settings::Settings;

    fn view(options: &str) -> Option<VolumeView> {
        let line = format!("planish-viewer a.obj {options}");
        Args::try_parse_from(line.split_whitespace()).unwrap().override_settings(Settings::default()).volume
    }

    #[test]
    fn options_say_where_a_volume_comes_from_and_how_it_is_drawn() {
        assert_eq!(view("--yaw 3"), None);
        assert_eq!(view("--volume distance"), Some(VolumeView::default()));
        let grid = VolumeSource::Distance { size: 20 };
        let expected = VolumeView { source: grid, display: VolumeDisplay::Hidden, ..VolumeView::default() };
        assert_eq!(view("--volume distance --volume-grid 20 --shading solid"), Some(expected));
        let raw =
            RawVolume { file: "a.raw".into(), size: [4, 3, 2], sample: SampleType::I16, spacing: [1.0, 1.0, 2.5] };
        let expected = VolumeView {
            source: VolumeSource::Raw(raw),
            transfer: Transfer::Preset(TransferPreset::Bone),
            range: Some(Range { low: -500.0, high: 2e3 }),
            slices: [None, Some(0.25), None],
            low: [0.0, 0.0, 0.2],
            mesh: Part::Hidden,
            ..VolumeView::default()
        };
        let options = "--volume a.raw --volume-size 4,3,2 --volume-type i16 --volume-spacing 1,1,2.5 --transfer bone \
            --volume-range -500,2000 --slice y=0.25 --clip z=0.2..1 --hide-mesh";
        assert_eq!(view(options), Some(expected));
        let file = VolumeView { source: VolumeSource::File("a.nrrd".into()), ..VolumeView::default() };
        assert_eq!(view("--volume a.nrrd"), Some(file));
    }

    #[test]
    fn nonsense_is_refused_with_an_example() {
        for (options, word) in [
            ("--volume a.raw --volume-size 4,3 --volume-type u8", "64,64,32"),
            ("--volume a.raw --volume-size 4,3,2", "--volume-type"),
            ("--slice w=0.5", "x=0.5"),
            ("--clip z=0.2", "z=0.2..1"),
            ("--volume-range 3", "-1,1"),
        ] {
            let line = format!("planish-viewer a.obj {options}");
            let said = Args::try_parse_from(line.split_whitespace()).unwrap_err().to_string();
            assert!(said.contains(word), "{options}: {said}");
        }
    }
}
