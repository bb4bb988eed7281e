//! Accessors: typed, strided, sparse, quantised arrays within views.
//!
//! Every count is checked against the bytes that hold it before anything is allocated for it.

use ::gltf::json::accessor::{ComponentType, Type, sparse::Sparse};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Accessor, Index, buffer};

use super::buffers::{Document, slice};

/// Accessors without a view hold zeros and no bytes against which their count could be checked.
const MAX_ZEROS: u64 = 1_000_000;

/// Rows of numbers.
pub(super) struct Table {
    pub values: Vec<f64>,
    pub columns: usize,
}

impl Table {
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns)
    }
}

/// The shape of an accessor's elements.
#[derive(Clone, Copy)]
struct Element {
    component: ComponentType,
    columns: usize,
    normalized: bool,
}

impl Element {
    fn size(self) -> usize {
        self.component.size() * self.columns
    }
}

/// Where elements lie: the first at the start of `bytes`, the next a stride further.
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl Document<'_> {
    /// The numbers of an accessor; integers are normalised where the accessor says so.
    pub fn table(&self, index: Index<Accessor>) -> Result<Table, String> {
        let accessor = self.accessor(index)?;
        self.read(accessor).map_err(|fault| format!("accessor {}: {fault}", index.value()))
    }

    /// The non-negative integers of a scalar accessor of type u8, u16 or u32.
    pub fn indices(&self, index: Index<Accessor>) -> Result<Vec<u32>, String> {
        let accessor = self.accessor(index)?;
        let unsigned = matches!(
            accessor.component_type,
            Checked::Valid(kind) if matches!(kind.0, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
        );
        if !unsigned || accessor.type_ != Checked::Valid(Type::Scalar) {
            return Err(format!("accessor {}: indices must be unsigned scalars", index.value()));
        }
        let table = self.table(index)?;
        // Exact: 32-bit integers fit into doubles.
        Ok(table.values.iter().map(|&value| value as u32).collect())
    }

    fn accessor(&self, index: Index<Accessor>) -> Result<&Accessor, String> {
        self.root.accessors.get(index.value()).ok_or(format!("accessor {} does not exist", index.value()))
    }

    fn read(&self, accessor: &Accessor) -> Result<Table, String> {
        let element = element(accessor)?;
        let count = accessor.count.0;
        let mut values = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                decode(&self.strided(view, offset, element.size(), count)?, element, count as usize)
            }
            None if count <= MAX_ZEROS => vec![0.0; count as usize * element.columns],
            None => return Err(format!("{count} elements are declared without data")),
        };
        if let Some(sparse) = &accessor.sparse {
            self.patch(&mut values, sparse, element)?;
        }
        Ok(Table { values, columns: element.columns })
    }

    /// Finds `count` elements in a view, every byte of them within it.
    fn strided(&self, view: Index<buffer::View>, offset: u64, size: usize, count: u64) -> Result<Strided<'_>, String> {
        let (bytes, stride) = self.view(view)?;
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(format!("elements of {size} bytes overlap at a stride of {stride}"));
        }
        let needed = match count {
            0 => Some(0),
            n => (n - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(size as u64)),
        };
        let bytes = needed.and_then(|needed| slice(bytes, offset, needed)).ok_or_else(|| {
            format!("{count} elements of {size} bytes from byte {offset} do not fit into bufferView {}", view.value())
        })?;
        Ok(Strided { bytes, stride })
    }

    /// Replaces the elements that a sparse accessor lists.
    fn patch(&self, values: &mut [f64], sparse: &Sparse, element: Element) -> Result<(), String> {
        let Checked::Valid(component) = sparse.indices.component_type else {
            return Err("the type of its sparse indices is unknown".into());
        };
        let count = sparse.count.0;
        let position = Element { component: component.0, columns: 1, normalized: false };
        let places = self.strided(sparse.indices.buffer_view, sparse.indices.byte_offset.0, position.size(), count)?;
        let places = decode(&places, position, count as usize);
        let rows = self.strided(sparse.values.buffer_view, sparse.values.byte_offset.0, element.size(), count)?;
        let rows = decode(&rows, element, count as usize);
        for (place, row) in places.iter().zip(rows.chunks_exact(element.columns)) {
            let start = *place as usize * element.columns;
            let target = values.get_mut(start..start + element.columns);
            target.ok_or(format!("its sparse index {place} is out of range"))?.copy_from_slice(row);
        }
        Ok(())
    }
}

fn element(accessor: &Accessor) -> Result<Element, String> {
    let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_) else {
        return Err("its type is unknown".into());
    };
    let columns = match kind {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 => 4,
        _ => return Err("it holds matrices where vectors belong".into()),
    };
    Ok(Element { component: component.0, columns, normalized: accessor.normalized })
}

fn decode(source: &Strided, element: Element, count: usize) -> Vec<f64> {
    let mut values = Vec::with_capacity(count * element.columns);
    let size = element.component.size();
    for row in 0..count {
        let row = &source.bytes[row * source.stride..];
        for column in 0..element.columns {
            let value = number(&row[column * size..], element.component);
            values.push(if element.normalized { normalized(value, element.component) } else { value });
        }
    }
    values
}

/// The number at the start of `bytes`, which hold it.
fn number(bytes: &[u8], component: ComponentType) -> f64 {
    let two = || [bytes[0], bytes[1]];
    let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
    match component {
        ComponentType::I8 => f64::from(bytes[0] as i8),
        ComponentType::U8 => f64::from(bytes[0]),
        ComponentType::I16 => f64::from(i16::from_le_bytes(two())),
        ComponentType::U16 => f64::from(u16::from_le_bytes(two())),
        ComponentType::U32 => f64::from(u32::from_le_bytes(four())),
        ComponentType::F32 => f64::from(f32::from_le_bytes(four())),
    }
}

/// glTF 2.0, section 3.6.2.2: signed types reach -1 one step early.
fn normalized(value: f64, component: ComponentType) -> f64 {
    match component {
        ComponentType::I8 => (value / 127.0).max(-1.0),
        ComponentType::U8 => value / 255.0,
        ComponentType::I16 => (value / 32767.0).max(-1.0),
        ComponentType::U16 => value / 65535.0,
        ComponentType::U32 | ComponentType::F32 => value,
    }
}
