//! Typed arrays out of buffers, every access checked (glTF 2.0 specification, section 3.6.2).

use std::borrow::Cow;

use crate::error::Result;

use super::json::Json;

/// Most elements of an accessor that has no bytes of its own (all zero but for its sparse part).
const MAX_UNBACKED: usize = 1 << 24;

/// A parsed document and the bytes of its buffers.
pub(super) struct Document<'a> {
    pub(super) root: Json<'a>,
    pub(super) buffers: Vec<Cow<'a, [u8]>>,
}

#[derive(Clone, Copy, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// `count` elements of `components` numbers, `stride` bytes apart.
struct Elements<'d> {
    bytes: &'d [u8],
    stride: usize,
    count: usize,
    component: Component,
    components: usize,
}

impl Document<'_> {
    /// The accessor `reference` names, as vectors of `N` floats; integers are normalised where the file says so.
    ///
    /// # Errors
    /// Where it is of another type, does not fit its buffer, or holds a number that is not finite.
    pub(super) fn vectors<const N: usize>(&self, reference: &Json<'_>) -> Result<Vec<[f32; N]>> {
        let (_, accessor) = self.root.element("accessors", reference)?;
        check_type(&accessor, N)?;
        let normalized = accessor
            .get("normalized")?
            .map_or(Ok(false), |flag| flag.flag())?;
        let vectors = self.read(&accessor, [0.0; N], |elements, i| {
            std::array::from_fn(|k| elements.float(i, k, normalized))
        })?;
        if let Some(i) = vectors
            .iter()
            .position(|v| !v.iter().all(|x| x.is_finite()))
        {
            return Err(accessor.error(format!("element {i} is not finite: {:?}", vectors[i])));
        }
        Ok(vectors)
    }

    /// The accessor `reference` names, as indices.
    ///
    /// # Errors
    /// Where its elements are not single unsigned integers or do not fit its buffer.
    pub(super) fn indices(&self, reference: &Json<'_>) -> Result<Vec<u32>> {
        let (_, accessor) = self.root.element("accessors", reference)?;
        check_type(&accessor, 1)?;
        check_unsigned(&accessor)?;
        self.read(&accessor, 0, Elements::index)
    }

    fn read<'d, T: Copy>(
        &'d self,
        accessor: &Json<'_>,
        zero: T,
        element: impl Fn(&Elements<'d>, usize) -> T,
    ) -> Result<Vec<T>> {
        let count = accessor.need("count")?.count()?;
        let sparse = accessor.get("sparse")?;
        let mut values: Vec<T> = if accessor.get("bufferView")?.is_some() {
            let elements = self.elements(accessor, accessor, count, None)?;
            (0..count).map(|i| element(&elements, i)).collect()
        } else if count <= MAX_UNBACKED {
            vec![zero; count]
        } else {
            return Err(accessor
                .need("count")?
                .error(format!("{count} elements without a `bufferView`")));
        };
        if let Some(sparse) = sparse {
            let count = sparse.need("count")?.count()?;
            let at = sparse.need("indices")?;
            check_unsigned(&at)?;
            let indices = self.elements(&at, &at, count, Some(1))?;
            let replacements = self.elements(&sparse.need("values")?, accessor, count, None)?;
            for i in 0..count {
                let index = indices.index(i);
                let length = values.len();
                let value = values.get_mut(index as usize).ok_or_else(|| {
                    at.error(format!(
                        "sparse index {index}, but the accessor has {length} elements"
                    ))
                })?;
                *value = element(&replacements, i);
            }
        }
        Ok(values)
    }

    /// The bytes that `source` (with `bufferView` and `byteOffset`) gives for `count` elements of the type of
    /// `typed`, or of `components` numbers.
    fn elements<'d>(
        &'d self,
        source: &Json<'_>,
        typed: &Json<'_>,
        count: usize,
        components: Option<usize>,
    ) -> Result<Elements<'d>> {
        let component = component(typed)?;
        let components = components.map_or_else(|| type_size(typed), Ok)?;
        let size = component.size() * components;
        let (bytes, stride) = self.view(&source.need("bufferView")?)?;
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(source.error(format!("byteStride {stride} for elements of {size} bytes")));
        }
        let offset = source.count_or("byteOffset", 0)?;
        let needed = match count {
            0 => Some(0),
            _ => (count - 1)
                .checked_mul(stride)
                .and_then(|n| n.checked_add(size))
                .and_then(|n| n.checked_add(offset)),
        };
        if needed.is_none_or(|needed| needed > bytes.len()) {
            return Err(source
                .error(format!(
                    "{count} elements of {size} bytes, {stride} apart from byte {offset}, do not fit the bufferView's {} bytes",
                    bytes.len()
                ))
                .help("the counts are wrong or the file is damaged"));
        }
        Ok(Elements {
            bytes: &bytes[offset.min(bytes.len())..],
            stride,
            count,
            component,
            components,
        })
    }

    /// The bytes of a buffer view, and its stride if it has one.
    pub(super) fn view(&self, reference: &Json<'_>) -> Result<(&[u8], Option<usize>)> {
        let (_, view) = self.root.element("bufferViews", reference)?;
        let (buffer, _) = self.root.element("buffers", &view.need("buffer")?)?;
        let bytes = &self.buffers[buffer];
        let offset = view.count_or("byteOffset", 0)?;
        let length = view.need("byteLength")?.count()?;
        let stride = view.get("byteStride")?.map(|s| s.count()).transpose()?;
        let end = offset.checked_add(length);
        (end.and_then(|end| bytes.get(offset..end))
            .map(|bytes| (bytes, stride)))
        .ok_or_else(|| {
            view.error(format!(
                "{length} bytes from byte {offset} do not fit the buffer's {}",
                bytes.len()
            ))
        })
    }
}

impl Elements<'_> {
    /// The bytes of number `k` of element `i`.
    fn bytes<const B: usize>(&self, i: usize, k: usize) -> [u8; B] {
        debug_assert!(i < self.count && k < self.components);
        let at = i * self.stride + k * B;
        std::array::from_fn(|b| self.bytes[at + b])
    }

    fn index(&self, i: usize) -> u32 {
        match self.component {
            Component::U8 => u32::from(self.bytes::<1>(i, 0)[0]),
            Component::U16 => u32::from(u16::from_le_bytes(self.bytes(i, 0))),
            _ => u32::from_le_bytes(self.bytes(i, 0)),
        }
    }

    /// Normalised as section 3.11 of the specification says.
    fn float(&self, i: usize, k: usize, normalized: bool) -> f32 {
        let (value, greatest) = match self.component {
            Component::I8 => (f32::from(i8::from_le_bytes(self.bytes(i, k))), 127.0),
            Component::U8 => (f32::from(u8::from_le_bytes(self.bytes(i, k))), 255.0),
            Component::I16 => (f32::from(i16::from_le_bytes(self.bytes(i, k))), 32_767.0),
            Component::U16 => (f32::from(u16::from_le_bytes(self.bytes(i, k))), 65_535.0),
            Component::U32 => (u32::from_le_bytes(self.bytes(i, k)) as f32, 4_294_967_295.0),
            Component::F32 => return f32::from_le_bytes(self.bytes(i, k)),
        };
        if normalized {
            (value / greatest).max(-1.0)
        } else {
            value
        }
    }
}

impl Component {
    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

fn component(typed: &Json<'_>) -> Result<Component> {
    let code = typed.need("componentType")?;
    match code.count()? {
        5120 => Ok(Component::I8),
        5121 => Ok(Component::U8),
        5122 => Ok(Component::I16),
        5123 => Ok(Component::U16),
        5125 => Ok(Component::U32),
        5126 => Ok(Component::F32),
        other => Err(code.error(format!("{other} is not a component type"))),
    }
}

/// How many numbers an element has; matrices are not read here.
fn type_size(accessor: &Json<'_>) -> Result<usize> {
    let name = accessor.need("type")?;
    match name.text()? {
        "SCALAR" => Ok(1),
        "VEC2" => Ok(2),
        "VEC3" => Ok(3),
        "VEC4" => Ok(4),
        other => Err(name.error(format!(
            "the type `{other}` is not one for vertices or indices"
        ))),
    }
}

fn check_type(accessor: &Json<'_>, components: usize) -> Result<()> {
    let found = type_size(accessor)?;
    if found == components {
        return Ok(());
    }
    Err((accessor.need("type")?).error(format!(
        "{found} numbers an element, where {components} belong"
    )))
}

fn check_unsigned(typed: &Json<'_>) -> Result<()> {
    match component(typed)? {
        Component::U8 | Component::U16 | Component::U32 => Ok(()),
        _ => Err((typed.need("componentType")?).error("indices must be unsigned integers")),
    }
}
