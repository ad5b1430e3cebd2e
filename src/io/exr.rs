//! Linear pictures in full precision: `OpenEXR`.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use exr::block;
use exr::meta::attribute::Chromaticities;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, Layer,
    LayerAttributes, LineOrder, ReadChannels, ReadLayers, Text, Vec2, WritableImage, f16, read,
};

use crate::error::{Error, ErrorKind, Place, Result};
use crate::image::{Channel, Image};

/// How a channel's values are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32-bit floats: every value is kept to the bit.
    #[default]
    Float,
    /// 16-bit floats: 11 significant bits; what is beyond ±65504 is stored as ±65504.
    Half,
}

/// The primaries and the white point of ITU-R BT.709.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.3, 0.6),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.329),
};

/// Encodes all channels as one part of scan lines, each line compressed without loss on its own (ZIPS), with
/// Rec. 709 primaries and the metadata as text attributes. Equal images give equal bytes.
///
/// # Errors
/// Where the image is empty, two channels have one name, or a name is empty, too long, has a NUL, or belongs
/// to an attribute of the format.
pub fn encode_exr(image: &Image, precision: Precision) -> Result<Vec<u8>> {
    image.validate()?;
    let channels = image.channels.iter().map(|channel| {
        let values = channel.values.iter();
        let samples = match precision {
            Precision::Float => FlatSamples::F32(channel.values.clone()),
            Precision::Half => FlatSamples::F16(values.map(|&x| to_half(x)).collect()),
        };
        Ok(AnyChannel::new(name(&channel.name)?, samples))
    });
    let metadata = image.metadata.iter().map(|(key, value)| {
        let value = Text::from_slice_unchecked(value.as_bytes());
        Ok((name(key)?, AttributeValue::Text(value)))
    });
    let attributes = LayerAttributes {
        software_name: Some(concat!("solidtrace ", env!("CARGO_PKG_VERSION")).into()),
        other: metadata.collect::<Result<_>>()?,
        ..LayerAttributes::default()
    };
    let mut picture = exr::prelude::Image::from_layer(Layer::new(
        (image.width, image.height),
        attributes,
        Encoding {
            compression: Compression::ZIP1,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        },
        AnyChannels::sort(channels.collect::<Result<_>>()?),
    ));
    picture.attributes.chromaticities = Some(REC_709);

    let mut bytes = Vec::new();
    (picture.write().non_parallel())
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(|cause| unfit(&cause.to_string()))?;
    sort_attributes(&mut bytes);
    Ok(bytes)
}

fn unfit(cause: &str) -> Error {
    Error::new(
        ErrorKind::Write,
        format!("the image does not fit into an EXR: {cause}"),
    )
}

/// A name in the header, where NUL is the end and an empty name ends the list.
fn name(name: &str) -> Result<Text> {
    if name.is_empty() || name.contains('\0') {
        return Err(unfit(&format!("{name:?} cannot name anything")));
    }
    Ok(Text::from_slice_unchecked(name.as_bytes()))
}

/// The text of a header, UTF-8 as other writers have it too.
fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}

fn to_half(x: f32) -> f16 {
    f16::from_f32(if x.is_nan() {
        x
    } else {
        x.clamp(f16::MIN.to_f32(), f16::MAX.to_f32())
    })
}

/// Puts the header's attributes, which are in a hash map's order, into the order of their names. The format
/// allows any order, and the header's length stays. It holds after 8 bytes: name, NUL, type, NUL, size, value;
/// and ends with an empty name.
fn sort_attributes(file: &mut [u8]) {
    let mut attributes = Vec::new();
    let mut end = 8;
    while file[end] != 0 {
        let start = end;
        for _ in 0..2 {
            end += file[end..].iter().take_while(|&&byte| byte != 0).count() + 1;
        }
        let size: [u8; 4] = std::array::from_fn(|i| file[end + i]);
        end += 4 + u32::from_le_bytes(size) as usize;
        attributes.push(file[start..end].to_vec());
    }
    attributes.sort_unstable();
    file[8..end].copy_from_slice(&attributes.concat());
}

/// Reads all channels of an EXR file with one flat part, at full resolution, as f32. Channels and text attributes
/// come sorted by name, as the file has the channels.
///
/// # Errors
/// Where the file cannot be read, is not an EXR, is damaged, or is of a kind that is not supported (deep, several
/// parts, subsampled, B44 or DWA); and where its header asks for more memory than a file of its length can fill.
pub fn read_exr(path: &Path) -> Result<Image> {
    let bytes = fs::read(path).map_err(|cause| Error::read(path, &cause))?;
    decode_exr(&bytes).map_err(|error| error.at(Place::file(path)))
}

/// [`read_exr`] for a file in memory.
///
/// # Errors
/// As [`read_exr`], without the file's name.
pub fn decode_exr(bytes: &[u8]) -> Result<Image> {
    let damaged = |cause: exr::error::Error| {
        Error::input(format!("cannot read the EXR: {cause}"))
            .help("check that the file is a whole, flat OpenEXR image")
    };
    let reader = block::read(Cursor::new(bytes), true).map_err(damaged)?;
    check_header(reader.meta_data(), bytes.len())?;
    let picture = (read().no_deep_data().largest_resolution_level())
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .pedantic()
        .non_parallel()
        .from_chunks(reader)
        .map_err(damaged)?;

    let layer = picture.layer_data;
    let channels = layer.channel_data.list.into_iter().map(|channel| Channel {
        name: string(&channel.name),
        values: match channel.sample_data {
            FlatSamples::F32(values) => values,
            other => other.values_as_f32().collect(),
        },
    });
    let attributes = layer.attributes.other.into_iter();
    let mut metadata: Vec<_> = attributes
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => Some((string(&name), string(&text))),
            _ => None,
        })
        .collect();
    metadata.sort_unstable();
    Ok(Image {
        width: layer.size.width(),
        height: layer.size.height(),
        channels: channels.collect(),
        metadata,
    })
}

/// Most bytes that are decoded whatever the file's length: a black picture of any usual size compresses to nothing.
const ALWAYS_ALLOWED: usize = 256 << 20;
/// Deflate cannot expand more than 1032 times.
const EXPANSION: usize = 1032;
/// Every chunk has an offset in the table, a coordinate and a size.
const CHUNK_OVERHEAD: usize = 16;

/// Refuses a header before its claims cost memory: a few damaged bytes can ask for more than any machine has.
fn check_header(meta: &MetaData, file_length: usize) -> Result<()> {
    let [header] = meta.headers.as_slice() else {
        return Err(
            Error::input(format!("the EXR has {} parts", meta.headers.len()))
                .help("only files with one part are supported; split the file"),
        );
    };
    if !matches!(
        header.compression,
        Compression::Uncompressed
            | Compression::RLE
            | Compression::ZIP1
            | Compression::ZIP16
            | Compression::PIZ
            | Compression::PXR24
    ) {
        // The decoders of B44 and DWA panic or take all memory when the data is damaged.
        return Err(Error::input(format!(
            "the EXR has {}, which is not read",
            header.compression
        ))
        .help("save it with ZIP or PIZ compression"));
    }
    let limit = ALWAYS_ALLOWED.max(file_length.saturating_mul(EXPANSION));
    let fits = |pixels: Option<usize>| {
        pixels
            .and_then(|pixels| pixels.checked_mul(header.channels.bytes_per_pixel))
            .is_some_and(|bytes| bytes <= limit)
    };
    let size = header.layer_size;
    if fits(size.0.checked_mul(size.1))
        && fits(block_pixels(header))
        && header.chunk_count <= file_length / CHUNK_OVERHEAD
    {
        return Ok(());
    }
    Err(Error::input(format!(
        "the EXR's header claims {} x {} pixels in {} channels and {} chunks, which a file of {file_length} bytes cannot hold",
        size.0,
        size.1,
        header.channels.list.len(),
        header.chunk_count
    ))
    .help("the file is damaged or cut off: make it again"))
}

/// Pixels in the largest chunk.
fn block_pixels(header: &Header) -> Option<usize> {
    match header.blocks {
        BlockDescription::Tiles(tiles) => tiles.tile_size.0.checked_mul(tiles.tile_size.1),
        BlockDescription::ScanLines => {
            (header.compression.scan_lines_per_block()).checked_mul(header.layer_size.0)
        }
    }
}
